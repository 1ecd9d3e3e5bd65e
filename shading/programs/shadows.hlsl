// Shadow maps: the first SHADOW_COUNT lights have one each, side by side in one D24 texture read as three bytes. One point
// sample, compared in the shader.
#if SHADOW_COUNT > 0
sampler2D shadow_map;
float4 shadow_matrix[4 * SHADOW_COUNT];  // rows: u, v, depth, w of a world position
float4 shadow_bias[SHADOW_COUNT];        // x: step along the normal, y: depth

// 1 where nothing stands between the light and p, else 0.
float lit_by(int i, float3 p, float3 n) {
  float4 q = float4(p + n * shadow_bias[i].x, 1.0);
  float over_w = 1.0 / dot(shadow_matrix[4 * i + 3], q);
  float2 uv = float2(dot(shadow_matrix[4 * i], q), dot(shadow_matrix[4 * i + 1], q)) * over_w;
  float depth = dot(shadow_matrix[4 * i + 2], q) * over_w;
  float nearest = dot(tex2Dlod(shadow_map, float4(uv, 0.0, 0.0)).xyz,
                      float3(0.9960938093718177L, 0.003890991442858663L, 0.000015199185323666652L));
  return nearest + shadow_bias[i].y >= depth ? 1.0 : 0.0;
}
#endif
