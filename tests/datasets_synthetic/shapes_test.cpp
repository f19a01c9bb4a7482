#include "datasets_synthetic/shapes/shapes.h"

#include "datasets_synthetic/shapes/bust_field.h"
#include "model/conventions.h"
#include "render/input_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <ostream>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace opaline {
namespace {

/// Vertices at the same position become one (for the hard edges of the slab and the teapot).
std::vector<glm::uvec3> weld_by_position(const Mesh& mesh) {
  std::map<std::tuple<float, float, float>, unsigned> first;
  std::vector<unsigned> same;
  for (const glm::vec3& p : mesh.positions)
    same.push_back(first.try_emplace({p.x, p.y, p.z}, static_cast<unsigned>(same.size())).first->second);
  std::vector<glm::uvec3> welded;
  for (const glm::uvec3& t : mesh.triangles) welded.emplace_back(same[t.x], same[t.y], same[t.z]);
  return welded;
}

/// Number of the part each triangle belongs to; parts hang together by edges (a teapot's handle
/// touches the body in one vertex). The first triangle's part is 0.
std::vector<std::size_t> part_numbers(const std::vector<glm::uvec3>& triangles) {
  std::vector<std::size_t> parent(triangles.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t t) {
    while (parent[t] != t) t = parent[t] = parent[parent[t]];
    return t;
  };
  std::map<std::pair<unsigned, unsigned>, std::size_t> first;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int s = 0; s < 3; ++s) {
      const auto edge = std::minmax(triangles[t][s], triangles[t][(s + 1) % 3]);
      const std::size_t a = root(t), b = root(first.try_emplace(edge, t).first->second);
      parent[std::max(a, b)] = std::min(a, b);
    }
  for (std::size_t t = 0; t < triangles.size(); ++t) parent[t] = root(t);
  return parent;
}

struct Topology {
  std::size_t open_edges = 0;      ///< directed edges whose opposite is missing
  std::size_t repeated_edges = 0;  ///< directed edges of more than one triangle
  int euler = 0;                   ///< summed over the parts
};

Topology topology(const std::vector<glm::uvec3>& triangles) {
  const std::vector<std::size_t> parts = part_numbers(triangles);
  std::map<std::pair<unsigned, unsigned>, int> edges;
  std::set<std::pair<std::size_t, unsigned>> vertices;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int s = 0; s < 3; ++s) {
      ++edges[{triangles[t][s], triangles[t][(s + 1) % 3]}];
      vertices.insert({parts[t], triangles[t][s]});
    }
  Topology result;
  for (const auto& [edge, count] : edges) {
    result.open_edges += !edges.contains({edge.second, edge.first});
    result.repeated_edges += count > 1;
  }
  result.euler =
      static_cast<int>(vertices.size()) - static_cast<int>(edges.size() / 2) + static_cast<int>(triangles.size());
  return result;
}

std::array<glm::dvec3, 3> corners(const Mesh& mesh, const glm::uvec3& t) {
  return {glm::dvec3(mesh.positions[t.x]), glm::dvec3(mesh.positions[t.y]), glm::dvec3(mesh.positions[t.z])};
}

glm::dvec3 doubled_area(const Mesh& mesh, const glm::uvec3& t) {
  const auto [a, b, c] = corners(mesh, t);
  return glm::cross(b - a, c - a);
}

/// Divergence theorem: the sum of the signed tetrahedra from the origin.
double volume(const Mesh& mesh) {
  double sum = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const auto [a, b, c] = corners(mesh, t);
    sum += glm::dot(a, glm::cross(b, c)) / 6;
  }
  return sum;
}

double area(const Mesh& mesh) {
  double sum = 0;
  for (const glm::uvec3& t : mesh.triangles) sum += glm::length(doubled_area(mesh, t)) / 2;
  return sum;
}

/// Smallest shape quality: 1 for an equilateral triangle, 0 for a degenerate one.
double worst_quality(const Mesh& mesh) {
  double worst = 1;
  for (const glm::uvec3& t : mesh.triangles) {
    const auto [a, b, c] = corners(mesh, t);
    const double edges = glm::dot(b - a, b - a) + glm::dot(c - b, c - b) + glm::dot(a - c, a - c);
    worst = std::min(worst, 2 * std::sqrt(3.0) * glm::length(doubled_area(mesh, t)) / edges);
  }
  return worst;
}

