#include "shading/vm/jit/generator.hpp"

#include <llvm/IR/IRBuilder.h>
#include <llvm/IR/Intrinsics.h>
#include <llvm/IR/MDBuilder.h>

#include <cstddef>
#include <map>

#include "platform/number/scalar.hpp"
#include "shading/vm/jit/definitions.hpp"
#include "shading/vm/jit/native.hpp"
#include "shading/vm/jit/row_liveness.hpp"
#include "shading/vm/jit/schedule.hpp"

namespace aluminate::vm::jit {
namespace {

using llvm::Value;

// What a row holds at a point of the code, one vector a part.
struct Cached {
  std::vector<Value*> plain, biased;  // biased: empty, or M + plain for M = magic
  double magic = 0;
};

class Generator {
 public:
  Generator(const Decoded& decoded, const RangePlan& ranges, const Form& form, llvm::Module& module)
      : d_(decoded),
        ranges_(ranges),
        module_(module),
        c_(module.getContext()),
        b_(c_),
        define_(b_, form.vector_lanes),
        vector_lanes_(form.vector_lanes),
        width_(form.width),
        parts_(form.width / form.vector_lanes),
        stretch_(form.stretch),
        window_(form.window),
        live_(decoded) {}

  void generate() {
    auto* type = llvm::FunctionType::get(b_.getVoidTy(), {b_.getPtrTy()}, false);
    function_ = llvm::Function::Create(type, llvm::Function::ExternalLinkage, kFunctionName, module_);
    function_->setDoesNotThrow();
    // Full-width vectors also where the processor's tuning prefers narrower ones: they are all this code does.
    function_->addFnAttr("prefer-vector-width", std::to_string(vector_lanes_ * 64));
    function_->addFnAttr("min-legal-vector-width", std::to_string(vector_lanes_ * 64));
    // Else spilled vectors lie across cache lines.
    function_->addFnAttr(llvm::Attribute::getWithStackAlignment(c_, llvm::Align(vector_lanes_ * 8)));
    frame_ = function_->getArg(0);
    frame_->addAttr(llvm::Attribute::NoAlias);
    b_.SetInsertPoint(new_block("entry"));
    rows_ = load_pointer(offsetof(Frame, rows));
    inputs_ = load_pointer(base_offset(Space::Input));
    uniforms_ = load_pointer(base_offset(Space::Uniform));
    literals_ = load_pointer(base_offset(Space::Literal));
    straight_ = true;
    for (const DecodedBlock& block : d_.blocks)
      straight_ &= block.flow == Flow::None || ((block.flow == Flow::Loop || block.flow == Flow::EndLoop) && block.trip_count >= 0);
    // A straight program has changed nothing yet that the interpreter would not do again, so where overflow is an accident
    // it is left to it. Formats that are made to saturate do so in place.
    gives_up_ = straight_ && d_.format.kind != number::Kind::Saturating;
    give_up_ = new_block("give_up");
    make_flow();
    b_.SetInsertPoint(give_up_);
    store(u64(1), offsetof(NativeFrame, gave_up));
    b_.CreateRetVoid();
  }

 private:
  // ---- memory ----------------------------------------------------------------------------------------------------

  static std::size_t base_offset(Space space) { return offsetof(Frame, base) + static_cast<std::size_t>(space) * sizeof(void*); }
  static constexpr std::size_t kFrame = offsetof(NativeFrame, frame);

  llvm::BasicBlock* new_block(const char* name) { return llvm::BasicBlock::Create(c_, name, function_); }
  Value* field(std::size_t offset) { return b_.CreateConstInBoundsGEP1_64(b_.getInt8Ty(), frame_, offset); }
  Value* load_pointer(std::size_t offset_in_frame) { return b_.CreateLoad(b_.getPtrTy(), field(kFrame + offset_in_frame)); }
  Value* load_u64(std::size_t offset) { return b_.CreateLoad(b_.getInt64Ty(), field(offset)); }
  void store(Value* value, std::size_t offset) { b_.CreateStore(value, field(offset)); }
  Value* load_exec() { return load_u64(kFrame + offsetof(Frame, exec)); }
  void store_exec(Value* exec) { store(exec, kFrame + offsetof(Frame, exec)); }
  Value* u64(std::uint64_t x) { return b_.getInt64(x); }
  Value* population(Value* x) { return b_.CreateUnaryIntrinsic(llvm::Intrinsic::ctpop, x); }
  void add_at(Value* array, std::size_t offset, Value* amount) {
    Value* at = b_.CreateConstInBoundsGEP1_64(b_.getInt8Ty(), array, offset);
    b_.CreateStore(b_.CreateAdd(b_.CreateLoad(b_.getInt64Ty(), at), amount), at);
  }

