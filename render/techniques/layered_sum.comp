// Spectra of layers, each times a kernel, summed into the spectra of others. Kernels are tabulated as in
// render/layered/kernel_spectrum.h.
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Input { vec2 source[]; };
layout(std430, binding = 1) buffer Output { vec2 result[]; };
layout(std430, binding = 2) readonly buffer Table { float table[]; };
layout(std430, binding = 3) readonly buffer AxisX { vec2 axis_x[]; };  // frequency and factor
layout(std430, binding = 4) readonly buffer AxisY { vec2 axis_y[]; };
// Output i is the sum of the products starts[i] .. starts[i + 1] - 1: the layer, and the places of the rows of the
// kernel that is added and of the one that is subtracted, or -1.
layout(std430, binding = 5) readonly buffer Starts { int starts[]; };
layout(std430, binding = 6) readonly buffer Products { ivec4 products[]; };

uniform ivec2 size;
uniform int first_entry, shift;
uniform bool overwrite;
uniform float offset, scale;

float kernel(int row, float share) { return mix(table[row], table[row + 1], share); }

void main() {
  int u = int(gl_GlobalInvocationID.x), v = int(gl_GlobalInvocationID.y), o = int(gl_GlobalInvocationID.z);
  if (u >= size.x) return;
  vec2 x = axis_x[u], y = axis_y[v];
  int bits = floatBitsToInt(x.x * x.x + y.x * y.x + offset);
  int entry = (bits >> shift) - first_entry, at = v * size.x + u, image = size.x * size.y;
  float share = float(bits & ((1 << shift) - 1)) / float(1 << shift);
  vec2 sum = vec2(0);
  for (int i = starts[o]; i < starts[o + 1]; ++i) {
    ivec4 p = products[i];
    float k = kernel(p.y + entry, share);
    if (p.z >= 0) k -= kernel(p.z + entry, share);
    sum += k * source[p.x * image + at];
  }
  sum *= scale * x.y * y.y;
  result[o * image + at] = overwrite ? sum : result[o * image + at] + sum;
}
