#include "shading/compiler/lowerer.hpp"

#include <spirv/unified1/spirv.hpp11>

#include <algorithm>

namespace aluminate::compiler {
namespace {

constexpr auto kOffset = static_cast<std::uint32_t>(spv::Decoration::Offset);
constexpr auto kArrayStride = static_cast<std::uint32_t>(spv::Decoration::ArrayStride);
constexpr auto kMatrixStride = static_cast<std::uint32_t>(spv::Decoration::MatrixStride);
constexpr auto kRowMajor = static_cast<std::uint32_t>(spv::Decoration::RowMajor);

bool is_uniform(std::uint32_t storage) {
  return storage == static_cast<std::uint32_t>(spv::StorageClass::Uniform) ||
         storage == static_cast<std::uint32_t>(spv::StorageClass::PushConstant);
}

}  // namespace

Pointer Lowerer::pointer(SpvId id) {
  if (auto it = pointers_.find(id); it != pointers_.end()) return it->second;
  const SpirvInstruction* d = m_.definition(id);
  if (d == nullptr || static_cast<spv::Op>(d->op) != spv::Op::OpVariable)
    throw UserError(place(b_.line()),
                    fmt::format("unsupported: a pointer made by {}", d != nullptr ? spirv_op_name(d->op) : "nothing"),
                    "pointers lead to variables and their elements, nowhere else");
  const SpirvType& t = m_.type(d->type);
  Pointer p;
  p.variable = id;
  p.type = t.element;
  p.storage = t.storage;
  return p;
}

void Lowerer::declare(const SpirvInstruction& variable) {
  const SpvId type = m_.type(variable.type).element;
  const std::uint32_t scalars = m_.scalar_count(type);
  if (scalars > kMaxLocalScalars)
    throw UserError(place(variable.line),
                    fmt::format("variable '{}' holds {} numbers", m_.name(variable.result), scalars),
                    fmt::format("the limit is {}", kMaxLocalScalars));
  if (variable.operands.size() > 1) {
    memory_[variable.result] = value(variable.operands[1]);
  } else if (!memory_.contains(variable.result)) {
    memory_[variable.result] = Tuple(scalars, num(0));
  }
}

void Lowerer::access_chain(const SpirvInstruction& i) {
  Pointer p = pointer(i.operands[0]);
  for (std::size_t k = 1; k < i.operands.size(); ++k) {
    const SpvId index_id = i.operands[k];
    const SpirvType& t = m_.type(p.type);
    if (is_uniform(p.storage) && k == 1 && t.kind != SpirvType::Kind::Struct)
      refuse(i, fmt::format("'{}', an array of uniform blocks", m_.name(p.variable)), "declare one block");
    const Ref index = scalar(index_id);
    const auto known = b_.value_of(index);
    if (known && t.kind != SpirvType::Kind::Struct && (*known < 0 || *known >= t.count))
      throw UserError(place(i.line), fmt::format("index {} is outside an array of {}", *known, t.count));
    const std::uint32_t at = known ? static_cast<std::uint32_t>(*known) : 0;
    if (is_uniform(p.storage)) {
      std::uint32_t stride = 0;
      switch (t.kind) {
        case SpirvType::Kind::Struct: {
          const Decorations& d = m_.member_decorations(p.type, at);
          if (k == 1)
            p.reg = static_cast<std::uint32_t>(member_register_.at({p.variable, at}));
          else
            p.byte += d.get(kOffset).value_or(0);
          p.matrix_stride = d.get(kMatrixStride).value_or(16);
          p.row_major = d.get(kRowMajor).has_value();
          break;
        }
        case SpirvType::Kind::Array:
          stride = m_.decorations(p.type).get(kArrayStride).value_or(16);
          break;
        case SpirvType::Kind::Matrix:
          stride = p.row_major ? 4 : p.matrix_stride;
          p.strided = p.row_major;
          break;
        default:
          stride = p.strided ? p.matrix_stride : 4;
          break;
      }
      if (known)
        p.byte += stride * at;
      else if (stride == 0 || stride % 4 != 0)
        refuse(i, fmt::format("an array stride of {} bytes", stride), "elements start every 4 bytes or more");
      else
        p.steps.push_back({index, stride, t.count});
    } else {
      const std::uint32_t stride = t.kind == SpirvType::Kind::Struct ? 0 : m_.scalar_count(t.element);
      if (known)
        p.scalar += m_.scalar_offset(p.type, at);
      else
        p.steps.push_back({index, stride, t.count});
    }
    p.type = m_.member_type(p.type, at);
  }
  pointers_[i.result] = std::move(p);
}

// The index expressions of an address as one register offset: c * value + constant. `unit` is the size of a
// register in the steps' own units; `shift` receives constant registers found inside the expressions.
Address Lowerer::address_of(const std::vector<Pointer::Step>& steps, std::uint32_t unit,
                            std::uint32_t& shift) {
  Address address;
  address.base = Address::Base::Value;
  std::uint32_t last = 0;
  for (const Pointer::Step& s : steps) last += (s.count - 1) * (s.stride / unit);
  address.limit = static_cast<std::uint16_t>(std::min(last + 1, 0xffffu));
  if (steps.size() > 1) {
    Lanes sum = num(0);
    for (const Pointer::Step& s : steps) sum = b_.add(b_.mul(s.index, num(s.stride / unit)), sum);
    address.value = sum[0];
    return address;
  }
  address.value = steps[0].index;
  address.scale = static_cast<std::uint16_t>(std::min(steps[0].stride / unit, 0xffffu));

  // value = factor * inner + offset, as far as it is visible
  double factor = 1, offset = 0;
  Ref inner = address.value;
  for (int depth = 0; depth < 4; ++depth) {
    const Node& n = b_.node(inner);
    if (inner.negate || inner.absolute || !is_instruction(n) || n.saturate || n.sink != Sink::Value) break;
    if (n.op != vm::Opcode::Add && n.op != vm::Opcode::Mul) break;
    Ref x = n.src[0][inner.lane], y = n.src[1][inner.lane];
    if (b_.value_of(x)) std::swap(x, y);
    const auto c = b_.value_of(y);
    if (!c || *c != static_cast<std::int64_t>(*c)) break;
    if (n.op == vm::Opcode::Add)
      offset += factor * *c;
    else
      factor *= *c;
    inner = x;
  }
  const Node& base = b_.node(inner);
  if (base.kind == NodeKind::Counter && !inner.negate && !inner.absolute) {
    const Counted& loop = counters_[base.index - 1];
    const double low = std::min(offset, offset + factor * (loop.trips - 1));
    const double high = std::max(offset, offset + factor * (loop.trips - 1));
    if (factor > 0 && low >= 0 && high < steps[0].count && factor * address.scale < 0xffff) {
      shift = static_cast<std::uint32_t>(offset) * address.scale;
      address.base = Address::Base::Counter;
      address.loop = base.index;
      address.limit = static_cast<std::uint16_t>(address.limit - shift);
      address.scale = static_cast<std::uint16_t>(factor * address.scale);
      address.value = {};
    }
    return address;
  }
  // k * i + c with 0 <= c < k: in range exactly when k * i is, so c can join the register number.
  if (factor > 1 && offset > 0 && offset < factor && offset < steps[0].count) {
    const Node& n = b_.node(address.value);
    Ref x = n.src[0][address.value.lane], y = n.src[1][address.value.lane];
    if (b_.value_of(x)) std::swap(x, y);
    if (n.op == vm::Opcode::Add && b_.is_constant(y, offset)) {
      shift = static_cast<std::uint32_t>(offset) * address.scale;
      address.limit = static_cast<std::uint16_t>(address.limit - shift);
      address.value = x;
    }
  }
  return address;
}

Ref Lowerer::uniform_scalar(const Pointer& p, std::uint32_t byte) {
  Address address;
  std::uint32_t shift = 0;
  if (!p.steps.empty()) address = address_of(p.steps, 16, shift);
  return b_.leaf(NodeKind::Uniform, p.reg + byte / 16 + shift, static_cast<int>(byte % 16 / 4), address);
}

void Lowerer::load_uniform_into(Tuple& out, const Pointer& p, SpvId type, std::uint32_t byte,
                                std::uint32_t matrix_stride, bool row_major, bool strided) {
  const SpirvType& t = m_.type(type);
  if (t.scalars > kMaxLocalScalars)
    throw UserError(place(b_.line()), "a whole array of uniforms is read at once and is too large",
                    "index it instead");
  switch (t.kind) {
    case SpirvType::Kind::Vector:
      for (std::uint32_t k = 0; k < t.count; ++k)
        out.push_back(uniform_scalar(p, byte + k * (strided ? matrix_stride : 4)));
      break;
    case SpirvType::Kind::Matrix:
      for (std::uint32_t k = 0; k < t.count; ++k)
        load_uniform_into(out, p, t.element, byte + k * (row_major ? 4 : matrix_stride), matrix_stride,
                          row_major, row_major);
      break;
    case SpirvType::Kind::Array: {
      const std::uint32_t stride = m_.decorations(type).get(kArrayStride).value_or(16);
      for (std::uint32_t k = 0; k < t.count; ++k)
        load_uniform_into(out, p, t.element, byte + k * stride, matrix_stride, row_major, false);
      break;
    }
    case SpirvType::Kind::Struct:
      for (std::uint32_t k = 0; k < t.members.size(); ++k) {
        const Decorations& d = m_.member_decorations(type, k);
        load_uniform_into(out, p, t.members[k], byte + d.get(kOffset).value_or(0),
                          d.get(kMatrixStride).value_or(16), d.get(kRowMajor).has_value(), false);
      }
      break;
    default:
      out.push_back(uniform_scalar(p, byte));
      break;
  }
}

Tuple Lowerer::load_uniform(const Pointer& p) {
  Tuple out;
  if (p.variable != 0 &&
      m_.type(m_.type(m_.definition(p.variable)->type).element).kind == SpirvType::Kind::Struct &&
      p.type == m_.type(m_.definition(p.variable)->type).element) {  // the whole block
    const SpirvType& block = m_.type(p.type);
    for (std::uint32_t k = 0; k < block.members.size(); ++k) {
      Pointer member = p;
      member.reg = static_cast<std::uint32_t>(member_register_.at({p.variable, k}));
      const Decorations& d = m_.member_decorations(p.type, k);
      load_uniform_into(out, member, block.members[k], 0, d.get(kMatrixStride).value_or(16),
                        d.get(kRowMajor).has_value(), false);
    }
    return out;
  }
  spend(kStepsPerInstruction);
  // An index inside a register (v[i], m[i][j]) picks among components; the others address registers.
  for (std::size_t k = 0; k < p.steps.size(); ++k)
    if (p.steps[k].stride % 16 != 0) {
      if (p.steps[k].count > kMaxIndexedElements)
        throw UserError(place(b_.line()),
                        fmt::format("indexing {} uniforms that are not registers of their own", p.steps[k].count),
                        "make them float4, or pad their stride to 16 bytes");
      Tuple picked;
      for (std::uint32_t e = p.steps[k].count; e-- > 0;) {
        Pointer q = p;
        q.steps.erase(q.steps.begin() + static_cast<std::ptrdiff_t>(k));
        q.byte += e * p.steps[k].stride;
        const Tuple element = load_uniform(q);
        if (picked.empty()) {
          picked = element;
          continue;
        }
        const Ref here = b_.op1(vm::Opcode::Seq, p.steps[k].index, num(e));
        for (std::size_t s = 0; s < picked.size(); ++s) picked[s] = b_.choose(here, element[s], picked[s])[0];
      }
      return picked;
    }
  load_uniform_into(out, p, p.type, p.byte, p.matrix_stride, p.row_major, p.strided);
  return out;
}

Tuple Lowerer::load_input(const Pointer& p) {
  const auto mapped = inputs_.find(p.variable);
  if (mapped == inputs_.end())
    throw UserError(place(b_.line()), fmt::format("input '{}' is not part of the entry point's interface",
                                                  m_.name(p.variable)));
  const auto& slots = mapped->second;
  Tuple all;
  const bool facing = m_.decorations(p.variable).get(static_cast<std::uint32_t>(spv::Decoration::BuiltIn)) ==
                      static_cast<std::uint32_t>(spv::BuiltIn::FrontFacing);
  for (const InterfaceSlot& s : slots) {
    if (s.reg < 0) {
      const auto builtin =
          m_.decorations(p.variable).get(static_cast<std::uint32_t>(spv::Decoration::BuiltIn));
      throw UserError(fmt::format("unsupported: input '{}'{}", m_.name(p.variable),
                                  builtin ? fmt::format(" (built-in {})", *builtin) : ""),
                      "inputs are interpolants and attributes, VPOS and VFACE");
    }
    const Ref r = b_.leaf(NodeKind::Input, static_cast<std::uint32_t>(s.reg), s.lane);
    all.push_back(facing ? b_.op1(vm::Opcode::Sgt, r, num(0)) : r);
  }
  memory_[p.variable] = all;
  Tuple result = load_local(p);
  return result;
}

std::optional<Tuple> Lowerer::load_table(const Pointer& p, const Tuple& from) {
  if (p.steps.size() != 1) return std::nullopt;
  const std::uint32_t width = m_.scalar_count(p.type);
  const Pointer::Step& s = p.steps[0];
  if (width > 4 || s.stride < width) return std::nullopt;
  std::vector<double> rows;
  for (std::uint32_t e = 0; e < s.count; ++e)
    for (std::uint32_t k = 0; k < 4; ++k) {
      const auto v = k < width ? b_.value_of(from[p.scalar + e * s.stride + k]) : 0.0;
      if (!v) return std::nullopt;
      rows.push_back(*v);
    }
  const auto [it, fresh] = tables_.try_emplace(rows, static_cast<std::uint32_t>(out_.ir.table.size()));
  if (fresh)
    for (std::uint32_t e = 0; e < s.count; ++e)
      out_.ir.table.push_back({rows[4 * e], rows[4 * e + 1], rows[4 * e + 2], rows[4 * e + 3]});
  Pointer::Step step = s;
  step.stride = 1;
  std::uint32_t shift = 0;
  const Address address = address_of({step}, 1, shift);
  Tuple result;
  for (std::uint32_t k = 0; k < width; ++k)
    result.push_back(b_.leaf(NodeKind::Table, it->second + shift, static_cast<int>(k), address));
  return result;
}

Tuple Lowerer::read_variable(SpvId variable) {
  auto kept = registers_.find(variable);
  if (kept == registers_.end()) {
    auto it = memory_.find(variable);
    ALU_CHECK(it != memory_.end(), "variable %{} read before it was declared", variable);
    return it->second;
  }
  Tuple result;
  const std::size_t scalars = memory_.at(variable).size();
  for (std::size_t first = 0; first < scalars; first += 4) {
    Lanes v;
    for (std::size_t k = first; k < std::min(first + 4, scalars); ++k)
      v.push({kept->second[first / 4], static_cast<std::uint8_t>(k - first)});
    for (Ref r : b_.snapshot(v)) result.push_back(r);
  }
  return result;
}

Tuple Lowerer::load_local(const Pointer& p) {
  const Tuple all = read_variable(p.variable);
  const std::uint32_t width = m_.scalar_count(p.type);
  spend(kStepsPerInstruction);
  if (p.steps.empty()) return Tuple(all.begin() + p.scalar, all.begin() + p.scalar + width);
  if (auto table = load_table(p, all)) return *table;
  // Not constant: choose among the elements, innermost index first.
  const Pointer::Step& s = p.steps[0];
  if (s.count > kMaxIndexedElements)
    throw UserError(place(b_.line()),
                    fmt::format("indexing an array of {} values that are not constants", s.count),
                    "use a constant array or a uniform array; those have an address register");
  Tuple picked;
  for (std::uint32_t e = s.count; e-- > 0;) {
    Pointer q = p;
    q.steps.erase(q.steps.begin());
    q.scalar += e * s.stride;
    const Tuple element = load_local(q);
    if (picked.empty()) {
      picked = element;
      continue;
    }
    const Ref here = b_.op1(vm::Opcode::Seq, s.index, num(e));
    for (std::size_t k = 0; k < picked.size(); k += 4) {
      Lanes yes, no;
      for (std::size_t c = k; c < std::min(k + 4, picked.size()); ++c) {
        yes.push(element[c]);
        no.push(picked[c]);
      }
      const Lanes chosen = b_.choose(here, yes, no);
      for (int c = 0; c < chosen.size; ++c) picked[k + static_cast<std::size_t>(c)] = chosen[c];
    }
  }
  return picked;
}

void Lowerer::load(const SpirvInstruction& i) {
  const SpirvType& type = m_.type(i.type);
  if (type.kind == SpirvType::Kind::Image || type.kind == SpirvType::Kind::SampledImage ||
      type.kind == SpirvType::Kind::Sampler) {
    const Pointer p = pointer(i.operands[0]);
    if (!p.steps.empty() || p.type != m_.type(m_.definition(p.variable)->type).element)
      refuse(i, "arrays of textures", "declare one sampler per texture");
    images_[i.result] = p.variable;
    return;
  }
  const Pointer p = pointer(i.operands[0]);
  switch (static_cast<spv::StorageClass>(p.storage)) {
    case spv::StorageClass::Uniform:
    case spv::StorageClass::PushConstant:
      define(i, load_uniform(p));
      break;
    case spv::StorageClass::Input:
      define(i, load_input(p));
      break;
    case spv::StorageClass::Function:
    case spv::StorageClass::Private:
    case spv::StorageClass::Output:
      define(i, load_local(p));
      break;
    default:
      refuse(i, "reading this kind of memory",
             "shaders read uniforms, inputs, textures and their own variables");
  }
}

void Lowerer::write_scalars(SpvId variable, std::uint32_t first, const Tuple& v) {
  if (m_.type(m_.definition(variable)->type).storage == static_cast<std::uint32_t>(spv::StorageClass::Output))
    for (std::uint32_t k = 0; k < v.size(); ++k) written_.insert({variable, first + k});
  auto kept = registers_.find(variable);
  if (kept == registers_.end()) {
    std::copy(v.begin(), v.end(), memory_.at(variable).begin() + first);
    return;
  }
  for (std::uint32_t k = 0; k < v.size();) {
    const std::uint32_t at = first + k, in_register = at % 4;
    Lanes part;
    std::array<std::uint8_t, 4> lane_to{};
    for (std::uint32_t c = in_register; c < 4 && k < v.size(); ++c, ++k) {
      lane_to[part.size] = static_cast<std::uint8_t>(c);
      part.push(v[k]);
    }
    b_.write(Sink::Variable, kept->second[at / 4], part, lane_to);
  }
}

void Lowerer::store(const SpirvInstruction& i) {
  const Pointer p = pointer(i.operands[0]);
  const auto storage = static_cast<spv::StorageClass>(p.storage);
  if (storage != spv::StorageClass::Function && storage != spv::StorageClass::Private &&
      storage != spv::StorageClass::Output)
    refuse(i, "writing this kind of memory", "shaders write their outputs and their own variables");
  const Tuple v = value(i.operands[1]);
  const std::function<void(const Pointer&, std::optional<Ref>)> put = [&](const Pointer& q,
                                                                          std::optional<Ref> condition) {
    if (!q.steps.empty()) {  // write every element, each keeping its value where the index is another
      const Pointer::Step s = q.steps[0];
      if (s.count > kMaxIndexedElements)
        refuse(i, fmt::format("writing by index into an array of {}", s.count), "use a smaller array");
      for (std::uint32_t e = 0; e < s.count; ++e) {
        Pointer element = q;
        element.steps.erase(element.steps.begin());
        element.scalar += e * s.stride;
        Ref here = b_.op1(vm::Opcode::Seq, s.index, num(e));
        if (condition) here = b_.mul(here, *condition)[0];
        put(element, here);
      }
      return;
    }
    if (!condition) return write_scalars(q.variable, q.scalar, v);
    const Tuple old = read_variable(q.variable);
    Tuple merged;
    for (std::uint32_t k = 0; k < v.size(); ++k)
      merged.push_back(b_.choose(*condition, v[k], old[q.scalar + k])[0]);
    write_scalars(q.variable, q.scalar, merged);
  };
  put(p, std::nullopt);
}

// Variables stored to inside control flow live in registers while it lasts: the writes then follow the lane
// mask.
void Lowerer::keep_in_registers(const std::unordered_set<SpvId>& blocks, std::vector<SpvId>& kept) {
  std::set<SpvId> stored;
  for (SpvId label : blocks)
    for (const SpirvInstruction& i : m_.block(label).code)
      if (static_cast<spv::Op>(i.op) == spv::Op::OpStore) {
        SpvId p = i.operands[0];
        for (const SpirvInstruction* d = m_.definition(p);
             d != nullptr && static_cast<spv::Op>(d->op) != spv::Op::OpVariable; d = m_.definition(p)) {
          if (d->operands.empty()) break;
          p = d->operands[0];
        }
        stored.insert(pointer(p).variable);
      }
  for (SpvId variable : stored) {
    if (registers_.contains(variable)) continue;
    const SpirvInstruction* d = m_.definition(variable);
    if (!memory_.contains(variable)) declare(*d);
    const Tuple current = memory_.at(variable);
    hold(*d, current.size());
    std::vector<NodeId> nodes;
    for (std::size_t first = 0; first < current.size(); first += 4)
      nodes.push_back(b_.variable(static_cast<int>(std::min<std::size_t>(4, current.size() - first))));
    registers_[variable] = std::move(nodes);
    const auto already = written_;
    write_scalars(variable, 0, current);
    written_ = already;
    kept.push_back(variable);
  }
}

void Lowerer::release_registers(const std::vector<SpvId>& kept) {
  for (SpvId variable : kept) {
    const auto nodes = registers_.at(variable);
    Tuple& current = memory_.at(variable);
    for (std::size_t k = 0; k < current.size(); ++k)
      current[k] = {nodes[k / 4], static_cast<std::uint8_t>(k % 4)};
    registers_.erase(variable);
  }
}

void Lowerer::write_outputs() {
  for (const auto& [variable, slots] :
       std::map<SpvId, std::vector<InterfaceSlot>>(outputs_.begin(), outputs_.end())) {
    const Tuple all = read_variable(variable);
    std::map<int, std::pair<Lanes, std::array<std::uint8_t, 4>>> by_register;
    for (std::uint32_t k = 0; k < slots.size() && k < all.size(); ++k) {
      if (!written_.contains({variable, k})) continue;
      if (slots[k].reg < 0)
        throw UserError(fmt::format("unsupported: output '{}'", m_.name(variable)),
                        "outputs are POSITION, interpolants, colours and DEPTH");
      auto& [lanes, to] = by_register[slots[k].reg];
      to[lanes.size] = slots[k].lane;
      if (lanes.size == 4)
        throw UserError(fmt::format("output '{}' puts more than four numbers into one register", m_.name(variable)),
                        "give each member a location of its own");
      lanes.push(all[k]);
    }
    for (auto& [reg, entry] : by_register)
      b_.write(Sink::Output, static_cast<NodeId>(reg), entry.first, entry.second);
  }
}

}  // namespace aluminate::compiler
