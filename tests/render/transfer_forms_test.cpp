// What is kept of a transfer table: quantiser, harmonics, reference points, and the sums over stored rows.
#include "model/quadrature.h"
#include "model/simd.h"
#include "render/input_error.h"
#include "render/transfer/harmonics.h"
#include "render/transfer/reference_fit.h"
#include "render/visibility/closest_triangle.h"
#include "tests/render/scene_fixture.h"
#include "tests/render/transfer_fixture.h"

#include <gmock/gmock.h>

#include <map>
#include <set>

namespace opaline {
namespace {

using testing::HasSubstr;

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

// --- reference points -------------------------------------------------------------------------------

TEST(ClosestTriangle, IsTheNearestOfAllThatFaceThePointsWay) {
  const Mesh mesh = make_torus(4, 1, 300);
  const ClosestTriangle search(mesh.positions, mesh.triangles);
  std::mt19937 random(6);
  for (int i = 0; i < 200; ++i) {
    const glm::vec3 p(5.0 * test::random_direction(random)), normal(test::random_direction(random));
    double nearest = 1e30;
    for (const glm::uvec3& t : mesh.triangles) {
      const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
      if (glm::dot(glm::cross(b - a, c - a), glm::dvec3(normal)) <= 0) continue;
      for (int u = 0; u <= 20; ++u)
        for (int v = 0; u + v <= 20; ++v)
          nearest = std::min(nearest, glm::length(a + u / 20.0 * (b - a) + v / 20.0 * (c - a) - glm::dvec3(p)));
    }
    const TrianglePlace place = search.find(p, normal);
    EXPECT_LE(place.distance, nearest + 1e-6);
    EXPECT_GT(place.distance, nearest - 0.05);
    EXPECT_NEAR(place.weights.x + place.weights.y + place.weights.z, 1, 1e-12);
  }
}

// Corners, edges, inside, and triangles that are a line, against a fine grid of barycentrics.
TEST(ClosestTriangle, FindsThePointOfATriangleOfAnyKind) {
  std::mt19937 random(7);
  for (int i = 0; i < 600; ++i) {
    const glm::dvec3 p(2.0 * test::random_direction(random)), a(test::random_direction(random)),
        b = i % 6 == 0 ? a : glm::dvec3(test::random_direction(random)),
        c = i % 6 == 1   ? 0.5 * (a + b)
            : i % 6 == 2 ? b
                         : glm::dvec3(test::random_direction(random));
    double nearest = 1e30;
    for (int u = 0; u <= 60; ++u)
      for (int v = 0; u + v <= 60; ++v)
        nearest = std::min(nearest, glm::length(a + u / 60.0 * (b - a) + v / 60.0 * (c - a) - p));
    const glm::dvec3 w = closest_on_triangle(p, a, b, c);
    EXPECT_NEAR(w.x + w.y + w.z, 1, 1e-12);
    EXPECT_GE(std::min({w.x, w.y, w.z}), 0);
    const double distance = glm::length(w.x * a + w.y * b + w.z * c - p);
    EXPECT_LE(distance, nearest + 1e-9) << "kind " << i % 6;
    EXPECT_GT(distance, nearest - 0.02) << "kind " << i % 6;
  }
}

TEST(ClosestTriangle, ABoundOfTheDistanceChangesNothing) {
  const Mesh mesh = make_torus(4, 1, 300);
  const ClosestTriangle search(mesh.positions, mesh.triangles);
  std::mt19937 random(8);
  for (int i = 0; i < 100; ++i) {
    const glm::vec3 p(5.0 * test::random_direction(random));
    const TrianglePlace free = search.find_within(p, 1e30);
    for (const double bound : {free.distance, 2 * free.distance, 0.1 * free.distance, 0.0}) {
      const TrianglePlace bounded = search.find_within(p, bound);
      EXPECT_EQ(bounded.distance, free.distance) << bound;
      EXPECT_EQ(bounded.position, free.position) << bound;
    }
  }
}

TEST(ReferenceMesh, IsASubsetOfTheVerticesInWhichEachLiesNearItsTriangle) {
  const Mesh mesh = make_teapot(10, 4000);
  const TransferVertices vertices(mesh, 1);
  const ReferenceMesh few = make_reference_mesh(vertices, 200);
  EXPECT_GT(few.points.size(), 100u);
  EXPECT_LT(few.points.size(), 400u);
  double squares = 0;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const glm::uvec3 t = few.triangles[few.triangle_of[v]];
    const glm::dvec2 w = few.weights[v];
    const auto corner = [&](std::uint32_t k) { return glm::dvec3(vertices.positions[few.points[k]]); };
    const glm::dvec3 p = w.x * corner(t.x) + w.y * corner(t.y) + (1 - w.x - w.y) * corner(t.z);
    squares += std::pow(glm::length(p - glm::dvec3(vertices.positions[v])), 2);
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(vertices.size())), 0.2);
}

