// The exported texture: DXT5 with filtered gloss in red, normal y in green, normal x in alpha, and what that
// layout does to the normal. In: a baked level. Out: DXT5 blocks, decoded texels, error figures. Encoder:
// libsquish; a tool of import time only.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "shading/filter/gloss_bake.hpp"

namespace aluminate::filter {

/// [McAuley12] Exported texel: R = gloss, G = ny, B = 0, A = nx, each round(255 v), normals mapped from [-1,
/// 1]. y shares the 5:6:5 colour block with gloss and competes with it for one line of four colours; x has
/// the alpha block to itself. (The layout "gloss in alpha" in the same source is that of the artists' file,
/// before export.)
[[nodiscard]] std::vector<std::uint8_t> pack_texels(const BakedLevel& level, const ScalarLevel& gloss);

/// Weights of red, green, blue in the encoder's search.
using ChannelWeights = std::array<float, 3>;

/// DXT5 blocks of a packed picture, 16 bytes each, 4x4 texels, row-major by block; sizes need not be
/// multiples of 4.
[[nodiscard]] std::vector<std::uint8_t> encode_dxt5(const std::vector<std::uint8_t>& rgba, int width,
                                                    int height, ChannelWeights weights = {1, 1, 1});
[[nodiscard]] std::vector<std::uint8_t> decode_dxt5(const std::vector<std::uint8_t>& blocks, int width,
                                                    int height);

/// Root-mean-square error of one encoding in 8-bit steps.
struct PackError {
  double gloss = 0, normal_y = 0, normal_x = 0;
};
[[nodiscard]] PackError pack_error(const std::vector<std::uint8_t>& packed,
                                   const std::vector<std::uint8_t>& decoded);

/// The cross-talk experiment: the same normals with five contents of the red channel, worst last.
struct CrossTalkRow {
  std::string_view content;  // none, smooth, filtered, detailed, noise
  PackError error;
};
/// `level` supplies the normals and the filtered gloss; the other contents are made here: none = 0, smooth =
/// one slow wave, detailed = waves of a few texels unrelated to the normals, noise = independent bytes.
[[nodiscard]] std::vector<CrossTalkRow> cross_talk(const BakedLevel& level,
                                                   ChannelWeights weights = {1, 1, 1});

}  // namespace aluminate::filter
