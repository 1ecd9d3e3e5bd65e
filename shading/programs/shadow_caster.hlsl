// What casts a shadow: nothing but depth leaves this shader, and not even that where the surface is cut out.
#include "material.hlsl"

float4 main(Interpolants i) : COLOR0 {
  float4 base = base_color(i);
#if ALPHA_MASK
  clip(base.a - material_factors.z);
#endif
  return base;
}
