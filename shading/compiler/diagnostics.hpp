// glslang's log in, one UserError out: the first error, its place with a column found in the line, a cleaned
// message and a hint where one is known.
#pragma once

#include "platform/host/error.hpp"

#include <functional>
#include <string>

namespace aluminate::compiler {

using TextOfFile = std::function<const std::string*(const std::string& file)>;

UserError front_end_error(const std::string& log, const std::string& main_file, const TextOfFile& text_of,
                          bool hlsl);

}  // namespace aluminate::compiler
