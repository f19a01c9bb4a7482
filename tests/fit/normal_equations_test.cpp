// The reduced problem is the problem: its squared residual equals the one over all pixels.
#include "fit/normal_equations.h"
#include "tests/support/fit_fixture.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <random>

namespace opaline {
namespace {

double direct_square(const TransportOperator& op, const Image& target, const Eigen::VectorXd& x, int channel) {
  double sum = 0;
  for (std::size_t row = 0; row < op.rows(); ++row) {
    const float* m = op.row(row, op.light_channel(channel));
    double value =
        -static_cast<double>(target.data[op.pixels[row] * target.channels.size() + static_cast<std::size_t>(channel)]);
    for (Eigen::Index j = 0; j < x.size(); ++j) value += static_cast<double>(m[j]) * x[j];
    sum += value * value;
  }
  return sum;
}

double reduced_square(const ReducedLeastSquares& reduced, const Eigen::VectorXd& x, int channel) {
  const auto c = static_cast<std::size_t>(channel);
  return (reduced.factor_transposed * x - reduced.y[c]).squaredNorm() + reduced.constant[c];
}

/// An operator with random rows, without a scene: `rows` pixels of a film as wide.
TransportOperator random_operator(std::size_t rows, int light_channels, unsigned seed) {
  TransportOperator op{RadialBasis(0.1, 0.9, 0.4), EtaNodes(1.1, 1.5, 2)};
  op.light_channels = light_channels;
  op.width = static_cast<int>(rows), op.height = 1;
  for (std::size_t i = 0; i < rows; ++i) op.pixels.push_back(static_cast<std::uint32_t>(i));
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  op.values.resize(rows * static_cast<std::size_t>(light_channels) * op.columns());
  for (float& value : op.values) value = normal(random);
  return op;
}

Image random_target(int width, unsigned seed) {
  Image image(width, 1, {"R", "G", "B"});
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  for (float& value : image.data) value = normal(random);
  return image;
}

Eigen::VectorXd random_vector(Eigen::Index n, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::VectorXd::NullaryExpr(n, [&] { return normal(random); });
}

TEST(NormalEquations, AreTheProductsOfTheMatrix) {
  for (const int light_channels : {1, 3}) {
    const TransportOperator op = random_operator(700, light_channels, 1);
    const Image target = random_target(700, 2);
    const std::vector<NormalEquations> equations = normal_equations(op, target);
    ASSERT_EQ(equations.size(), static_cast<std::size_t>(light_channels));
    const auto n = static_cast<Eigen::Index>(op.columns());
    for (int c = 0; c < 3; ++c) {
      Eigen::MatrixXd m(700, n);
      Eigen::VectorXd t(700);
      for (Eigen::Index i = 0; i < 700; ++i) {
        for (Eigen::Index j = 0; j < n; ++j)
          m(i, j) = static_cast<double>(op.row(static_cast<std::size_t>(i), op.light_channel(c))[j]);
        t[i] = static_cast<double>(target.at(static_cast<int>(i), 0, c));
      }
      const NormalEquations& e = equations[static_cast<std::size_t>(op.light_channel(c))];
      EXPECT_EQ(e.rows, 700u);
      EXPECT_LT((e.gram - m.transpose() * m).norm(), 1e-11 * e.gram.norm());
      EXPECT_LT((e.b[static_cast<std::size_t>(c)] - m.transpose() * t).norm(), 1e-11 * e.gram.norm());
      EXPECT_NEAR(e.tau[static_cast<std::size_t>(c)], t.squaredNorm(), 1e-11 * t.squaredNorm());
    }
    if (light_channels == 3) {
      EXPECT_EQ(equations[0].b[1].size(), 0) << "the red light serves no other colour";
    }
  }
}

TEST(Reduce, KeepsTheSquaredResidualOfAnyCoefficients) {
  const TransportOperator op = random_operator(60, 1, 3);
  const Image target = random_target(60, 4);
  const ReducedLeastSquares reduced = reduce(normal_equations(op, target).front());
  EXPECT_EQ(reduced.factor_transposed.rows(), static_cast<Eigen::Index>(op.columns()));  // full rank
  std::mt19937 random(5);
  for (int c = 0; c < 3; ++c) {
    const Eigen::VectorXd x = random_vector(static_cast<Eigen::Index>(op.columns()), random);
    const double direct = direct_square(op, target, x, c);
    EXPECT_NEAR(reduced_square(reduced, x, c), direct, 1e-10 * direct);
    EXPECT_GT(reduced.constant[static_cast<std::size_t>(c)], 0);
  }
}

TEST(Reduce, LeavesOutColumnsThatAreZeroOrRepeated) {
  TransportOperator op = random_operator(60, 1, 6);
  const std::size_t n = op.columns();
  for (std::size_t row = 0; row < op.rows(); ++row) {
    op.values[row * n] = 0;
    op.values[row * n + 5] = 0;
    op.values[row * n + 4] = 2e4f * op.values[row * n + 2];  // scale does not matter
  }
  const Image target = random_target(60, 7);
  const ReducedLeastSquares reduced = reduce(normal_equations(op, target).front());
  EXPECT_EQ(reduced.factor_transposed.rows(), static_cast<Eigen::Index>(n) - 3);
  EXPECT_EQ(reduced.factor_transposed.col(0).norm(), 0);
  EXPECT_TRUE(reduced.factor_transposed.allFinite());
  std::mt19937 random(8);
  const Eigen::VectorXd x = random_vector(static_cast<Eigen::Index>(n), random);
  for (int c = 0; c < 3; ++c) {
    const double direct = direct_square(op, target, x, c);
    EXPECT_NEAR(reduced_square(reduced, x, c), direct, 1e-8 * direct);
  }
}

TEST(Reduce, OfAnOperatorWithoutLightIsEmpty) {
  TransportOperator op = random_operator(20, 1, 9);
  std::fill(op.values.begin(), op.values.end(), 0.0f);
  const Image target = random_target(20, 10);
  const NormalEquations equations = normal_equations(op, target).front();
  const ReducedLeastSquares reduced = reduce(equations);
  EXPECT_EQ(reduced.factor_transposed.rows(), 0);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_DOUBLE_EQ(reduced.constant[c], equations.tau[c]);
}

TEST(Reduce, KeepsTheResidualOfProfilesToABillionth) {
  for (const bool coloured : {false, true}) {
    Scene scene = test::sphere_scene("marble", 28);
    if (coloured) scene.lights.push_back(DirectionalLight{{0, 0, -1}, Rgb(1, 0.2, 0.1), 0});
    const TransportOperator op = build_operator(scene, 0, test::free_eta(), test::small_operator(1500));
    ASSERT_EQ(op.light_channels, coloured ? 3 : 1);
    Image target = operator_image(op, test::dipole(), test::library_material("skin2"));
    add_noise(target, 0.01, 1);
    const std::vector<NormalEquations> equations = normal_equations(op, target);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int c = 0; c < 3; ++c) {
      const auto light = static_cast<std::size_t>(op.light_channel(c));
      const ReducedLeastSquares reduced = reduce(equations[light]);
      EXPECT_LT(reduced.factor_transposed.rows(), static_cast<Eigen::Index>(2 * op.columns() / 3));
      for (int i = 0; i < 4; ++i) {
        const Medium<double> medium{std::pow(10, -2 + 2 * unit(random)), std::pow(10, 1.5 * unit(random)),
                                    1.1 + 0.8 * unit(random)};
        const std::vector<double> value = column_coefficients(op, test::dipole(), medium, c).value;
        const Eigen::VectorXd x =
            Eigen::Map<const Eigen::VectorXd>(value.data(), static_cast<Eigen::Index>(value.size()));
        EXPECT_NEAR(reduced_square(reduced, x, c), direct_square(op, target, x, c),
                    1e-9 * equations[light].tau[static_cast<std::size_t>(c)]);
      }
    }
  }
}

TEST(NormalEquations, AreTheSameForAnyNumberOfThreads) {
  const TransportOperator op = random_operator(5000, 3, 12);
  const Image target = random_target(5000, 13);
  const auto build = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return normal_equations(op, target);
  };
  const auto one = build(1), two = build(2);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_TRUE(one[i].gram == two[i].gram);
    EXPECT_TRUE(one[i].b[i] == two[i].b[i]);
    EXPECT_EQ(one[i].tau, two[i].tau);
  }
}

}  // namespace
}  // namespace opaline
