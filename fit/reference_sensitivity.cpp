#include "fit/reference_sensitivity.h"

#include "fit/reduced_picture.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Length of the secants: of a noisy reference far enough for its noise, else near.
double ln_secant(bool noisy) { return noisy ? 0.25 : 0.02; }

bool noisy(const std::vector<ReferencePicture>& made) {
  return std::any_of(made.begin(), made.end(), [](const ReferencePicture& p) { return p.noise.known; });
}

double secant(const FitProblem& problem, int i, const ParameterVector& at, bool noisy) {
  const double length = (i == eta_index ? 0.2 : 1) * ln_secant(noisy);
  return at[static_cast<std::size_t>(i)] + length > problem.bounds().upper(i) ? -length : length;
}

MatrixXd operator_rows(const FitProblem& problem, std::size_t t, const ParameterVector& at) {
  return target_rows(problem.targets()[t], problem.profile(), to_material(at, {}));
}

/// Derivatives of the operator and of the reference, whitened: rows x columns of Solution::jacobian.
struct Secants {
  MatrixXd fast, slow;
};

class Measurement {
 public:
  Measurement(const FitProblem& problem, const std::vector<Whitened>& weights, const FitPoint& at,
              const std::vector<ReferencePicture>& made)
      : problem_(problem), weights_(weights), at_(at), made_(made) {
    Index rows = 0, columns = parameter_count;
    for (const Whitened& w : weights) first_.push_back(rows), rows += w.rows();
    for (const FitTarget& target : problem.targets()) columns += target.scale_free;
    out_.fast = out_.slow = MatrixXd::Zero(rows, columns);
    for (std::size_t t = 0; t < weights.size(); ++t)
      if (const int column = scale_column(problem.targets(), t); column >= 0)
        set(t, column, -1, 1, operator_rows(problem, t, at.material), made[t].rows);
  }

  void move(const std::vector<int>& group, const Reference& reference) {
    ParameterVector beside = at_.material;
    for (const int i : group) beside[static_cast<std::size_t>(i)] += secant(problem_, i, at_.material, noisy(made_));
    const std::vector<ReferencePicture> there = reference(beside);
    for (std::size_t t = 0; t < weights_.size(); ++t) {
      const MatrixXd fast = operator_rows(problem_, t, beside) - operator_rows(problem_, t, at_.material),
                     slow = there[t].rows - made_[t].rows;
      for (const int i : group)
        set(t, i, i == eta_index || problem_.targets()[t].channels == 1 ? -1 : i % 3,
            secant(problem_, i, at_.material, noisy(made_)), fast, slow);
    }
  }

  const Secants& secants() const { return out_; }

 private:
  void set(std::size_t t, int column, int channel, double length, const MatrixXd& fast, const MatrixXd& slow) {
    const double scale = std::exp(at_.ln_scale[t]) / length;
    const Index rows = weights_[t].rows();
    out_.fast.col(column).segment(first_[t], rows) = scale * whitened(t, fast, channel);
    out_.slow.col(column).segment(first_[t], rows) = scale * whitened(t, slow, channel);
  }

  /// Rows of one channel (-1: all) of a picture of target t.
  VectorXd whitened(std::size_t t, const MatrixXd& rows, int channel) const {
    VectorXd y = VectorXd::Zero(weights_[t].rows());
    const FitTarget& target = problem_.targets()[t];
    for (int c = 0; c < target.channels; ++c)
      if (channel < 0 || channel == c) weights_[t].add(c, basis_sum(target.q(c), rows.col(c)), y);
    return y;
  }

  const FitProblem& problem_;
  const std::vector<Whitened>& weights_;
  const FitPoint& at_;
  const std::vector<ReferencePicture>& made_;
  std::vector<Index> first_;
  Secants out_;
};

/// Information (1 over a squared standard deviation) up to which the operator's own derivatives are believed: of a
/// noisy reference what two pictures a secant apart would drown, where entries of A - 1 are about this large.
double trust_in_operator(const std::vector<ReferencePicture>& made) {
  constexpr double entries = 0.5;
  const double apart = ln_secant(true) * entries;
  return noisy(made) ? 2 / (apart * apart) : 1;
}

}  // namespace

std::vector<std::vector<int>> parameter_groups(const FitProblem& problem) {
  std::vector<std::vector<int>> all;
  for (const int first : {0, 3, eta_index}) {
    std::vector<int> group;
    for (int i = first; i < std::min(first + 3, parameter_count); ++i)
      if (problem.is_free(i)) group.push_back(i);
    if (!group.empty()) all.push_back(group);
  }
  return all;
}

MatrixXd reference_sensitivity(const FitProblem& problem, const std::vector<Whitened>& weights, const FitPoint& at,
                               const std::vector<ReferencePicture>& made, const Reference& reference) {
  Measurement measurement(problem, weights, at, made);
  for (const std::vector<int>& group : parameter_groups(problem)) measurement.move(group, reference);
  const auto& [fast, slow] = measurement.secants();
  const MatrixXd unknown = trust_in_operator(made) * MatrixXd::Identity(fast.cols(), fast.cols());
  return (fast.transpose() * fast + unknown).ldlt().solve(fast.transpose() * slow + unknown);
}

}  // namespace opaline
