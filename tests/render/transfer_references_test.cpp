// Reference points and the encoded forms of a small table, against each other and against independent sums.
#include "render/input_error.h"
#include "render/transfer/harmonics.h"
#include "render/transfer/reference_fit.h"
#include "render/visibility/closest_triangle.h"
#include "tests/render/scene_fixture.h"
#include "tests/render/transfer_fixture.h"

#include <gmock/gmock.h>

#include <set>

namespace opaline {
namespace {

using testing::HasSubstr;

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
