// The 100-digit scalar that `opaline stress` holds the formulas against.
//
// Constants that a formula states as doubles (pi, 4/3, quadrature nodes) are the same doubles here: what is measured is
// rounding and cancellation in the formula, not those constants (pi's own error is 0.4 units in the last place).
#pragma once

#include "model/fresnel_moments.h"

#include <boost/multiprecision/mpfr.hpp>

namespace opaline {

/// Without expression templates, as the formulas' templates want it.
using Wide =
    boost::multiprecision::number<boost::multiprecision::mpfr_float_backend<100, boost::multiprecision::allocate_stack>,
                                  boost::multiprecision::et_off>;

namespace fresnel_detail {

/// In 100 digits the closed form's cancellation costs at most 20 of them above x = 1e-3: faster than hundreds of
/// terms, and independent of the series that double precision uses.
template <>
Wide entering_series<Wide>(const Wide& x);

/// The series, remembering the last few results: the reference is evaluated many times at one eta.
template <>
Wide second_series<Wide>(Side side, const Wide& x);

}  // namespace fresnel_detail
}  // namespace opaline
