// Complex numbers over any scalar. std::complex is specified for float, double and long double only; the formulas here
// are also evaluated with dual numbers and in 100 digits.
#pragma once

#include <cmath>
#include <type_traits>

namespace opaline {

template <typename T>
struct Complex {
  T re{}, im{};

  Complex() = default;
  Complex(T real, T imaginary = T(0.0)) : re(real), im(imaginary) {}
  explicit Complex(double real) requires(!std::is_same_v<T, double>) : re(real), im(0.0) {}

  Complex operator-() const { return {T(-re), T(-im)}; }
  friend Complex operator+(const Complex& a, const Complex& b) { return {T(a.re + b.re), T(a.im + b.im)}; }
  friend Complex operator-(const Complex& a, const Complex& b) { return {T(a.re - b.re), T(a.im - b.im)}; }
  friend Complex operator*(const Complex& a, const Complex& b) {
    return {T(a.re * b.re - a.im * b.im), T(a.re * b.im + a.im * b.re)};
  }
  friend Complex operator*(const Complex& a, const T& k) { return {T(a.re * k), T(a.im * k)}; }
  friend Complex operator*(const T& k, const Complex& a) { return a * k; }
  friend Complex operator/(const Complex& a, const Complex& b) {
    const T n = b.re * b.re + b.im * b.im;
    return {T((a.re * b.re + a.im * b.im) / n), T((a.im * b.re - a.re * b.im) / n)};
  }
  friend bool operator==(const Complex& a, double k) { return a.re == k && a.im == 0.0; }
};

/// The root with a real part >= 0.
template <typename T>
Complex<T> sqrt(const Complex<T>& z) {
  using std::abs;
  using std::sqrt;
  if (z.im == T(0.0)) {
    if (z.re == T(0.0)) return {};
    return z.re > T(0.0) ? Complex<T>(T(sqrt(z.re))) : Complex<T>(T(0.0), T(sqrt(T(-z.re))));
  }
  const T larger = sqrt(T((sqrt(T(z.re * z.re + z.im * z.im)) + abs(z.re)) * T(0.5))), other = z.im / (T(2.0) * larger);
  if (z.re >= T(0.0)) return {larger, other};
  return z.im > T(0.0) ? Complex<T>(other, larger) : Complex<T>(T(-other), T(-larger));
}

template <typename T>
Complex<T> exp(const Complex<T>& z) {
  using std::cos;
  using std::exp;
  using std::sin;
  const T size = exp(z.re);
  return {T(size * cos(z.im)), T(size * sin(z.im))};
}

/// exp(z) - 1 without cancellation.
template <typename T>
Complex<T> expm1(const Complex<T>& z) {
  using std::cos;
  using std::exp;
  using std::expm1;
  using std::sin;
  const T half = sin(T(z.im * T(0.5)));
  return {T(expm1(z.re) * cos(z.im) - T(2.0) * half * half), T(exp(z.re) * sin(z.im))};
}

}  // namespace opaline