/// How many vertex normals are within 60 degrees of the normal of every triangle they belong to.
double share_of_agreeing_normals(const Mesh& mesh) {
  std::vector<bool> agrees(mesh.positions.size(), true);
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 n = glm::normalize(doubled_area(mesh, t));
    for (int s = 0; s < 3; ++s)
      if (glm::dot(n, glm::dvec3(mesh.normals[t[s]])) < 0.5) agrees[t[s]] = false;
  }
  return static_cast<double>(std::count(agrees.begin(), agrees.end(), true)) / static_cast<double>(agrees.size());
}

std::pair<glm::vec3, glm::vec3> bounds(const Mesh& mesh) {
  glm::vec3 lo(1e30f), hi(-1e30f);
  for (const glm::vec3& p : mesh.positions) {
    lo = glm::min(lo, p);
    hi = glm::max(hi, p);
  }
  return {lo, hi};
}

/// Where the line p + s d meets the mesh, sorted (brute force over the triangles).
std::vector<double> crossings(const Mesh& mesh, const glm::dvec3& p, const glm::dvec3& d) {
  std::vector<double> hits;
  for (const glm::uvec3& t : mesh.triangles) {
    const auto [a, b, c] = corners(mesh, t);
    const glm::dmat3 system(b - a, c - a, -d);
    if (std::abs(glm::determinant(system)) < 1e-20) continue;
    const glm::dvec3 x = glm::inverse(system) * (p - a);
    if (x.x >= 0 && x.y >= 0 && x.x + x.y <= 1) hits.push_back(x.z);
  }
  std::sort(hits.begin(), hits.end());
  return hits;
}

/// The part of a mesh that its first triangle belongs to.
Mesh first_part(const Mesh& mesh) {
  const std::vector<std::size_t> parts = part_numbers(weld_by_position(mesh));
  Mesh part = mesh;
  part.triangles.clear();
  for (std::size_t t = 0; t < parts.size(); ++t)
    if (parts[t] == 0) part.triangles.push_back(mesh.triangles[t]);
  return part;
}

/// A bust 200 high, made once per count.
const Mesh& bust(int triangles) {
  static std::map<int, Mesh> made;
  const auto [slot, is_new] = made.try_emplace(triangles);
  if (is_new) slot->second = make_bust(200, triangles);
  return slot->second;
}

