#include "shading/compiler/lowerer.hpp"

#include <spirv/unified1/spirv.hpp11>

namespace aluminate::compiler {

using vm::Opcode;

namespace {

struct ImageOperands {
  std::optional<SpvId> bias, lod, grad_x, grad_y;
  bool other = false;
};

ImageOperands read_operands(std::span<const std::uint32_t> words) {
  ImageOperands r;
  if (words.empty()) return r;
  const std::uint32_t mask = words[0];
  std::size_t at = 1;
  const auto bit = [&](spv::ImageOperandsMask m) { return (mask & static_cast<std::uint32_t>(m)) != 0; };
  if (bit(spv::ImageOperandsMask::Bias)) r.bias = words[at++];
  if (bit(spv::ImageOperandsMask::Lod)) r.lod = words[at++];
  if (bit(spv::ImageOperandsMask::Grad)) {
    r.grad_x = words[at++];
    r.grad_y = words[at++];
  }
  constexpr std::uint32_t known = static_cast<std::uint32_t>(spv::ImageOperandsMask::Bias) |
                                  static_cast<std::uint32_t>(spv::ImageOperandsMask::Lod) |
                                  static_cast<std::uint32_t>(spv::ImageOperandsMask::Grad);
  r.other = (mask & ~known) != 0;
  return r;
}

}  // namespace

void Lowerer::refuse_image(const SpirvInstruction& i) const {
  refuse(i, "a texture that is chosen at run time", "name the texture where it is sampled");
}

bool Lowerer::texture(const SpirvInstruction& i) {
  bool projected = false, compared = false;
  switch (static_cast<spv::Op>(i.op)) {
    case spv::Op::OpSampledImage:
    case spv::Op::OpImage: {
      auto image = images_.find(i.operands[0]);
      if (image == images_.end()) refuse_image(i);
      images_[i.result] = image->second;
      return true;
    }
    case spv::Op::OpImageSampleImplicitLod:
    case spv::Op::OpImageSampleExplicitLod:
      break;
    case spv::Op::OpImageSampleProjImplicitLod:
    case spv::Op::OpImageSampleProjExplicitLod:
      projected = true;
      break;
    case spv::Op::OpImageSampleDrefImplicitLod:
    case spv::Op::OpImageSampleDrefExplicitLod:
      compared = true;
      break;
    case spv::Op::OpImageSampleProjDrefImplicitLod:
    case spv::Op::OpImageSampleProjDrefExplicitLod:
      projected = compared = true;
      break;
    case spv::Op::OpImageFetch:
      refuse(i, "OpImageFetch", "fetch with normalised coordinates and a point filter: tex2Dlod");
    case spv::Op::OpImageGather:
    case spv::Op::OpImageDrefGather:
      refuse(i, spirv_op_name(i.op), "fetch the four texels one by one");
    case spv::Op::OpImageQuerySize:
    case spv::Op::OpImageQuerySizeLod:
    case spv::Op::OpImageQueryLod:
    case spv::Op::OpImageQueryLevels:
      refuse(i, spirv_op_name(i.op), "pass the texture's size in a uniform");
    default:
      return false;
  }
  auto image = images_.find(i.operands[0]);
  if (image == images_.end()) refuse_image(i);
  auto sampler = samplers_.find(image->second);
  if (sampler == samplers_.end())
    refuse(i, fmt::format("the kind of texture of '{}'", m_.name(image->second)),
           "textures are 2D, 3D or cube, neither arrays nor multisampled");

  const ImageOperands operands = read_operands(i.operands.subspan(compared ? 3 : 2));
  if (operands.other) refuse(i, spirv_op_name(i.op) + " with an offset", "add the offset to the coordinates");

  const bool flat = out_.symbols.samplers[sampler->second].dimension == vm::SamplerDimension::Tex2D;
  const int dimensions = flat ? 2 : 3;
  const Lanes given = vec(i.operands[1]);
  Lanes at;
  for (int k = 0; k < dimensions; ++k) at.push(k < given.size ? given[k] : num(0));
  if (flat && given.size == 1) at[1] = num(0.5);
  Lanes reference;
  if (compared) reference = vec(i.operands[2]);
  if (projected) {
    const Ref w = b_.op1(Opcode::Rcp, given[given.size - 1]);
    at = b_.mul(at, w);
    if (compared) reference = b_.mul(reference, w);
  }

  Opcode op = Opcode::Tex;
  Lanes b, c;
  const auto level = [&](SpvId id) {
    while (at.size < 3) at.push(at[0]);  // not read
    at.push(scalar(id));
  };
  if (operands.grad_x) {
    op = Opcode::TexGrad;
    b = vec(*operands.grad_x);
    c = vec(*operands.grad_y);
  } else if (operands.lod) {
    op = Opcode::TexLod;
    level(*operands.lod);
  } else if (operands.bias) {
    op = Opcode::TexBias;
    level(*operands.bias);
  } else if (stage_ == vm::Stage::Vertex) {
    op = Opcode::TexLod;  // no quads: the finest level, as the languages say
    at = [&] {
      Lanes v = at;
      while (v.size < 3) v.push(at[0]);
      v.push(num(0));
      return v;
    }();
  }
  Lanes texel;
  for (int k = 0; k < (compared ? 1 : 4); ++k) texel.push(b_.fetch(op, sampler->second, at, b, c, k));
  if (compared) {  // depth comparison: 1 where the reference is not behind the texel
    define(i, b_.op(Opcode::Sge, texel, reference));
    return true;
  }
  define(i, texel);
  return true;
}

}  // namespace aluminate::compiler
