#include "model/transport/searchlight_transform.h"

#include "model/conventions.h"
#include "model/fresnel.h"
#include "model/transport/modulated_h.h"
#include "model/transport/ray_rule.h"

#include <Eigen/Dense>

#include <functional>

namespace opaline {
namespace {

using Complex = std::complex<double>;
using Vector = Eigen::VectorXcd;

/// Solves y - operation(y) = right by GMRES. `operation` is linear over the reals (it conjugates), so the inner product
/// is a real one.
Vector solve(const std::function<Vector(const Vector&)>& operation, const Vector& right) {
  constexpr int most_steps = 60;
  constexpr double tolerance = 1e-13;
  const double length = right.norm();
  std::vector<Vector> basis = {right / length};
  Eigen::MatrixXd projected = Eigen::MatrixXd::Zero(most_steps + 1, most_steps);
  Eigen::VectorXd coefficients;
  for (int j = 0; j < most_steps; ++j) {
    const Vector& newest = basis.back();
    Vector next = newest - operation(newest);
    for (int i = 0; i <= j; ++i) {
      projected(i, j) = basis[static_cast<std::size_t>(i)].dot(next).real();
      next -= projected(i, j) * basis[static_cast<std::size_t>(i)];
    }
    projected(j + 1, j) = next.norm();
    const Eigen::MatrixXd block = projected.topLeftCorner(j + 2, j + 1);
    const Eigen::VectorXd aim = length * Eigen::VectorXd::Unit(j + 2, 0);
    coefficients = block.householderQr().solve(aim);
    if ((block * coefficients - aim).norm() <= tolerance * length) break;
    basis.push_back(next / projected(j + 1, j));
  }
  Vector sum = Vector::Zero(right.size());
  for (int i = 0; i < coefficients.size(); ++i) sum += coefficients[i] * basis[static_cast<std::size_t>(i)];
  return sum;
}

/// One wave number and boundary; any albedo.
class Transform {
 public:
  Transform(double k_squared, double eta, double resolution)
      : k_squared_(k_squared), eta_(eta), reflecting_(eta > 1), rule_(make_ray_rule(k_squared, eta, resolution)) {
    if (!reflecting_) return;
    const auto n = static_cast<Eigen::Index>(rule_.x.size());
    same_.resize(n, n);
    mirrored_.resize(n, n);
    for (Eigen::Index j = 0; j < n; ++j) {
      for (Eigen::Index i = 0; i < n; ++i) {
        same_(i, j) = 1.0 / (x(i) + x(j));
        mirrored_(i, j) = 1.0 / (x(i) + std::conj(x(j)));
      }
    }
  }

  double multiple(double albedo, SearchlightExit exit) const {
    const ModulatedH h(albedo, k_squared_);
    const double beam = h.minus_one(1).real();
    Vector scattered(static_cast<Eigen::Index>(rule_.x.size()));  // H - 1 at the rays
    for (Eigen::Index i = 0; i < scattered.size(); ++i) scattered[i] = h.minus_one(x(i));
    const Vector down = sent_down(albedo, scattered, 1 + beam);
    return exit == SearchlightExit::exitance ? exitance(albedo, scattered, beam, down)
                                             : radiance_up(albedo, beam, down);
  }

 private:
  Complex x(Eigen::Index i) const { return rule_.x[static_cast<std::size_t>(i)]; }

  double exitance(double albedo, const Vector& scattered, double beam, const Vector& down) const {
    const Vector again = reflecting_ ? reflect(down) : Vector::Zero(scattered.size());
    double sum = 0;
    for (Eigen::Index i = 0; i < scattered.size(); ++i) {
      const Complex others = (beam + scattered[i] * (1 + beam)) / (1.0 + x(i));
      const Complex left = x(i) * (others + (1.0 + scattered[i]) * again[i]);
      sum += 2 * rule_.transmitted[static_cast<std::size_t>(i)] * left.real();
    }
    return albedo / (4 * pi) * sum;
  }

  double radiance_up(double albedo, double beam, const Vector& down) const {
    double again = 0;  // Y(1) - H(1)/2
    for (Eigen::Index i = 0; i < down.size(); ++i) again += 2 * (down[i] / (1.0 + x(i))).real();
    const double multiple = (2 + beam) * beam / 2 + (1 + beam) * again;
    return albedo / 4 * diffuse_transmittance_external(eta_) / (eta_ * eta_) * multiple;
  }

  /// What the boundary sends down, (albedo/4 pi) (F/mu) x^2 H^2 Y times the weights; empty without a boundary.
  Vector sent_down(double albedo, const Vector& scattered, double h_of_beam) const {
    const Eigen::Index n = reflecting_ ? scattered.size() : 0;
    Vector strength(n), first(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Complex xh = x(i) * (1.0 + scattered[i]);
      strength[i] = albedo / (4 * pi) * rule_.reflected[static_cast<std::size_t>(i)] * xh * xh;
      first[i] = h_of_beam / (1.0 + x(i));
    }
    if (!reflecting_) return first;
    return strength.cwiseProduct(solve([&](const Vector& y) { return reflect(strength.cwiseProduct(y)); }, first));
  }

  /// Y(x) - H(1)/(1 + x) at the rays.
  Vector reflect(const Vector& down) const { return same_ * down + mirrored_ * down.conjugate(); }

  double k_squared_, eta_;
  bool reflecting_;
  RayRule rule_;
  Eigen::MatrixXcd same_, mirrored_;
};

}  // namespace

std::vector<double> searchlight_transform(double k_squared, double eta, std::span<const double> albedos,
                                          double resolution, SearchlightExit exit) {
  const Transform transform(k_squared, eta, resolution);
  std::vector<double> values;
  for (const double albedo : albedos) values.push_back(transform.multiple(albedo, exit));
  return values;
}

}  // namespace opaline
