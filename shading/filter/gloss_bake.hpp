// Filtered gloss baked at import: per mip, how smooth the averaged surface still is. In: a normal map and its
// gloss. Out: gloss maps for every mip, one factor for the whole material. Runs on float normals, before any
// block compression: two-channel formats rebuild unit length, so nothing can be read back from them at run
// time [Hill11].
#pragma once

#include <vector>

#include "shading/brdf/toksvig.hpp"
#include "shading/filter/normal_mips.hpp"

namespace aluminate::filter {

struct BakeOptions {
  double footprint_sigma = 0;  // texels, see gaussian(); 0: level 0 keeps its gloss
};

/// One mip. All planes have the level's size.
struct BakedLevel {
  ScalarLevel length;          // |na|, [0, 1]
  ScalarLevel gloss;           // artists' gloss, box-filtered in gloss space (the mean of log2 m)
  ScalarLevel filtered_gloss;  // brdf::filtered_gloss(length, gloss)
  NormalLevel normal;          // un-normalised mean
};

/// Gloss levels from level 0 to 1x1. `gloss` must have the size of `normals` (InternalError).
[[nodiscard]] std::vector<BakedLevel> bake_gloss(const NormalLevel& normals, const ScalarLevel& gloss,
                                                 const BakeOptions& options = {});
/// The artists' source: normal in rgb, gloss in alpha.
[[nodiscard]] std::vector<BakedLevel> bake_gloss(const Rgba8View& source, const BakeOptions& options = {});

/// Toksvig factor of every texel for one fixed power: the form that one texture shares between materials.
/// Converted to a material's power with brdf::convert_toksvig_factor it equals a bake at that power.
[[nodiscard]] ScalarLevel bake_factor(const BakedLevel& level, double fixed_power = brdf::kFixedPower);

/// [McAuley12] The form that shipped: one factor per material, over the texels of `level`, for the power of
/// the material's mean gloss on that level. m' = factor m.
[[nodiscard]] double material_factor(const BakedLevel& level,
                                     brdf::ToksvigMean mean = brdf::ToksvigMean::Factor);

/// One line per mip of what filtering does to the material.
struct BakeSummary {
  int level = 0, width = 0, height = 0;
  double mean_length = 1, mean_gloss = 0, mean_filtered_gloss = 0, mean_filtered_power = 1;
  std::array<double, 4> material_factor{};  // by ToksvigMean
};
[[nodiscard]] std::vector<BakeSummary> summarize(const std::vector<BakedLevel>& levels);

}  // namespace aluminate::filter
