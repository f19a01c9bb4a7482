// One point of a layered object: reads it, marches as march.glsl says, which stands before this text, and adds gloss,
// the twin of gloss.h.
layout(location = 0) out vec4 radiance;
layout(location = 1) out vec4 counts;  // steps, light paths, those from behind, the deepest layer's number

uniform sampler2D positions;      // w: 0 where there is no point, else where the view leaves
uniform sampler2D normals;        // w: height of the fitted plane
uniform sampler2D plane_normals;  // w: u
uniform sampler2D gradients_u;    // w: v
uniform sampler2D gradients_v;    // w: which lights reach its planes, bit by bit
uniform sampler2D views;          // direction to the viewer; w: which lights are seen
uniform float f0, roughness;

const float pi = 3.14159265358979;

Point fetched(ivec2 here, vec4 position) {
  vec4 n = texelFetch(normals, here, 0), plane = texelFetch(plane_normals, here, 0);
  vec4 gu = texelFetch(gradients_u, here, 0), gv = texelFetch(gradients_v, here, 0);
  return Point(position.xyz, n.xyz, texelFetch(views, here, 0).xyz, plane.xyz, gu.xyz, gv.xyz, n.w,
               vec2(plane.w, gu.w), position.w, exit_cosine(), int(gv.w));
}

vec3 towards(int l, vec3 p) { return light_far[l] > 0.0 ? light_place[l] : normalize(light_place[l] - p); }
vec3 irradiance(int l, vec3 p) {
  vec3 d = light_place[l] - p;
  return light_far[l] > 0.0 ? light_power[l] : light_power[l] / max(dot(d, d), 1e-30);
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
  radiance = counts = vec4(0);
  if (position.w == 0.0) return;
  Point p = fetched(here, position);
  March m = march(p);
  radiance = vec4(m.sum, 0);
  counts = vec4(m.steps, m.light_paths, m.from_behind, m.deepest);
  if (reflection)
    for (int l = 0; l < lights; ++l)
      if (sees(int(texelFetch(views, here, 0).w), l)) radiance.rgb += gloss(p, l);
}
