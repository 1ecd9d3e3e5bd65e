// Program -> Decoded: one operation per live result component, operands resolved to rows and constants.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "platform/host/error.hpp"
#include "platform/number/scalar.hpp"
#include "shading/vm/auto_grids.hpp"
#include "shading/vm/decoded.hpp"
#include "shading/vm/grid_plan.hpp"
#include "shading/vm/operands.hpp"
#include "shading/vm/row_map.hpp"
#include "shading/vm/texture_unit.hpp"

namespace aluminate::vm {
namespace {

constexpr std::uint32_t row_offset(std::int64_t row) { return static_cast<std::uint32_t>(row) * kLanes; }

// A source position after decoding: where it is and whether its sign is still to be flipped.
struct Resolved {
  Operand operand;
  bool negate = false;
};

class Decoder {
 public:
  Decoder(const Program& program, const GridPlan& plan, const Liveness& liveness)
      : program_(program), plan_(plan), liveness_(liveness), map_(map_rows(liveness_)) {
    const number::NumberFormat& format = plan.format;
    out_.format = format;
    out_.frac_bits = plan.frac_bits;
    out_.input_grid = format.default_grid();
    out_.loop_value_limit = std::floor(out_.input_grid.greatest);
    out_.instruction_count = program.code.size();
    out_.uniform_values = static_cast<std::size_t>(program.uniform_count) * 4;
  }

  Decoded decode() {
    lay_out_rows();
    for (const auto& literal : plan_.literals) out_.literals.insert(out_.literals.end(), literal.begin(), literal.end());
    // Every grid an operation can point to, made once so that the pointers stay good: f and its unbounded twin, for
    // results that the Saturate operation bounds afterwards.
    out_.grids.reserve(2 * (number::kUnitFracBits + 1));
    const std::vector<Block> blocks = find_blocks(program_);
    for (const Block& block : blocks) decode_block(block);
    connect_blocks();
    if (program_.straight_line()) find_straight_trips();
    out_.row_count = first_staging_row_ + most_staging_;
    return std::move(out_);
  }

 private:
  // ---- rows ------------------------------------------------------------------------------------------------------

  void lay_out_rows() {
    std::vector<std::uint8_t> read(program_.inputs.size(), 0);
    for (std::size_t i = 0; i < program_.code.size(); ++i)
      for (int s = 0; s < info(program_.code[i].op).sources; ++s) {
        const Source& source = program_.code[i].src[static_cast<std::size_t>(s)];
        if (source.file != RegisterFile::Input) continue;
        const std::uint8_t positions = positions_read(program_, program_.code[i], s, liveness_.live_mask[i]);
        for (std::size_t p = 0; p < 4; ++p)
          if ((positions >> p & 1) != 0) read[source.index] |= static_cast<std::uint8_t>(1u << source.swizzle[p]);
      }
    input_offsets_.assign(read.size(), {});
    for (std::size_t r = 0; r < read.size(); ++r)
      for (std::uint8_t c = 0; c < 4; ++c)
        if ((read[r] >> c & 1) != 0) {
          input_offsets_[r][c] = row_offset(static_cast<std::int64_t>(out_.inputs.size()));
          out_.inputs.push_back({static_cast<std::uint16_t>(r), c});
        }
    out_.input_row = 0;
    first_register_row_ = static_cast<int>(out_.inputs.size());
    first_staging_row_ = first_register_row_ + map_.rows;

    for (std::size_t o = 0; o < map_.outputs.size(); ++o)
      for (std::uint8_t c = 0; c < 4; ++c) {
        if (map_.outputs[o][c] == kNoRow) continue;
        out_.outputs.push_back({static_cast<std::uint16_t>(o), c});
        out_.output_rows.push_back(register_offset(map_.outputs[o][c]));
        if ((liveness_.zero_outputs[o] >> c & 1) != 0) out_.zero_rows.push_back(out_.output_rows.back());
      }
    for (std::size_t t = 0; t < map_.temps.size(); ++t)
      for (std::size_t c = 0; c < 4; ++c)
        if ((liveness_.zero_temps[t] >> c & 1) != 0) out_.zero_rows.push_back(register_offset(map_.temps[t][c]));
  }

