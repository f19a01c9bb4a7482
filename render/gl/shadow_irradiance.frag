// Light of one light that enters at each point: V cos F_t(eta, cos) L, added to what other lights brought. The twin of
// render/irradiance/entering_light.h and light_sampler.cpp.
layout(location = 0) out vec4 entering;

uniform sampler2D points;        // place in the world; w < 0: no point here
uniform sampler2D normals;       // shading normal
uniform sampler2D face_normals;
uniform sampler2D image;         // of a projector
uniform sampler1D transmittance; // F_t over the cosine
uniform sampler2DShadow shadow;

uniform int kind;    // 0 directional, 1 point, 2 projector's disk, 3 projector's image
uniform int shadows; // 0: nothing is in shadow
uniform float object;  // the object of this pass: points.w
uniform vec3 colour, position, direction, right, up;
uniform vec2 tangents;  // of a disk's half-angle; of half the image's width and height
uniform mat4 to_clip;
uniform float map_scale;

vec3 texel(ivec2 at) { return texelFetch(image, clamp(at, ivec2(0), textureSize(image, 0) - 1), 0).rgb; }

vec3 projected(vec3 d) {
  float z = dot(d, direction);
  if (z <= 0.0) return vec3(0);
  if (kind == 2) return length(d - z * direction) <= z * tangents.x ? vec3(1) : vec3(0);
  vec2 s = vec2(dot(d, right), dot(d, up)) / (z * tangents);
  if (any(greaterThan(abs(s), vec2(1)))) return vec3(0);
  vec2 at = vec2(s.x + 1.0, 1.0 - s.y) / 2.0 * vec2(textureSize(image, 0)) - 0.5;
  ivec2 low = ivec2(floor(at));
  vec2 f = at - vec2(low);
  return mix(mix(texel(low), texel(low + ivec2(1, 0)), f.x),
             mix(texel(low + ivec2(0, 1)), texel(low + ivec2(1, 1)), f.x), f.y);
}

bool lit(vec3 p, vec3 face_normal) {
  if (shadows == 0) return true;
  float texel_mm = (to_clip * vec4(p, 1)).w / map_scale;
  vec4 clip = to_clip * vec4(p + 2.0 * texel_mm * face_normal, 1);
  return textureLod(shadow, clip.xyz / clip.w * 0.5 + 0.5, 0.0) > 0.5;
}

void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  vec4 p = texelFetch(points, here, 0);
  entering = vec4(0);
  if (p.w != object) return;
  vec3 l = kind == 0 ? -direction : position - p.xyz, light = colour;
  if (kind != 0) light /= dot(l, l);
  if (kind >= 2) light *= projected(-l);
  l = normalize(l);
  float cosine = dot(texelFetch(normals, here, 0).xyz, l);
  vec3 face_normal = texelFetch(face_normals, here, 0).xyz;
  if (cosine <= 0.0 || dot(face_normal, l) <= 0.0 || !lit(p.xyz, face_normal)) return;
  cosine = min(cosine, 1.0);
  float n = float(textureSize(transmittance, 0));
  entering = vec4(cosine * textureLod(transmittance, (cosine * (n - 1.0) + 0.5) / n, 0.0).r * light, 0);
}
