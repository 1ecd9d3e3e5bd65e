#include "shading/cost/program_paths.hpp"

#include <algorithm>

namespace aluminate::cost {
namespace {

using vm::Opcode;

void add(PathSum& sum, const PathSum& other, double times = 1) {
  for (std::size_t q = 0; q < kPathQuantities; ++q) sum[q] += other[q] * times;
}
PathSum least(const PathSum& a, const PathSum& b) {
  PathSum sum;
  for (std::size_t q = 0; q < kPathQuantities; ++q) sum[q] = std::min(a[q], b[q]);
  return sum;
}
PathSum most(const PathSum& a, const PathSum& b) {
  PathSum sum;
  for (std::size_t q = 0; q < kPathQuantities; ++q) sum[q] = std::max(a[q], b[q]);
  return sum;
}

class PathWalker {
 public:
  PathWalker(const vm::Program& program, const std::vector<vm::Block>& blocks,
             const std::vector<PathSum>& of_block)
      : program_(program), blocks_(blocks), of_block_(of_block) {}

  PathBounds run() {
    const Range range = sequence();
    bounds_.shortest = range.shortest;
    bounds_.longest = range.longest;
    return bounds_;
  }

 private:
  struct Range {
    PathSum shortest{}, longest{};
    bool leaves = false;       // a Break or Continue may end the body early
    PathSum until_leaving{};   // least up to the first of them
    Opcode end = Opcode::Mov;  // the Flow instruction that closed the sequence
  };

  /// Blocks up to and including the one that ends with Else, EndIf or EndLoop, or the end of the program.
  Range sequence() {
    Range range;
    while (next_ < blocks_.size()) {
      const std::size_t at = next_++;
      add(range.shortest, of_block_[at]);
      add(range.longest, of_block_[at]);
      if (blocks_[at].end == blocks_[at].begin) continue;
      const vm::Instruction& last = program_.code[blocks_[at].end - 1];
      if (vm::info(last.op).pipe != vm::Pipe::Flow) continue;
      const PathSum flow_word = {0, 0, 1};
      add(range.shortest, flow_word);
      add(range.longest, flow_word);
      if (last.op == Opcode::Else || last.op == Opcode::EndIf || last.op == Opcode::EndLoop) {
        range.end = last.op;
        return range;
      }
      if (last.op == Opcode::If) branch(range);
      if (last.op == Opcode::Loop) loop(range, last.trip_count);
      if (last.op == Opcode::Break || last.op == Opcode::Continue) leave(range, range.shortest);
    }
    return range;
  }

  void leave(Range& range, const PathSum& so_far) {
    bounds_.straight_line = false;
    range.until_leaving = range.leaves ? least(range.until_leaving, so_far) : so_far;
    range.leaves = true;
  }

  void branch(Range& range) {
    bounds_.straight_line = false;
    const Range then = sequence();
    Range otherwise;
    if (then.end == Opcode::Else) otherwise = sequence();
    for (const Range* side : {&then, static_cast<const Range*>(&otherwise)}) {
      if (!side->leaves) continue;
      PathSum so_far = range.shortest;
      add(so_far, side->until_leaving);
      leave(range, so_far);
    }
    add(range.shortest, least(then.shortest, otherwise.shortest));
    add(range.longest, most(then.longest, otherwise.longest));
  }

  void loop(Range& range, int trips) {
    const Range body = sequence();
    const bool counted = trips >= 0;
    if (!counted) {
      bounds_.known = false;
      bounds_.straight_line = false;
    }
    add(range.longest, body.longest, counted ? trips : 1);
    if (body.leaves) {
      add(range.shortest, counted && trips == 0 ? PathSum{} : least(body.until_leaving, body.shortest));
    } else {
      add(range.shortest, body.shortest, counted ? trips : 0);
    }
  }

  const vm::Program& program_;
  const std::vector<vm::Block>& blocks_;
  const std::vector<PathSum>& of_block_;
  std::size_t next_ = 0;
  PathBounds bounds_;
};

}  // namespace

PathBounds bound_paths(const vm::Program& program, const std::vector<vm::Block>& blocks,
                       const std::vector<PathSum>& of_block) {
  return PathWalker(program, blocks, of_block).run();
}

}  // namespace aluminate::cost
