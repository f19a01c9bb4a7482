// The profile transport_radiance against its solver and Chandrasekhar's radiance. What path_traced sees of a beam is in
// tests/render/path_traced_test.cpp.
#include "model/profiles/transport_radiance.h"

#include "model/profiles/profile.h"
#include "model/transport/h_function.h"
#include "model/transport/searchlight_mixture.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace opaline {
namespace {

std::unique_ptr<Profile> radiance(double albedo, double eta) {
  return find_profile("transport_radiance")->make({1 - albedo, albedo, eta});
}

/// Media between the table's nodes, made anew; beyond the width of what stands for the delta.
TEST(TransportRadiance, IsWhatItsMakerFinds) {
  const std::array<double, 3> albedos = {.2, .93, .9998};
  constexpr double eta = 1.27;
  const auto mixtures = searchlight_mixtures(eta, albedos, 1.3, SearchlightExit::radiance_up);
  for (std::size_t i = 0; i < albedos.size(); ++i) {
    const auto profile = radiance(albedos[i], eta);
    const double last = std::min(100.0, .7 * TransportTableShape::reach(1 - albedos[i]));
    for (double r = .3; r < last; r *= 1.37) {
      const double exact = std::exp(mixtures[i].log_evaluate(r)), beyond = profile->total() - profile->cumulative(r);
      const double limit = beyond > 1e-6 * profile->total() ? 5e-4 : 2e-2;
      EXPECT_NEAR(profile->evaluate(r) / exact, 1, limit) << albedos[i] << " " << r;
    }
  }
}

/// A wide beam without a boundary: pi times the radiance along the normal is albedo H(1)^2/8.
TEST(TransportRadiance, HasChandrasekharsRadiance) {
  for (const double albedo : {.03, .45, .9, .993, 1.0}) {
    const double h = chandrasekhar_h(albedo, 1);
    EXPECT_NEAR(radiance(albedo, 1)->total() / (albedo * h * h / 8), 1, 3e-4) << albedo;
  }
}

/// Light scattered once and seen along the beam leaves where it entered.
TEST(TransportRadiance, ScattersOnceOntoTheAxis) {
  constexpr double albedo = .1, eta = 1.4;
  const double c = exit_lobe_normalisation(eta, ExitLobe::normalised), once = albedo * c / (8 * eta * eta);
  const auto profile = radiance(albedo, eta);
  const double near = profile->cumulative(15 * TransportRadiance<double>::width);
  EXPECT_GT(near, once);
  EXPECT_LT(near, 1.1 * once);
}

}  // namespace
}  // namespace opaline
