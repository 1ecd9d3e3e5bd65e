#include "shading/vm/range_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "platform/number/scalar.hpp"

namespace aluminate::vm {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Bounds are computed in rounded binary64 arithmetic and the operations themselves round too: every interval is made
// wider by far more than both.
constexpr double kSlack = 0x1p-40;
// The polynomials of exp and log err by more (docs/number_formats.md, Functions: 2^-34.3 relative, 2^-38.8 absolute).
constexpr double kExpSlack = 0x1p-33, kLogSlack = 0x1p-37;

// |a_i| / sqrt(max(a.a, c)) as the machine computes it. The dot product is rounded to its grid in up to four
// steps of half a unit s, so a_i^2 <= S + 2 s. rsq takes M = max(S, c, its own least operand): the product is
// at most sqrt((S + 2 s) / M) <= sqrt(1 + 2 s / M), with room for the relative errors of both operations,
// plus their roundings to a grid: half a unit of the rsq times |a_i|, and half a unit of the product.
double normalised_bound(double sum_step, double least_square, double root_step, double product_step,
                        double magnitude) {
  return std::sqrt(1 + 2 * sum_step / least_square) * (1 + 0x1p-30) + magnitude * root_step + product_step;
}

Interval join(const Interval& a, const Interval& b) {
  return {std::min(a.least, b.least), std::max(a.greatest, b.greatest)};
}
Interval negate(const Interval& a) { return {-a.greatest, -a.least}; }
Interval absolute(const Interval& a) {
  if (a.least >= 0) return a;
  if (a.greatest <= 0) return negate(a);
  return {0, std::max(-a.least, a.greatest)};
}
Interval add(const Interval& a, const Interval& b) { return {a.least + b.least, a.greatest + b.greatest}; }
Interval multiply(const Interval& a, const Interval& b) {
  const double p[4] = {a.least * b.least, a.least * b.greatest, a.greatest * b.least, a.greatest * b.greatest};
  return {*std::min_element(p, p + 4), *std::max_element(p, p + 4)};
}
double magnitude(const Interval& a) { return std::max(std::fabs(a.least), std::fabs(a.greatest)); }

constexpr Interval kNone{kInfinity, -kInfinity};  // of a row nobody has written

// Names the value in a row or a constant; a new name for every write.
using Name = int;

class Planner {
 public:
  Planner(const Decoded& decoded, Assume assume, SquaredLength lengths)
      : d_(decoded),
        lengths_(lengths),
        format_{decoded.input_grid.least, decoded.input_grid.greatest},
        rows_(static_cast<std::size_t>(decoded.row_count), kNone),
        names_(rows_.size(), 0) {
    plan_.assume = assume;
    plan_.operations.resize(d_.operations.size());
  }

  RangePlan plan() {
    for (Name& name : names_) name = ++last_name_;
    for (std::uint32_t row : d_.zero_rows) rows_[row / kLanes] = {0, 0};
    for (std::size_t b = 0; b < d_.blocks.size(); ++b) {
      const DecodedBlock& block = d_.blocks[b];
      for (std::uint32_t i = block.first; i < block.last; ++i) visit(i);
      if (block.flow == Flow::Loop) forget_rows_of_loop(b + 1, block.target);
      if (block.flow != Flow::None) start_block();
    }
    return std::move(plan_);
  }

 private:
  // Lanes may join or leave: what was learnt about how values relate held for the lanes of one block.
  void start_block() {
    sums_of_squares_.clear();
    inverse_roots_.clear();
    for (Name& name : names_) name = ++last_name_;
  }

  // The body may run again with whatever it wrote: anything the format holds.
  void forget_rows_of_loop(std::size_t first, std::size_t last) {
    const auto forget = [&](std::uint32_t row) { rows_[row / kLanes] = join(rows_[row / kLanes], format_); };
    for (std::size_t b = first; b <= last; ++b)
      for (std::uint32_t i = d_.blocks[b].first; i < d_.blocks[b].last; ++i) {
        const Operation& op = d_.operations[i];
        if (op.kernel == Kernel::Texture) {
          for (std::size_t c = 0; c < 4; ++c)
            if ((op.texture_mask >> c & 1) != 0) forget(op.texture_dst[c]);
        } else if (writes_row(op)) {
          forget(op.dst);
        }
      }
  }

