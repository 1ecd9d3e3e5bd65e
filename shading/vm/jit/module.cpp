#include "shading/vm/jit/module.hpp"

#include <llvm/ADT/SmallVector.h>
#include <llvm/IR/LLVMContext.h>
#include <llvm/IR/LegacyPassManager.h>
#include <llvm/IR/Verifier.h>
#include <llvm/MC/TargetRegistry.h>
#include <llvm/Pass.h>
#include <llvm/Support/CommandLine.h>
#include <llvm/Support/TargetSelect.h>
#include <llvm/Support/raw_ostream.h>
#include <llvm/Target/TargetMachine.h>
#include <llvm/TargetParser/Host.h>
#include <llvm/Transforms/Scalar.h>

#include <chrono>
#include <memory>
#include <thread>

#include "shading/vm/jit/flat_code.hpp"
#include "shading/vm/jit/generator.hpp"

namespace aluminate::vm::jit {
namespace {

// The processor this runs on.
struct Host {
  std::string triple, cpu, features;
  const llvm::Target* target = nullptr;
  unsigned vector_lanes = 4;
};

const Host& host() {
  static const Host known = [] {
    // The order of schedule() is the one that is wanted: LLVM's own schedulers would bring uses back to
    // definitions, which saves registers and leaves the processor waiting. Options of a process, not of a
    // target machine; nobody else here has LLVM make code.
    constexpr const char* kOptions[] = {"aluminate", "-pre-RA-sched=source", "-enable-misched=false"};
    llvm::cl::ParseCommandLineOptions(static_cast<int>(std::size(kOptions)), kOptions);
    llvm::InitializeNativeTarget();
    llvm::InitializeNativeTargetAsmPrinter();
    Host h;
    h.triple = llvm::sys::getProcessTriple();
    h.cpu = llvm::sys::getHostCPUName().str();
    bool wide = false;
    for (const auto& feature : llvm::sys::getHostCPUFeatures()) {
      h.features += (h.features.empty() ? "" : ",") + std::string(feature.second ? "+" : "-") + feature.first().str();
      wide |= feature.first() == "avx512f" && feature.second;
    }
    h.vector_lanes = wide ? 8 : 4;
    std::string error;
    h.target = llvm::TargetRegistry::lookupTarget(h.triple, error);
    return h;
  }();
  return known;
}

std::unique_ptr<llvm::TargetMachine> make_machine(int level) {
  llvm::TargetOptions options;
  options.AllowFPOpFusion = llvm::FPOpFusion::Strict;  // only what the definitions fuse
  constexpr llvm::CodeGenOptLevel kLevels[] = {llvm::CodeGenOptLevel::None, llvm::CodeGenOptLevel::Less,
                                               llvm::CodeGenOptLevel::Default, llvm::CodeGenOptLevel::Aggressive};
  return std::unique_ptr<llvm::TargetMachine>(
      host().target->createTargetMachine(host().triple, host().cpu, host().features, options, llvm::Reloc::PIC_,
                                         llvm::CodeModel::Small, kLevels[level]));
}

// LLVM calls this between passes. A thread that is no longer wanted stays here: the process ends without it.
void stop_if_abandoned(llvm::LLVMContext*, void* request) {
  const auto& r = *static_cast<const CompileRequest*>(request);
  if (r.abandon == nullptr || !r.abandon->load()) return;
  r.abandoned->store(true);
  for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
}

CompileResult compile(const CompileRequest& request) {
  CompileResult result;
  if (host().target == nullptr) {
    result.problem = "LLVM does not know this processor";
    return result;
  }
  llvm::LLVMContext context;
  context.setYieldCallback(stop_if_abandoned, const_cast<CompileRequest*>(&request));
  context.setDiscardValueNames(!request.listing);
  llvm::Module module("shader", context);
  const std::unique_ptr<llvm::TargetMachine> machine = make_machine(request.level);
  module.setTargetTriple(host().triple);
  module.setDataLayout(machine->createDataLayout());
  generate(*request.decoded, *request.ranges, {host().vector_lanes, request.width, request.stretch, request.window}, module);
  std::string broken;
  llvm::raw_string_ostream broken_stream(broken);
  if (llvm::verifyModule(module, &broken_stream)) {
    result.problem = "generated code is not valid: " + broken;
    return result;
  }
  const auto emit = [&](llvm::CodeGenFileType type, llvm::SmallVectorImpl<char>& into) {
    llvm::raw_svector_ostream stream(into);
    llvm::legacy::PassManager passes;
    passes.add(llvm::createEarlyCSEPass());
    if (machine->addPassesToEmitFile(passes, stream, nullptr, type)) return false;
    passes.run(module);
    return true;
  };
  if (request.listing) {
    llvm::raw_string_ostream stream(result.ir);
    module.print(stream, nullptr);
    llvm::SmallVector<char, 0> text;
    emit(llvm::CodeGenFileType::AssemblyFile, text);
    result.assembly.assign(text.begin(), text.end());
  }
  llvm::SmallVector<char, 0> object;
  if (!emit(llvm::CodeGenFileType::ObjectFile, object)) {
    result.problem = "LLVM writes no object files for this processor";
    return result;
  }
  FlatCode flat = flatten(llvm::StringRef(object.data(), object.size()));
  if (auto* problem = std::get_if<std::string>(&flat)) {
    result.problem = std::move(*problem);
  } else {
    result.code = std::move(std::get<std::vector<std::uint8_t>>(flat));
  }
  return result;
}

std::uint32_t vector_lanes() { return host().vector_lanes; }

constexpr Module kModule = {compile, vector_lanes};

}  // namespace
}  // namespace aluminate::vm::jit

extern "C" __attribute__((visibility("default"))) const aluminate::vm::jit::Module* aluminate_jit_module() {
  return &aluminate::vm::jit::kModule;
}
