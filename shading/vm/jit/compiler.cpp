#include "shading/vm/jit/compiler.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "platform/host/error.hpp"
#include "platform/host/input_file.hpp"
#include "platform/host/machine_code.hpp"
#include "platform/host/module_file.hpp"

namespace aluminate::vm::jit {
namespace {

// Compiling threads, and whether each has been told to stop and did.
std::atomic<bool> abandon{false};
std::atomic<bool> abandoned{false};
std::atomic<int> compiling{0};

const Module& module() {
  static const Module* const loaded = [] {
    void* symbol = host::open_module(kModuleFile, ALUMINATE_MODULE_DIR, kModuleEntry, "compiles shaders");
    // Registered after LLVM's own clean-up, so it runs before it.
    std::atexit([] { abandon_compilation(); });
    return reinterpret_cast<ModuleEntry>(symbol)();
  }();
  return *loaded;
}

}  // namespace

const host::Hash128& compiler_identity() {
  static const host::Hash128 identity = [] {
    host::Hasher hasher;
    hasher.add_text(ALUMINATE_LLVM_VERSION).add_text(host::processor_identity());
    const std::string file = host::find_module(kModuleFile, ALUMINATE_MODULE_DIR);
    if (!file.empty()) hasher.add(host::read_bytes(file));
    return hasher.finish();
  }();
  return identity;
}

Compiled compile(const Decoded& decoded, const CompileOptions& options) noexcept {
  Compiled result;
  try {
    const RangePlan ranges = plan_ranges(decoded, options.assume);
    CompileRequest request;
    request.decoded = &decoded;
    request.ranges = &ranges;
    request.width = std::max(options.width, module().vector_lanes());
    request.stretch = options.stretch;
    request.window = options.window;
    request.level = options.level;
    request.abandon = &abandon;
    request.abandoned = &abandoned;
    request.listing = options.listing;
    ++compiling;
    CompileResult made = module().compile(request);
    --compiling;
    result.code = std::move(made.code);
    result.description = {request.width, options.assume == Assume::Typical};
    result.problem = std::move(made.problem);
    result.ir = std::move(made.ir);
    result.assembly = std::move(made.assembly);
  } catch (const std::exception& error) {
    result.problem = error.what();
  }
  return result;
}

void abandon_compilation() noexcept {
  abandon = true;
  while (compiling > 0 && !abandoned) std::this_thread::sleep_for(std::chrono::microseconds(200));
}

}  // namespace aluminate::vm::jit
