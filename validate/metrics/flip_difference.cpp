#include "validate/metrics/flip_difference.h"

#include "validate/metrics/filter.h"
#include "validate/metrics/luminance.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace opaline {

const double flip_pixels_per_degree = 0.7 * (3840 / 0.7) * std::numbers::pi / 180;

namespace {

using Colour = glm::dvec3;
using Plane = std::vector<double>;

/// Three planes: an image in some colour space.
struct Picture {
  int width = 0, height = 0;
  Plane plane[3];
  std::size_t size() const { return plane[0].size(); }
  Colour at(std::size_t p) const { return {plane[0][p], plane[1][p], plane[2][p]}; }
  void set(std::size_t p, const Colour& c) {
    for (int k = 0; k < 3; ++k) plane[k][p] = c[k];
  }
};

Picture make_picture(const Comparison& c, const std::vector<std::vector<float>>& planes) {
  Picture picture{c.width, c.height, {}};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::vector<float>& from = planes[planes.size() == 1 ? 0 : k];
    picture.plane[k].assign(from.begin(), from.end());
  }
  return picture;
}

template <typename Map>
Picture mapped(Picture picture, const Map& map) {
  for (std::size_t p = 0; p < picture.size(); ++p) picture.set(p, map(picture.at(p)));
  return picture;
}

// --- colour spaces, illuminant D65 ---

/// Rows of the matrix from linear sRGB to XYZ.
const glm::dmat3 xyz_rows(Colour(10135552, 8788810, 4435075) / 24577794.0,
                          Colour(2613072, 8788810, 887015) / 12288897.0,
                          Colour(1425312, 8788810, 70074185) / 73733382.0);
const glm::dmat3 xyz_from_rgb = glm::transpose(xyz_rows);
const glm::dmat3 rgb_from_xyz = glm::inverse(xyz_from_rgb);
const Colour white = xyz_from_rgb * Colour(1);

/// The linear opponent space of the spatial filters: luminance, red-green, blue-yellow.
Colour opponent_from_rgb(const Colour& rgb) {
  const Colour xyz = xyz_from_rgb * rgb / white;
  return {116 * xyz.y - 16, 500 * (xyz.x - xyz.y), 200 * (xyz.y - xyz.z)};
}

Colour rgb_from_opponent(const Colour& c) {
  const double y = (c.x + 16) / 116;
  return rgb_from_xyz * (Colour(y + c.y / 500, y, y - c.z / 200) * white);
}

/// CIELAB with its chroma scaled by 0.01 L (the Hunt effect: colours look stronger in bright light).
Colour hunt_lab_from_rgb(const Colour& rgb) {
  constexpr double delta = 6.0 / 29;
  Colour f = xyz_from_rgb * rgb / white;
  for (int k = 0; k < 3; ++k)
    f[k] = f[k] > delta * delta * delta ? std::cbrt(f[k]) : f[k] / (3 * delta * delta) + 4.0 / 29;
  const double lightness = 116 * f.y - 16;
  return {lightness, 0.01 * lightness * 500 * (f.x - f.y), 0.01 * lightness * 200 * (f.y - f.z)};
}

/// City block in lightness, Euclidean in chroma.
double hyab(const Colour& a, const Colour& b) {
  const Colour d = a - b;
  return std::abs(d.x) + std::hypot(d.y, d.z);
}

// --- colour pipeline ---

/// A contrast sensitivity function: sum of a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees.
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr Sensitivity sensitivities[3] = {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};

/// Filters with both Gaussians of a sensitivity. Each is separable; their sum is not.
Plane filter_by(const Sensitivity& s, const Plane& plane, int width, int height) {
  constexpr double pi = std::numbers::pi, widest = 0.04;
  const int radius = static_cast<int>(std::ceil(3 * std::sqrt(widest / (2 * pi * pi)) * flip_pixels_per_degree));
  const auto gaussian = [&](double b) {
    return kernel_of(radius, [&](double x) {
      const double degrees = x / flip_pixels_per_degree;
      return std::exp(-pi * pi * degrees * degrees / b);
    });
  };
  const auto mass = [&](double a, double b) {
    double sum = 0;
    for (const double w : gaussian(b)) sum += w;
    return a * std::sqrt(pi / b) * sum * sum;
  };
  const double m1 = mass(s.a1, s.b1), m2 = mass(s.a2, s.b2);
  const Kernel k1 = normalised(gaussian(s.b1));
  Plane result = filter(plane, width, height, k1, k1);
  if (m2 == 0) return result;
  const Kernel k2 = normalised(gaussian(s.b2));
  const Plane second = filter(plane, width, height, k2, k2);
  for (std::size_t p = 0; p < result.size(); ++p) result[p] = (m1 * result[p] + m2 * second[p]) / (m1 + m2);
  return result;
}

/// What the eye resolves of an opponent picture, in Hunt-adjusted CIELAB.
Picture seen(const Picture& opponent) {
  Picture filtered = opponent;
  for (int k = 0; k < 3; ++k)
    filtered.plane[k] = filter_by(sensitivities[k], opponent.plane[k], opponent.width, opponent.height);
  return mapped(std::move(filtered),
                [](const Colour& c) { return hunt_lab_from_rgb(glm::clamp(rgb_from_opponent(c), 0.0, 1.0)); });
}

/// The distance to the power 0.7, mapped to [0, 1]: 40 % of the largest one (green to blue) at 0.95.
double colour_difference(const Colour& a, const Colour& b) {
  static const double largest = std::pow(hyab(hunt_lab_from_rgb({0, 1, 0}), hunt_lab_from_rgb({0, 0, 1})), 0.7);
  const double knee = 0.4 * largest, d = std::pow(hyab(a, b), 0.7);
  return d < knee ? 0.95 * d / knee : 0.95 + 0.05 * (d - knee) / (largest - knee);
}

