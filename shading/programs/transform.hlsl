// Vertex shader of every mesh: world space to clip space; the rest travels on unchanged.
// Meshes are baked into world space when the scene is loaded, as static level geometry was.

float4x4 world_to_clip;

struct Vertex {
  float3 position : POSITION0;
  float3 normal : NORMAL0;
#if HAS_NORMAL_MAP
  float4 tangent : TANGENT0;
#endif
#if HAS_UV
  float4 uv : TEXCOORD0;
#endif
#if HAS_VERTEX_COLOR
  float4 color : COLOR0;
#endif
};

struct Transformed {
  float4 clip : POSITION;
  float3 position : TEXCOORD0;
  float3 normal : TEXCOORD1;
#if HAS_NORMAL_MAP
  float4 tangent : TEXCOORD2;
#endif
#if HAS_UV
  float4 uv : TEXCOORD3;
#endif
#if HAS_VERTEX_COLOR
  float4 color : COLOR0;
#endif
};

Transformed main(Vertex v) {
  Transformed t;
  t.clip = mul(world_to_clip, float4(v.position, 1.0));
  t.position = v.position;
  t.normal = v.normal;
#if HAS_NORMAL_MAP
  t.tangent = v.tangent;
#endif
#if HAS_UV
  t.uv = v.uv;
#endif
#if HAS_VERTEX_COLOR
  t.color = v.color;
#endif
  return t;
}
