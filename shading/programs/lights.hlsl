// The light loop's inputs. One record per light, in uniform arrays so that a rolled loop can index them.
#ifndef LIGHT_COUNT
#define LIGHT_COUNT 1
#endif

#if LIGHT_COUNT > 0
float4 light_position[LIGHT_COUNT];    // xyz: position, or direction to the light; w: 1 for a position, 0 for a direction
float4 light_color[LIGHT_COUNT];       // rgb: linear, carries pi; w: falloff k1 in 1 / (k0 + k1 d^2)
#if PUNCTUAL_LIGHTS                    // KHR_lights_punctual: inverse square, range window, spot cone
float4 light_window[LIGHT_COUNT];      // x: 1 / range^2 (0: unlimited); y: k0; z, w: spot scale and offset
float4 light_axis[LIGHT_COUNT];        // xyz: unit vector from the target back to the light (spot), else 0
#endif

// 1 / (k0 + k1 d^2), with the range window and the spot cone of KHR_lights_punctual when lights come from the file.
float attenuation(int i, float distance_squared, float3 l) {
#if PUNCTUAL_LIGHTS
  float falloff = 1.0 / max(light_window[i].y + distance_squared * light_color[i].w, 0.00001);
  float reach = distance_squared * light_window[i].x;
  float window = saturate(1.0 - reach * reach);
  float cone = saturate(dot(light_axis[i].xyz, l) * light_window[i].z + light_window[i].w);
  return falloff * window * (cone * cone);
#else
  return 1.0 / (distance_squared * light_color[i].w + 1.0);
#endif
}
#endif
