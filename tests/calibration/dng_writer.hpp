// Camera raw files made by the tests, with known samples.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace aluminate::calibration::test {

// A minimal DNG: one uncompressed 16-bit strip, little-endian.
class DngWriter {
 public:
  DngWriter(int width, int height, std::string pattern, std::vector<std::uint16_t> samples, int black,
            int white, std::array<double, 3> neutral)
      : samples_(std::move(samples)) {
    static constexpr std::string_view kNames = "RGB";
    std::vector<std::uint8_t> cfa;
    for (const char name : pattern) cfa.push_back(static_cast<std::uint8_t>(kNames.find(name)));
    longs(254, {0});
    longs(256, {static_cast<std::uint32_t>(width)});
    longs(257, {static_cast<std::uint32_t>(height)});
    shorts(258, {16});
    shorts(259, {1});
    shorts(262, {32803});
    text(271, "Test");
    text(272, "Mosaic");
    longs(273, {0});  // where the strip is: filled in below
    shorts(274, {1});
    shorts(277, {1});
    longs(278, {static_cast<std::uint32_t>(height)});
    longs(279, {static_cast<std::uint32_t>(samples_.size() * 2)});
    shorts(33421, {2, 2});
    bytes(33422, cfa);
    bytes(50706, {1, 4, 0, 0});
    text(50708, "Test Mosaic");
    longs(50714, {static_cast<std::uint32_t>(black)});
    longs(50717, {static_cast<std::uint32_t>(white)});
    rationals(50721, 10,
              {3.2404542, -1.5371385, -0.4985314, -0.9692660, 1.8760108, 0.0415560, 0.0556434, -0.2040259,
               1.0572252});
    rationals(50728, 5, {neutral[0], neutral[1], neutral[2]});
    shorts(50778, {21});
  }

  std::vector<std::uint8_t> file() {
    const std::size_t directory = 8, end_of_directory = directory + 2 + 12 * entries_.size() + 4;
    std::size_t data_at = end_of_directory;
    for (const Entry& entry : entries_)
      data_at += entry.data.size() > 4 ? entry.data.size() + (entry.data.size() & 1) : 0;
    const std::size_t strip_at = data_at;
    std::vector<std::uint8_t> out{'I', 'I', 42, 0, 8, 0, 0, 0};
    put(out, entries_.size(), 2);
    std::vector<std::uint8_t> extra;
    for (Entry& entry : entries_) {
      if (entry.tag == 273) entry.data = number(strip_at, 4);
      put(out, entry.tag, 2);
      put(out, entry.type, 2);
      put(out, entry.count, 4);
      if (entry.data.size() > 4) {
        put(out, end_of_directory + extra.size(), 4);
        extra.insert(extra.end(), entry.data.begin(), entry.data.end());
        if (extra.size() & 1) extra.push_back(0);
      } else {
        std::vector<std::uint8_t> value = entry.data;
        value.resize(4);
        out.insert(out.end(), value.begin(), value.end());
      }
    }
    put(out, 0, 4);
    out.insert(out.end(), extra.begin(), extra.end());
    for (const std::uint16_t sample : samples_) put(out, sample, 2);
    return out;
  }

 private:
  struct Entry {
    std::size_t tag, type, count;
    std::vector<std::uint8_t> data;
  };
  static void put(std::vector<std::uint8_t>& out, std::size_t value, int size) {
    for (int i = 0; i < size; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  static std::vector<std::uint8_t> number(std::size_t value, int size) {
    std::vector<std::uint8_t> out;
    put(out, value, size);
    return out;
  }
  void bytes(std::size_t tag, const std::vector<std::uint8_t>& values) {
    entries_.push_back({tag, 1, values.size(), values});
  }
  void text(std::size_t tag, const std::string& value) {
    std::vector<std::uint8_t> data(value.begin(), value.end());
    data.push_back(0);
    entries_.push_back({tag, 2, data.size(), data});
  }
  void shorts(std::size_t tag, const std::vector<std::uint32_t>& values) {
    std::vector<std::uint8_t> data;
    for (const std::uint32_t value : values) put(data, value, 2);
    entries_.push_back({tag, 3, values.size(), data});
  }
  void longs(std::size_t tag, const std::vector<std::uint32_t>& values) {
    std::vector<std::uint8_t> data;
    for (const std::uint32_t value : values) put(data, value, 4);
    entries_.push_back({tag, 4, values.size(), data});
  }
  void rationals(std::size_t tag, std::size_t type, const std::vector<double>& values) {
    std::vector<std::uint8_t> data;
    for (const double value : values) {
      put(data, static_cast<std::size_t>(static_cast<std::int64_t>(std::lround(value * 1000000.0))), 4);
      put(data, 1000000, 4);
    }
    entries_.push_back({tag, type, values.size(), data});
  }
  std::vector<Entry> entries_;
  std::vector<std::uint16_t> samples_;
};

}  // namespace aluminate::calibration::test
