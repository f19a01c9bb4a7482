layout(location = 0) in vec3 position;
layout(location = 1) in vec3 exitance;
uniform mat4 to_clip;
out vec3 b;
void main() {
  b = exitance;
  gl_Position = to_clip * vec4(position, 1);
}
