#include "shading/compiler/lowerer.hpp"

#include <spirv/unified1/spirv.hpp11>

#include <algorithm>

namespace aluminate::compiler {

using vm::Opcode;

Lanes Lowerer::clamp(const Lanes& x, const Lanes& low, const Lanes& high) {
  if (b_.all_constant(low, 0) && b_.all_constant(high, 1)) return b_.saturate(x);
  return b_.op(Opcode::Min, b_.op(Opcode::Max, x, low), high);
}

bool Lowerer::arithmetic(const SpirvInstruction& i) {
  const auto op = static_cast<spv::Op>(i.op);
  const auto a = [&] { return vec(i.operands[0]); };
  const auto b = [&] { return vec(i.operands[1]); };
  switch (op) {
    case spv::Op::OpFNegate:
      define(i, negated(a()));
      return true;
    case spv::Op::OpFAdd:
      define(i, b_.add(a(), b()));
      return true;
    case spv::Op::OpFSub:
      define(i, b_.sub(a(), b()));
      return true;
    case spv::Op::OpFMul:
    case spv::Op::OpVectorTimesScalar:
      define(i, b_.mul(a(), b()));
      return true;
    case spv::Op::OpFDiv:
      define(i, b_.divide(a(), b()));
      return true;
    case spv::Op::OpFMod:
    case spv::Op::OpFRem: {
      const Lanes quotient = b_.divide(a(), b());
      // HLSL's fmod and % truncate; glslang writes the flooring operation for them.
      const Lanes whole =
          op == spv::Op::OpFMod && !m_.is_hlsl() ? b_.floor(quotient) : b_.op(Opcode::Trunc, quotient);
      define(i, b_.sub(a(), b_.mul(b(), whole)));
      return true;
    }
    case spv::Op::OpDot:
      define(i, b_.dot(a(), b()));
      return true;
    case spv::Op::OpDPdx:
    case spv::Op::OpDPdxFine:
    case spv::Op::OpDPdxCoarse:
      define(i, b_.op(Opcode::DsX, a()));
      return true;
    case spv::Op::OpDPdy:
    case spv::Op::OpDPdyFine:
    case spv::Op::OpDPdyCoarse:
      define(i, b_.op(Opcode::DsY, a()));
      return true;
    case spv::Op::OpFwidth:
    case spv::Op::OpFwidthFine:
    case spv::Op::OpFwidthCoarse: {
      Lanes x = b_.op(Opcode::DsX, a()), y = b_.op(Opcode::DsY, a());
      for (Ref& r : x) r = absolute(r);
      for (Ref& r : y) r = absolute(r);
      define(i, b_.add(x, y));
      return true;
    }
    case spv::Op::OpQuantizeToF16:
    case spv::Op::OpFConvert:
      define(i, value(i.operands[0]));
      return true;
    default:
      return false;
  }
}

bool Lowerer::comparison(const SpirvInstruction& i) {
  const auto a = [&] { return vec(i.operands[0]); };
  const auto b = [&] { return vec(i.operands[1]); };
  switch (static_cast<spv::Op>(i.op)) {
    case spv::Op::OpFOrdLessThan:
    case spv::Op::OpFUnordLessThan:
    case spv::Op::OpSLessThan:
    case spv::Op::OpULessThan:
      define(i, b_.op(Opcode::Sgt, b(), a()));
      return true;
    case spv::Op::OpFOrdGreaterThan:
    case spv::Op::OpFUnordGreaterThan:
    case spv::Op::OpSGreaterThan:
    case spv::Op::OpUGreaterThan:
      define(i, b_.op(Opcode::Sgt, a(), b()));
      return true;
    case spv::Op::OpFOrdLessThanEqual:
    case spv::Op::OpFUnordLessThanEqual:
    case spv::Op::OpSLessThanEqual:
    case spv::Op::OpULessThanEqual:
      define(i, b_.op(Opcode::Sge, b(), a()));
      return true;
    case spv::Op::OpFOrdGreaterThanEqual:
    case spv::Op::OpFUnordGreaterThanEqual:
    case spv::Op::OpSGreaterThanEqual:
    case spv::Op::OpUGreaterThanEqual:
      define(i, b_.op(Opcode::Sge, a(), b()));
      return true;
    case spv::Op::OpFOrdEqual:
    case spv::Op::OpFUnordEqual:
    case spv::Op::OpIEqual:
    case spv::Op::OpLogicalEqual:
      define(i, b_.op(Opcode::Seq, a(), b()));
      return true;
    case spv::Op::OpFOrdNotEqual:
    case spv::Op::OpFUnordNotEqual:
    case spv::Op::OpINotEqual:
    case spv::Op::OpLogicalNotEqual:
      define(i, b_.op(Opcode::Sne, a(), b()));
      return true;
    case spv::Op::OpLogicalNot:
      define(i, b_.logical_not(a()));
      return true;
    case spv::Op::OpLogicalAnd:
      define(i, b_.mul(a(), b()));
      return true;
    case spv::Op::OpLogicalOr:
      define(i, b_.op(Opcode::Max, a(), b()));
      return true;
    case spv::Op::OpAny:
    case spv::Op::OpAll: {
      const Lanes v = a();
      Lanes result = v[0];
      for (int k = 1; k < v.size; ++k)
        result = static_cast<spv::Op>(i.op) == spv::Op::OpAny ? b_.op(Opcode::Max, result, v[k])
                                                              : b_.mul(result, v[k]);
      define(i, result);
      return true;
    }
    case spv::Op::OpIsNan:
    case spv::Op::OpIsInf:
      define(i, splat(num(0), a().size));
      return true;  // no register holds either
    case spv::Op::OpSelect: {
      const Tuple yes = value(i.operands[1]), no = value(i.operands[2]);
      Lanes condition = vec(i.operands[0]);
      Tuple result;
      for (std::size_t first = 0; first < yes.size();
           first += 4) {  // whole structs and matrices may be selected
        Lanes y, n;
        for (std::size_t k = first; k < std::min(first + 4, yes.size()); ++k) {
          y.push(yes[k]);
          n.push(no[k]);
        }
        for (Ref r : b_.choose(condition, y, n)) result.push_back(r);
      }
      define(i, result);
      return true;
    }
    default:
      return false;
  }
}

bool Lowerer::composite(const SpirvInstruction& i) {
  switch (static_cast<spv::Op>(i.op)) {
    case spv::Op::OpCompositeConstruct: {
      Tuple t;
      for (SpvId part : i.operands) {
        const Tuple& v = value(part);
        t.insert(t.end(), v.begin(), v.end());
      }
      define(i, std::move(t));
      return true;
    }
    case spv::Op::OpCompositeExtract: {
      SpvId type = m_.definition(i.operands[0])->type;
      std::uint32_t offset = 0;
      for (std::uint32_t index : i.operands.subspan(1)) {
        offset += m_.scalar_offset(type, index);
        type = m_.member_type(type, index);
      }
      const Tuple v = value(i.operands[0]);
      define(i, Tuple(v.begin() + offset, v.begin() + offset + m_.scalar_count(type)));
      return true;
    }
    case spv::Op::OpCompositeInsert: {
      SpvId type = i.type;
      std::uint32_t offset = 0;
      for (std::uint32_t index : i.operands.subspan(2)) {
        offset += m_.scalar_offset(type, index);
        type = m_.member_type(type, index);
      }
      Tuple v = value(i.operands[1]);
      const Tuple part = value(i.operands[0]);
      std::copy(part.begin(), part.end(), v.begin() + offset);
      define(i, std::move(v));
      return true;
    }
    case spv::Op::OpVectorShuffle: {
      const Tuple a = value(i.operands[0]), b = value(i.operands[1]);
      Tuple t;
      for (std::uint32_t k : i.operands.subspan(2))
        t.push_back(k < a.size() ? a[k] : k < a.size() + b.size() ? b[k - a.size()] : num(0));
      define(i, std::move(t));
      return true;
    }
    case spv::Op::OpVectorExtractDynamic: {
      const Lanes v = vec(i.operands[0]);
      const Ref index = scalar(i.operands[1]);
      Lanes result = v[v.size - 1];
      for (int k = v.size - 1; k-- > 0;) result = b_.choose(b_.op(Opcode::Seq, index, num(k)), v[k], result);
      define(i, result);
      return true;
    }
    case spv::Op::OpVectorInsertDynamic: {
      Lanes v = vec(i.operands[0]);
      const Ref part = scalar(i.operands[1]), index = scalar(i.operands[2]);
      for (int k = 0; k < v.size; ++k) v[k] = b_.choose(b_.op(Opcode::Seq, index, num(k)), part, v[k])[0];
      define(i, v);
      return true;
    }
    default:
      return false;
  }
}

namespace {

// True when the components come from one register, so that a dot product with them needs no gathering.
bool one_register(const Lanes& v) {
  for (Ref r : v)
    if (r.node != v[0].node) return false;
  return true;
}

std::vector<Lanes> transposed(const std::vector<Lanes>& columns) {
  std::vector<Lanes> rows(static_cast<std::size_t>(columns[0].size));
  for (std::size_t r = 0; r < rows.size(); ++r)
    for (const Lanes& column : columns) rows[r].push(column[static_cast<int>(r)]);
  return rows;
}

}  // namespace

bool Lowerer::matrix(const SpirvInstruction& i) {
  // sum over columns[k] * v[k], or a dot product per row: whichever reads registers as they lie.
  const auto transform = [&](const std::vector<Lanes>& matrix_columns, const Lanes& v) -> Lanes {
    const std::vector<Lanes> rows = transposed(matrix_columns);
    if (one_register(rows[0]) && !one_register(matrix_columns[0])) {
      Lanes result;
      for (const Lanes& row : rows) result.push(b_.dot(row, v));
      return result;
    }
    return b_.combine(matrix_columns, v);
  };
  const auto flatten = [](const std::vector<Lanes>& matrix_columns) {
    Tuple t;
    for (const Lanes& column : matrix_columns) t.insert(t.end(), column.begin(), column.end());
    return t;
  };
  switch (static_cast<spv::Op>(i.op)) {
    case spv::Op::OpMatrixTimesVector:
      define(i, transform(columns(i.operands[0]), vec(i.operands[1])));
      return true;
    case spv::Op::OpVectorTimesMatrix: {
      const std::vector<Lanes> c = columns(i.operands[1]);
      const Lanes v = vec(i.operands[0]);
      if (one_register(c[0])) {
        Lanes result;
        for (const Lanes& column : c) result.push(b_.dot(v, column));
        define(i, result);
      } else {
        define(i, b_.combine(transposed(c), v));
      }
      return true;
    }
    case spv::Op::OpMatrixTimesScalar: {
      std::vector<Lanes> c = columns(i.operands[0]);
      for (Lanes& column : c) column = b_.mul(column, vec(i.operands[1]));
      define(i, flatten(c));
      return true;
    }
    case spv::Op::OpMatrixTimesMatrix: {
      const std::vector<Lanes> left = columns(i.operands[0]);
      std::vector<Lanes> result;
      for (const Lanes& column : columns(i.operands[1])) result.push_back(transform(left, column));
      define(i, flatten(result));
      return true;
    }
    case spv::Op::OpTranspose:
      define(i, flatten(transposed(columns(i.operands[0]))));
      return true;
    case spv::Op::OpOuterProduct: {
      const Lanes a = vec(i.operands[0]);
      std::vector<Lanes> result;
      for (Ref r : vec(i.operands[1])) result.push_back(b_.mul(a, r));
      define(i, flatten(result));
      return true;
    }
    default:
      return false;
  }
}

}  // namespace aluminate::compiler
