// What is kept of a transfer table: quantiser, harmonics, and the sums over stored rows.
#include "model/quadrature.h"
#include "model/simd.h"
#include "render/transfer/harmonics.h"
#include "tests/render/transfer_fixture.h"

#include <gmock/gmock.h>

#include <map>

namespace opaline {
namespace {

// --- Lloyd ------------------------------------------------------------------------------------------

double mean_squared_error(const Codebook& book, const std::vector<float>& values) {
  double sum = 0;
  for (const float v : values) sum += std::pow(static_cast<double>(book[encode(book, v)] - v), 2);
  return sum / static_cast<double>(values.size());
}

TEST(Lloyd, LevelsAreTheMeansOfWhatIsNearestToThem) {
  std::vector<float> values(200000);  // of density 2 x
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = std::sqrt((static_cast<float>(i) + 0.5f) / static_cast<float>(values.size()));
  const Codebook book = lloyd_codebook(values);
  std::array<double, 256> sum{}, count{};
  for (const float v : values) {
    const std::uint8_t code = encode(book, v);
    for (const int other : {code - 1, code + 1}) {
      if (other < 0 || other > 255) continue;
      EXPECT_LE(std::abs(v - book[code]), std::abs(v - book[static_cast<std::size_t>(other)]) + 1e-7f);
    }
    sum[code] += static_cast<double>(v), count[code] += 1;
  }
  for (std::size_t i = 0; i < 256; ++i) {
    ASSERT_GT(count[i], 0) << i;
    EXPECT_NEAR(sum[i] / count[i], static_cast<double>(book[i]), 2e-4 * static_cast<double>(book[255])) << i;
  }
  // Panter and Dite 1951: the least error of n levels is (int f^(1/3))^3 / (12 n^2), (int f^(1/3))^3 = 2 (3/4)^3.
  EXPECT_NEAR(mean_squared_error(book, values) / (0.84375 / (12 * 256 * 256)), 1, 0.02);
}

TEST(Lloyd, IsTheUniformQuantiserOfUniformNumbers) {
  std::vector<float> values(100001);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i) / 100000.0f;
  const Codebook book = lloyd_codebook(values);
  EXPECT_NEAR(mean_squared_error(book, values) * 12 * 256 * 256, 1, 0.01);
  std::vector<float> one(10, 3.0f), none;
  EXPECT_EQ(lloyd_codebook(one)[encode(lloyd_codebook(one), 3.0f)], 3.0f);
  EXPECT_EQ(lloyd_codebook(none), Codebook{});
}

// --- harmonics --------------------------------------------------------------------------------------

TEST(Harmonics, AreOrthonormal) {
  constexpr int order = 8, steps = 32;
  const std::size_t n = order * order;
  // Gauss in cos t and equal steps in p: exact for products of these polynomials.
  std::map<double, std::vector<std::vector<double>>> rings;
  const auto ring = [&](double z) -> const std::vector<std::vector<double>>& {
    auto& values = rings[z];
    const double r = std::sqrt(1 - z * z);
    for (int k = static_cast<int>(values.size()); k < steps; ++k) {
      const double phi = 2 * pi * (k + 0.5) / steps;
      values.push_back(harmonics(order, {r * std::cos(phi), r * std::sin(phi), z}));
    }
    return values;
  };
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      const double product = gauss_legendre(-1.0, 1.0, [&](double z) {
        double sum = 0;
        for (const std::vector<double>& y : ring(z)) sum += y[a] * y[b] * 2 * pi / steps;
        return sum;
      });
      EXPECT_NEAR(product, a == b ? 1 : 0, 1e-12) << a << " " << b;
    }
}

TEST(Harmonics, AddUpToLegendresPolynomials) {
  std::mt19937 random(4);
  for (int i = 0; i < 100; ++i) {
    const glm::dvec3 a = test::random_direction(random), b = test::random_direction(random);
    const std::vector<double> ya = harmonics(7, a), yb = harmonics(7, b);
    const double c = glm::dot(a, b);
    double p = 1, below = 0;
    for (int l = 0; l < 7; ++l) {
      double sum = 0;
      for (int m = -l; m <= l; ++m)
        sum += ya[static_cast<std::size_t>(l * (l + 1) + m)] * yb[static_cast<std::size_t>(l * (l + 1) + m)];
      EXPECT_NEAR(sum, (2 * l + 1) / (4 * pi) * p, 1e-12);
      const double next = ((2 * l + 1) * c * p - l * below) / (l + 1);
      below = p, p = next;
    }
  }
  EXPECT_NEAR(harmonics(2, {0, 0, 1})[2], std::sqrt(3 / (4 * pi)), 1e-15);
  EXPECT_NEAR(harmonics(2, {1, 0, 0})[3], std::sqrt(3 / (4 * pi)), 1e-15);
}