  std::uint32_t register_offset(std::int32_t row) const { return row_offset(first_register_row_ + row); }
  std::uint32_t destination_row(std::size_t component) const {
    const Destination& d = now_->dst;
    return register_offset(d.file == RegisterFile::Temp ? map_.temps[d.index][component]
                                                        : map_.outputs[d.index][component]);
  }
  // A row nobody else uses during this instruction.
  std::uint32_t staging_row() {
    most_staging_ = std::max(most_staging_, ++staging_);
    return row_offset(first_staging_row_ + staging_ - 1);
  }

  const number::Grid* grid(bool bounded) {
    number::Grid g = plan_.grid(index_);
    if (!bounded) {
      g.least = std::numeric_limits<double>::lowest();
      g.greatest = std::numeric_limits<double>::max();
    }
    const auto known = std::find(out_.grids.begin(), out_.grids.end(), g);
    if (known != out_.grids.end()) return &*known;
    ALU_CHECK(out_.grids.size() < out_.grids.capacity(), "{} grids", out_.grids.size());
    return &out_.grids.emplace_back(g);
  }

  // ---- sources ---------------------------------------------------------------------------------------------------

  Operand locate(const Source& s, std::size_t component) {
    const auto constant_offset = static_cast<std::uint32_t>(s.index * 4u + component);
    switch (s.file) {
      case RegisterFile::Temp: return {Space::Row, register_offset(map_.temps[s.index][component])};
      case RegisterFile::Input: return {Space::Input, input_offsets_[s.index][component]};
      case RegisterFile::LoopCounter: return {Space::Loop, s.index};
      case RegisterFile::Uniform:
      case RegisterFile::Literal: break;
      case RegisterFile::Output: ALU_CHECK(false, "outputs are not readable");
    }
    const Operand constant{s.file == RegisterFile::Uniform ? Space::Uniform : Space::Literal, constant_offset};
    if (s.relative.base == RelativeBase::None) return constant;
    Operation gather = begin(Kernel::RelativeUniform);
    gather.src[0] = constant;
    gather.relative = s.relative;
    if (s.relative.base == RelativeBase::Temp) {
      gather.src[1] = {Space::Row, register_offset(map_.temps[s.relative.index][s.relative.component])};
    } else {
      gather.loop_level = static_cast<std::uint8_t>(s.relative.index);
    }
    gather.dst = staging_row();
    gather.masked = false;
    push(gather, 0);
    return {Space::Row, gather.dst};
  }

  Operand copy_to_row(const Operand& from, bool absolute, bool negate) {
    Operation copy = begin(Kernel::Copy);
    copy.src[0] = from;
    copy.absolute = absolute;
    copy.negate = negate;
    copy.dst = staging_row();
    copy.masked = false;  // other lanes may be read as neighbours
    push(copy, from.is_row() ? 0 : 1);
    return {Space::Row, copy.dst};
  }

  Resolved resolve(std::size_t source, std::size_t position) {
    const Source& s = now_->src[source];
    const Operand at = locate(s, s.swizzle[position]);
    if (s.absolute) return {copy_to_row(at, true, s.negate), false};
    return {at, s.negate};
  }
  // With every modifier applied.
  Operand resolve_plain(std::size_t source, std::size_t position) {
    const Resolved r = resolve(source, position);
    return r.negate ? copy_to_row(r.operand, false, true) : r.operand;
  }
  Operand in_row(const Operand& operand) { return operand.is_row() ? operand : copy_to_row(operand, false, false); }

  // ---- operations ------------------------------------------------------------------------------------------------

  Operation begin(Kernel kernel) {
    Operation op;
    op.kernel = kernel;
    op.grid = grid(true);
    op.instruction = static_cast<std::uint32_t>(index_);
    op.masked = liveness_.masked[index_];
    return op;
  }

  void push(Operation op, std::uint8_t src_const) {
    op.function = find_kernel({op.kernel, src_const, op.post, op.masked});
    ALU_CHECK(op.function != nullptr, "kernel {} with constant sources {}", static_cast<int>(op.kernel), src_const);
    out_.operations.push_back(op);
  }

  void push_in_place(Kernel kernel, std::uint32_t row) {
    Operation op = begin(kernel);
    op.dst = row;
    op.src[0] = {Space::Row, row};
    push(op, 0);
  }

