#include "model/transport/ray_rule.h"

#include "model/check.h"
#include "model/conventions.h"
#include "model/fresnel.h"

#include <cmath>

namespace opaline {
namespace {

struct Point {
  double at, weight;
};

/// Gauss-Legendre on [0, 1], the nodes by Newton's method.
std::vector<Point> gauss_unit(int n) {
  std::vector<Point> rule;
  for (int i = 0; i < n; ++i) {
    double z = std::cos(pi * (i + 0.75) / (n + 0.5)), slope = 1;
    for (int step = 0; step < 20; ++step) {
      double p = 1, before = 0;
      for (int j = 0; j < n; ++j) {
        const double next = ((2 * j + 1) * z * p - j * before) / (j + 1);
        before = p;
        p = next;
      }
      slope = n * (z * p - before) / (z * z - 1);
      z -= p / slope;
    }
    rule.push_back({0.5 * (1 - z), 1 / ((1 - z * z) * slope * slope)});
  }
  return rule;
}

/// A rule on [0, end] for what varies on the scale `width` near 0 and by factors beyond: Gauss in v, at = width sinh v.
/// `base` nodes, and `each` more for every unit of v.
std::vector<Point> graded(double end, double width, double base, double each) {
  const double last = std::asinh(end / width);
  std::vector<Point> rule = gauss_unit(static_cast<int>(std::ceil(base + each * last)));
  for (Point& p : rule) {
    const double v = last * p.at;
    p = {width * std::sinh(v), width * std::cosh(v) * last * p.weight};
  }
  return rule;
}

/// A rule on [0, end] for what goes like sqrt(at) or at log(at) near 0.
std::vector<Point> root_graded(double end, int n) {
  std::vector<Point> rule = gauss_unit(n);
  for (Point& p : rule) p = {end * p.at * p.at, 2 * end * p.at * p.weight};
  return rule;
}

class Maker {
 public:
  Maker(double k_squared, double eta, double resolution)
      : k_(std::sqrt(std::abs(k_squared))), falling_(k_squared < 0), eta_(eta), resolution_(resolution) {}

  RayRule make() {
    const double a_squared = (eta_ - 1) * (eta_ + 1), a = std::sqrt(a_squared), critical = a / eta_;
    if (eta_ > 1) {
      for (const Point& mu : root_graded(critical, count(12)))
        add(mu.at, std::sqrt((1 - mu.at) * (1 + mu.at)), mu.weight, 1, 0);
    }
    // The escape cone in two parts: around the normal by the sine inside, up to sine .8 and cosine .6 outside; near
    // grazing by the cosine outside.
    constexpr double outer_cosine = 0.6, outer_sine = 0.8;
    const double sine_end = outer_sine / eta_, width = 1 / std::max(k_, 1e-3);
    for (const Point& s : graded(sine_end, width, 6 * resolution_, 2.5 * resolution_)) {
      const double mu = std::sqrt((1 - s.at) * (1 + s.at)), sine = eta_ * s.at;
      add_escaping(mu, s.at, s.weight * s.at / mu, std::sqrt((1 - sine) * (1 + sine)));
    }
    const std::vector<Point> grazing =
        eta_ > 1 ? graded(outer_cosine, a, 8 * resolution_, 1.5 * resolution_) : root_graded(outer_cosine, count(14));
    for (const Point& c : grazing) {
      const double mu = std::sqrt(c.at * c.at + a_squared) / eta_;
      add_escaping(mu, std::sqrt((1 - c.at) * (1 + c.at)) / eta_, c.weight * c.at / (eta_ * eta_ * mu), c.at);
    }
    return std::move(rule_);
  }

 private:
  int count(double n) const { return static_cast<int>(std::ceil(n * resolution_)); }

  void add_escaping(double mu, double sine, double weight, double outer_cosine) {
    add(mu, sine, weight, fresnel_reflectance(outer_cosine, eta_), fresnel_transmittance(outer_cosine, eta_));
  }

  /// All azimuths at one mu; `weight` is dmu.
  void add(double mu, double sine, double weight, double reflectance, double transmittance) {
    const double a = k_ * sine;
    const auto push = [&](std::complex<double> slant, double azimuth_weight) {
      rule_.x.push_back(mu / slant);
      rule_.reflected.push_back(weight * azimuth_weight * reflectance / mu);
      rule_.transmitted.push_back(weight * azimuth_weight * transmittance);
    };
    if (falling_) {  // x is real and its own mirror image: half the weight; period pi by symmetry
      const int n = std::min(300, count(4 + 16 / std::acosh(1 / a)));
      for (int i = 0; i < n; ++i) push(1 - a * std::cos(pi * (i + 0.5) / n), pi / n);
    } else if (k_ == 0) {
      push(1, pi);
    } else {  // a quarter turn from phi = pi/2, where x varies over angles of 1/a; the other quarters mirror it
      for (const Point& angle : graded(pi / 2, 1 / std::max(a, 1e-3), 4 * resolution_, 3.5 * resolution_))
        push({1, -a * std::sin(angle.at)}, 2 * angle.weight);
    }
  }

  double k_;
  bool falling_;
  double eta_, resolution_;
  RayRule rule_;
};

}  // namespace

RayRule make_ray_rule(double k_squared, double eta, double resolution) {
  OPALINE_CHECK(eta >= 1 && k_squared > -1 && resolution > 0);
  return Maker(k_squared, eta, resolution).make();
}

}  // namespace opaline
