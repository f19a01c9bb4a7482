#include "model/single_scattering/layered.h"

#include "model/transport/walk.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace opaline {
namespace {

using Layers = std::vector<ScatteringLayer<double>>;
using Medium1 = ScatteringMedium<double>;
constexpr double infinity = std::numeric_limits<double>::infinity();

const Medium1 hg{.2, .8, .4, 1.4}, schlick{.2, .8, .4, 1.4, Phase::schlick};

TEST(LayeredSingleScattering, OneInfiniteLayerIsTheHalfSpace) {
  for (const Medium1& m : {hg, schlick, Medium1{.1, .9, 0, 1}, Medium1{.3, .5, -.6, .8, Phase::schlick}}) {
    const double total = single_scattering_total(m);
    EXPECT_NEAR(layered_single_scattering_total(Layers{{m, infinity}}, 1.0) / total, 1, 1e-9);
    for (const double r : {.01, .3, 2.0}) {
      const double expected = single_scattering_profile(m, r);
      EXPECT_NEAR(layered_single_scattering_profile(Layers{{m, infinity}}, r) / expected, 1, 1e-12) << r;
    }
  }
  const double cos_i = .8, cos_o = .7, cos_azimuth = -.3, sines = .6 * std::sqrt(.51) / (1.4 * 1.4);
  const double mu_i = std::sqrt(1 - .36 / 1.96), mu_o = std::sqrt(1 - .51 / 1.96),
               phase = sines * cos_azimuth - mu_i * mu_o;
  for (const double tau : {.3, infinity}) {
    EXPECT_NEAR(layered_single_scattering_brdf(Layers{{schlick, tau}}, cos_i, cos_o, cos_azimuth),
                hanrahan_krueger_brdf(schlick, cos_i, cos_o, phase, tau), 1e-14);
  }
}

TEST(LayeredSingleScattering, TotalsAreThePublishedOnes) {
  const Medium1 white{0, 1, 0, 1};
  EXPECT_NEAR(layered_single_scattering_total(Layers{{white, infinity}}, 1.0), .5 * (1 - std::log(2.0)), 1e-9);
  // Diffuse light: the mean over 2 cos d cos, by the midpoint rule in the squared cosine.
  double diffuse = 0;
  const int count = 1000;
  for (int i = 0; i < count; ++i) {
    const double cosine = std::sqrt((i + .5) / count);
    diffuse += layered_single_scattering_total(Layers{{white, infinity}}, cosine) / count;
  }
  EXPECT_NEAR(diffuse, 2.0 / 3 * (1 - std::log(2.0)), 5e-6);
  // A slab, isotropic, index matched: (alpha/2) (1 - int exp(-tau (1 + 1/mu)) ... ) by its own integral over mu.
  const double tau = .7;
  double expected = 0;
  for (int i = 0; i < 20000; ++i) {
    const double mu = (i + .5) / 20000;
    expected += .5 * mu / (1 + mu) * -std::expm1(-tau * (1 + 1 / mu)) / 20000;
  }
  EXPECT_NEAR(layered_single_scattering_total(Layers{{white, tau}}, 1.0), expected, 1e-8);
}

/// z of the closed total against walks, per transmitted flux.
double z_of(const SearchlightResult& walks, double total) {
  return (walks.once_reflected.value - total) / walks.once_reflected.standard_error;
}

TEST(LayeredSingleScattering, TotalsAreTheSimulatedOnes) {
  const auto walked = [](double g, double eta, double thickness, double cos_incident) {
    WhiteWalk walk;
    walk.g = g;
    walk.eta = eta;
    walk.optical_thickness = thickness;
    walk.cos_incident = cos_incident;
    walk.walks = 1 << 19;
    walk.roulette_albedo = .5;
    walk.free_scatterings = 1;
    return searchlight_at(white_walk(walk), .4);
  };
  const auto total = [](double g, double eta, double thickness, double cos_incident) {
    return layered_single_scattering_total(Layers{{{.6, .4, g, eta}, thickness}}, cos_incident);
  };
  // Behind a boundary only a half space: a slab's lower face would send light back after its scattering.
  EXPECT_LT(std::abs(z_of(walked(.5, 1.3, infinity, .4), total(.5, 1.3, infinity, .4))), 4);
  EXPECT_LT(std::abs(z_of(walked(-.3, 1, .8, .3), total(-.3, 1, .8, .3))), 4);
  EXPECT_LT(std::abs(z_of(walked(.6, 1, .5, 1), total(.6, 1, .5, 1))), 4);
}

TEST(LayeredSingleScattering, ALayerCutInTwoIsTheLayer) {
  const Layers whole = {{hg, 2}, {schlick, infinity}}, cut = {{hg, .5}, {hg, 1.5}, {schlick, infinity}};
  for (const double cos_i : {.2, .9}) {
    for (const double cos_o : {.3, 1.0}) {
      const double one = layered_single_scattering_brdf(whole, cos_i, cos_o, .4);
      EXPECT_NEAR(layered_single_scattering_brdf(cut, cos_i, cos_o, .4) / one, 1, 1e-14);
    }
    EXPECT_NEAR(layered_single_scattering_total(cut, cos_i) / layered_single_scattering_total(whole, cos_i), 1, 1e-13);
  }
  for (const double r : {.05, .6, 3.0}) {
    const double one = layered_single_scattering_profile(whole, r);
    EXPECT_NEAR(layered_single_scattering_profile(cut, r) / one, 1, 1e-10) << r;
  }
}

TEST(LayeredSingleScattering, IsReciprocal) {
  const Layers layers = {{{.1, .7, .3, 1.2}, .4}, {{.5, .5, -.2, 1.5, Phase::schlick}, .3}, {{0, 1, 0, 1.1}, infinity}};
  EXPECT_NEAR(layered_single_scattering_brdf(layers, .3, .8, -.7) / layered_single_scattering_brdf(layers, .8, .3, -.7),
              1, 1e-14);
}

TEST(LayeredSingleScattering, AClearLayerOnlyAttenuatesAndRefracts) {
  const Medium1 clear{.7, 0, 0, 1.4};
  const double covered = layered_single_scattering_brdf(Layers{{clear, .5}, {hg, infinity}}, .8, .6, .1);
  const double bare = layered_single_scattering_brdf(Layers{{hg, infinity}}, .8, .6, .1);
  const double mu_i = std::sqrt(1 - .36 / 1.96), mu_o = std::sqrt(1 - .64 / 1.96);
  EXPECT_NEAR(covered / bare, std::exp(-.35 * (1 / mu_i + 1 / mu_o)), 1e-14);
}

TEST(LayeredSingleScattering, ProfileIntegratesToTheTotal) {
  const Layers layers = {{{.3, 1, .2, 1.3}, .6}, {{.1, 2, .5, 1.3, Phase::schlick}, 1.1}, {{1, .5, 0, 1.3}, infinity}};
  double sum = 0;
  for (double y = -16; y < 5; y += .05) {
    const double r = std::exp(y);
    sum += .05 * 2 * pi * r * r * layered_single_scattering_profile(layers, r);
  }
  EXPECT_NEAR(sum / layered_single_scattering_total(layers, 1.0), 1, 1e-5);
}

TEST(LayeredSingleScattering, DenseLightBelowTheSurfaceStaysInside) {
  // From a thin medium into a thinner layer: beyond the critical angle nothing enters.
  EXPECT_EQ(layered_single_scattering_brdf(Layers{{{.1, 1, 0, .8}, infinity}}, .3, .9, 0.0), 0);
}

}  // namespace
}  // namespace opaline
