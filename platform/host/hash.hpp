// XXH3-128 [XXH3] of bytes: names inputs and images. Not cryptographic. The hex text is the canonical (big-endian) form,
// the same on every machine; so are the numbers given to add_u32/add_u64/add_text, which are hashed in little-endian.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace aluminate::host {

struct Hash128 {
  std::uint64_t high = 0, low = 0;
  bool operator==(const Hash128&) const = default;
  auto operator<=>(const Hash128&) const = default;

  std::string hex() const;  // 32 lower-case digits
};

Hash128 hash_bytes(std::span<const std::uint8_t> bytes);
Hash128 hash_text(std::string_view text);

/// The hash of the concatenation of everything added.
class Hasher {
 public:
  Hasher();
  ~Hasher();
  Hasher(Hasher&&) noexcept;
  Hasher& operator=(Hasher&&) noexcept;

  Hasher& add(std::span<const std::uint8_t> bytes);
  Hasher& add(std::span<const std::uint32_t> values);  // each as 4 little-endian bytes
  Hasher& add_u32(std::uint32_t value);
  Hasher& add_u64(std::uint64_t value);
  Hasher& add_text(std::string_view text);  // its length first, so ("ab","c") differs from ("a","bc")

  Hash128 finish() const;  // more may be added afterwards

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace aluminate::host