/// A table of 100 directions of a small object.
class Forms : public testing::Test {
 protected:
  static const test::TableFixture& fixture() {
    static const test::TableFixture f(
        test::make_scene(make_torus(4, 1.5, 2400), test::library_material("marble"), 12, 8), test::table_settings(100),
        2400);
    return f;
  }
  static double error(const EncodedTransfer& t) { return test::encoding_error(fixture(), t); }
  static EncodedTransfer references(std::size_t points, int order, ReferenceWeights weights,
                                    ReferenceSelection selection = ReferenceSelection::shape) {
    return encode_references(fixture().table, fixture().nodes, fixture().vertices,
                             {.points = points, .selection = selection, .weights = weights, .order = order});
  }
  static Remainder remainder() { return Remainder(fixture().table, HarmonicFit(fixture().table, fixture().nodes, 3)); }
};

TEST_F(Forms, FloatsAreExactAndCodesNearlySo) {
  EXPECT_LT(error(encode_rows(fixture().table, RowStorage::f32)), 1e-6);
  const EncodedTransfer codes = encode_rows(fixture().table, RowStorage::code8);
  EXPECT_EQ(codes.bytes_per_vertex(), 300);
  EXPECT_LT(error(codes), 4e-3);  // 48 dB
}

// The best that coefficients can do, by the projection in double on a few vertices' own functions.
TEST_F(Forms, HarmonicsAreTheLeastSquaresFit) {
  std::vector<glm::dvec3> directions;
  for (std::size_t j = 0; j < 100; ++j) directions.push_back(fixture().nodes.directions[j]);
  std::vector<double> matrix;
  ASSERT_TRUE(harmonic_projection(4, directions, matrix));
  const EncodedTransfer t = encode_harmonics(fixture().table, fixture().nodes, 4);
  Counters counters;
  const VertexExitance b = t.exitance({{directions[42], 0, Rgb(1)}}, fixture().nodes, counters);
  const std::vector<double> y = harmonics(4, directions[42]);
  for (std::size_t v = 0; v < fixture().table.vertices; v += 7) {
    double value = 0;
    for (std::size_t i = 0; i < 16; ++i)
      for (std::size_t j = 0; j < 100; ++j)
        value += y[i] * matrix[i * 100 + j] * static_cast<double>(fixture().table.row(3 * j)[v]);
    EXPECT_NEAR(static_cast<double>(b.channel[0][v]), std::max(value, 0.0), 2e-4);
  }
}

TEST_F(Forms, HarmonicsGetBetterWithTheirOrder) {
  double before = 1;
  for (const int order : {1, 2, 3, 5, 7}) {
    const EncodedTransfer t = encode_harmonics(fixture().table, fixture().nodes, order);
    EXPECT_EQ(t.bytes_per_vertex(), 6.0 * order * order);
    const double now = error(t);
    EXPECT_LT(now, before) << order;
    before = now;
  }
  EXPECT_THAT(test::message_of([&] { encode_harmonics(fixture().table, fixture().nodes, 11); }),
              HasSubstr("100 directions don't determine 121 coefficients"));
}

TEST_F(Forms, ReferencePointsBeatTheHarmonicsTheyAreCompletedBy) {
  const double alone = error(encode_harmonics(fixture().table, fixture().nodes, 3));
  double before = alone;
  for (const std::size_t points : {50u, 150u, 400u}) {
    const EncodedTransfer t = references(points, 3, ReferenceWeights::barycentric);
    const double now = error(t);
    EXPECT_LT(now, before) << points;
    before = now;
    // Three colours: 9 bytes of harmonics each, 4 of weights, 2 of the triangle's number, and the points' own share.
    const double share = static_cast<double>(t.references->points.size()) / static_cast<double>(t.vertices());
    EXPECT_NEAR(t.bytes_per_vertex(), 3 * 9 + 4 + 2 + share * (300 + 4 + 12), 1.5 + 16 * share);
  }
  EXPECT_LT(before, alone / 4);
}

TEST_F(Forms, LeastSquaresWeightsAreNoWorse) {
  EXPECT_LT(error(references(100, 3, ReferenceWeights::least_squares)),
            error(references(100, 3, ReferenceWeights::barycentric)));
}

TEST_F(Forms, TheRemainderIsOrthogonalToTheHarmonics) {
  const Remainder rest = remainder();
  std::vector<glm::dvec3> directions;
  for (std::size_t j = 0; j < 100; ++j) directions.push_back(fixture().nodes.directions[j]);
  std::vector<double> matrix;
  ASSERT_TRUE(harmonic_projection(3, directions, matrix));
  for (std::size_t v = 0; v < fixture().table.vertices; v += 31)
    for (std::size_t i = 0; i < 9; ++i) {
      double coefficient = 0;
      for (std::size_t j = 0; j < 100; ++j)
        coefficient += matrix[i * 100 + j] * static_cast<double>(rest.rest(v)[3 * j + 1]);
      EXPECT_NEAR(coefficient, 0, 1e-5);
    }
}

