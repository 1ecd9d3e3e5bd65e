float4x4 m; float4 t[8]; struct S { float4 p : POSITION; float2 u : TEXCOORD0; };
S main(float4 p : POSITION, float2 u : TEXCOORD0) { S o; o.p = mul(p, m) + t[(int)u.x]; o.u = u.yx; return o; }