// --- feature pipeline ---

/// Positive weights sum to 1, negative ones to -1 (of the two-dimensional filter, whose other factor is positive).
Kernel balanced(Kernel kernel) {
  double positive = 0, negative = 0;
  for (const double w : kernel) (w > 0 ? positive : negative) += w;
  for (double& w : kernel) w /= w > 0 ? positive : -negative;
  return kernel;
}

/// Magnitudes of edges and points of the luminance in [0, 1].
struct Features {
  Plane edges, points;
};

Features features(const Picture& opponent) {
  const double sd = 0.5 * 0.082 * flip_pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * sd)), width = opponent.width, height = opponent.height;
  const auto bell = [sd](double x) { return std::exp(-x * x / (2 * sd * sd)); };
  const Kernel smooth = normalised(kernel_of(radius, bell));
  const Kernel first = balanced(kernel_of(radius, [&](double x) { return -x * bell(x); }));
  const Kernel second = balanced(kernel_of(radius, [&](double x) { return (x * x / (sd * sd) - 1) * bell(x); }));
  Plane y = opponent.plane[0];
  for (double& v : y) v = (v + 16) / 116;
  const auto magnitude = [&](const Kernel& derivative) {
    Plane dx = filter(y, width, height, derivative, smooth);
    const Plane dy = filter(y, width, height, smooth, derivative);
    for (std::size_t p = 0; p < dx.size(); ++p) dx[p] = std::hypot(dx[p], dy[p]);
    return dx;
  };
  return {magnitude(first), magnitude(second)};
}

Plane ldr_flip(const Picture& image, const Picture& reference) {
  const Picture i = mapped(image, opponent_from_rgb), r = mapped(reference, opponent_from_rgb);
  const Picture seen_i = seen(i), seen_r = seen(r);
  const Features fi = features(i), fr = features(r);
  Plane map(i.size());
  for (std::size_t p = 0; p < map.size(); ++p) {
    const double feature =
        std::max(std::abs(fi.edges[p] - fr.edges[p]), std::abs(fi.points[p] - fr.points[p])) / std::numbers::sqrt2;
    map[p] = std::pow(colour_difference(seen_i.at(p), seen_r.at(p)), 1 - std::sqrt(feature));
  }
  return map;
}

// --- exposures ---

// (k0 x^2 + k1 x) / (k3 x^2 + k4 x + k5): the ACES curve with its pre-exposure of 0.6 taken out.
constexpr double k0 = 0.6 * 0.6 * 2.51, k1 = 0.6 * 0.03, k3 = 0.6 * 0.6 * 2.43, k4 = 0.6 * 0.59, k5 = 0.14;

double tone_mapped(double x) {
  if (!(x < 1e100)) return 1;
  return std::clamp((k0 * x * x + k1 * x) / (k3 * x * x + k4 * x + k5), 0.0, 1.0);
}

/// The x that the curve maps to 0.85.
double tone_mapped_inverse_085() {
  constexpr double t = 0.85, a = k0 - t * k3, b = k1 - t * k4, c = -t * k5;
  return (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
}

Picture exposed(const Picture& picture, double stops) {
  const double scale = std::exp2(stops);
  return mapped(picture, [scale](const Colour& c) {
    return Colour(tone_mapped(scale * std::max(c.x, 0.0)), tone_mapped(scale * std::max(c.y, 0.0)),
                  tone_mapped(scale * std::max(c.z, 0.0)));
  });
}

Colour clipped(const Colour& c) { return glm::clamp(c, 0.0, 1.0); }

}  // namespace

std::vector<double> ldr_flip(const Comparison& c) {
  return ldr_flip(mapped(make_picture(c, c.image), clipped), mapped(make_picture(c, c.reference), clipped));
}

FlipExposures flip_exposures(const Comparison& c) {
  const Plane y = luminance(c.reference);
  Plane compared;
  for (const std::size_t p : c.pixels) compared.push_back(y[p]);
  const double brightest = *std::max_element(compared.begin(), compared.end());
  if (!(brightest > 0)) return {};
  const auto middle = compared.begin() + static_cast<std::ptrdiff_t>(compared.size() / 2);
  std::nth_element(compared.begin(), middle, compared.end());
  // As published: a dark half of the picture doesn't make the last exposure infinite.
  const double median = std::max(*middle, static_cast<double>(std::numeric_limits<float>::epsilon()));
  const double x = tone_mapped_inverse_085();
  FlipExposures e{std::log2(x / brightest), std::log2(x / std::min(median, brightest)), 2};
  e.count = std::max(2, static_cast<int>(std::ceil(e.last - e.first)));
  return e;
}

std::vector<double> hdr_flip(const Comparison& c) {
  const Picture image = make_picture(c, c.image), reference = make_picture(c, c.reference);
  const FlipExposures e = flip_exposures(c);
  Plane largest(image.size(), 0.0);
  for (int k = 0; k < e.count; ++k) {
    const double stops = e.first + k * (e.last - e.first) / (e.count - 1);
    const Plane map = ldr_flip(exposed(image, stops), exposed(reference, stops));
    for (std::size_t p = 0; p < map.size(); ++p) largest[p] = std::max(largest[p], map[p]);
  }
  return largest;
}

double mean_over_compared(const Comparison& c, const std::vector<double>& map) {
  double sum = 0;
  for (const std::size_t p : c.pixels) sum += map[p];
  return sum / static_cast<double>(c.pixels.size());
}

}  // namespace opaline
