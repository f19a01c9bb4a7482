#include "render/visibility/closest_triangle.h"

#include "model/check.h"
#include "render/input_error.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <limits>

namespace opaline {

struct ClosestTriangle::Handles {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  ~Handles() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
};

namespace {

struct Search {
  const std::vector<glm::vec3>& positions;
  const std::vector<glm::uvec3>& triangles;
  glm::dvec3 point, normal;  ///< no normal: all triangles
  bool found = false;
  TrianglePlace best{};

  bool look(std::uint32_t triangle, float& radius) {
    const glm::uvec3 t = triangles[triangle];
    const glm::dvec3 a(positions[t.x]), b(positions[t.y]), c(positions[t.z]);
    if (normal != glm::dvec3(0) && glm::dot(glm::cross(b - a, c - a), normal) <= 0) return false;
    const glm::dvec3 w = closest_on_triangle(point, a, b, c);
    const glm::dvec3 position = w.x * a + w.y * b + w.z * c;
    const double distance = glm::length(position - point);
    if (found && distance >= best.distance) return false;
    found = true;
    best = {triangle, w, position, distance};
    radius = static_cast<float>(distance);
    return true;
  }
};

bool visit(RTCPointQueryFunctionArguments* arguments) {
  return static_cast<Search*>(arguments->userPtr)->look(arguments->primID, arguments->query->radius);
}

}  // namespace

glm::dvec3 closest_on_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap), d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp),
               d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  // Proportional to the areas that p's foot cuts off; where one is not positive, the foot on that edge is nearest.
  const double of_a = d3 * d6 - d5 * d4, of_b = d5 * d2 - d1 * d6, of_c = d1 * d4 - d3 * d2;
  if (of_c <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  if (of_b <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double to_c = d4 - d3, to_b = d5 - d6;
  if (of_a <= 0 && to_c >= 0 && to_b >= 0 && to_c + to_b > 0) return {0, to_b / (to_c + to_b), to_c / (to_c + to_b)};
  return glm::dvec3(of_a, of_b, of_c) / (of_a + of_b + of_c);
}

ClosestTriangle::ClosestTriangle(std::vector<glm::vec3> positions, std::vector<glm::uvec3> triangles)
    : positions_(std::move(positions)), triangles_(std::move(triangles)), handles_(std::make_unique<Handles>()) {
  OPALINE_CHECK(!triangles_.empty());
  handles_->device = rtcNewDevice(nullptr);
  if (!handles_->device) throw MachineError("Embree could not be started");
  handles_->scene = rtcNewScene(handles_->device);
  RTCGeometry geometry = rtcNewGeometry(handles_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3),
                                           positions_.size());
  void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(glm::uvec3),
                                          triangles_.size());
  if (!vertices || !indices) {
    rtcReleaseGeometry(geometry);
    throw MachineError("not enough memory for the search of triangles");
  }
  std::copy(positions_.begin(), positions_.end(), static_cast<glm::vec3*>(vertices));
  std::copy(triangles_.begin(), triangles_.end(), static_cast<glm::uvec3*>(indices));
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(handles_->scene, geometry, 0);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(handles_->scene);
}

ClosestTriangle::~ClosestTriangle() = default;

TrianglePlace ClosestTriangle::find(const glm::vec3& point, const glm::vec3& normal, float radius, bool& found) const {
  Search search{positions_, triangles_, glm::dvec3(point), glm::dvec3(normal)};
  RTCPointQuery query{point.x, point.y, point.z, 0, radius};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(handles_->scene, &query, &context, visit, &search);
  found = search.found;
  return search.best;
}

TrianglePlace ClosestTriangle::find(const glm::vec3& point, const glm::vec3& normal) const {
  constexpr float anywhere = std::numeric_limits<float>::infinity();
  bool found = false;
  const TrianglePlace facing = find(point, normal, anywhere, found);
  return found ? facing : find(point, glm::vec3(0), anywhere, found);
}

TrianglePlace ClosestTriangle::find_within(const glm::vec3& point, double distance) const {
  bool found = false;
  const TrianglePlace near = find(point, glm::vec3(0), 1.001f * static_cast<float>(distance), found);
  return found ? near : find(point, glm::vec3(0), std::numeric_limits<float>::infinity(), found);
}

}  // namespace opaline
