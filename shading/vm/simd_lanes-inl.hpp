// Vectors of 64-bit lanes for code that is compiled once per instruction set: included inside foreach_target, so the
// guard toggles with the target. What Highway lacks or rounds differently is here, with the bits of the scalar definition.
#if defined(ALUMINATE_SIMD_LANES) == defined(HWY_TARGET_TOGGLE)
#ifdef ALUMINATE_SIMD_LANES
#undef ALUMINATE_SIMD_LANES
#else
#define ALUMINATE_SIMD_LANES
#endif

#include <hwy/highway.h>

#include <bit>
#include <cmath>
#include <cstdint>

#include "platform/number/scalar.hpp"

HWY_BEFORE_NAMESPACE();
namespace aluminate::vm {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// 64 lanes in steps of one vector. Capped at 8 lanes (512 bits) so that a mask step fits one byte.
using D = hn::CappedTag<double, 8>;
using U = hn::RebindToUnsigned<D>;
using F = hn::Rebind<float, D>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

HWY_INLINE V constant(double x) { return hn::Set(D(), x); }

// Of any vector of binary64, so that code of a narrower step can share them.
template <class T>
HWY_INLINE T fma(T a, T b, T c) {
#if HWY_NATIVE_FMA
  return hn::MulAdd(a, b, c);
#else
  const hn::DFromV<T> d;
  HWY_ALIGN double x[hn::MaxLanes(d)], y[hn::MaxLanes(d)], z[hn::MaxLanes(d)];
  hn::Store(a, d, x);
  hn::Store(b, d, y);
  hn::Store(c, d, z);
  for (std::size_t i = 0; i < hn::Lanes(d); ++i) z[i] = std::fma(x[i], y[i], z[i]);
  return hn::Load(d, z);
#endif
}
HWY_INLINE V negative_fma(V a, V b, V c) {  // c - a*b
#if HWY_NATIVE_FMA
  return hn::NegMulAdd(a, b, c);
#else
  return fma(hn::Xor(a, constant(-0.0)), b, c);
#endif
}

// Highway's portable rounding loses the sign of zero; libm's does not.
template <class T>
HWY_INLINE T floor_of(T a) {
#if HWY_NATIVE_FMA
  return hn::Floor(a);
#else
  const hn::DFromV<T> d;
  HWY_ALIGN double x[hn::MaxLanes(d)];
  hn::Store(a, d, x);
  for (std::size_t i = 0; i < hn::Lanes(d); ++i) x[i] = std::floor(x[i]);
  return hn::Load(d, x);
#endif
}
HWY_INLINE V trunc_of(V a) {
#if HWY_NATIVE_FMA
  return hn::Trunc(a);
#else
  HWY_ALIGN double x[hn::MaxLanes(D())];
  hn::Store(a, D(), x);
  for (std::size_t i = 0; i < hn::Lanes(D()); ++i) x[i] = std::trunc(x[i]);
  return hn::Load(D(), x);
#endif
}

HWY_INLINE V less_of(V a, V b) { return hn::IfThenElse(hn::Lt(a, b), a, b); }     // a < b ? a : b
HWY_INLINE V greater_of(V a, V b) { return hn::IfThenElse(hn::Gt(a, b), a, b); }  // a > b ? a : b

HWY_INLINE M mask_at(std::uint64_t mask, std::size_t i) {
  const std::uint64_t bits = mask >> i;
  return hn::LoadMaskBits(D(), reinterpret_cast<const std::uint8_t*>(&bits));
}

template <std::size_t N>
HWY_INLINE V horner(const double (&coefficient)[N], V x) {
  V sum = constant(coefficient[N - 1]);
  for (std::size_t i = N - 1; i-- > 0;) sum = fma(sum, x, constant(coefficient[i]));
  return sum;
}

// number::log2 without its last rounding: 2^e m with m in [sqrt(1/2), sqrt(2)), then e + s q(s^2). x > 0.
template <bool kReference>
HWY_INLINE V log2_unrounded(V x) {
  const auto bias = hn::Set(U(), std::uint64_t{1024} << 52);
  const auto split = hn::Set(U(), std::bit_cast<std::uint64_t>(number::kSqrtHalf) - (std::uint64_t{1024} << 52));
  const auto bits = hn::BitCast(U(), x);
  const auto biased = hn::ShiftRight<52>(hn::Sub(bits, split));
  const V m = hn::BitCast(D(), hn::Add(hn::Sub(bits, hn::ShiftLeft<52>(biased)), bias));
  const auto integer = hn::Or(biased, hn::Set(U(), std::bit_cast<std::uint64_t>(0x1p52)));
  const V e = hn::Sub(hn::BitCast(D(), integer), constant(0x1p52 + 1024.0));
  const V s = hn::Div(hn::Sub(m, constant(1.0)), hn::Add(m, constant(1.0)));
  const V z = hn::Mul(s, s);
  const V q = kReference ? horner(number::kLog2Reference, z) : horner(number::kLog2, z);
  return fma(s, q, e);
}

}  // namespace HWY_NAMESPACE
}  // namespace aluminate::vm
HWY_AFTER_NAMESPACE();

#endif
