// The short rows of Q and the factor L^T are the operator, and its residuals in whitened coordinates are the pixels'.
#include "fit/reduced_picture.h"
#include "fit/solve.h"
#include "tests/support/fit_fixture.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <Eigen/LU>

#include <random>

namespace opaline {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

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

MatrixXd matrix_of(const TransportOperator& op, int light) {
  MatrixXd m(static_cast<Index>(op.rows()), static_cast<Index>(op.columns()));
  for (Index i = 0; i < m.rows(); ++i)
    for (Index j = 0; j < m.cols(); ++j) m(i, j) = static_cast<double>(op.row(static_cast<std::size_t>(i), light)[j]);
  return m;
}

MatrixXd q_of(const OrthonormalOperator& o, std::size_t light) { return o.q[light].cast<double>().transpose(); }

/// How far Q^T Q is from 1; what is left is the rounding of Q to float.
double skewness(const OrthonormalOperator& o, std::size_t light) {
  const MatrixXd q = o.q[light].cast<double>();
  return (q * q.transpose() - MatrixXd::Identity(q.rows(), q.rows())).norm();
}

TEST(OrthonormalOperator, IsTheOperator) {
  for (const int lights : {1, 3}) {
    const TransportOperator op = random_operator(700, lights, 1);
    const OrthonormalOperator o = orthonormalise(op);
    ASSERT_EQ(o.q.size(), static_cast<std::size_t>(lights));
    for (int light = 0; light < lights; ++light) {
      const auto l = static_cast<std::size_t>(light);
      const MatrixXd m = matrix_of(op, light), q = q_of(o, l);
      EXPECT_EQ(q.cols(), m.cols()) << "full rank";
      EXPECT_LT((q * o.factor[l] - m).norm(), 1e-6 * m.norm());
      EXPECT_LT(skewness(o, l), 1e-6);
    }
  }
}

TEST(OrthonormalOperator, LeavesOutColumnsThatAreZeroOrRepeated) {
  TransportOperator op = random_operator(60, 1, 6);
  const std::size_t n = op.columns();
  for (std::size_t row = 0; row < op.rows(); ++row) {
    op.values[row * n] = op.values[row * n + 5] = 0;
    op.values[row * n + 4] = 2e4f * op.values[row * n + 2];  // scale does not matter
  }
  const OrthonormalOperator o = orthonormalise(op);
  EXPECT_EQ(o.q[0].rows(), static_cast<Index>(n) - 3);
  EXPECT_EQ(o.factor[0].col(0).norm(), 0);
  EXPECT_TRUE(o.factor[0].allFinite());
  const MatrixXd m = matrix_of(op, 0);
  EXPECT_LT((q_of(o, 0) * o.factor[0] - m).norm(), 1e-6 * m.norm());
}

/// Of many rows only some tell which columns depend on which; a column that those do not show is found out.
TEST(OrthonormalOperator, LearnsFromSomeRowsAndChecksOnOthers) {
  TransportOperator op = random_operator(17000, 1, 9);
  const std::size_t n = op.columns();
  for (std::size_t row = 0; row < op.rows(); ++row) op.values[row * n + 3] = 2 * op.values[row * n + 1];
  const auto error = [&](const OrthonormalOperator& o) {
    const MatrixXd m = matrix_of(op, 0);
    return (q_of(o, 0) * o.factor[0] - m).norm() / m.norm();
  };
  const OrthonormalOperator some = orthonormalise(op);
  EXPECT_EQ(some.reduced_in_full, 0);
  EXPECT_EQ(some.q[0].rows(), static_cast<Index>(n) - 1);
  EXPECT_LT(error(some), 1e-6);
  EXPECT_LT(skewness(some, 0), 1e-6);
  for (std::size_t row = 0; row < op.rows(); row += 2) op.values[row * n + 3] = 2 * op.values[row * n + 1];
  for (std::size_t row = 1; row < op.rows(); row += 2) op.values[row * n + 3] = op.values[row * n + 2];
  const OrthonormalOperator all = orthonormalise(op);
  EXPECT_EQ(all.reduced_in_full, 1);
  EXPECT_EQ(all.q[0].rows(), static_cast<Index>(n));
  EXPECT_LT(error(all), 1e-6);
  EXPECT_LT(skewness(all, 0), 1e-6);
}

TEST(OrthonormalOperator, ShrinksAScenesOperatorAndKeepsItsPictures) {
  for (const bool coloured : {false, true}) {
    Scene scene = test::sphere_scene("marble", 28);
    if (coloured) scene.lights.push_back(DirectionalLight{{0, 0, -1}, Rgb(1, 0.2, 0.1), 0});
    const TransportOperator op = build_operator(scene, 0, test::free_eta(), test::small_operator(1500));
    ASSERT_EQ(op.light_channels, coloured ? 3 : 1);
    const FitTarget target = make_target(op, operator_image(op, test::dipole(), scene.materials[0]), "target");
    EXPECT_LT(target.basis.q[0].rows(), static_cast<Index>(2 * op.columns() / 3));
    EXPECT_TRUE(target.op.values.empty());
    EXPECT_LT(skewness(target.basis, 0), 1e-6);
    for (const char* name : {"skin2", "cream", "ketchup"}) {
      const Material material = test::library_material(name);
      const Image full = operator_image(op, test::dipole(), material),
                  shrunk = target_image(target, test::dipole(), material);
      EXPECT_LT(test::relative_rms(op, shrunk, full), 1e-6) << name;
    }
  }
}

TEST(OrthonormalOperator, IsTheSameForAnyNumberOfThreads) {
  const TransportOperator op = random_operator(5000, 3, 12);
  const auto build = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return orthonormalise(op);
  };
  const OrthonormalOperator one = build(1), two = build(2);
  for (std::size_t i = 0; i < one.q.size(); ++i) {
    EXPECT_TRUE(one.q[i] == two.q[i]);
    EXPECT_TRUE(one.factor[i] == two.factor[i]);
  }
}

