// The surface under a pixel: what the textures and factors of a glTF material say, in the terms the BRDF wants.
// A map that the material lacks is compiled out (HAS_*), never sampled.

#include "surface.hlsl"
#include "brdf.hlsl"

float4 base_color_factor;              // linear
float4 material_factors;               // metallic, roughness, alpha cutoff, occlusion strength
float4 specular_factor;                // specular-glossiness workflow: rgb, gloss
float4 emissive_factor;                // rgb, normal scale

#if HAS_BASE_COLOR_MAP
sampler2D base_color_map;              // sRGB
#endif
#if HAS_METALLIC_ROUGHNESS_MAP
sampler2D metallic_roughness_map;      // G roughness, B metallic
#endif
#if HAS_SPECULAR_GLOSSINESS_MAP
sampler2D specular_glossiness_map;     // rgb sRGB specular, A gloss
#endif
#define TOKSVIG_TEXTURE 1
#define TOKSVIG_DXT5 2
#define TOKSVIG_MATERIAL 3
#if HAS_NORMAL_MAP
sampler2D normal_map;                  // NORMAL_DXT5NM: y in G, x in A; TOKSVIG_DXT5: the same, filtered gloss in R
#if TOKSVIG == TOKSVIG_TEXTURE
sampler2D toksvig_map;                 // R: Toksvig's factor for power 100
#elif TOKSVIG == TOKSVIG_MATERIAL
float4 toksvig;                        // x: the material's factor
#endif
#endif
#if HAS_OCCLUSION_MAP
sampler2D occlusion_map;               // R
#endif
#if HAS_EMISSIVE_MAP
sampler2D emissive_map;                // sRGB
#endif
#if UV_TRANSFORMS
float4 uv_transform[12];               // two rows for each map in the order above: u' = dot(row, (u, v, 1))
#endif

struct Interpolants {
  float3 position : TEXCOORD0;         // world
  float3 normal : TEXCOORD1;
#if HAS_NORMAL_MAP
  float4 tangent : TEXCOORD2;          // w: handedness
#endif
#if HAS_UV
  float4 uv : TEXCOORD3;               // uv set 0 in xy, set 1 in zw
#endif
#if HAS_VERTEX_COLOR
  float4 color : COLOR0;
#endif
#if DOUBLE_SIDED
  float face : VFACE;                  // +1 front, -1 back
#endif
};

#if HAS_UV
float2 map_uv(Interpolants i, int map, int set) {
  float2 uv = set == 1 ? i.uv.zw : i.uv.xy;
#if UV_TRANSFORMS
  uv = float2(dot(uv_transform[2 * map].xy, uv) + uv_transform[2 * map].z,
              dot(uv_transform[2 * map + 1].xy, uv) + uv_transform[2 * map + 1].z);
#endif
  return uv;
}
#endif

float3 surface_normal(Interpolants i) {
#if HAS_NORMAL_MAP
#if TOKSVIG == TOKSVIG_DXT5 || NORMAL_DXT5NM
  float3 t;
  t.xy = tex2D(normal_map, map_uv(i, 3, NORMAL_UV_SET)).ag * 2.0 - 1.0;
  t.z = sqrt(saturate(1.0 - dot(t.xy, t.xy)));
#else
  float3 t = tex2D(normal_map, map_uv(i, 3, NORMAL_UV_SET)).xyz * 2.0 - 1.0;
#endif
#if NORMAL_SCALE && TOKSVIG != TOKSVIG_DXT5
  t.xy *= emissive_factor.w;
#endif
  float3 bitangent = cross(i.normal, i.tangent.xyz) * i.tangent.w;
  float3 n = i.tangent.xyz * t.x + bitangent * t.y + i.normal * t.z;
#else
  float3 n = i.normal;
#endif
  n *= rsqrt(max(dot(n, n), 0.00000001));
#if DOUBLE_SIDED
  n *= i.face;
#endif
  return n;
}

float4 base_color(Interpolants i) {
  float4 base = base_color_factor;
#if HAS_BASE_COLOR_MAP
  base *= tex2D(base_color_map, map_uv(i, 0, BASE_COLOR_UV_SET));
#endif
#if HAS_VERTEX_COLOR
  base *= i.color;
#endif
  return base;
}

float3 emitted(Interpolants i) {
  float3 e = emissive_factor.rgb;
#if HAS_EMISSIVE_MAP
  e *= tex2D(emissive_map, map_uv(i, 5, EMISSIVE_UV_SET)).rgb;
#endif
  return e;
}

#if HAS_NORMAL_MAP
// What the bumps under the pixel leave of the power [Toksvig04] [Hill11], made at import (docs/shading.md, section 5).
float filtered_power(Interpolants i, float m) {
#if TOKSVIG == TOKSVIG_TEXTURE
  float factor = tex2D(toksvig_map, map_uv(i, 3, NORMAL_UV_SET)).r;
  float ratio = 0.01 * m;
  return max(m * (factor / (ratio + (1.0 - ratio) * factor + 0.0000001)), 1.0);
#elif TOKSVIG == TOKSVIG_DXT5
  return specular_power(tex2D(normal_map, map_uv(i, 3, NORMAL_UV_SET)).r);
#elif TOKSVIG == TOKSVIG_MATERIAL
  return max(m * toksvig.x, 1.0);
#else
  return m;
#endif
}
#endif

// Metallic-roughness: alpha = rough^2, m = clamp(2 / alpha^2 - 2, 1, 8192) [Walter07]; the upper bound is the lower bound
// on alpha^2, 2 / 8194. Specular-glossiness maps directly.
Surface surface(Interpolants i, float4 base) {
  Surface s;
  s.n = surface_normal(i);
  s.alpha = base.a;
#if SPECULAR_GLOSSINESS
  float4 specular = specular_factor;
#if HAS_SPECULAR_GLOSSINESS_MAP
  specular *= tex2D(specular_glossiness_map, map_uv(i, 2, SPECULAR_GLOSSINESS_UV_SET));
#endif
  s.cdiff = base.rgb;
  s.cspec = specular.rgb;
  s.m = specular_power(specular.a);
#else
  float metallic = material_factors.x;
  float roughness = material_factors.y;
#if HAS_METALLIC_ROUGHNESS_MAP
  float4 texel = tex2D(metallic_roughness_map, map_uv(i, 1, METALLIC_ROUGHNESS_UV_SET));
  metallic *= texel.b;
  roughness *= texel.g;
#endif
  float alpha = roughness * roughness;
  s.m = max(2.0 / max(alpha * alpha, 0.000244081034903588) - 2.0, 1.0);
  s.cspec = lerp(float3(0.04, 0.04, 0.04), base.rgb, metallic);
  s.cdiff = base.rgb * (1.0 - metallic);
#endif
#if HAS_NORMAL_MAP
  s.m = filtered_power(i, s.m);
#endif
  s.occlusion = 1.0;
#if HAS_OCCLUSION_MAP
  s.occlusion = 1.0 + material_factors.w * (tex2D(occlusion_map, map_uv(i, 4, OCCLUSION_UV_SET)).r - 1.0);
#endif
  s.emissive = emitted(i);
  return s;
}
