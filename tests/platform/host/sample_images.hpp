// One small image of every format that is read: a 16 x 12 colour ramp, written by oiiotool.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "platform/host/input_file.hpp"

namespace aluminate::host {

inline const std::map<std::string, std::vector<std::uint8_t>>& sample_images() {
  static const auto loaded = [] {
    std::map<std::string, std::vector<std::uint8_t>> images;
    for (const char* name : {"sample.png", "sample16.png", "grey.png", "grey_alpha.png", "sample.jpg", "sample.tif",
                             "sample16.tif", "sample.exr", "sample.hdr", "sample.bmp", "sample.tga"}) {
      images[name] = read_bytes(std::string(ALUMINATE_SOURCE_DIR "/tests/platform/host/samples/") + name);
    }
    return images;
  }();
  return loaded;
}

}  // namespace aluminate::host
