// What a diffusion profile does between parallel planes, in the frequency domain: the 2-D Fourier transform
//
//   K(k; z) = int R_d(sqrt(r^2 + z^2)) J_0(k r) 2 pi r dr       k [1/mm], planes z [mm] apart; no unit
//
// exact where the profile has it in closed form (Profile::plane_spectrum: sums of dipole poles and Yukawa terms, such
// as z_r exp(-beta h)/h), else by a 1-D Hankel transform. K(0; 0) is the profile's total: sampled on the frequencies of
// a grid it is a kernel whose sum is that total, for any size of its pixels.
//
// A grid of finite period repeats the kernel. Where the profile reaches as far as the object is wide, the kernel is cut
// off, smoothly, beyond the largest distance that occurs, and the repetitions can't meet (CutOff). That spectrum is
// integrated up to k = 150 / start, beyond which a cut-off there makes no difference.
#pragma once

#include "model/profile_table.h"
#include "model/profiles/profile.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace opaline {

/// In-plane distances [mm]: the kernel is whole up to `start` and 0 from `end` on.
struct CutOff {
  double range = 1;  ///< no kernel has structure finer than 1 / range in k
  double start = HUGE_VAL, end = HUGE_VAL;
  bool finite() const { return start < HUGE_VAL; }
};

/// K without a cut-off, by the closed form or the Hankel transform; relative to K(0; z) the error is below 1e-5.
class PlaneSpectrum {
 public:
  explicit PlaneSpectrum(const Profile& profile);
  double operator()(double k, double z) const;
  double by_hankel(double k, double z) const;
  bool closed() const { return closed_; }
  double core_radius() const { return profile_.core_radius(); }
  /// R_d(d), from a table where the transform is numeric.
  double evaluate(double d) const;

 private:
  const Profile& profile_;
  bool closed_;
  double r_max_;
  ProfileTable table_;
};

/// K for several distances, tabulated at equal steps of the bits of the float k^2 + offset, linear between them.
class KernelTable {
 public:
  /// k_max: largest k that will be asked for. The distances may be in any order.
  KernelTable(const PlaneSpectrum& spectrum, const std::vector<double>& distances, double k_max, const CutOff& cut);

  /// Place of k^2 in the table: entry and share of the next one.
  struct Place {
    std::int32_t entry;
    float share;
  };
  Place place(float k_squared) const {
    const std::int32_t bits = std::bit_cast<std::int32_t>(k_squared + offset_);
    const std::int32_t entry = (bits >> shift) - first_;
    return {entry, static_cast<float>(bits & ((1 << shift) - 1)) * (1.0f / (1 << shift))};
  }
  const float* values(int distance) const {
    return values_.data() + static_cast<std::size_t>(distance) * static_cast<std::size_t>(entries_);
  }
  float operator()(int distance, float k_squared) const {
    const Place p = place(k_squared);
    const float* v = values(distance) + p.entry;
    return v[0] + p.share * (v[1] - v[0]);
  }
  int entries() const { return entries_; }
  float offset() const { return offset_; }
  std::int32_t first() const { return first_; }
  const std::vector<float>& all() const { return values_; }

  static constexpr int shift = 17;  ///< 64 entries an octave of k^2

 private:
  double node(int entry) const;
  void fill_cut(const PlaneSpectrum& spectrum, const std::vector<double>& distances, const CutOff& cut, int entries);

  float offset_;
  std::int32_t first_;
  int entries_;
  std::vector<float> values_;
};

}  // namespace opaline
