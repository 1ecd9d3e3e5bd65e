// pi times the specular BRDF for given angles: what `aluminate eval brdf` runs, the very functions of the forward shader.
#include "brdf.hlsl"

float4 main(float4 angles : TEXCOORD0,     // n.l, n.v, n.h, h.v
            float2 material : TEXCOORD1)   // gloss, cspec
    : COLOR0 {
  float4 dots = saturate(angles);
  float m = specular_power(material.x);
  float f = saturate(material.y + (1.0 - material.y) * fresnel_weight(dots.w));
  return 8.0 * (f * specular_lobe_8th(m, dots.x, dots.y, dots.z));
}
