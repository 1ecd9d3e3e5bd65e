#include "shading/vm/program_file.hpp"

#include <bit>
#include <exception>
#include <type_traits>

namespace aluminate::vm {
namespace {

constexpr std::size_t kMostItems = std::size_t{1} << 20;  // of any list: far beyond what a compiler makes

// One description of the format serves both directions: write() and read() call fields() with themselves.
class Writer {
 public:
  static constexpr bool kReads = false;
  template <class T>
  void number(const T& value) {
    std::uint64_t bits = 0;
    if constexpr (std::is_same_v<T, double>) {
      bits = std::bit_cast<std::uint64_t>(value);
    } else {
      bits = static_cast<std::uint64_t>(static_cast<std::int64_t>(value));
    }
    for (std::size_t i = 0; i < bytes_of<T>(); ++i)
      bytes.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
  }
  void text(const std::string& value) {
    number(static_cast<std::uint32_t>(value.size()));
    bytes.insert(bytes.end(), value.begin(), value.end());
  }
  template <class T>
  void size(const std::vector<T>& list) {
    number(static_cast<std::uint32_t>(list.size()));
  }
  template <class T>
  static constexpr std::size_t bytes_of() {
    return std::is_same_v<T, bool> ? 1 : sizeof(T);
  }
  std::vector<std::uint8_t> bytes;
};

class Reader {
 public:
  static constexpr bool kReads = true;
  explicit Reader(std::span<const std::uint8_t> bytes) : left_(bytes) {}
  template <class T>
  void number(T& value) {
    std::uint64_t bits = 0;
    constexpr std::size_t kBytes = Writer::bytes_of<T>();
    if (left_.size() < kBytes) return fail();
    for (std::size_t i = 0; i < kBytes; ++i) bits |= std::uint64_t{left_[i]} << (8 * i);
    left_ = left_.subspan(kBytes);
    if constexpr (std::is_same_v<T, double>) {
      value = std::bit_cast<double>(bits);
    } else if constexpr (std::is_same_v<T, bool>) {
      if (bits > 1) return fail();
      value = bits == 1;
    } else {
      value = static_cast<T>(bits);
    }
  }
  void text(std::string& value) {
    std::uint32_t size = 0;
    number(size);
    if (size > left_.size()) return fail();
    value.assign(left_.begin(), left_.begin() + size);
    left_ = left_.subspan(size);
  }
  template <class T>
  void size(std::vector<T>& list) {
    std::uint32_t count = 0;
    number(count);
    if (count > kMostItems || count > left_.size()) return fail();  // every item takes a byte at least
    list.resize(count);
  }
  void fail() {
    good_ = false;
    left_ = {};
  }
  bool good() const { return good_; }
  bool at_end() const { return good_ && left_.empty(); }

 private:
  std::span<const std::uint8_t> left_;
  bool good_ = true;
};

// Enumerations are read as numbers and refused beyond their last value.
template <class Archive, class T>
void named(Archive& archive, T& value, T last) {
  auto number = static_cast<std::uint8_t>(value);
  archive.number(number);
  if constexpr (Archive::kReads) {
    if (number > static_cast<std::uint8_t>(last)) return archive.fail();
    value = static_cast<T>(number);
  }
}

template <class Archive, class P, class Function>
void each(Archive& archive, P& list, Function function) {
  archive.size(list);
  for (auto& item : list) function(item);
}

template <class Archive, class I>
void instruction(Archive& a, I& i) {
  named(a, i.op, static_cast<Opcode>(kOpcodes.size() - 1));
  a.number(i.saturate);
  named(a, i.dst.file, RegisterFile::LoopCounter);
  a.number(i.dst.index);
  a.number(i.dst.mask);
  for (auto& s : i.src) {
    named(a, s.file, RegisterFile::LoopCounter);
    a.number(s.index);
    for (auto& c : s.swizzle) a.number(c);
    a.number(s.negate);
    a.number(s.absolute);
    named(a, s.relative.base, RelativeBase::Temp);
    a.number(s.relative.index);
    a.number(s.relative.component);
    a.number(s.relative.scale);
    a.number(s.relative.limit);
  }
  a.number(i.sampler);
  a.number(i.trip_count);
  a.number(i.line.file);
  a.number(i.line.column);
  a.number(i.line.line);
}

template <class Archive, class P>
void fields(Archive& a, P& p) {
  a.text(p.name);
  named(a, p.stage, Stage::Pixel);
  each(a, p.files, [&](auto& file) { a.text(file); });
  each(a, p.code, [&](auto& i) { instruction(a, i); });
  each(a, p.literals, [&](auto& literal) {
    for (auto& x : literal) a.number(x);
  });
  const auto symbol = [&](auto& s) {
    a.text(s.semantic);
    a.number(s.mask);
  };
  each(a, p.inputs, symbol);
  each(a, p.outputs, symbol);
  each(a, p.uniforms, [&](auto& u) {
    a.text(u.name);
    for (auto* number : {&u.reg, &u.registers, &u.components, &u.component}) a.number(*number);
  });
  each(a, p.samplers, [&](auto& s) {
    a.text(s.name);
    named(a, s.dimension, SamplerDimension::Tex3D);
    a.number(s.shadow_compare);
  });
  a.number(p.temp_count);
  a.number(p.uniform_count);
}

// What validate() takes for granted because a compiler made it.
bool plausible(const Program& p) {
  constexpr int kMostRegisters = 1 << 16;
  const auto count = [](int n) { return n >= 0 && n <= kMostRegisters; };
  for (const UniformSymbol& u : p.uniforms)
    if (!count(u.reg) || !count(u.registers) || u.reg + u.registers > p.uniform_count || u.components < 1 ||
        u.components > 4 || u.component < 0 || u.component + u.components > 4)
      return false;
  for (const Instruction& i : p.code)
    if (i.line.line != 0 && i.line.file >= p.files.size()) return false;
  return count(p.temp_count) && count(p.uniform_count);
}

}  // namespace

std::vector<std::uint8_t> pack_program(const Program& program) {
  Writer writer;
  Program copy = program;
  fields(writer, copy);
  return std::move(writer.bytes);
}

std::optional<Program> unpack_program(std::span<const std::uint8_t> bytes) {
  Reader reader(bytes);
  Program program;
  fields(reader, program);
  if (!reader.at_end() || !plausible(program)) return std::nullopt;
  try {
    validate(program);
  } catch (const std::exception&) {
    return std::nullopt;
  }
  return program;
}

}  // namespace aluminate::vm