  Value* lane_address(Value* base, std::uint32_t offset, unsigned part) {
    Value* at = b_.CreateConstInBoundsGEP1_64(b_.getDoubleTy(), base, offset + part * vector_lanes_);
    return first_lane_ == nullptr ? at : b_.CreateInBoundsGEP(b_.getDoubleTy(), at, first_lane_);
  }
  Value* load_lanes(Value* base, std::uint32_t offset, unsigned part, bool constant) {
    auto* load = b_.CreateAlignedLoad(define_.vector(), lane_address(base, offset, part), llvm::Align(vector_lanes_ * 8));
    if (constant) load->setMetadata(llvm::LLVMContext::MD_invariant_load, llvm::MDNode::get(c_, {}));
    return load;
  }

  // ---- operands --------------------------------------------------------------------------------------------------

  // What the row holds for the operation being written.
  const Cached& row(std::uint32_t offset) {
    std::int32_t by = kFromMemory;
    for (const auto& [known, producer] : now_->rows)
      if (known == offset) by = producer;
    if (by != kFromMemory) return results_.at(static_cast<std::uint32_t>(by));
    Cached& cached = loaded_[offset];
    if (cached.plain.empty())
      for (unsigned p = 0; p < parts_; ++p) cached.plain.push_back(load_lanes(rows_, offset, p, false));
    return cached;
  }

  Value* scalar(const Operand& operand) {
    Value*& known = scalars_[{operand.space, operand.offset}];
    if (known != nullptr) return known;
    switch (operand.space) {
      case Space::Uniform: {
        auto* load = b_.CreateLoad(b_.getDoubleTy(), b_.CreateConstInBoundsGEP1_64(b_.getDoubleTy(), uniforms_, operand.offset));
        load->setMetadata(llvm::LLVMContext::MD_invariant_load, llvm::MDNode::get(c_, {}));
        return known = load;
      }
      case Space::Literal: return known = llvm::ConstantFP::get(b_.getDoubleTy(), d_.literals[operand.offset]);
      default:
        return known = b_.CreateLoad(b_.getDoubleTy(), field(kFrame + offsetof(Frame, loop_values) + operand.offset * 8));
    }
  }

  Value* get(const Operand& operand, unsigned part) {
    switch (operand.space) {
      case Space::Row: return row(operand.offset).plain[part];
      case Space::Input: {
        auto& values = inputs_known_[operand.offset];
        if (values.empty())
          for (unsigned p = 0; p < parts_; ++p) values.push_back(load_lanes(inputs_, operand.offset, p, true));
        return values[part];
      }
      default: return splat(operand);
    }
  }
  Value* splat(const Operand& operand) {
    Value*& known = splats_[{operand.space, operand.offset}];
    if (known == nullptr) known = define_.splat(scalar(operand));
    return known;
  }

  // M + c, what a multiply-add starts from.
  Value* biased(const number::Grid& grid, const Operand& operand, unsigned part) {
    if (operand.space == Space::Row) {
      const Cached& cached = row(operand.offset);
      if (!cached.biased.empty() && cached.magic == grid.magic) return cached.biased[part];
    }
    if (!operand.is_row()) {
      Value*& known = biased_splats_[{operand.space, operand.offset, grid.magic}];
      if (known == nullptr)
        known = define_.splat(b_.CreateFAdd(llvm::ConstantFP::get(b_.getDoubleTy(), grid.magic), scalar(operand)));
      return known;
    }
    return b_.CreateFAdd(define_.constant(grid.magic), get(operand, part));
  }
  // The biased form of a row when it is there for nothing.
  Value* free_biased(const number::Grid& grid, const Operand& operand, unsigned part) {
    if (operand.space != Space::Row) return nullptr;
    const Cached& cached = row(operand.offset);
    return !cached.biased.empty() && cached.magic == grid.magic ? cached.biased[part] : nullptr;
  }

  // ---- masks -----------------------------------------------------------------------------------------------------

  // Lanes of one part as a vector of bits, from 64 bits.
  Value* mask_of(Value* lanes, unsigned part) {
    Value* shifted = lanes;
    if (first_lane_ != nullptr) shifted = b_.CreateLShr(shifted, first_lane_);
    if (part != 0) shifted = b_.CreateLShr(shifted, part * vector_lanes_);
    return b_.CreateBitCast(b_.CreateTrunc(shifted, b_.getIntNTy(vector_lanes_)), llvm::FixedVectorType::get(b_.getInt1Ty(), vector_lanes_));
  }
  Value* exec_mask(unsigned part) {
    if (masks_.empty()) {
      Value* exec = load_exec();
      for (unsigned p = 0; p < parts_; ++p) masks_.push_back(mask_of(exec, p));
    }
    return masks_[part];
  }
  // The other way round: one bit a lane, in place.
  Value* gather_bits(const std::vector<Value*>& conditions) {
    Value* all = nullptr;
    for (unsigned p = 0; p < conditions.size(); ++p) {
      Value* bits = b_.CreateZExt(b_.CreateBitCast(conditions[p], b_.getIntNTy(vector_lanes_)), b_.getInt64Ty());
      if (p != 0) bits = b_.CreateShl(bits, p * vector_lanes_);
      all = all == nullptr ? bits : b_.CreateOr(all, bits);
    }
    return first_lane_ == nullptr ? all : b_.CreateShl(all, first_lane_);
  }