/// z per channel, and the squared residual of the pixels it stands for, weighted by P.
struct Case {
  FitTarget target;
  std::array<Eigen::VectorXd, 3> z;

  explicit Case(int lights, unsigned seed)
      : target(make_target(random_operator(300, lights, seed), random_target(300, seed + 1), "target")) {
    std::mt19937 random(seed + 2);
    std::normal_distribution<double> normal;
    for (int c = 0; c < 3; ++c)
      z[static_cast<std::size_t>(c)] = Eigen::VectorXd::NullaryExpr(target.q(c).rows(), [&] { return normal(random); });
  }
  Eigen::Vector3d residual(Index p) const {
    Eigen::Vector3d r;
    for (int c = 0; c < 3; ++c)
      r[c] = target.q(c).col(p).cast<double>().dot(z[static_cast<std::size_t>(c)]) - target.picture(p, c);
    return r;
  }
  double whitened_square(const Whitened& w) const {
    Eigen::VectorXd r = -w.y;
    for (int c = 0; c < 3; ++c) w.add(c, z[static_cast<std::size_t>(c)], r);
    return r.squaredNorm() + w.constant;
  }
};

TEST(Whitening, IsTheSumOverThePixelsForAnyNoise) {
  for (const int lights : {1, 3})
    for (const double correlation : {0.0, 0.7}) {
      SCOPED_TRACE(std::to_string(lights) + " lights, correlation " + std::to_string(correlation));
      Case c(lights, 20);
      NoiseModel noise;
      noise.known = true;
      noise.read_sd = {0.5, 1, 2};
      noise.correlation = (1 - correlation) * Eigen::Matrix3d::Identity() + correlation * Eigen::Matrix3d::Ones();
      Eigen::Matrix3d sd = Eigen::Vector3d(0.5, 1, 2).asDiagonal();
      const Eigen::Matrix3d covariance = sd * noise.correlation * sd;
      double uniform = 0, shot = 0;
      NoiseModel with_shot = noise;
      with_shot.shot = {0.3, 0.1, 2};
      const MatrixXd signal = c.target.picture.cwiseAbs();
      for (Index p = 0; p < 300; ++p) {
        const Eigen::Vector3d r = c.residual(p);
        uniform += r.dot(covariance.inverse() * r);
        Eigen::Matrix3d local = Eigen::Matrix3d::Zero();
        for (int i = 0; i < 3; ++i) local(i, i) = std::sqrt(with_shot.variance(i, signal(p, i)));
        shot += r.dot((local * noise.correlation * local).inverse() * r);
      }
      EXPECT_NEAR(c.whitened_square(whiten(c.target, covariance)), uniform, 1e-5 * uniform);
      EXPECT_NEAR(c.whitened_square(whiten(c.target, pixel_precision(c.target, with_shot, signal))), shot, 1e-5 * shot);
    }
}

TEST(Whitening, ANearlySingularCovarianceIsKeptRegular) {
  const Eigen::Matrix3d ones = Eigen::Matrix3d::Ones();
  const Eigen::Matrix3d regular = regular_covariance(4 * ones, 0.02);
  EXPECT_NEAR(regular(0, 0), 4, 1e-12);
  EXPECT_NEAR(regular(0, 1) / 4, 0.98, 1e-12);
  const Eigen::Matrix3d diagonal = Eigen::Vector3d(1, 4, 9).asDiagonal();
  EXPECT_LT((regular_covariance(diagonal) - diagonal).norm(), 1e-12);
}

}  // namespace
}  // namespace opaline
