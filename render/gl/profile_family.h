// One profile for all media of a refraction index, for shaders: render/gl/profile_family.glsl reads it.
//
// A profile of a medium alone has no length but those of the medium, so R(r; sigma_a, sigma_s') = s^2 f(s r; u) with
// s = sigma_a + sigma_s' and u = sqrt(sigma_a / s). The texture holds f, at equal steps of the bits of (s r)^2 + core^2
// / 4 and of ln u over the range of an object's material, interpolated linearly both ways.
#pragma once

#include "render/gl/program.h"
#include "render/gl/resources.h"
#include "render/irradiance/profile_gather.h"

namespace opaline::gl {

class ProfileFamily {
 public:
  /// For every material that `material`'s maps can hold, and distances up to r_max [mm].
  ProfileFamily(const Context& context, const ProfileInfo& info, const Material& material, double r_max);
  /// Sets the uniforms of profile_family.glsl and binds the texture.
  void bind(const Program& program, int unit) const;
  /// s [1/mm] and the texture coordinate of u, of one channel of a homogeneous material.
  glm::vec2 place(const Medium<double>& medium) const;

 private:
  double log_u_min_ = 0, log_u_max_ = 0;
  glm::vec2 map_{0};  ///< offset; texture coordinate per bit
  int first_ = 0;     ///< bits of the offset
  std::unique_ptr<Texture2D> texture_;
};

}  // namespace opaline::gl
