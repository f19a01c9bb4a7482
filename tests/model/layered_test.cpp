#include "model/profiles/layered_profile.h"
#include "model/profiles/multipole.h"
#include "model/profiles/profile.h"
#include "model/profiles/standard_dipole.h"

#include <gtest/gtest.h>
#include <boost/math/quadrature/gauss_kronrod.hpp>

#include <cmath>
#include <limits>

namespace opaline {
namespace {

using Stack = std::vector<StackLayer<double>>;
constexpr double infinity = std::numeric_limits<double>::infinity();

const std::vector<Stack> stacks = {
    {{{.02, 1, 1.3}, 3}, {{.1, 2, 1.5}, 4}, {{.01, 2, 1.2}, infinity}},
    {{{.3, 2, 1.4}, 2}, {{.02, 1, 1.4}, 5}},
    {{{0, 1, 1.3}, 3}, {{0, 2, 1.0}, 4}},
    {{{.5, .5, 1}, 2.5}, {{0, 3, 1}, infinity}},
};

double reflectance(const Stack& layers, double r) {
  const auto slabs = stack_of(layers, 1.0);
  return evaluate_kernels(reflectance_kernels(slabs, decays(slabs)), r);
}

double transmittance(const Stack& layers, double r) {
  const auto slabs = stack_of(layers, 1.0);
  return evaluate_kernels(transmittance_kernels(slabs, decays(slabs).back()), r);
}

TEST(Layered, OneSlabIsTheMultipole) {
  for (const double sigma_a : {0.0, .2}) {
    for (const double d : {.3, 2.0, 12.0}) {
      const Stack one = {{{sigma_a, 1, 1.3}, d}};
      const Multipole<double> slab({{sigma_a, 1, 1.3}, d, 1.3});
      for (const double r : {0.0, .1, 1.0, 3.0, 9.0, 40.0}) {
        const double reflected = slab.reflectance(r), transmitted = slab.transmittance(r);
        EXPECT_NEAR(reflectance(one, r), reflected, 1e-9 * reflected) << sigma_a << " " << d << " " << r;
        EXPECT_NEAR(transmittance(one, r), transmitted, 1e-9 * transmitted) << sigma_a << " " << d << " " << r;
      }
    }
  }
}

TEST(Layered, OneHalfSpaceIsTheStandardDipole) {
  for (const Medium<double>& m : {Medium<double>{.1, .9, 1.3}, {0, 1, 1.5}, {1e-5, 2, 1}}) {
    for (const double r : {0.0, .2, 2.0, 30.0, 300.0}) {
      const double expected = StandardDipole<double>(m).evaluate(r);
      EXPECT_NEAR(reflectance({{m, infinity}}, r), expected, 1e-9 * expected) << m.sigma_a << " " << r;
    }
  }
}

/// 1/(2 pi) int R~(k) J_0(k r) k dk between the zeros of J_0.
double plain_inversion(const Stack& layers, double r, bool through) {
  const auto slabs = stack_of(layers, 1.0);
  const auto f = [&](double k) {
    const Response<double> all = stack_response(slabs, k * k);
    return (through ? all.transmitted : all.reflected) * std::cyl_bessel_j(0.0, k * r) * k / (2 * pi);
  };
  double sum = 0;
  const double step = std::min(1.0, pi / r);
  for (double k = 0; k < 110; k += step)
    sum += boost::math::quadrature::gauss_kronrod<double, 31>::integrate(f, k, k + step, 0);
  return sum;
}

TEST(Layered, EqualsThePlainHankelIntegral) {
  for (const Stack& layers : stacks) {
    for (const double r : {.3, 2.0, 7.0}) {
      const double reflected = plain_inversion(layers, r, false);
      EXPECT_NEAR(reflectance(layers, r), reflected, 1e-9 * reflected + 1e-13) << layers.size() << " " << r;
      if (std::isinf(layers.back().thickness)) continue;
      const double transmitted = plain_inversion(layers, r, true);
      EXPECT_NEAR(transmittance(layers, r), transmitted, 1e-9 * transmitted + 1e-13) << layers.size() << " " << r;
    }
  }
}

TEST(Layered, KernelsHaveTheClosedTransform) {
  for (const Stack& layers : stacks) {
    const auto slabs = stack_of(layers, 1.0);
    const auto kernels = reflectance_kernels(slabs, decays(slabs));
    for (double k = 0; k < 4; k += .17) {
      double sum = 0;
      for (const auto& kernel : kernels) sum += kernel.weight * std::exp(-kernel.t * k * k);
      EXPECT_NEAR(sum, stack_response(slabs, k * k).reflected, 2e-12) << k;
    }
  }
}

/// A square grid of values, spacing `step`, the beam in its middle.
struct Grid {
  static constexpr int half = 36, size = 2 * half + 1;
  static constexpr double step = .45;
  std::vector<double> value = std::vector<double>(size * size, 0.0);

