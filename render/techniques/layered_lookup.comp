// What the layers have at the visible points: linear between the four nodes and the two layers around each.
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Layers { vec2 nodes[]; };
layout(std430, binding = 1) readonly buffer Points { vec4 points[]; };  // x, y, lower layer, share of the next one
layout(std430, binding = 2) buffer Sums { float sums[]; };
layout(std430, binding = 3) readonly buffer Images { int images[]; };  // of each layer its image, or -1

uniform int first_point, last_point, width, height, outputs, to;

float in_layer(int layer, vec2 p) {
  if (images[layer] < 0) return 0.0;
  ivec2 at = ivec2(p);
  vec2 f = p - vec2(at);
  int n = (images[layer] * height + at.y) * width + at.x;
  float upper = mix(nodes[n].x, nodes[n + 1].x, f.x), under = mix(nodes[n + width].x, nodes[n + width + 1].x, f.x);
  return mix(upper, under, f.y);
}

void main() {
  int i = first_point + int(gl_GlobalInvocationID.x);
  if (i >= last_point) return;
  vec4 p = points[i];
  int lower = int(p.z);
  float sum = 0.0;
  if (p.w < 1.0) sum += (1.0 - p.w) * in_layer(lower, p.xy);
  if (p.w > 0.0) sum += p.w * in_layer(lower + 1, p.xy);
  sums[i * outputs + to] = sum;
}
