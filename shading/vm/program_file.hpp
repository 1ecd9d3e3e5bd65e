// A program as bytes and back, for keeping it on disk.
//   in   a valid program, or bytes of any origin
//   out  bytes; or the program, or nothing when the bytes are not exactly what was written for a valid one
#pragma once

#include "shading/vm/program.hpp"

#include <optional>
#include <span>

namespace aluminate::vm {

std::vector<std::uint8_t> pack_program(const Program& program);
std::optional<Program> unpack_program(std::span<const std::uint8_t> bytes);

}  // namespace aluminate::vm
