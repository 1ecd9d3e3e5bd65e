// A console-era forward light loop: normal map, Blinn-Phong with Schlick Fresnel, optional Schlick-Smith visibility.
#ifndef LIGHTS
#define LIGHTS 1
#endif
#ifndef SCHLICK_SMITH
#define SCHLICK_SMITH 0
#endif
sampler2D albedo_map;
sampler2D normal_map;
sampler2D gloss_map;
float4 light_position[8];   // w = 1 / range^2
float4 light_color[8];
float3 eye;
float3 ambient;

float4 main(float2 uv : TEXCOORD0, float3 world : TEXCOORD1, float3 normal : TEXCOORD2, float3 tangent : TEXCOORD3) : COLOR0
{
  float4 albedo = tex2D(albedo_map, uv);
  float4 bump = tex2D(normal_map, uv);
  float4 gloss = tex2D(gloss_map, uv);
  float3 t;
  t.xy = bump.wy * 2.0 - 1.0;
  t.z = sqrt(1.0 - t.x * t.x - t.y * t.y);
  float3 n = normalize(tangent * t.x + cross(normal, tangent) * t.y + normal * t.z);
  float3 v = normalize(eye - world);
  float m = exp2(gloss.x * 13.0);
  float norm = m * 0.125 + 0.25;
  float3 sum = ambient * albedo.rgb;
  [unroll] for (int i = 0; i < LIGHTS; ++i)
  {
    float3 to_light = light_position[i].xyz - world;
    float d2 = dot(to_light, to_light);
    float3 l = to_light * rsqrt(d2);
    float3 h = normalize(l + v);
    float nl = saturate(dot(n, l));
    float nh = saturate(dot(n, h));
    float hv = saturate(dot(h, v));
    float window = saturate(1.0 - d2 * light_position[i].w);
    float k = 1.0 - hv;
    float k2 = k * k;
    float fresnel = gloss.y + (1.0 - gloss.y) * (k2 * k2 * k);
    float spec = fresnel * norm * pow(nh, m);
#if SCHLICK_SMITH
    float a = rsqrt(0.785398 * m + 1.570796);
    float nv = saturate(dot(n, v));
    spec *= 1.0 / ((nl * (1.0 - a) + a) * (nv * (1.0 - a) + a));
#endif
    sum += (albedo.rgb + spec) * light_color[i].rgb * (nl * window * window);
  }
  return float4(sum, albedo.a);
}
