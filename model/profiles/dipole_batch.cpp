#include "model/profiles/dipole_batch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "model/profiles/dipole_batch.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/float_lanes.h"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace opaline::HWY_NAMESPACE {

template <typename T>
constexpr double largest_exponent = 86;  // exp(-86) is still a normal float

template <typename T>
T screening_at(const T& y);

/// sqrt(a) is the same for all lanes and leaves the loop.
HWY_INLINE FloatLanes screening_of_product(const FloatLanes& a, const FloatLanes& b,
                                           const FloatLanes& inverse_root_of_b) {
  return screening_at(sqrt(a) * sqrt_by_inverse(b, inverse_root_of_b));
}

#include "model/profiles/pole_formula.h"

/// The coefficients of one channel on every lane.
struct DipoleLanes {
  FloatLanes alpha_prime, z_r, z_v, sigma_tr_squared;

  explicit DipoleLanes(const StandardDipole<double>& d)
      : alpha_prime(d.alpha_prime), z_r(d.z_r), z_v(d.z_v), sigma_tr_squared(d.sigma_tr_squared) {}

  HWY_INLINE void evaluate(const float* r2, float* out) const {
    const Floats::D d;
    const FloatLanes q({hn::LoadU(d, r2), hn::LoadU(d, r2 + hn::Lanes(d))}, 0.0f);
    const Floats value = dipole_evaluate_squared(q, alpha_prime, z_r, z_v, sigma_tr_squared).hi;
    hn::StoreU(value.a, d, out);
    hn::StoreU(value.b, d, out + hn::Lanes(d));
  }
};

HWY_FLATTEN void evaluate_dipoles_rgb(const StandardDipole<double> (&dipoles)[3], const float* r2, std::size_t n,
                                      float* const (&out)[3]) {
  const Floats::D d;
  const std::size_t step = 2 * hn::Lanes(d), whole = n / step * step;
  const DipoleLanes channel[3] = {DipoleLanes(dipoles[0]), DipoleLanes(dipoles[1]), DipoleLanes(dipoles[2])};
  for (std::size_t i = 0; i < whole; i += step) {  // written out: a loop over channels would keep nothing in registers
    channel[0].evaluate(r2 + i, out[0] + i);
    channel[1].evaluate(r2 + i, out[1] + i);
    channel[2].evaluate(r2 + i, out[2] + i);
  }
  if (whole == n) return;
  HWY_ALIGN float rest[2 * hn::MaxLanes(d)] = {}, value[2 * hn::MaxLanes(d)];
  std::copy(r2 + whole, r2 + n, rest);
  for (int c = 0; c < 3; ++c) {
    channel[c].evaluate(rest, value);
    std::copy(value, value + (n - whole), out[c] + whole);
  }
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace opaline {

HWY_EXPORT(evaluate_dipoles_rgb);

void evaluate_dipoles_rgb(const StandardDipole<double> (&dipoles)[3], const float* r2, std::size_t n,
                          float* const (&out)[3]) {
  HWY_DYNAMIC_DISPATCH(evaluate_dipoles_rgb)(dipoles, r2, n, out);
}

}  // namespace opaline
#endif
