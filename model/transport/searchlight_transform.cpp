#include "model/transport/searchlight_transform.h"

#include "model/conventions.h"
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
      : k_squared_(k_squared), reflecting_(eta > 1), rule_(make_ray_rule(k_squared, eta, resolution)) {
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

  double multiple(double albedo) const {
    const ModulatedH h(albedo, k_squared_);
    const double beam = h.minus_one(1).real();
    Vector scattered(static_cast<Eigen::Index>(rule_.x.size()));  // H - 1 at the rays
    for (Eigen::Index i = 0; i < scattered.size(); ++i) scattered[i] = h.minus_one(x(i));
    const Vector again = from_boundary(albedo, scattered, 1 + beam);
    double sum = 0;
    for (Eigen::Index i = 0; i < scattered.size(); ++i) {
      const Complex others = (beam + scattered[i] * (1 + beam)) / (1.0 + x(i));
      const Complex left = x(i) * (others + (1.0 + scattered[i]) * again[i]);
      sum += 2 * rule_.transmitted[static_cast<std::size_t>(i)] * left.real();
    }
    return albedo / (4 * pi) * sum;
  }

 private:
  Complex x(Eigen::Index i) const { return rule_.x[static_cast<std::size_t>(i)]; }

  /// Y(x) - H(1)/(1 + x).
  Vector from_boundary(double albedo, const Vector& scattered, double h_of_beam) const {
    const Eigen::Index n = scattered.size();
    if (!reflecting_) return Vector::Zero(n);
    Vector strength(n), first(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Complex xh = x(i) * (1.0 + scattered[i]);
      strength[i] = albedo / (4 * pi) * rule_.reflected[static_cast<std::size_t>(i)] * xh * xh;
      first[i] = h_of_beam / (1.0 + x(i));
    }
    const auto reflect = [&](const Vector& y) -> Vector {
      const Vector down = strength.cwiseProduct(y);
      return same_ * down + mirrored_ * down.conjugate();
    };
    return reflect(solve(reflect, first));
  }

  double k_squared_;
  bool reflecting_;
  RayRule rule_;
  Eigen::MatrixXcd same_, mirrored_;
};

}  // namespace

std::vector<double> searchlight_transform(double k_squared, double eta, std::span<const double> albedos,
                                          double resolution) {
  const Transform transform(k_squared, eta, resolution);
  std::vector<double> values;
  for (const double albedo : albedos) values.push_back(transform.multiple(albedo));
  return values;
}

}  // namespace opaline
