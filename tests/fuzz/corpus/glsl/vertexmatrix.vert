#version 450
layout(location = 0) in vec4 p;
layout(location = 0) out vec2 u;
uniform mat4 m;
void main() { gl_Position = m * p; u = transpose(m)[int(p.x) & 3].xy; }
