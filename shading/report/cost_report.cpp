#include "shading/report/cost_report.hpp"

#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>

#include "platform/console/platform_file.hpp"
#include "platform/host/error.hpp"
#include "platform/host/parallel.hpp"
#include "platform/host/suggest.hpp"
#include "shading/compiler/program_cache.hpp"
#include "shading/cost/static_cost.hpp"
#include "shading/passes/programs.hpp"
#include "shading/programs/shipped.hpp"

namespace aluminate::report {
namespace {

bool looks_like_file(const std::string& subject) {
  for (const char* ending : {".hlsl", ".fx", ".glsl", ".frag", ".vert", ".spv"})
    if (subject.ends_with(ending)) return true;
  return subject.find('/') != std::string::npos;
}

int light_count(const passes::FrameOptions& options) {
  int count = 4;
  if (options.lights.starts_with("rig:"))
    std::from_chars(options.lights.data() + 4, options.lights.data() + options.lights.size(), count);
  if (options.lights == "none") count = 0;
  return count;
}

cost::StaticCost price_file(const std::string& path, const CostRequest& request,
                            const console::GpuModel& gpu) {
  compiler::Options options;
  options.source_path = path;
  options.stage = request.stage == "vertex" || path.ends_with(".vert") ? vm::Stage::Vertex : vm::Stage::Pixel;
  options.entry = request.entry;
  options.defines = request.options.defines;
  programs::add_shipped_includes(options);
  if (request.options.light_loop == passes::LightLoop::Rolled) options.loops = compiler::LoopMode::Rolled;
  if (request.options.light_loop == passes::LightLoop::Unrolled) options.loops = compiler::LoopMode::Unrolled;
  const vm::Program program = compiler::compile_kept(options);
  cost::StaticCost price = cost::price(program, gpu, request.assumptions);
  for (const vm::Instruction& instruction : program.code)
    if (instruction.op == vm::Opcode::Loop) {
      price.per_light = cost::loop_body_light(program, price);
      break;
    }
  return price;
}

// A variant of the shipped shader on a plain surface, with its marginal light under the loop form asked for.
cost::StaticCost price_variant(const std::string& name, const passes::FrameOptions& options,
                               const CostRequest& request, const console::GpuModel& gpu) {
  const passes::SurfaceFeatures plain;
  const int lights = light_count(options);
  const bool rolled = lights > 0 && passes::rolls_lights(options, lights);
  // Unrolled, the marginal light is the difference of two programs: both are compiled at once.
  vm::Program programs[2];
  cost::StaticCost prices[2];
  host::parallel_for(rolled ? 1 : 2, [&](std::int64_t i) {
    programs[i] = passes::compile_pixel(options, plain, {.count = lights + static_cast<int>(i)}, rolled);
    prices[i] = cost::price(programs[i], gpu, request.assumptions);
  });
  cost::StaticCost& price = prices[0];
  price.name = fmt::format("{} ({} light{}, {})", name, lights, lights == 1 ? "" : "s",
                           rolled ? "rolled" : "unrolled");
  if (rolled) {
    price.per_light = cost::loop_body_light(programs[0], price);
  } else {
    price.per_light = cost::marginal_light(price, prices[1]);
  }
  return std::move(price);
}

cost::StaticCost price_subject(const std::string& subject, const CostRequest& request,
                               const console::GpuModel& gpu) {
  if (looks_like_file(subject)) return price_file(subject, request, gpu);
  passes::FrameOptions options = request.options;
  if (subject.find('=') != std::string::npos) {
    passes::set_options(options, subject);
  } else if (const auto visibility = brdf::parse_visibility(subject)) {
    options.visibility = *visibility;
  } else {
    std::vector<std::string> known;
    for (const brdf::VisibilityTerm& row : brdf::kVisibilityTerms) known.emplace_back(row.name);
    throw UserError(fmt::format("'{}' is neither a shader file nor a variant", subject),
                    host::did_you_mean(subject, known));
  }
  return price_variant(subject, options, request, gpu);
}

}  // namespace

std::vector<cost::StaticCost> price_subjects(const CostRequest& request) {
  const console::GpuModel gpu = console::load_platform(request.options.platform);
  std::vector<cost::StaticCost> costs(request.subjects.size());
  if (costs.size() == 1) {  // alone, its own two compilations may use the threads
    costs[0] = price_subject(request.subjects[0], request, gpu);
    return costs;
  }
  host::parallel_for(static_cast<std::int64_t>(costs.size()), [&](std::int64_t i) {
    const auto at = static_cast<std::size_t>(i);
    costs[at] = price_subject(request.subjects[at], request, gpu);
  });
  return costs;
}

std::string cost_command(const CostRequest& request) {
  const passes::FrameOptions& options = request.options;
  std::string text =
      fmt::format("aluminate cost {} --platform {}", fmt::join(request.subjects, " "), options.platform);
  if (request.stage != "pixel") text += " --stage " + request.stage;
  if (request.entry != "main") text += " --entry " + request.entry;
  if (!options.lights.empty()) text += " --lights " + options.lights;
  if (options.light_loop != passes::LightLoop::Auto)
    text += fmt::format(" --light-loop {}", passes::to_string(options.light_loop));
  if (options.fresnel != brdf::Fresnel::Schlick)
    text += fmt::format(" --fresnel {}", brdf::to_string(options.fresnel));
  for (const auto& [name, value] : options.defines) text += fmt::format(" -D {}={}", name, value);
  if (request.assumptions.filter == cost::FilterAssumption::Trilinear) text += " --trilinear";
  if (request.assumptions.pairing == cost::PairingRule::Loose) text += " --loose";
  return text;
}

std::string cost_report(const CostRequest& request) {
  const console::GpuModel gpu = console::load_platform(request.options.platform);
  const std::vector<cost::StaticCost> costs = price_subjects(request);
  std::string text = cost::format_cost(costs, request.format);
  if (request.format == cost::Format::Json) {
    nlohmann::ordered_json document = {{"schema", 1},
                                       {"tool", {{"name", "aluminate"}, {"version", ALUMINATE_VERSION}}},
                                       {"command", cost_command(request)},
                                       {"inputs", {{"subjects", request.subjects}, {"platform", gpu.path}}}};
    document.update(nlohmann::ordered_json::parse(text));
    text = document.dump(2) + "\n";
  }
  if (request.listing)
    for (const cost::StaticCost& cost : costs) text += "\n" + cost::format_listing(cost, request.format);
  return text;
}

}  // namespace aluminate::report
