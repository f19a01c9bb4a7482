#include "render/scene/mesh.h"

#include "render/input_error.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

constexpr double zero_area_fraction = 1e-14;  ///< of the squared bounding diagonal

bool is_finite(const glm::vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
bool is_finite(const glm::vec2& v) { return std::isfinite(v.x) && std::isfinite(v.y); }

/// How many elements fail a test and which is the first.
struct Failures {
  std::size_t count = 0, first = 0;
  void add(std::size_t index) {
    if (count++ == 0) first = index;
  }
  std::string describe(const std::string& singular, const std::string& plural) const {
    return std::to_string(count) + " " + (count == 1 ? singular : plural) + " (the first: " + std::to_string(first) +
           ", counted from 0)";
  }
};

template <typename Vector>
void check_finite(const std::vector<Vector>& values, const std::string& what, const std::string& file,
                  const std::string& place) {
  Failures bad;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!is_finite(values[i])) bad.add(i);
  }
  if (bad.count == 0) return;
  throw InputError(file, place,
                   "the " + what + " of " + bad.describe("vertex", "vertices") + " is NaN or infinite; mend the mesh");
}

void check_indices(const Mesh& mesh, const std::string& file, const std::string& place) {
  Failures bad;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3& v = mesh.triangles[t];
    if (std::max({v.x, v.y, v.z}) >= mesh.positions.size()) bad.add(t);
  }
  if (bad.count == 0) return;
  throw InputError(file, place,
                   bad.describe("triangle", "triangles") + " name vertices that do not exist; there are " +
                       std::to_string(mesh.positions.size()));
}

double triangle_area(const Mesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
  return 0.5 * glm::length(glm::cross(b - a, c - a));
}

double smallest_area(const Mesh& mesh) {
  glm::dvec3 low(mesh.positions[0]), high(mesh.positions[0]);
  for (const glm::vec3& p : mesh.positions) {
    low = glm::min(low, glm::dvec3(p));
    high = glm::max(high, glm::dvec3(p));
  }
  return zero_area_fraction * glm::dot(high - low, high - low);
}

template <typename T>
void keep(std::vector<T>& values, const std::vector<std::uint32_t>& kept) {
  if (values.empty()) return;
  std::vector<T> result;
  for (std::uint32_t i : kept) result.push_back(values[i]);
  values = std::move(result);
}

/// Vertices that only dropped triangles used would still count for bounds and samples.
void remove_unused_vertices(Mesh& mesh) {
  constexpr std::uint32_t unused = 0xffffffffu;
  std::vector<std::uint32_t> renumbered(mesh.positions.size(), unused), kept;
  for (glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      std::uint32_t& number = renumbered[triangle[i]];
      if (number == unused) {
        number = static_cast<std::uint32_t>(kept.size());
        kept.push_back(triangle[i]);
      }
      triangle[i] = number;
    }
  }
  keep(mesh.positions, kept);
  keep(mesh.normals, kept);
  keep(mesh.uvs, kept);
}

std::size_t drop_zero_area(Mesh& mesh, double limit, const std::string& file, const std::string& place) {
  const std::size_t before = mesh.triangles.size();
  std::erase_if(mesh.triangles, [&](const glm::uvec3& t) { return !(triangle_area(mesh, t) > limit); });
  if (mesh.triangles.empty()) throw InputError(file, place, "the mesh is empty: all its triangles have zero area");
  if (mesh.triangles.size() < before) remove_unused_vertices(mesh);
  return before - mesh.triangles.size();
}

void reject_zero_area(const Mesh& mesh, double limit, const std::string& file, const std::string& place) {
  Failures bad;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!(triangle_area(mesh, mesh.triangles[t]) > limit)) bad.add(t);
  }
  if (bad.count == 0) return;
  throw InputError(file, place,
                   bad.describe("triangle", "triangles") +
                       " with zero area; mend the mesh, or set \"zero_area_triangles\": \"drop\"");
}

void check_array_sizes(const Mesh& mesh, const std::string& file, const std::string& place) {
  const std::size_t n = mesh.positions.size();
  const bool agree = (mesh.normals.empty() || mesh.normals.size() == n) && (mesh.uvs.empty() || mesh.uvs.size() == n);
  if (!agree) throw InputError(file, place, "the mesh does not have one normal and one uv for each vertex");
}

}  // namespace

std::size_t validate_mesh(Mesh& mesh, ZeroAreaTriangles policy, const std::string& file, const std::string& place) {
  if (mesh.triangles.empty()) throw InputError(file, place, "the mesh is empty: it has no triangles");
  check_array_sizes(mesh, file, place);
  check_finite(mesh.positions, "position", file, place);
  check_finite(mesh.normals, "normal", file, place);
  check_finite(mesh.uvs, "texture coordinate", file, place);
  check_indices(mesh, file, place);
  const double limit = smallest_area(mesh);
  if (policy == ZeroAreaTriangles::drop) return drop_zero_area(mesh, limit, file, place);
  reject_zero_area(mesh, limit, file, place);
  return 0;
}

double surface_area(const Mesh& mesh) {
  double sum = 0;
  for (const glm::uvec3& t : mesh.triangles) sum += triangle_area(mesh, t);
  return sum;
}

}  // namespace opaline
