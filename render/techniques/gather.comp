// One query per invocation: a walk through the cluster tree with skip pointers, near cells split in quarters until
// they are small. One loop and no stack: it stops after some steps and goes on in the next dispatch, because software
// renderers end a loop silently after 65536 turns. The twin of render/irradiance/gather.h and profile_sum.cpp, but for
// two things: a cluster is judged by an estimate of its own error alone, so more of them are opened than on the
// processor, and the two-point rule keeps the mean and the variance of q, with that of a disk for |delta|^2.
// Given before this text, as constants, because software renderers run both sides of every branch:
//   int masses; bool clusters, solid_angle
layout(local_size_x = 64) in;

struct Node {
  vec4 centre;      // flux-weighted; and radius
  vec4 covariance;  // xx, xy, xz, yy
  vec4 more;        // yz, zz, area
  uvec4 links;      // skip, cell (no_cell: inner)
};
layout(std430, binding = 0) readonly buffer Nodes { Node nodes[]; };
layout(std430, binding = 1) readonly buffer Masses { float mass[]; };
layout(std430, binding = 2) readonly buffer FirstMoments { float first_moment[]; };
layout(std430, binding = 3) readonly buffer Cells { vec4 corners[]; };
layout(std430, binding = 4) readonly buffer Queries { vec4 queries[]; };
layout(std430, binding = 5) buffer Sums { vec4 sums[]; };
layout(std430, binding = 6) buffer Carries { vec4 carries[]; };
// Where a query is: a node, and while its leaf's cell is in parts, which of them.
struct Walk {
  uint node, path, depth, padding;
};
layout(std430, binding = 7) buffer Walks { Walk walks[]; };
layout(std430, binding = 8) buffer Progress { int unfinished; };

uniform int first_query, last_query, steps, node_count;
uniform float tolerance, core_squared, quality;
uniform vec3 tables;  // which profile serves each channel of three masses

const uint no_cell = 0xffffffffu;
const int max_depth = 12;
// Estimated remainder of the two-point rule, and how near a patch may be.
const float third_remainder = 0.003, fourth_remainder = 0.3, max_opening = 0.5;

bool acceptable(float d2, float radius, float trace) {
  if (radius * radius > max_opening * (d2 + core_squared)) return false;
  float s = profile_scale(d2), w = trace / (d2 + core_squared);
  return third_remainder * s * s * s * radius * trace + fourth_remainder * w * w <= tolerance;
}

vec3 masses_of(uint node) {
  if (masses == 1) return vec3(mass[node]);
  return vec3(mass[3u * node], mass[3u * node + 1u], mass[3u * node + 2u]);
}

vec3 profiles_of(float r2) {
  vec3 r = profile(r2);
  if (masses == 1) return r;
  ivec3 t = ivec3(tables);
  return vec3(r[t.x], r[t.y], r[t.z]);
}

// The two-point rule. `scale` shrinks the covariance to that of a part; moments: 0 for a point.
vec3 patch_sum(uint node, vec3 from_centre, float scale, bool whole) {
  Node n = nodes[node];
  vec3 d = from_centre;
  float xx = scale * n.covariance.x, xy = scale * n.covariance.y, xz = scale * n.covariance.z,
        yy = scale * n.covariance.w, yz = scale * n.more.x, zz = scale * n.more.y;
  float trace = xx + yy + zz;
  float along = xx * d.x * d.x + yy * d.y * d.y + zz * d.z * d.z +
                2.0 * (xy * d.x * d.y + xz * d.x * d.z + yz * d.y * d.z);
  float spread = sqrt(max(4.0 * along + trace * trace / 3.0, 0.0));
  float middle = dot(d, d) + trace;
  vec3 near = profiles_of(max(middle - spread, 0.0)), far = profiles_of(middle + spread);
  vec3 sum = 0.5 * masses_of(node) * (near + far);
  if (masses == 3 && whole && spread > 0.0) {
    vec3 moved = vec3(0);
    for (uint axis = 0u; axis < 3u; ++axis)
      for (uint m = 0u; m < 3u; ++m) moved[m] += d[axis] * first_moment[(3u * node + axis) * 3u + m];
    sum += moved / spread * (near - far);
  }
  return sum;
}

// Centroid of the part of a cell that `path` names: two bits a level, the last split in the lowest.
vec3 part_centre(uint cell, uint path, int depth) {
  vec3 a = corners[3u * cell].xyz, b = corners[3u * cell + 1u].xyz, c = corners[3u * cell + 2u].xyz;
  for (int level = max_depth - 1; level >= 0; --level) {  // of constant length, to be unrolled
    if (level >= depth) continue;
    uint k = (path >> uint(2 * level)) & 3u;
    vec3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
    if (k == 0u) b = ab, c = ca;
    else if (k == 1u) a = ab, c = bc;
    else if (k == 2u) a = ca, b = bc;
    else a = ab, b = bc, c = ca;
  }
  return (a + b + c) / 3.0;
}

void main() {
  int query = first_query + int(gl_GlobalInvocationID.x);
  if (query >= last_query) return;
  vec3 x = queries[query].xyz, sum = sums[query].xyz, carry = carries[query].xyz;
  Walk walk = walks[query];
  uint i = walk.node, path = walk.path;
  int depth = int(walk.depth);
  for (int step = 0; step < steps && i < uint(node_count); ++step) {
    Node n = nodes[i];
    float trace = n.covariance.x + n.covariance.w + n.more.y, scale = 1.0;
    vec3 d;
    if (depth > 0) {
      scale = exp2(-2.0 * float(depth));
      d = x - part_centre(n.links.y, path, depth);
      if (depth < max_depth && !acceptable(dot(d, d), n.centre.w * exp2(-float(depth)), trace * scale)) {
        path = path << 2u, ++depth;
        continue;
      }
    } else {
      d = x - n.centre.xyz;
      float d2 = dot(d, d);
      bool leaf = n.links.y != no_cell;
      bool use = solid_angle ? leaf || (d2 > n.centre.w * n.centre.w && n.more.z < quality * d2)
                                  : (leaf || clusters) && acceptable(d2, n.centre.w, trace);
      if (!use) {
        if (leaf) depth = 1, path = 0u;
        else ++i;
        continue;
      }
    }
    // Kahan's sum: a million equal terms in float would drift by 1e-3.
    precise vec3 y = scale * patch_sum(i, d, solid_angle ? 0.0 : scale, !solid_angle && depth == 0) - carry;
    precise vec3 t = sum + y;
    carry = (t - sum) - y;
    sum = t;
    // Out of every level whose fourth quarter this was.
    int up = min(findLSB(~path) / 2, depth);
    path = path >> uint(2 * up), depth -= up;
    if (depth == 0) i = n.links.x, path = 0u;
    else ++path;
  }
  sums[query] = vec4(sum, 0), carries[query] = vec4(carry, 0);
  walks[query] = Walk(i, path, uint(depth), 0u);
  if (i < uint(node_count)) atomicAdd(unfinished, 1);
}