TEST(Harmonics, AProjectionGivesBackWhatItIsMadeOf) {
  const DirectionSet set(200);
  std::vector<glm::dvec3> directions;
  for (std::size_t i = 0; i < set.size(); ++i) directions.push_back(set[i]);
  std::vector<double> matrix;
  ASSERT_TRUE(harmonic_projection(7, directions, matrix));
  for (const std::size_t which : {0u, 5u, 30u, 48u})
    for (std::size_t i = 0; i < 49; ++i) {
      double sum = 0;
      for (std::size_t j = 0; j < 200; ++j) sum += matrix[i * 200 + j] * harmonics(7, directions[j])[which];
      EXPECT_NEAR(sum, i == which ? 1 : 0, 1e-10);
    }
  directions.resize(40);
  EXPECT_FALSE(harmonic_projection(7, directions, matrix));
}

// --- rows -------------------------------------------------------------------------------------------

class EveryTarget : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { ASSERT_TRUE(limit_simd_target(GetParam())); }
  void TearDown() override { limit_simd_target(""); }
};

TEST_P(EveryTarget, RowsAreSummedAsTheyAreStored) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-1, 1);
  constexpr std::size_t rows = 13, vertices = 100, stride = 112;
  std::vector<float> values(rows * stride, 0.0f);
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t v = 0; v < vertices; ++v) values[r * stride + v] = uniform(random);
  const std::pair<RowStorage, double> forms[] = {
      {RowStorage::f32, 1e-6}, {RowStorage::i16, 1e-4}, {RowStorage::i8, 0.03}, {RowStorage::code8, 0.03}};
  for (const auto& [storage, tolerance] : forms) {
    const CodedRows coded(storage, values, rows, vertices, 1);
    EXPECT_EQ(coded.bytes_per_vertex(), static_cast<double>(rows * bytes_of(storage)));
    std::vector<float> out(stride, 0.5f);
    std::vector<RowTerm> terms;
    for (std::size_t r = 0; r < rows; ++r) terms.push_back(coded.term(r, 0.1f * static_cast<float>(r)));
    add_rows(storage, terms, 0, 32, out.data());
    add_rows(storage, terms, 32, stride - 32, out.data() + 32, terms);
    for (std::size_t v = 0; v < vertices; ++v) {
      double sum = 0.5;
      for (std::size_t r = 0; r < rows; ++r)
        sum += static_cast<double>(0.1f * static_cast<float>(r)) * static_cast<double>(values[r * stride + v]);
      EXPECT_NEAR(static_cast<double>(out[v]), sum, tolerance) << static_cast<int>(storage);
    }
  }
}

TEST_P(EveryTarget, CornersAreBlended) {
  const std::vector<float> points = {1, 2, 3, 0, 10, 20, 30, 0, 100, 200, 300, 0, 7, 7, 7, 0};
  const std::vector<std::uint32_t> triangles = {0, 1, 2, 3, 3, 3, 2, 0, 1};
  std::vector<std::uint32_t> triangle_of(48, 1);
  std::vector<short> weights(96, 0);
  triangle_of[16] = 0, weights[32] = 5000, weights[33] = 2500;
  triangle_of[18] = 2, weights[36] = -10000, weights[37] = 20000;
  std::vector<float> red(32, 1), green(32, 1), blue(32, 1);
  add_blend({points.data(), triangles.data(), triangle_of.data(), weights.data(), 10}, 16, 32,
            {red.data(), green.data(), blue.data()});
  EXPECT_NEAR(red[0], 1 + 0.5 + 2.5 + 25, 1e-4);
  EXPECT_NEAR(blue[1], 8, 1e-5);
  EXPECT_NEAR(green[2], 1 - 200 + 4, 1e-4);
  EXPECT_NEAR(blue[31], 8, 1e-5);
  std::vector<float> over(32, 100), under(32, -100), within(32, 0.5f);  // a correction of at most a tenth
  add_blend({points.data(), triangles.data(), triangle_of.data(), weights.data(), 0.1f}, 16, 32,
            {over.data(), under.data(), within.data()});
  EXPECT_NEAR(over[31], 7.7, 1e-5);
  EXPECT_NEAR(under[31], 6.3, 1e-5);
  EXPECT_NEAR(within[31], 7.5, 1e-5);
}

TEST_P(EveryTarget, NoLightIsNegative) {
  std::vector<float> sum(32), out(32, 5);
  for (std::size_t i = 0; i < 32; ++i) sum[i] = static_cast<float>(i) - 10;
  EXPECT_EQ(store_exitance(sum.data(), 2, 32, out.data()), 10u);
  for (std::size_t i = 0; i < 32; ++i) EXPECT_EQ(out[i], std::max(2 * sum[i], 0.0f));
}

INSTANTIATE_TEST_SUITE_P(TransferRows, EveryTarget, testing::ValuesIn(simd_targets()),
                         [](const auto& row) { return row.param; });

}  // namespace
}  // namespace opaline