  // ---- results ---------------------------------------------------------------------------------------------------

  using Parts = std::vector<Rounded>;

  void write(const Operation& op, const Parts& parts) {
    Cached result;
    bool keeps_biased = !op.masked;
    for (const Rounded& part : parts) keeps_biased &= part.biased != nullptr;
    std::vector<Value*> old;
    if (op.masked) old = row(op.dst).plain;
    for (unsigned p = 0; p < parts_; ++p) {
      result.plain.push_back(op.masked ? b_.CreateSelect(exec_mask(p), parts[p].plain, old[p]) : parts[p].plain);
      if (keeps_biased) result.biased.push_back(parts[p].biased);
    }
    result.magic = op.grid->magic;
    results_[now_->index] = std::move(result);
  }

  void finish(const Operation& op, std::uint32_t index, Parts parts) {
    if (op.post == Post::Saturate) {
      const OperationRange& known = ranges_.operations[index];
      const bool below_one = known.result.greatest <= 1,
                 above_zero = known.result.least >= 0 && known.never_minus_zero;
      for (Rounded& part : parts) {
        if (!below_one) part = {define_.less_of(part.plain, define_.constant(1.0)), nullptr};
        if (!above_zero) part = {define_.greater_of(part.plain, define_.constant(0.0)), nullptr};
      }
    } else if (op.post == Post::Range && !ranges_.operations[index].in_range) {
      bound(op, parts);
    }
    write(op, parts);
  }

  llvm::MDNode* rarely() { return llvm::MDBuilder(c_).createBranchWeights(1, 1 << 20); }
  Value* any_above(Value* sizes, double greatest) {
    Value* outside =
        b_.CreateBitCast(b_.CreateFCmpOGT(sizes, define_.constant(greatest)), b_.getIntNTy(vector_lanes_));
    return b_.CreateICmpNE(outside, llvm::ConstantInt::get(outside->getType(), 0));
  }

  // The batch may be given up as late as the end of the stretch: until then a value out of range does no
  // harm, because nothing but rows is written and no operation of a stretch takes an address from a value
  // unbounded. What follows from it may be anything, even no number: the comparison keeps the old maximum
  // then.
  void remember_greatest(const Operation& op, const Parts& parts) {
    std::vector<Value*>& greatest = greatest_[op.grid->greatest];
    greatest.resize(parts_ < 2 ? parts_ : 2);
    for (unsigned p = 0; p < parts_; ++p) {
      Value*& known = greatest[p % greatest.size()];
      Value* size = ranges_.operations[now_->index].result.least >= 0 ? parts[p].plain
                                                                      : define_.absolute(parts[p].plain);
      known = known == nullptr ? size : define_.greater_of(size, known);
    }
  }
  void give_up_if_beyond() {
    for (const auto& [limit, sizes] : greatest_) {
      Value* all = sizes.size() == 1 ? sizes[0] : define_.greater_of(sizes[0], sizes[1]);
      llvm::BasicBlock* after = new_block("in_range");
      b_.CreateCondBr(any_above(all, limit), give_up_, after, rarely());
      b_.SetInsertPoint(after);
    }
    greatest_.clear();
  }

  // When any lane is outside the range of the grid: clamps and counts, or gives the batch up. Hardly ever
  // taken.
  void bound(const Operation& op, Parts& parts) {
    if (gives_up_) return remember_greatest(op, parts);
    std::vector<Value*> sizes;
    for (const Rounded& part : parts) sizes.push_back(define_.absolute(part.plain));
    while (sizes.size() > 1) {
      for (std::size_t i = 0; i < sizes.size() / 2; ++i) sizes[i] = define_.greater_of(sizes[2 * i], sizes[2 * i + 1]);
      sizes.resize(sizes.size() / 2);
    }
    Value* any = any_above(sizes[0], op.grid->greatest);
    llvm::BasicBlock *before = b_.GetInsertBlock(), *after = new_block("go_on");
    llvm::BasicBlock* clamp = new_block("clamp");
    b_.CreateCondBr(any, clamp, after, rarely());

    b_.SetInsertPoint(clamp);
    std::vector<Value*> clamped, conditions;
    for (const Rounded& part : parts) {
      Value* above = b_.CreateFCmpOGT(part.plain, define_.constant(op.grid->greatest));
      Value* below = b_.CreateFCmpOLT(part.plain, define_.constant(op.grid->least));
      Value* high = b_.CreateSelect(above, define_.constant(op.grid->greatest), part.plain);
      clamped.push_back(b_.CreateSelect(below, define_.constant(op.grid->least), high));
      conditions.push_back(b_.CreateOr(above, below));
    }
    Value* billed = b_.CreateAnd(load_exec(), load_u64(kFrame + offsetof(Frame, covered)));
    Value* saturations = load_pointer(offsetof(Frame, saturations));
    add_at(saturations, std::size_t{op.instruction} * 8, population(b_.CreateAnd(gather_bits(conditions), billed)));
    b_.CreateBr(after);

    b_.SetInsertPoint(after);
    for (unsigned p = 0; p < parts.size(); ++p) {
      llvm::PHINode* merged = b_.CreatePHI(define_.vector(), 2);
      merged->addIncoming(parts[p].plain, before);
      merged->addIncoming(clamped[p], clamp);
      parts[p] = {merged, nullptr};
    }
  }

