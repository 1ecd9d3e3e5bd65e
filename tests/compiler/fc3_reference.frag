#version 450
// The GLSL twin of fc3_reference.hlsl.
#ifndef LIGHTS
#define LIGHTS 4
#endif
#ifndef VISIBILITY
#define VISIBILITY 0
#endif
#ifndef FRESNEL
#define FRESNEL 0
#endif

layout(binding = 0) uniform sampler2D albedo_map;
layout(binding = 1) uniform sampler2D normal_map;
layout(binding = 2) uniform sampler2D specular_map;

uniform vec3 eye;
uniform vec4 sh[7];
uniform float exposure;
uniform float white;
uniform vec4 light_position[LIGHTS];
uniform vec4 light_color[LIGHTS];

layout(location = 0) in vec2 uv;
layout(location = 1) in vec3 position;
layout(location = 2) in vec3 normal;
layout(location = 3) in vec3 tangent;
layout(location = 4) in vec3 binormal;
layout(location = 0) out vec4 color;

float saturate(float x) { return clamp(x, 0.0, 1.0); }

void main() {
  vec4 albedo = texture(albedo_map, uv);
  vec4 specular = texture(specular_map, uv);

  vec3 t;
  t.xy = texture(normal_map, uv).wy * 2.0 - 1.0;
  t.z = sqrt(1.0 - saturate(dot(t.xy, t.xy)));
  vec3 n = normalize(tangent * t.x + binormal * t.y + normal * t.z);
  vec3 v = normalize(eye - position);
  float m = exp2(13.0 * specular.a);

  vec4 n1 = vec4(n, 1.0);
  vec3 linear_part = vec3(dot(sh[0], n1), dot(sh[1], n1), dot(sh[2], n1));
  vec4 b = n.xyzz * n.yzzx;
  vec3 quadratic_part = vec3(dot(sh[3], b), dot(sh[4], b), dot(sh[5], b));
  float c = n.x * n.x - n.y * n.y;
  vec3 ambient = linear_part + quadratic_part + sh[6].rgb * c;
  vec3 sum = ambient * albedo.rgb;
#if VISIBILITY == 2
  float n_dot_v = saturate(dot(n, v));
#endif
  for (int k = 0; k < LIGHTS; ++k) {
    vec3 to_light = light_position[k].xyz - position;
    float d2 = dot(to_light, to_light);
    vec3 l = to_light * inversesqrt(d2);
    vec3 h = normalize(l + v);
    float n_dot_l = saturate(dot(n, l));
    float n_dot_h = saturate(dot(n, h));
    float h_dot_v = saturate(dot(h, l));
    float attenuation = saturate(1.0 - d2 * light_position[k].w);
    attenuation *= attenuation;
#if FRESNEL == 0
    float x = 1.0 - h_dot_v;
    float xx = x * x;
    float f = xx * xx * x;
#else
    float f = exp2((-5.55473 * h_dot_v - 6.98316) * h_dot_v);
#endif
    vec3 fresnel = specular.rgb + (1.0 - specular.rgb) * f;
#if VISIBILITY == 1
    float norm = (2.0 * m + 1.0) / 8.0;
#else
    float norm = (m + 2.0) / 8.0;
#endif
    float d = norm * pow(n_dot_h, m);
#if VISIBILITY == 2
    float a = 1.0 / sqrt(0.78539816 * m + 1.57079633);
    float at_l = n_dot_l * (1.0 - a) + a;
    float at_v = n_dot_v * (1.0 - a) + a;
    d *= 1.0 / (at_l * at_v);
#endif
    vec3 brdf = albedo.rgb + fresnel * d;
    sum += brdf * (light_color[k].rgb * (n_dot_l * attenuation));
  }

  vec3 lit = max(sum * exposure, 0.0);
  vec3 above = lit * (0.22 * lit + 0.03) + 0.002;
  vec3 below = lit * (0.3 * lit + 0.5) + 0.06;
  vec3 mapped = (above / below - 0.0666667) * white;
  color = vec4(mapped, albedo.a);
}
