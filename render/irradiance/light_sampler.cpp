#include "render/irradiance/light_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace opaline {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

std::uint64_t mix(std::uint64_t x) {  // splitmix64 finaliser
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

glm::dmat3 frame_around(const glm::dvec3& axis) {
  const glm::dvec3 helper = std::abs(axis.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 s = glm::normalize(glm::cross(axis, helper));
  return {s, glm::cross(axis, s), axis};
}

/// A direction of the disk, uniform in projected solid angle around the axis, so that every sample
/// carries the same irradiance on a plane facing the axis.
LightSample draw_directional(const DirectionalLight& light, float u, float v, int n) {
  const double sine = std::sin(light.angular_radius_deg * pi / 180) * std::sqrt(static_cast<double>(u));
  const double cosine = std::sqrt(1 - sine * sine), phi = 2 * pi * v;
  const glm::dvec3 local(sine * std::cos(phi), sine * std::sin(phi), cosine);
  const glm::dvec3 direction = frame_around(-light.direction) * local;
  return {glm::vec3(direction), infinite, glm::vec3(light.irradiance / (n * std::max(cosine, 1e-9)))};
}

LightSample towards(const glm::dvec3& position, const glm::vec3& point, const Rgb& intensity) {
  const glm::dvec3 d = position - glm::dvec3(point);
  const double distance = glm::length(d);
  if (distance == 0) return {glm::vec3(0, 0, 1), 0, glm::vec3(0)};
  return {glm::vec3(d / distance), static_cast<float>(distance), glm::vec3(intensity / (distance * distance))};
}

Rgb pixel_rgb(const Image& image, int x, int y) {
  const int r = image.channel("R"), g = image.channel("G"), b = image.channel("B");
  if (r >= 0 && g >= 0 && b >= 0) return {image.at(x, y, r), image.at(x, y, g), image.at(x, y, b)};
  return Rgb(image.at(x, y, 0));
}

Rgb bilinear(const Image& image, double x, double y, bool wrap_x) {
  const double fx = std::floor(x), fy = std::floor(y);
  Rgb sum(0);
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx) {
      int ix = static_cast<int>(fx) + dx;
      const int iy = std::clamp(static_cast<int>(fy) + dy, 0, image.height - 1);
      ix = wrap_x ? ((ix % image.width) + image.width) % image.width : std::clamp(ix, 0, image.width - 1);
      sum += (dx ? x - fx : 1 - x + fx) * (dy ? y - fy : 1 - y + fy) * pixel_rgb(image, ix, iy);
    }
  return sum;
}

/// Brightest channel of every pixel; negative values count as 0.
std::vector<double> brightness(const Image& image) {
  std::vector<double> values;
  values.reserve(image.pixel_count());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Rgb c = pixel_rgb(image, x, y);
      values.push_back(std::max({c.r, c.g, c.b, 0.0}));
    }
  return values;
}

/// Mean of the bilinear lookup over a pixel: a bright pixel lights its neighbours' areas too, and
/// sampling must go there as often.
double mean_over_pixel(const std::vector<double>& values, int width, int height, int x, int y) {
  constexpr double weight[3] = {1.0 / 8, 6.0 / 8, 1.0 / 8};
  double sum = 0;
  for (int dy = 0; dy < 3; ++dy)
    for (int dx = 0; dx < 3; ++dx) {
      const int column = (x + dx - 1 + width) % width, row = std::clamp(y + dy - 1, 0, height - 1);
      sum += weight[dx] * weight[dy] * values[static_cast<std::size_t>(row * width + column)];
    }
  return sum;
}

/// What the projector shows in the direction of a point: its image, its disk, or nothing.
Rgb projected(const ProjectorLight& light, const glm::vec3& point) {
  const glm::dvec3 forward = glm::normalize(light.look_at - light.position);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, light.up)), up = glm::cross(right, forward);
  const glm::dvec3 d = glm::dvec3(point) - light.position;
  const double z = glm::dot(d, forward);
  if (z <= 0) return Rgb(0);
  if (!light.image) {
    const double tangent = std::tan(light.disk_radius_deg * pi / 180);
    return glm::length(d - z * forward) <= z * tangent ? light.intensity : Rgb(0);
  }
  const double half = z * std::tan(light.fov_y_deg * pi / 360);
  const double aspect = static_cast<double>(light.image->width) / light.image->height;
  const double sx = glm::dot(d, right) / (half * aspect), sy = glm::dot(d, up) / half;
  if (std::abs(sx) > 1 || std::abs(sy) > 1) return Rgb(0);
  return light.intensity * bilinear(*light.image, (sx + 1) / 2 * light.image->width - 0.5,
                                    (1 - sy) / 2 * light.image->height - 0.5, false);
}

/// The colour of a light if it has one, scaled to a largest channel of 1.
std::optional<Rgb> colour_of(const Light& light) {
  const auto scaled = [](const Rgb& c) { return c / std::max({c.r, c.g, c.b, 1e-300}); };
  const auto grey = [](const Image& image) {
    for (std::size_t i = 0; i < image.pixel_count(); ++i) {
      const Rgb c = pixel_rgb(image, static_cast<int>(i % static_cast<std::size_t>(image.width)),
                              static_cast<int>(i / static_cast<std::size_t>(image.width)));
      if (c.r != c.g || c.g != c.b) return false;
    }
    return true;
  };
  if (const auto* l = std::get_if<DirectionalLight>(&light)) return scaled(l->irradiance);
  if (const auto* l = std::get_if<PointLight>(&light)) return scaled(l->intensity);
  if (const auto* l = std::get_if<EnvironmentLight>(&light))
    return grey(*l->image) ? std::optional(scaled(l->scale)) : std::nullopt;
  const auto& l = std::get<ProjectorLight>(light);
  return !l.image || grey(*l.image) ? std::optional(scaled(l.intensity)) : std::nullopt;
}

