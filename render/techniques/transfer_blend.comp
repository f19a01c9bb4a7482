// Adds the blend of the reference points' exitance, if there are any, to its bounded correction, and leaves nothing below
// 0.
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Triangles { uvec4 triangles[]; };       // of reference points
layout(std430, binding = 1) readonly buffer Places { uvec2 places[]; };             // triangle, two packed weights
layout(std430, binding = 2) readonly buffer Reference { float reference[]; };       // exitance of reference points
layout(std430, binding = 4) buffer Exitance { float exitance[]; };

uniform int vertices, blended;
uniform float weight_unit, correction;

vec3 corner(uint point) { return vec3(reference[3u * point], reference[3u * point + 1u], reference[3u * point + 2u]); }

void main() {
  uint v = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u;
  if (v >= uint(vertices)) return;
  vec3 sum = vec3(exitance[3u * v], exitance[3u * v + 1u], exitance[3u * v + 2u]);
  if (blended != 0) {
    uvec4 triangle = triangles[places[v].x];
    int packed_weights = int(places[v].y);
    float a = float(bitfieldExtract(packed_weights, 0, 16)) / weight_unit,
          b = float(bitfieldExtract(packed_weights, 16, 16)) / weight_unit;
    vec3 blend = a * corner(triangle.x) + b * corner(triangle.y) + (1.0 - a - b) * corner(triangle.z);
    vec3 most = correction * abs(blend);
    sum = blend + clamp(sum, -most, most);
  }
  sum = max(sum, vec3(0));
  exitance[3u * v] = sum.r, exitance[3u * v + 1u] = sum.g, exitance[3u * v + 2u] = sum.b;
}