  // ---- operations ------------------------------------------------------------------------------------------------

  Rounded add(const Operation& op, unsigned p) {
    Value *a = get(op.src[0], p), *b = get(op.src[1], p);
    switch (op.kernel) {
      case Kernel::Add: {
        Rounded sum{b_.CreateFAdd(a, b), nullptr};
        if (Value* t = free_biased(*op.grid, op.src[0], p)) {
          sum.biased = b_.CreateFAdd(t, b);
        } else if (Value* u = free_biased(*op.grid, op.src[1], p)) {
          sum.biased = b_.CreateFAdd(u, a);
        }
        return sum;
      }
      case Kernel::Sub: {
        Rounded difference{b_.CreateFSub(a, b), nullptr};
        if (Value* t = free_biased(*op.grid, op.src[0], p)) difference.biased = b_.CreateFSub(t, b);
        return difference;
      }
      case Kernel::AddRound: return define_.unbias(*op.grid, b_.CreateFAdd(biased(*op.grid, op.src[0], p), b));
      default: return define_.round(*op.grid, b_.CreateFAdd(a, b));
    }
  }

  Rounded multiply(const Operation& op, unsigned p) {
    Value *a = get(op.src[0], p), *b = get(op.src[1], p);
    Value* magic = define_.constant(op.grid->magic);
    return define_.unbias(*op.grid, op.kernel == Kernel::NegMul ? define_.negative_fma(a, b, magic) : define_.fma(a, b, magic));
  }

  Rounded multiply_add(const Operation& op, unsigned p) {
    Value *a = get(op.src[0], p), *b = get(op.src[1], p);
    const bool negative_c = op.kernel == Kernel::MadNegC || op.kernel == Kernel::NegMadNegC;
    Value* start = negative_c ? b_.CreateFSub(define_.constant(op.grid->magic), get(op.src[2], p)) : biased(*op.grid, op.src[2], p);
    const bool negative = op.kernel == Kernel::NegMad || op.kernel == Kernel::NegMadNegC;
    return define_.unbias(*op.grid, negative ? define_.negative_fma(a, b, start) : define_.fma(a, b, start));
  }

  Rounded dot(const Operation& op, unsigned p) {
    const bool negative = op.kernel >= Kernel::NegDot2;
    const int terms = static_cast<int>(op.kernel) - static_cast<int>(negative ? Kernel::NegDot2 : Kernel::Dot2) + 2;
    Value* t = terms == 2 ? biased(*op.grid, op.src[4], p) : define_.constant(op.grid->magic);
    for (std::size_t i = 0; i < static_cast<std::size_t>(terms); ++i) {
      Value *a = get(op.src[2 * i], p), *b = get(op.src[2 * i + 1], p);
      t = negative ? define_.negative_fma(a, b, t) : define_.fma(a, b, t);
    }
    return define_.unbias(*op.grid, t);
  }

  Value* compare(const Operation& op, unsigned p) {
    Value *a = get(op.src[0], p), *b = get(op.src[1], p);
    switch (op.kernel) {
      case Kernel::Sge:
      case Kernel::KillGe: return b_.CreateFCmpOGE(a, b);
      case Kernel::Sgt:
      case Kernel::KillGt: return b_.CreateFCmpOGT(a, b);
      case Kernel::Seq:
      case Kernel::KillEq: return b_.CreateFCmpOEQ(a, b);
      default: return b_.CreateFCmpUNE(a, b);
    }
  }

  Value* choose(const Operation& op, unsigned p) {
    Value *a = get(op.src[0], p), *zero = define_.constant(0.0);
    Value* condition = op.kernel == Kernel::CndGe   ? b_.CreateFCmpOGE(a, zero)
                       : op.kernel == Kernel::CndGt ? b_.CreateFCmpOGT(a, zero)
                                                    : b_.CreateFCmpOEQ(a, zero);
    return b_.CreateSelect(condition, get(op.src[1], p), get(op.src[2], p));
  }

  // Lane `neighbour` minus lane 0 of each quad, for all four lanes.
  Rounded derivative(const Operation& op, unsigned p) {
    if (!op.src[0].is_row()) return {define_.constant(0.0), nullptr};
    Value* a = get(op.src[0], p);
    const auto lane_of_quad = [&](int lane) {
      std::vector<int> order;
      for (int i = 0; i < static_cast<int>(vector_lanes_); ++i) order.push_back(i / 4 * 4 + lane);
      return b_.CreateShuffleVector(a, order);
    };
    return define_.round(*op.grid, b_.CreateFSub(lane_of_quad(op.kernel == Kernel::DsX ? 1 : 2), lane_of_quad(0)));
  }

