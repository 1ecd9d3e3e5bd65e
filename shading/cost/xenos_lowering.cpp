#include "shading/cost/xenos_lowering.hpp"

#include "platform/host/error.hpp"
#include "shading/cost/xenos_rewrite.hpp"

#include <map>
#include <span>

namespace aluminate::cost {
namespace {

using vm::Opcode;

/// A component as later reads see it: where it is and what to apply when reading it.
struct Value {
  Ref ref{};
  bool negate = false, absolute = false;
};

Value literal_value(double number) {
  Value value;
  value.ref.kind = Ref::Kind::Literal;
  value.ref.value = number;
  return value;
}

bool is_compare(Opcode op) {
  return op == Opcode::Sge || op == Opcode::Sgt || op == Opcode::Seq || op == Opcode::Sne;
}

/// Translates one block, keeping for every temp component the value it holds so that copies cost nothing.
class BlockBuilder {
 public:
  BlockBuilder(const vm::Program& program, const std::vector<std::uint8_t>& homes)
      : program_(program), homes_(homes) {
    for (std::size_t temp = 0; temp < homes.size(); ++temp) {
      std::array<Value, 4> values;
      for (std::uint8_t c = 0; c < 4; ++c) {
        values[c].ref.kind = Ref::Kind::Home;
        values[c].ref.index = static_cast<std::uint32_t>(temp);
        values[c].ref.component = c;
      }
      temps_.push_back(values);
    }
    outputs_.resize(program.outputs.size());
  }

  void translate(const vm::Block& block) {
    for (std::uint32_t i = block.begin; i < block.end; ++i) {
      at_ = i;
      const vm::Instruction& instruction = program_.code[i];
      switch (vm::info(instruction.op).pipe) {
        case vm::Pipe::Flow:
          flow(instruction);
          break;
        case vm::Pipe::Fetch:
          fetch(instruction);
          break;
        default:
          arithmetic(instruction);
          break;
      }
    }
  }

  BlockResults results() && {
    BlockResults out;
    out.graph = std::move(graph_);
    for (std::size_t o = 0; o < outputs_.size(); ++o) {
      for (std::uint8_t c = 0; c < 4; ++c) {
        if (!outputs_[o].written[c]) continue;
        const Value& value = outputs_[o].values[c];
        out.exports.push_back(
            {static_cast<std::uint16_t>(o), c, value.ref, value.negate, value.absolute, outputs_[o].origin});
      }
    }
    for (std::size_t temp = 0; temp < temps_.size(); ++temp) {
      for (std::uint8_t c = 0; c < 4; ++c) {
        if ((homes_[temp] >> c & 1) == 0) continue;
        const Value& value = temps_[temp][c];
        const bool unchanged = value.ref.kind == Ref::Kind::Home && value.ref.index == temp &&
                               value.ref.component == c && !value.negate && !value.absolute;
        if (!unchanged)
          out.homes.push_back(
              {static_cast<std::uint16_t>(temp), c, value.ref, value.negate, value.absolute, at_});
      }
    }
    return out;
  }

 private:
  struct OutputState {
    std::array<Value, 4> values{};
    std::array<bool, 4> written{};
    std::uint32_t origin = 0;
  };

  Value read(const vm::Source& source, int lane) {
    const std::uint8_t c = source.swizzle[static_cast<std::size_t>(lane)];
    Value value;
    value.ref.component = c;
    value.ref.index = source.index;
    switch (source.file) {
      case vm::RegisterFile::Temp:
        value = temps_[source.index][c];
        break;
      case vm::RegisterFile::Input:
        value.ref.kind = Ref::Kind::Input;
        break;
      case vm::RegisterFile::LoopCounter:
        value.ref.kind = Ref::Kind::Counter;
        value.ref.component = 0;
        break;
      case vm::RegisterFile::Literal:
        if (source.relative.base == vm::RelativeBase::None) {
          value = literal_value(program_.literals[source.index][c]);
          break;
        }
        [[fallthrough]];
      case vm::RegisterFile::Uniform:
        value.ref.kind = Ref::Kind::Constant;
        value.ref.file = source.file;
        value.ref.relative = source.relative;
        if (source.relative.base == vm::RelativeBase::Temp)
          value.ref.address_node = address_of(source.relative);
        break;
      case vm::RegisterFile::Output:
        ALU_CHECK(false, "outputs are write only");
        break;
    }
    if (source.absolute) {
      value.absolute = true;
      value.negate = false;
    }
    value.negate ^= source.negate;
    if (value.ref.kind == Ref::Kind::Literal) {  // modifiers fold into the number
      const double magnitude = value.absolute && value.ref.value < 0 ? -value.ref.value : value.ref.value;
      value.ref.value = value.negate ? 0.0 - magnitude : magnitude;
      value.negate = value.absolute = false;
    }
    return value;
  }

