// Far Cry 3's forward shading written to be counted by hand: every statement below is the instruction count beside it.
// LIGHTS, VISIBILITY (0 none, 1 cheap, 2 schlick-smith), FRESNEL (0 schlick, 1 spherical gaussian)
#ifndef LIGHTS
#define LIGHTS 4
#endif
#ifndef VISIBILITY
#define VISIBILITY 0
#endif
#ifndef FRESNEL
#define FRESNEL 0
#endif

sampler2D albedo_map : register(s0);
sampler2D normal_map : register(s1);
sampler2D specular_map : register(s2);

float3 eye : register(c0);
float4 sh[7] : register(c1);
float exposure : register(c8);
float white : register(c9);
float4 light_position[LIGHTS] : register(c16);  // w: 1 / radius^2
float4 light_color[LIGHTS] : register(c80);

struct Interpolants {
  float2 uv : TEXCOORD0;
  float3 position : TEXCOORD1;
  float3 normal : TEXCOORD2;
  float3 tangent : TEXCOORD3;
  float3 binormal : TEXCOORD4;
};

float4 main(Interpolants i) : COLOR0 {
  float4 albedo = tex2D(albedo_map, i.uv);
  float4 specular = tex2D(specular_map, i.uv);

  float3 t;
  t.xy = tex2D(normal_map, i.uv).wy * 2.0 - 1.0;                    // mad
  t.z = sqrt(1.0 - saturate(dot(t.xy, t.xy)));                      // dp2_sat, add, sqrt
  float3 n = i.tangent * t.x + i.binormal * t.y + i.normal * t.z;   // mul, mad, mad
  n = normalize(n);                                                 // dp3, rsq, mul
  float3 v = normalize(eye - i.position);                           // add, dp3, rsq, mul
  float m = exp2(13.0 * specular.a);                                // mul, exp

  float4 n1 = float4(n, 1.0);                                       // mov
  float3 linear_part = float3(dot(sh[0], n1), dot(sh[1], n1), dot(sh[2], n1));
  float4 b = n.xyzz * n.yzzx;                                       // 3 dp4; mul
  float3 quadratic_part = float3(dot(sh[3], b), dot(sh[4], b), dot(sh[5], b));
  float c = n.x * n.x - n.y * n.y;                                  // 3 dp4; mul, mad
  float3 ambient = linear_part + quadratic_part + sh[6].rgb * c;    // add, mad
  float3 sum = ambient * albedo.rgb;                                // mul
#if VISIBILITY == 2
  float n_dot_v = saturate(dot(n, v));                              // dp3_sat
#endif
#ifdef UNROLL
  [unroll]
#endif
  for (int k = 0; k < LIGHTS; ++k) {
    float3 to_light = light_position[k].xyz - i.position;           // add
    float d2 = dot(to_light, to_light);                             // dp3
    float3 l = to_light * rsqrt(d2);                                // rsq, mul
    float3 h = normalize(l + v);                                    // add, dp3, rsq, mul
    float n_dot_l = saturate(dot(n, l));                            // dp3_sat
    float n_dot_h = saturate(dot(n, h));                            // dp3_sat
    float h_dot_v = saturate(dot(h, l));                            // dp3_sat: h.l = h.v
    float attenuation = saturate(1.0 - d2 * light_position[k].w);   // mad_sat
    attenuation *= attenuation;                                     // mul
#if FRESNEL == 0
    float x = 1.0 - h_dot_v;                                        // add
    float xx = x * x;                                               // mul
    float f = xx * xx * x;                                          // mul, mul
#else
    float f = exp2((-5.55473 * h_dot_v - 6.98316) * h_dot_v);       // mad, mul, exp
#endif
    float3 fresnel = specular.rgb + (1.0 - specular.rgb) * f;       // add, mad
#if VISIBILITY == 1
    float norm = (2.0 * m + 1.0) / 8.0;                             // mad
#else
    float norm = (m + 2.0) / 8.0;                                   // mad
#endif
    float d = norm * pow(n_dot_h, m);                               // log, mul, exp, mul
#if VISIBILITY == 2
    float a = 1.0 / sqrt(0.78539816 * m + 1.57079633);              // mad, rsq
    float at_l = n_dot_l * (1.0 - a) + a;                           // add, mad
    float at_v = n_dot_v * (1.0 - a) + a;                           // mad
    d *= 1.0 / (at_l * at_v);                                       // mul, rcp, mul
#endif
    float3 brdf = albedo.rgb + fresnel * d;                         // mad
    sum += brdf * (light_color[k].rgb * (n_dot_l * attenuation));   // mul, mul, mad
  }

  float3 lit = max(sum * exposure, 0.0);                            // mul, max
  float3 above = lit * (0.22 * lit + 0.03) + 0.002;                 // mad, mad
  float3 below = lit * (0.3 * lit + 0.5) + 0.06;                   // mad, mad
  float3 mapped = (above / below - 0.0666667) * white;              // 3 rcp, mad, mul
  return float4(mapped, albedo.a);                                  // mov
}