TEST_F(Forms, PointsAreAddedWhereTheyHelp) {
  const auto squares = [](const ReferenceMesh& mesh, const Remainder& rest) {
    double sum = 0;
    for (std::size_t v = 0; v < mesh.triangle_of.size(); ++v) sum += squares_left(rest, mesh, v);
    return sum;
  };
  const Remainder rest = remainder();
  ReferenceMesh mesh = make_reference_mesh(fixture().vertices, 100);
  const std::size_t before = mesh.points.size();
  double left = squares(mesh, rest);
  for (const std::size_t more : {20u, 40u, 80u}) {
    add_points(rest, before + more, mesh);
    ASSERT_EQ(mesh.points.size(), before + more);
    EXPECT_EQ(std::set<std::uint32_t>(mesh.points.begin(), mesh.points.end()).size(), mesh.points.size());
    const double now = squares(mesh, rest);
    EXPECT_LT(now, left) << more;
    left = now;
  }
  for (std::size_t v = 0; v < mesh.weights.size(); ++v) {  // still places in a triangle
    const glm::dvec2 w = mesh.weights[v];
    EXPECT_GE(std::min({w.x, w.y, 1 - w.x - w.y}), -1e-9);
  }
  for (const std::size_t v : {std::size_t{3}, std::size_t{400}, std::size_t{900}}) {
    const glm::uvec3 t = mesh.triangles[mesh.triangle_of[v]];
    const glm::dvec3 w(mesh.weights[v], 1 - mesh.weights[v].x - mesh.weights[v].y);
    double sum = 0;
    for (std::size_t r = 0; r < fixture().table.rows(); ++r) {
      const auto own = [&](std::uint32_t u) { return static_cast<double>(fixture().table.row(r)[u]); };
      double unheld = static_cast<double>(rest.rest(v)[r]), value = own(static_cast<std::uint32_t>(v));
      const double factor = 0.03 / (value / static_cast<double>(rest.largest(v)) + 0.02);
      for (int k = 0; k < 3; ++k) {
        unheld -= w[k] * static_cast<double>(rest.rest(mesh.points[t[k]])[r]);
        value -= w[k] * own(mesh.points[t[k]]);
      }
      sum += unheld * unheld + factor * factor * value * value;
    }
    EXPECT_NEAR(squares_left(rest, mesh, v), sum, 1e-3 * sum + 1e-12);
  }
  for (std::size_t i = before; i < mesh.points.size(); ++i) {  // a new point is itself
    const std::uint32_t v = mesh.points[i];
    const glm::uvec3 t = mesh.triangles[mesh.triangle_of[v]];
    const glm::dvec3 w(mesh.weights[v], 1 - mesh.weights[v].x - mesh.weights[v].y);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(w[k], mesh.points[t[k]] == v ? 1 : 0, 1e-9);
  }
  fit_weights(rest, mesh);
  EXPECT_LT(squares(mesh, rest), left);
}

TEST_F(Forms, PointsThatFollowTheTransferAreWorthMore) {
  const EncodedTransfer by_shape = references(150, 3, ReferenceWeights::barycentric),
                        by_transfer = references(by_shape.references->points.size(), 3, ReferenceWeights::barycentric,
                                                 ReferenceSelection::transfer),
                        fitted = references(by_shape.references->points.size(), 3, ReferenceWeights::least_squares,
                                            ReferenceSelection::transfer);
  EXPECT_EQ(by_transfer.references->points.size(), by_shape.references->points.size());
  EXPECT_LT(error(by_transfer), error(by_shape));
  EXPECT_LT(error(fitted), 0.8 * error(by_transfer));
}

// Nodes whose light a vertex sees least of: errors against the vertices' values there.
TEST_F(Forms, BoundedCorrectionsSpareTheDark) {
  EncodedTransfer t = references(150, 3, ReferenceWeights::least_squares, ReferenceSelection::transfer);
  EXPECT_LE(t.references->correction, 1);
  const auto dark_error = [&] {
    double squares = 0, norm = 0;
    Counters counters;
    for (std::size_t j = 0; j < 100; j += 9) {
      const VertexExitance b = t.exitance({{fixture().nodes.directions[j], 0, Rgb(1)}}, fixture().nodes, counters);
      for (std::size_t v = 0; v < t.vertices(); ++v) {
        const auto q = static_cast<double>(fixture().table.row(3 * j)[v]);
        if (q > 0.05) continue;
        squares += std::pow(static_cast<double>(b.channel[0][v]) - q, 2), norm += q * q;
      }
    }
    return std::sqrt(squares / norm);
  };
  const double bounded = dark_error(), all = error(t);
  t.references->correction = 1e6f;
  EXPECT_LT(bounded, 0.9 * dark_error());
  EXPECT_LT(all, 1.02 * error(t));
}

TEST_F(Forms, ReferencePointsKeepWhatTheyHold) {
  const EncodedTransfer t = references(100, 3, ReferenceWeights::barycentric);
  Counters counters;
  const VertexExitance b = t.exitance({{fixture().nodes.directions[11], 0, Rgb(1)}}, fixture().nodes, counters);
  double squares = 0, norm = 0;
  for (const std::uint32_t v : t.references->points) {
    const auto q = static_cast<double>(fixture().table.row(33)[v]);
    squares += std::pow(static_cast<double>(b.channel[0][v]) - q, 2), norm += q * q;
  }
  EXPECT_LT(std::sqrt(squares / norm), 0.01);
}

}  // namespace
}  // namespace opaline
