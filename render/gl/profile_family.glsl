// R_d at a squared distance [mm^2] of a medium with s = sigma_a + sigma_s' [1/mm] whose u is at texture coordinate v:
// see profile_family.h.
uniform sampler2D profile_family;
uniform vec2 family_map;  // offset; per bit
uniform int family_first;

float family_profile(float r2, float s, float v) {
  float at = float(floatBitsToInt(r2 * s * s + family_map.x) - family_first) * family_map.y;
  return s * s * textureLod(profile_family, vec2(at + 0.5 / 4096.0, v), 0.0).r;
}
