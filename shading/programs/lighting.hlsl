// Light on a surface, the same for every pipeline [McAuley12]:
//
//   Lo = emissive + occlusion * (ambient(n) * cdiff + specular ambient)
//      + sum_i color_i * att_i * (n.l) * (cdiff + F * V * norm(m) * (n.h)^m)
//
// Specular ambient is ambient(n) * cspec, or with REFLECTIONS a captured cube map filtered by gloss (filter/cube_filter.hpp).
// All dots are clamped to [0, 1]. There is no branch on n.l: a light behind the surface is multiplied away.
#include "surface.hlsl"
#include "brdf.hlsl"
#include "lights.hlsl"
#ifndef SHADOW_COUNT
#define SHADOW_COUNT 0
#endif
#include "shadows.hlsl"

float4 eye;                            // world
#define AMBIENT_FLAT 0
#define AMBIENT_SKY 1
#define AMBIENT_HEMISPHERE 2
#ifndef AMBIENT_KIND
#define AMBIENT_KIND AMBIENT_FLAT
#endif
#if AMBIENT_KIND == AMBIENT_SKY
float4 ambient_sh[7];                  // irradiance / pi as a quadratic of the normal [Ramamoorthi01]: xyz1 of r, g, b;
                                       // xy, yz, zx, yy of r, g, b; x^2 - z^2 of rgb
#elif AMBIENT_KIND == AMBIENT_HEMISPHERE
float4 ambient_upper;                  // irradiance / pi of a normal straight up, and straight down
float4 ambient_lower;
#else
float4 ambient;                        // rgb
#endif

#if UNROLL
#define LIGHT_LOOP [unroll]
#else
#define LIGHT_LOOP [loop]
#endif

float3 ambient_light(float3 n) {
#if AMBIENT_KIND == AMBIENT_SKY
  float4 linear_terms = float4(n, 1.0);
  float4 products = n.xyzy * n.yzxy;
  float3 e = float3(dot(ambient_sh[0], linear_terms), dot(ambient_sh[1], linear_terms), dot(ambient_sh[2], linear_terms));
  e += float3(dot(ambient_sh[3], products), dot(ambient_sh[4], products), dot(ambient_sh[5], products));
  e += ambient_sh[6].rgb * (n.x * n.x - n.z * n.z);
  return max(e, 0.0);                  // a truncated series dips below 0 opposite a low sun
#elif AMBIENT_KIND == AMBIENT_HEMISPHERE
  return lerp(ambient_lower.rgb, ambient_upper.rgb, saturate(n.y * 0.5 + 0.5));
#else
  return ambient.rgb;
#endif
}

float3 to_eye(float3 position) {
  float3 v = eye.xyz - position;
  return v * rsqrt(max(dot(v, v), 0.00000001));
}

#if REFLECTIONS
samplerCUBE reflection_map;
float4 reflection;                     // x: greatest value of the map; y: level of power 1

// Reflectance under light from everywhere [Lazarov13]; brdf/environment.hpp.
float3 environment_reflectance(float gloss, float n_dot_v, float3 cspec) {
  float a0 = saturate(exp2(-9.28L * n_dot_v));
  a0 = gloss * (1.0416666666666667L * min(a0, 0.475 * gloss) + 0.018229166666666668L) - 0.015625;
  float a1 = 0.25 * gloss + 0.75;
  return saturate(a0 + cspec * (a1 - a0));
}

float3 reflected_surroundings(Surface s, float3 position) {
  float3 v = to_eye(position);
  float n_dot_v = dot(s.n, v);
  float log2_m = log2(s.m);
  float3 r = 2.0 * n_dot_v * s.n - v;
  float3 light = texCUBElod(reflection_map, float4(r, reflection.y - 0.5 * log2_m)).rgb * reflection.x;
  return light * environment_reflectance(0.076923076923076927L * log2_m, saturate(n_dot_v), s.cspec);
}

float3 ambient_reflected(Surface s, float3 position) {
  return s.occlusion * (ambient_light(s.n) * s.cdiff + reflected_surroundings(s, position));
}
#else
float3 ambient_reflected(Surface s, float3 position) { return s.occlusion * ambient_light(s.n) * (s.cdiff + s.cspec); }
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

// `radiance` and what the lights add to it.
float3 add_lights(Surface s, float3 position, float3 radiance) {
#if LIGHT_COUNT > 0
  float3 v = to_eye(position);
  float n_dot_v = saturate(dot(s.n, v));
  float3 cspec_8 = 8.0 * s.cspec;
#if SHADOW_COUNT > 0
  [unroll]
  for (int caster = 0; caster < SHADOW_COUNT; ++caster)
    radiance += punctual(s, cspec_8, position, v, n_dot_v, caster) * lit_by(caster, position, s.n);
#endif
#if LIGHT_COUNT > SHADOW_COUNT
  LIGHT_LOOP
  for (int light = SHADOW_COUNT; light < LIGHT_COUNT; ++light)
    radiance += punctual(s, cspec_8, position, v, n_dot_v, light);
#endif
#endif
  return radiance;
}
