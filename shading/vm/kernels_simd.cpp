// Elementwise kernels, compiled once per instruction set. Each repeats the scalar definition of the same name in
// platform/number/scalar.hpp, operation by operation: same constants, same order, fused where that is fused.
// Where the instruction set has no fused multiply-add, std::fma per lane keeps the bits.
#include "shading/vm/kernels.hpp"

// SSE without fused multiply-add gains nothing over the portable target: three targets are enough on x86.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/vm/kernels_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <bit>

#include "platform/number/scalar.hpp"
#include "shading/vm/simd_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace aluminate::vm {
namespace HWY_NAMESPACE {
// ---- where results go -------------------------------------------------------------------------------------------

template <Post kPost, bool kMasked>
class Writer {
 public:
  HWY_INLINE Writer(const Operation& op, Frame& frame) : dst_(frame.rows + op.dst), exec_(frame.exec) {}
  HWY_INLINE void put(std::size_t i, V v) {
    if constexpr (kPost == Post::Saturate) v = greater_of(less_of(v, constant(1.0)), hn::Zero(D()));
    if constexpr (kPost == Post::Range) largest_ = hn::Max(largest_, hn::Abs(v));
    if constexpr (kMasked) {
      hn::BlendedStore(v, mask_at(exec_, i), D(), dst_ + i);
    } else {
      hn::Store(v, D(), dst_ + i);
    }
  }
  HWY_INLINE void finish(const Operation& op, Frame& frame) const {
    if constexpr (kPost == Post::Range) {
      if (HWY_UNLIKELY(!hn::AllTrue(D(), hn::Le(largest_, constant(op.grid->greatest))))) enforce_range(op, frame);
    }
  }

 private:
  double* dst_;  // may be a source row too: each step loads before it stores
  std::uint64_t exec_;
  V largest_ = hn::Zero(D());
};

// ---- where operands come from -----------------------------------------------------------------------------------

template <bool kConstant>
class Reader {
 public:
  HWY_INLINE Reader(const Frame& frame, const Operand& operand)
      : from_(frame.base[static_cast<int>(operand.space)] + operand.offset) {
    if constexpr (kConstant) value_ = constant(*from_);
  }
  HWY_INLINE V at(std::size_t i) const {
    if constexpr (kConstant) {
      return value_;
    } else {
      return hn::Load(D(), from_ + i);
    }
  }

