sampler2D s; float4 c[4]; struct I { float2 uv : TEXCOORD0; float3 n : TEXCOORD1; };
float4 main(I i) : COLOR0 {
  float4 t = tex2D(s, i.uv); float3 r = 0;
  for (int k = 0; k < 4; k++) { if (dot(i.n, c[k].xyz) < 0) continue; r += c[k].rgb * pow(t.a, 5); if (r.x > 9) break; }
  switch ((int)t.x) { case 0: r += 1; break; case 1: case 2: r *= 2; default: r.z = 1; }
  [loop] while (r.x < i.uv.x) r += 0.25;
  if (t.a < 0.5) discard;
  return float4(normalize(r), c[(int)t.x].w);
}