  static bool writes_row(const Operation& op) {
    return op.kernel < Kernel::KillGt && op.kernel != Kernel::Texture;
  }

  Interval of(const Operand& operand) const {
    switch (operand.space) {
      case Space::Row: {
        // A masked row that no lane has written yet: whatever is read there is not used.
        const Interval& row = rows_[operand.offset / kLanes];
        return row.least <= row.greatest ? row : format_;
      }
      case Space::Input: return assumed(kTypicalInput);
      case Space::Uniform: return assumed(kTypicalUniform);
      case Space::Literal: return {d_.literals[operand.offset], d_.literals[operand.offset]};
      case Space::Loop: break;
    }
    return {0, d_.loop_value_limit};
  }
  Interval assumed(double bound) const {
    if (plan_.assume == Assume::Nothing || bound > format_.greatest) return format_;
    return {-bound, bound};
  }
  Name name_of(const Operand& operand) {
    if (operand.space == Space::Row) return names_[operand.offset / kLanes];
    Name& name = constant_names_[{static_cast<int>(operand.space), operand.offset}];
    if (name == 0) name = ++last_name_;
    return name;
  }

  void write(const Operation& op, std::uint32_t offset, Interval value) {
    Interval& row = rows_[offset / kLanes];
    row = op.masked ? join(row, value) : value;
    names_[offset / kLanes] = ++last_name_;
  }

  Interval product(const Operation& op, int a, int b) {
    const Operand &x = op.src[static_cast<std::size_t>(a)], &y = op.src[static_cast<std::size_t>(b)];
    const Interval p = multiply(of(x), of(y));
    if (name_of(x) == name_of(y)) return {std::max(0.0, p.least), p.greatest};
    return p;
  }
  Interval dot(const Operation& op, int terms) {
    Interval sum = product(op, 0, 1);
    for (int t = 1; t < terms; ++t) sum = add(sum, product(op, 2 * t, 2 * t + 1));
    return sum;
  }

  // x * rsq(x.x + y.y + z.z): the one relation between values that intervals cannot see and every shader relies on.
  Interval bound_normalised(const Operation& op, Interval result) {
    for (std::size_t s = 0; s < 2; ++s) {
      const auto root = inverse_roots_.find(name_of(op.src[s]));
      if (root == inverse_roots_.end()) continue;
      const SumOfSquares& sum = root->second;
      const Operand& vector = op.src[1 - s];
      if (!sum.terms.contains(name_of(vector))) continue;
      const double size = magnitude(of(vector));
      // Where the sum was clamped it is too small, and the quotient greater by that much.
      double bound = normalised_bound(sum.step, sum.least, sum.root_step, op.grid->step, size);
      if (!sum.in_range && lengths_ == SquaredLength::MaySaturate) bound = std::max(bound, 2 * size / std::sqrt(sum.greatest));
      result = {std::max(result.least, -bound), std::min(result.greatest, bound)};
    }
    return result;
  }

  Interval rounded(const Operation& op, Interval v) const {
    const double step = d_.format.kind == number::Kind::Reference ? 0 : op.grid->step;
    const double more = magnitude(v) * kSlack + step;
    const Interval wide = {v.least - more, v.greatest + more};
    // Rounding is monotone and keeps zero: signs survive.
    return {v.least >= 0 ? std::max(0.0, wide.least) : wide.least, v.greatest <= 0 ? std::min(0.0, wide.greatest) : wide.greatest};
  }

  Interval reciprocal(const Operation& op, const Interval& x) const {
    if (x.least > 0) return {1 / x.greatest, std::min(op.grid->beyond, 1 / x.least)};
    if (x.greatest < 0) return {std::max(-op.grid->beyond, 1 / x.greatest), 1 / x.least};
    return {-op.grid->beyond, op.grid->beyond};
  }

