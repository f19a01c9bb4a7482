// The pole and the dipole as functions of q = r^2, for any scalar. Included by poles.h, and once for every vector target
// by dipole_batch.cpp inside that target's namespace: a template compiled for the baseline can't be inlined there.
//
// Expects in scope, for T: choose(condition, a, b), inverse_sqrt(x), largest_exponent<T>, and pi.

/// (1 + y) exp(-y) with y = sqrt(t), t >= 0. Smooth in t to first order (derivative -exp(-y)/2), but
/// the derivative of sqrt is infinite at 0: a dual number (ceres::Jet: value `a`, gradient `v`) gets
/// the closed form, so that gradients stay exact down to sigma_a = 0. 0 beyond y = largest_exponent<T>.
template <typename T>
T screening(const T& t) {
  using std::exp;
  using std::sqrt;
  if constexpr (requires {
                  t.a;
                  t.v;
                }) {
    const auto y = sqrt(t.a);
    return y < largest_exponent<T> ? T(screening(t.a), t.v * (-0.5 * exp(-y))) : T(0.0);
  } else {
    const T y = sqrt(t);
    return choose(y < largest_exponent<T>, T((1.0 + y) * exp(-y)), T(0.0));
  }
}

/// P as a function of q = r^2 and sigma^2: no square root of an argument, so smooth in both.
template <typename T>
T pole_evaluate_squared(const T& q, const T& z, const T& sigma_squared) {
  const T d_squared = q + z * z;
  const T inverse_d = inverse_sqrt(d_squared);
  // In this order neither d^3 nor its derivatives overflow.
  return screening(T(sigma_squared * d_squared)) * (0.5 / pi * z * inverse_d) * (inverse_d * inverse_d);
}

/// The sum of two poles, per transmitted flux.
template <typename T>
T dipole_evaluate_squared(const T& q, const T& alpha_prime, const T& z_r, const T& z_v, const T& sigma_squared) {
  return 0.5 * alpha_prime *
         (pole_evaluate_squared(q, z_r, sigma_squared) + pole_evaluate_squared(q, z_v, sigma_squared));
}
