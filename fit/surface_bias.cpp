#include "fit/surface_bias.h"

#include "model/conventions.h"
#include "render/visibility/gbuffer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace opaline {
namespace {

constexpr double beam_share = 0.77;  ///< of l_d/radius
constexpr double oblique_deg = 20;
constexpr double flat_mfp = 500;      ///< a larger radius does not show
constexpr double least_error = -.97;  ///< the search for the coefficients behind an error of -1 would not end

/// Measured on spheres lit from 60 degrees beside the view, eta 1.4: relative errors of sigma_a and sigma_s'.
constexpr std::array<double, 4> radii = {5, 10, 20, 50};   // transport mean free paths
constexpr std::array<double, 3> absorbed = {.02, .1, .3};  // 1 - alpha'
constexpr double side_sigma_a[4][3] = {{-1.0, -.78, -.72}, {-.76, -.62, -.68}, {-.58, -.60, -.73}, {-.48, -.63, -.79}};
constexpr double side_sigma_s[4][3] = {{-.03, -.31, -.49}, {-.19, -.38, -.58}, {-.29, -.49, -.68}, {-.36, -.58, -.77}};

/// Place in a rising list by the logarithm, held at its ends.
template <std::size_t n>
std::pair<std::size_t, double> place(const std::array<double, n>& list, double x) {
  const double held = std::clamp(x, list.front(), list.back());
  std::size_t i = 0;
  while (i + 2 < n && held > list[i + 1]) ++i;
  return {i, std::log(held / list[i]) / std::log(list[i + 1] / list[i])};
}

double interpolated(const double (&table)[4][3], double mfp, double share_absorbed) {
  const auto [i, t] = place(radii, mfp);
  const auto [j, u] = place(absorbed, share_absorbed);
  return (1 - t) * ((1 - u) * table[i][j] + u * table[i][j + 1]) +
         t * ((1 - u) * table[i + 1][j] + u * table[i + 1][j + 1]);
}

struct Errors {
  double radius_mfp = 0, sigma_a = 0, sigma_s_prime = 0;
};

/// By the coefficients that would come out as those fitted: the tables go by the true ones.
Errors expected(double radius_mm, bool side_light, double fitted_a, double fitted_s) {
  Errors e;
  double a = fitted_a, s = fitted_s;
  for (int step = 0; step < 40; ++step) {
    const double t = a + s;
    e.radius_mfp = radius_mm * t;
    if (side_light) {
      e.sigma_a = std::max(interpolated(side_sigma_a, e.radius_mfp, a / t), least_error);
      e.sigma_s_prime = interpolated(side_sigma_s, e.radius_mfp, a / t);
    } else {
      const double diffusion_length = 1 / std::sqrt(3 * a * t);
      e.sigma_a = std::isinf(radius_mm) ? 0 : std::max(-beam_share * diffusion_length / radius_mm, least_error);
    }
    a = std::sqrt(a * fitted_a / (1 + e.sigma_a));  // half a step: no swinging to and fro
    s = std::sqrt(s * fitted_s / (1 + e.sigma_s_prime));
  }
  return e;
}

std::optional<glm::dvec3> towards(const Light& light, const glm::dvec3& p) {
  if (const auto* sun = std::get_if<DirectionalLight>(&light)) return -sun->direction;
  if (const auto* lamp = std::get_if<PointLight>(&light)) return glm::normalize(lamp->position - p);
  if (const auto* projector = std::get_if<ProjectorLight>(&light)) {
    const glm::dvec3 from = glm::normalize(p - projector->position),
                     axis = glm::normalize(projector->look_at - projector->position);
    if (!projector->image && glm::dot(from, axis) < std::cos(projector->disk_radius_deg * pi / 180))
      return std::nullopt;
    return -from;
  }
  return std::nullopt;
}

/// Of a light that meets the point's outer side.
std::optional<double> incidence_deg(const Light& light, const VisiblePoint& p) {
  if (std::holds_alternative<EnvironmentLight>(light)) return 45;  // mean over an even sky, weighted by the cosine
  const auto l = towards(light, p.position);
  const double cosine = l ? glm::dot(*l, glm::dvec3(p.normal)) : 0;
  if (!(cosine > 0)) return std::nullopt;
  return std::acos(std::min(cosine, 1.0)) * 180 / pi;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::string percent(const std::array<double, 3>& v) {
  return fmt::format("{:+.0f}, {:+.0f}, {:+.0f} %", 100 * v[0], 100 * v[1], 100 * v[2]);
}

std::string words(const SurfaceBias& b) {
  if (b.side_light)
    return fmt::format(
        "curved and lit obliquely (radius about {:.2g}, {:.2g}, {:.2g} transport mean free paths, light {:.0f} "
        "degrees off the normal on average): the profile is that of a plane and a normal beam. Of spheres "
        "lit from the side such a fit had sigma_a off by about {} and sigma_s' by {}. --correct-with path_traced fits "
        "with transport on the shape itself",
        b.radius_mfp[0], b.radius_mfp[1], b.radius_mfp[2], b.shape.incidence_deg, percent(b.sigma_a),
        percent(b.sigma_s_prime));
  return fmt::format(
      "curved (radius about {:.2g}, {:.2g}, {:.2g} transport mean free paths) where the profile is that of "
      "a plane: expect sigma_a off by about {}, sigma_s' by up to 4 %",
      b.radius_mfp[0], b.radius_mfp[1], b.radius_mfp[2], percent(b.sigma_a));
}

}  // namespace

SurfaceShape surface_shape(const Scene& scene, int material) {
  const GBuffer view = make_gbuffer(scene, RayScene(scene));
  const auto width = static_cast<std::size_t>(view.width);
  std::vector<const VisiblePoint*> at(width * static_cast<std::size_t>(view.height));
  for (const VisiblePoint& p : view.points)
    if (scene.objects[static_cast<std::size_t>(p.object)].material == material) at[p.pixel] = &p;
  std::vector<double> curvature;
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (at[i] == nullptr) continue;
    const bool last_column = (i + 1) % width == 0;
    for (const std::size_t j : {last_column ? at.size() : i + 1, i + width}) {
      if (j >= at.size() || at[j] == nullptr || at[j]->object != at[i]->object) continue;
      const glm::dvec3 bend = glm::dvec3(at[j]->normal) - glm::dvec3(at[i]->normal),
                       way = glm::dvec3(at[j]->position) - glm::dvec3(at[i]->position);
      if (glm::length(way) > 0) curvature.push_back(glm::length(bend) / glm::length(way));
    }
    for (const Light& light : scene.lights)
      if (const auto angle = incidence_deg(light, *at[i])) sum += *angle, ++count;
  }
  const double bend = median(std::move(curvature));
  return {bend > 0 ? 1 / bend : std::numeric_limits<double>::infinity(), count > 0 ? sum / count : 0};
}

