#include "platform/number/format.hpp"

#include <charconv>

namespace aluminate::number {
namespace {

// The whole text as a decimal number without sign or leading zero; -1 when it is not one.
int parse_count(std::string_view text) {
  if (text.empty() || text.size() > 2 || (text.size() > 1 && text.front() == '0')) return -1;
  int value = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? value : -1;
}

}  // namespace

Grid NumberFormat::grid(int f) const {
  switch (kind) {
    case Kind::Fixed: {
      const double step = power_of_two(-f);
      const double greatest = power_of_two(kIntegerBits - f) - step;
      return {f, 1.5 * power_of_two(52 - f), step, -greatest, greatest, power_of_two(52 - f), -60.0, 52.0 - f};
    }
    case Kind::Saturating: {
      const double step = power_of_two(-frac_bits);
      const double bound = power_of_two(int_bits - 1);
      return {frac_bits, 1.5 * power_of_two(52 - frac_bits), step, -bound, bound - step, power_of_two(52 - frac_bits), -60.0,
              52.0 - frac_bits};
    }
    case Kind::Reference: break;
  }
  return {0, 0.0, 1 / kReferenceGreatest, -kReferenceGreatest, kReferenceGreatest, 2 * kReferenceGreatest, -1000.0, 501.0};
}

std::optional<NumberFormat> parse_number_format(std::string_view name) {
  if (name == "ref64") return NumberFormat{"ref64", Kind::Reference, 0, 0};
  if (name == "auto") return NumberFormat{"auto", Kind::Fixed, NumberFormat{}.frac_bits, 0, true};
  if (name.starts_with("fx")) {
    const int f = parse_count(name.substr(2));
    if (f < 20 || f > 40) return std::nullopt;
    return NumberFormat{std::string(name), Kind::Fixed, f, 0};
  }
  if (name.starts_with("q")) {
    const auto dot = name.find('.');
    if (dot == std::string_view::npos) return std::nullopt;
    const int i = parse_count(name.substr(1, dot - 1)), f = parse_count(name.substr(dot + 1));
    if (i < 2 || f < 0 || i + f > 32) return std::nullopt;  // I = 1 could not hold the number 1
    return NumberFormat{std::string(name), Kind::Saturating, f, i};
  }
  return std::nullopt;
}

std::string_view number_format_names() {
  return "fx20..fx40 (default fx31), auto (fx31 on finer grids where proven), qI.F with I + F <= 32 (q16.16, q12.20, q8.24), ref64";
}

}  // namespace aluminate::number
