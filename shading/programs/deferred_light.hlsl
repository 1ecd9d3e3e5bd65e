// Light passes over the G-buffer: what forward shading adds up in one shader, one group of lights at a time.
// AMBIENT: this draw also brings emitted and ambient light. ACCUMULATE: what earlier draws left in the light buffer is an
// input and LIGHT_COUNT lights go on top, in order, so that any grouping gives the same bits; a console blends instead.
#define GBUFFER_READ 1
#include "gbuffer.hlsl"
#include "lighting.hlsl"

float4 main(float4 screen : TEXCOORD0  // uv, ndc
#if ACCUMULATE
            , float4 below : TEXCOORD1
#endif
            ) : COLOR0 {
  Surface s = from_gbuffer(screen.xy);
  float3 position = position_from_depth(screen.xy, screen.zw);
  float3 radiance = float3(0.0, 0.0, 0.0);
#if ACCUMULATE
  radiance = below.rgb;
#endif
#if AMBIENT
  radiance += s.emissive + ambient_reflected(s, position);
#endif
#if LIGHT_COUNT > 0
  radiance = add_lights(s, position, radiance);
#endif
  return float4(radiance, 1.0);
}