  template <typename F>
  static Grid of(const F& f) {
    Grid grid;
    for (int y = -half; y <= half; ++y)
      for (int x = -half; x <= half; ++x) grid.at(x, y) = f(step * std::hypot(x, y));
    return grid;
  }
  double& at(int x, int y) { return value[static_cast<std::size_t>((y + half) * size + x + half)]; }
  double at(int x, int y) const { return value[static_cast<std::size_t>((y + half) * size + x + half)]; }
};

/// sum_u a(u) b(x - u) step^2: light that spreads by a, then by b. What leaves the grid is lost.
Grid convolved(const Grid& a, const Grid& b) {
  constexpr int h = Grid::half;
  Grid result;
  for (int y = -h; y <= h; ++y)
    for (int v = std::max(-h, y - h); v <= std::min(h, y + h); ++v)
      for (int u = -h; u <= h; ++u) {
        const double weight = a.at(u, v) * Grid::step * Grid::step;
        for (int x = std::max(-h, u - h); x <= std::min(h, u + h); ++x) result.at(x, y) += weight * b.at(x - u, y - v);
      }
  return result;
}

TEST(Layered, EqualsConvolutionsOfTheSlabsInThePlane) {
  // Strong absorption: the light stays on the grid, and few reflections between the layers count.
  const Medium<double> upper{.4, .6, 1.2}, lower{.3, .7, 1.4};
  const double d = 3, below = 2.8;
  const Multipole<double> first({upper, d, 1.2 / 1.4}), first_reversed({{.4, .6, 1.2 / 1.4}, d, 1.2});
  const Multipole<double> second({{.3, .7, 1.4 / 1.2}, below, 1.4});
  const auto grid_of = [](const Multipole<double>& slab, bool through) {
    return Grid::of([&](double r) { return through ? slab.transmittance(r) : slab.reflectance(r); });
  };
  const Grid between = convolved(grid_of(first_reversed, false), grid_of(second, false));  // one round trip
  Grid down = grid_of(first, true), arriving = down;
  for (int trip = 0; trip < 5; ++trip) {
    down = convolved(down, between);
    for (std::size_t i = 0; i < down.value.size(); ++i) arriving.value[i] += down.value[i];
  }
  const Grid transmitted = convolved(arriving, grid_of(second, true));
  const Grid added = convolved(convolved(arriving, grid_of(second, false)), grid_of(first_reversed, true));
  const Stack layers = {{upper, d}, {lower, below}};
  for (const int x : {0, 1, 4, 9}) {
    const double r = x * Grid::step;
    EXPECT_NEAR((reflectance(layers, r) - first.reflectance(r)) / added.at(x, 0), 1, 2e-5) << r;
    EXPECT_NEAR(transmittance(layers, r) / transmitted.at(x, 0), 1, 2e-5) << r;
  }
}

TEST(Layered, EnergyIsConserved) {
  for (const Stack& layers : stacks) {
    const auto slabs = stack_of(layers, 1.0);
    const Response<double> all = stack_response(slabs, 0.0);
    EXPECT_NEAR(all.reflected + all.transmitted + all.absorbed, 1, 1e-15);
    if (layers.front().medium.sigma_a == 0) {
      EXPECT_NEAR(all.reflected + all.transmitted, 1, 1e-15);
      EXPECT_EQ(all.absorbed, 0);
    }
  }
}

TEST(Layered, FromBelowIsTheStackTurnedOver) {
  const Stack layers = {{{.3, 2, 1.4}, 2}, {{.02, 1, 1.2}, 5}, {{.1, 1, 1.5}, 3}};
  const Stack turned(layers.rbegin(), layers.rend());
  for (const double k : {0.0, .4, 2.0}) {
    const auto a = stack_response(stack_of(layers, 1.0), k * k), b = stack_response(stack_of(turned, 1.0), k * k);
    EXPECT_NEAR(a.reflected_below / b.reflected, 1, 1e-14);
    EXPECT_NEAR(a.transmitted_below / b.transmitted, 1, 1e-13);
    EXPECT_NEAR(a.absorbed_below / b.absorbed, 1, 1e-14);
    EXPECT_GT(std::abs(a.reflected / b.reflected - 1), .01);
  }
}

TEST(Layered, ThickTopLayersHideAndVanishingOnesShowWhatIsBelow) {
  const Medium<double> top{.2, 1, 1}, bottom{.01, 3, 1};
  const double alone = StandardDipole<double>(top).total(), hidden = StandardDipole<double>(bottom).total();
  const auto total = [&](double d) {
    return stack_response(stack_of(Stack{{top, d}, {bottom, infinity}}, 1.0), 0.0).reflected;
  };
  EXPECT_NEAR(total(60) / alone, 1, 1e-12);
  EXPECT_NEAR(total(1e-9) / hidden, 1, 1e-8);
  EXPECT_NEAR(reflectance({{top, 60}, {bottom, infinity}}, .7) / StandardDipole<double>(top).evaluate(.7), 1, 1e-9);
  double before = hidden;  // without a jump where the source is moved and the beam passes (slab.h)
  for (double d = .01; d < 5; d *= 1.01) {
    EXPECT_LT(std::abs(total(d) - before), .03 * before) << d;
    before = total(d);
  }
}

TEST(Layered, ALayerThatDoesNotScatterIsBlack) {
  const Stack black = {{{1, 0, 1.3}, 3}, {{.01, 3, 1.3}, infinity}};
  EXPECT_EQ(stack_response(stack_of(black, 1.0), 0.0).reflected, 0);
  EXPECT_EQ(reflectance(black, 1), 0);
}

TEST(Layered, ASlabCutInTwoIsNotTheSlab) {
  // The model's weak point: the lower half is lit as if by a normal beam, a mean free path deeper than diffuse light
  // gets. Whole and halves approach each other as the halves grow.
  const auto transmitted = [](const Stack& layers) { return stack_response(stack_of(layers, 1.0), 0.0).transmitted; };
  double before = 1;
  for (const double half : {2.0, 5.0, 20.0, 200.0}) {
    const Layer piece{{0, 1, 1}, half};
    const double cut = transmitted({{piece.medium, half}, {piece.medium, half}}),
                 whole = transmitted({{piece.medium, 2 * half}});
    EXPECT_GT(cut / whole, 1) << half;
    EXPECT_LT(cut / whole - 1, before) << half;
    before = cut / whole - 1;
  }
  EXPECT_LT(before, 5e-3);
}

TEST(Layered, DecayIsTheSlowestMode) {
  const Stack layers = {{{.5, 1, 1.3}, 2}, {{.001, 1, 1.3}, infinity}};
  const auto slabs = stack_of(layers, 1.0);
  const double kappa = std::sqrt(decays(slabs).back());
  EXPECT_NEAR(kappa, std::sqrt(slabs[1].sigma_tr_squared), 1e-9 * kappa);  // the clear half space carries it
  const double r = 400, fall = reflectance(layers, r + 10) / reflectance(layers, r);
  EXPECT_NEAR(-std::log(fall) / 10, kappa, .1 * kappa);
}

TEST(Layered, RowTellsTheStackApart) {
  const ProfileInfo& info = *find_profile("layered");
  const std::vector<Layer> below = {{{.1, 2, 1.5}, 4}, {{.01, 2, 1.2}, infinity}};
  const auto profile = info.make({.02, 1, 1.3}, {{"thickness_mm", 3.0}, {"layers", below}});
  EXPECT_NEAR(profile->evaluate(1.3) / reflectance(stacks[0], 1.3), 1, 1e-13);
  EXPECT_EQ(profile->transmittance(1), 0);
}

}  // namespace
}  // namespace opaline
