// What the templates need to know about a scalar.
#pragma once

namespace opaline {

/// The number under a dual number (ceres::Jet), or any scalar, as a double.
template <typename T>
double value_of(const T& x) {
  if constexpr (requires { x.a; }) {
    return x.a;
  } else {
    return static_cast<double>(x);
  }
}

}  // namespace opaline
