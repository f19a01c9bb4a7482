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

/// Barycentrics along the edge from corner i to corner k of the point nearest to p.
glm::dvec3 closest_on_edge(const glm::dvec3& p, const glm::dvec3 corners[3], int i, int k) {
  const glm::dvec3 edge = corners[k] - corners[i];
  const double along = std::clamp(glm::dot(p - corners[i], edge) / std::max(glm::dot(edge, edge), 1e-300), 0.0, 1.0);
  glm::dvec3 weights(0);
  weights[i] = 1 - along, weights[k] = along;
  return weights;
}

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
    const double distance = glm::length(w.x * a + w.y * b + w.z * c - point);
    if (found && distance >= best.distance) return false;
    found = true;
    best = {triangle, w, distance};
    radius = static_cast<float>(distance);
    return true;
  }
};

bool visit(RTCPointQueryFunctionArguments* arguments) {
  return static_cast<Search*>(arguments->userPtr)->look(arguments->primID, arguments->query->radius);
}

}  // namespace

glm::dvec3 closest_on_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 n = glm::cross(b - a, c - a);
  const double area2 = glm::dot(n, n);
  if (area2 > 0) {
    const glm::dvec3 inside(glm::dot(glm::cross(c - b, p - b), n) / area2,
                            glm::dot(glm::cross(a - c, p - c), n) / area2,
                            glm::dot(glm::cross(b - a, p - a), n) / area2);
    if (inside.x >= 0 && inside.y >= 0 && inside.z >= 0) return inside / (inside.x + inside.y + inside.z);
  }
  const glm::dvec3 corners[3] = {a, b, c};
  glm::dvec3 best(1, 0, 0);
  double nearest = std::numeric_limits<double>::max();
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 w = closest_on_edge(p, corners, i, (i + 1) % 3);
    const double distance = glm::length(w.x * a + w.y * b + w.z * c - p);
    if (distance < nearest) nearest = distance, best = w;
  }
  return best;
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

TrianglePlace ClosestTriangle::find(const glm::vec3& point, const glm::vec3& normal) const {
  for (const glm::dvec3& facing : {glm::dvec3(normal), glm::dvec3(0)}) {
    Search search{positions_, triangles_, glm::dvec3(point), facing};
    RTCPointQuery query{point.x, point.y, point.z, 0, std::numeric_limits<float>::infinity()};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(handles_->scene, &query, &context, visit, &search);
    if (search.found) return search.best;
  }
  OPALINE_CHECK(false);
  return {};
}

}  // namespace opaline
