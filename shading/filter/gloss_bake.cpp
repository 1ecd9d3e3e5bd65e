#include "shading/filter/gloss_bake.hpp"

#include <cmath>

#include "platform/host/error.hpp"

namespace aluminate::filter {
namespace {

double mean(const ScalarLevel& level) {
  double sum = 0.0;
  for (const double value : level.texels) sum += value;
  return sum / static_cast<double>(level.texels.size());
}

}  // namespace

std::vector<BakedLevel> bake_gloss(const NormalLevel& normals, const ScalarLevel& gloss,
                                   const BakeOptions& options) {
  ALU_CHECK(normals.width == gloss.width && normals.height == gloss.height, "normals {}x{}, gloss {}x{}",
            normals.width, normals.height, gloss.width, gloss.height);
  const std::vector<NormalLevel> normal_levels = mip_chain(normals);
  std::vector<ScalarLevel> gloss_levels = mip_chain(gloss);
  std::vector<BakedLevel> baked;
  baked.reserve(normal_levels.size());
  for (std::size_t i = 0; i < normal_levels.size(); ++i) {
    BakedLevel level;
    level.normal = gaussian(normal_levels[i], options.footprint_sigma);
    level.gloss = std::move(gloss_levels[i]);
    level.length = {level.gloss.width, level.gloss.height, {}};
    level.filtered_gloss = level.length;
    for (std::size_t k = 0; k < level.normal.texels.size(); ++k) {
      const double length = brdf::clamped(glm::length(level.normal.texels[k]));
      level.length.texels.push_back(length);
      level.filtered_gloss.texels.push_back(brdf::filtered_gloss(length, level.gloss.texels[k]));
    }
    baked.push_back(std::move(level));
  }
  return baked;
}

std::vector<BakedLevel> bake_gloss(const Rgba8View& source, const BakeOptions& options) {
  return bake_gloss(decode_normal_map(source), decode_channel(source, 3), options);
}

ScalarLevel bake_factor(const BakedLevel& level, double fixed_power) {
  ScalarLevel factors{level.length.width, level.length.height, {}};
  factors.texels.reserve(level.length.texels.size());
  for (const double length : level.length.texels)
    factors.texels.push_back(brdf::toksvig_factor(length, fixed_power));
  return factors;
}

double material_factor(const BakedLevel& level, brdf::ToksvigMean kind) {
  return brdf::mean_toksvig_factor(level.length.texels, brdf::power_from_gloss(mean(level.gloss)), kind);
}

std::vector<BakeSummary> summarize(const std::vector<BakedLevel>& levels) {
  std::vector<BakeSummary> rows;
  for (const BakedLevel& level : levels) {
    BakeSummary row;
    row.level = static_cast<int>(rows.size());
    row.width = level.length.width;
    row.height = level.length.height;
    row.mean_length = mean(level.length);
    row.mean_gloss = mean(level.gloss);
    row.mean_filtered_gloss = mean(level.filtered_gloss);
    row.mean_filtered_power = brdf::power_from_gloss(row.mean_filtered_gloss);
    for (const brdf::ToksvigMeanName& kind : brdf::kToksvigMeans)
      row.material_factor[static_cast<std::size_t>(kind.id)] = material_factor(level, kind.id);
    rows.push_back(row);
  }
  return rows;
}

}  // namespace aluminate::filter
