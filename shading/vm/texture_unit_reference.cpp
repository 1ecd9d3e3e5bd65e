// The texture unit, texel by texel: the oracle of the fast one.
#include <algorithm>
#include <cmath>

#include "platform/number/scalar.hpp"
#include "shading/vm/cube_map.hpp"
#include "shading/vm/texture_unit.hpp"

namespace aluminate::vm {
namespace {

// Coordinate folded into [0, 1]: exact, because floor and subtraction are.
double fold(Address mode, double u) {
  switch (mode) {
    case Address::Wrap:
      return u - std::floor(u);
    case Address::Clamp:
      return u < 0.0 ? 0.0 : u > 1.0 ? 1.0 : u;
    case Address::Mirror:
      break;
  }
  const double t = u - 2.0 * std::floor(0.5 * u);
  return t > 1.0 ? 2.0 - t : t;
}

std::int64_t to_texel(Address mode, std::int64_t x, std::int64_t size) {
  if (mode == Address::Wrap) return (x + size) % size;  // x >= -1
  return std::clamp<std::int64_t>(x, 0, size - 1);
}

struct Axis {
  std::array<std::int64_t, 2> texel{};
  std::array<std::uint64_t, 2> weight{256, 0};  // sum 256
};

Axis locate(Address mode, Filter filter, double u, int size) {
  // Texel position with 8 fraction bits, texel centres at half texels; rounded to nearest even.
  const double scaled = fold(mode, u) * (256.0 * size);
  const auto position = static_cast<std::int64_t>((scaled + number::kToInteger) - number::kToInteger);
  if (filter == Filter::Point) return {{to_texel(mode, position >> 8, size), 0}, {256, 0}};
  const std::int64_t corner = position - 128;
  const auto fraction = static_cast<std::uint64_t>(corner & 255);
  return {{to_texel(mode, corner >> 8, size), to_texel(mode, (corner >> 8) + 1, size)},
          {256 - fraction, fraction}};
}

std::int32_t lod_of_square(double rho2) noexcept {
  rho2 = rho2 < 0x1p60 ? rho2 : 0x1p60;  // also what overflowed to infinity
  // 256 * log2(rho) = 128 * log2(rho^2), to nearest even; log2 as the instruction defines it, without a grid.
  const number::Grid none{};
  constexpr double kLeastRho2 = 0x1p-60;
  const double lod = 128.0 * number::log2(none, kLeastRho2, rho2);
  return static_cast<std::int32_t>((lod + number::kToInteger) - number::kToInteger);
}

// One lane's fetch, from its coordinates to a sum of texels.
class LaneFetch {
 public:
  LaneFetch(const SamplerBinding& binding, const FetchRequest& request, int lane)
      : texture_(*binding.texture), state_(binding.state), request_(request), lane_(lane) {}

  // For cubes and volumes only the level of detail.
  Footprint footprint() const {
    const std::size_t n = coordinate_count(request_.dimension);
    Footprint result;
    if (request_.op == Opcode::TexLod) {
      result.lod = to_lod(row(n, lane_));
      return result;
    }
    const int first = lane_ & ~3;
    Direction at{}, along_x{}, along_y{};
    for (std::size_t k = 0; k < n; ++k) {
      if (request_.op == Opcode::TexGrad) {
        at[k] = row(k, lane_);
        along_x[k] = row(n + k, lane_);
        along_y[k] = row(2 * n + k, lane_);
      } else {
        at[k] = row(k, first);
        along_x[k] = row(k, first + 1) - row(k, first);
        along_y[k] = row(k, first + 2) - row(k, first);
      }
    }
    result = footprint_of(at, along_x, along_y);
    if (request_.op == Opcode::TexBias) result.lod += to_lod(row(n, lane_));
    return result;
  }

  // Scaled by 65535 * 2^24; for volumes the third axis is weighed first and its 8 bits are rounded away at
  // the end.
  std::array<std::uint64_t, 4> filtered(const MipChoice& mip, const Footprint& footprint) const {
    std::array<std::uint64_t, 4> sum{};
    const auto fraction = static_cast<std::uint64_t>(mip.fraction);
    for (int i = 0; i < footprint.probes; ++i) {
      const double offset = probe_offset(i, footprint.probes);
      const double du = offset * footprint.du, dv = offset * footprint.dv;
      add_level(mip.level, mip.filter, 256 - fraction, du, dv, sum);
      if (fraction != 0) add_level(mip.level + 1, mip.filter, fraction, du, dv, sum);
    }
    return sum;
  }

 private:
  double row(std::size_t r, int lane) const { return request_.rows[r][lane]; }

  Footprint footprint_of(const Direction& at, const Direction& along_x, const Direction& along_y) const {
    const MipLevel& base = texture_.levels().front();
    if (request_.dimension == SamplerDimension::Tex2D)
      return vm::footprint_of(along_x[0], along_x[1], along_y[0], along_y[1], base.width, base.height,
                              most_probes(state_, request_));
    Footprint result;
    if (request_.dimension == SamplerDimension::TexCube) {
      const auto x = face_step(at, along_x), y = face_step(at, along_y);
      result.lod = level_of_detail(x[0], x[1], y[0], y[1], base.width, base.height);
    } else {
      result.lod = volume_level_of_detail(along_x, along_y, {base.width, base.height, base.slices});
    }
    return result;
  }

