// The sky dome behind everything. The fake polarising filter [McAuley12] belongs to what the eye sees of the sky and is
// applied here, never to the light the sky casts.
#include "sky.hlsl"

#if POLARIZER
float4 polarizer;                      // rgb factor
#endif

float4 main(float3 ray : TEXCOORD0) : COLOR0 {
  float3 radiance = sky_radiance(ray * rsqrt(max(dot(ray, ray), 0.00000001)));
#if POLARIZER
  radiance *= polarizer.rgb;
#endif
  return float4(radiance, 1.0);
}
