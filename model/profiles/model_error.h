// How far each registered profile is from transport (transport_table.h).
#pragma once

#include "model/profiles/profile.h"

namespace opaline {

struct ModelError {
  double total;  ///< total reflectance: model/truth - 1
  double shape;  ///< mean of |ln(model/truth)| over r, evenly in log r from 0.1 to 10 transport mean free paths
  double bias;   ///< the same without the bars: above 0 where the model is too bright
};

/// Infinite where the model is 0. eta from 1 to 2, alpha_prime in (0, 1].
ModelError model_error(const ProfileInfo& model, double alpha_prime, double eta);

}  // namespace opaline