  static Kernel exact_kernel(Opcode op) {
    switch (op) {
      case Opcode::Frc: return Kernel::Frc;
      case Opcode::Trunc: return Kernel::Trunc;
      case Opcode::Min: return Kernel::Min;
      case Opcode::Max: return Kernel::Max;
      case Opcode::Sge: return Kernel::Sge;
      case Opcode::Sgt: return Kernel::Sgt;
      case Opcode::Seq: return Kernel::Seq;
      case Opcode::Sne: return Kernel::Sne;
      case Opcode::CndGe: return Kernel::CndGe;
      case Opcode::CndGt: return Kernel::CndGt;
      case Opcode::CndEq: return Kernel::CndEq;
      default: return Kernel::Copy;
    }
  }

  // Exact operations keep a range-keeping value in range, except where a sign flips the asymmetric end of qI.F.
  bool exact_result_may_leave_range() const {
    if (out_.format.kind != number::Kind::Saturating) return false;
    return std::any_of(now_->src.begin(), now_->src.begin() + info(now_->op).sources,
                       [](const Source& s) { return s.negate || s.absolute; });
  }

  void emit_exact(std::size_t component, std::uint32_t dst) {
    Operation op = begin(exact_kernel(now_->op));
    op.dst = dst;
    std::uint8_t constants = 0;
    if (now_->op == Opcode::Mov) {
      const Source& s = now_->src[0];
      op.src[0] = locate(s, s.swizzle[component]);
      op.absolute = s.absolute;
      op.negate = s.negate;
      constants = op.src[0].is_row() ? 0 : 1;
    } else {
      const auto sources = static_cast<std::size_t>(info(now_->op).sources);
      for (std::size_t s = 0; s < sources; ++s) {
        op.src[s] = resolve_plain(s, component);
        // The first source of one- and three-operand kernels is a row, and so is one of two.
        const bool row_wanted = s == 0 ? sources != 2 : sources == 2 && (constants & 1) != 0;
        if (row_wanted) op.src[s] = in_row(op.src[s]);
        if (!op.src[s].is_row()) constants |= static_cast<std::uint8_t>(1u << s);
      }
    }
    push(op, constants);
    if (now_->saturate) {
      push_in_place(Kernel::Saturate, dst);
    } else if (exact_result_may_leave_range()) {
      push_in_place(Kernel::ClampRange, dst);
    }
  }

  Operation begin_rounded(Kernel kernel, std::uint32_t dst) {
    Operation op = begin(kernel);
    op.dst = dst;
    op.post = now_->saturate ? Post::Saturate : Post::Range;
    return op;
  }

  void emit_add(std::size_t component, std::uint32_t dst) {
    Resolved a = resolve(0, component), b = resolve(1, component);
    const int position = static_cast<int>(component);
    const number::AddForm form =
        number::add_form(plan_.frac_bits[index_], plan_.source_frac_bits(program_, index_, 0, position),
                         plan_.source_frac_bits(program_, index_, 1, position));
    Operation op = begin_rounded(Kernel::Add, dst);
    if (form == number::AddForm::Plain) {
      if (a.negate && !b.negate) std::swap(a, b);
      if (a.negate) a = {copy_to_row(a.operand, false, true), false};
      if (b.negate) op.kernel = Kernel::Sub;
    } else {
      if (a.negate) a = {copy_to_row(a.operand, false, true), false};
      if (b.negate) b = {copy_to_row(b.operand, false, true), false};
      op.kernel = form == number::AddForm::RoundSum ? Kernel::AddRoundSum : Kernel::AddRound;
      if (form == number::AddForm::RoundA) std::swap(a, b);  // AddRound adds the finer operand last
    }
    push_binary(op, a.operand, b.operand);
  }

  void push_binary(Operation op, Operand a, Operand b) {
    if (!a.is_row() && !b.is_row()) a = copy_to_row(a, false, false);
    op.src[0] = a;
    op.src[1] = b;
    push(op, static_cast<std::uint8_t>((a.is_row() ? 0 : 1) | (b.is_row() ? 0 : 2)));
  }

  void emit_mul(std::size_t component, std::uint32_t dst) {
    const Resolved a = resolve(0, component), b = resolve(1, component);
    push_binary(begin_rounded(a.negate != b.negate ? Kernel::NegMul : Kernel::Mul, dst), a.operand, b.operand);
  }

