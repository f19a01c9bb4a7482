#include "model/transport/h_function.h"

#include "model/conventions.h"
#include "model/fresnel.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace opaline {
namespace {

using Values = std::vector<double>;

/// Quadrature nodes on [0, 1], with values there of whatever is being solved for.
struct Rule {
  Values mu, weight;
};

/// Adds [a, b] by the tanh-sinh rule: exact to rounding in spite of H's x log x at 0 and the Fresnel root at the
/// critical cosine, if those are ends.
void add_interval(double a, double b, Rule& rule) {
  constexpr double step = 0.0625, half_pi = pi / 2;
  for (int i = -50; i <= 50; ++i) {
    const double k = i * step, e = std::exp(-2 * half_pi * std::sinh(std::abs(k)));
    const double distance = (b - a) * e / (1 + e);  // from the nearer end, without cancellation
    rule.mu.push_back(i < 0 ? a + distance : b - distance);
    rule.weight.push_back((b - a) * 2 * step * half_pi * std::cosh(k) * e / ((1 + e) * (1 + e)));
  }
}

double critical_cosine(double eta) { return eta > 1 ? std::sqrt((1 - 1 / eta) * (1 + 1 / eta)) : 0; }

Rule make_rule(double eta) {
  Rule rule;
  const double critical = critical_cosine(eta);
  if (critical > 0) add_interval(0, critical, rule);
  add_interval(critical, 1, rule);
  return rule;
}

/// int_0^1 H(u) u/(mu + u) f(u) du; f = 1 without one.
double h_average(const Rule& rule, const Values& h, double mu, const Values* f = nullptr) {
  double sum = 0;
  for (std::size_t j = 0; j < rule.mu.size(); ++j) {
    const double term = rule.weight[j] * h[j] * rule.mu[j] / (mu + rule.mu[j]);
    sum += f ? term * (*f)[j] : term;
  }
  return sum;
}

/// 1/H(mu) = sqrt(1 - albedo) + (albedo/2) int u H(u)/(mu + u) du.
double next_h(const Rule& rule, const Values& h, double albedo, double mu) {
  return 1 / (std::sqrt(1 - albedo) + albedo / 2 * h_average(rule, h, mu));
}

/// H at the nodes. Plain iteration swings around the solution; the mean of two steps converges at every albedo.
Values solve_h(const Rule& rule, double albedo) {
  Values h(rule.mu.size(), 1), next(h);
  for (int iteration = 0; iteration < 200; ++iteration) {
    double change = 0;
    for (std::size_t i = 0; i < h.size(); ++i) next[i] = 0.5 * (h[i] + next_h(rule, h, albedo, rule.mu[i]));
    for (std::size_t i = 0; i < h.size(); ++i) change = std::max(change, std::abs(next[i] - h[i]));
    h.swap(next);
    if (change < 1e-13) break;
  }
  return h;
}

/// The half space as a mirror. Light I(u) going down just below the surface comes back up as
///   K I (mu) = (albedo/2) H(mu) int_0^1 H(u) u/(mu + u) I(u) du      (invariance, Chandrasekhar 1950)
/// and the boundary sends F(mu) of it down again: I_up = K I_in + K (F I_up), summed here as a Neumann series of
/// internal reflections, each at most the internal diffuse reflectance of the one before.
struct HalfSpace {
  Rule rule;
  double albedo;
  Values h, reflected, transmitted;  // F and 1 - F of light from inside

  HalfSpace(double albedo_, double eta) : rule(make_rule(eta)), albedo(albedo_), h(solve_h(rule, albedo_)) {
    for (const double mu : rule.mu) {
      reflected.push_back(fresnel_reflectance(mu, 1 / eta));
      transmitted.push_back(fresnel_transmittance(mu, 1 / eta));
    }
  }

  Values mirror(const Values& down) const {
    Values up;
    for (std::size_t i = 0; i < h.size(); ++i) up.push_back(albedo / 2 * h[i] * h_average(rule, h, rule.mu[i], &down));
    return up;
  }

  /// All that comes up, given what comes up before any internal reflection.
  Values with_reflections(const Values& first) const {
    Values sum = first, order = first;
    for (int i = 0; i < 2000; ++i) {
      for (std::size_t j = 0; j < order.size(); ++j) order[j] *= reflected[j];
      order = mirror(order);
      double largest = 0;
      for (std::size_t j = 0; j < sum.size(); ++j) largest = std::max(largest, order[j] / (sum[j] += order[j]));
      if (largest < 1e-13) break;
    }
    return sum;
  }

  /// Flux that leaves: 2 pi int (1 - F) I mu dmu.
  double leaving(const Values& up) const {
    double sum = 0;
    for (std::size_t i = 0; i < up.size(); ++i) sum += rule.weight[i] * transmitted[i] * up[i] * rule.mu[i];
    return 2 * pi * sum;
  }

  /// Light that comes up at once from a beam of unit flux going down with cosine u: I = delta/(2 pi u).
  Values from_beam(double u) const {
    const double h_u = next_h(rule, h, albedo, u);
    Values up;
    for (std::size_t i = 0; i < h.size(); ++i) up.push_back(albedo * h[i] * h_u / (4 * pi * (rule.mu[i] + u)));
    return up;
  }

  /// From diffuse light of unit irradiance outside: radiance 1/pi, (1 - F) eta^2/pi inside the critical cone.
  Values from_diffuse(double eta) const {
    Values down;
    for (const double t : transmitted) down.push_back(t * eta * eta / pi);
    return mirror(down);
  }
};

void require(bool condition, const char* what) {
  if (!condition) throw std::invalid_argument(std::string("half space: ") + what);
}

}  // namespace

double chandrasekhar_h(double albedo, double mu) {
  require(albedo >= 0 && albedo <= 1, "albedo must be in [0, 1]");
  require(mu >= 0 && mu <= 1, "mu must be in [0, 1]");
  const Rule rule = make_rule(1);
  return mu == 0 ? 1 : next_h(rule, solve_h(rule, albedo), albedo, mu);
}

HalfSpaceAlbedo half_space_albedo(double albedo, double eta, double cos_incident) {
  require(albedo >= 0 && albedo <= 1, "albedo must be in [0, 1]");
  require(eta >= 0.3 && eta <= 4, "eta must be in [0.3, 4]");
  require(cos_incident > 0 && cos_incident <= 1, "cos_incident must be in (0, 1]");
  const double sine = std::sqrt((1 - cos_incident) * (1 + cos_incident)) / eta;
  require(sine < 1, "the beam is reflected totally");
  const double cosine = std::sqrt((1 - sine) * (1 + sine));
  const HalfSpace half_space(albedo, eta);
  HalfSpaceAlbedo r;
  r.specular = fresnel_reflectance(cos_incident, eta);
  r.specular_white = diffuse_reflectance_external(eta);
  r.beam_per_transmitted = half_space.leaving(half_space.with_reflections(half_space.from_beam(cosine)));
  r.beam_per_incident = fresnel_transmittance(cos_incident, eta) * r.beam_per_transmitted;
  r.beam_with_specular = r.specular + r.beam_per_incident;
  r.white_per_incident = half_space.leaving(half_space.with_reflections(half_space.from_diffuse(eta)));
  r.white_with_specular = r.specular_white + r.white_per_incident;
  return r;
}

}  // namespace opaline
