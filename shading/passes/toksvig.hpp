// Filtered specular for a scene: what averaging a normal map takes from its gloss, made at import from float
// normals for every mip. In: materials with a normal map. Out: a texture, or one number a material. One set a
// frame.
#pragma once

#include <map>
#include <memory>

#include "scenes/scene.hpp"
#include "shading/passes/options.hpp"
#include "shading/vm/texture.hpp"

namespace aluminate::passes {

/// Mip whose texels the one number of a material is the mean of: footprints of 4x4 texels, or the last mip.
inline constexpr std::size_t kMaterialToksvigMip = 2;

class ToksvigSet {
 public:
  /// Decodes and bakes every normal map that a mesh uses. mode Off: nothing. Throws UserError for an image
  /// that cannot be decoded.
  ToksvigSet(const scenes::Scene& scene, ToksvigMode mode);

  ToksvigMode mode() const { return mode_; }
  /// Texture: red = Toksvig's factor for power 100. Dxt5: red = filtered gloss, green = normal y, alpha =
  /// normal x, as decoded from DXT5. nullptr in other modes and for a material without normal map.
  const vm::Texture* texture(const scenes::Material& material) const;
  /// Material: arithmetic mean of the factor at the material's own power over mip kMaterialToksvigMip;
  /// else 1.
  double factor(const scenes::Material& material) const;

 private:
  struct Baked {
    vm::Texture texture;
    double factor = 1;
  };
  ToksvigMode mode_;
  std::map<const scenes::Material*, std::shared_ptr<const Baked>> baked_;  // looked up, never iterated
};

}  // namespace aluminate::passes
