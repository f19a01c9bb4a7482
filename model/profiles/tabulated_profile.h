// A measured or simulated profile: samples of R_d, monotone cubic interpolation between their logarithms.
//
// log R over log r is the piecewise cubic of Fritsch & Butland 1984 (C1, monotone where the data are). Below the first
// radius R is constant; beyond the last it falls exponentially with the last slope. Units and normalisation:
// conventions.h. A table doesn't depend on a medium: its gradient is 0.
#pragma once

#include "model/profiles/profile.h"

#include <stdexcept>
#include <string_view>
#include <vector>

namespace opaline {

/// What is wrong with a table of samples, and in which of its lines (1 is the first).
struct ProfileTableError : std::runtime_error {
  ProfileTableError(int at_line, const std::string& what) : std::runtime_error(what), line(at_line) {}
  int line;
};

class TabulatedProfile final : public Profile {
 public:
  /// At least two samples with rising r, positive finite values, and a last one below the one before, so that
  /// the tail falls; otherwise ProfileTableError with `line` counting samples.
  explicit TabulatedProfile(std::vector<ProfileSample> samples);

  double evaluate(double r) const override;
  ProfileGradient evaluate_with_gradient(double r) const override { return {evaluate(r), 0, 0, 0}; }
  /// As measured: may exceed 1.
  double total() const override { return total_; }
  double cumulative(double r) const override;
  double sample(double xi) const override;
  double core_radius() const override { return samples_.front().r; }

  const std::vector<ProfileSample>& samples() const { return samples_; }

 private:
  struct Node {
    double log_r, log_value, slope;  ///< slope: d log R / d log r
    double cumulative;               ///< 2 pi int_0^r R s ds
  };
  double between(std::size_t i, double log_r) const;
  double cumulative_in(std::size_t i, double log_r) const;

  std::vector<ProfileSample> samples_;
  std::vector<Node> nodes_;
  double decay_ = 0, total_ = 0;  ///< of the tail [1/mm]
};

/// Samples from CSV text: a line "r,R" each (mm, 1/mm^2); empty lines and lines that start with # are skipped, one
/// header line of names is allowed. Throws ProfileTableError with the line's number (0: of no line) for what can't be
/// read or isn't valid for TabulatedProfile.
std::vector<ProfileSample> parse_profile_csv(std::string_view text);

}  // namespace opaline
