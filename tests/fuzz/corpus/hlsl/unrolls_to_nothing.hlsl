float4 main(float4 v : TEXCOORD0) : COLOR0 { float r = 0; [unroll] for (int i = 0; i < 60000; i++) [unroll] for (int j = 0; j < 60000; j++) r = r * 1; return v * r; }
