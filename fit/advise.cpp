#include "fit/advise.h"

#include "fit/reduced_picture.h"
#include "render/visibility/gbuffer.h"

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

using glm::dvec3;

struct Trial {
  std::string what;
  Scene scene;
  nlohmann::json light, camera;
};

nlohmann::json json_of(const dvec3& v) { return {v.x, v.y, v.z}; }

/// Where the camera's central ray meets the object, and how large that is.
struct Centre {
  dvec3 point{0}, normal{0, 0, 1};
  double radius = 1;
};

Centre centre_of(const Scene& scene, int material) {
  dvec3 low(HUGE_VAL), high(-HUGE_VAL);
  for (const Object& object : scene.objects)
    if (object.material == material)
      for (const auto& p : object.mesh.positions) low = glm::min(low, dvec3(p)), high = glm::max(high, dvec3(p));
  Centre centre{0.5 * (low + high), {0, 0, 1}, 0.5 * glm::length(high - low)};
  const RayScene rays(scene);
  const GBuffer view = make_gbuffer(scene, rays);
  double nearest = HUGE_VAL;
  for (const VisiblePoint& p : view.points) {
    if (scene.objects[static_cast<std::size_t>(p.object)].material != material) continue;
    const double dx = p.pixel % static_cast<std::uint32_t>(view.width) + 0.5 - 0.5 * view.width,
                 dy = p.pixel / static_cast<std::uint32_t>(view.width) + 0.5 - 0.5 * view.height;
    if (dx * dx + dy * dy >= nearest) continue;
    nearest = dx * dx + dy * dy;
    centre.point = dvec3(p.position), centre.normal = dvec3(p.normal);
  }
  return centre;
}

Trial lit(const Scene& scene, const std::string& what, const dvec3& direction) {
  Trial trial{"light from " + what, scene, {}, {}};
  trial.scene.lights = {DirectionalLight{glm::normalize(direction), Rgb(3.14159), 0}};
  trial.light = {{"type", "directional"}, {"direction", json_of(glm::normalize(direction))}, {"irradiance", 3.14159}};
  return trial;
}

/// A beam a thirtieth of the object wide, from `from` onto the centre.
Trial beam(const Scene& scene, const std::string& what, const Centre& c, const dvec3& from) {
  Trial trial{what, scene, {}, {}};
  const double distance = 4 * c.radius, width_deg = glm::degrees(std::atan(1.0 / 60));
  ProjectorLight light;
  light.position = c.point + distance * glm::normalize(from);
  light.look_at = c.point;
  light.up = std::abs(glm::normalize(from).y) > 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  light.intensity = Rgb(3.14159 * distance * distance);
  light.disk_radius_deg = width_deg * 0.5;
  trial.scene.lights = {light};
  trial.light = {{"type", "projector"},
                 {"position", json_of(light.position)},
                 {"look_at", json_of(c.point)},
                 {"intensity", light.intensity.r},
                 {"disk_radius_deg", light.disk_radius_deg}};
  return trial;
}

Trial seen_from_beside(const Scene& scene, const Centre& c, double degrees) {
  Trial trial{fmt::format("the same light seen from {:.0f} degrees to the {}", std::abs(degrees),
                          degrees < 0 ? "left" : "right"),
              scene,
              {},
              {}};
  const CameraFrame frame = camera_frame(scene.camera);
  const dvec3 arm = scene.camera.position - c.point;
  const double a = glm::radians(degrees);
  const dvec3 back = -frame.forward;
  trial.scene.camera.position =
      c.point + glm::length(arm) * glm::normalize(std::cos(a) * back + std::sin(a) * frame.right);
  trial.scene.camera.look_at = c.point;
  trial.camera = {{"position", json_of(trial.scene.camera.position)}, {"look_at", json_of(c.point)}};
  return trial;
}

std::vector<Trial> trials(const Scene& scene, int material) {
  const CameraFrame f = camera_frame(scene.camera);
  const Centre c = centre_of(scene, material);
  return {lit(scene, "the camera", f.forward),
          lit(scene, "the left", f.right + 0.3 * f.forward),
          lit(scene, "the right", -f.right + 0.3 * f.forward),
          lit(scene, "above", -f.up + 0.3 * f.forward),
          lit(scene, "the left, grazing", f.right),
          lit(scene, "behind on the left", 0.8 * f.right - 0.6 * f.forward),
          beam(scene, "a narrow beam from the camera", c, -f.forward),
          beam(scene, "a narrow oblique beam from the left", c, -f.right - f.forward),
          seen_from_beside(scene, c, -60),
          seen_from_beside(scene, c, 60)};
}

/// Film of `pixels` rows; how many of the scene's pixels one stands for.
double shrink(Scene& scene, int pixels) {
  const double factor = std::min(1.0, static_cast<double>(pixels) / scene.film.height);
  const double before = static_cast<double>(scene.film.width) * scene.film.height;
  scene.film.width = std::max(1, static_cast<int>(std::lround(scene.film.width * factor)));
  scene.film.height = std::max(1, static_cast<int>(std::lround(scene.film.height * factor)));
  return before / (static_cast<double>(scene.film.width) * scene.film.height);
}

