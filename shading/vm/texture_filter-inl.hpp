// Places of texels and their weighted sums, in vectors: four lanes where vectors have 256 bits or more, two
// otherwise.
//   in   folded places of a quad on one level, the level's texels
//   out  Taps: addresses and weights; then per channel the weighted sum of the four texels, scaled by 2^16,
//   exact
// A pair of neighbouring texels is one load. Two lanes share a vector from there on, each in a 128-bit block,
// all four channels side by side: gathers, which would keep lanes apart, made a fetch half as long again on an AVX2 core.
// Included once per instruction set, see simd_lanes-inl.hpp.
#if defined(ALUMINATE_TEXTURE_FILTER) == defined(HWY_TARGET_TOGGLE)
#ifdef ALUMINATE_TEXTURE_FILTER
#undef ALUMINATE_TEXTURE_FILTER
#else
#define ALUMINATE_TEXTURE_FILTER
#endif

#include <cstring>

#include "shading/vm/simd_lanes-inl.hpp"
#include "shading/vm/texture.hpp"

#ifndef ALUMINATE_TEXTURE_LEVELS
#define ALUMINATE_TEXTURE_LEVELS
namespace aluminate::vm {

// A level as the filter wants it, spread over vectors of four lanes. Two 32-bit numbers a lane: x low, y
// high.
struct FilterLevel {
  alignas(32) double scale_u[4];  // 256 * size
  alignas(32) double scale_v[4];
  alignas(32) std::int32_t step[8];  // bytes of a texel and of a row
  alignas(
      32) std::int32_t inside[8];  // size - 1 - 2^31: first neighbours below it, unsigned, have a second one
  alignas(32) std::uint64_t texels[4];  // address of the first one
  std::size_t pitch = 0;                // bytes of a row
  std::size_t slice = 0;                // bytes of a face
  int width = 0, height = 0;
  bool wraps_u = false, wraps_v = false;
};

}  // namespace aluminate::vm
#endif

