// One point of a layered object: the twin of render/subsurface/march.cpp and gloss.h, which say what is done and why.
// Given before this text: constants
//   int layers, lights, samples; bool by_pieces, reflection
// and void boundaries(vec2 uv, out float depth[layers]), which reads the depth textures.
layout(location = 0) out vec4 radiance;  // and the number of steps

uniform sampler2D positions;      // w: 0 where there is no point
uniform sampler2D normals;        // w: height of the fitted plane
uniform sampler2D plane_normals;  // w: u
uniform sampler2D gradients_u;    // w: v
uniform sampler2D gradients_v;    // w: which lights are seen, bit by bit
uniform sampler2D views;          // direction to the viewer

uniform vec3 light_place[lights];
uniform vec3 light_power[lights];
uniform float light_far[lights];
uniform vec3 sigma_s[layers + 1];
uniform vec3 sigma_t[layers + 1];
uniform vec2 phase_of[layers + 1];  // g; 1: Schlick
uniform float largest_depth, negligible, least_view_cosine, f0, roughness;

const float pi = 3.14159265358979;

struct Point {
  vec3 position, normal, w_o, plane_normal, gradient_u, gradient_v;
  float plane_height;
  vec2 uv;
  int sees;
};
struct Arrival {
  bool lit;
  vec3 w_i, tau, power;
};

Point fetched(ivec2 here, vec3 position) {
  vec4 n = texelFetch(normals, here, 0), plane = texelFetch(plane_normals, here, 0);
  vec4 gu = texelFetch(gradients_u, here, 0), gv = texelFetch(gradients_v, here, 0);
  return Point(position, n.xyz, texelFetch(views, here, 0).xyz, plane.xyz, gu.xyz, gv.xyz, n.w, vec2(plane.w, gu.w),
               int(gv.w));
}

vec2 uv_at(Point p, vec3 offset) { return p.uv + vec2(dot(p.gradient_u, offset), dot(p.gradient_v, offset)); }

vec3 towards(int l, vec3 p) { return light_far[l] > 0.0 ? light_place[l] : normalize(light_place[l] - p); }
vec3 irradiance(int l, vec3 p) {
  vec3 d = light_place[l] - p;
  return light_far[l] > 0.0 ? light_power[l] : light_power[l] / max(dot(d, d), 1e-30);
}

float phase(int layer, vec3 w_i, vec3 w_o) {
  float g = phase_of[layer].x, c = clamp(-dot(w_i, w_o), -1.0, 1.0);
  float d = (1.0 - g) + g * (1.0 - c), e = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - c);
  return (1.0 - g) * (1.0 + g) / (4.0 * pi * (phase_of[layer].y > 0.0 ? d * d : e * sqrt(e)));
}

// Mean of e^-x over a way on which it goes from e0 to e1, x growing by delta.
float mean_between(float e0, float e1, float delta) {
  if (abs(delta) > 0.02) return (e0 - e1) / delta;
  return e0 * (1.0 - delta * (0.5 - delta * (1.0 / 6.0 - delta / 24.0)));
}

int layer_at(float below[layers]) {
  int layer = 0;
  for (int k = 0; k < layers; ++k)
    if (layer == k && below[k] >= 0.0) layer = k + 1;
  return layer;
}

Arrival arrival(Point p, int l, vec3 m, float depth[layers], vec3 plane_point, vec3 plane_normal) {
  Arrival a = Arrival(false, towards(l, m), vec3(0), vec3(0));
  float cosine = dot(plane_normal, a.w_i);
  if (cosine <= 1e-4 || (p.sees >> l & 1) == 0) return a;
  a.lit = true;
  a.power = irradiance(l, m);
  float way = max(dot(plane_point - m, plane_normal), 0.0) / cosine;
  float at_k[layers];
  boundaries(uv_at(p, m + way * a.w_i - p.position), at_k);
  float left = way, above = 0.0;
  for (int j = 0; j < layers; ++j) {
    float end = 0.5 * (depth[j] + at_k[j]);
    float part = min(left, (end - above) / cosine);
    a.tau += part * sigma_t[j];
    left -= part, above = end;
  }
  a.tau += left * sigma_t[layers];
  return a;
}

