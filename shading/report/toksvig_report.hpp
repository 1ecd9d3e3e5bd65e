// What filtering does to a normal map, and the texture an importer would write.
#pragma once

#include <string>

#include "platform/host/image_file.hpp"
#include "shading/filter/gloss_bake.hpp"

namespace aluminate::report {

/// A line a mip: lengths, gloss before and after, power, the four means of the factor; then the cross-talk of
/// the DXT5 layout on level 0.
std::string toksvig_text(const std::vector<filter::BakedLevel>& levels);

/// The exported texels, red = filtered gloss, green = normal y, alpha = normal x: level 0 on the left, the
/// others one below the other to its right, black where nothing lies. dxt5: as they come back from DXT5.
host::Image8 toksvig_picture(const std::vector<filter::BakedLevel>& levels, bool dxt5);

}  // namespace aluminate::report
