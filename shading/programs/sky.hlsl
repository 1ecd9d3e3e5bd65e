// Sky radiance in a direction: the artists' gradient times the CIE general sky [CIE-S011] [McAuley12], by day and night.
// The same function as shading/sky, which projects it to light; the formulas stand in docs/shading.md.
float4 sky_sun;                        // unit, world, towards the sun
float4 sky_gradation;                  // a, b log2(e)
float4 sky_indicatrix;                 // c, d log2(e), e, 1 - c exp(d pi / 2)
float4 sky_zenith;                     // by day, times intensity and 1 / (f(0) phi(Zs)) or its zenith-relative sister
float4 sky_horizon;
float4 night_zenith;
float4 night_horizon;

// acos, |error| <= 6.7e-5 radians [AS64] 4.4.45.
float angle_of(float cosine) {
  float x = saturate(abs(cosine));
  float angle = sqrt(saturate(1.0 - x)) *
                (((-0.0187293L * x + 0.0742610L) * x - 0.2121144L) * x + 1.5707288L);
  return cosine < 0.0 ? 3.1415926535897932L - angle : angle;
}

// direction: unit. Below the horizon the values of the horizon continue.
float3 sky_radiance(float3 direction) {
  float height = saturate(direction.y);
  float cosine = dot(direction, sky_sun.xyz);
  float phi = 1.0 + sky_gradation.x * saturate(exp2(sky_gradation.y / max(height, 0.000244140625)));
  float f = sky_indicatrix.w + sky_indicatrix.x * saturate(exp2(sky_indicatrix.y * angle_of(cosine))) +
            sky_indicatrix.z * (cosine * cosine);
  float3 day = lerp(sky_horizon.rgb, sky_zenith.rgb, height);
  float3 night = lerp(night_horizon.rgb, night_zenith.rgb, height);
  return max(f * phi, 0.0) * day + night;
}
