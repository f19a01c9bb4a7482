#include "model/profile_table.h"

#include "model/check.h"

#include <array>
#include <cmath>

namespace opaline {
namespace {

/// Nodes of Gauss-Legendre quadrature on [-1, 1], which make the interpolation error orthogonal to polynomials.
constexpr std::array<double, 4> legendre4 = {-0.86113631159405258, -0.33998104358485626, 0.33998104358485626,
                                             0.86113631159405258};
constexpr std::array<double, 7> legendre7 = {-0.94910791234275852, -0.74153118559939444, -0.40584515137739717, 0,
                                             0.40584515137739717,  0.74153118559939444,  0.94910791234275852};

constexpr std::array<double, 9> legendre9 = {
    -0.96816023950762609, -0.83603110732663579, -0.61337143270059040, -0.32425342340380893, 0,
    0.32425342340380893,  0.61337143270059040,  0.83603110732663579,  0.96816023950762609};

template <std::size_t N>
constexpr const std::array<double, N>& legendre() {
  if constexpr (N == 4) return legendre4;
  if constexpr (N == 7) return legendre7;
  if constexpr (N == 9) return legendre9;
}

/// Coefficients in powers of u of the polynomial that takes value_at(u) at the nodes u = centre + half * node.
template <std::size_t N>
std::array<float, N> interpolate(double centre, double half, const std::function<double(double)>& value_at) {
  std::array<double, N> u, difference, c{};
  for (std::size_t i = 0; i < N; ++i) {
    u[i] = centre + half * legendre<N>()[i];
    difference[i] = value_at(u[i]);
  }
  for (std::size_t level = 1; level < N; ++level)
    for (std::size_t i = N - 1; i >= level; --i)
      difference[i] = (difference[i] - difference[i - 1]) / (u[i] - u[i - level]);
  c[0] = difference[N - 1];  // Newton form expanded, highest divided difference first
  for (std::size_t level = N - 1; level-- > 0;) {
    for (std::size_t k = N - 1; k > 0; --k) c[k] = c[k - 1] - u[level] * c[k];
    c[0] = difference[level] - u[level] * c[0];
  }
  std::array<float, N> rounded;
  for (std::size_t k = 0; k < N; ++k) rounded[k] = static_cast<float>(c[k]);
  return rounded;
}

std::int32_t segment_of(float x, int shift) { return std::bit_cast<std::int32_t>(x) >> shift; }
float start_of(std::int32_t segment, int shift) { return std::bit_cast<float>(segment << shift); }

double at_x(const std::function<double(double)>& profile, double x, float offset) {
  return profile(std::sqrt(std::fmax(x - static_cast<double>(offset), 0.0)));
}

}  // namespace

ProfileTable::ProfileTable(const std::function<double(double)>& profile, double core_radius, double r_max)
    : core_radius_(core_radius), r_max_(r_max) {
  OPALINE_CHECK(core_radius > 0 && r_max > 0);
  fill_rows(profile);
  if (!fill_columns<2>(profile)) fill_columns<1>(profile);
}

void ProfileTable::fill_rows(const std::function<double(double)>& profile) {
  // x0 sits on a segment boundary, so that the first segment starts at r = 0 exactly.
  first_segment_ = segment_of(static_cast<float>(core_radius_ * core_radius_ / 4), segment_shift);
  offset_ = start_of(first_segment_, segment_shift);
  last_segment_ = segment_of(static_cast<float>(r_max_ * r_max_) + offset_, segment_shift) - first_segment_;
  rows_.reserve(4 * (static_cast<std::size_t>(last_segment_) + 1));
  for (std::int32_t s = first_segment_; s <= first_segment_ + last_segment_; ++s) {
    const double lo = start_of(s, segment_shift), hi = start_of(s + 1, segment_shift);
    const auto cubic = interpolate<4>(0.5, 0.5, [&](double f) { return at_x(profile, lo + f * (hi - lo), offset_); });
    rows_.insert(rows_.end(), cubic.begin(), cubic.end());
  }
}

/// False, and the table stays without columns, if the range takes too many segments.
template <int PerOctave>
bool ProfileTable::fill_columns(const std::function<double(double)>& profile) {
  constexpr int shift = Registers::shift(PerOctave);
  // A dipole is smooth down to r^2 = -core_radius^2: a smaller offset would only add segments.
  first_register_ = segment_of(static_cast<float>(core_radius_ * core_radius_), shift);
  register_offset_ = start_of(first_register_, shift);
  const std::int32_t last = segment_of(static_cast<float>(r_max_ * r_max_) + register_offset_, shift);
  const std::int32_t count = last - first_register_ + 1;
  if (count > static_cast<std::int32_t>(Registers::entries)) return false;
  per_octave_ = PerOctave;
  register_x_max_ = std::bit_cast<float>(((last + 1) << shift) - 1);
  constexpr std::size_t coefficients = Registers::degree(PerOctave) + 1;
  columns_.assign(2 * coefficients, Line{});
  for (std::int32_t s = 0; s < count; ++s) {
    const double lo = start_of(first_register_ + s, shift), hi = start_of(first_register_ + s + 1, shift);
    const auto c = interpolate<coefficients>(0, 0.5 / PerOctave, [&](double t) {
      return at_x(profile, lo + (PerOctave * t + 0.5) * (hi - lo), register_offset_);
    });
    for (std::size_t k = 0; k < coefficients; ++k)
      columns_[2 * k + static_cast<std::size_t>(s / 16)].number[s % 16] = c[k];
  }
  return true;
}

}  // namespace opaline