  // Register index + scale * value of a constant file, the value per lane or of a loop counter.
  Value* relative(const Operation& op, unsigned p) {
    const Relative& r = op.relative;
    Value* table = op.src[0].space == Space::Uniform ? uniforms_ : literals_;
    Value* first = b_.CreateConstInBoundsGEP1_64(b_.getDoubleTy(), table, op.src[0].offset);
    const bool by_loop = r.base == RelativeBase::LoopCounter;
    Value* index;
    if (by_loop) {
      Value* at = field(kFrame + offsetof(Frame, iterations) + std::size_t{op.loop_level} * 4);
      index = b_.CreateSIToFP(b_.CreateLoad(b_.getInt32Ty(), at), b_.getDoubleTy());
    } else {
      index = define_.floor(get(op.src[1], p));
    }
    const auto number = [&](double x) -> Value* { return llvm::ConstantFP::get(index->getType(), x); };
    Value* scaled = b_.CreateFMul(index, number(r.scale));
    Value* last = number(r.limit - 1.0);
    Value* below = b_.CreateSelect(b_.CreateFCmpOLT(scaled, last), scaled, last);
    Value* clamped = b_.CreateSelect(b_.CreateFCmpOLT(scaled, number(0.0)), number(0.0), below);
    if (by_loop) {
      Value* offset = b_.CreateShl(b_.CreateFPToSI(clamped, b_.getInt64Ty()), 2);
      return define_.splat(b_.CreateLoad(b_.getDoubleTy(), b_.CreateInBoundsGEP(b_.getDoubleTy(), first, offset)));
    }
    auto* integers = llvm::FixedVectorType::get(b_.getInt64Ty(), vector_lanes_);
    Value* offsets = b_.CreateShl(b_.CreateFPToSI(clamped, integers), 2);
    Value* all = llvm::ConstantInt::getTrue(llvm::FixedVectorType::get(b_.getInt1Ty(), vector_lanes_));
    return b_.CreateMaskedGather(define_.vector(), b_.CreateInBoundsGEP(b_.getDoubleTy(), first, offsets), llvm::Align(8), all);
  }

  // The value of an operation that is one vector a part, before it is bounded.
  Rounded evaluate(const Operation& op, std::uint32_t index, unsigned p) {
    const auto a = [&] { return get(op.src[0], p); };
    const auto b = [&] { return get(op.src[1], p); };
    const auto plain = [](Value* v) { return Rounded{v, nullptr}; };
    switch (op.kernel) {
      case Kernel::Copy: {
        Value* kept = op.absolute ? define_.absolute(a()) : a();
        return plain(op.negate ? define_.negate(kept) : kept);
      }
      case Kernel::Saturate: return plain(define_.saturate(a()));
      case Kernel::ClampRange: return plain(a());
      case Kernel::Frc: return plain(b_.CreateFSub(a(), define_.floor(a())));
      case Kernel::Flr: return plain(define_.floor(a()));
      case Kernel::Trunc: return plain(define_.truncate(a()));
      case Kernel::Add:
      case Kernel::Sub:
      case Kernel::AddRound:
      case Kernel::AddRoundSum: return add(op, p);
      case Kernel::Mul:
      case Kernel::NegMul: return multiply(op, p);
      case Kernel::Min: return plain(define_.less_of(a(), b()));
      case Kernel::Max: return plain(define_.greater_of(b(), a()));  // a where they are equal: one instruction on x86
      case Kernel::Sge:
      case Kernel::Sgt:
      case Kernel::Seq:
      case Kernel::Sne: return plain(b_.CreateSelect(compare(op, p), define_.constant(1.0), define_.constant(0.0)));
      case Kernel::Mad:
      case Kernel::NegMad:
      case Kernel::MadNegC:
      case Kernel::NegMadNegC: return multiply_add(op, p);
      case Kernel::CndGe:
      case Kernel::CndGt:
      case Kernel::CndEq: return plain(choose(op, p));
      case Kernel::Dot2:
      case Kernel::Dot3:
      case Kernel::Dot4:
      case Kernel::NegDot2:
      case Kernel::NegDot3:
      case Kernel::NegDot4: return dot(op, p);
      case Kernel::RelativeUniform: return plain(relative(op, p));
      case Kernel::DsX:
      case Kernel::DsY: return derivative(op, p);
      default: return define_.function(op, a(), ranges_.operations[index].operand);
    }
  }

  void emit_test(const Operation& op) {
    std::vector<Value*> conditions;
    for (unsigned p = 0; p < parts_; ++p)
      conditions.push_back(op.kernel == Kernel::NotZero ? b_.CreateFCmpUNE(get(op.src[0], p), define_.constant(0.0)) : compare(op, p));
    Value* lanes = gather_bits(conditions);
    const bool kill = op.kernel != Kernel::NotZero;
    const std::size_t at = kFrame + (kill ? offsetof(Frame, killed) : offsetof(Frame, condition));
    if (kill) lanes = b_.CreateAnd(lanes, load_exec());
    store(b_.CreateOr(load_u64(at), lanes), at);
  }

