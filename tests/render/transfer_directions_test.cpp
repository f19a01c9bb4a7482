// The directions that a transfer table has its light from: spread, and interpolation between them.
#include "tests/render/transfer_fixture.h"

#include <gtest/gtest.h>

namespace opaline {
namespace {

TEST(DirectionSet, IsUniformOverTheSphere) {
  for (const int count : {50, 200, 800}) {
    const DirectionSet set(count);
    glm::dvec3 mean(0);
    glm::dmat3 square(0.0);
    for (std::size_t i = 0; i < set.size(); ++i)
      mean += set[i] / double(count), square += glm::outerProduct(set[i], set[i]) / double(count);
    EXPECT_LT(glm::length(mean), 1.0 / count);
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(square[i][k], i == k ? 1.0 / 3 : 0, 1.0 / count) << count;
  }
}

TEST(DirectionSet, InterpolatesExactlyAtItsDirectionsAndLinearlyBetweenThem) {
  std::mt19937 random(1);
  const DirectionSet set(200);
  for (std::size_t i = 0; i < set.size(); ++i) {
    const auto w = set.around(set[i]);
    EXPECT_EQ(w[0].direction, i);
    EXPECT_NEAR(w[0].weight, 1, 1e-9);
  }
  for (int i = 0; i < 1000; ++i) {
    const glm::dvec3 w = test::random_direction(random);
    double sum = 0;
    glm::dvec3 on_plane(0);
    for (const DirectionWeight& d : set.around(w)) {
      EXPECT_GT(d.weight, -0.5);
      sum += d.weight, on_plane += d.weight * set[d.direction] / glm::dot(set[d.direction], w);
    }
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_LT(glm::length(on_plane - w), 1e-9);
  }
}

TEST(DirectionSet, ItsErrorIsOfTheSecondOrder) {
  // Four times the directions halve the spacing, so a smooth function's error falls to a quarter.
  const auto error = [](int count) {
    std::mt19937 random(2);
    const DirectionSet set(count);
    double squares = 0;
    for (int i = 0; i < 2000; ++i) {
      const glm::dvec3 w = test::random_direction(random);
      const auto f = [](const glm::dvec3& d) { return std::exp(d.x) + d.y * d.z; };
      double sum = -f(w);
      for (const DirectionWeight& d : set.around(w)) sum += d.weight * f(set[d.direction]);
      squares += sum * sum / 2000;
    }
    return std::sqrt(squares);
  };
  const double ratio = error(200) / error(800);
  EXPECT_GT(ratio, 3);
  EXPECT_LT(ratio, 5);
}

TEST(DirectionSet, TwelveDirectionsReproduceQuadratics) {
  std::mt19937 random(3);
  const DirectionSet set(200, DirectionInterpolation::twelve);
  for (std::size_t i = 0; i < set.size(); i += 7) {
    const auto w = set.around(set[i]);
    EXPECT_EQ(w[0].direction, i);
    EXPECT_NEAR(w[0].weight, 1, 1e-6);
  }
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 w = test::random_direction(random);
    const glm::dvec3 s = glm::normalize(glm::cross(w, glm::dvec3(0.3, 0.5, 0.8))), t = glm::cross(w, s);
    double sums[6] = {};
    for (const DirectionWeight& d : set.around(w)) {
      const glm::dvec3 v = set[d.direction];
      const double angle = std::acos(glm::dot(v, w)), phi = std::atan2(glm::dot(v, t), glm::dot(v, s));
      const double x = angle * std::cos(phi), y = angle * std::sin(phi);
      const double terms[6] = {1, x, y, x * x, x * y, y * y};
      for (int k = 0; k < 6; ++k) sums[k] += d.weight * terms[k];
      EXPECT_LT(std::abs(d.weight), 1.5);
    }
    for (int k = 0; k < 6; ++k) EXPECT_NEAR(sums[k], k == 0, 1e-9);
  }
}

TEST(DirectionSet, TwelveAreBetterThanFourWhereAFunctionIsSmooth) {
  const auto f = [](const glm::dvec3& d) { return std::exp(d.x) + d.y * d.z; };
  const auto error = [&](int count, DirectionInterpolation interpolation) {
    std::mt19937 random(2);
    const DirectionSet set(count, interpolation);
    double squares = 0;
    for (int i = 0; i < 2000; ++i) {
      const glm::dvec3 w = test::random_direction(random);
      double sum = -f(w);
      for (const DirectionWeight& d : set.around(w)) sum += d.weight * f(set[d.direction]);
      squares += sum * sum / 2000;
    }
    return std::sqrt(squares);
  };
  EXPECT_LT(error(200, DirectionInterpolation::twelve), 0.2 * error(200, DirectionInterpolation::four));
  const double ratio = error(200, DirectionInterpolation::twelve) / error(800, DirectionInterpolation::twelve);
  EXPECT_GT(ratio, 6.5);  // third order: 8
}

}  // namespace
}  // namespace opaline
