// The least-squares problem of one profile and given weights: what starts, intervals and the bootstrap solve again.
#pragma once

#include "fit/solve.h"

#include <memory>

namespace ceres {
class Problem;
}

namespace opaline {

/// Parameters of a fit: the material's and each target's brightness.
struct FitPoint {
  ParameterVector material{};
  std::vector<double> ln_scale;
};

struct FitEnd {
  FitPoint at;
  double cost = 0;  ///< half the sum of squares, without the constants
  bool converged = false;
  std::string message{};
  std::vector<double> history{};
};

/// All references must outlive it.
class FitProblem {
 public:
  FitProblem(const std::vector<FitTarget>& targets, const std::vector<Whitened>& whitened, const ProfileInfo& profile,
             const SolveSettings& settings, const ParameterBounds& bounds);

  /// Runs Levenberg-Marquardt from `from`. `held` keeps one more parameter where it is (-1: none).
  FitEnd minimise(const FitPoint& from, int held = -1) const;
  /// The same to a ten-thousandth of a standard deviation: for repetitions, from a point near the minimum.
  FitEnd minimise_quickly(const FitPoint& from, int held = -1) const;
  /// The same problem with other data, whitened: a repetition of the measurement. They must outlive it.
  FitProblem with_data(const std::vector<Eigen::VectorXd>& y) const;
  /// What the whitened data would be without noise.
  std::vector<Eigen::VectorXd> expected_data(const FitPoint& at) const;

  /// Half the sum of squares with the constants and the priors.
  double half_chi_squared(const FitPoint& at) const;
  /// The scales that suit the material best, in closed form; 0 where they are known.
  void set_scales(FitPoint& at) const;
  /// Whitened Jacobian, columns as Solution::jacobian.
  Eigen::MatrixXd jacobian(const FitPoint& at) const;

  const std::vector<FitTarget>& targets() const { return targets_; }
  const ProfileInfo& profile() const { return profile_; }
  const SolveSettings& settings() const { return settings_; }
  const ParameterBounds& bounds() const { return bounds_; }
  bool is_free(int i) const;

 private:
  FitEnd run(const FitPoint& from, int held, double function_tolerance) const;
  std::unique_ptr<ceres::Problem> build(FitPoint& at, int held) const;
  const Eigen::VectorXd& data(std::size_t t) const { return data_ ? (*data_)[t] : whitened_[t].y; }

  const std::vector<FitTarget>& targets_;
  const std::vector<Whitened>& whitened_;
  const ProfileInfo& profile_;
  const SolveSettings& settings_;
  ParameterBounds bounds_;
  const std::vector<Eigen::VectorXd>* data_ = nullptr;  ///< instead of the whitened targets' own
};

/// settings.bounds within what every operator resolves.
ParameterBounds searched_bounds(const std::vector<FitTarget>& targets, ParameterBounds bounds);

/// Column of Solution::jacobian that holds target t's ln scale, or -1 if it is known.
int scale_column(const std::vector<FitTarget>& targets, std::size_t t);

/// Is every picture grey?
bool all_grey(const std::vector<FitTarget>& targets);

}  // namespace opaline
