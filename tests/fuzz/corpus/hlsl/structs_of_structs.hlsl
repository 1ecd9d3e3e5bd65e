struct S0 { float4 a[8]; };
struct S1 { S0 a, b, c, d; };
struct S2 { S1 a, b, c, d; };
struct S3 { S2 a, b, c, d; };
struct S4 { S3 a, b, c, d; };
struct S5 { S4 a, b, c, d; };
struct S6 { S5 a, b, c, d; };
struct S7 { S6 a, b, c, d; };
struct S8 { S7 a, b, c, d; };
struct S9 { S8 a, b, c, d; };
struct S10 { S9 a, b, c, d; };
struct S11 { S10 a, b, c, d; };
S11 u;
float4 main(float4 v : TEXCOORD0) : COLOR0 { return v + u.a.a.a.a.a.a.a.a.a.a.a.a[0]; }
