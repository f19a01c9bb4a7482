#include "model/profiles/model_error.h"

#include "model/check.h"

#include <cmath>

namespace opaline {

ModelError model_error(const ProfileInfo& model, double alpha_prime, double eta) {
  const ProfileInfo* truth_info = find_profile("transport_table");
  OPALINE_CHECK(truth_info != nullptr);
  const Medium<double> medium{1 - alpha_prime, alpha_prime, eta};  // lengths in transport mean free paths
  const auto profile = model.make(medium), truth = truth_info->make(medium);
  constexpr int radii = 100;
  ModelError error{profile->total() / truth->total() - 1, 0, 0};
  for (int i = 0; i < radii; ++i) {
    const double r = 0.1 * std::pow(100.0, (i + 0.5) / radii);
    const double difference = std::log(profile->evaluate(r) / truth->evaluate(r));
    error.bias += difference / radii;
    error.shape += std::abs(difference) / radii;
  }
  return error;
}

}  // namespace opaline
