// Far Cry 3's forward shading of one pixel [McAuley12]: linear radiance to COLOR0, alpha in w.
#include "material.hlsl"
#include "lighting.hlsl"

float4 main(Interpolants i) : COLOR0 {
  float4 base = base_color(i);
#if ALPHA_MASK
  clip(base.a - material_factors.z);
#endif
#if UNLIT
  return base;
#else
  Surface s = surface(i, base);
  return float4(add_lights(s, i.position, s.emissive + ambient_reflected(s, i.position)), s.alpha);
#endif
}