  /// The node that loads the address register from a temp component; one for each distinct value.
  int address_of(const vm::Relative& relative) {
    const Value value = temps_[relative.index][relative.component];
    for (std::size_t i = 0; i < graph_.nodes.size(); ++i) {
      const Node& node = graph_.nodes[i];
      if (node.special == Special::LoadAddress && node.src[0].refs[0] == value.ref &&
          node.src[0].negate == value.negate && node.src[0].absolute == value.absolute) {
        return static_cast<int>(i);
      }
    }
    Node node = fresh(Opcode::Mov, 1);
    node.special = Special::LoadAddress;
    node.dest = DestKind::Effect;
    node.src[0] = operand_of({&value, 1});
    return graph_.add(node);
  }

  Node fresh(Opcode op, int width) const {
    Node node;
    node.op = op;
    node.width = width;
    node.sources = vm::info(op).sources;
    node.origin = at_;
    node.line = program_.code[at_].line;
    return node;
  }

  /// One operand from up to four values. Modifiers hold for a whole operand, so lanes that disagree are
  /// copied first.
  Operand operand_of(std::span<const Value> values) {
    Operand operand;
    operand.count = static_cast<int>(values.size());
    const Value* pattern = nullptr;
    for (const Value& value : values) {
      if (value.ref.kind != Ref::Kind::Literal && pattern == nullptr) pattern = &value;
    }
    bool agree = true;
    for (const Value& value : values) {
      if (pattern == nullptr) break;
      if (value.ref.kind == Ref::Kind::Literal) {
        agree = agree && !pattern->absolute;
      } else {
        agree = agree && value.negate == pattern->negate && value.absolute == pattern->absolute;
      }
    }
    if (agree && pattern != nullptr) {
      operand.negate = pattern->negate;
      operand.absolute = pattern->absolute;
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
      Ref ref = values[i].ref;
      if (ref.kind == Ref::Kind::Literal) {
        if (operand.negate) ref.value = 0.0 - ref.value;
      } else if (!agree && (values[i].negate || values[i].absolute)) {
        Node copy = fresh(Opcode::Mov, 1);
        copy.src[0].count = 1;
        copy.src[0].refs[0] = ref;
        copy.src[0].negate = values[i].negate;
        copy.src[0].absolute = values[i].absolute;
        ref = node_ref(graph_.add(copy), 0);
      }
      operand.refs[i] = ref;
    }
    return operand;
  }

  Operand operand_of(const vm::Source& source, std::span<const int> lanes) {
    std::array<Value, 4> values;
    for (std::size_t i = 0; i < lanes.size(); ++i) values[i] = read(source, lanes[i]);
    return operand_of({values.data(), lanes.size()});
  }

  /// After an instruction: destination component c holds lane lane_of[c] of the node.
  void write(const vm::Destination& dst, int node, const std::array<int, 4>& lane_of) {
    for (std::uint8_t c = 0; c < 4; ++c) {
      if ((dst.mask >> c & 1) == 0) continue;
      Value value;
      value.ref = node_ref(node, lane_of[c]);
      write_component(dst, c, value);
    }
  }

  void write_component(const vm::Destination& dst, std::uint8_t c, const Value& value) {
    if (dst.file == vm::RegisterFile::Temp) {
      temps_[dst.index][c] = value;
    } else {
      OutputState& output = outputs_[dst.index];
      output.values[c] = value;
      output.written[c] = true;
      output.origin = at_;
    }
  }

