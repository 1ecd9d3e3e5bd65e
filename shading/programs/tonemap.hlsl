// Resolve pass: HDR linear radiance to displayable linear [0, 1]. Runs only when a tone map is asked for; without one the
// render target's own clamp does the work and there is no pass to pay for.

#define TONEMAP_REINHARD 1
#define TONEMAP_FILMIC 2

float4 main(float4 radiance : TEXCOORD0) : COLOR0 {
  float3 c = max(radiance.rgb, 0.0);
#if TONEMAP == TONEMAP_REINHARD
  c = c / (1.0 + c);                                                      // [Reinhard02], per channel
#else
  // Filmic shoulder and toe, exposure 2, white at 11.2 [Hable10].
  c = min(c, 1000.0) * 2.0;
  float3 mapped = ((c * (0.15 * c + 0.05) + 0.004) / (c * (0.15 * c + 0.50) + 0.06)) - 0.0666666666666667;
  c = saturate(mapped * 1.37906);
#endif
  return float4(c, radiance.a);
}
