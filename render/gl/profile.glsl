// Up to three profiles R_d at a squared distance [mm^2], and how steeply they change as an inverse length [1/mm]: see
// profile_texture.h. The bits of a float are nearly its logarithm, and cost nothing.
uniform sampler1D profile_texture;
uniform vec2 profile_map;  // offset; per bit
uniform int profile_first;

vec4 profile_texel(float r2) {
  float at = float(floatBitsToInt(r2 + profile_map.x) - profile_first) * profile_map.y;
  return textureLod(profile_texture, at + 0.5 / 4096.0, 0.0);
}
vec3 profile(float r2) { return profile_texel(r2).rgb; }
float profile_scale(float r2) { return profile_texel(r2).a; }