  Interval result_of(const Operation& op, const Interval& a) {
    const auto b = [&] { return of(op.src[1]); };
    const auto c = [&] { return of(op.src[2]); };
    switch (op.kernel) {
      case Kernel::Copy: {
        const Interval kept = op.absolute ? absolute(a) : a;
        return op.negate ? negate(kept) : kept;
      }
      case Kernel::Saturate: return {std::clamp(a.least, 0.0, 1.0), std::clamp(a.greatest, 0.0, 1.0)};
      case Kernel::ClampRange: return a;
      case Kernel::Frc: return {0, 1};
      case Kernel::Flr: return {std::floor(a.least), std::floor(a.greatest)};
      case Kernel::Trunc: return {std::trunc(a.least), std::trunc(a.greatest)};
      case Kernel::Rcp:
      case Kernel::RcpReference: return reciprocal(op, a);
      case Kernel::Rsq:
      case Kernel::RsqReference:
        return {1 / std::sqrt(std::max(a.greatest, op.operand_step)), 1 / std::sqrt(std::max(a.least, op.operand_step))};
      case Kernel::Sqrt: return {std::sqrt(std::max(a.least, 0.0)), std::sqrt(std::max(a.greatest, 0.0))};
      case Kernel::Exp:
      case Kernel::ExpReference:
        return {(1 - kExpSlack) * number::exp2(reference_, std::clamp(a.least, op.grid->exp2_least, op.grid->exp2_greatest)),
                (1 + kExpSlack) * number::exp2(reference_, std::clamp(a.greatest, op.grid->exp2_least, op.grid->exp2_greatest))};
      case Kernel::Log:
      case Kernel::LogReference:
        return {number::log2(reference_, op.operand_step, a.least) - kLogSlack, number::log2(reference_, op.operand_step, a.greatest) + kLogSlack};
      case Kernel::Sin:
      case Kernel::Cos: return {-1, 1};
      case Kernel::Add:
      case Kernel::AddRound:
      case Kernel::AddRoundSum: return add(a, b());
      case Kernel::Sub: return add(a, negate(b()));
      case Kernel::Mul: return bound_normalised(op, product(op, 0, 1));
      case Kernel::NegMul: return negate(bound_normalised(op, product(op, 0, 1)));
      case Kernel::Min: return {std::min(a.least, b().least), std::min(a.greatest, b().greatest)};
      case Kernel::Max: return {std::max(a.least, b().least), std::max(a.greatest, b().greatest)};
      case Kernel::Sge:
      case Kernel::Sgt:
      case Kernel::Seq:
      case Kernel::Sne: return {0, 1};
      case Kernel::Mad: return add(product(op, 0, 1), c());
      case Kernel::NegMad: return add(negate(product(op, 0, 1)), c());
      case Kernel::MadNegC: return add(product(op, 0, 1), negate(c()));
      case Kernel::NegMadNegC: return add(negate(product(op, 0, 1)), negate(c()));
      case Kernel::CndGe:
      case Kernel::CndGt:
      case Kernel::CndEq: return join(b(), c());
      case Kernel::Dot2: return add(dot(op, 2), of(op.src[4]));
      case Kernel::NegDot2: return add(negate(dot(op, 2)), of(op.src[4]));
      case Kernel::Dot3: return dot(op, 3);
      case Kernel::Dot4: return dot(op, 4);
      case Kernel::NegDot3: return negate(dot(op, 3));
      case Kernel::NegDot4: return negate(dot(op, 4));
      case Kernel::RelativeUniform: {
        if (op.src[0].space == Space::Uniform) return of(op.src[0]);
        Interval any = kNone;
        for (std::size_t r = 0; r < op.relative.limit; ++r) {
          const double value = d_.literals[op.src[0].offset + 4 * r];
          any = join(any, {value, value});
        }
        return any;
      }
      case Kernel::DsX:
      case Kernel::DsY: return {a.least - a.greatest, a.greatest - a.least};
      case Kernel::Texture:
      case Kernel::KillGt:
      case Kernel::KillGe:
      case Kernel::KillNe:
      case Kernel::KillEq:
      case Kernel::NotZero: break;
    }
    return format_;
  }

