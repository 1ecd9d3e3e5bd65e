// G-buffer pass: the material of a lit surface into the targets; no light.
#include "material.hlsl"
#include "gbuffer.hlsl"

GBufferTexels main(Interpolants i) {
  float4 base = base_color(i);
#if ALPHA_MASK
  clip(base.a - material_factors.z);
#endif
  return to_gbuffer(surface(i, base));
}
