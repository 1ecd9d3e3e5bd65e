#include "shading/compiler/module_size.hpp"

#include "platform/host/error.hpp"
#include "shading/compiler/limits.hpp"

#include <spirv/unified1/spirv.hpp11>

#include <algorithm>
#include <unordered_map>

namespace aluminate::compiler {
namespace {

using Id = std::uint32_t;

struct Size {
  std::uint64_t instructions = 0, branches = 0;
  Size& operator+=(const Size& o) {  // saturating: calls multiply
    constexpr std::uint64_t kMany = std::uint64_t{1} << 40;
    instructions = std::min(instructions + o.instructions, kMany);
    branches = std::min(branches + o.branches, kMany);
    return *this;
  }
};

struct Function {
  Size own, inlined;
  std::vector<Id> calls;
  enum class State : std::uint8_t { New, Open, Done } state = State::New;
};

class Measure {
 public:
  Measure(const std::vector<std::uint32_t>& words, const std::string& file) : words_(words), whole_{file, 0, 0} {}

  void run() {
    const auto limit = [&](std::uint64_t is, std::uint64_t most, const std::string& what) {
      if (is > most)
        throw UserError(whole_, fmt::format("{} {}", what, is), fmt::format("the limit is {}", most));
    };
    limit(words_.size() * 4, kMaxModuleBytes, "the size of the SPIR-V module in bytes is");
    if (words_.size() < 5) return;
    if (words_[0] == 0x03022307u)
      throw UserError(whole_, "the SPIR-V module was written for the other byte order",
                      "store its words with the low byte first");
    limit(words_[3], kMaxModuleIds, "the SPIR-V module's bound of ids is");
    read();
    for (const Id entry : entries_) {
      const Size& size = inlined(entry);
      limit(size.instructions, kMaxModuleInstructions, "the shader's length in SPIR-V instructions, calls inlined, is");
      limit(size.branches, kMaxModuleBranches, "the number of ifs, switches and loops, calls inlined, is");
    }
  }

 private:
  void read() {
    Id function = 0;
    std::uint64_t outside = 0;
    for (std::size_t at = 5; at < words_.size();) {
      const std::size_t size = words_[at] >> 16;
      const auto op = static_cast<spv::Op>(words_[at] & 0xffff);
      if (size == 0 || at + size > words_.size()) return;
      const std::uint32_t* const w = &words_[at];
      at += size;
      switch (op) {
        case spv::Op::OpEntryPoint:
          if (size > 2) entries_.push_back(w[2]);
          break;
        case spv::Op::OpTypeStruct:
          if (size > 1) add_type(w[1], w + 2, size - 2);
          break;
        case spv::Op::OpTypeArray:
        case spv::Op::OpTypeMatrix:
        case spv::Op::OpTypeVector:
          if (size > 2) add_type(w[1], w + 2, 1);
          break;
        case spv::Op::OpFunction:
          if (size > 2) function = w[2];
          break;
        case spv::Op::OpFunctionEnd:
          function = 0;
          break;
        case spv::Op::OpSelectionMerge:
        case spv::Op::OpLoopMerge:
          ++functions_[function].own.branches;
          break;
        case spv::Op::OpFunctionCall:
          if (size > 3) functions_[function].calls.push_back(w[3]);
          break;
        default:
          break;
      }
      if (function != 0 && op != spv::Op::OpLine)
        ++functions_[function].own.instructions;
      else if (++outside > 2 * kMaxModuleInstructions)
        throw UserError(whole_, "the SPIR-V module declares too many types, constants and names",
                        fmt::format("the limit is {}", 2 * kMaxModuleInstructions));
    }
  }

  // Types are looked at again wherever they are part of another.
  void add_type(Id type, const std::uint32_t* parts, std::size_t count) {
    std::uint64_t sum = 1;
    for (std::size_t k = 0; k < count; ++k) {
      const auto it = type_parts_.find(parts[k]);
      sum += it == type_parts_.end() ? 1 : it->second;
    }
    if (sum > kMaxTypeParts)
      throw UserError(whole_, fmt::format("a type of {} parts", sum), fmt::format("the limit is {}", kMaxTypeParts));
    type_parts_[type] = sum;
  }

  // The stack is deep enough for a chain of calls as long as the module: a frame per OpFunctionCall, 100 bytes or so.
  const Size& inlined(Id id) {
    Function& f = functions_[id];
    if (f.state == Function::State::Open)
      throw UserError(whole_, "a function calls itself", "shaders have no call stack; write a loop");
    if (f.state == Function::State::Done) return f.inlined;
    f.state = Function::State::Open;
    f.inlined = f.own;
    for (const Id callee : std::vector<Id>(f.calls)) {
      const Size size = inlined(callee);
      functions_[id].inlined += size;
    }
    functions_[id].state = Function::State::Done;
    return functions_[id].inlined;
  }

  const std::vector<std::uint32_t>& words_;
  SourcePlace whole_;
  std::vector<Id> entries_;
  std::unordered_map<Id, Function> functions_;
  std::unordered_map<Id, std::uint64_t> type_parts_;
};

}  // namespace

void check_module_size(const std::vector<std::uint32_t>& words, const std::string& file) {
  Measure(words, file).run();
}

}  // namespace aluminate::compiler
