// Static costs of shaders and variants: what `aluminate cost` prints.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "shading/cost/listing.hpp"
#include "shading/passes/options.hpp"

namespace aluminate::report {

struct CostRequest {
  /// Shader files (.hlsl .glsl .frag .vert .spv), visibility names ("cheap"), or variants
  /// "visibility=cheap,fresnel=sg".
  std::vector<std::string> subjects;
  passes::FrameOptions options;  // platform, light loop, lights (rig:N gives the light count), defines
  std::string stage = "pixel", entry = "main";
  cost::Assumptions assumptions;
  cost::Format format = cost::Format::Text;
  bool listing = false;
};

/// Compiles and prices every subject. Throws like cost_report.
std::vector<cost::StaticCost> price_subjects(const CostRequest& request);

/// The command that prices these subjects again.
std::string cost_command(const CostRequest& request);

/// Compiles and prices every subject. Throws UserError for a name that is neither a file nor a variant.
std::string cost_report(const CostRequest& request);

}  // namespace aluminate::report