 private:
  const double* from_;
  V value_ = hn::Zero(D());
};

// ---- definitions, one struct each -------------------------------------------------------------------------------

struct Base {
  explicit Base(const Operation& op) : magic(constant(op.grid->magic)) {}
  V round(V x) const { return hn::Sub(hn::Add(x, magic), magic); }
  V magic;
};

struct CopyOp {
  explicit CopyOp(const Operation& op)
      : keep(hn::BitCast(D(), hn::Set(U(), op.absolute ? ~(std::uint64_t{1} << 63) : ~std::uint64_t{0}))),
        flip(hn::BitCast(D(), hn::Set(U(), std::uint64_t{op.negate} << 63))) {}
  V operator()(V a) const { return hn::Xor(hn::And(a, keep), flip); }
  V keep, flip;
};
struct FrcOp {
  explicit FrcOp(const Operation&) {}
  V operator()(V a) const { return hn::Sub(a, floor_of(a)); }
};
struct FlrOp {
  explicit FlrOp(const Operation&) {}
  V operator()(V a) const { return floor_of(a); }
};
struct TruncOp {
  explicit TruncOp(const Operation&) {}
  V operator()(V a) const { return trunc_of(a); }
};

struct RcpOp : Base {
  explicit RcpOp(const Operation& op) : Base(op), beyond(constant(op.grid->beyond)) {}
  V operator()(V x) const {
    const auto one = hn::Set(F(), 1.0f);
    const V s = hn::PromoteTo(D(), hn::Div(one, hn::DemoteTo(F(), x)));
    return round(bound(fma(negative_fma(x, s, constant(1.0)), s, s)));
  }
  V bound(V y) const { return greater_of(less_of(y, beyond), hn::Xor(beyond, constant(-0.0))); }
  V beyond;
};
struct RcpReferenceOp : RcpOp {
  using RcpOp::RcpOp;
  V operator()(V x) const {
    const V y = hn::IfThenElse(hn::Eq(x, hn::Zero(D())), beyond, hn::Div(constant(1.0), x));
    return round(bound(y));
  }
};
struct RsqOp : Base {
  explicit RsqOp(const Operation& op) : Base(op), step(constant(op.operand_step)) {}
  V operator()(V x) const {
    x = greater_of(x, step);
    const auto one = hn::Set(F(), 1.0f);
    const V s = hn::PromoteTo(D(), hn::Div(one, hn::Sqrt(hn::DemoteTo(F(), x))));
    const V e = negative_fma(hn::Mul(x, s), s, constant(1.0));
    return round(fma(hn::Mul(constant(0.5), s), e, s));
  }
  V step;
};
struct RsqReferenceOp : RsqOp {
  using RsqOp::RsqOp;
  V operator()(V x) const { return hn::Div(constant(1.0), hn::Sqrt(greater_of(x, step))); }
};
struct SqrtOp : Base {
  using Base::Base;
  V operator()(V x) const { return round(hn::Sqrt(greater_of(x, hn::Zero(D())))); }
};

template <bool kReference>
struct ExpOp : Base {
  explicit ExpOp(const Operation& op)
      : Base(op), least(constant(op.grid->exp2_least)), greatest(constant(op.grid->exp2_greatest)) {}
  V operator()(V x) const {
    x = greater_of(less_of(x, greatest), least);
    const V to_integer = constant(number::kToInteger);
    const V k = hn::Add(x, to_integer);
    const V r = hn::Sub(x, hn::Sub(k, to_integer));
    const V p = kReference ? horner(number::kExp2Reference, r) : horner(number::kExp2, r);
    return round(hn::BitCast(D(), hn::Add(hn::BitCast(U(), p), hn::ShiftLeft<52>(hn::BitCast(U(), k)))));
  }
  V least, greatest;
};

template <bool kReference>
struct LogOp : Base {
  explicit LogOp(const Operation& op) : Base(op), step(constant(op.operand_step)) {}
  V operator()(V x) const { return round(log2_unrounded<kReference>(greater_of(x, step))); }
  V step;
};

template <int kQuarterTurns>
struct SineOp : Base {
  using Base::Base;
  V operator()(V x) const {
    x = greater_of(less_of(x, constant(number::kAngleGreatest)), constant(-number::kAngleGreatest));
    const V to_integer = constant(number::kToInteger);
    const V k = fma(x, constant(number::kTwoOverPi), to_integer);
    const V n = hn::Sub(k, to_integer);
    const V high = negative_fma(n, constant(number::kPiOver2High), x);
    const V r = negative_fma(n, constant(number::kPiOver2Low), high);
    const V z = hn::Mul(r, r);
    const V sine = fma(hn::Mul(r, z), horner(number::kSin, z), r);
    const V cosine = fma(z, horner(number::kCos, z), constant(1.0));
    const auto quadrant = hn::Add(hn::BitCast(U(), k), hn::Set(U(), std::uint64_t{kQuarterTurns}));
    const auto one = hn::Set(U(), std::uint64_t{1});
    const auto odd = hn::RebindMask(D(), hn::Eq(hn::And(quadrant, one), one));
    const V v = hn::IfThenElse(odd, cosine, sine);
    const auto sign = hn::ShiftLeft<62>(hn::And(quadrant, hn::Set(U(), std::uint64_t{2})));
    return round(hn::BitCast(D(), hn::Xor(hn::BitCast(U(), v), sign)));
  }
};

struct AddOp {
  explicit AddOp(const Operation&) {}
  V operator()(V a, V b) const { return hn::Add(a, b); }
};
struct SubOp {
  explicit SubOp(const Operation&) {}
  V operator()(V a, V b) const { return hn::Sub(a, b); }
};
struct AddRoundOp : Base {
  using Base::Base;
  V operator()(V a, V b) const { return hn::Sub(hn::Add(hn::Add(a, magic), b), magic); }
};
struct AddRoundSumOp : Base {
  using Base::Base;
  V operator()(V a, V b) const { return round(hn::Add(a, b)); }
};
struct MulOp : Base {
  using Base::Base;
  V operator()(V a, V b) const { return hn::Sub(fma(a, b, magic), magic); }
};
struct NegMulOp : Base {
  using Base::Base;
  V operator()(V a, V b) const { return hn::Sub(negative_fma(a, b, magic), magic); }
};
struct MinOp {
  explicit MinOp(const Operation&) {}
  V operator()(V a, V b) const { return less_of(a, b); }
};
struct MaxOp {
  explicit MaxOp(const Operation&) {}
  V operator()(V a, V b) const { return hn::IfThenElse(hn::Ge(a, b), a, b); }
};
struct SgeOp {
  explicit SgeOp(const Operation&) {}
  V operator()(V a, V b) const { return hn::IfThenElseZero(hn::Ge(a, b), constant(1.0)); }
};
struct SgtOp {
  explicit SgtOp(const Operation&) {}
  V operator()(V a, V b) const { return hn::IfThenElseZero(hn::Gt(a, b), constant(1.0)); }
};
struct SeqOp {
  explicit SeqOp(const Operation&) {}
  V operator()(V a, V b) const { return hn::IfThenElseZero(hn::Eq(a, b), constant(1.0)); }
};
struct SneOp {
  explicit SneOp(const Operation&) {}
  V operator()(V a, V b) const { return hn::IfThenZeroElse(hn::Eq(a, b), constant(1.0)); }
};

template <bool kNegProduct, bool kNegC>
struct MadOp : Base {
  using Base::Base;
  V operator()(V a, V b, V c) const {
    const V start = kNegC ? hn::Sub(magic, c) : hn::Add(magic, c);
    return hn::Sub(kNegProduct ? negative_fma(a, b, start) : fma(a, b, start), magic);
  }
};
struct CndGeOp {
  explicit CndGeOp(const Operation&) {}
  V operator()(V a, V b, V c) const { return hn::IfThenElse(hn::Ge(a, hn::Zero(D())), b, c); }
};
struct CndGtOp {
  explicit CndGtOp(const Operation&) {}
  V operator()(V a, V b, V c) const { return hn::IfThenElse(hn::Gt(a, hn::Zero(D())), b, c); }
};
struct CndEqOp {
  explicit CndEqOp(const Operation&) {}
  V operator()(V a, V b, V c) const { return hn::IfThenElse(hn::Eq(a, hn::Zero(D())), b, c); }
};
struct SaturateOp {
  explicit SaturateOp(const Operation&) {}
  V operator()(V a) const { return greater_of(less_of(a, constant(1.0)), hn::Zero(D())); }
};

// ---- drivers: one definition over 64 lanes ----------------------------------------------------------------------

template <class Op, Post kPost, bool kMasked, bool kConstA = false>
void unary(const Operation& op, Frame& frame) noexcept {
  const Op function(op);
  const Reader<kConstA> a(frame, op.src[0]);
  Writer<kPost, kMasked> out(op, frame);
  for (std::size_t i = 0; i < kLanes; i += hn::Lanes(D())) out.put(i, function(a.at(i)));
  out.finish(op, frame);
}
template <class Op, Post kPost, bool kMasked, bool kConstA, bool kConstB>
void binary(const Operation& op, Frame& frame) noexcept {
  const Op function(op);
  const Reader<kConstA> a(frame, op.src[0]);
  const Reader<kConstB> b(frame, op.src[1]);
  Writer<kPost, kMasked> out(op, frame);
  for (std::size_t i = 0; i < kLanes; i += hn::Lanes(D())) out.put(i, function(a.at(i), b.at(i)));
  out.finish(op, frame);
}
template <class Op, Post kPost, bool kMasked, bool kConstB, bool kConstC>
void ternary(const Operation& op, Frame& frame) noexcept {
  const Op function(op);
  const Reader<false> a(frame, op.src[0]);
  const Reader<kConstB> b(frame, op.src[1]);
  const Reader<kConstC> c(frame, op.src[2]);
  Writer<kPost, kMasked> out(op, frame);
  for (std::size_t i = 0; i < kLanes; i += hn::Lanes(D())) out.put(i, function(a.at(i), b.at(i), c.at(i)));
  out.finish(op, frame);
}

// Dot products: sources a0 b0 a1 b1 ..., all b constant or none; dp2add's addend follows as a row or a constant that
// was copied to one.
template <int kTerms, bool kNegative, Post kPost, bool kMasked, bool kConstB>
void dot(const Operation& op, Frame& frame) noexcept {
  const V magic = constant(op.grid->magic);
  const Reader<false> a0(frame, op.src[0]), a1(frame, op.src[2]), a2(frame, op.src[kTerms > 2 ? 4 : 0]),
      a3(frame, op.src[kTerms > 3 ? 6 : 0]);
  const Reader<kConstB> b0(frame, op.src[1]), b1(frame, op.src[3]), b2(frame, op.src[kTerms > 2 ? 5 : 1]),
      b3(frame, op.src[kTerms > 3 ? 7 : 1]);
  const Reader<false> addend(frame, op.src[kTerms == 2 ? 4 : 0]);
  const auto step = [](V a, V b, V t) HWY_ATTR { return kNegative ? negative_fma(a, b, t) : fma(a, b, t); };
  Writer<kPost, kMasked> out(op, frame);
  for (std::size_t i = 0; i < kLanes; i += hn::Lanes(D())) {
    V t = kTerms == 2 ? hn::Add(magic, addend.at(i)) : magic;
    t = step(a0.at(i), b0.at(i), t);
    t = step(a1.at(i), b1.at(i), t);
    if constexpr (kTerms > 2) t = step(a2.at(i), b2.at(i), t);
    if constexpr (kTerms > 3) t = step(a3.at(i), b3.at(i), t);
    out.put(i, hn::Sub(t, magic));
  }
  out.finish(op, frame);
}

// ---- from a key to a kernel -------------------------------------------------------------------------------------

template <class Op>
KernelFunction pick_exact_unary(const KernelKey& key) {
  if (key.src_const != 0) return nullptr;
  return key.masked ? unary<Op, Post::None, true> : unary<Op, Post::None, false>;
}
template <class Op>
KernelFunction pick_unary(const KernelKey& key) {
  if (key.src_const != 0) return nullptr;
  return key.masked ? unary<Op, Post::Range, true> : unary<Op, Post::Range, false>;
}

template <class Op, Post kPost, bool kMasked>
KernelFunction pick_binary_constants(const KernelKey& key) {
  switch (key.src_const) {
    case 0: return binary<Op, kPost, kMasked, false, false>;
    case 1: return binary<Op, kPost, kMasked, true, false>;
    case 2: return binary<Op, kPost, kMasked, false, true>;
    default: return nullptr;
  }
}
template <class Op>
KernelFunction pick_exact_binary(const KernelKey& key) {
  return key.masked ? pick_binary_constants<Op, Post::None, true>(key) : pick_binary_constants<Op, Post::None, false>(key);
}
template <class Op>
KernelFunction pick_binary(const KernelKey& key) {
  if (key.post == Post::Saturate) {
    return key.masked ? pick_binary_constants<Op, Post::Saturate, true>(key)
                      : pick_binary_constants<Op, Post::Saturate, false>(key);
  }
  return key.masked ? pick_binary_constants<Op, Post::Range, true>(key)
                    : pick_binary_constants<Op, Post::Range, false>(key);
}

template <class Op, Post kPost, bool kMasked>
KernelFunction pick_ternary_constants(const KernelKey& key) {
  switch (key.src_const) {
    case 0: return ternary<Op, kPost, kMasked, false, false>;
    case 2: return ternary<Op, kPost, kMasked, true, false>;
    case 4: return ternary<Op, kPost, kMasked, false, true>;
    case 6: return ternary<Op, kPost, kMasked, true, true>;
    default: return nullptr;
  }
}
template <class Op>
KernelFunction pick_exact_ternary(const KernelKey& key) {
  return key.masked ? pick_ternary_constants<Op, Post::None, true>(key)
                    : pick_ternary_constants<Op, Post::None, false>(key);
}
template <class Op>
KernelFunction pick_ternary(const KernelKey& key) {
  if (key.post == Post::Saturate) {
    return key.masked ? pick_ternary_constants<Op, Post::Saturate, true>(key)
                      : pick_ternary_constants<Op, Post::Saturate, false>(key);
  }
  return key.masked ? pick_ternary_constants<Op, Post::Range, true>(key)
                    : pick_ternary_constants<Op, Post::Range, false>(key);
}

template <int kTerms, bool kNegative, Post kPost, bool kMasked>
KernelFunction pick_dot_constants(const KernelKey& key) {
  if (key.src_const == 0) return dot<kTerms, kNegative, kPost, kMasked, false>;
  if (key.src_const == 2) return dot<kTerms, kNegative, kPost, kMasked, true>;
  return nullptr;
}
template <int kTerms, bool kNegative>
KernelFunction pick_dot(const KernelKey& key) {
  if (key.post == Post::Saturate) {
    return key.masked ? pick_dot_constants<kTerms, kNegative, Post::Saturate, true>(key)
                      : pick_dot_constants<kTerms, kNegative, Post::Saturate, false>(key);
  }
  return key.masked ? pick_dot_constants<kTerms, kNegative, Post::Range, true>(key)
                    : pick_dot_constants<kTerms, kNegative, Post::Range, false>(key);
}

KernelFunction find_simd_kernel(const KernelKey& key) {
  switch (key.kernel) {
    case Kernel::Copy:
      if (key.src_const == 0) return pick_exact_unary<CopyOp>(key);
      return key.masked ? unary<CopyOp, Post::None, true, true> : unary<CopyOp, Post::None, false, true>;
    case Kernel::Saturate: return pick_exact_unary<SaturateOp>(key);
    case Kernel::Frc: return pick_exact_unary<FrcOp>(key);
    case Kernel::Flr: return pick_unary<FlrOp>(key);
    case Kernel::Trunc: return pick_exact_unary<TruncOp>(key);
    case Kernel::Rcp: return pick_unary<RcpOp>(key);
    case Kernel::Rsq: return pick_unary<RsqOp>(key);
    case Kernel::Sqrt: return pick_unary<SqrtOp>(key);
    case Kernel::Exp: return pick_unary<ExpOp<false>>(key);
    case Kernel::Log: return pick_unary<LogOp<false>>(key);
    case Kernel::Sin: return pick_exact_unary<SineOp<0>>(key);
    case Kernel::Cos: return pick_exact_unary<SineOp<1>>(key);
    case Kernel::RcpReference: return pick_unary<RcpReferenceOp>(key);
    case Kernel::RsqReference: return pick_unary<RsqReferenceOp>(key);
    case Kernel::ExpReference: return pick_unary<ExpOp<true>>(key);
    case Kernel::LogReference: return pick_unary<LogOp<true>>(key);
    case Kernel::Add: return pick_binary<AddOp>(key);
    case Kernel::Sub: return pick_binary<SubOp>(key);
    case Kernel::AddRound: return pick_binary<AddRoundOp>(key);
    case Kernel::AddRoundSum: return pick_binary<AddRoundSumOp>(key);
    case Kernel::Mul: return pick_binary<MulOp>(key);
    case Kernel::NegMul: return pick_binary<NegMulOp>(key);
    case Kernel::Min: return pick_exact_binary<MinOp>(key);
    case Kernel::Max: return pick_exact_binary<MaxOp>(key);
    case Kernel::Sge: return pick_exact_binary<SgeOp>(key);
    case Kernel::Sgt: return pick_exact_binary<SgtOp>(key);
    case Kernel::Seq: return pick_exact_binary<SeqOp>(key);
    case Kernel::Sne: return pick_exact_binary<SneOp>(key);
    case Kernel::Mad: return pick_ternary<MadOp<false, false>>(key);
    case Kernel::NegMad: return pick_ternary<MadOp<true, false>>(key);
    case Kernel::MadNegC: return pick_ternary<MadOp<false, true>>(key);
    case Kernel::NegMadNegC: return pick_ternary<MadOp<true, true>>(key);
    case Kernel::CndGe: return pick_exact_ternary<CndGeOp>(key);
    case Kernel::CndGt: return pick_exact_ternary<CndGtOp>(key);
    case Kernel::CndEq: return pick_exact_ternary<CndEqOp>(key);
    case Kernel::Dot2: return pick_dot<2, false>(key);
    case Kernel::Dot3: return pick_dot<3, false>(key);
    case Kernel::Dot4: return pick_dot<4, false>(key);
    case Kernel::NegDot2: return pick_dot<2, true>(key);
    case Kernel::NegDot3: return pick_dot<3, true>(key);
    case Kernel::NegDot4: return pick_dot<4, true>(key);
    default: return nullptr;
  }
}

std::uint64_t sanitise_lanes(const number::Grid& grid, const double* from, double* to, std::uint64_t active,
                             std::uint64_t covered) {
  const D d;
  const V magic = constant(grid.magic), least = constant(grid.least), greatest = constant(grid.greatest);
  std::uint64_t replaced = 0;
  for (std::size_t i = 0; i < kLanes; i += hn::Lanes(d)) {
    const V x = hn::IfThenElseZero(mask_at(active, i), hn::LoadU(d, from + i));
    const auto good = hn::And(hn::Ge(x, least), hn::Le(x, greatest));  // false for NaN
    if (HWY_LIKELY(hn::AllTrue(d, good))) {
      hn::Store(hn::Sub(hn::Add(x, magic), magic), d, to + i);
      continue;
    }
    for (std::size_t j = i; j < i + hn::Lanes(d); ++j) {
      const number::Ranged r = number::sanitise(grid, (active >> j & 1) != 0 ? from[j] : 0.0);
      to[j] = r.value;
      replaced += r.saturated ? covered >> j & 1 : 0;
    }
  }
  return replaced;
}

bool lanes_within(const double* values, std::size_t count, double bound) {
  const D d;
  const V most = constant(bound);
  auto good = hn::Eq(most, most);
  std::size_t i = 0;
  for (; i + hn::Lanes(d) <= count; i += hn::Lanes(d)) good = hn::And(good, hn::Le(hn::Abs(hn::LoadU(d, values + i)), most));
  bool rest = true;
  for (; i < count; ++i) rest &= values[i] <= bound && values[i] >= -bound;
  return rest && hn::AllTrue(d, good);
}

void copy_lanes(const double* from, double* to, std::uint64_t mask) {
  const D d;
  for (std::size_t i = 0; i < kLanes; i += hn::Lanes(d))
    hn::BlendedStore(hn::Load(d, from + i), mask_at(mask, i), d, to + i);
}

}  // namespace HWY_NAMESPACE
}  // namespace aluminate::vm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <string_view>