  void emit(std::uint32_t index) {
    const Operation& op = d_.operations[index];
    if (op.kernel >= Kernel::KillGt) return emit_test(op);
    Parts parts;
    for (unsigned p = 0; p < parts_; ++p) parts.push_back(evaluate(op, index, p));
    if (op.kernel == Kernel::ClampRange && !ranges_.operations[index].in_range) bound(op, parts);
    finish(op, index, std::move(parts));
  }

  // ---- stretches of code between fetches and control flow ---------------------------------------------------------

  void begin_stretch() {
    loaded_.clear();
    results_.clear();
    inputs_known_.clear();
    scalars_.clear();
    splats_.clear();
    biased_splats_.clear();
    masks_.clear();
  }

  void emit_stretch(std::size_t block, std::uint32_t first, std::uint32_t last) {
    if (first == last) return;
    for (std::uint32_t i = first; i < last; ++i)
      if (d_.operations[i].kernel == Kernel::NotZero) store(u64(0), kFrame + offsetof(Frame, condition));
    llvm::BasicBlock *loop = nullptr, *after = nullptr;
    llvm::PHINode* lane = nullptr;
    if (width_ < kLanes) {
      llvm::BasicBlock* before = b_.GetInsertBlock();
      loop = new_block("lanes");
      after = new_block("stretch_end");
      b_.CreateBr(loop);
      b_.SetInsertPoint(loop);
      lane = b_.CreatePHI(b_.getInt64Ty(), 2);
      lane->addIncoming(u64(0), before);
      first_lane_ = lane;
    }
    begin_stretch();
    const Stretch stretch = schedule(d_, first, last, window_);
    for (const ScheduledOperation& op : stretch.operations) {
      now_ = &op;
      emit(op.index);
    }
    give_up_if_beyond();
    const RowSet live = live_.after(block, last - 1);
    for (const auto& [offset, by] : stretch.written)
      if (live[offset / kLanes])
        for (unsigned p = 0; p < parts_; ++p)
          b_.CreateAlignedStore(results_.at(by).plain[p], lane_address(rows_, offset, p), llvm::Align(vector_lanes_ * 8));
    if (lane != nullptr) {
      Value* next = b_.CreateAdd(lane, u64(width_), "", true, true);
      lane->addIncoming(next, b_.GetInsertBlock());
      b_.CreateCondBr(b_.CreateICmpULT(next, load_u64(offsetof(NativeFrame, lanes))), loop, after);
      b_.SetInsertPoint(after);
      first_lane_ = nullptr;
    }
    begin_stretch();
  }

  void call_back(std::size_t member, std::uint32_t argument) {
    Value* target = b_.CreateLoad(b_.getPtrTy(), field(member));
    auto* type = llvm::FunctionType::get(b_.getVoidTy(), {b_.getPtrTy(), b_.getInt32Ty()}, false);
    b_.CreateCall(type, target, {frame_, b_.getInt32(argument)})->setDoesNotThrow();
  }

  void emit_operations(std::size_t b) {
    const DecodedBlock& block = d_.blocks[b];
    std::uint32_t first = block.first;
    for (std::uint32_t i = block.first; i < block.last; ++i) {
      if (i - first == stretch_) {
        emit_stretch(b, first, i);
        first = i;
      }
      if (d_.operations[i].kernel != Kernel::Texture) continue;
      emit_stretch(b, first, i);
      call_back(offsetof(NativeFrame, call), i);
      first = i + 1;
    }
    emit_stretch(b, first, block.last);
  }

  // ---- control flow ----------------------------------------------------------------------------------------------

  void make_flow() {
    const std::size_t count = d_.blocks.size();
    Value* levels = nullptr;
    if (!straight_) {
      // outer, waiting and iteration of each open If or Loop; three 64-bit words.
      levels_type_ = llvm::ArrayType::get(b_.getInt64Ty(), 3 * static_cast<std::uint64_t>(std::max(d_.level_count, 1)));
      levels = b_.CreateAlloca(levels_type_);
      counted_ = b_.CreateAlloca(llvm::ArrayType::get(b_.getInt64Ty(), 2));
    }
    levels_ = levels;
    for (std::size_t b = 0; b <= count; ++b) {
      bodies_.push_back(new_block("body"));
      ends_.push_back(b < count && !straight_ ? new_block("end") : nullptr);
    }
    if (!straight_) count_exec(load_exec());
    b_.CreateBr(bodies_[0]);
    for (std::size_t b = 0; b < count; ++b) {
      b_.SetInsertPoint(bodies_[b]);
      if (!straight_) count_block(b);
      emit_operations(b);
      if (straight_) {
        end_straight(b);
      } else {
        b_.CreateBr(ends_[b]);
        b_.SetInsertPoint(ends_[b]);
        end_diverging(b);
      }
    }
    b_.SetInsertPoint(bodies_[count]);
    b_.CreateRetVoid();
  }