struct Case {
  std::string name;
  Mesh (*make)(int triangles);
  std::vector<int> counts;
  int euler;
  bool welded_by_index;
  double agreeing_normals;  ///< share that must be within 60 degrees of their faces
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class EveryShape : public testing::TestWithParam<Case> {};

TEST_P(EveryShape, IsAClosedManifoldOfItsGenus) {
  for (const int count : GetParam().counts) {
    const Mesh mesh = GetParam().make(count);
    const Topology t = topology(GetParam().welded_by_index ? mesh.triangles : weld_by_position(mesh));
    EXPECT_EQ(t.open_edges, 0u) << count;
    EXPECT_EQ(t.repeated_edges, 0u) << count;
    EXPECT_EQ(t.euler, GetParam().euler) << count;
    EXPECT_GT(volume(mesh), 0) << count;
  }
}

TEST_P(EveryShape, HonoursTheTriangleCount) {
  for (const int count : GetParam().counts) {
    const auto made = static_cast<double>(GetParam().make(count).triangles.size());
    EXPECT_GE(made, 0.5 * count);
    EXPECT_LE(made, 2.0 * count);
  }
}

TEST_P(EveryShape, HasUnitNormalsThatAgreeWithItsFaces) {
  const Mesh mesh = GetParam().make(GetParam().counts.back());
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  for (const glm::vec3& n : mesh.normals) ASSERT_NEAR(glm::length(n), 1, 1e-5);
  EXPECT_GE(share_of_agreeing_normals(mesh), GetParam().agreeing_normals);
}

TEST_P(EveryShape, HasNoZeroAreaTriangles) {
  for (const int count : GetParam().counts) {
    Mesh mesh = GetParam().make(count);
    EXPECT_GT(worst_quality(mesh), 0.01) << count;
    const auto [lo, hi] = bounds(mesh);
    const double diagonal = glm::length(glm::dvec3(hi - lo));
    for (const glm::uvec3& t : mesh.triangles)
      ASSERT_GT(glm::length(doubled_area(mesh, t)) / 2, 1e-12 * diagonal * diagonal);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Shapes, EveryShape,
    testing::Values(Case{"sphere", [](int n) { return make_sphere(7, n); }, {20, 80, 333, 5000}, 2, true, 1},
                    Case{"slab",
                         [](int n) {
                           return make_slab({40, 25, 3}, n);
                         },
                         {12, 500, 9000},
                         2,
                         false,
                         1},
                    Case{"thin_slab",
                         [](int n) {
                           return make_slab({9, 8, 0.1}, n);
                         },
                         {100, 3000},
                         2,
                         false,
                         1},
                    Case{"torus", [](int n) { return make_torus(5, 1.5, n); }, {18, 700, 8000}, 0, true, 1},
                    Case{"teapot", [](int n) { return make_teapot(60, n); }, {256, 1000, 20000}, 6, false, 1},
                    Case{"bust", [](int n) { return bust(n); }, {4000, 60000}, 2, true, 0.999}),
    [](const auto& tested) { return tested.param.name; });

TEST(EveryShapeTwice, IsTheSame) {
  const Mesh pairs[4][2] = {{make_bust(200, 4000), make_bust(200, 4000)},
                            {make_sphere(1), make_sphere(1)},
                            {make_torus(2, 1), make_torus(2, 1)},
                            {make_teapot(1), make_teapot(1)}};
  for (const auto& [a, b] : pairs) {
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.normals, b.normals);
    EXPECT_EQ(a.triangles, b.triangles);
  }
}

TEST(Sphere, ConvergesToTheClosedFormsAtSecondOrder) {
  const double r = 3, exact_volume = 4.0 / 3 * pi * r * r * r, exact_area = 4 * pi * r * r;
  const Mesh coarse = make_sphere(r, 20 * 8 * 8), fine = make_sphere(r, 20 * 16 * 16);
  EXPECT_NEAR(volume(fine) / exact_volume, 1, 0.003);
  EXPECT_NEAR(area(fine) / exact_area, 1, 0.002);
  EXPECT_NEAR((exact_volume - volume(coarse)) / (exact_volume - volume(fine)), 4, 0.1);
  EXPECT_NEAR((exact_area - area(coarse)) / (exact_area - area(fine)), 4, 0.1);
}

TEST(Sphere, HasNearlyEqualTrianglesOnItsSurface) {
  const Mesh mesh = make_sphere(2, 20 * 25 * 25);
  double smallest = 1e30, largest = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    smallest = std::min(smallest, glm::length(doubled_area(mesh, t)));
    largest = std::max(largest, glm::length(doubled_area(mesh, t)));
  }
  EXPECT_LT(largest / smallest, 1.6);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    ASSERT_NEAR(glm::length(mesh.positions[v]), 2, 1e-6);
    ASSERT_NEAR(glm::length(mesh.positions[v] / 2.0f - mesh.normals[v]), 0, 1e-6);
  }
}

TEST(Slab, IsTheBoxItSays) {
  const Mesh mesh = make_slab({4, 2, 0.5}, 3000);
  const auto [lo, hi] = bounds(mesh);
  EXPECT_EQ(lo, glm::vec3(-2, -1, -0.5));
  EXPECT_EQ(hi, glm::vec3(2, 1, 0));
  EXPECT_NEAR(volume(mesh), 4, 1e-5);
  EXPECT_NEAR(area(mesh), 2 * (8 + 2 + 1), 1e-4);
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 n = glm::normalize(doubled_area(mesh, t));
    for (int s = 0; s < 3; ++s) ASSERT_GT(glm::dot(n, glm::dvec3(mesh.normals[t[s]])), 0.9999);
  }
}

TEST(Slab, HasNearlySquareCells) {
  // Two equal right triangles to a square: quality sqrt(3) / 2 = 0.866.
  EXPECT_GT(worst_quality(make_slab({40, 25, 10}, 9000)), 0.85);
}

TEST(Torus, ConvergesToTheClosedFormsAtSecondOrder) {
  const double major = 4, minor = 1, exact_volume = 2 * pi * pi * major * minor * minor,
               exact_area = 4 * pi * pi * major * minor;
  const Mesh coarse = make_torus(major, minor, 2 * 20 * 80), fine = make_torus(major, minor, 2 * 40 * 160);
  EXPECT_NEAR(volume(fine) / exact_volume, 1, 0.006);
  EXPECT_NEAR(area(fine) / exact_area, 1, 0.003);
  EXPECT_NEAR((exact_volume - volume(coarse)) / (exact_volume - volume(fine)), 4, 0.1);
  EXPECT_NEAR((exact_area - area(coarse)) / (exact_area - area(fine)), 4, 0.2);
}

