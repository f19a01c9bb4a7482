// Weighted sums of a table's rows, a vertex per invocation: the twin of render/transfer/row_sum.cpp.
// Given before this text: const int storage, 0 float, 1 16-bit, 2 8-bit, 3 8-bit code
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Rows { uint rows[]; };
layout(std430, binding = 1) readonly buffer Terms { uvec4 terms[]; };  // row in the buffer, first level of its codebook
layout(std430, binding = 2) readonly buffer Weights { vec4 weights[]; };
layout(std430, binding = 3) readonly buffer Codebooks { float levels[]; };
layout(std430, binding = 4) buffer Exitance { float exitance[]; };

uniform int vertices, stride, term_count;

float value(uvec4 term, uint v) {
  uint at = term.x * uint(stride) + v;
  if (storage == 0) return uintBitsToFloat(rows[at]);
  if (storage == 1) return float(bitfieldExtract(int(rows[at >> 1]), int(at & 1u) * 16, 16));
  int shift = int(at & 3u) * 8;
  if (storage == 2) return float(bitfieldExtract(int(rows[at >> 2]), shift, 8));
  return levels[term.y + bitfieldExtract(rows[at >> 2], shift, 8)];
}

void main() {
  uint v = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u;
  if (v >= uint(vertices)) return;
  vec3 sum = vec3(exitance[3u * v], exitance[3u * v + 1u], exitance[3u * v + 2u]);
  for (int i = 0; i < term_count; ++i) sum += weights[i].rgb * value(terms[i], v);
  exitance[3u * v] = sum.r, exitance[3u * v + 1u] = sum.g, exitance[3u * v + 2u] = sum.b;
}