  Value* level_word(std::uint8_t level, unsigned word) {
    return b_.CreateConstInBoundsGEP2_64(levels_type_, levels_, 0, 3 * std::uint64_t{level} + word);
  }
  Value* load_word(Value* at) { return b_.CreateLoad(b_.getInt64Ty(), at); }

  void set_iteration(const DecodedBlock& block, Value* iteration) {
    const std::size_t loop = block.loop;
    store(iteration, kFrame + offsetof(Frame, iterations) + loop * 4);
    Value* number = b_.CreateSIToFP(iteration, b_.getDoubleTy());
    Value* limit = llvm::ConstantFP::get(b_.getDoubleTy(), d_.loop_value_limit);
    store(b_.CreateSelect(b_.CreateFCmpOLT(number, limit), number, limit), kFrame + offsetof(Frame, loop_values) + loop * 8);
  }

  // Every lane takes the same way: counted loops only. Blocks are counted outside, from their static trips.
  void end_straight(std::size_t b) {
    const DecodedBlock& block = d_.blocks[b];
    if (block.flow == Flow::Loop) {
      set_iteration(block, b_.getInt32(0));
      b_.CreateBr(bodies_[block.trip_count == 0 ? block.target + 1 : b + 1]);
    } else if (block.flow == Flow::EndLoop) {
      Value* at = field(kFrame + offsetof(Frame, iterations) + std::size_t{block.loop} * 4);
      Value* done = b_.CreateAdd(b_.CreateLoad(b_.getInt32Ty(), at), b_.getInt32(1));
      llvm::BasicBlock* again = new_block("again");
      b_.CreateCondBr(b_.CreateICmpSLT(done, b_.getInt32(static_cast<std::uint32_t>(block.trip_count))), again, bodies_[b + 1]);
      b_.SetInsertPoint(again);
      set_iteration(block, done);
      b_.CreateBr(bodies_[block.target]);
    } else {
      b_.CreateBr(bodies_[b + 1]);
    }
  }

  // Population counts of the executing lanes, taken again only when they change.
  void count_exec(Value* exec) {
    Value* covered = load_u64(offsetof(NativeFrame, covered));
    auto* type = llvm::ArrayType::get(b_.getInt64Ty(), 2);
    b_.CreateStore(population(b_.CreateAnd(exec, covered)), b_.CreateConstInBoundsGEP2_64(type, counted_, 0, 0));
    b_.CreateStore(population(b_.CreateAnd(exec, b_.CreateNot(covered))), b_.CreateConstInBoundsGEP2_64(type, counted_, 0, 1));
  }
  void change_exec(Value* exec) {
    store_exec(exec);
    count_exec(exec);
  }

  void count_block(std::size_t b) {
    Value* blocks = b_.CreateLoad(b_.getPtrTy(), field(offsetof(NativeFrame, blocks)));
    auto* type = llvm::ArrayType::get(b_.getInt64Ty(), 2);
    const std::size_t at = b * sizeof(BlockCount);
    add_at(blocks, at + offsetof(BlockCount, executions), u64(1));
    add_at(blocks, at + offsetof(BlockCount, covered_lanes), load_word(b_.CreateConstInBoundsGEP2_64(type, counted_, 0, 0)));
    add_at(blocks, at + offsetof(BlockCount, helper_lanes), load_word(b_.CreateConstInBoundsGEP2_64(type, counted_, 0, 1)));
    Value* lane_blocks = b_.CreateLoad(b_.getPtrTy(), field(offsetof(NativeFrame, lane_blocks)));
    llvm::BasicBlock *count = new_block("count_lanes"), *after = new_block("counted");
    b_.CreateCondBr(b_.CreateIsNull(lane_blocks), after, count, llvm::MDBuilder(c_).createBranchWeights(1 << 10, 1));
    b_.SetInsertPoint(count);
    call_back(offsetof(NativeFrame, count_lanes), static_cast<std::uint32_t>(b));
    b_.CreateBr(after);
    b_.SetInsertPoint(after);
  }

  // To the next block when a lane is left, else to the end of the region.
  void go_on(std::size_t b, Value* exec) {
    llvm::BasicBlock* empty = d_.blocks[b].flow == Flow::None ? bodies_.back() : ends_[d_.blocks[b].target];
    b_.CreateCondBr(b_.CreateICmpNE(exec, u64(0)), bodies_[b + 1], empty);
  }