  static bool is_exact(Kernel kernel) {
    switch (kernel) {
      case Kernel::Copy:
      case Kernel::Saturate:
      case Kernel::ClampRange:
      case Kernel::Flr:
      case Kernel::Trunc:
      case Kernel::Min:
      case Kernel::Max:
      case Kernel::CndGe:
      case Kernel::CndGt:
      case Kernel::CndEq:
      case Kernel::RelativeUniform: return true;
      default: return false;
    }
  }

  // Bounds that hold without any room for rounding: it is monotone, and these ends lie on every grid.
  Interval unslacken(const Operation& op, const Interval& a, Interval v) const {
    if (op.kernel == Kernel::Mul) {
      const Interval b = of(op.src[1]);
      if (a.within(-1, 1) && b.within(-1, 1)) v = {std::max(v.least, -1.0), std::min(v.greatest, 1.0)};
    } else if (op.kernel == Kernel::Sub) {  // exact
      const Interval b = of(op.src[1]);
      if (b.least >= 0) v.greatest = std::min(v.greatest, a.greatest);
      if (a.least >= b.greatest) v.least = std::max(v.least, 0.0);
    }
    return v;
  }

  // Zeros have a sign. A rounding ends with x - M, which is +0 where x = M; so is p - q where p is above
  // zero.
  static bool never_minus_zero(Kernel kernel, const Interval& a) {
    switch (kernel) {
      case Kernel::Sub:
        return a.least > 0;
      case Kernel::Mul:
      case Kernel::NegMul:
      case Kernel::Mad:
      case Kernel::NegMad:
      case Kernel::MadNegC:
      case Kernel::NegMadNegC:
      case Kernel::Dot2:
      case Kernel::Dot3:
      case Kernel::Dot4:
      case Kernel::NegDot2:
      case Kernel::NegDot3:
      case Kernel::NegDot4:
      case Kernel::AddRound:
      case Kernel::AddRoundSum:
      case Kernel::Exp:
      case Kernel::Rsq:
        return true;
      default:
        return false;
    }
  }

  // Sums are rounded as they grow: no part may be beyond the range where M rounds to the grid.
  double greatest_part(const Operation& op) {
    const auto terms = [&](int count) {
      double sum = 0;
      for (int t = 0; t < count; ++t) sum += magnitude(product(op, 2 * t, 2 * t + 1));
      return sum;
    };
    switch (op.kernel) {
      case Kernel::Add:
      case Kernel::AddRound:
      case Kernel::AddRoundSum:
      case Kernel::Sub: return std::max(magnitude(of(op.src[0])), magnitude(of(op.src[1])));
      case Kernel::Mad:
      case Kernel::NegMad:
      case Kernel::MadNegC:
      case Kernel::NegMadNegC: return magnitude(of(op.src[2]));
      case Kernel::Dot2:
      case Kernel::NegDot2: return terms(2) + magnitude(of(op.src[4]));
      case Kernel::Dot3:
      case Kernel::NegDot3: return terms(3);
      case Kernel::Dot4:
      case Kernel::NegDot4: return terms(4);
      default: return 0;
    }
  }