  void emit_mad(std::size_t component, std::uint32_t dst) {
    Resolved a = resolve(0, component), b = resolve(1, component);
    const Resolved c = resolve(2, component);
    const bool negative = a.negate != b.negate;
    Operation op = begin_rounded(negative ? (c.negate ? Kernel::NegMadNegC : Kernel::NegMad)
                                          : (c.negate ? Kernel::MadNegC : Kernel::Mad), dst);
    if (!a.operand.is_row()) std::swap(a, b);
    op.src = {in_row(a.operand), b.operand, c.operand};
    push(op, static_cast<std::uint8_t>((b.operand.is_row() ? 0 : 2) | (c.operand.is_row() ? 0 : 4)));
  }

  void emit_dot(std::uint32_t dst) {
    const std::size_t terms = now_->op == Opcode::Dp2Add ? 2 : now_->op == Opcode::Dp3 ? 3 : 4;
    const bool negative = (now_->src[0].negate && !now_->src[0].absolute) != (now_->src[1].negate && !now_->src[1].absolute);
    constexpr Kernel kKernels[2][3] = {{Kernel::Dot2, Kernel::Dot3, Kernel::Dot4},
                                       {Kernel::NegDot2, Kernel::NegDot3, Kernel::NegDot4}};
    Operation op = begin_rounded(kKernels[negative ? 1 : 0][terms - 2], dst);
    std::uint8_t constants = 0;
    for (std::size_t t = 0; t < terms; ++t) {
      Operand a = resolve(0, t).operand, b = resolve(1, t).operand;
      if (!a.is_row()) std::swap(a, b);
      op.src[2 * t] = in_row(a);
      op.src[2 * t + 1] = b;
      constants = b.is_row() ? 0 : 2;  // all components of a source come from the same file
    }
    if (terms == 2) op.src[4] = in_row(resolve_plain(2, 0));
    push(op, constants);
  }

  Kernel defined_function() const {
    const bool reference = out_.format.kind == number::Kind::Reference;
    switch (now_->op) {
      case Opcode::Rcp: return reference ? Kernel::RcpReference : Kernel::Rcp;
      case Opcode::Rsq: return reference ? Kernel::RsqReference : Kernel::Rsq;
      case Opcode::Exp: return reference ? Kernel::ExpReference : Kernel::Exp;
      case Opcode::Log: return reference ? Kernel::LogReference : Kernel::Log;
      case Opcode::Sqrt: return Kernel::Sqrt;
      case Opcode::Sin: return Kernel::Sin;
      case Opcode::Cos: return Kernel::Cos;
      default: return Kernel::Flr;
    }
  }

  void emit_function(std::size_t position, std::uint32_t dst) {
    Operation op = begin(defined_function());
    op.dst = dst;
    op.post = Post::Range;
    op.grid = grid(!now_->saturate);
    op.operand_step = plan_.operand_step(program_, index_, static_cast<int>(position));
    op.src[0] = in_row(resolve_plain(0, position));
    push(op, 0);
    if (now_->saturate) push_in_place(Kernel::Saturate, dst);
  }

  void emit_derivative(std::size_t component, std::uint32_t dst) {
    Operation op = begin(now_->op == Opcode::DsX ? Kernel::DsX : Kernel::DsY);
    op.dst = dst;
    op.post = Post::Range;
    op.grid = grid(!now_->saturate);
    op.src[0] = resolve_plain(0, component);
    push(op, 0);
    if (now_->saturate) push_in_place(Kernel::Saturate, dst);
  }

  void emit_component(std::size_t component, std::uint32_t dst) {
    switch (now_->op) {
      case Opcode::Add: emit_add(component, dst); break;
      case Opcode::Mul: emit_mul(component, dst); break;
      case Opcode::Mad: emit_mad(component, dst); break;
      case Opcode::Flr: emit_function(component, dst); break;
      case Opcode::DsX:
      case Opcode::DsY: emit_derivative(component, dst); break;
      default: emit_exact(component, dst); break;
    }
  }

  // Does producing `component` read the row that `row_of` is written to?
  bool reads_destination_of(std::size_t component, std::size_t row_of) const {
    if (now_->dst.file != RegisterFile::Temp) return false;
    for (std::size_t s = 0; s < static_cast<std::size_t>(info(now_->op).sources); ++s) {
      const Source& source = now_->src[s];
      if (source.file == RegisterFile::Temp && source.index == now_->dst.index && source.swizzle[component] == row_of)
        return true;
      if (source.relative.base == RelativeBase::Temp && source.relative.index == now_->dst.index &&
          source.relative.component == row_of)
        return true;
    }
    return false;
  }

