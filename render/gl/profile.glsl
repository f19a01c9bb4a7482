// R_d of up to three profiles at a squared distance [mm^2]: see profile_texture.h.
uniform sampler1D profile_texture;
uniform vec3 profile_map;

vec3 profile(float r2) {
  return textureLod(profile_texture, profile_map.y * log2(r2 + profile_map.x) + profile_map.z, 0.0).rgb;
}

// How steeply the profiles change there, as an inverse length [1/mm].
float profile_scale(float r2) {
  return textureLod(profile_texture, profile_map.y * log2(r2 + profile_map.x) + profile_map.z, 0.0).a;
}