/// Position of xi in a cumulative table over `count` bins starting at `first`: bin and fraction.
std::pair<std::size_t, double> invert(const std::vector<double>& table, std::size_t first, std::size_t count,
                                      double xi) {
  const auto begin = table.begin() + static_cast<std::ptrdiff_t>(first),
             end = begin + static_cast<std::ptrdiff_t>(count);
  const double target = xi * *(end - 1);
  auto it = std::upper_bound(begin, end, target);
  if (it == end) --it;
  const double below = it == begin ? 0 : *(it - 1);
  return {static_cast<std::size_t>(it - begin), (target - below) / std::max(*it - below, 1e-300)};
}

}  // namespace

std::array<float, 2> shifted_r2(std::uint64_t seed, std::uint32_t number) {
  const std::uint64_t a = mix(seed + 0x9e3779b97f4a7c15ull), b = mix(a + 0x9e3779b97f4a7c15ull);
  // R2: additive recurrence with the plastic number's inverse powers.
  const double u = number * 0.7548776662466927 + static_cast<double>(a >> 11) * 0x1p-53;
  const double v = number * 0.5698402909980532 + static_cast<double>(b >> 11) * 0x1p-53;
  return {std::min(static_cast<float>(u - std::floor(u)), 0x1.fffffep-1f),
          std::min(static_cast<float>(v - std::floor(v)), 0x1.fffffep-1f)};
}

Rgb environment_radiance(const EnvironmentLight& light, const glm::dvec3& w) {
  const Image& image = *light.image;
  const double theta = std::acos(std::clamp(w.y, -1.0, 1.0)), phi = std::atan2(w.x, -w.z);
  return light.scale *
         bilinear(image, (phi / (2 * pi) + 0.5) * image.width - 0.5, theta / pi * image.height - 0.5, true);
}

LightSampler::LightSampler(const Scene& scene, int area_samples)
    : lights_(scene.lights), tables_(scene.lights.size()), area_samples_(std::max(area_samples, 1)) {
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const auto* disk = std::get_if<DirectionalLight>(&lights_[i]);
    const auto* environment = std::get_if<EnvironmentLight>(&lights_[i]);
    extended_.push_back((disk && disk->angular_radius_deg > 0) || environment);
    if (!environment) continue;
    const Image& image = *environment->image;
    EnvironmentTable& table = tables_[i];
    const std::vector<double> bright = brightness(image);
    double total = 0;
    for (int y = 0; y < image.height; ++y) {
      double row = 0;
      const double sine = std::sin((y + 0.5) * pi / image.height);
      for (int x = 0; x < image.width; ++x) {
        // A little everywhere, so that a black image has a density too.
        row += sine * (mean_over_pixel(bright, image.width, image.height, x, y) + 1e-30);
        table.columns.push_back(row);
      }
      table.rows.push_back(total += row);
    }
  }
}

LightSample LightSampler::draw_environment(std::size_t light, float u, float v, int n) const {
  const auto& environment = std::get<EnvironmentLight>(lights_[light]);
  const Image& image = *environment.image;
  const EnvironmentTable& table = tables_[light];
  const auto height = static_cast<std::size_t>(image.height), width = static_cast<std::size_t>(image.width);
  const auto [row, fy] = invert(table.rows, 0, height, v);
  const auto [column, fx] = invert(table.columns, row * width, width, u);
  const double theta = pi * (static_cast<double>(row) + fy) / image.height;
  const double phi = 2 * pi * ((static_cast<double>(column) + fx) / image.width - 0.5);
  const glm::dvec3 w(std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi));
  const auto weight = [](const std::vector<double>& t, std::size_t first, std::size_t i) {
    return t[first + i] - (i ? t[first + i - 1] : 0.0);
  };
  const double probability = weight(table.rows, 0, row) / table.rows.back() *
                             weight(table.columns, row * width, column) / table.columns[row * width + width - 1];
  const double pixel_solid_angle = 2 * pi * pi * std::sin(theta) / (image.width * image.height);
  return {glm::vec3(w), infinite,
          glm::vec3(environment_radiance(environment, w) * (pixel_solid_angle / (probability * n)))};
}

LightSample LightSampler::draw(std::size_t light, const glm::vec3& point, std::uint64_t seed, std::uint32_t number,
                               int n) const {
  const Light& any = lights_[light];
  if (const auto* l = std::get_if<PointLight>(&any)) return towards(l->position, point, l->intensity);
  if (const auto* l = std::get_if<ProjectorLight>(&any)) return towards(l->position, point, projected(*l, point));
  const auto [u, v] = shifted_r2(seed * 31 + light, number);
  if (const auto* l = std::get_if<DirectionalLight>(&any)) return draw_directional(*l, extended_[light] ? u : 0, v, n);
  return draw_environment(light, u, v, n);
}

bool LightSampler::single_colour(Rgb& colour) const {
  std::optional<Rgb> common;
  for (const Light& light : lights_) {
    const std::optional<Rgb> c = colour_of(light);
    if (!c) return false;
    if (common && glm::length(*c - *common) > 1e-12) return false;
    common = c;
  }
  colour = common.value_or(Rgb(1));
  return true;
}

}  // namespace opaline
