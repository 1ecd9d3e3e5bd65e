float4 main(float4 v : TEXCOORD0) : COLOR0 { [loop] for (int i = 0; i < 60000; i++) [loop] for (int j = 0; j < 60000; j++) [loop] for (int k = 0; k < 60000; k++) v = v * v + 1; return v; }
