#include "model/profiles/extended_source.h"

#include "model/profiles/profile.h"

#include <gtest/gtest.h>
#include <boost/math/quadrature/gauss_kronrod.hpp>

#include <limits>

namespace opaline {
namespace {

using Rule = boost::math::quadrature::gauss_kronrod<double, 31>;

double total_of(const char* name, double alpha, double eta) {
  return find_profile(name)->make({1 - alpha, alpha, eta})->total();
}

struct Row {
  double eta, alpha_prime, extended, beam;
};
const Row rows[] = {{1, .5, .06250, .05124},    {1, .8, .23620, .20323},    {1, .9, .38075, .33614},
                    {1, .95, .51449, .46268},   {1, .99, .74776, .68920},   {1, .999, .91266, .85238},
                    {1.3, .5, .03927, .03193},  {1.3, .8, .15576, .13443},  {1.3, .9, .26943, .24044},
                    {1.3, .95, .39194, .35802}, {1.3, .99, .65056, .61172}, {1.3, .999, .87046, .83027},
                    {1.5, .5, .02935, .02381},  {1.5, .8, .11680, .10075},  {1.5, .9, .20717, .18535},
                    {1.5, .95, .31373, .28813}, {1.5, .99, .57394, .54442}, {1.5, .999, .83248, .80181}};

TEST(ExtendedSource, TotalsAreThePublishedOnesAndTheClosedForm) {
  for (const Row& row : rows) {
    const double closed = extended_source_total(Medium<double>{1 - row.alpha_prime, row.alpha_prime, row.eta});
    EXPECT_NEAR(closed, row.extended, 6e-6) << row.eta << " " << row.alpha_prime;
    EXPECT_NEAR(total_of("extended_source", row.alpha_prime, row.eta) / closed, 1, 1e-5);
  }
}

TEST(PhotonBeamDiffusion, TotalsAreThePublishedOnes) {
  for (const Row& row : rows) {
    EXPECT_NEAR(total_of("photon_beam_diffusion", row.alpha_prime, row.eta), row.beam, 2e-5)
        << row.eta << " " << row.alpha_prime;
  }
}

/// R_d by adaptive quadrature over the depth, in the printed form.
double beam_by_adaptive_quadrature(const Medium<double>& m, double r, bool kappa) {
  const double st = m.sigma_a + m.sigma_s_prime, alpha = m.sigma_s_prime / st;
  const double diffusion = (2 * m.sigma_a + m.sigma_s_prime) / (3 * st * st), s = std::sqrt(m.sigma_a / diffusion);
  const double c_phi = exitance_weight_fluence(m.eta), c_e = exitance_weight_flux(m.eta);
  const auto integrand = [&](double t) {
    const double zv = t + 4 * modified_boundary_a(m.eta) * diffusion;
    const double dr = std::hypot(r, t), dv = std::hypot(r, zv), er = std::exp(-s * dr), ev = std::exp(-s * dv);
    const double flux = t * (1 + s * dr) * er / std::pow(dr, 3) + zv * (1 + s * dv) * ev / std::pow(dv, 3);
    const double near = kappa ? -std::expm1(-2 * st * (dr + t)) : 1;
    return near * st * std::exp(-st * t) * (c_phi / diffusion * (er / dr - ev / dv) + c_e * flux) / (4 * pi);
  };
  const double infinity = std::numeric_limits<double>::infinity();
  return alpha * alpha *
         (Rule::integrate(integrand, 0.0, r, 15, 1e-12) + Rule::integrate(integrand, r, 10 * r, 15, 1e-12) +
          Rule::integrate(integrand, 10 * r, infinity, 15, 1e-12));
}

TEST(PhotonBeamDiffusion, QuadratureHoldsItsStatedError) {
  for (const Medium<double>& m : {Medium<double>{.1, .9, 1.3}, {.001, .999, 1.0}, {.5, .5, 1.5}}) {
    const PhotonBeamDiffusion<double> beam(m);
    const ExtendedSource<double> source(m);
    struct Bound {
      double r, error;
    };
    for (const Bound& b : {Bound{.02, 3e-4}, Bound{.1, 3e-6}, Bound{.5, 5e-8}, Bound{3, 5e-8}, Bound{12, 5e-8}}) {
      EXPECT_NEAR(beam.evaluate(b.r) / beam_by_adaptive_quadrature(m, b.r, true), 1, b.error) << b.r;
      EXPECT_NEAR(source.evaluate(b.r) / beam_by_adaptive_quadrature(m, b.r, false), 1, b.error) << b.r;
    }
  }
}

TEST(PhotonBeamDiffusion, CorrectionOnlyTakesAwayAndOnlyNearTheSource) {
  const Medium<double> m{.1, .9, 1.3};
  const PhotonBeamDiffusion<double> beam(m);
  const ExtendedSource<double> source(m);
  double before = 0;
  for (const double r : {0.0, .01, .1, .3, 1.0, 3.0, 8.0}) {
    const double ratio = beam.evaluate(r) / source.evaluate(r);
    EXPECT_GT(ratio, before);
    EXPECT_LT(ratio, 1);
    before = ratio;
  }
  EXPECT_GT(before, 1 - 1e-6);
}

TEST(ExtendedSource, CumulativeIsTheIntegralAndEndsAtTheClosedTotal) {
  for (const double sigma_a : {0.0, .02, .8}) {
    const Medium<double> m{sigma_a, 1, 1.3};
    const ExtendedSource<double> source(m);
    EXPECT_NEAR(source.total() / extended_source_total(m), 1, 1e-6);
    EXPECT_NEAR(source.cumulative(1e14), source.total(), 1e-12);
    double sum = 0;  // trapezoid rule in log r up to r = 1
    for (double y = -24; y < -1e-9; y += .02) sum += .02 * 2 * pi * std::exp(2 * y) * source.evaluate(std::exp(y));
    sum += .01 * 2 * pi * source.evaluate(1.0);
    EXPECT_NEAR(source.cumulative(1.0) / sum, 1, 1e-4) << sigma_a;
  }
}

}  // namespace
}  // namespace opaline