TEST(Torus, LiesOnItsImplicitSurface) {
  for (const glm::vec3& p : make_torus(4, 1, 2000).positions)
    ASSERT_NEAR(std::hypot(std::hypot(p.x, p.y) - 4, p.z), 1, 1e-5);
}

TEST(Teapot, HasThePublishedProportions) {
  const double unit = 10 / 3.15;  // Newell's teapot is 3.15 high
  const auto [lo, hi] = bounds(make_teapot(10));
  EXPECT_NEAR(lo.y, -5, 1e-5);
  EXPECT_NEAR(hi.y, 5, 1e-5);
  EXPECT_NEAR(lo.x, -3 * unit, 1e-3);     // handle
  EXPECT_NEAR(hi.x, 3.434 * unit, 5e-3);  // lip of the spout
  EXPECT_NEAR(lo.z, -2 * unit, 1e-4);
  EXPECT_NEAR(hi.z, 2 * unit, 1e-4);
}

TEST(Teapot, HasThePublishedSilhouette) {
  const double unit = 3.15;
  const Mesh mesh = make_teapot(unit, 60000);
  const auto front = [&](double z) {  // where a line along the depth, between handle and spout, leaves the mesh
    return crossings(mesh, {1e-4, z - unit / 2, 0}, {0, 0, 1}).back();
  };
  EXPECT_NEAR(front(0.9), 2, 0.002);     // widest
  EXPECT_NEAR(front(2.4), 1.5, 0.005);   // below the rim
  EXPECT_NEAR(front(0.15), 1.5, 0.005);  // foot
  EXPECT_NEAR(front(2.7), 0.2, 0.005);   // neck of the knob
}

/// The body alone, by Pappus on the Bezier profile, with the area of Newell's near-circle.
TEST(Teapot, HasTheVolumeOfItsProfile) {
  const double profile[7][4][2] = {{{0, 3.15}, {0.8, 3.15}, {0, 2.85}, {0.2, 2.7}},
                                   {{0.2, 2.7}, {0.4, 2.55}, {1.3, 2.55}, {1.3, 2.4}},
                                   {{1.3, 2.4}, {4 / 3.0, 2.4}, {4.1 / 3, 2.4}, {1.4, 2.4}},
                                   {{1.4, 2.4}, {1.3375, 2.53125}, {1.4375, 2.53125}, {1.5, 2.4}},
                                   {{1.5, 2.4}, {1.75, 1.875}, {2, 1.35}, {2, 0.9}},
                                   {{2, 0.9}, {2, 0.45}, {1.5, 0.225}, {1.5, 0.15}},
                                   {{1.5, 0.15}, {1.5, 0.075}, {1.425, 0}, {0, 0}}};
  double body = 0;
  for (const auto& curve : profile) {
    const auto at = [&](double t, int k) {
      const double s = 1 - t;
      return s * s * s * curve[0][k] + 3 * s * s * t * curve[1][k] + 3 * s * t * t * curve[2][k] +
             t * t * t * curve[3][k];
    };
    for (int i = 0; i < 2000; ++i) {
      const double r = at((i + 0.5) / 2000, 0);
      body += pi * r * r * (at(i / 2000.0, 1) - at((i + 1) / 2000.0, 1));
    }
  }
  // Rings are not quite circles: integrate x dy of the quarter (1, 0), (1, k), (k, 1), (0, 1).
  double quarter = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto y = [](double t) { return 3 * (1 - t) * (1 - t) * t * 0.56 + 3 * (1 - t) * t * t + t * t * t; };
    const double t = (i + 0.5) / 2000, x = y(1 - t);
    quarter += x * (y((i + 1) / 2000.0) - y(i / 2000.0));
  }
  const Mesh mesh = make_teapot(3.15, 60000);
  EXPECT_NEAR(volume(first_part(mesh)) / (body * quarter * 4 / pi), 1, 1e-3);
}

TEST(Bust, IsAsHighAsAskedAndSymmetric) {
  const auto [lo, hi] = bounds(bust(60000));
  EXPECT_NEAR(hi.y - lo.y, 200, 0.1);
  EXPECT_NEAR(hi.y + lo.y, 0, 0.1);
  EXPECT_NEAR(hi.x + lo.x, 0, 0.5);
}

TEST(Bust, LiesOnTheZeroSetOfItsField) {
  const double to_mm = bust_height / 200, middle = (bust_crown + bust_base) / 2;
  double worst = 0;
  for (const glm::vec3& p : bust(60000).positions)
    worst = std::max(worst, std::abs(bust_field(to_mm * glm::dvec3(p) + glm::dvec3(0, middle, 0))));
  EXPECT_LT(worst, 1e-4 * bust_height);
}

