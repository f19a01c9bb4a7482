// Exitance interpolated over the triangle, and which object it is.
in vec3 b;
layout(location = 0) out vec4 colour;
uniform float object;
void main() { colour = vec4(b, object); }
