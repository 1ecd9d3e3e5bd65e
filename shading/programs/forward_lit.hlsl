// Far Cry 3's forward shading of one pixel [McAuley12]: linear radiance to COLOR0, alpha in w.
//
//   Lo = emissive + occlusion * ambient * (cdiff + cspec)
//      + sum_i color_i * att_i * (n.l) * (cdiff + F * V * norm(m) * (n.h)^m)
//
// All dots are clamped to [0, 1]. There is no branch on n.l: a light behind the surface is multiplied away.

#include "material.hlsl"
#include "lights.hlsl"

float4 eye;                            // world
float4 ambient;                        // rgb

#if UNROLL
#define LIGHT_LOOP [unroll]
#else
#define LIGHT_LOOP [loop]
#endif

#if LIGHT_COUNT > 0
float3 punctual(Surface s, float3 cspec_8, float3 position, float3 v, float n_dot_v, int i) {
  float3 to_light = light_position[i].xyz - position * light_position[i].w;
  float distance_squared = max(dot(to_light, to_light), 0.00000001);
  float3 l = to_light * rsqrt(distance_squared);
  float3 h = l + v;
  h *= rsqrt(max(dot(h, h), 0.00000001));

  float n_dot_l = saturate(dot(s.n, l));
  float n_dot_h = saturate(dot(s.n, h));
  float h_dot_v = saturate(dot(h, v));

  float3 reflected = s.cdiff + fresnel_8(cspec_8, h_dot_v) * specular_lobe_8th(s.m, n_dot_l, n_dot_v, n_dot_h);
  return light_color[i].rgb * (attenuation(i, distance_squared, l) * n_dot_l) * reflected;
}
#endif

float4 main(Interpolants i) : COLOR0 {
  float4 base = base_color(i);
#if ALPHA_MASK
  clip(base.a - material_factors.z);
#endif
#if UNLIT
  return base;
#else
  Surface s = surface(i, base);
  float3 v = eye.xyz - i.position;
  v *= rsqrt(max(dot(v, v), 0.00000001));
  float n_dot_v = saturate(dot(s.n, v));

  float3 radiance = s.emissive + s.occlusion * ambient.rgb * (s.cdiff + s.cspec);
#if LIGHT_COUNT > 0
  float3 cspec_8 = 8.0 * s.cspec;
  LIGHT_LOOP
  for (int light = 0; light < LIGHT_COUNT; ++light) radiance += punctual(s, cspec_8, i.position, v, n_dot_v, light);
#endif
  return float4(radiance, s.alpha);
#endif
}
