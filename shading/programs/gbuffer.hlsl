// The G-buffer's layout, said once: what a surface becomes in 32-bit targets and what a light pass reads back.
//
//   target 0  RGBA8 sRGB   cdiff, occlusion (linear)
//   target 1  RGB10A2      normal * 0.5 + 0.5, not used
//   target 2  RGBA8 sRGB   cspec, gloss = log2(m) / 13 (linear)
//   target 3  RGBA8 sRGB   emissive over its greatest value; written and read only where a surface of the frame glows
//   depth     D24          position, along the pixel's view ray
//
// Gloss is stored as log2 of the power: one of 255 steps is a factor of 1.036 in m wherever it lies. Colours are stored in
// sRGB by the target and decoded by the fetch, free of instructions on both consoles.
#include "surface.hlsl"
#include "brdf.hlsl"

#if GBUFFER_EMISSIVE
float4 gbuffer_emissive_scale;         // x: the frame's brightest emission, up to a power of two; y: 1 / x
#endif

struct GBufferTexels {
  float4 diffuse : COLOR0;
  float4 normal : COLOR1;
  float4 specular : COLOR2;
#if GBUFFER_EMISSIVE
  float4 emissive : COLOR3;
#endif
};

GBufferTexels to_gbuffer(Surface s) {
  GBufferTexels t;
  t.diffuse = float4(s.cdiff, s.occlusion);
  t.normal = float4(s.n * 0.5 + 0.5, 0.0);
  t.specular = float4(s.cspec, 0.076923076923076927L * log2(s.m));
#if GBUFFER_EMISSIVE
  t.emissive = float4(s.emissive * gbuffer_emissive_scale.y, 0.0);
#endif
  return t;
}

#if GBUFFER_READ
sampler2D gbuffer_diffuse;
sampler2D gbuffer_normal;
sampler2D gbuffer_specular;
sampler2D gbuffer_depth;               // D24 as three bytes, the highest in red
#if GBUFFER_EMISSIVE
sampler2D gbuffer_emissive;
#endif

float4 depth_to_distance;              // x - y depth = z / distance along the view
float4 view_forward;                   // unit; w unused
float4 view_right;                     // scaled so that ndc reaches the edge of the picture at distance 1
float4 view_up;
float4 view_origin;                    // the eye

Surface from_gbuffer(float2 uv) {
  Surface s;
  float4 diffuse = tex2D(gbuffer_diffuse, uv);
  float4 specular = tex2D(gbuffer_specular, uv);
  float3 n = tex2D(gbuffer_normal, uv).xyz * 2.0 - 1.0;
  s.n = n * rsqrt(max(dot(n, n), 0.00000001));
  s.cdiff = diffuse.rgb;
  s.occlusion = diffuse.a;
  s.cspec = specular.rgb;
  s.m = specular_power(specular.a);
#if GBUFFER_EMISSIVE
  s.emissive = tex2D(gbuffer_emissive, uv).rgb * gbuffer_emissive_scale.x;
#else
  s.emissive = float3(0.0, 0.0, 0.0);
#endif
  s.alpha = 1.0;
  return s;
}

// Position from depth: the eye, and the pixel's ray times the distance along the view.
float3 position_from_depth(float2 uv, float2 ndc) {
  // Bytes of D24: 255 * 65536, 255 * 256, 255 over 2^24 - 1.
  float depth = saturate(dot(tex2D(gbuffer_depth, uv).xyz,
                             float3(0.9960938093718177L, 0.003890991442858663L, 0.000015199185323666652L)));
#if ORTHOGRAPHIC
  float distance = depth_to_distance.x + depth * depth_to_distance.y;
  return view_origin.xyz + view_right.xyz * ndc.x + view_up.xyz * ndc.y + view_forward.xyz * distance;
#else
  float distance = depth_to_distance.z / (depth_to_distance.x - depth * depth_to_distance.y);
  float3 ray = view_right.xyz * ndc.x + view_up.xyz * ndc.y + view_forward.xyz;
  return view_origin.xyz + ray * distance;
#endif
}
#endif
