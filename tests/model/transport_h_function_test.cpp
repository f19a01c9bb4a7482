#include "model/transport/h_function.h"

#include "model/quadrature.h"
#include "tests/model/transport_reference.h"

#include <gtest/gtest.h>

namespace opaline {
namespace {

using test::read_reference;

/// ln H(mu) = -(mu/pi) int_0^{pi/2} ln(1 - albedo t cot t)/(cos^2 t + mu^2 sin^2 t) dt, no equation to solve; with
/// tan s = mu tan t the fraction goes into ds.
double h_by_integral(double albedo, double mu) {
  double sum = 0;
  const int panels = 400;
  for (int i = 0; i < panels; ++i) {
    // Panels that shrink towards 0, where the logarithm nearly diverges.
    const auto edge = [](int k) { return pi / 2 * std::pow(double(k) / panels, 4); };
    sum += gauss_legendre(edge(i), edge(i + 1), [&](double s) {
      const double tangent = std::tan(s) / mu;
      return std::log(1 - albedo * std::atan(tangent) / tangent);
    });
  }
  return std::exp(-sum / pi);
}

TEST(HFunction, MatchesThePublishedTable) {
  for (auto& row : read_reference("h_function.csv")) {
    const double albedo = row["alpha"];
    EXPECT_NEAR(chandrasekhar_h(albedo, 1), row["H1"], 1e-9) << albedo;
    EXPECT_NEAR(half_space_albedo(albedo, 1).beam_per_transmitted, row["R_1"], 1e-8) << albedo;
    EXPECT_NEAR(half_space_albedo(albedo, 1, .5).beam_per_transmitted, row["R_0.5"], 1e-8) << albedo;
    EXPECT_NEAR(half_space_albedo(albedo, 1, .25).beam_per_transmitted, row["R_0.25"], 1e-8) << albedo;
    EXPECT_NEAR(half_space_albedo(albedo, 1, .1).beam_per_transmitted, row["R_0.1"], 1e-8) << albedo;
    EXPECT_NEAR(half_space_albedo(albedo, 1).white_per_incident, row["R_white"], 1e-8) << albedo;
  }
}

TEST(HFunction, SolvesTheEquationThatHasAClosedIntegral) {
  for (const double albedo : {0.0, .3, .9, .999, .999999, 1.0})
    for (const double mu : {1e-4, .03, .4, 1.0})
      EXPECT_NEAR(chandrasekhar_h(albedo, mu), h_by_integral(albedo, mu), 2e-10 * h_by_integral(albedo, mu))
          << albedo << " " << mu;
}

TEST(HFunction, StartsAtOneAndGrows) {
  for (const double albedo : {.2, .99, 1.0}) {
    EXPECT_DOUBLE_EQ(chandrasekhar_h(albedo, 0), 1);
    double before = 1;
    for (double mu = .05; mu <= 1; mu += .05) {
      EXPECT_GT(chandrasekhar_h(albedo, mu), before);
      before = chandrasekhar_h(albedo, mu);
    }
  }
}

TEST(HFunction, WithoutABoundaryReflectsOneMinusItsShareOfH) {
  for (const double albedo : {.1, .8, .99})
    for (const double mu : {.02, .3, 1.0})
      EXPECT_NEAR(half_space_albedo(albedo, 1, mu).beam_per_transmitted,
                  1 - std::sqrt(1 - albedo) * h_by_integral(albedo, mu), 1e-9);
}

TEST(HalfSpaceAlbedo, MatchesTheTableForFourBoundaries) {
  const auto rows = read_reference("half_space_totals.csv");
  ASSERT_EQ(rows.size(), 60u);
  for (auto row : rows) {
    const HalfSpaceAlbedo r = half_space_albedo(row["alpha"], row["eta"]);
    const auto near = [&](double reached, const char* column) {
      EXPECT_NEAR(reached, row[column], 0.51e-6) << column << " " << row["eta"] << " " << row["alpha"];
    };
    near(r.specular, "F0");
    near(r.specular_white, "Fdr_ext");
    near(r.beam_per_transmitted, "Rd_normal_per_transmitted");
    near(r.beam_per_incident, "Rd_normal_per_incident");
    near(r.beam_with_specular, "Rtot_normal_with_specular");
    near(r.white_per_incident, "Rd_white_per_incident");
    near(r.white_with_specular, "Rtot_white");
  }
}

TEST(HalfSpaceAlbedo, WhiteMediaReturnEverything) {
  for (const double eta : {.5, .8, 1.0, 1.0005, 1.05, 1.5, 2.5, 4.0}) {
    const HalfSpaceAlbedo r = half_space_albedo(1, eta, .9);
    EXPECT_NEAR(r.beam_with_specular, 1, 2e-9) << eta;
    EXPECT_NEAR(r.white_with_specular, 1, 2e-9) << eta;
  }
}

TEST(HalfSpaceAlbedo, DiffuseLightIsTheMeanOverBeams) {
  for (const double eta : {1.0, 1.4}) {
    const auto beam = [&](double c) { return 2 * c * half_space_albedo(.95, eta, c).beam_per_incident; };
    // Squared spacing: near grazing incidence the transmittance rises like the cosine.
    const double mean = gauss_legendre(0.0, 1.0, [&](double t) { return 2 * t * beam(t * t); });
    EXPECT_NEAR(half_space_albedo(.95, eta).white_per_incident, mean, 2e-7) << eta;
  }
}

TEST(HalfSpaceAlbedo, ABlackMediumReflectsNothing) {
  const HalfSpaceAlbedo r = half_space_albedo(0, 1.4);
  EXPECT_EQ(r.beam_per_incident, 0);
  EXPECT_EQ(r.white_per_incident, 0);
}

TEST(HalfSpaceAlbedo, RefusesWhatIsOutOfRange) {
  EXPECT_THROW(half_space_albedo(1.1, 1), std::invalid_argument);
  EXPECT_THROW(half_space_albedo(.5, .1), std::invalid_argument);
  EXPECT_THROW(half_space_albedo(.5, 1, 0), std::invalid_argument);
  EXPECT_THROW(half_space_albedo(.5, .5, .3), std::invalid_argument) << "reflected totally";
  EXPECT_THROW(chandrasekhar_h(.5, -1), std::invalid_argument);
}

}  // namespace
}  // namespace opaline