vec3 gloss(Point p, int l) {
  vec3 w_i = towards(l, p.position), sum = w_i + p.w_o;
  float cos_i = dot(p.normal, w_i), cos_o = dot(p.normal, p.w_o);
  if (cos_i <= 0.0 || cos_o <= 0.0 || dot(sum, sum) <= 0.0) return vec3(0);
  vec3 h = normalize(sum);
  float a2 = roughness * roughness * roughness * roughness, cos_h = dot(p.normal, h);
  float d = cos_h * cos_h * (a2 - 1.0) + 1.0, density = a2 / (pi * d * d);
  float visible = 0.5 / (cos_o * sqrt(a2 + (1.0 - a2) * cos_i * cos_i) + cos_i * sqrt(a2 + (1.0 - a2) * cos_o * cos_o));
  float turned = 1.0 - max(dot(w_i, h), 0.0), turned2 = turned * turned;
  return irradiance(l, p.position) * (cos_i * (f0 + (1.0 - f0) * turned2 * turned2 * turned) * density * visible);
}

void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  vec4 position = texelFetch(positions, here, 0);
  radiance = vec4(0);
  if (position.w == 0.0) return;
  Point p = fetched(here, position.xyz);

  vec3 deep_normal = p.plane_normal;
  float view_cosine = dot(deep_normal, p.w_o);
  if (view_cosine < least_view_cosine) {
    deep_normal = p.normal;
    view_cosine = max(dot(deep_normal, p.w_o), least_view_cosine);
  }
  float len = largest_depth / view_cosine, step_length = len / float(samples);

  float depth[layers], below[layers], below_next[layers];
  Arrival from[lights], to[lights];
  vec3 sum = vec3(0), tau = vec3(0);
  int steps = 0;
  for (int i = 0; i <= samples; ++i) {
    float t = float(i) / float(samples);
    vec3 n = (1.0 - t) * p.normal + t * deep_normal;
    float size = length(n);
    n = size > 1e-6 ? n / size : p.normal;
    vec3 plane_point = p.position + t * p.plane_height * p.normal;
    vec3 m = p.position - t * len * p.w_o;
    boundaries(uv_at(p, m - p.position), depth);
    float down = max(dot(plane_point - m, n), 0.0);
    for (int k = 0; k < layers; ++k) below_next[k] = down - depth[k];
    for (int l = 0; l < lights; ++l) to[l] = arrival(p, l, m, depth, plane_point, n);
    if (i > 0) {
      int layer = layer_at(below);
      if (by_pieces) {
        int last = layer_at(below_next), direction = last > layer ? 1 : -1;
        float t0 = 0.0;
        for (int piece = 0; piece <= layers && t0 < 1.0; ++piece) {
          float t1 = 1.0;
          if (layer != last) {
            int k = direction > 0 ? layer : layer - 1;
            t1 = clamp(below[k] / (below[k] - below_next[k]), t0, 1.0);
          }
          float part = (t1 - t0) * step_length;
          vec3 fade = part * sigma_t[layer];
          if (part > 0.0)
            for (int l = 0; l < lights; ++l) {
              if (!from[l].lit && !to[l].lit) continue;
              Arrival x = to[l], y = from[l];
              if (from[l].lit) x = from[l];
              if (to[l].lit) y = to[l];
              vec3 change = y.tau - x.tau, delta = fade + (t1 - t0) * change;
              vec3 e0 = exp(-(tau + x.tau + t0 * change)), e1 = exp(-(tau + fade + x.tau + t1 * change));
              vec3 mean = vec3(mean_between(e0.x, e1.x, delta.x), mean_between(e0.y, e1.y, delta.y),
                               mean_between(e0.z, e1.z, delta.z));
              float weight = (from[l].lit && to[l].lit ? 0.5 : 0.25) * part;
              sum += weight * (phase(layer, x.w_i, p.w_o) * x.power + phase(layer, y.w_i, p.w_o) * y.power) *
                     sigma_s[layer] * mean;
            }
          tau += fade;
          t0 = t1;
          if (layer != last) layer += direction;
        }
      } else {
        for (int l = 0; l < lights; ++l)
          if (from[l].lit)
            sum += sigma_s[layer] * from[l].power * (phase(layer, from[l].w_i, p.w_o) * step_length) *
                   exp(-tau - from[l].tau);
        tau += step_length * sigma_t[layer];
      }
      steps = i;
      if (exp(-min(tau.x, min(tau.y, tau.z))) < negligible) break;
    }
    below = below_next;
    from = to;
  }
  if (max(sum.x, max(sum.y, sum.z)) >= 1e30) sum = vec3(0);
  if (reflection)
    for (int l = 0; l < lights; ++l)
      if ((p.sees >> l & 1) != 0) sum += gloss(p, l);
  radiance = vec4(sum, float(steps));
}
