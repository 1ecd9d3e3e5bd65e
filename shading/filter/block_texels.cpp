#include "shading/filter/block_texels.hpp"

#include <squish.h>

#include "platform/host/error.hpp"

namespace aluminate::filter {
namespace {

int flags_of(BlockFormat format) {
  return (format == BlockFormat::Dxt1 ? squish::kDxt1 : squish::kDxt5) | squish::kColourRangeFit;
}

}  // namespace

std::vector<std::uint8_t> through_blocks(const std::vector<std::uint8_t>& rgba, int width, int height,
                                         BlockFormat format) {
  ALU_CHECK(rgba.size() == 4u * static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
            "{} bytes for {}x{}", rgba.size(), width, height);
  std::vector<std::uint8_t> texels = rgba;
  if (format == BlockFormat::Dxt5nm)
    for (std::size_t i = 0; i < texels.size(); i += 4) {
      texels[i + 3] = rgba[i];
      texels[i] = texels[i + 2] = 0;
    }
  std::vector<std::uint8_t> blocks(block_bytes(width, height, format));
  squish::CompressImage(texels.data(), width, height, blocks.data(), flags_of(format));
  squish::DecompressImage(texels.data(), width, height, blocks.data(), flags_of(format));
  return texels;
}

std::size_t block_bytes(int width, int height, BlockFormat format) {
  return static_cast<std::size_t>(squish::GetStorageRequirements(width, height, flags_of(format)));
}

}  // namespace aluminate::filter
