// What light sees of a pixel, however it got there: from interpolants and maps (material.hlsl) or from the G-buffer
// (gbuffer.hlsl).
#ifndef SURFACE_HLSL
#define SURFACE_HLSL

struct Surface {
  float3 n;                            // unit, world
  float3 cdiff;
  float3 cspec;
  float3 emissive;
  float m;                             // Blinn-Phong power
  float occlusion;
  float alpha;
};

#endif