HWY_BEFORE_NAMESPACE();
namespace aluminate::vm {
namespace HWY_NAMESPACE {

using Q = hn::CappedTag<double, 4>;
inline constexpr std::size_t kQuadStep = hn::MaxLanes(Q());
static_assert(kQuadStep == 2 || kQuadStep == 4);
using QV = hn::Vec<Q>;
using Q64 = hn::RebindToUnsigned<Q>;
using Q32 = hn::Repartition<std::int32_t, Q>;
using QU32 = hn::Repartition<std::uint32_t, Q>;
using Q16 = hn::Repartition<std::int16_t, Q>;
using Q64I = hn::RebindToSigned<Q>;
using Pairs = hn::Vec<Q32>;  // x low and y high of each lane; or the channels of lanes

// Constants as vectors in memory: compilers would rather assemble each one anew for every quad.
struct FilterConstants {
  FilterConstants() {
    hn::Store(hn::Set(Q64(), std::uint64_t{0xffffffff}), Q64(), low_half);
    hn::Store(hn::Set(Q32(), 255), Q32(), byte);
    hn::Store(hn::Set(Q32(), 256), Q32(), one);
    hn::Store(hn::Set(Q32(), std::int32_t{-0x7fffffff - 1}), Q32(), sign);
  }
  alignas(32) std::uint64_t low_half[4];
  alignas(32) std::int32_t byte[8], one[8], sign[8];
};

// Where the texels of a quad are on one level. Complete in itself, so that all quads of a fetch are located
// before the first texel is read: one chain of dependent steps from coordinate to result would be longer than
// a core looks ahead.
template <std::size_t kTexelBytes>
struct Taps {
  alignas(32) const std::uint8_t* texels[kQuadStep];  // the upper left one of each lane
  alignas(32) std::int32_t weight[2 * kQuadStep];     // of the right and of the lower ones, 0..255
  std::size_t pitch;                                  // bytes from there to the lower ones
};

// Texels that are not side by side in memory, brought together: [lane][row][column].
template <std::size_t kTexelBytes>
struct EdgeTexels {
  std::uint8_t texels[kQuadStep][2][2 * kTexelBytes];
};

template <std::size_t kTexelBytes, bool kLinear>
HWY_NOINLINE void bring_together(const FilterLevel& level, Pairs first_texels, EdgeTexels<kTexelBytes>& edge,
                                 Taps<kTexelBytes>& taps) {
  alignas(32) std::int32_t first[2 * kQuadStep];
  hn::Store(first_texels, Q32(), first);
  const auto placed = [](int texel, int size, bool wraps) {  // texel: -1 .. size
    const int last = size - 1;
    return static_cast<std::size_t>(texel < 0       ? (wraps ? last : 0)
                                    : texel <= last ? texel
                                    : wraps         ? 0
                                                    : last);
  };
  for (std::size_t lane = 0; lane < kQuadStep; ++lane) {
    const int x = first[2 * lane], y = first[2 * lane + 1];
    // The address counts from the face's first texel, modulo 2^32 where the corner lies before it.
    const std::uint8_t* const face =
        taps.texels[lane] - static_cast<std::uint32_t>(x * level.step[0] + y * level.step[1]);
    for (int j = 0; j < (kLinear ? 2 : 1); ++j)
      for (int i = 0; i < (kLinear ? 2 : 1); ++i)
        std::memcpy(edge.texels[lane][j] + static_cast<std::size_t>(i) * kTexelBytes,
                    face + placed(y + j, level.height, level.wraps_v) * level.pitch +
                        placed(x + i, level.width, level.wraps_u) * kTexelBytes,
                    kTexelBytes);
    taps.texels[lane] = edge.texels[lane][0];
  }
  taps.pitch = 2 * kTexelBytes;
}

// Positions are at most 256 * 2^14 and corners at least -128: they fit the low half of the shifted binary64,
// where (x + M) - 128 is x + (M - 128), as 128 is even. Offsets in a face are below 8 * 2^14 * 2^14.
template <std::size_t kTexelBytes, bool kFaces, bool kLinear>
HWY_INLINE void locate(const FilterConstants& k, const FilterLevel& level, QV u, QV v,
                       const std::int64_t* faces, EdgeTexels<kTexelBytes>& edge, Taps<kTexelBytes>& taps) {
  static_assert(256LL * (1 << 14) < (1LL << 31) && 8LL * (1 << 14) * (1 << 14) <= (1LL << 31));
  const QV to_corner = hn::Set(Q(), number::kToInteger - (kLinear ? 128.0 : 0.0));
  const auto x = hn::BitCast(Q64(), hn::Add(hn::Mul(u, hn::Load(Q(), level.scale_u)), to_corner));
  const auto y = hn::BitCast(Q64(), hn::Add(hn::Mul(v, hn::Load(Q(), level.scale_v)), to_corner));
  const Pairs corner = hn::OddEven(hn::BitCast(Q32(), hn::ShiftLeft<32>(y)), hn::BitCast(Q32(), x));
  hn::Store(hn::And(corner, hn::Load(Q32(), k.byte)), Q32(), taps.weight);
  const Pairs first = hn::ShiftRight<8>(corner);
  const auto steps = hn::BitCast(Q64(), hn::Mul(first, hn::Load(Q32(), level.step)));
  const auto offset = hn::And(hn::Add(steps, hn::ShiftRight<32>(steps)), hn::Load(Q64(), k.low_half));
  auto texels = hn::Add(offset, hn::Load(Q64(), level.texels));
  if constexpr (kFaces) {
    const auto face = hn::BitCast(QU32(), hn::LoadU(Q64I(), faces));
    texels = hn::Add(texels, hn::MulEven(face, hn::Set(QU32(), static_cast<std::uint32_t>(level.slice))));
  }
  hn::Store(texels, Q64(), reinterpret_cast<std::uint64_t*>(taps.texels));
  taps.pitch = level.pitch;
  const Pairs biased = hn::Xor(first, hn::Load(Q32(), k.sign));
  if (HWY_UNLIKELY(!hn::AllTrue(Q32(), hn::Lt(biased, hn::Load(Q32(), level.inside)))))
    bring_together<kTexelBytes, kLinear>(level, first, edge, taps);
}

// Channels of two neighbouring texels (kCount 2) or of one, of lanes `of[0]` and, in the upper block,
// `of[2]`.
template <std::size_t kTexelBytes, std::size_t kCount>
HWY_INLINE hn::Vec<Q16> channels_at(const std::uint8_t* const* of) {
  constexpr std::size_t kBytes = kTexelBytes * kCount;
  const hn::FixedTag<std::uint8_t, kBytes> d;
  const hn::FixedTag<std::uint8_t, 2 * kTexelBytes> block;  // room for two texels
  const auto widened = [&](const std::uint8_t* from) HWY_ATTR {
    if constexpr (kCount == 2) {
      return hn::LoadU(d, from);
    } else {
      return hn::ZeroExtendVector(block, hn::LoadU(d, from));
    }
  };
  if constexpr (kTexelBytes == 8) {
    if constexpr (kQuadStep == 2) {
      return hn::BitCast(Q16(), widened(of[0]));
    } else {
      return hn::BitCast(Q16(),
                         hn::Combine(hn::Repartition<std::uint8_t, Q>(), widened(of[2]), widened(of[0])));
    }
  } else {  // codes, no sign
    using Codes = hn::Rebind<std::uint8_t, Q16>;
    if constexpr (kQuadStep == 2) {
      return hn::PromoteTo(Q16(), widened(of[0]));
    } else {
      return hn::PromoteTo(Q16(), hn::Combine(Codes(), widened(of[2]), widened(of[0])));
    }
  }
}

HWY_INLINE Pairs weighted_pairs(hn::Vec<Q16> pairs, Pairs weights) {  // a * wa + b * wb of each two numbers
  Pairs rest = hn::Zero(Q32());
  const Pairs sum =
      hn::ReorderWidenMulAccumulate(Q32(), pairs, hn::BitCast(Q16(), weights), hn::Zero(Q32()), rest);
  return hn::RearrangeToOddPlusEven(sum, rest);
}

// Four channels of even lanes (lane 0 in the low, lane 2 in the high block) and of odd ones, 2^16 times a
// filter texel: within [-2^31, 2^31).
struct Channels {
  Pairs even, odd;
};

// Four texels each. |left|, |right| <= 2^15 * 256 = 2^23. (right - left) * w may pass 2^31, the sum does not:
// exact modulo 2^32.
HWY_INLINE Pairs bilinear(hn::Vec<Q16> top, hn::Vec<Q16> bottom, Pairs down, Pairs across) {
  static_assert((1LL << 15) * 256 * 256 <= (1LL << 31));
  const Pairs left = weighted_pairs(hn::InterleaveLower(Q16(), top, bottom), down);
  const Pairs right = weighted_pairs(hn::InterleaveUpper(Q16(), top, bottom), down);
  return hn::Add(hn::ShiftLeft<8>(left), hn::Mul(across, hn::Sub(right, left)));
}

template <std::size_t kTexelBytes, bool kLinear>
HWY_INLINE Channels filtered(const FilterConstants& k, const Taps<kTexelBytes>& taps) {
  if constexpr (kLinear) {
    const std::uint8_t* bottom[kQuadStep];
    for (std::size_t lane = 0; lane < kQuadStep; ++lane) bottom[lane] = taps.texels[lane] + taps.pitch;
    // 256 - w and w as a pair of 16-bit numbers.
    const Pairs weight = hn::Load(Q32(), taps.weight);
    const Pairs down = hn::Or(hn::Sub(hn::Load(Q32(), k.one), weight), hn::ShiftLeft<16>(weight));
    return {bilinear(channels_at<kTexelBytes, 2>(taps.texels), channels_at<kTexelBytes, 2>(bottom),
                     hn::Broadcast<1>(down), hn::Broadcast<0>(weight)),
            bilinear(channels_at<kTexelBytes, 2>(taps.texels + 1), channels_at<kTexelBytes, 2>(bottom + 1),
                     hn::Broadcast<3>(down), hn::Broadcast<2>(weight))};
  } else {
    const auto lifted = [](hn::Vec<Q16> texel) HWY_ATTR {
      return hn::BitCast(Q32(), hn::InterleaveLower(Q16(), hn::Zero(Q16()), texel));
    };
    return {lifted(channels_at<kTexelBytes, 1>(taps.texels)),
            lifted(channels_at<kTexelBytes, 1>(taps.texels + 1))};
  }
}

// Sums of two levels, 64 bits: red and blue of a lane, then green and alpha, of even and of odd lanes.
struct Sums {
  hn::Vec<Q64I> red_blue_even, red_blue_odd, green_alpha_even, green_alpha_odd;