namespace aluminate::vm {
HWY_EXPORT(find_simd_kernel);
HWY_EXPORT(sanitise_lanes);
HWY_EXPORT(copy_lanes);
HWY_EXPORT(lanes_within);

KernelFunction find_kernel(const KernelKey& key) {
  if (KernelFunction function = find_lane_kernel(key.kernel)) return function;
  return HWY_DYNAMIC_DISPATCH(find_simd_kernel)(key);
}

std::uint64_t sanitise_row(const number::Grid& grid, const double* from, double* to, std::uint64_t active,
                           std::uint64_t covered) {
  return HWY_DYNAMIC_DISPATCH(sanitise_lanes)(grid, from, to, active, covered);
}

bool all_within(const double* values, std::size_t count, double bound) {
  return HWY_DYNAMIC_DISPATCH(lanes_within)(values, count, bound);
}

void copy_row(const double* from, double* to, std::uint64_t mask) { HWY_DYNAMIC_DISPATCH(copy_lanes)(from, to, mask); }

namespace {
std::vector<std::int64_t> usable_targets() {
  std::vector<std::int64_t> targets;
  for (std::int64_t target : hwy::SupportedAndGeneratedTargets()) targets.push_back(target);
  return targets;
}
}  // namespace

const char* kernel_target() {
  // Bits are ordered from the best target (lowest) to the portable one.
  const std::vector<std::int64_t> targets = usable_targets();
  std::int64_t best = targets.front();
  for (std::int64_t target : targets) best = target < best ? target : best;
  return hwy::TargetName(best);
}

std::vector<const char*> kernel_targets() {
  hwy::SetSupportedTargetsForTest(0);
  std::vector<const char*> names;
  for (std::int64_t target : usable_targets()) names.push_back(hwy::TargetName(target));
  return names;
}

void force_kernel_target(const char* name) {
  hwy::SetSupportedTargetsForTest(0);
  if (name != nullptr) {
    for (std::int64_t target : usable_targets())
      if (std::string_view(hwy::TargetName(target)) == name) {
        hwy::SetSupportedTargetsForTest(target);
        break;
      }
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace aluminate::vm
#endif
