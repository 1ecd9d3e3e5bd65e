#define F(x) (x) + (x) + (x)
float4 main(float4 v : TEXCOORD0) : COLOR0 { return F(F(F(F(F(F(F(F(F(F(F(F(F(F(F(F(F(F(F(F(v)))))))))))))))))))); }
