// One triangle over the whole picture, in front of nothing: its uv are NDC, its ray goes to the pixel shader unnormalised.
float4 view_forward;
float4 view_right;
float4 view_up;
float4 dome_depth;                     // x: clip z at w = 1, the last depth before what was cleared

struct Corner {
  float4 clip : POSITION;
  float3 ray : TEXCOORD0;
};

Corner main(float4 ndc : TEXCOORD0) {
  Corner c;
  c.clip = float4(ndc.x, ndc.y, dome_depth.x, 1.0);
#if ORTHOGRAPHIC
  c.ray = view_forward.xyz;
#else
  c.ray = view_right.xyz * ndc.x + view_up.xyz * ndc.y + view_forward.xyz;
#endif
  return c;
}
