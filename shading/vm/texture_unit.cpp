// The texture unit on vectors: coordinates in binary64, texels as four 16-bit channels of one 64-bit lane.
// Same integers as texture_unit_reference.cpp; lanes of a vector that need different levels are done level by
// level and blended. Volumes, which no shipped shader samples, go to the reference.
#include "shading/vm/texture_unit.hpp"

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/vm/texture_unit.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "shading/vm/cube_map.hpp"
#include "shading/vm/simd_lanes-inl.hpp"

#ifndef ALUMINATE_TEXTURE_LANES
#define ALUMINATE_TEXTURE_LANES
namespace aluminate::vm {

// What each lane samples, decided before any texel is read.
struct LaneChoices {
  alignas(64) std::int64_t key[64];  // 2 * level + (1 if linear)
  alignas(64) double fraction[64];   // weight of the next level, 0..255
  std::uint64_t blended = 0;         // lanes whose fraction is not 0
};

// Places on a plane, folded into [0, 1]; cubes also have a face.
struct PlaneLanes {
  alignas(64) double u[64];
  alignas(64) double v[64];
  alignas(64) std::int64_t face[64];
  bool has_faces = false;
  Address mode_u = Address::Wrap, mode_v = Address::Wrap;
};

}  // namespace aluminate::vm
#endif

HWY_BEFORE_NAMESPACE();
namespace aluminate::vm {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

// One lane at a time there is nothing to gain.
FetchCost fetch_lanes(const SamplerBinding& binding, const FetchRequest& request, bool masked,
                      const number::Grid& grid, const std::array<double*, 4>& results) {
  return fetch_reference(binding, request, masked, grid, results);
}

#else

using I = hn::RebindToSigned<D>;
using IV = hn::Vec<I>;
using UV = hn::Vec<U>;
using I32 = hn::Repartition<std::int32_t, D>;
using U32 = hn::Repartition<std::uint32_t, D>;
using I16 = hn::Repartition<std::int16_t, D>;
using V32 = hn::Vec<I32>;

// Level of detail of all 16 quads, times 256, from the squares of the longer derivative; lod_of_square() in
// vectors.
void details_of(double* rho2, std::int32_t* lods) {
  const V to_integer = constant(number::kToInteger);
  alignas(64) std::int64_t wide[16];
  for (std::size_t q = 0; q < 16; q += hn::Lanes(D())) {
    const V x = greater_of(hn::Load(D(), rho2 + q), constant(0x1p-60));
    const V rounded = hn::Add(hn::Mul(constant(128.0), log2_unrounded<true>(x)), to_integer);
    hn::Store(hn::Sub(hn::BitCast(I(), rounded), hn::BitCast(I(), to_integer)), I(), wide + q);
  }
  for (std::size_t q = 0; q < 16; ++q) lods[q] = static_cast<std::int32_t>(wide[q]);
}

// Implicit detail of flat textures: level_of_detail() of each quad's differences.
void quad_details(const double* u, const double* v, int width, int height, std::int32_t* lods) {
  alignas(64) double rho2[16];
  for (std::size_t q = 0; q < 16; ++q) {
    const double* qu = u + 4 * q;
    const double* qv = v + 4 * q;
    const double ux = (qu[1] - qu[0]) * width, vx = (qv[1] - qv[0]) * height;
    const double uy = (qu[2] - qu[0]) * width, vy = (qv[2] - qv[0]) * height;
    const double along_x = ux * ux + vx * vx, along_y = uy * uy + vy * vy;
    const double larger = along_x > along_y ? along_x : along_y;
    rho2[q] = larger < 0x1p60 ? larger : 0x1p60;
  }
  details_of(rho2, lods);
}

HWY_INLINE V fold(Address mode, V u) {
  switch (mode) {
    case Address::Wrap:
      return hn::Sub(u, floor_of(u));
    case Address::Clamp: {
      const V low = hn::IfThenElse(hn::Lt(u, hn::Zero(D())), hn::Zero(D()), u);
      return hn::IfThenElse(hn::Gt(low, constant(1.0)), constant(1.0), low);
    }
    case Address::Mirror:
      break;
  }
  const V t = hn::Sub(u, hn::Mul(constant(2.0), floor_of(hn::Mul(constant(0.5), u))));
  return hn::IfThenElse(hn::Gt(t, constant(1.0)), hn::Sub(constant(2.0), t), t);
}

// x in the low, y in the high half of each 64-bit lane.
HWY_INLINE V32 both(std::int32_t x, std::int32_t y) {
  return hn::BitCast(I32(), hn::Set(U(), std::uint64_t{static_cast<std::uint32_t>(y)} << 32 |
                                             static_cast<std::uint32_t>(x)));
}

// A level as the vectors want it.
struct Level {
  Level(const Texture& texture, const PlaneLanes& plane, std::size_t index)
      : Level(texture.levels()[index], texture.filter_texels(index), plane) {}

