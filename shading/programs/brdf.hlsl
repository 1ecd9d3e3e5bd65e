// Far Cry 3's punctual specular, one term per function [McAuley12]. Light carries pi, so these are pi * f.
//
//   specular = F(h.v) * V(n.l, n.v) * norm(m) * (n.h)^m,   m = 2^(13 gloss)
//
// VISIBILITY picks V and the normalisation that goes with it, FRESNEL picks F. The four visibilities differ in nothing
// else, so their cost difference is the cost of the term.
//
// Fixed point asks for three habits, none of which costs an instruction in a light. A value known to lie in [0, 1] is
// written with saturate(), a free modifier that also puts it on the fine unit grid. V, which reaches 6400 where the lobe
// is narrow, is multiplied into the lobe before the normalisation. And the lobe is kept at an eighth with F eight times
// as large, so that no intermediate leaves the range of 2^20 while the product is in it: V * norm alone reaches 6.6e6.
// Constants end in L: full precision, where a plain literal would be rounded to 24 bits.

#ifndef BRDF_HLSL
#define BRDF_HLSL

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
  float x2 = saturate(x * x);
  return saturate(saturate(x2 * x2) * x);
#elif FRESNEL == FRESNEL_SG
  return saturate(exp2(-8.6561702453337812L * h_dot_v));                  // exp(-6 h.v) [Lagarde12]
#else
  return saturate(exp2((-5.55473L * h_dot_v - 6.98316L) * h_dot_v));      // [Lagarde12]
#endif
}

// 8 F, from 8 cspec.
float3 fresnel_8(float3 cspec_8, float h_dot_v) { return cspec_8 + (8.0 - cspec_8) * fresnel_weight(h_dot_v); }

// norm(m) * V * (n.h)^m / 8: everything of the specular term but F.
float specular_lobe_8th(float m, float n_dot_l, float n_dot_v, float n_dot_h) {
  float lobe = saturate(pow(n_dot_h, m));
#if VISIBILITY == VISIBILITY_NONE
  return lobe * (0.015625 * m + 0.03125);                                 // (m + 2) / 8 [Hoffman10]
#elif VISIBILITY == VISIBILITY_SCHLICK_SMITH
  // V = 1 / ((n.l (1 - a) + a) (n.v (1 - a) + a)), a = 1 / sqrt(pi m / 4 + pi / 2) [Lazarov11]. Both factors are kept at
  // a quarter, which makes this 16 V; the normalisation takes the 16 back: (m + 2) / 8 / 8 / 16.
  float a_4 = rsqrt(12.566370614359172L * m + 25.132741228718345L);
  float one_minus_a_4 = 0.25 - a_4;
  float visibility_16 = 1.0 / ((n_dot_l * one_minus_a_4 + a_4) * (n_dot_v * one_minus_a_4 + a_4));
  return visibility_16 * lobe * (0.0009765625 * m + 0.001953125);
#elif VISIBILITY == VISIBILITY_INTEGRATED
  // V = (-ln a / (1 - a))^2: Schlick-Smith averaged over both hemispheres [McAuley12].
  float a = rsqrt(0.78539816339744831L * m + 1.5707963267948966L);
  float root = -0.69314718055994531L * log2(a) / (1.0 - a);
  return lobe * (root * root * (0.015625 * m + 0.03125));
#else
  return lobe * (0.03125 * m + 0.015625);                                 // (2 m + 1) / 8 [McAuley12]
#endif
}

#endif
