// The texture unit, texel by texel: the oracle of the fast one.
#include <algorithm>
#include <cmath>

#include "platform/number/scalar.hpp"
#include "shading/vm/srgb.hpp"
#include "shading/vm/texture_unit.hpp"

namespace aluminate::vm {
namespace {

// 16-bit linear value of one channel of a texel.
std::uint64_t texel16(const Texture& texture, const MipLevel& level, std::int64_t x, std::int64_t y, std::size_t channel) {
  const std::uint8_t code =
      level.rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(level.width) + static_cast<std::size_t>(x)) + channel];
  return texture.srgb() && channel < 3 ? srgb_decode16(code) : std::uint64_t{code} * 257;
}

// Coordinate folded into [0, 1]: exact, because floor and subtraction are.
double fold(Address mode, double u) {
  switch (mode) {
    case Address::Wrap: return u - std::floor(u);
    case Address::Clamp: return u < 0.0 ? 0.0 : u > 1.0 ? 1.0 : u;
    case Address::Mirror: break;
  }
  const double t = u - 2.0 * std::floor(0.5 * u);
  return t > 1.0 ? 2.0 - t : t;
}

std::int64_t to_texel(Address mode, std::int64_t x, std::int64_t size) {
  if (mode == Address::Wrap) return (x + size) % size;  // x >= -1
  return std::clamp<std::int64_t>(x, 0, size - 1);
}

struct Axis {
  std::int64_t texel[2];
  std::uint64_t weight[2];  // sum 256
};

Axis locate(Address mode, Filter filter, double u, int size) {
  // Texel position with 8 fraction bits, texel centres at half texels; rounded to nearest even.
  const double scaled = fold(mode, u) * (256.0 * size);
  const auto position = static_cast<std::int64_t>((scaled + number::kToInteger) - number::kToInteger);
  if (filter == Filter::Point) return {{to_texel(mode, position >> 8, size), 0}, {256, 0}};
  const std::int64_t corner = position - 128;
  const auto fraction = static_cast<std::uint64_t>(corner & 255);
  return {{to_texel(mode, corner >> 8, size), to_texel(mode, (corner >> 8) + 1, size)}, {256 - fraction, fraction}};
}

using Sums = std::array<std::uint64_t, 4>;

// Scaled by 2^16: <= 65535 * 2^16.
Sums bilinear(const SamplerBinding& binding, Filter filter, int level_index, double u, double v) {
  const Texture& texture = *binding.texture;
  const MipLevel& level = texture.levels()[static_cast<std::size_t>(level_index)];
  const Axis x = locate(binding.state.u, filter, u, level.width), y = locate(binding.state.v, filter, v, level.height);
  Sums sum{};
  for (std::size_t j = 0; j < 2; ++j)
    for (std::size_t i = 0; i < 2; ++i)
      if (x.weight[i] * y.weight[j] != 0)
        for (std::size_t c = 0; c < 4; ++c)
          sum[c] += x.weight[i] * y.weight[j] * texel16(texture, level, x.texel[i], y.texel[j], c);
  return sum;
}

}  // namespace

std::int32_t level_of_detail(double du_dx, double dv_dx, double du_dy, double dv_dy, int width, int height) noexcept {
  const double ux = du_dx * width, vx = dv_dx * height, uy = du_dy * width, vy = dv_dy * height;
  const double along_x = ux * ux + vx * vx, along_y = uy * uy + vy * vy;
  double rho2 = along_x > along_y ? along_x : along_y;
  rho2 = rho2 < 0x1p60 ? rho2 : 0x1p60;  // also what overflowed to infinity
  // 256 * log2(rho) = 128 * log2(rho^2), to nearest even; log2 as the instruction defines it, without a grid.
  const number::Grid none{};
  constexpr double kLeastRho2 = 0x1p-60;
  const double lod = 128.0 * number::log2(none, kLeastRho2, rho2);
  return static_cast<std::int32_t>((lod + number::kToInteger) - number::kToInteger);
}

std::int32_t to_lod(double level) noexcept {
  constexpr double kGreatest = 1024.0;
  level = level < kGreatest ? level : kGreatest;
  level = level > -kGreatest ? level : -kGreatest;
  return static_cast<std::int32_t>((256.0 * level + number::kToInteger) - number::kToInteger);
}

MipChoice choose_mip(const SamplerState& state, std::size_t levels, std::int32_t lod) noexcept {
  MipChoice choice;
  choice.filter = lod > 0 ? state.minify : state.magnify;
  if (!state.mipmapped || lod <= 0) return choice;
  const std::int32_t last = static_cast<std::int32_t>(levels - 1) * 256;
  lod = std::min(lod, last);
  if (state.mip == Filter::Point) lod = (lod + 128) & ~255;
  choice.level = std::min(lod, last) >> 8;
  choice.fraction = std::min(lod, last) & 255;
  return choice;
}

FetchCost fetch_reference(const SamplerBinding& binding, const FetchRequest& request, bool masked,
                          const number::Grid& grid, const std::array<double*, 4>& results) noexcept {
  FetchCost cost;
  const auto row = [&](std::size_t r, int lane) { return request.rows[r][lane]; };
  for (int quad = 0; quad < 64; quad += 4) {
    std::array<std::array<double, 4>, 4> texels{};  // [lane][channel]: written only after the quad has been read
    for (int l = 0; l < 4; ++l) {
      const int lane = quad + l;
      auto& texel = texels[static_cast<std::size_t>(l)];
      const bool executes = (request.exec >> lane & 1) != 0;
      const bool billed = executes && (request.covered >> lane & 1) != 0;
      cost.fetches += billed ? 1 : 0;
      if (binding.texture == nullptr) {
        texel = {0, 0, 0, 1};
        cost.cycles += billed ? 1 : 0;
        continue;
      }
      const MipLevel& base = binding.texture->levels().front();
      std::int32_t lod = 0;
      if (request.op == Opcode::TexLod) {
        lod = to_lod(row(2, lane));
      } else if (request.op == Opcode::TexGrad) {
        lod = level_of_detail(row(2, lane), row(3, lane), row(4, lane), row(5, lane), base.width, base.height);
      } else {
        lod = level_of_detail(row(0, quad + 1) - row(0, quad), row(1, quad + 1) - row(1, quad),
                              row(0, quad + 2) - row(0, quad), row(1, quad + 2) - row(1, quad), base.width, base.height);
        if (request.op == Opcode::TexBias) lod += to_lod(row(2, lane));
      }
      const MipChoice mip = choose_mip(binding.state, binding.texture->levels().size(), lod);
      cost.cycles += billed ? (mip.fraction != 0 ? 2 : 1) : 0;

      const Sums fine = bilinear(binding, mip.filter, mip.level, row(0, lane), row(1, lane));
      Sums coarse{};
      if (mip.fraction != 0) coarse = bilinear(binding, mip.filter, mip.level + 1, row(0, lane), row(1, lane));
      for (std::size_t c = 0; c < 4; ++c) {
        const auto f = static_cast<std::uint64_t>(mip.fraction);
        // <= 65535 * 2^24 < 2^40: exact in binary64. One rounding to the grid.
        texel[c] = texel_value(grid, fine[c] * (256 - f) + coarse[c] * f);
      }
    }
    for (int l = 0; l < 4; ++l) {
      if (masked && (request.exec >> (quad + l) & 1) == 0) continue;
      for (std::size_t c = 0; c < 4; ++c)
        if (results[c] != nullptr) results[c][quad + l] = texels[static_cast<std::size_t>(l)][c];
    }
  }
  return cost;
}

}  // namespace aluminate::vm
