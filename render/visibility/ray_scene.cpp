#include "render/visibility/ray_scene.h"

#include "render/input_error.h"

#include <embree3/rtcore.h>

#include <limits>

namespace opaline {

struct RayScene::Handles {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  ~Handles() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
};

namespace {

// Embree reads 16 bytes at a time and may touch the 12 after the last vertex, so the vertices are
// copied into a buffer of its own.
void attach_mesh(RTCDevice device, RTCScene scene, const Mesh& mesh, unsigned id) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), mesh.positions.size()));
  auto* indices = static_cast<glm::uvec3*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                   sizeof(glm::uvec3), mesh.triangles.size()));
  if (!vertices || !indices) {
    rtcReleaseGeometry(geometry);
    throw MachineError("not enough memory for the ray tracing buffers");
  }
  std::copy(mesh.positions.begin(), mesh.positions.end(), vertices);
  std::copy(mesh.triangles.begin(), mesh.triangles.end(), indices);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

RTCRay make_ray(const glm::vec3& origin, const glm::vec3& direction, float far) {
  RTCRay ray{};
  ray.org_x = origin.x, ray.org_y = origin.y, ray.org_z = origin.z;
  ray.dir_x = direction.x, ray.dir_y = direction.y, ray.dir_z = direction.z;
  ray.tnear = 0;
  ray.tfar = far;
  ray.mask = ~0u;
  return ray;
}

}  // namespace

RayScene::RayScene(const Scene& scene) : handles_(std::make_unique<Handles>()) {
  handles_->device = rtcNewDevice(nullptr);
  if (!handles_->device) throw MachineError("Embree could not be started");
  handles_->scene = rtcNewScene(handles_->device);
  rtcSetSceneFlags(handles_->scene, RTC_SCENE_FLAG_ROBUST);
  glm::vec3 lo(std::numeric_limits<float>::max()), hi(-lo);
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    attach_mesh(handles_->device, handles_->scene, scene.objects[i].mesh, static_cast<unsigned>(i));
    for (const glm::vec3& p : scene.objects[i].mesh.positions) lo = glm::min(lo, p), hi = glm::max(hi, p);
  }
  rtcCommitScene(handles_->scene);
  offset_ = 1e-5f * glm::length(hi - lo);
}

RayScene::~RayScene() = default;

SurfaceHit RayScene::closest(const glm::vec3& origin, const glm::vec3& direction, float near) const {
  RTCRayHit query{};
  query.ray = make_ray(origin, direction, std::numeric_limits<float>::infinity());
  query.ray.tnear = near;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(handles_->scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return {static_cast<std::int32_t>(query.hit.geomID), query.hit.primID, query.hit.u, query.hit.v, query.ray.tfar};
}

bool RayScene::occluded(const glm::vec3& origin, const glm::vec3& direction, float distance) const {
  RTCRay ray = make_ray(origin, direction, distance);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(handles_->scene, &context, &ray);
  return ray.tfar < 0;
}

SurfacePoint surface_point(const Mesh& mesh, std::uint32_t triangle, float u, float v) {
  const glm::uvec3 t = mesh.triangles[triangle];
  const glm::vec3 a = mesh.positions[t.x], ab = mesh.positions[t.y] - a, ac = mesh.positions[t.z] - a;
  SurfacePoint point;
  point.position = a + u * ab + v * ac;
  point.face_normal = glm::normalize(glm::cross(ab, ac));
  point.normal = point.face_normal;
  if (!mesh.normals.empty()) {
    const glm::vec3 n = (1 - u - v) * mesh.normals[t.x] + u * mesh.normals[t.y] + v * mesh.normals[t.z];
    // Opposing vertex normals can cancel; the face normal is the only sound answer there.
    if (glm::dot(n, n) > 1e-12f) point.normal = glm::normalize(n);
  }
  return point;
}

SurfacePoint surface_point_at(const Mesh& mesh, std::uint32_t triangle, const glm::vec3& position) {
  const glm::uvec3 t = mesh.triangles[triangle];
  const glm::vec3 a = mesh.positions[t.x], ab = mesh.positions[t.y] - a, ac = mesh.positions[t.z] - a;
  const glm::vec3 n = glm::cross(ab, ac), d = position - a;
  const float area2 = glm::dot(n, n);
  SurfacePoint point =
      surface_point(mesh, triangle, glm::dot(glm::cross(d, ac), n) / area2, glm::dot(glm::cross(ab, d), n) / area2);
  point.position = position;
  return point;
}

}  // namespace opaline
