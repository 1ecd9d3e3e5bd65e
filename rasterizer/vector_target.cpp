#include "rasterizer/vector_target.hpp"

#include <hwy/targets.h>

#include "platform/host/error.hpp"

namespace aluminate::raster {
namespace {

// The units tile_kernel.cpp and its peers are compiled for.
constexpr std::int64_t kCompiled = HWY_AVX3 | HWY_AVX2 | HWY_SSE4 | HWY_EMU128;

std::vector<std::int64_t> runnable() {
  std::vector<std::int64_t> targets;
  for (std::int64_t left = (hwy::SupportedTargets() | HWY_EMU128) & kCompiled; left != 0; left &= left - 1) targets.push_back(left & -left);
  return targets;
}

}  // namespace

std::vector<std::string> vector_targets() {
  std::vector<std::string> names;
  for (const std::int64_t target : runnable()) names.emplace_back(hwy::TargetName(target));
  return names;
}

void use_vector_target(const std::string& name) {
  for (const std::int64_t target : runnable()) {
    if (!name.empty() && name != hwy::TargetName(target)) continue;
    hwy::GetChosenTarget().Update(target);
    return;
  }
  throw UserError({}, fmt::format("unknown vector unit '{}'", name), fmt::format("this machine has: {}", fmt::join(vector_targets(), ", ")));
}

}  // namespace aluminate::raster
