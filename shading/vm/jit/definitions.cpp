#include "shading/vm/jit/definitions.hpp"

#include <llvm/IR/Constants.h>
#include <llvm/IR/Intrinsics.h>

#include "platform/number/scalar.hpp"

namespace aluminate::vm::jit {

using llvm::Value;

Definitions::Definitions(llvm::IRBuilder<>& builder, unsigned lanes)
    : b_(builder),
      lanes_(lanes),
      vector_(llvm::FixedVectorType::get(builder.getDoubleTy(), lanes)),
      integers_(llvm::FixedVectorType::get(builder.getInt64Ty(), lanes)),
      singles_(llvm::FixedVectorType::get(builder.getFloatTy(), lanes)) {}

Value* Definitions::constant(double x) const { return llvm::ConstantFP::get(vector_, x); }
Value* Definitions::integer(std::uint64_t x) const { return llvm::ConstantInt::get(integers_, x); }
Value* Definitions::splat(Value* scalar) { return b_.CreateVectorSplat(lanes_, scalar); }
Value* Definitions::bits(Value* x) { return b_.CreateBitCast(x, integers_); }
Value* Definitions::from_bits(Value* x) { return b_.CreateBitCast(x, vector_); }

Value* Definitions::absolute(Value* a) { return b_.CreateUnaryIntrinsic(llvm::Intrinsic::fabs, a); }
Value* Definitions::negate(Value* a) { return b_.CreateFNeg(a); }
Value* Definitions::less_of(Value* a, Value* b) { return b_.CreateSelect(b_.CreateFCmpOLT(a, b), a, b); }
Value* Definitions::greater_of(Value* a, Value* b) { return b_.CreateSelect(b_.CreateFCmpOGT(a, b), a, b); }
Value* Definitions::saturate(Value* a) { return greater_of(less_of(a, constant(1.0)), constant(0.0)); }
Value* Definitions::floor(Value* a) { return b_.CreateUnaryIntrinsic(llvm::Intrinsic::floor, a); }
Value* Definitions::truncate(Value* a) { return b_.CreateUnaryIntrinsic(llvm::Intrinsic::trunc, a); }
Value* Definitions::fma(Value* a, Value* b, Value* c) {
  return b_.CreateIntrinsic(llvm::Intrinsic::fma, {vector_}, {a, b, c});
}
Value* Definitions::negative_fma(Value* a, Value* b, Value* c) { return fma(negate(a), b, c); }

Rounded Definitions::round(const number::Grid& grid, Value* x) { return unbias(grid, b_.CreateFAdd(x, constant(grid.magic))); }
Rounded Definitions::unbias(const number::Grid& grid, Value* biased) {
  return {b_.CreateFSub(biased, constant(grid.magic)), biased};
}

Value* Definitions::horner(std::span<const double> coefficients, Value* x) {
  Value* sum = constant(coefficients.back());
  for (std::size_t i = coefficients.size() - 1; i-- > 0;) sum = fma(sum, x, constant(coefficients[i]));
  return sum;
}

Value* Definitions::at_least(Value* x, double least, const Interval& range) {
  return range.least >= least ? x : greater_of(x, constant(least));
}

Value* Definitions::within_beyond(const Operation& op, Value* y, bool proven) {
  if (proven) return y;
  return greater_of(less_of(y, constant(op.grid->beyond)), constant(-op.grid->beyond));
}

// 1/x or 1/sqrt(x) in binary32, correctly rounded by IEEE division and root.
Value* Definitions::single_seed(Value* x, bool root) {
  Value* single = b_.CreateFPTrunc(x, singles_);
  if (root) single = b_.CreateUnaryIntrinsic(llvm::Intrinsic::sqrt, single);
  return b_.CreateFPExt(b_.CreateFDiv(llvm::ConstantFP::get(singles_, 1.0), single), vector_);
}

Rounded Definitions::reciprocal(const Operation& op, Value* x, const Interval& range) {
  // |1/x| stays clear of `beyond`, with room for the error of the Newton step.
  const double nearest = 2 / op.grid->beyond;
  const bool proven = range.least > nearest || range.greatest < -nearest;
  if (op.kernel == Kernel::RcpReference) {
    Value* y = b_.CreateFDiv(constant(1.0), x);
    if (!proven) y = b_.CreateSelect(b_.CreateFCmpOEQ(x, constant(0.0)), constant(op.grid->beyond), y);
    return round(*op.grid, within_beyond(op, y, proven));
  }
  Value* s = single_seed(x, false);
  return round(*op.grid, within_beyond(op, fma(negative_fma(x, s, constant(1.0)), s, s), proven));
}

Rounded Definitions::inverse_root(const Operation& op, Value* x, const Interval& range) {
  x = at_least(x, op.operand_step, range);
  if (op.kernel == Kernel::RsqReference)
    return {b_.CreateFDiv(constant(1.0), b_.CreateUnaryIntrinsic(llvm::Intrinsic::sqrt, x)), nullptr};
  Value* s = single_seed(x, true);
  Value* e = negative_fma(b_.CreateFMul(x, s), s, constant(1.0));
  return round(*op.grid, fma(b_.CreateFMul(constant(0.5), s), e, s));
}

Rounded Definitions::exponential(const Operation& op, Value* x, const Interval& range) {
  if (range.greatest > op.grid->exp2_greatest) x = less_of(x, constant(op.grid->exp2_greatest));
  x = at_least(x, op.grid->exp2_least, range);
  Value* to_integer = constant(number::kToInteger);
  Value* k = b_.CreateFAdd(x, to_integer);
  Value* r = b_.CreateFSub(x, b_.CreateFSub(k, to_integer));
  Value* p = op.kernel == Kernel::ExpReference ? horner(number::kExp2Reference, r) : horner(number::kExp2, r);
  return round(*op.grid, from_bits(b_.CreateAdd(bits(p), b_.CreateShl(bits(k), 52))));
}

Rounded Definitions::logarithm(const Operation& op, Value* x, const Interval& range) {
  x = at_least(x, op.operand_step, range);
  constexpr std::uint64_t kBias = std::uint64_t{1024} << 52;
  constexpr std::uint64_t kSplit = std::bit_cast<std::uint64_t>(number::kSqrtHalf);
  Value* pattern = bits(x);
  Value* biased = b_.CreateLShr(b_.CreateSub(pattern, integer(kSplit - kBias)), 52);
  Value* m = from_bits(b_.CreateAdd(b_.CreateSub(pattern, b_.CreateShl(biased, 52)), integer(kBias)));
  Value* e = b_.CreateFSub(from_bits(b_.CreateOr(biased, integer(std::bit_cast<std::uint64_t>(0x1p52)))),
                           constant(0x1p52 + 1024.0));
  Value* s = b_.CreateFDiv(b_.CreateFSub(m, constant(1.0)), b_.CreateFAdd(m, constant(1.0)));
  Value* z = b_.CreateFMul(s, s);
  Value* q = op.kernel == Kernel::LogReference ? horner(number::kLog2Reference, z) : horner(number::kLog2, z);
  return round(*op.grid, fma(s, q, e));
}

Rounded Definitions::sine(const Operation& op, Value* x) {
  x = greater_of(less_of(x, constant(number::kAngleGreatest)), constant(-number::kAngleGreatest));
  Value* k = fma(x, constant(number::kTwoOverPi), constant(number::kToInteger));
  Value* n = b_.CreateFSub(k, constant(number::kToInteger));
  Value* r = negative_fma(n, constant(number::kPiOver2Low), negative_fma(n, constant(number::kPiOver2High), x));
  Value* z = b_.CreateFMul(r, r);
  Value* sine = fma(b_.CreateFMul(r, z), horner(number::kSin, z), r);
  Value* cosine = fma(z, horner(number::kCos, z), constant(1.0));
  Value* quadrant = b_.CreateAdd(bits(k), integer(op.kernel == Kernel::Cos ? 1 : 0));
  Value* odd = b_.CreateICmpEQ(b_.CreateAnd(quadrant, integer(1)), integer(1));
  Value* sign = b_.CreateShl(b_.CreateAnd(quadrant, integer(2)), 62);
  return round(*op.grid, from_bits(b_.CreateXor(bits(b_.CreateSelect(odd, cosine, sine)), sign)));
}

Rounded Definitions::function(const Operation& op, Value* x, const Interval& range) {
  switch (op.kernel) {
    case Kernel::Rcp:
    case Kernel::RcpReference: return reciprocal(op, x, range);
    case Kernel::Rsq:
    case Kernel::RsqReference: return inverse_root(op, x, range);
    case Kernel::Sqrt:
      return round(*op.grid, b_.CreateUnaryIntrinsic(llvm::Intrinsic::sqrt, at_least(x, 0.0, range)));
    case Kernel::Exp:
    case Kernel::ExpReference: return exponential(op, x, range);
    case Kernel::Log:
    case Kernel::LogReference: return logarithm(op, x, range);
    default: return sine(op, x);
  }
}

}  // namespace aluminate::vm::jit
