// The picture of a material in the coordinates of Q: z_c = L^T x_c and its derivatives, a few hundred numbers a
// channel.
#pragma once

#include "fit/parameters.h"
#include "fit/whitening.h"

namespace opaline {

struct ReducedChannel {
  Eigen::VectorXd value, d_sigma_a, d_sigma_s_prime, d_eta;
};

/// Per channel of the target; the derivatives are left empty unless asked for. The eta nodes are contracted once for
/// all channels.
std::array<ReducedChannel, 3> reduced_picture(const FitTarget& target, const ProfileInfo& profile,
                                              const Material& material, bool derivatives);

/// Q z: rows x channels, at unit scale.
Eigen::MatrixXd target_rows(const FitTarget& target, const ProfileInfo& profile, const Material& material);

/// The same as an image of the film: R, G, B, A with A = 1 where a row is; a grey target shows R three times.
Image target_image(const FitTarget& target, const ProfileInfo& profile, const Material& material, double scale = 1);

}  // namespace opaline