  // Components in an order that reads every register before it is overwritten; cycles go through a spare row.
  void emit_per_component(std::uint8_t wanted) {
    std::vector<std::pair<std::size_t, std::uint32_t>> delayed;
    while (wanted != 0) {
      std::size_t pick = 4;
      for (std::size_t c = 0; c < 4 && pick == 4; ++c) {
        if ((wanted >> c & 1) == 0) continue;
        bool needed = false;
        for (std::size_t other = 0; other < 4; ++other)
          needed |= other != c && (wanted >> other & 1) != 0 && reads_destination_of(other, c);
        if (!needed) pick = c;
      }
      if (pick < 4) {
        emit_component(pick, destination_row(pick));
      } else {
        pick = static_cast<std::size_t>(std::countr_zero(wanted));
        delayed.emplace_back(pick, staging_row());
        emit_component(pick, delayed.back().second);
      }
      wanted = static_cast<std::uint8_t>(wanted & ~(1u << pick));
    }
    for (const auto& [component, row] : delayed) copy_register(row, destination_row(component));
  }

  void copy_register(std::uint32_t from, std::uint32_t to) {
    Operation copy = begin(Kernel::Copy);
    copy.src[0] = {Space::Row, from};
    copy.dst = to;
    push(copy, 0);
  }

  void emit_texture(std::uint8_t wanted) {
    Operation op = begin(Kernel::Texture);
    op.texture_op = now_->op;
    op.sampler = now_->sampler;
    op.texture_mask = wanted;
    op.dimension = program_.samplers[now_->sampler].dimension;
    for (std::size_t i = 0; i < op.src.size(); ++i) {
      const FetchOperand from = fetch_operand(op.texture_op, op.dimension, i);
      op.src[i] = from.source < 0 ? op.src[0]
                                  : in_row(resolve_plain(static_cast<std::size_t>(from.source), static_cast<std::size_t>(from.position)));
    }
    for (std::size_t c = 0; c < 4; ++c)
      if ((wanted >> c & 1) != 0) op.texture_dst[c] = destination_row(c);
    push(op, 0);
  }

  void emit_test() {
    Operation op = begin(Kernel::NotZero);
    switch (now_->op) {
      case Opcode::KillGt: op.kernel = Kernel::KillGt; break;
      case Opcode::KillGe: op.kernel = Kernel::KillGe; break;
      case Opcode::KillNe: op.kernel = Kernel::KillNe; break;
      case Opcode::KillEq: op.kernel = Kernel::KillEq; break;
      default: break;
    }
    for (std::size_t s = 0; s < static_cast<std::size_t>(info(now_->op).sources); ++s) op.src[s] = resolve_plain(s, 0);
    push(op, 0);
  }

  void emit(std::size_t index) {
    index_ = index;
    now_ = &program_.code[index];
    staging_ = 0;
    const std::uint8_t wanted = liveness_.live_mask[index];
    const Shape shape = shape_of(now_->op);
    if (shape == Shape::Marker) return;
    if (shape == Shape::Test) return emit_test();
    if (shape == Shape::Texture) return emit_texture(wanted);
    if (wanted == 0) return;
    if (shape == Shape::PerComponent) return emit_per_component(wanted);
    const auto first = static_cast<std::size_t>(std::countr_zero(wanted));
    if (shape == Shape::Dot) {
      emit_dot(destination_row(first));
    } else {
      emit_function(0, destination_row(first));
    }
    for (std::size_t c = first + 1; c < 4; ++c)
      if ((wanted >> c & 1) != 0) copy_register(destination_row(first), destination_row(c));
  }

  // ---- blocks ----------------------------------------------------------------------------------------------------

