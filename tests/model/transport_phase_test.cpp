#include "model/phase.h"
#include "model/quadrature.h"

#include <gtest/gtest.h>

#include <vector>

namespace opaline {
namespace {

/// 2 pi int_-1^c p dmu, with panels that shrink towards both ends.
template <typename Density>
double share_below(double c, const Density& density) {
  const int panels = 400;
  double sum = 0;
  for (int i = 0; i < panels; ++i) {
    const auto edge = [&](int k) { return -1 + (c + 1) * 0.5 * (1 - std::cos(pi * k / panels)); };
    sum += gauss_legendre(edge(i), edge(i + 1), density);
  }
  return 2 * pi * sum;
}

TEST(PhaseSampling, HenyeyGreensteinIsTheInverseOfItsCumulative) {
  for (const double g : {-.95, -.3, 0.0, 1e-9, .5, .9, .98})
    for (const double xi : {1e-6, .01, .3, .5, .77, .999, 1 - 1e-9}) {
      const double c = sample_henyey_greenstein(xi, g);
      EXPECT_NEAR(share_below(c, [&](double mu) { return henyey_greenstein(mu, g); }), xi, 1e-11) << g << " " << xi;
    }
}

TEST(PhaseSampling, SchlickIsTheInverseOfItsCumulative) {
  for (const double k : {-.9, 0.0, .3, .95})
    for (const double xi : {1e-6, .01, .3, .5, .77, .999}) {
      const double c = sample_schlick_phase(xi, k);
      EXPECT_NEAR(share_below(c, [&](double mu) { return schlick_phase(mu, k); }), xi, 1e-11) << k << " " << xi;
    }
}

TEST(PhaseSampling, ReachesBothEnds) {
  for (const double g : {-.9, -.2, 0.0, .2, .9}) {
    EXPECT_NEAR(sample_henyey_greenstein(0.0, g), -1, 1e-14);
    EXPECT_NEAR(sample_henyey_greenstein(1.0, g), 1, 1e-14);
    EXPECT_NEAR(sample_schlick_phase(0.0, g), -1, 1e-14);
    EXPECT_NEAR(sample_schlick_phase(1.0, g), 1, 1e-14);
  }
}

TEST(PhaseSampling, FloatsKeepTheirDigitsInTheForwardPeak) {
  // 1 - cosine is what turns the light; the usual form loses it.
  for (const float g : {.9f, .99f})
    for (const float xi : {.5f, .9f, .99f}) {
      const double turn = 1 - sample_henyey_greenstein(double{xi}, double{g});
      EXPECT_NEAR(1 - sample_henyey_greenstein(xi, g), turn, 1e-5 * turn + 1.2e-7) << g << " " << xi;
    }
}

}  // namespace
}  // namespace opaline
