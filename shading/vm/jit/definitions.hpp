// The elementwise definitions of platform/number/scalar.hpp as LLVM IR on one vector of lanes: the same constants in the
// same order, fused where that is fused, without fast-math flags. Facts about ranges drop steps that cannot matter and
// change no bit.
#pragma once

#include <llvm/IR/IRBuilder.h>

#include <span>

#include "shading/vm/range_plan.hpp"

namespace aluminate::vm::jit {

/// A rounded result in two forms. biased = M + plain, what the last addition left before M was subtracted: exact while
/// the value is in range, and the very operand that a following multiply-add starts from. May be null.
struct Rounded {
  llvm::Value* plain = nullptr;
  llvm::Value* biased = nullptr;
};

class Definitions {
 public:
  Definitions(llvm::IRBuilder<>& builder, unsigned lanes);

  llvm::Type* vector() const { return vector_; }
  unsigned lanes() const { return lanes_; }

  llvm::Value* constant(double x) const;
  llvm::Value* splat(llvm::Value* scalar);
  llvm::Value* absolute(llvm::Value* a);
  llvm::Value* negate(llvm::Value* a);
  llvm::Value* less_of(llvm::Value* a, llvm::Value* b);     // a < b ? a : b
  llvm::Value* greater_of(llvm::Value* a, llvm::Value* b);  // a > b ? a : b
  llvm::Value* saturate(llvm::Value* a);
  llvm::Value* floor(llvm::Value* a);
  llvm::Value* truncate(llvm::Value* a);
  llvm::Value* fma(llvm::Value* a, llvm::Value* b, llvm::Value* c);
  llvm::Value* negative_fma(llvm::Value* a, llvm::Value* b, llvm::Value* c);  // c - a b

  /// (x + M) - M, and x - M for an x that already has M in it.
  Rounded round(const number::Grid& grid, llvm::Value* x);
  Rounded unbias(const number::Grid& grid, llvm::Value* biased);

  /// Rcp .. LogReference of decoded.hpp; x lies in `range`.
  Rounded function(const Operation& op, llvm::Value* x, const Interval& range);

 private:
  llvm::Value* integer(std::uint64_t x) const;
  llvm::Value* bits(llvm::Value* x);
  llvm::Value* from_bits(llvm::Value* x);
  llvm::Value* horner(std::span<const double> coefficients, llvm::Value* x);
  llvm::Value* at_least(llvm::Value* x, double least, const Interval& range);
  llvm::Value* within_beyond(const Operation& op, llvm::Value* y, bool proven);
  llvm::Value* single_seed(llvm::Value* x, bool root);
  Rounded reciprocal(const Operation& op, llvm::Value* x, const Interval& range);
  Rounded inverse_root(const Operation& op, llvm::Value* x, const Interval& range);
  Rounded exponential(const Operation& op, llvm::Value* x, const Interval& range);
  Rounded logarithm(const Operation& op, llvm::Value* x, const Interval& range);
  Rounded sine(const Operation& op, llvm::Value* x);

  llvm::IRBuilder<>& b_;
  unsigned lanes_;
  llvm::Type* vector_;
  llvm::Type* integers_;
  llvm::Type* singles_;
};

}  // namespace aluminate::vm::jit