  // One channel of the quad's lanes.
  template <std::size_t kChannel>
  HWY_INLINE hn::Vec<Q64I> channel() const {
    const auto even = kChannel % 2 == 0 ? red_blue_even : green_alpha_even;
    const auto odd = kChannel % 2 == 0 ? red_blue_odd : green_alpha_odd;
    return kChannel < 2 ? hn::InterleaveLower(Q64I(), even, odd) : hn::InterleaveUpper(Q64I(), even, odd);
  }
};

// weight: of each lane, 0..256. |sums| <= 2^31 * 2^8.
HWY_INLINE Sums weighted(const Channels& of, hn::Vec<Q64I> weight) {
  const Pairs even = hn::BitCast(Q32(), hn::InterleaveLower(Q64I(), weight, weight));
  const Pairs odd = hn::BitCast(Q32(), hn::InterleaveUpper(Q64I(), weight, weight));
  const auto upper = [](Pairs x)
                         HWY_ATTR { return hn::BitCast(Q32(), hn::ShiftRight<32>(hn::BitCast(Q64(), x))); };
  return {hn::MulEven(of.even, even), hn::MulEven(of.odd, odd), hn::MulEven(upper(of.even), even),
          hn::MulEven(upper(of.odd), odd)};
}

HWY_INLINE Sums sum_of(const Sums& a, const Sums& b) {
  return {hn::Add(a.red_blue_even, b.red_blue_even), hn::Add(a.red_blue_odd, b.red_blue_odd),
          hn::Add(a.green_alpha_even, b.green_alpha_even), hn::Add(a.green_alpha_odd, b.green_alpha_odd)};
}

}  // namespace HWY_NAMESPACE
}  // namespace aluminate::vm
HWY_AFTER_NAMESPACE();

#endif
