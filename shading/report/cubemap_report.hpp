// What a captured cube map holds, level by level.
#pragma once

#include <string>
#include <vector>

#include "shading/filter/cube_filter.hpp"

namespace aluminate::report {

/// A line a level: texels, the power and gloss it is filtered for, mean and greatest light, share of the sky.
std::string cubemap_text(const std::vector<filter::CubeLevel>& chain);

}  // namespace aluminate::report