  void visit(std::uint32_t index) {
    const Operation& op = d_.operations[index];
    OperationRange& known = plan_.operations[index];
    if (op.kernel == Kernel::Texture) {
      known.in_range = true;
      for (std::size_t c = 0; c < 4; ++c)
        if ((op.texture_mask >> c & 1) != 0) write(op, op.texture_dst[c], {0, 1});
      return;
    }
    const Interval a = of(op.src[0]);
    known.operand = a;
    if (!writes_row(op)) return;

    Interval result = result_of(op, a);
    if (!is_exact(op.kernel)) {
      result = unslacken(op, a, rounded(op, result));
      known.reach = std::max(magnitude(result), greatest_part(op));
    }
    known.result = result;
    known.never_minus_zero = never_minus_zero(op.kernel, a);
    if (op.post == Post::Saturate) {
      known.in_range = true;
      result = {std::clamp(result.least, 0.0, 1.0), std::clamp(result.greatest, 0.0, 1.0)};
    } else {
      const bool unbounded = op.grid->greatest == std::numeric_limits<double>::max();
      known.in_range = unbounded || result.within(op.grid->least, op.grid->greatest);
      if (!unbounded && (op.post == Post::Range || op.kernel == Kernel::ClampRange || op.kernel == Kernel::DsX || op.kernel == Kernel::DsY))
        result = {std::clamp(result.least, op.grid->least, op.grid->greatest),
                  std::clamp(result.greatest, op.grid->least, op.grid->greatest)};
    }
    learn(op, known, result);
  }

  // Writes the result and remembers how it came about.
  void learn(const Operation& op, const OperationRange& known, const Interval& result) {
    SumOfSquares sum;
    const int terms = op.kernel == Kernel::Dot3 ? 3 : op.kernel == Kernel::Dot4 ? 4 : 0;
    bool squares = terms != 0 && op.post == Post::Range;
    for (int t = 0; t < terms && squares; ++t) {
      const Name a = name_of(op.src[static_cast<std::size_t>(2 * t)]), b = name_of(op.src[static_cast<std::size_t>(2 * t) + 1]);
      squares = a == b;
      sum.terms.insert(a);
    }
    sum.in_range = known.in_range;
    sum.greatest = op.grid->greatest;
    sum.step = op.grid->step;
    // max(S, anything) is at least S.
    if (op.kernel == Kernel::Max && !op.masked)
      for (std::size_t s = 0; s < 2 && !squares; ++s) {
        const auto known_sum = sums_of_squares_.find(name_of(op.src[s]));
        if (known_sum == sums_of_squares_.end()) continue;
        sum = known_sum->second;
        squares = true;
      }
    const Name operand = name_of(op.src[0]);
    const bool copied = op.kernel == Kernel::Copy && !op.absolute && !op.negate;
    write(op, op.dst, result);
    Name& name = names_[op.dst / kLanes];
    if (copied && !op.masked) name = operand;
    if (squares) sums_of_squares_[name] = sum;
    const bool root = op.kernel == Kernel::Rsq || op.kernel == Kernel::RsqReference;
    const auto of_sum = sums_of_squares_.find(operand);
    if (!root || of_sum == sums_of_squares_.end() || !known.in_range) return;
    SumOfSquares& rooted = inverse_roots_[name] = of_sum->second;
    rooted.least = std::max(known.operand.least, op.operand_step);
    rooted.root_step = op.grid->step;
    if (rooted.least < rooted.step) inverse_roots_.erase(name);
  }

  struct SumOfSquares {
    std::set<Name> terms;
    bool in_range = false;
    double greatest = 0, step = 0;
    double least = 0, root_step = 0;  // of an inverse root: the smallest operand it takes, the step of its grid
  };

  const Decoded& d_;
  SquaredLength lengths_;
  Interval format_;
  const number::Grid reference_ = number::parse_number_format("ref64")->default_grid();
  std::vector<Interval> rows_;
  std::vector<Name> names_;
  std::map<std::pair<int, std::uint32_t>, Name> constant_names_;
  std::map<Name, SumOfSquares> sums_of_squares_;
  std::map<Name, SumOfSquares> inverse_roots_;  // of which sum
  Name last_name_ = 0;
  RangePlan plan_;
};

}  // namespace

RangePlan plan_ranges(const Decoded& decoded, Assume assume, SquaredLength lengths) {
  return Planner(decoded, assume, lengths).plan();
}

}  // namespace aluminate::vm