SurfaceBias surface_bias(const SurfaceShape& shape, const Material& material) {
  SurfaceBias out;
  out.shape = shape;
  out.side_light = shape.incidence_deg > oblique_deg;
  double least_radius = std::numeric_limits<double>::infinity(), worst = 0;
  for (int c = 0; c < 3; ++c) {
    const auto i = static_cast<std::size_t>(c);
    const Errors e = expected(shape.radius_mm, out.side_light, material.sigma_a[c], material.sigma_s_prime[c]);
    out.radius_mfp[i] = e.radius_mfp, out.sigma_a[i] = e.sigma_a, out.sigma_s_prime[i] = e.sigma_s_prime;
    least_radius = std::min(least_radius, e.radius_mfp);
    worst = std::max({worst, std::abs(e.sigma_a), std::abs(e.sigma_s_prime)});
  }
  const bool flat = least_radius > flat_mfp;
  if (flat && out.side_light) {
    out.sigma_a = out.sigma_s_prime = {};
    out.note = fmt::format(
        "lit {:.0f} degrees off the normal on average: the profile is that of a normal beam, and more "
        "of oblique light comes back. How far that moves the result is not known here",
        shape.incidence_deg);
  } else if (worst > 0.005) {
    out.note = words(out);
  }
  return out;
}

}  // namespace opaline