  void decode_block(const Block& block) {
    DecodedBlock decoded;
    decoded.first = static_cast<std::uint32_t>(out_.operations.size());
    for (std::uint32_t i = block.begin; i < block.end; ++i) emit(i);
    decoded.last = static_cast<std::uint32_t>(out_.operations.size());
    const Instruction& end = program_.code[block.end - 1];
    decoded.instruction = block.end - 1;
    decoded.trip_count = end.trip_count;
    switch (end.op) {
      case Opcode::If: decoded.flow = Flow::If; break;
      case Opcode::Else: decoded.flow = Flow::Else; break;
      case Opcode::EndIf: decoded.flow = Flow::EndIf; break;
      case Opcode::Loop: decoded.flow = Flow::Loop; break;
      case Opcode::EndLoop: decoded.flow = Flow::EndLoop; break;
      case Opcode::Break: decoded.flow = Flow::Break; break;
      case Opcode::Continue: decoded.flow = Flow::Continue; break;
      default: break;
    }
    out_.blocks.push_back(decoded);
  }

  void connect_blocks() {
    struct Open {
      std::uint32_t block;                  // of the If, Else or Loop that opened the region
      std::vector<std::uint32_t> inside;    // blocks that jump to the end of this region when no lane is left
      bool loop;
    };
    std::vector<Open> open;
    auto& blocks = out_.blocks;
    int loops = 0;
    const auto close = [&](std::uint32_t end) {
      blocks[open.back().block].target = end;
      for (std::uint32_t b : open.back().inside) blocks[b].target = end;
      open.pop_back();
    };
    const auto leave_to_region_end = [&](std::uint32_t b) {
      if (!open.empty()) open.back().inside.push_back(b);
    };
    for (std::uint32_t b = 0; b < blocks.size(); ++b) {
      DecodedBlock& block = blocks[b];
      switch (block.flow) {
        case Flow::None: break;
        case Flow::If:
          block.level = static_cast<std::uint8_t>(open.size());
          open.push_back({b, {}, false});
          break;
        case Flow::Else:
          close(b);
          block.level = static_cast<std::uint8_t>(open.size());
          open.push_back({b, {}, false});
          break;
        case Flow::EndIf:
          close(b);
          block.level = static_cast<std::uint8_t>(open.size());
          leave_to_region_end(b);
          break;
        case Flow::Loop:
          block.level = static_cast<std::uint8_t>(open.size());
          block.loop = static_cast<std::uint8_t>(loops++);
          open.push_back({b, {}, true});
          break;
        case Flow::EndLoop: {
          const std::uint32_t begin = open.back().block;
          close(b);
          --loops;
          block.level = blocks[begin].level;
          block.loop = blocks[begin].loop;
          block.trip_count = blocks[begin].trip_count;
          block.instruction = blocks[begin].instruction;
          block.target = begin + 1;
          break;
        }
        case Flow::Break:
        case Flow::Continue: {
          const auto loop = std::find_if(open.rbegin(), open.rend(), [](const Open& o) { return o.loop; });
          block.level = blocks[loop->block].level;
          leave_to_region_end(b);
          break;
        }
      }
      out_.level_count = std::max(out_.level_count, static_cast<int>(open.size()));
      out_.loop_count = std::max(out_.loop_count, loops);
    }
  }

  void find_straight_trips() {
    std::vector<std::uint64_t> around = {1};  // executions of the blocks at each depth
    for (const DecodedBlock& block : out_.blocks) {
      out_.straight_trips.push_back(around.back());
      if (block.flow == Flow::Loop) around.push_back(around.back() * static_cast<std::uint64_t>(block.trip_count));
      if (block.flow == Flow::EndLoop) around.pop_back();
    }
  }

  const Program& program_;
  const GridPlan& plan_;
  const Liveness& liveness_;
  RowMap map_;
  Decoded out_;
  std::vector<std::array<std::uint32_t, 4>> input_offsets_;
  int first_register_row_ = 0, first_staging_row_ = 0;
  int staging_ = 0, most_staging_ = 0;
  std::size_t index_ = 0;
  const Instruction* now_ = nullptr;
};

}  // namespace

Executable prepare(const Program& program, const number::NumberFormat& format) {
  validate(program);
  const Liveness liveness = find_liveness(program);
  GridPlan plan = plan_grids(program, format, default_frac_bits(program, format));
  const auto decode = [&](const GridPlan& grids) { return Decoder(program, grids, liveness).decode(); };
  Decoded decoded = decode(plan);
  if (format.finest) decoded = refine_grids(program, plan, std::move(decoded), decode);
  return Executable(std::make_shared<const Decoded>(std::move(decoded)));
}

}  // namespace aluminate::vm
