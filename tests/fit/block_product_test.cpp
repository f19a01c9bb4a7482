// The vectorised products against Eigen's, on every instruction set, for sizes around the tiles' and the panels'.
#include "fit/block_product.h"
#include "model/simd.h"

#include <gtest/gtest.h>

#include <random>

namespace opaline {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd random_matrix(Index rows, Index columns, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

/// Of a product, whose terms are about 1.
double tolerance(Index depth) { return 1e-14 * static_cast<double>(depth + 1); }

void compare(Index rows, Index columns, Index depth, std::mt19937& random) {
  SCOPED_TRACE(testing::Message() << rows << " x " << columns << ", depth " << depth);
  const MatrixXd a = random_matrix(rows, depth, random), b = random_matrix(depth, columns, random),
                 before = random_matrix(rows, columns, random);  // products add to what is there
  MatrixXd sum = before;
  add_product(a, b, sum);
  EXPECT_LT((sum - before - a * b).cwiseAbs().maxCoeff(), tolerance(depth));
  sum = before;
  add_outer_product(a, b.transpose(), false, sum);
  EXPECT_LT((sum - before - a * b).cwiseAbs().maxCoeff(), tolerance(depth));
  MatrixXd square = MatrixXd::Zero(rows, rows);
  add_outer_product(a, a, true, square);
  const MatrixXd lower = MatrixXd(square - a * a.transpose()).triangularView<Eigen::Lower>();
  EXPECT_LT(lower.cwiseAbs().maxCoeff(), tolerance(depth));
  if (rows != depth) return;
  const MatrixXd triangle = a.triangularView<Eigen::Lower>();
  sum = before;
  add_product(triangle, b, sum);
  EXPECT_LT((sum - before - triangle * b).cwiseAbs().maxCoeff(), tolerance(depth));
}

TEST(BlockProduct, IsEigensOnEveryInstructionSet) {
  for (const std::string& target : simd_targets()) {
    SCOPED_TRACE(target);
    ASSERT_TRUE(limit_simd_target(target));
    std::mt19937 random(5);
    for (const Index rows : {1, 7, 16, 33})
      for (const Index columns : {1, 5, 6, 13})
        for (const Index depth : {1, 7, 16, 33, 192, 193, 400}) compare(rows, columns, depth, random);
    compare(70, 70, 70, random);
    compare(250, 20, 250, random);
  }
  limit_simd_target("");
}

TEST(BlockProduct, WithoutTermsAddsNothing) {
  MatrixXd sum = MatrixXd::Ones(3, 2);
  add_product(MatrixXd(3, 0), MatrixXd(0, 2), sum);
  EXPECT_EQ(sum, MatrixXd::Ones(3, 2));
  add_product(MatrixXd::Zero(3, 4), MatrixXd::Ones(4, 2), sum);
  EXPECT_EQ(sum, MatrixXd::Ones(3, 2));
}

}  // namespace
}  // namespace opaline
