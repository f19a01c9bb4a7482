// One pixel: its sample set on a plane through its point, projected into the irradiance image and summed. The twin of
// render/image_space/sample_gather.cpp; places are camera coordinates, see render/image_space/projection.h.
// Given before this text, as constants, because software renderers run both sides of every branch:
//   bool perspective, coloured, jacobian, count_valid, textured
layout(location = 0) out vec4 sums;   // per distinct profile, or per channel of a coloured irradiance
layout(location = 1) out vec4 valid;  // shares of the samples that met the object

uniform sampler2D texels;         // depth, its slopes, E G of the first channel; < 0: off the object
uniform sampler2D more_light;     // E G of the other two channels
uniform sampler2D points;         // place; which sets: 2 representative + (1 if combined), < 0: not a point of the object
uniform sampler2D normals;
uniform sampler2D sample_places;  // u, v, weight; a row per set
uniform sampler2D sample_shares;
uniform sampler2D scales;         // textured: s of each channel
uniform sampler2D family_places;  // textured: where the texture of all profiles holds each channel's

uniform vec3 film;  // scale, cx, cy
uniform ivec2 size, corner;
uniform int samples, pattern;
uniform float min_plane_cosine;
uniform vec3 tables;  // which profile serves each channel of a coloured irradiance

vec3 turned_to(vec3 viewer, vec3 normal) {
  float cosine = dot(viewer, normal);
  if (abs(cosine) >= min_plane_cosine) return normal;
  vec3 side = normal - cosine * viewer;
  return (cosine < 0.0 ? -min_plane_cosine : min_plane_cosine) * viewer +
         sqrt(1.0 - min_plane_cosine * min_plane_cosine) / length(side) * side;
}

void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  vec4 point = texelFetch(points, here, 0);
  sums = vec4(0), valid = vec4(0);
  if (point.w < 0.0) return;
  vec3 x = point.xyz;
  vec3 normal = turned_to(perspective ? -normalize(x) : vec3(0, 0, -1), texelFetch(normals, here, 0).xyz);
  vec3 tangent = normalize(cross(normal, abs(normal.x) < 0.5 ? vec3(1, 0, 0) : vec3(0, 1, 0)));
  vec3 bitangent = cross(normal, tangent);
  float facing = abs(perspective ? dot(normal, x) : normal.z);
  ivec2 cell = (here + corner) % pattern;
  int row = (int(point.w) * pattern + cell.y) * pattern + cell.x;
  ivec3 table = ivec3(tables);
  vec3 scale = vec3(0), family = vec3(0);
  if (textured) scale = texelFetch(scales, here, 0).xyz, family = texelFetch(family_places, here, 0).xyz;

  for (int i = 0; i < samples; ++i) {
    vec3 place = texelFetch(sample_places, ivec2(i, row), 0).xyz;
    vec3 t = x + place.x * tangent + place.y * bitangent;
    if (perspective && t.z <= 1e-6) continue;
    vec2 slope = perspective ? t.xy * (1.0 / t.z) : t.xy;
    vec2 at = vec2(film.y + film.x * slope.x, film.z - film.x * slope.y);
    if (any(lessThan(at, vec2(0))) || any(greaterThanEqual(at, vec2(size)))) continue;
    ivec2 pixel = ivec2(at);
    vec4 texel = texelFetch(texels, pixel, 0);
    if (texel.w < 0.0) continue;
    if (count_valid) valid += texelFetch(sample_shares, ivec2(i, row), 0);
    vec3 light = vec3(texel.w);
    if (coloured) light.yz = texelFetch(more_light, pixel, 0).xy;
    if (max(light.x, max(light.y, light.z)) <= 0.0) continue;
    float depth = texel.x + dot(texel.yz, at - vec2(pixel) - 0.5);
    vec3 p = perspective ? vec3(slope, 1.0) * (1.0 / depth) : vec3(slope, depth);
    float per_d = inversesqrt(dot(t, t));
    float per_g = !jacobian ? 1.0 : facing * (perspective ? per_d * per_d * per_d : 1.0);
    float r2 = dot(p - x, p - x);
    vec3 r = textured ? vec3(family_profile(r2, scale.x, family.x), family_profile(r2, scale.y, family.y),
                             family_profile(r2, scale.z, family.z))
                      : profile(r2);
    if (coloured && !textured) r = vec3(r[table.x], r[table.y], r[table.z]);
    sums.rgb += place.z * per_g * light * r;
  }
}