/// Of a trial picture with noise of 1: information of each channel about (ln sigma_a, ln sigma_s', eta), its brightest
/// value.
struct TrialInformation {
  std::array<Eigen::Matrix3d, 3> of_channel{Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
  std::array<double, 3> peak{};
};

void add_channel(const TransportOperator& op, const ColumnCoefficients& x, const Material& material, int c,
                 TrialInformation& out) {
  const auto n = static_cast<Eigen::Index>(op.columns());
  const auto i = static_cast<std::size_t>(c);
  for (std::size_t p = 0; p < op.rows(); ++p) {
    const Eigen::VectorXd row = Eigen::Map<const Eigen::VectorXf>(op.row(p, op.light_channel(c)), n).cast<double>();
    const auto dot = [&](const std::vector<double>& v) {
      return row.dot(Eigen::Map<const Eigen::VectorXd>(v.data(), n));
    };
    const Eigen::Vector3d d(material.sigma_a[c] * dot(x.d_sigma_a), material.sigma_s_prime[c] * dot(x.d_sigma_s_prime),
                            dot(x.d_eta));
    out.of_channel[i] += d * d.transpose();
    out.peak[i] = std::max(out.peak[i], dot(x.value));
  }
}

TrialInformation information(const Trial& trial, int material_index, const ProfileInfo& profile,
                             const Material& material, const AdviseSettings& settings) {
  Scene scene = trial.scene;
  const double per_pixel = shrink(scene, settings.pixels);
  OperatorSettings op_settings;
  op_settings.samples = settings.samples;
  const double spread = 0.02 * (material.eta - 1);
  const EtaNodes etas(material.eta - 2 * spread, material.eta + 2 * spread, 3);
  TrialInformation out;
  const TransportOperator op = build_operator(scene, material_index, etas, op_settings);
  for (int c = 0; c < 3; ++c) {
    add_channel(op, column_coefficients(op, profile, material.channel(c), c), material, c, out);
    out.of_channel[static_cast<std::size_t>(c)] *= per_pixel;
  }
  return out;
}

/// All seven parameters' information, for noise of `relative` times the peak of each channel. An exposure makes up for
/// a dim picture, but not for one below a hundredth of the brightest trial.
Eigen::MatrixXd assembled(const TrialInformation& trial, const std::array<double, 3>& brightest, double relative) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(parameter_count, parameter_count);
  for (int c = 0; c < 3; ++c) {
    const auto k = static_cast<std::size_t>(c);
    const double sd = relative * std::max({trial.peak[k], 0.01 * brightest[k], 1e-30});
    const int at[] = {c, c + 3, eta_index};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) sum(at[i], at[j]) += trial.of_channel[k](i, j) / (sd * sd);
  }
  return sum;
}

}  // namespace

std::vector<Advice> advise(const Scene& scene, int material_index, const ProfileInfo& profile, const Solution& solution,
                           const Uncertainty& now, const FreeParameters& free, double relative_noise,
                           const AdviseSettings& settings) {
  const Material material = to_material(solution.parameters, scene.materials[static_cast<std::size_t>(material_index)]);
  std::vector<int> columns;
  for (int i = 0; i < parameter_count; ++i)
    if (free.is_free(i)) columns.push_back(i);
  const auto k = static_cast<Eigen::Index>(columns.size());
  const auto picked = [&](const Eigen::MatrixXd& m) {
    Eigen::MatrixXd out(k, k);
    for (Eigen::Index i = 0; i < k; ++i)
      for (Eigen::Index j = 0; j < k; ++j)
        out(i, j) = m(columns[static_cast<std::size_t>(i)], columns[static_cast<std::size_t>(j)]);
    return out;
  };
  const Eigen::MatrixXd covariance = picked(now.covariance);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
  const Eigen::MatrixXd root = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  std::vector<Advice> all;
  const std::vector<Trial> tried = trials(scene, material_index);
  std::vector<TrialInformation> found;
  std::array<double, 3> brightest{};
  for (const Trial& trial : tried) {
    found.push_back(information(trial, material_index, profile, material, settings));
    for (std::size_t c = 0; c < 3; ++c) brightest[c] = std::max(brightest[c], found.back().peak[c]);
  }
  for (std::size_t t = 0; t < tried.size(); ++t) {
    const Trial& trial = tried[t];
    const Eigen::MatrixXd more = picked(assembled(found[t], brightest, relative_noise));
    // (C^-1 + I)^-1 = S (1 + S^T I S)^-1 S^T with C = S S^T: no inverse of a C that knows nothing in some direction.
    const Eigen::MatrixXd inner = Eigen::MatrixXd::Identity(k, k) + root.transpose() * more * root;
    const Eigen::MatrixXd then = root * inner.ldlt().solve(root.transpose());
    Advice advice{trial.what, trial.light, trial.camera, {}, 1};
    double log_sum = 0;
    for (Eigen::Index i = 0; i < k; ++i) {
      const double sd = std::sqrt(std::max(then(i, i), 1e-30));
      advice.sd[static_cast<std::size_t>(columns[static_cast<std::size_t>(i)])] = sd;
      log_sum += std::log(std::sqrt(covariance(i, i)) / sd);
    }
    advice.factor = std::exp(log_sum / static_cast<double>(k));
    all.push_back(std::move(advice));
  }
  std::stable_sort(all.begin(), all.end(), [](const Advice& a, const Advice& b) { return a.factor > b.factor; });
  return all;
}

}  // namespace opaline
