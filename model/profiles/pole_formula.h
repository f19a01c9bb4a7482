// No include guard, on purpose. The pole and the dipole as functions of q = r^2, for any scalar. Included by poles.h,
// and once for every vector target by dipole_batch.cpp inside that target's namespace: a template compiled for the
// baseline can't be inlined there.
//
// Expects in scope, for T: choose(condition, a, b), inverse_sqrt(x), screening_of_product(a, b, inverse_root_of_b),
// largest_exponent<T>, and pi.

/// (1 + y) exp(-y), 0 beyond y = largest_exponent<T>.
template <typename T>
T screening_at(const T& y) {
  using std::exp;
  return choose(y < largest_exponent<T>, T((1.0 + y) * exp(-y)), T(0.0));
}

/// P as a function of q = r^2 and sigma^2: no square root of an argument, so smooth in both.
template <typename T>
T pole_evaluate_squared(const T& q, const T& z, const T& sigma_squared) {
  const T d_squared = q + z * z;
  const T inverse_d = inverse_sqrt(d_squared);
  // In this order neither d^3 nor its derivatives overflow.
  return screening_of_product(sigma_squared, d_squared, inverse_d) * (0.5 / pi * z * inverse_d) *
         (inverse_d * inverse_d);
}

/// The sum of two poles, per transmitted flux.
template <typename T>
T dipole_evaluate_squared(const T& q, const T& alpha_prime, const T& z_r, const T& z_v, const T& sigma_squared) {
  return 0.5 * alpha_prime *
         (pole_evaluate_squared(q, z_r, sigma_squared) + pole_evaluate_squared(q, z_v, sigma_squared));
}
