// Files that only make a later run faster: $XDG_CACHE_HOME/aluminate or ~/.cache/aluminate. Safe to delete at any time.
//   in   a plain file name and bytes
//   out  the bytes somebody stored under that name, or nothing: whatever goes wrong is as if the file were not there
// Never follows a link, never reads a file or uses a folder that another user could have written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace aluminate::host {

/// At most this much is read from one file.
inline constexpr std::size_t kCacheFileBytes = std::size_t{16} << 20;

std::optional<std::vector<std::uint8_t>> read_cache_file(const std::string& name) noexcept;

/// Written complete or not at all. Afterwards the oldest files with this ending go until all of them together are within
/// `budget` bytes.
void write_cache_file(const std::string& name, std::span<const std::uint8_t> bytes, const std::string& ending,
                      std::size_t budget) noexcept;

}  // namespace aluminate::host
