// The cumulative of a radial profile without a closed one, and sampling from it.
//
// y = log(r/core) is cut into segments of 1/2; in each the ring density 2 pi r^2 R(r) is a Chebyshev polynomial of
// degree 15 and the cumulative its integral. Error below 1e-12 of cumulative(r) for a profile that is smooth in
// r^2 on the scale core^2 and analytic in log r elsewhere (poles, Yukawa terms, exponentials).
#pragma once

#include <array>
#include <functional>
#include <vector>

namespace opaline {

class CumulativeTable {
 public:
  static constexpr int points = 16;

  /// profile      R(r) [1/mm^2], r [mm]; finite, >= 0, flat well below core_radius
  /// core_radius  > 0 [mm]
  CumulativeTable(const std::function<double(double)>& profile, double core_radius);

  double total() const { return starts_.back(); }
  /// 2 pi int_0^r R s ds, r >= 0 [mm]; total() beyond the last segment.
  double cumulative(double r) const;
  /// r with cumulative(r) = xi total(), xi in [0, 1]; 0 if the total is.
  double sample(double xi) const;

 private:
  using Coefficients = std::array<double, points + 1>;

  double core_, centre_;                 ///< core radius; pi R(0)
  std::vector<double> starts_;           ///< cumulative at the segments' starts, and the total
  std::vector<Coefficients> segments_;   ///< of the cumulative's rise, Chebyshev in x = -1 .. 1
  std::vector<Coefficients> densities_;  ///< of its derivative by x
};

}  // namespace opaline
