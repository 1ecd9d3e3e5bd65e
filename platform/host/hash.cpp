#include "platform/host/hash.hpp"

#include <fmt/format.h>
#define XXH_INLINE_ALL  // header-only: no further library, and the vector path is chosen by this compiler
#include <xxhash.h>

#include <array>
#include <bit>

namespace aluminate::host {
namespace {

Hash128 from_xxh(const XXH128_hash_t& hash) { return {hash.high64, hash.low64}; }

template <class Integer>
std::array<std::uint8_t, sizeof(Integer)> little_endian(Integer value) {
  std::array<std::uint8_t, sizeof(Integer)> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(value >> (8 * i));
  return bytes;
}

}  // namespace

struct Hasher::State {
  XXH3_state_t xxh;  // aligned to 64 bytes by its own declaration; operator new honours it
};

std::string Hash128::hex() const { return fmt::format("{:016x}{:016x}", high, low); }

Hash128 hash_bytes(std::span<const std::uint8_t> bytes) { return from_xxh(XXH3_128bits(bytes.data(), bytes.size())); }
Hash128 hash_text(std::string_view text) { return from_xxh(XXH3_128bits(text.data(), text.size())); }

Hasher::Hasher() : state_(std::make_unique<State>()) { XXH3_128bits_reset(&state_->xxh); }
Hasher::~Hasher() = default;
Hasher::Hasher(Hasher&&) noexcept = default;
Hasher& Hasher::operator=(Hasher&&) noexcept = default;

Hasher& Hasher::add(std::span<const std::uint8_t> bytes) {
  XXH3_128bits_update(&state_->xxh, bytes.data(), bytes.size());
  return *this;
}

Hasher& Hasher::add(std::span<const std::uint32_t> values) {
  if constexpr (std::endian::native == std::endian::little) {
    XXH3_128bits_update(&state_->xxh, values.data(), values.size_bytes());
  } else {
    for (const std::uint32_t value : values) add_u32(value);
  }
  return *this;
}

Hasher& Hasher::add_u32(std::uint32_t value) { return add(std::span<const std::uint8_t>(little_endian(value))); }
Hasher& Hasher::add_u64(std::uint64_t value) { return add(std::span<const std::uint8_t>(little_endian(value))); }

Hasher& Hasher::add_text(std::string_view text) {
  add_u64(text.size());
  XXH3_128bits_update(&state_->xxh, text.data(), text.size());
  return *this;
}

Hash128 Hasher::finish() const { return from_xxh(XXH3_128bits_digest(&state_->xxh)); }

}  // namespace aluminate::host
