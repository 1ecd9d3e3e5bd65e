// Texels as block compression leaves them: encoded and decoded again at import, so that the texture unit
// reads plain codes and the blocks decide only what they are and how many bytes a console would have moved.
// Encoder: libsquish, range fit; what it chooses is its own, what a block decodes to is the format's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace aluminate::filter {

/// Dxt1: opaque colour, 4 bits a texel. Dxt5: colour and alpha, 8 bits. Dxt5nm: of a normal map (x, y, z in
/// rgb) y in green and x in alpha, red and blue 0; the shader makes z.
enum class BlockFormat { Dxt1, Dxt5, Dxt5nm };

/// rgba: 4 * width * height codes, row-major; the result likewise. Sizes need not be multiples of 4.
[[nodiscard]] std::vector<std::uint8_t> through_blocks(const std::vector<std::uint8_t>& rgba, int width,
                                                       int height, BlockFormat format);
[[nodiscard]] std::size_t block_bytes(int width, int height, BlockFormat format);

}  // namespace aluminate::filter
