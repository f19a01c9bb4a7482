#include "validate/edits.h"

#include "model/check.h"
#include "render/input_error.h"

#include <glm/gtc/matrix_transform.hpp>

namespace opaline {
namespace {

const double turn = glm::radians(2.0);

glm::dvec3 turned(const glm::dvec3& v, const glm::dvec3& axis) {
  return glm::dvec3(glm::rotate(glm::dmat4(1), turn, axis) * glm::dvec4(v, 0));
}

/// A unit vector that is not along v.
glm::dvec3 axis_across(const glm::dvec3& v) {
  return glm::normalize(
      glm::cross(v, std::abs(v.y) < 0.9 * glm::length(v) ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0)));
}

void edit_camera(Camera& camera) {
  camera.position = camera.look_at + turned(camera.position - camera.look_at, glm::normalize(camera.up));
}

void edit_light(Light& light) {
  if (auto* l = std::get_if<DirectionalLight>(&light)) l->direction = turned(l->direction, axis_across(l->direction));
  if (auto* l = std::get_if<PointLight>(&light)) l->position *= 1.01;
  if (auto* l = std::get_if<ProjectorLight>(&light))
    l->position = l->look_at + turned(l->position - l->look_at, axis_across(l->position - l->look_at));
  if (auto* l = std::get_if<EnvironmentLight>(&light)) l->scale *= 0.9;
}

void edit_material(Material& material) {
  material.sigma_a *= 1.1;
  if (!material.layers) return;
  auto layers = std::make_shared<LayeredMedium>(*material.layers);
  for (SubsurfaceLayer& layer : layers->layers) layer.sigma_t += 0.1 * (layer.sigma_t - layer.sigma_s);
  material.layers = layers;
}

void edit_geometry(Mesh& mesh) {
  glm::vec3 centre(0);
  for (const glm::vec3& p : mesh.positions) centre += p / static_cast<float>(mesh.positions.size());
  for (glm::vec3& p : mesh.positions) p = centre + 1.01f * (p - centre);
}

/// Puts scene and shared parts back at the end.
class Restore {
 public:
  explicit Restore(MeasuredScene& scene) : scene_(scene), before_(scene.scene), parts_(*scene.shared) {}
  ~Restore() {
    scene_.scene = before_;
    if (rays_made_again)
      scene_.shared = std::make_unique<SharedScene>(scene_.scene, scene_.shared->settings, std::move(parts_));
    else
      static_cast<SharedParts&>(*scene_.shared) = std::move(parts_);
  }
  Restore(const Restore&) = delete;
  Restore& operator=(const Restore&) = delete;
  bool rays_made_again = false;

 private:
  MeasuredScene& scene_;
  Scene before_;
  SharedParts parts_;
};

/// Does what was prepared no longer hold after the edit, whatever the settings?
bool needs_prepare(const std::string& edit, const TechniqueRun& run) {
  const InvalidatedBy& by = run.technique.invalidated_by;
  if (edit == "camera") return by.camera;
  if (edit == "light") return by.light;
  if (edit == "material") return by.material;
  return true;  // geometry: whatever was prepared holds on to the shared parts of before
}

/// Edits, and makes the shared parts again that the technique needs.
void apply(const std::string& edit, TechniqueRun& run, Restore& restore) {
  MeasuredScene& s = run.scene;
  if (edit == "camera") {
    edit_camera(s.scene.camera);
    s.shared->view = make_gbuffer(s.scene, s.shared->rays);
  } else if (edit == "light") {
    if (!s.scene.lights.empty()) edit_light(s.scene.lights.front());
    if (run.technique.needs_irradiance) s.shared->make_irradiance();
  } else if (edit == "material") {
    for (Material& material : s.scene.materials) edit_material(material);
  } else {
    OPALINE_CHECK(edit == "geometry");
    edit_geometry(s.scene.objects.front().mesh);
    restore.rays_made_again = true;
    s.shared = std::make_unique<SharedScene>(s.scene, s.shared->settings, run.technique.needs_irradiance);
  }
}

/// A frame of what is prepared; false where that refuses the scene as it is, as one that a setting binds to its view
/// (view=fixed) refuses another camera.
bool renders(TechniqueRun& run) {
  try {
    run.render();
    return true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

EditCost measure_edit_once(const std::string& edit, TechniqueRun& run, bool anyway) {
  Restore restore(run.scene);
  EditCost cost;
  bool prepare = anyway || needs_prepare(edit, run);
  Stopwatch watch;
  apply(edit, run, restore);
  cost.shared = watch.lap();
  if (!prepare && !renders(run)) prepare = true;
  if (prepare) {
    watch.lap();
    run.prepare();
    cost.prepare = watch.lap();
    run.render();
  }
  cost.render = watch.lap();
  cost.total = cost.shared + cost.prepare + cost.render;
  run.forget();  // it is the edited scene's, or holds on to shared parts that are put back elsewhere
  return cost;
}

EditCost measure_edit(const std::string& edit, TechniqueRun& run, const TimingPlan& plan, double& spent) {
  std::vector<EditCost> costs;
  Stopwatch watch;
  double sum = 0;
  do {
    // What the technique has at the moment of the edit. Where the edit makes it worthless it is not made.
    if (!run.is_prepared() && !needs_prepare(edit, run)) run.prepare();
    costs.push_back(measure_edit_once(edit, run));
    sum += watch.lap();
  } while (static_cast<int>(costs.size()) < plan.runs && sum < plan.max_seconds);
  spent += sum;
  const auto middle = costs.begin() + static_cast<std::ptrdiff_t>(costs.size() / 2);
  std::nth_element(costs.begin(), middle, costs.end(),
                   [](const EditCost& a, const EditCost& b) { return a.total < b.total; });
  return *middle;
}

}  // namespace opaline
