// Bounds of a profile and its derivatives as a function of q = r^2, looked up in float: what turns the moments of a
// cluster into a bound on the error of using it whole (irradiance.md).
//
// For f(q) = R(sqrt q) and every q from 0 to r_max^2 a row holds, for up to three outputs side by side, suprema over
// all larger q (so they hold for every q' >= q) with x = q + core^2:
//   first .. fourth   x^k |f^(k)| [1/mm^2]; third comes divided by 6, fourth by 24
//   high              f;  low: the infimum of f over all smaller q
//   noise             what the kernel's float table and float positions may be off by
//
// Of the derivatives: a backward difference of order k is |f^(k)| somewhere to the left, so where |f^(k)| is
// non-increasing it is an upper bound. That is so for completely monotone f: sums of poles exp(-s d)/d^n with positive
// weights, all registered profiles but photon_beam_diffusion. For that one, and within k/256 of the axis, differences
// are sampled four times a row and the bounds are as good as the margin of 5 % that all get.
#pragma once

#include "model/profiles/profile.h"
#include "render/irradiance/profile_sum.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <vector>

namespace opaline {

class ProfileBounds {
 public:
  /// Padded to four, so that a compiler can treat them as one vector.
  using Four = std::array<float, 4>;
  struct Row {
    Four first, second, third, fourth, high, low, noise;
  };

  ProfileBounds() = default;
  /// profiles: of each table of `tables`; core: shortest length on which any of them changes [mm];
  /// position_error: of a difference of two float positions [mm].
  ProfileBounds(std::span<const Profile* const> profiles, const ProfileSum& tables, double core, double r_max,
                double position_error);

  /// The same with output c for table_of[c], of three channels.
  ProfileBounds per_channel(const int table_of[3]) const;

  int outputs() const { return outputs_; }
  float core_squared() const { return core_squared_; }
  /// The row whose bounds hold from q on (low: down from it); q >= 0 [mm^2].
  const Row& from(float q) const { return rows_[index(q)]; }
  /// low of this row is a lower bound of f at q.
  const Row& up_to(float q) const { return rows_[index(q)]; }

 private:
  static constexpr int shift = 20;  ///< 8 rows an octave of q + core^2
  std::size_t index(float q) const {
    const std::int32_t row = (std::bit_cast<std::int32_t>(q + core_squared_) >> shift) - first_;
    return static_cast<std::size_t>(std::clamp(row, 0, static_cast<std::int32_t>(rows_.size()) - 1));
  }
  double edge(std::size_t row) const;

  int outputs_ = 0;
  float core_squared_ = 1;
  std::int32_t first_ = 0;
  std::vector<Row> rows_;
};

}  // namespace opaline
