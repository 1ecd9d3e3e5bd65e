#include "shading/vm/jit/row_liveness.hpp"

namespace aluminate::vm::jit {
namespace {

bool merge(RowSet& into, const RowSet& from) {
  bool changed = false;
  for (std::size_t r = 0; r < into.size(); ++r)
    if (from[r] && !into[r]) into[r] = changed = true;
  return changed;
}

}  // namespace

int source_count(const Operation& op) {
  switch (op.kernel) {
    case Kernel::Add:
    case Kernel::Sub:
    case Kernel::AddRound:
    case Kernel::AddRoundSum:
    case Kernel::Mul:
    case Kernel::NegMul:
    case Kernel::Min:
    case Kernel::Max:
    case Kernel::Sge:
    case Kernel::Sgt:
    case Kernel::Seq:
    case Kernel::Sne:
    case Kernel::KillGt:
    case Kernel::KillGe:
    case Kernel::KillNe:
    case Kernel::KillEq: return 2;
    case Kernel::Mad:
    case Kernel::NegMad:
    case Kernel::MadNegC:
    case Kernel::NegMadNegC:
    case Kernel::CndGe:
    case Kernel::CndGt:
    case Kernel::CndEq: return 3;
    case Kernel::Dot2:
    case Kernel::NegDot2: return 5;
    case Kernel::Dot3:
    case Kernel::NegDot3: return 6;
    case Kernel::Dot4:
    case Kernel::NegDot4: return 8;
    case Kernel::Texture: return static_cast<int>(op.src.size());
    case Kernel::RelativeUniform: return op.relative.base == RelativeBase::Temp ? 2 : 1;
    default: return 1;
  }
}

RowLiveness::RowLiveness(const Decoded& decoded)
    : d_(decoded), end_(decoded.blocks.size(), RowSet(static_cast<std::size_t>(decoded.row_count), false)) {
  RowSet outputs(static_cast<std::size_t>(decoded.row_count), false);
  for (std::uint32_t row : decoded.output_rows) outputs[row / kLanes] = true;
  std::vector<RowSet> begin = end_;
  const std::size_t blocks = decoded.blocks.size();
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t b = blocks; b-- > 0;) {
      const DecodedBlock& block = decoded.blocks[b];
      RowSet live = b + 1 < blocks ? begin[b + 1] : outputs;
      if (block.flow == Flow::EndLoop) merge(live, begin[block.target]);
      if (block.flow == Flow::Loop) merge(live, block.target + 1 < blocks ? begin[block.target + 1] : outputs);
      // No lane left: control goes on where the enclosing region ends.
      if (block.flow != Flow::None && block.flow != Flow::Loop && block.flow != Flow::EndLoop) merge(live, end_[block.target]);
      changed |= merge(end_[b], live);
      RowSet at_begin = end_[b];
      for (std::uint32_t i = block.last; i-- > block.first;) step_back(decoded.operations[i], at_begin);
      changed |= merge(begin[b], at_begin);
    }
  }
}

void RowLiveness::step_back(const Operation& op, RowSet& live) const {
  const bool keeps_some = op.masked;
  if (op.kernel == Kernel::Texture) {
    for (std::size_t c = 0; c < 4; ++c)
      if ((op.texture_mask >> c & 1) != 0) live[op.texture_dst[c] / kLanes] = keeps_some;
  } else if (op.kernel < Kernel::KillGt) {
    live[op.dst / kLanes] = keeps_some;
  }
  for (int s = 0; s < source_count(op); ++s) {
    const Operand& operand = op.src[static_cast<std::size_t>(s)];
    if (operand.space == Space::Row) live[operand.offset / kLanes] = true;
  }
}

RowSet RowLiveness::after(std::size_t block, std::uint32_t index) const {
  RowSet live = end_[block];
  for (std::uint32_t i = d_.blocks[block].last; i-- > index + 1;) step_back(d_.operations[i], live);
  return live;
}

}  // namespace aluminate::vm::jit
