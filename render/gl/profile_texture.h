// Diffusion profiles as a row of floats for shaders: read with render/gl/profile.glsl, never retyped there.
#pragma once

#include "render/gl/program.h"
#include "render/gl/resources.h"
#include "render/irradiance/profile_gather.h"

namespace opaline::gl {

/// R of the distinct profiles of a material in R, G and B of one texture, and in A the inverse of the length over which
/// any of them changes [1/mm], at equal steps of the bits of the float r^2 + core^2 / 4, interpolated linearly.
/// Error of the interpolation: below 1e-4 of R where R falls no faster than r^-10; beyond r_max R(r_max).
class ProfileTexture {
 public:
  ProfileTexture(const Context& context, const ChannelProfiles& profiles, double r_max);
  /// Sets the uniforms of profile.glsl and binds the texture.
  void bind(const Program& program, int unit) const;
  /// Of the narrowest profile, squared [mm^2].
  float core_squared() const { return core_squared_; }

 private:
  glm::vec2 map_{0};  ///< offset; texture coordinate per bit
  int first_ = 0;     ///< bits of the offset
  float core_squared_ = 1;
  Texture1D texture_;
};

}  // namespace opaline::gl
