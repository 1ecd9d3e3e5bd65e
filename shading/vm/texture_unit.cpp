// The texture unit on vectors: coordinates in binary64, texels as four 16-bit channels of one 64-bit lane. Same integers
// as texture_unit_reference.cpp; lanes of a vector that need different levels are done level by level and blended.
#include "shading/vm/texture_unit.hpp"

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/vm/texture_unit.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <bit>

#include "shading/vm/simd_lanes-inl.hpp"

#ifndef ALUMINATE_TEXTURE_LANES
#define ALUMINATE_TEXTURE_LANES
namespace aluminate::vm {
// What each lane samples, decided before any texel is read.
struct LaneChoices {
  alignas(64) std::int64_t key[64];       // 2 * level + (1 if linear)
  alignas(64) std::int64_t fraction[64];  // weight of the next level in 1/256
};
}  // namespace aluminate::vm
#endif

HWY_BEFORE_NAMESPACE();
namespace aluminate::vm {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

// One lane at a time there is nothing to gain.
FetchCost fetch_lanes(const SamplerBinding& binding, const FetchRequest& request, bool masked, const number::Grid& grid,
                      const std::array<double*, 4>& results) {
  return fetch_reference(binding, request, masked, grid, results);
}

#else

using I = hn::RebindToSigned<D>;
using IV = hn::Vec<I>;
using UV = hn::Vec<U>;
using U32 = hn::Repartition<std::uint32_t, D>;

// Level of detail of all 16 quads, times 256; level_of_detail() in vectors.
void quad_details(const double* u, const double* v, int width, int height, std::int64_t* lods) {
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
  const V to_integer = constant(number::kToInteger);
  for (std::size_t q = 0; q < 16; q += hn::Lanes(D())) {
    const V x = greater_of(hn::Load(D(), rho2 + q), constant(0x1p-60));
    const V rounded = hn::Add(hn::Mul(constant(128.0), log2_unrounded<true>(x)), to_integer);
    hn::Store(hn::Sub(hn::BitCast(I(), rounded), hn::BitCast(I(), to_integer)), I(), lods + q);
  }
}

HWY_INLINE V fold(Address mode, V u) {
  switch (mode) {
    case Address::Wrap: return hn::Sub(u, floor_of(u));
    case Address::Clamp: {
      const V low = hn::IfThenElse(hn::Lt(u, hn::Zero(D())), hn::Zero(D()), u);
      return hn::IfThenElse(hn::Gt(low, constant(1.0)), constant(1.0), low);
    }
    case Address::Mirror: break;
  }
  const V t = hn::Sub(u, hn::Mul(constant(2.0), floor_of(hn::Mul(constant(0.5), u))));
  return hn::IfThenElse(hn::Gt(t, constant(1.0)), hn::Sub(constant(2.0), t), t);
}

HWY_INLINE IV to_texel(Address mode, IV x, std::int64_t size) {
  const IV count = hn::Set(I(), size), zero = hn::Zero(I());
  const auto below = hn::Lt(x, zero), beyond = hn::Gt(x, hn::Set(I(), size - 1));
  if (mode == Address::Wrap)
    return hn::IfThenElse(below, hn::Add(x, count), hn::IfThenElse(beyond, hn::Sub(x, count), x));
  return hn::IfThenElse(below, zero, hn::IfThenElse(beyond, hn::Set(I(), size - 1), x));
}

struct AxisLanes {
  IV first, second;  // texels
  UV weight;         // of the second, in both 32-bit halves of a lane
};

HWY_INLINE AxisLanes locate(Address mode, bool linear, V folded, int size) {
  const V to_integer = constant(number::kToInteger);
  const V scaled = hn::Add(hn::Mul(folded, constant(256.0 * size)), to_integer);
  const IV position = hn::Sub(hn::BitCast(I(), scaled), hn::BitCast(I(), to_integer));
  const IV corner = hn::Sub(position, hn::Set(I(), linear ? 128 : 0));
  const IV texel = hn::ShiftRight<8>(corner);
  const UV weight = hn::And(hn::BitCast(U(), corner), hn::Set(U(), std::uint64_t{linear ? 255u : 0u}));
  return {to_texel(mode, texel, size), to_texel(mode, hn::Add(texel, hn::Set(I(), 1)), size),
          hn::Or(weight, hn::ShiftLeft<32>(weight))};
}

// (256 - w) a + w b in each 32-bit half; <= 65535 * 2^16 < 2^32 after both directions.
HWY_INLINE UV blend(UV a, UV b, UV weight) {
  const auto a32 = hn::BitCast(U32(), a), b32 = hn::BitCast(U32(), b), w = hn::BitCast(U32(), weight);
  return hn::BitCast(U(), hn::Add(hn::ShiftLeft<8>(a32), hn::Mul(w, hn::Sub(b32, a32))));  // modulo 2^32: exact
}

struct Channels {
  UV even, odd;  // R and B, G and A in the 32-bit halves; scaled by 2^16
};

HWY_INLINE Channels bilinear(const Texture& texture, const SamplerState& state, std::size_t level, bool linear, V u, V v) {
  const MipLevel& mip = texture.levels()[level];
  const std::uint64_t* const texels = texture.linear_texels(level);
  const AxisLanes x = locate(state.u, linear, u, mip.width), y = locate(state.v, linear, v, mip.height);
  const auto width = hn::Set(U32(), static_cast<std::uint32_t>(mip.width));
  const auto row = [&](IV texel) HWY_ATTR {  // y * width < 2^28
    return hn::BitCast(I(), hn::MulEven(hn::BitCast(U32(), texel), width));
  };
  const auto at = [&](IV offset, IV column) HWY_ATTR {
    return hn::GatherIndex(U(), texels, hn::Add(offset, column));
  };
  const UV low = hn::Set(U(), std::uint64_t{0x0000ffff0000ffff});
  const IV top = row(y.first);
  UV t0 = at(top, x.first);
  if (!linear) return {hn::ShiftLeft<16>(hn::And(t0, low)), hn::AndNot(low, t0)};  // weight 256 * 256
  const IV bottom = row(y.second);
  const UV t1 = at(top, x.second), t2 = at(bottom, x.first), t3 = at(bottom, x.second);
  const auto even = [&](UV t) HWY_ATTR { return hn::And(t, low); };
  const auto odd = [&](UV t) HWY_ATTR { return hn::And(hn::ShiftRight<16>(t), low); };
  return {blend(blend(even(t0), even(t1), x.weight), blend(even(t2), even(t3), x.weight), y.weight),
          blend(blend(odd(t0), odd(t1), x.weight), blend(odd(t2), odd(t3), x.weight), y.weight)};
}

// Sums below 2^40 to binary64, exactly.
HWY_INLINE V to_double(UV sum) {
  return hn::Sub(hn::BitCast(D(), hn::Or(sum, hn::BitCast(U(), constant(0x1p52)))), constant(0x1p52));
}

void filter_lanes(const SamplerBinding& binding, const FetchRequest& request, bool masked, const number::Grid& grid,
                  const std::array<double*, 4>& results, const LaneChoices& choices) {
  const Texture& texture = *binding.texture;
  const V magic = constant(grid.magic), scale = constant(0x1p-24 / 65535.0);
  for (std::size_t i = 0; i < 64; i += hn::Lanes(D())) {
    const V u = fold(binding.state.u, hn::LoadU(D(), request.rows[0] + i));
    const V v = fold(binding.state.v, hn::LoadU(D(), request.rows[1] + i));
    const IV keys = hn::Load(I(), choices.key + i);
    const UV fraction = hn::BitCast(U(), hn::Load(I(), choices.fraction + i));
    const UV rest = hn::Sub(hn::Set(U(), std::uint64_t{256}), fraction);
    UV sums[4] = {hn::Zero(U()), hn::Zero(U()), hn::Zero(U()), hn::Zero(U())};

    auto open = hn::Eq(keys, keys);  // lanes without a result yet
    for (std::size_t lane = i; !hn::AllFalse(I(), open); ++lane) {
      const std::int64_t key = choices.key[lane];
      const auto mine = hn::And(open, hn::Eq(keys, hn::Set(I(), key)));
      if (hn::AllFalse(I(), mine)) continue;
      open = hn::AndNot(mine, open);
      const auto level = static_cast<std::size_t>(key >> 1);
      const bool linear = (key & 1) != 0;
      const Channels fine = bilinear(texture, binding.state, level, linear, u, v);
      const bool blended = !hn::AllTrue(I(), hn::Or(hn::Not(mine), hn::Eq(hn::BitCast(I(), fraction), hn::Zero(I()))));
      const Channels coarse = blended ? bilinear(texture, binding.state, level + 1, linear, u, v) : fine;
      const auto weigh = [&](UV a, UV b) HWY_ATTR {  // the low 32-bit halves; < 2^40
        const auto a32 = hn::BitCast(U32(), a), b32 = hn::BitCast(U32(), b);
        return hn::Add(hn::MulEven(a32, hn::BitCast(U32(), rest)), hn::MulEven(b32, hn::BitCast(U32(), fraction)));
      };
      const UV parts[4] = {weigh(fine.even, coarse.even), weigh(fine.odd, coarse.odd),
                           weigh(hn::ShiftRight<32>(fine.even), hn::ShiftRight<32>(coarse.even)),
                           weigh(hn::ShiftRight<32>(fine.odd), hn::ShiftRight<32>(coarse.odd))};
      const auto select = hn::RebindMask(U(), mine);
      for (std::size_t c = 0; c < 4; ++c) sums[c] = hn::IfThenElse(select, parts[c], sums[c]);
    }

    for (std::size_t c = 0; c < 4; ++c) {
      if (results[c] == nullptr) continue;
      const V texel = hn::Sub(fma(to_double(sums[c]), scale, magic), magic);
      if (masked) {
        hn::BlendedStore(texel, mask_at(request.exec, i), D(), results[c] + i);
      } else {
        hn::StoreU(texel, D(), results[c] + i);
      }
    }
  }
}

FetchCost fetch_lanes(const SamplerBinding& binding, const FetchRequest& request, bool masked, const number::Grid& grid,
                      const std::array<double*, 4>& results) {
  const MipLevel& base = binding.texture->levels().front();
  const std::size_t levels = binding.texture->levels().size();
  LaneChoices choices;
  std::uint64_t blended = 0;
  const auto choose = [&](int first, int count, std::int32_t lod) {
    const MipChoice mip = choose_mip(binding.state, levels, lod);
    for (int lane = first; lane < first + count; ++lane) {
      choices.key[lane] = 2 * mip.level + (mip.filter == Filter::Linear ? 1 : 0);
      choices.fraction[lane] = mip.fraction;
      if (mip.fraction != 0) blended |= std::uint64_t{1} << lane;
    }
  };
  const auto row = [&](std::size_t r, int lane) { return request.rows[r][lane]; };
  if (request.op == Opcode::TexLod) {
    for (int lane = 0; lane < 64; ++lane) choose(lane, 1, to_lod(row(2, lane)));
  } else if (request.op == Opcode::TexGrad) {
    for (int lane = 0; lane < 64; ++lane)
      choose(lane, 1, level_of_detail(row(2, lane), row(3, lane), row(4, lane), row(5, lane), base.width, base.height));
  } else {
    alignas(64) std::int64_t lods[16];
    quad_details(request.rows[0], request.rows[1], base.width, base.height, lods);
    for (int quad = 0; quad < 16; ++quad) {
      const auto lod = static_cast<std::int32_t>(lods[quad]);
      if (request.op == Opcode::Tex) {
        choose(4 * quad, 4, lod);
      } else {
        for (int lane = 4 * quad; lane < 4 * quad + 4; ++lane) choose(lane, 1, lod + to_lod(row(2, lane)));
      }
    }
  }
  filter_lanes(binding, request, masked, grid, results, choices);
  const std::uint64_t billed = request.exec & request.covered;
  const auto fetches = static_cast<std::uint64_t>(std::popcount(billed));
  return {fetches, fetches + static_cast<std::uint64_t>(std::popcount(billed & blended))};
}

#endif  // HWY_TARGET == HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace aluminate::vm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace aluminate::vm {
HWY_EXPORT(fetch_lanes);

FetchCost fetch(const SamplerBinding& binding, const FetchRequest& request, bool masked, const number::Grid& grid,
                const std::array<double*, 4>& results) noexcept {
  if (binding.texture == nullptr) return fetch_reference(binding, request, masked, grid, results);
  return HWY_DYNAMIC_DISPATCH(fetch_lanes)(binding, request, masked, grid, results);
}

}  // namespace aluminate::vm
#endif
