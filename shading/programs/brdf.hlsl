// Far Cry 3's punctual specular, one term per function [McAuley12]. Light carries pi, so these are pi * f.
//
//   specular = F(h.v) * V(n.l, n.v) * norm(m) * (n.h)^m,   m = 2^(13 gloss)
//
// VISIBILITY picks V and the normalisation that goes with it, FRESNEL picks F. The four visibilities differ in nothing
// else, so their cost difference is the cost of the term.
//
// Fixed point asks for two habits that cost no instruction. A value known to lie in [0, 1] is written with saturate(),
// a free modifier that also puts it on the fine unit grid. And V, which reaches 6400 where the lobe is narrow, is
// multiplied into the lobe before the normalisation, so that no intermediate leaves the range while the product is in it.

#define VISIBILITY_NONE 0
#define VISIBILITY_SCHLICK_SMITH 1
#define VISIBILITY_INTEGRATED 2
#define VISIBILITY_CHEAP 3
#ifndef VISIBILITY
#define VISIBILITY VISIBILITY_SCHLICK_SMITH
#endif

#define FRESNEL_SCHLICK 0
#define FRESNEL_SG 1
#define FRESNEL_SG_LAGARDE 2
#ifndef FRESNEL
#define FRESNEL FRESNEL_SCHLICK
#endif

// Specular power of a gloss in [0, 1]: 1 .. 8192 [McAuley12].
float specular_power(float gloss) { return exp2(13.0 * gloss); }

// Weight of (1 - cspec) in F = cspec + (1 - cspec) w.
float fresnel_weight(float h_dot_v) {
#if FRESNEL == FRESNEL_SCHLICK
  float x = saturate(1.0 - h_dot_v);                                      // [Schlick94]
  float x2 = x * x;
  return x2 * x2 * x;
#elif FRESNEL == FRESNEL_SG
  return saturate(exp2(-8.65617024533378 * h_dot_v));                     // exp(-6 h.v) [Lagarde12]
#else
  return saturate(exp2((-5.55473 * h_dot_v - 6.98316) * h_dot_v));        // [Lagarde12]
#endif
}

float3 fresnel(float3 cspec, float h_dot_v) { return cspec + (1.0 - cspec) * fresnel_weight(h_dot_v); }

// norm(m) * V, times (n.h)^m: everything of the specular term but F.
float specular_lobe(float m, float n_dot_l, float n_dot_v, float n_dot_h) {
  float lobe = saturate(pow(n_dot_h, m));
#if VISIBILITY == VISIBILITY_NONE
  return lobe * (0.125 * m + 0.25);                                       // (m + 2) / 8 [Hoffman10]
#elif VISIBILITY == VISIBILITY_SCHLICK_SMITH
  // V = 1 / ((n.l (1 - a) + a) (n.v (1 - a) + a)), a = 1 / sqrt(pi m / 4 + pi / 2) [Lazarov11]. Both factors are kept at
  // a quarter, which makes this 16 V; the normalisation takes the 16 back: (m + 2) / 128.
  float a_4 = rsqrt(12.5663706143592 * m + 25.1327412287183);
  float one_minus_a_4 = 0.25 - a_4;
  float visibility_16 = 1.0 / ((n_dot_l * one_minus_a_4 + a_4) * (n_dot_v * one_minus_a_4 + a_4));
  return visibility_16 * lobe * (0.0078125 * m + 0.015625);
#elif VISIBILITY == VISIBILITY_INTEGRATED
  // V = (-ln a / (1 - a))^2: Schlick-Smith averaged over both hemispheres [McAuley12].
  float a = rsqrt(0.785398163397448 * m + 1.5707963267949);
  float root = -0.693147180559945 * log2(a) / (1.0 - a);
  return lobe * (root * root * (0.125 * m + 0.25));
#else
  return lobe * (0.25 * m + 0.125);                                       // (2 m + 1) / 8 [McAuley12]
#endif
}