  Level(const MipLevel& mip, const std::uint64_t* from, const PlaneLanes& plane)
      : texels(from),
        scale_u(constant(256.0 * mip.width)),
        scale_v(constant(256.0 * mip.height)),
        size(both(mip.width, mip.height)),
        before(both(plane.mode_u == Address::Wrap ? mip.width - 1 : 0,
                    plane.mode_v == Address::Wrap ? mip.height - 1 : 0)),
        after(both(plane.mode_u == Address::Wrap ? 0 : mip.width - 1,
                   plane.mode_v == Address::Wrap ? 0 : mip.height - 1)),
        width(hn::Set(U32(), static_cast<std::uint32_t>(mip.width))),
        area(hn::Set(U32(), static_cast<std::uint32_t>(mip.width) * static_cast<std::uint32_t>(mip.height))) {
  }

  const std::uint64_t* texels;
  V scale_u, scale_v;
  V32 size, before, after;  // only one texel lies beyond an edge: -1 before the first, size after the last
  hn::Vec<U32> width, area;
};

struct Corners {
  IV top, bottom;  // texel index of the row's first texel
  IV left, right;  // columns
  V32 weight;      // of right and bottom, 0..255, as in both()
};

// The four texels around a position: first and second of each axis, and the second's weight. Positions are at
// most 256 * 2^14 and corners at least -128, so that they fit the low half of the shifted binary64.
template <bool kLinear>
HWY_INLINE Corners locate(const Level& level, V u, V v) {
  static_assert(256LL * (1 << 14) < (1LL << 31));
  const V to_integer = constant(number::kToInteger);
  const auto bits_x = hn::BitCast(U(), hn::Add(hn::Mul(u, level.scale_u), to_integer));
  const auto bits_y = hn::BitCast(U(), hn::Add(hn::Mul(v, level.scale_v), to_integer));
  const UV low_half = hn::Set(U(), std::uint64_t{0xffffffff});
  const V32 position = hn::BitCast(I32(), hn::Or(hn::And(bits_x, low_half), hn::ShiftLeft<32>(bits_y)));
  const V32 corner = kLinear ? hn::Sub(position, hn::Set(I32(), 128)) : position;
  const V32 here = hn::ShiftRight<8>(corner);
  const V32 next = hn::Add(here, hn::Set(I32(), 1));
  const V32 second = hn::IfThenElse(hn::Eq(next, level.size), level.after, next);
  const V32 first = kLinear ? hn::IfThenElse(hn::Lt(here, hn::Zero(I32())), level.before, here)
                            : hn::IfThenElse(hn::Eq(here, level.size), level.after, here);
  const auto row = [&](V32 texel) HWY_ATTR {  // y * width < 2^28
    return hn::BitCast(
        I(), hn::MulEven(hn::BitCast(U32(), hn::ShiftRight<32>(hn::BitCast(U(), texel))), level.width));
  };
  const auto column = [&](V32 texel)
                          HWY_ATTR { return hn::BitCast(I(), hn::And(hn::BitCast(U(), texel), low_half)); };
  return {row(first), row(second), column(first), column(second), hn::And(corner, hn::Set(I32(), 255))};
}

HWY_INLINE V32 weighted_pairs(V32 pairs, V32 weights) {  // a * wa + b * wb of each two 16-bit numbers
  V32 rest = hn::Zero(I32());
  const V32 sum = hn::ReorderWidenMulAccumulate(I32(), hn::BitCast(I16(), pairs), hn::BitCast(I16(), weights),
                                                hn::Zero(I32()), rest);
  return hn::RearrangeToOddPlusEven(sum, rest);
}

// Four channels as 32-bit numbers of the even (low) and odd (high) lanes: 2^16 (texel - 32768), in [-2^31,
// 2^31).
struct Channels {
  V32 even, odd;
};

template <bool kLinear>
HWY_INLINE Channels bilinear(const std::uint64_t* texels, const Corners& at) {
  const auto texel = [&](IV row, IV column) HWY_ATTR {
    return hn::BitCast(I16(), hn::GatherIndex(U(), texels, hn::Add(row, column)));
  };
  const auto t00 = texel(at.top, at.left);
  if constexpr (!kLinear) {
    const auto zero = hn::Zero(I16());
    return {hn::BitCast(I32(), hn::InterleaveLower(I16(), zero, t00)),
            hn::BitCast(I32(), hn::InterleaveUpper(I16(), zero, t00))};
  } else {
    const auto t01 = texel(at.top, at.right), t10 = texel(at.bottom, at.left),
               t11 = texel(at.bottom, at.right);
    // 256 - w and w as a pair of 16-bit numbers.
    const V32 pair = hn::Or(hn::Sub(hn::Set(I32(), 256), at.weight), hn::ShiftLeft<16>(at.weight));
    // |rows| <= 2^15 * 256 = 2^23. (bottom - top) * w may pass 2^31, the sum does not: exact modulo 2^32.
    static_assert((1LL << 15) * 256 * 256 <= (1LL << 31));
    const auto blend = [](V32 upper, V32 lower, V32 down) HWY_ATTR {
      return hn::Add(hn::ShiftLeft<8>(upper), hn::Mul(down, hn::Sub(lower, upper)));
    };
    const auto even = [](auto a, auto b)
                          HWY_ATTR { return hn::BitCast(I32(), hn::InterleaveLower(I16(), a, b)); };
    const auto odd = [](auto a, auto b)
                         HWY_ATTR { return hn::BitCast(I32(), hn::InterleaveUpper(I16(), a, b)); };
    const V32 across_even = hn::Broadcast<0>(pair), across_odd = hn::Broadcast<2>(pair);
    return {blend(weighted_pairs(even(t00, t01), across_even), weighted_pairs(even(t10, t11), across_even),
                  hn::Broadcast<1>(at.weight)),
            blend(weighted_pairs(odd(t00, t01), across_odd), weighted_pairs(odd(t10, t11), across_odd),
                  hn::Broadcast<3>(at.weight))};
  }
}

struct Rows {
  V channel[4];
};

// Lanes of four channels to four rows of lanes.
HWY_INLINE Rows transposed(const Channels& c) {
  using Half = hn::Half<I32>;
  const auto red_green =
      hn::BitCast(U(), hn::InterleaveLower(I32(), c.even, c.odd));  // r r g g in each block
  const auto blue_alpha = hn::BitCast(U(), hn::InterleaveUpper(I32(), c.even, c.odd));
  const V32 red_blue = hn::BitCast(I32(), hn::ConcatEven(U(), blue_alpha, red_green));
  const V32 green_alpha = hn::BitCast(I32(), hn::ConcatOdd(U(), blue_alpha, red_green));
  return {{hn::PromoteTo(D(), hn::LowerHalf(Half(), red_blue)),
           hn::PromoteTo(D(), hn::LowerHalf(Half(), green_alpha)),
           hn::PromoteTo(D(), hn::UpperHalf(Half(), red_blue)),
           hn::PromoteTo(D(), hn::UpperHalf(Half(), green_alpha))}};
}

template <bool kLinear>
HWY_INLINE Rows filtered(const Level& level, const PlaneLanes& plane, std::size_t i) {
  Corners at = locate<kLinear>(level, hn::Load(D(), plane.u + i), hn::Load(D(), plane.v + i));
  if (plane.has_faces) {  // face * width^2 < 6 * 2^28 < 2^32
    const IV face =
        hn::BitCast(I(), hn::MulEven(hn::BitCast(U32(), hn::Load(I(), plane.face + i)), level.area));
    at.top = hn::Add(at.top, face);
    at.bottom = hn::Add(at.bottom, face);
  }
  return transposed(bilinear<kLinear>(level.texels, at));
}

// Everything about one fetch that its vectors share.
struct Filter64 {
  const SamplerBinding& binding;
  const PlaneLanes& plane;
  const LaneChoices& choices;
  const number::Grid& grid;
  const std::array<double*, 4>& results;
};

// The lanes of one level and filter. Sums are scaled by 65535 * 2^24 and offset back to unsigned: binary64
// holds each step exactly (below 2^41).
template <bool kLinear>
void filter_lanes(const Filter64& fetch, std::size_t index, std::uint64_t lanes) {
  constexpr std::size_t kStep = hn::MaxLanes(D());
  constexpr std::uint64_t kVectorLanes = (std::uint64_t{1} << kStep) - 1;
  const Level fine(*fetch.binding.texture, fetch.plane, index);
  const std::uint64_t blended = lanes & fetch.choices.blended;
  const Level coarse(*fetch.binding.texture, fetch.plane, blended != 0 ? index + 1 : index);
  const V magic = constant(fetch.grid.magic), scale = constant(0x1p-24 / 65535.0);
  const V weight = constant(256.0), offset = constant(0x1p39);
  for (std::size_t i = 0; i < 64; i += kStep) {
    const std::uint64_t mine = lanes >> i & kVectorLanes;
    if (mine == 0) continue;
    Rows sums = filtered<kLinear>(fine, fetch.plane, i);
    if ((blended >> i & kVectorLanes) != 0) {
      const Rows beyond = filtered<kLinear>(coarse, fetch.plane, i);
      const V fraction = hn::Load(D(), fetch.choices.fraction + i);
      for (std::size_t c = 0; c < 4; ++c)
        sums.channel[c] =
            fma(hn::Sub(beyond.channel[c], sums.channel[c]), fraction, fma(sums.channel[c], weight, offset));
    } else {
      for (V& sum : sums.channel) sum = fma(sum, weight, offset);
    }
    for (std::size_t c = 0; c < 4; ++c) {
      if (fetch.results[c] == nullptr) continue;
      const V texel = hn::Sub(fma(sums.channel[c], scale, magic), magic);
      if (mine == kVectorLanes) {
        hn::StoreU(texel, D(), fetch.results[c] + i);
      } else {
        hn::BlendedStore(texel, mask_at(lanes, i), D(), fetch.results[c] + i);
      }
    }
  }
}

std::uint64_t lanes_of_key(const LaneChoices& choices, std::int64_t key) {
  std::uint64_t lanes = 0;
  for (std::size_t i = 0; i < 64; i += hn::Lanes(D())) {
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(I(), hn::Eq(hn::Load(I(), choices.key + i), hn::Set(I(), key)), bits);
    lanes |= std::uint64_t{bits[0]} << i;
  }
  return lanes;
}

// choose_mip() of 16 quads without a branch per quad.
void choose_by_quad(const SamplerState& state, std::size_t levels, const std::int32_t* lods,
                    LaneChoices& choices) {
  const std::int32_t last = state.mipmapped ? static_cast<std::int32_t>(levels - 1) * 256 : 0;
  const std::int32_t round = state.mip == Filter::Point ? 128 : 0,
                     keep = state.mip == Filter::Point ? ~255 : ~0;
  const std::int32_t magnify = state.magnify == Filter::Linear ? 1 : 0,
                     minify = state.minify == Filter::Linear ? 1 : 0;
  for (int quad = 0; quad < 16; ++quad) {
    const std::int32_t lod = lods[quad];
    const std::int32_t inside = lod < 0 ? 0 : lod > last ? last : lod;
    const std::int32_t chosen = (inside + round) & keep;
    const std::int32_t place = chosen > last ? last : chosen;
    const std::int64_t key = 2 * (place >> 8) + (lod > 0 ? minify : magnify);
    const double fraction = place & 255;
    for (int lane = 4 * quad; lane < 4 * quad + 4; ++lane) {
      choices.key[lane] = key;
      choices.fraction[lane] = fraction;
    }
    choices.blended |= std::uint64_t{(place & 255) != 0 ? 0xfu : 0u} << (4 * quad);
  }
}

// Level and weight of every lane.
void choose_levels(const SamplerBinding& binding, const FetchRequest& request, LaneChoices& choices) {
  const MipLevel& base = binding.texture->levels().front();
  const std::size_t levels = binding.texture->levels().size();
  const std::size_t n = coordinate_count(request.dimension);
  const bool is_cube = request.dimension == SamplerDimension::TexCube;
  const auto row = [&](std::size_t r, int lane) { return request.rows[r][lane]; };
  const auto choose = [&](int first, int count, std::int32_t lod) {
    const MipChoice mip = choose_mip(binding.state, levels, lod);
    for (int lane = first; lane < first + count; ++lane) {
      choices.key[lane] = 2 * mip.level + (mip.filter == Filter::Linear ? 1 : 0);
      choices.fraction[lane] = mip.fraction;
    }
    if (mip.fraction != 0) choices.blended |= ((std::uint64_t{1} << count) - 1) << first;
  };
  if (request.op == Opcode::TexLod) {
    for (int lane = 0; lane < 64; ++lane) choose(lane, 1, to_lod(row(n, lane)));
    return;
  }
  const auto cube_detail = [&](const Direction& at, const Direction& along_x, const Direction& along_y) {
    const auto x = face_step(at, along_x), y = face_step(at, along_y);
    return level_of_detail(x[0], x[1], y[0], y[1], base.width, base.height);
  };
  if (request.op == Opcode::TexGrad) {
    for (int lane = 0; lane < 64; ++lane) {
      const auto at = [&](std::size_t first) {
        return Direction{row(first, lane), row(first + 1, lane), row(first + 2, lane)};
      };
      choose(lane, 1,
             is_cube ? cube_detail(at(0), at(3), at(6))
                     : level_of_detail(row(2, lane), row(3, lane), row(4, lane), row(5, lane), base.width,
                                       base.height));
    }
    return;
  }
  alignas(64) std::int32_t lods[16];
  if (is_cube) {
    for (int quad = 0; quad < 16; ++quad) {
      Direction at{}, along_x{}, along_y{};
      for (std::size_t k = 0; k < 3; ++k) {
        const double* const r = request.rows[k] + 4 * quad;
        at[k] = r[0];
        along_x[k] = r[1] - r[0];
        along_y[k] = r[2] - r[0];
      }
      lods[quad] = cube_detail(at, along_x, along_y);
    }
  } else {
    quad_details(request.rows[0], request.rows[1], base.width, base.height, lods);
  }
  if (request.op == Opcode::Tex) {
    choose_by_quad(binding.state, levels, lods, choices);
  } else {
    for (int lane = 0; lane < 64; ++lane) choose(lane, 1, lods[lane / 4] + to_lod(row(n, lane)));
  }
}

// Coordinates are copied out: result rows may be coordinate rows.
void find_places(const SamplerBinding& binding, const FetchRequest& request, PlaneLanes& plane) {
  if (request.dimension == SamplerDimension::TexCube) {
    plane.has_faces = true;
    plane.mode_u = plane.mode_v = Address::Clamp;
    for (int lane = 0; lane < 64; ++lane) {
      const FacePoint point =
          face_point({request.rows[0][lane], request.rows[1][lane], request.rows[2][lane]});
      plane.u[lane] = point.u;
      plane.v[lane] = point.v;
      plane.face[lane] = point.face;
    }
    return;
  }
  plane.mode_u = binding.state.u;
  plane.mode_v = binding.state.v;
  for (std::size_t i = 0; i < 64; i += hn::Lanes(D())) {
    hn::Store(fold(plane.mode_u, hn::LoadU(D(), request.rows[0] + i)), D(), plane.u + i);
    hn::Store(fold(plane.mode_v, hn::LoadU(D(), request.rows[1] + i)), D(), plane.v + i);
  }
}

FetchCost fetch_lanes(const SamplerBinding& binding, const FetchRequest& request, bool masked,
                      const number::Grid& grid, const std::array<double*, 4>& results) {
  LaneChoices choices;
  choose_levels(binding, request, choices);
  PlaneLanes plane;
  find_places(binding, request, plane);
  const Filter64 filter{binding, plane, choices, grid, results};
  std::uint64_t open = request.exec;
  if (!masked) {  // nobody reads the other lanes, but they stay numbers
    if (open != ~std::uint64_t{0})
      for (double* const row : results)
        if (row != nullptr) std::fill_n(row, 64, 0.0);
  }
  while (open != 0) {
    const std::int64_t key = choices.key[std::countr_zero(open)];
    const std::uint64_t lanes = open & lanes_of_key(choices, key);
    open &= ~lanes;
    const auto level = static_cast<std::size_t>(key >> 1);
    (key & 1) != 0 ? filter_lanes<true>(filter, level, lanes) : filter_lanes<false>(filter, level, lanes);
  }
  const std::uint64_t billed = request.exec & request.covered;
  const auto fetches = static_cast<std::uint64_t>(std::popcount(billed));
  return {fetches, fetches + static_cast<std::uint64_t>(std::popcount(billed & choices.blended))};
}

#endif  // HWY_TARGET == HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace aluminate::vm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace aluminate::vm {
HWY_EXPORT(fetch_lanes);

FetchCost fetch(const SamplerBinding& binding, const FetchRequest& request, bool masked,
                const number::Grid& grid, const std::array<double*, 4>& results) noexcept {
  if (!has_shape(binding.texture, request.dimension) || request.dimension == SamplerDimension::Tex3D)
    return fetch_reference(binding, request, masked, grid, results);
  return HWY_DYNAMIC_DISPATCH(fetch_lanes)(binding, request, masked, grid, results);
}

}  // namespace aluminate::vm
#endif
