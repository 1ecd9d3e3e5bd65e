// Whole files in. A missing or unreadable file is a UserError that names it; nothing is interpreted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace aluminate::host {

inline constexpr std::int64_t kMaxInputBytes = std::int64_t{1} << 31;

std::vector<std::uint8_t> read_bytes(const std::string& path);
std::string read_text(const std::string& path);

}  // namespace aluminate::host
