#include "render/layered/kernel_spectrum.h"

#include "model/quadrature.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace opaline {
namespace {

/// int f(t/k) J_0(t) t dt as a sum over fixed t: the trapezoid rule in u with t = log(1 + exp(u)), which is logarithmic
/// at small t and linear at large. The integrand is faded out from t = 30 to 70: the profile is smooth on the scale of
/// its argument, so nothing is left there but an alternating tail.
struct HankelRule {
  std::vector<double> t, weight;
  HankelRule() {
    constexpr double step = 0.3;
    for (double u = -30; u < 72; u += step) {
      const double at = std::log1p(std::exp(u)), slope = 1 / (1 + std::exp(-u));
      t.push_back(at);
      weight.push_back(step * slope * at * ::j0(at) * 0.5 * std::erfc((at - 50) / 8));
    }
  }
};

const HankelRule& hankel_rule() {
  static const HankelRule rule;
  return rule;
}

/// 1 before the cut-off, 0 after it.
double kept(double r, const CutOff& cut) {
  const double middle = 0.5 * (cut.start + cut.end), width = 0.2 * (cut.end - cut.start);
  return 0.5 * std::erfc((r - middle) / width);
}

/// Radii and weights (2 pi r dr and the cut-off) that integrate anything smooth on the scale of r, and J_0(k r) up to
/// k = 150 / start: octaves from the axis outwards, then equal steps.
struct CutRule {
  std::vector<double> r, weight;
  CutRule(const CutOff& cut, double core) {
    const double step = cut.end / 14;
    add(0, core / 64, cut);
    for (double a = core / 64; a < step; a *= 2) add(a, std::min(2 * a, step), cut);
    for (int i = 1; i < 14; ++i) add(i * step, (i + 1) * step, cut);
  }

 private:
  // The Gauss-Legendre rule on [a, b], caught node by node: a weight is the rule applied to an indicator.
  void add(double a, double b, const CutOff& cut) {
    std::vector<double> nodes;
    gauss_legendre(a, b, [&](double x) { return nodes.push_back(x), 0.0; });
    for (const double x : nodes) {
      r.push_back(x);
      weight.push_back(2 * pi * x * kept(x, cut) * gauss_legendre(a, b, [&](double y) { return x == y ? 1.0 : 0.0; }));
    }
  }
};

}  // namespace

PlaneSpectrum::PlaneSpectrum(const Profile& profile)
    : profile_(profile), closed_(profile.plane_spectrum(0, 0).has_value()), r_max_(1e6 * profile.core_radius()) {
  if (!closed_) table_ = ProfileTable([&](double r) { return profile.evaluate(r); }, profile.core_radius(), r_max_);
}

double PlaneSpectrum::evaluate(double d) const {
  if (closed_) return profile_.evaluate(d);
  return d < 0.9 * r_max_ ? static_cast<double>(table_(static_cast<float>(d * d))) : 0;
}

double PlaneSpectrum::by_hankel(double k, double z) const {
  if (k * profile_.core_radius() < 1e-8) k = 1e-8 / profile_.core_radius();
  const HankelRule& rule = hankel_rule();
  double sum = 0;
  for (std::size_t i = 0; i < rule.t.size(); ++i) sum += rule.weight[i] * evaluate(std::hypot(rule.t[i] / k, z));
  return 2 * pi * sum / (k * k);
}

double PlaneSpectrum::operator()(double k, double z) const {
  return closed_ ? *profile_.plane_spectrum(k, z) : by_hankel(k, z);
}

double KernelTable::node(int entry) const {
  const auto x = std::bit_cast<float>((first_ + entry) << shift);
  return std::sqrt(std::max(0.0, static_cast<double>(x) - static_cast<double>(offset_)));
}

KernelTable::KernelTable(const PlaneSpectrum& spectrum, const std::vector<double>& distances, double k_max,
                         const CutOff& cut) {
  // Near k = 0 the steps are offset / 64 in k^2: an eighth of 1 / range in k.
  const auto wanted = static_cast<float>(1 / (cut.range * cut.range));
  offset_ = std::bit_cast<float>((std::bit_cast<std::int32_t>(wanted) >> shift) << shift);
  first_ = std::bit_cast<std::int32_t>(offset_) >> shift;
  entries_ = (std::bit_cast<std::int32_t>(static_cast<float>(k_max * k_max) * 1.0001f + offset_) >> shift) - first_ + 2;
  values_.resize(distances.size() * static_cast<std::size_t>(entries_));
  int by_cut = 0;
  while (cut.finite() && by_cut < entries_ && node(by_cut) < 150 / cut.start) ++by_cut;
  tbb::parallel_for(std::size_t{0}, distances.size(), [&](std::size_t d) {
    float* out = values_.data() + d * static_cast<std::size_t>(entries_);
    for (int e = by_cut; e < entries_; ++e) out[e] = static_cast<float>(spectrum(node(e), distances[d]));
  });
  if (by_cut > 0) fill_cut(spectrum, distances, cut, by_cut);
}

void KernelTable::fill_cut(const PlaneSpectrum& spectrum, const std::vector<double>& distances, const CutOff& cut,
                           int entries) {
  const CutRule rule(cut, spectrum.core_radius());
  const std::size_t radii = rule.r.size();
  std::vector<double> bessel(static_cast<std::size_t>(entries) * radii);
  tbb::parallel_for(0, entries, [&](int e) {
    for (std::size_t i = 0; i < radii; ++i) bessel[static_cast<std::size_t>(e) * radii + i] = ::j0(node(e) * rule.r[i]);
  });
  tbb::parallel_for(std::size_t{0}, distances.size(), [&](std::size_t d) {
    std::vector<double> f(radii);
    for (std::size_t i = 0; i < radii; ++i)
      f[i] = rule.weight[i] * spectrum.evaluate(std::hypot(rule.r[i], distances[d]));
    for (int e = 0; e < entries; ++e) {
      const double* j = bessel.data() + static_cast<std::size_t>(e) * radii;
      double sum = 0;
      for (std::size_t i = 0; i < radii; ++i) sum += f[i] * j[i];
      values_[d * static_cast<std::size_t>(entries_) + static_cast<std::size_t>(e)] = static_cast<float>(sum);
    }
  });
}

}  // namespace opaline