  void arithmetic(const vm::Instruction& instruction) {
    const vm::OpcodeInfo& info = vm::info(instruction.op);
    if (instruction.op == Opcode::Mov &&
        !instruction.saturate) {  // a copy is only a name, until something needs it placed
      std::array<Value, 4> values;
      for (std::uint8_t c = 0; c < 4; ++c) {
        if (instruction.dst.mask >> c & 1) values[c] = read(instruction.src[0], c);
      }
      for (std::uint8_t c = 0; c < 4; ++c) {
        if (instruction.dst.mask >> c & 1) write_component(instruction.dst, c, values[c]);
      }
      return;
    }
    Node node = fresh(instruction.op, 1);
    node.saturate = instruction.saturate;
    std::array<int, 4> lane_of{};
    if (instruction.dst.mask == 0) {  // Kill
      node.dest = DestKind::Effect;
      constexpr int kFirst[] = {0};
      for (std::size_t s = 0; s < 2; ++s) node.src[s] = operand_of(instruction.src[s], kFirst);
    } else if (node.is_reduction() || info.pipe == vm::Pipe::Scalar) {
      constexpr int kAll[] = {0, 1, 2, 3};
      const std::size_t lanes = info.pipe == vm::Pipe::Scalar ? 1
                                : node.op == Opcode::Dp2Add   ? 2
                                : node.op == Opcode::Dp3      ? 3
                                                              : 4;
      for (std::size_t s = 0; s < static_cast<std::size_t>(info.sources); ++s) {
        node.src[s] = operand_of(instruction.src[s], {kAll, s == 2 ? 1 : lanes});
      }
    } else {
      std::array<int, 4> components{};
      std::size_t count = 0;
      for (int c = 0; c < 4; ++c) {
        if (instruction.dst.mask >> c & 1) components[count++] = c;
      }
      for (std::size_t s = 0; s < static_cast<std::size_t>(info.sources); ++s) {
        node.src[s] = operand_of(instruction.src[s], {components.data(), count});
      }
      const std::array<int, 4> unique = drop_equal_lanes(node, static_cast<int>(count));
      for (std::size_t i = 0; i < count; ++i) lane_of[static_cast<std::size_t>(components[i])] = unique[i];
    }
    write(instruction.dst, graph_.add(node), lane_of);
  }

  void flow(const vm::Instruction& instruction) {
    if (vm::info(instruction.op).sources == 0) return;
    const Value condition = read(instruction.src[0], 0);
    Node node = fresh(Opcode::Sne, 1);
    node.special = Special::SetPredicate;
    node.dest = DestKind::Effect;
    // The set-predicate operations compare two operands themselves, so a comparison in front of the branch is
    // free.
    const bool fuse = condition.ref.kind == Ref::Kind::Node &&
                      is_compare(graph_.nodes[condition.ref.index].op) &&
                      !graph_.nodes[condition.ref.index].saturate && !condition.absolute;
    if (fuse) {
      const Node& compare = graph_.nodes[condition.ref.index];
      node.op = compare.op;
      for (std::size_t s = 0; s < 2; ++s) {
        node.src[s] = compare.src[s];
        node.src[s].count = 1;
        node.src[s].refs[0] = compare.src[s].refs[condition.ref.component];
      }
    } else {
      node.src[0] = operand_of({&condition, 1});
      const Value zero = literal_value(0.0);
      node.src[1] = operand_of({&zero, 1});
    }
    graph_.add(node);
  }

  void fetch(const vm::Instruction& instruction) {
    Node node = fresh(instruction.op, 0);
    node.sources = 1;
    node.sampler = instruction.sampler;
    node.saturate = instruction.saturate;
    std::array<int, 4> lane_of{};
    for (std::size_t c = 0; c < 4; ++c) {
      if ((instruction.dst.mask >> c & 1) == 0) continue;
      node.texel_component[static_cast<std::size_t>(node.width)] = static_cast<std::uint8_t>(c);
      lane_of[c] = node.width++;
    }
    if (node.op == Opcode::DsX || node.op == Opcode::DsY) {
      std::array<int, 4> components{};
      std::size_t count = 0;
      for (int c = 0; c < 4; ++c) {
        if (instruction.dst.mask >> c & 1) components[count++] = c;
      }
      node.src[0] = operand_of(instruction.src[0], {components.data(), count});
    } else {
      texture(instruction, node);
    }
    // The fetch word's destination swizzle selects components; it cannot clamp.
    if (!instruction.saturate) {
      write(instruction.dst, graph_.add(node), lane_of);
      return;
    }
    node.saturate = false;
    Node clamp = fresh(Opcode::Mov, node.width);
    clamp.sources = 1;
    clamp.saturate = true;
    clamp.src[0].count = node.width;
    const int fetched = graph_.add(node);
    for (int lane = 0; lane < node.width; ++lane)
      clamp.src[0].refs[static_cast<std::size_t>(lane)] = node_ref(fetched, lane);
    write(instruction.dst, graph_.add(clamp), lane_of);
  }

