// x = 2^k m with m in [sqrt(1/2), sqrt(2)), and x^e = 2^(e (k + log2 m)), both by their series. With s = (m-1)/(m+1), at most
// 0.172: that of log2 ends at s^19, what follows is 0.172^20/21 = 2e-17 of it; that of 2^f, |f| <= 1/2, ends at f^13, what
// follows is (ln2/2)^14/14! = 4e-18. The rest is rounding of the exponent, 100 * 2^-53 * ln2 = 8e-15, a few times.
#include "calibration/power.hpp"

#include <algorithm>
#include <cstdint>
#include <numbers>

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calibration/power.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace aluminate::calibration::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::ScalableTag<double>;
using BitsTag = hn::RebindToUnsigned<Tag>;
constexpr Tag kTag;
constexpr BitsTag kBits;
constexpr std::size_t kLanes = hn::MaxLanes(Tag());

// Never MulAdd: fused on some units, two roundings on others.
template <class V>
HWY_INLINE V power(V x, V exponent) {
  constexpr std::uint64_t kOne = 0x3FF0'0000'0000'0000u, kSqrtHalf = 0x3FE6'A09E'667F'3BCDu, kTwo52 = 0x4330'0000'0000'0000u;
  const auto set = [](double value) HWY_ATTR { return hn::Set(kTag, value); };
  const auto bits = hn::BitCast(kBits, x);
  const auto biased = hn::ShiftRight<52>(hn::Add(bits, hn::Set(kBits, kOne - kSqrtHalf)));  // k + 1023
  const V m = hn::BitCast(kTag, hn::Add(hn::Sub(bits, hn::ShiftLeft<52>(biased)), hn::Set(kBits, kOne)));
  // An integer below 2^52 behind 2^52's exponent is the sum of both.
  const V k = hn::Sub(hn::BitCast(kTag, hn::Or(biased, hn::Set(kBits, kTwo52))), set(0x1p52 + 1023));
  const V s = hn::Div(hn::Sub(m, set(1.0)), hn::Add(m, set(1.0))), s2 = hn::Mul(s, s);
  constexpr double kScale = 2.0 / std::numbers::ln2;
  V log2m = set(kScale / 19);
  for (const double c : {kScale / 17, kScale / 15, kScale / 13, kScale / 11, kScale / 9, kScale / 7, kScale / 5, kScale / 3, kScale})
    log2m = hn::Add(hn::Mul(log2m, s2), set(c));
  const V at = hn::Min(hn::Max(hn::Mul(exponent, hn::Add(k, hn::Mul(s, log2m))), set(-1000.0)), set(1000.0));
  const V magic = set(0x1.8p52), whole = hn::Add(at, magic);  // its low bits are the integer nearest to `at`
  const V f = hn::Mul(hn::Sub(at, hn::Sub(whole, magic)), set(std::numbers::ln2));
  V exp = set(1.0 / 6227020800.0);  // 1/13!, 1/12!, ...
  for (const double c : {1.0 / 479001600, 1.0 / 39916800, 1.0 / 3628800, 1.0 / 362880, 1.0 / 40320, 1.0 / 5040, 1.0 / 720,
                         1.0 / 120, 1.0 / 24, 1.0 / 6, 0.5, 1.0, 1.0})
    exp = hn::Add(hn::Mul(exp, f), set(c));
  const V scaled = hn::BitCast(kTag, hn::Add(hn::BitCast(kBits, exp), hn::ShiftLeft<52>(hn::BitCast(kBits, whole))));
  return hn::IfThenElseZero(hn::Gt(x, hn::Zero(kTag)), scaled);
}

void RaiseTo(double exponent, double* values, std::size_t count) {
  const auto e = hn::Set(kTag, exponent);
  const auto raise = [&](double* at) HWY_ATTR {
    const auto x = hn::LoadU(kTag, at);
    hn::StoreU(hn::CopySign(power(hn::Abs(x), e), x), kTag, at);
  };
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) raise(values + i);
  if (i == count) return;
  double rest[kLanes] = {};
  std::copy(values + i, values + count, rest);
  raise(rest);
  std::copy_n(rest, count - i, values + i);
}

}  // namespace aluminate::calibration::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace aluminate::calibration {

HWY_EXPORT(RaiseTo);
void raise_to(double exponent, double* values, std::size_t count) noexcept { HWY_DYNAMIC_DISPATCH(RaiseTo)(exponent, values, count); }

}  // namespace aluminate::calibration
#endif