  void end_diverging(std::size_t b) {
    const DecodedBlock& block = d_.blocks[b];
    Value* exec = load_exec();
    Value* outer = block.flow == Flow::None ? nullptr : level_word(block.level, 0);
    Value* waiting = block.flow == Flow::None ? nullptr : level_word(block.level, 1);
    const auto condition = [&] { return load_u64(kFrame + offsetof(Frame, condition)); };
    switch (block.flow) {
      case Flow::None: b_.CreateBr(bodies_[b + 1]); return;
      case Flow::If: {
        Value* taken = b_.CreateAnd(exec, condition());
        b_.CreateStore(exec, outer);
        b_.CreateStore(b_.CreateAnd(exec, b_.CreateNot(condition())), waiting);
        change_exec(taken);
        return go_on(b, taken);
      }
      case Flow::Else: {
        Value* others = load_word(waiting);
        b_.CreateStore(exec, waiting);
        change_exec(others);
        return go_on(b, others);
      }
      case Flow::EndIf: {
        Value* joined = b_.CreateOr(exec, load_word(waiting));
        change_exec(joined);
        return go_on(b, joined);
      }
      case Flow::Loop:
        b_.CreateStore(exec, outer);
        b_.CreateStore(u64(0), waiting);
        b_.CreateStore(u64(0), level_word(block.level, 2));
        set_iteration(block, b_.getInt32(0));
        b_.CreateBr(bodies_[block.trip_count == 0 ? block.target + 1 : b + 1]);
        return;
      case Flow::EndLoop: return end_loop(b, exec, outer, waiting);
      case Flow::Break: {
        Value* staying = b_.CreateAnd(exec, b_.CreateNot(condition()));
        change_exec(staying);
        return go_on(b, staying);
      }
      case Flow::Continue: {
        b_.CreateStore(b_.CreateOr(load_word(waiting), b_.CreateAnd(exec, condition())), waiting);
        Value* staying = b_.CreateAnd(exec, b_.CreateNot(condition()));
        change_exec(staying);
        return go_on(b, staying);
      }
    }
  }

  void end_loop(std::size_t b, Value* leaving, Value* outer, Value* waiting) {
    const DecodedBlock& block = d_.blocks[b];
    Value* exec = b_.CreateOr(leaving, load_word(waiting));
    b_.CreateStore(u64(0), waiting);
    Value* iteration = level_word(block.level, 2);
    Value* done = b_.CreateAdd(load_word(iteration), u64(1));
    b_.CreateStore(done, iteration);
    const bool open = block.trip_count < 0;
    Value* more = b_.CreateICmpSLT(done, u64(static_cast<std::uint64_t>(open ? kLoopLimit : block.trip_count)));
    Value* left = b_.CreateICmpNE(exec, u64(0));
    llvm::BasicBlock *again = new_block("again"), *leave = new_block("leave");
    b_.CreateCondBr(b_.CreateAnd(left, more), again, leave);

    b_.SetInsertPoint(again);
    change_exec(exec);
    set_iteration(block, b_.CreateTrunc(done, b_.getInt32Ty()));
    b_.CreateBr(bodies_[block.target]);

    b_.SetInsertPoint(leave);
    if (open) {
      // The first loop, in code order, that never ended.
      Value* at = field(offsetof(NativeFrame, overrun_loop));
      Value* known = b_.CreateLoad(b_.getInt32Ty(), at);
      Value* mine = b_.getInt32(block.instruction);
      Value* first = b_.CreateSelect(b_.CreateICmpULT(known, mine), known, mine);  // -1 is the greatest
      b_.CreateStore(b_.CreateSelect(left, first, known), at);
    }
    Value* entered = load_word(outer);
    change_exec(entered);
    b_.CreateBr(bodies_[b + 1]);
  }

  using Place = std::pair<Space, std::uint32_t>;

  const Decoded& d_;
  const RangePlan& ranges_;
  llvm::Module& module_;
  llvm::LLVMContext& c_;
  llvm::IRBuilder<> b_;
  Definitions define_;
  const unsigned vector_lanes_, width_, parts_, stretch_, window_;
  RowLiveness live_;
  bool straight_ = false, gives_up_ = false;
  llvm::BasicBlock* give_up_ = nullptr;

  llvm::Function* function_ = nullptr;
  llvm::Argument* frame_ = nullptr;
  Value *rows_ = nullptr, *inputs_ = nullptr, *uniforms_ = nullptr, *literals_ = nullptr;
  Value *levels_ = nullptr, *counted_ = nullptr;
  llvm::Type* levels_type_ = nullptr;
  std::vector<llvm::BasicBlock*> bodies_, ends_;

  // Of the current stretch.
  Value* first_lane_ = nullptr;  // null: lane 0 is the only first lane
  const ScheduledOperation* now_ = nullptr;
  std::map<std::uint32_t, Cached> loaded_;   // by row offset
  std::map<std::uint32_t, Cached> results_;  // by operation
  std::map<std::uint32_t, std::vector<Value*>> inputs_known_;
  std::map<Place, Value*> scalars_, splats_;
  std::map<std::tuple<Space, std::uint32_t, double>, Value*> biased_splats_;
  std::vector<Value*> masks_;
  std::map<double, std::vector<Value*>> greatest_;  // sizes seen so far, by the greatest value of their grid
};

}  // namespace

void generate(const Decoded& decoded, const RangePlan& ranges, const Form& form, llvm::Module& module) {
  Generator(decoded, ranges, form, module).generate();
}

}  // namespace aluminate::vm::jit