TEST(Bust, HasEarsOfTheStatedThickness) {
  for (const int count : {20000, 60000}) {
    const Mesh& mesh = bust(count);
    EarPlate ear = bust_ear_plate(200);
    EXPECT_DOUBLE_EQ(ear.thickness, 0.012 * 200);
    for (int side = 0; side < 2; ++side) {
      std::vector<double> hits = crossings(mesh, ear.centre, ear.normal);
      std::erase_if(hits, [&](double s) { return std::abs(s) > 2 * ear.thickness; });
      ASSERT_EQ(hits.size(), 2u) << count;
      EXPECT_NEAR(hits[1] - hits[0], ear.thickness, 0.1 * ear.thickness) << count;
      EXPECT_NEAR((hits[1] + hits[0]) / 2, 0, 0.1 * ear.thickness) << count;
      ear.centre.x = -ear.centre.x;
      ear.normal.x = -ear.normal.x;
    }
  }
}

TEST(Bust, HasAirBehindItsEars) {
  const Mesh& mesh = bust(60000);
  const EarPlate ear = bust_ear_plate(200);
  // From the front the plate is seen past the head, and nothing else stands behind it.
  EXPECT_EQ(crossings(mesh, ear.centre, {0, 0, 1}).size(), 2u);
}

TEST(Bust, LooksForwardWithANose) {
  const Mesh& mesh = bust(60000);
  const glm::vec3* tip = &*std::max_element(mesh.positions.begin(), mesh.positions.end(),
                                            [](const glm::vec3& a, const glm::vec3& b) { return a.z < b.z; });
  EXPECT_NEAR(tip->x, 0, 2);
  const auto depth = [&](double x, double y) { return crossings(mesh, {x, y, 0}, {0, 0, 1}).back(); };
  const double y = tip->y + 8;  // half way up the bridge
  EXPECT_GT(depth(0, y), depth(5, y) + 3);
  EXPECT_GT(depth(0, y), depth(-5, y) + 3);
  // The eye lies deeper than the brow above it and the bridge beside it.
  const double eye = tip->y + 22;
  EXPECT_LT(depth(13, eye), depth(13, eye + 14));
  EXPECT_LT(depth(13, eye), depth(0, eye));
}

Mesh make_from_json(const std::string& name, const nlohmann::json& keys) {
  JsonObject object(keys, "scene.json", "/objects/0");
  return synthetic_shapes().at(name).make(object);
}

TEST(ShapeLibrary, HasARowForEveryShape) {
  std::set<std::string> names;
  for (const auto& [name, maker] : synthetic_shapes()) {
    names.insert(name);
    EXPECT_FALSE(maker.summary.empty());
    EXPECT_NE(maker.summary.find("triangles"), std::string::npos) << name;
  }
  EXPECT_EQ(names, (std::set<std::string>{"bust", "fish", "slab", "sphere", "teapot", "torus"}));
}

TEST(ShapeLibrary, ReadsItsKeys) {
  EXPECT_EQ(make_from_json("sphere", {{"radius", 3}, {"triangles", 500}}).positions, make_sphere(3, 500).positions);
  EXPECT_EQ(make_from_json("slab", {{"size", {1, 2, 3}}, {"triangles", 500}}).positions,
            make_slab({1, 2, 3}, 500).positions);
  EXPECT_EQ(make_from_json("torus", {{"major_radius", 3}, {"minor_radius", 1}}).positions, make_torus(3, 1).positions);
  EXPECT_EQ(make_from_json("teapot", {{"height", 3}, {"triangles", 500}}).positions, make_teapot(3, 500).positions);
  EXPECT_EQ(make_from_json("bust", {{"height", 3}, {"triangles", 5000}}).positions, make_bust(3, 5000).positions);
}

TEST(ShapeLibrary, RefusesBadKeys) {
  EXPECT_THROW(make_from_json("sphere", nlohmann::json::object()), InputError);
  EXPECT_THROW(make_from_json("sphere", {{"radius", -1}}), InputError);
  EXPECT_THROW(make_from_json("sphere", {{"radius", 1}, {"triangles", 3}}), InputError);
  EXPECT_THROW(make_from_json("slab", {{"size", {1, 0, 1}}}), InputError);
  EXPECT_THROW(make_from_json("torus", {{"major_radius", 1}, {"minor_radius", 2}}), InputError);
}

}  // namespace
}  // namespace opaline