  void texture(const vm::Instruction& instruction, Node& node) {
    const vm::SamplerDimension dimension = program_.samplers[instruction.sampler].dimension;
    constexpr int kCoordinates[] = {0, 1, 2};
    const std::size_t count = dimension == vm::SamplerDimension::Tex2D ? 2 : 3;
    node.src[0] = operand_of(instruction.src[0], {kCoordinates, count});
    if (instruction.op == Opcode::TexBias || instruction.op == Opcode::TexLod) {
      constexpr int kLevel[] = {3};
      node.after = setup_word(operand_of(instruction.src[0], kLevel), -1);
    } else if (instruction.op == Opcode::TexGrad) {
      const int along_x = setup_word(operand_of(instruction.src[1], {kCoordinates, count}), -1);
      node.after = setup_word(operand_of(instruction.src[2], {kCoordinates, count}), along_x);
    }
    if (dimension == vm::SamplerDimension::TexCube) expand_cube(node);
  }

  int setup_word(const Operand& operand, int after) {
    Node setup = fresh(Opcode::Tex, 1);
    setup.special = Special::FetchSetup;
    setup.dest = DestKind::Effect;
    setup.sources = 1;
    setup.src[0] = operand;
    setup.after = after;
    return graph_.add(setup);
  }

  /// cube (face selection); mov face | rcp |2 ma|; mad 1.5: three words and then a 2D fetch with the face as
  /// third coordinate [XEN-U, UNI].
  void expand_cube(Node& node) {
    Node cube = fresh(Opcode::Mov, 4);
    cube.special = Special::Cube;
    cube.sources = 1;
    cube.src[0] = node.src[0];
    const int faces = graph_.add(cube);

    Node face = fresh(Opcode::Mov, 1);
    face.sources = 1;
    face.src[0].count = 1;
    face.src[0].refs[0] = node_ref(faces, 3);
    const int face_copy = graph_.add(face);

    Node reciprocal = fresh(Opcode::Rcp, 1);
    reciprocal.src[0].count = 1;
    reciprocal.src[0].refs[0] = node_ref(faces, 2);
    reciprocal.src[0].absolute = true;
    const int scale = graph_.add(reciprocal);

    Node scaled = fresh(Opcode::Mad, 2);
    for (std::size_t lane = 0; lane < 2; ++lane) {
      scaled.src[0].refs[lane] = node_ref(faces, static_cast<int>(lane));
      scaled.src[1].refs[lane] = node_ref(scale, 0);
      scaled.src[2].refs[lane] = literal_value(1.5).ref;
    }
    for (Operand& operand : scaled.src) operand.count = 2;
    const int coordinates = graph_.add(scaled);

    node.src[0] = Operand{};
    node.src[0].count = 3;
    node.src[0].refs[0] = node_ref(coordinates, 0);
    node.src[0].refs[1] = node_ref(coordinates, 1);
    node.src[0].refs[2] = node_ref(face_copy, 0);
  }

  const vm::Program& program_;
  const std::vector<std::uint8_t>& homes_;
  Graph graph_;
  std::vector<std::array<Value, 4>> temps_;
  std::vector<OutputState> outputs_;
  std::uint32_t at_ = 0;
};

}  // namespace

std::vector<std::uint8_t> components_across_blocks(const vm::Program& program,
                                                   const std::vector<vm::Block>& blocks) {
  std::vector<std::uint8_t> across(static_cast<std::size_t>(program.temp_count), 0);
  for (const vm::Block& block : blocks) {
    std::vector<std::uint8_t> written(across.size(), 0);
    const auto reads = [&](std::uint16_t temp, int c) {
      if ((written[temp] >> c & 1) == 0) across[temp] |= static_cast<std::uint8_t>(1 << c);
    };
    for (std::uint32_t i = block.begin; i < block.end; ++i) {
      const vm::Instruction& instruction = program.code[i];
      for (std::size_t s = 0; s < static_cast<std::size_t>(vm::info(instruction.op).sources); ++s) {
        const vm::Source& source = instruction.src[s];
        if (source.relative.base == vm::RelativeBase::Temp)
          reads(source.relative.index, source.relative.component);
        if (source.file != vm::RegisterFile::Temp) continue;
        for (int lane = 0; lane < 4; ++lane) {
          if (reads_lane(program, instruction, static_cast<int>(s), lane))
            reads(source.index, source.swizzle[static_cast<std::size_t>(lane)]);
        }
      }
      if (instruction.dst.file == vm::RegisterFile::Temp && instruction.dst.mask != 0)
        written[instruction.dst.index] |= instruction.dst.mask;
    }
  }
  return across;
}

Graph lower_block(const vm::Program& program, const vm::Block& block, const std::vector<std::uint8_t>& homes,
                  Packing packing) {
  BlockBuilder builder(program, homes);
  builder.translate(block);
  BlockResults results = std::move(builder).results();
  return rewrite_block(std::move(results), packing);
}

}  // namespace aluminate::cost