  void add_level(std::int32_t index, Filter filter, std::uint64_t weight, double du, double dv,
                 std::array<std::uint64_t, 4>& sum) const {
    const auto level = static_cast<std::size_t>(index);
    const MipLevel& mip = texture_.levels()[level];
    double u = row(0, lane_) + du, v = row(1, lane_) + dv;
    Address mode_u = state_.u, mode_v = state_.v;
    Axis slices;
    if (request_.dimension == SamplerDimension::TexCube) {
      const FacePoint point = face_point({u, v, row(2, lane_)});
      u = point.u, v = point.v;
      mode_u = mode_v = Address::Clamp;
      slices.texel[0] = point.face;
    } else if (request_.dimension == SamplerDimension::Tex3D) {
      slices = locate(state_.w, filter, row(2, lane_), mip.slices);
    }
    const Axis x = locate(mode_u, filter, u, mip.width), y = locate(mode_v, filter, v, mip.height);
    for (std::size_t c = 0; c < 4; ++c) {
      std::array<std::uint64_t, 2> planes{};  // <= 65535 * 2^16
      for (std::size_t k = 0; k < 2; ++k)
        for (std::size_t j = 0; j < 2; ++j)
          for (std::size_t i = 0; i < 2; ++i) {
            const std::uint64_t w = slices.weight[k] == 0 ? 0 : x.weight[i] * y.weight[j];
            if (w == 0) continue;
            const std::int64_t texel = (slices.texel[k] * mip.height + y.texel[j]) * mip.width + x.texel[i];
            planes[k] += w * texture_.linear16(level, static_cast<std::size_t>(texel), c);
          }
      // Two slices: their blend, back to 16 weight bits with round half up, as one more filter stage of the
      // same width.
      const std::uint64_t plane =
          slices.weight[1] == 0 ? planes[0]
                                : (planes[0] * slices.weight[0] + planes[1] * slices.weight[1] + 128) >> 8;
      sum[c] += weight * plane;
    }
  }

  const Texture& texture_;
  const SamplerState& state_;
  const FetchRequest& request_;
  int lane_;
};

}  // namespace

bool has_shape(const Texture* texture, SamplerDimension dimension) noexcept {
  if (texture == nullptr) return false;
  switch (dimension) {
    case SamplerDimension::Tex2D:
      return texture->shape() == TextureShape::Flat;
    case SamplerDimension::TexCube:
      return texture->shape() == TextureShape::Cube;
    case SamplerDimension::Tex3D:
      break;
  }
  return texture->shape() == TextureShape::Volume;
}

std::int32_t level_of_detail(double du_dx, double dv_dx, double du_dy, double dv_dy, int width,
                             int height) noexcept {
  return footprint_of(du_dx, dv_dx, du_dy, dv_dy, width, height, 1).lod;
}

Footprint footprint_of(double du_dx, double dv_dx, double du_dy, double dv_dy, int width, int height,
                       int max_anisotropy) noexcept {
  const double ux = du_dx * width, vx = dv_dx * height, uy = du_dy * width, vy = dv_dy * height;
  const double along_x = ux * ux + vx * vx, along_y = uy * uy + vy * vy;
  const bool is_x = along_x >= along_y;
  const double longer = is_x ? along_x : along_y, shorter = is_x ? along_y : along_x;
  // As many probes as the longer axis is times the shorter one, or times a texel if that is more.
  const double least = shorter > 1.0 ? shorter : 1.0;
  Footprint result;
  while (result.probes < max_anisotropy && result.probes * result.probes * least < longer) ++result.probes;
  const double share = 1.0 / (result.probes * result.probes);
  result.lod = lod_of_square(longer * share);
  result.du = is_x ? du_dx : du_dy;
  result.dv = is_x ? dv_dx : dv_dy;
  return result;
}

std::int32_t volume_level_of_detail(const std::array<double, 3>& along_x,
                                    const std::array<double, 3>& along_y,
                                    const std::array<int, 3>& size) noexcept {
  double squares[2] = {0, 0};
  for (std::size_t k = 0; k < 3; ++k) {
    const double x = along_x[k] * size[k], y = along_y[k] * size[k];
    squares[0] += x * x;
    squares[1] += y * y;
  }
  return lod_of_square(squares[0] > squares[1] ? squares[0] : squares[1]);
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
  const bool is_bound = has_shape(binding.texture, request.dimension);
  for (int quad = 0; quad < 64; quad += 4) {
    std::array<std::array<double, 4>, 4>
        texels{};  // [lane][channel]: written only after the quad has been read
    for (int l = 0; l < 4; ++l) {
      const int lane = quad + l;
      auto& texel = texels[static_cast<std::size_t>(l)];
      const bool is_billed = (request.exec & request.covered) >> lane & 1;
      cost.fetches += is_billed ? 1 : 0;
      if (!is_bound) {
        texel = {0, 0, 0, 1};
        cost.cycles += is_billed ? 1 : 0;
        continue;
      }
      const LaneFetch one(binding, request, lane);
      const Footprint footprint = one.footprint();
      const MipChoice mip = choose_mip(binding.state, binding.texture->levels().size(), footprint.lod);
      const int slices = request.dimension == SamplerDimension::Tex3D && mip.filter == Filter::Linear ? 2 : 1;
      cost.cycles +=
          is_billed ? static_cast<std::uint64_t>((mip.fraction != 0 ? 2 : 1) * slices * footprint.probes) : 0;
      const std::array<std::uint64_t, 4> sum = one.filtered(mip, footprint);
      // <= 16 * 65535 * 2^24 < 2^44: exact in binary64. One rounding to the grid.
      for (std::size_t c = 0; c < 4; ++c) texel[c] = texel_value(grid, sum[c], footprint.probes);
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
