#include "fit/defect_correction.h"

#include "fit/fit_problem.h"
#include "fit/reduced_picture.h"
#include "render/stopwatch.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Secants of the reference: far enough for its noise, near enough for the operator to bend alike.
constexpr double ln_secant = 0.25, eta_secant = 0.05;

class Corrector {
 public:
  Corrector(std::vector<FitTarget>& targets, const ProfileInfo& profile, const Material& initial,
            const SolveSettings& settings, const Reference& reference, const CorrectionSettings& correction,
            Solution& found)
      : targets_(targets),
        profile_(profile),
        initial_(initial),
        settings_(settings),
        reference_(reference),
        rules_(correction),
        found_(found) {
    for (const FitTarget& target : targets) pictures_.push_back(target.picture), noise_.push_back(target.noise);
    out_.sensitivity = MatrixXd::Identity(columns(), columns());
  }

  Correction run() {
    Stopwatch watch;
    while (!out_.converged && static_cast<int>(out_.steps.size()) < rules_.max_steps) step();
    if (!out_.measured) out_.renders_saved = static_cast<int>(groups().size());
    found_.jacobian.topRows(data_rows()) *= out_.sensitivity;
    found_.converged &= out_.converged;
    out_.seconds = watch.lap();
    return std::move(out_);
  }

 private:
  Index columns() const { return found_.jacobian.cols(); }
  Index data_rows() const { return found_.jacobian.rows() - found_.prior_rows; }
  bool is_free(int i) const {
    return settings_.free.is_free(i) && !(all_grey(targets_) && i < eta_index && i % 3 != 0);
  }

  std::vector<ReferencePicture> render(const ParameterVector& at) {
    ++out_.renders;
    return reference_(at);
  }

  MatrixXd operator_rows(std::size_t t, const ParameterVector& at) const {
    return target_rows(targets_[t], profile_, to_material(at, initial_, settings_.free));
  }

  /// Takes the defect at `at` off the pictures; returns its size.
  double take_defect(const ParameterVector& at, const std::vector<ReferencePicture>& made) {
    double defect = 0, all = 0;
    for (std::size_t t = 0; t < targets_.size(); ++t) {
      const double scale = std::exp(found_.ln_scale[t]);
      const MatrixXd off = made[t].rows - operator_rows(t, at);
      defect += off.squaredNorm(), all += made[t].rows.squaredNorm();
      targets_[t].offset = scale * off;
      targets_[t].noise = sum_of_noise(noise_[t], made[t].noise, scale);
      replace_picture(targets_[t], pictures_[t] - targets_[t].offset);
    }
    return all > 0 ? std::sqrt(defect / all) : 0;
  }

  void step() {
    const ParameterVector at = found_.parameters;
    const std::vector<double> scale_at = found_.ln_scale;
    const std::vector<ReferencePicture> made = render(at);
    CorrectionStep record{at, take_defect(at, made)};
    const std::vector<StartRecord> starts = std::move(found_.starts);
    const int best_start = found_.best_start, iterations = found_.iterations;
    const double seconds = found_.seconds;
    found_ = solve(targets_, profile_, to_material(at, initial_, settings_.free), settings_);
    found_.starts = starts, found_.best_start = best_start;
    found_.iterations += iterations, found_.seconds += seconds;
    // The first step may be long: A would be that of another place.
    const bool far = record.defect > rules_.measure_from;
    if (far && !out_.measured && !out_.steps.empty()) measure(at, made);
    record.moved = move(at, scale_at);
    out_.steps.push_back(record);
    out_.converged |= record.moved < rules_.small_step * std::sqrt(free_parameters()) && (out_.measured || !far);
  }

  double free_parameters() const {
    double count = static_cast<double>(columns() - parameter_count);
    for (int i = 0; i < parameter_count; ++i) count += is_free(i);
    return count;
  }

  /// Parameters that one render may move together, for they show in different channels.
  std::vector<std::vector<int>> groups() const {
    std::vector<std::vector<int>> all;
    for (const int first : {0, 3, eta_index}) {
      std::vector<int> group;
      for (int i = first; i < std::min(first + 3, parameter_count); ++i)
        if (is_free(i)) group.push_back(i);
      if (!group.empty()) all.push_back(group);
    }
    return all;
  }

  /// A picture's rows, those of one channel (-1: all), in the whitened coordinates of target t.
  VectorXd whitened(std::size_t t, const MatrixXd& rows, int channel) const {
    VectorXd y = VectorXd::Zero(found_.whitened[t].rows());
    for (int c = 0; c < targets_[t].channels; ++c)
      if (channel < 0 || channel == c) found_.whitened[t].add(c, basis_sum(targets_[t].q(c), rows.col(c)), y);
    return y;
  }

  /// Secants of the operator and of the reference in all free directions; A by least squares between them. Directions
  /// that neither shows keep the operator's own derivatives.
  void measure(const ParameterVector& at, const std::vector<ReferencePicture>& made) {
    MatrixXd fast = MatrixXd::Zero(data_rows(), columns()), slow = fast;
    for (const std::vector<int>& group : groups()) {
      ParameterVector beside = at;
      for (const int i : group) beside[static_cast<std::size_t>(i)] += secant(i, at);
      const std::vector<ReferencePicture> there = render(beside);
      Index row = 0;
      for (std::size_t t = 0; t < targets_.size(); ++t) {
        const double scale = std::exp(found_.ln_scale[t]);
        const MatrixXd by_operator = scale * (operator_rows(t, beside) - operator_rows(t, at)),
                       by_reference = scale * (there[t].rows - made[t].rows);
        for (const int i : group) {
          const int channel = i == eta_index || targets_[t].channels == 1 ? -1 : i % 3;
          const VectorXd a = whitened(t, by_operator, channel), b = whitened(t, by_reference, channel);
          fast.col(i).segment(row, a.size()) = a / secant(i, at);
          slow.col(i).segment(row, b.size()) = b / secant(i, at);
        }
        row += found_.whitened[t].rows();
      }
    }
    add_scales(at, made, fast, slow);
    const MatrixXd unknown = trust_in_operator(made) * MatrixXd::Identity(columns(), columns());
    out_.sensitivity = (fast.transpose() * fast + unknown).ldlt().solve(fast.transpose() * slow + unknown);
    out_.measured = true;
  }

  /// Information, per squared standard deviation, up to which the operator's own derivatives are believed: those that
  /// the noise of two pictures, a secant apart, would drown. Entries of A - 1 are about this large.
  static double trust_in_operator(const std::vector<ReferencePicture>& made) {
    constexpr double entries = 0.5;
    const bool noisy = std::any_of(made.begin(), made.end(), [](const ReferencePicture& p) { return p.noise.known; });
    return noisy ? 2 / (ln_secant * ln_secant * entries * entries) : 1;
  }

  double secant(int i, const ParameterVector& at) const {
    const double length = i == eta_index ? eta_secant : ln_secant;
    return at[static_cast<std::size_t>(i)] + length > found_.bounds.upper(i) ? -length : length;
  }

  void add_scales(const ParameterVector& at, const std::vector<ReferencePicture>& made, MatrixXd& fast,
                  MatrixXd& slow) const {
    Index row = 0;
    for (std::size_t t = 0; t < targets_.size(); ++t) {
      const Index rows = found_.whitened[t].rows();
      if (const int column = scale_column(targets_, t); column >= 0) {
        const double scale = std::exp(found_.ln_scale[t]);
        fast.col(column).segment(row, rows) = scale * whitened(t, operator_rows(t, at), -1);
        slow.col(column).segment(row, rows) = scale * whitened(t, made[t].rows, -1);
      }
      row += rows;
    }
  }

  /// From `at` to where the reference is expected to fit: with the operator's step d, its Hessian H, and priors P about
  /// m, (A^T H A + P) step = A^T (H d + P (theta + d - m)) ... + P (m - theta); A = 1 gives d. Returns its length.
  double move(const ParameterVector& at, const std::vector<double>& scale_at) {
    const MatrixXd& a = out_.sensitivity;
    const MatrixXd j = found_.jacobian.topRows(data_rows());
    const MatrixXd h = j.transpose() * j;
    VectorXd moved(columns()), pull_there = VectorXd::Zero(columns()), pull_here = pull_there, weight = pull_there;
    for (int i = 0; i < parameter_count; ++i)
      moved[i] = found_.parameters[static_cast<std::size_t>(i)] - at[static_cast<std::size_t>(i)];
    for (std::size_t t = 0; t < targets_.size(); ++t)
      if (const int column = scale_column(targets_, t); column >= 0) moved[column] = found_.ln_scale[t] - scale_at[t];
    for (const Prior& prior : settings_.priors) {
      const auto i = static_cast<std::size_t>(prior.parameter);
      const double p = 1 / (prior.sd * prior.sd);
      weight[prior.parameter] += p;
      pull_here[prior.parameter] += p * (prior.mean - at[i]);
      pull_there[prior.parameter] += p * (prior.mean - found_.parameters[i]);
    }
    const VectorXd gradient = a.transpose() * (h * moved - pull_there) + pull_here;
    MatrixXd curvature = a.transpose() * h * a;
    curvature.diagonal() += weight;
    const VectorXd step = out_.measured ? solve_step(curvature, gradient) : moved;
    for (int i = 0; i < parameter_count; ++i)
      if (is_free(i))
        found_.parameters[static_cast<std::size_t>(i)] =
            std::clamp(at[static_cast<std::size_t>(i)] + step[i], found_.bounds.lower(i), found_.bounds.upper(i));
    if (all_grey(targets_))
      for (std::size_t i = 0; i < eta_index; ++i) found_.parameters[i] = found_.parameters[i - i % 3];
    for (std::size_t t = 0; t < targets_.size(); ++t)
      if (const int column = scale_column(targets_, t); column >= 0) found_.ln_scale[t] = scale_at[t] + step[column];
    if (step.cwiseAbs().maxCoeff() < rules_.least_step) out_.converged = true;
    return std::sqrt(std::max(0.0, step.dot(curvature * step)));
  }

  /// Directions without curvature stay where they are.
  static VectorXd solve_step(const MatrixXd& curvature, const VectorXd& gradient) {
    const VectorXd length = curvature.diagonal().cwiseSqrt().cwiseMax(1e-6).cwiseInverse();
    MatrixXd scaled = length.asDiagonal() * curvature * length.asDiagonal();
    scaled.diagonal().array() += 1e-10;
    return length.asDiagonal() * scaled.ldlt().solve(length.asDiagonal() * gradient);
  }

  std::vector<FitTarget>& targets_;
  const ProfileInfo& profile_;
  const Material& initial_;
  const SolveSettings& settings_;
  const Reference& reference_;
  const CorrectionSettings& rules_;
  Solution& found_;
  std::vector<MatrixXd> pictures_;
  std::vector<NoiseModel> noise_;
  Correction out_;
};

}  // namespace

NoiseModel sum_of_noise(const NoiseModel& a, const NoiseModel& b, double scale_of_b) {
  NoiseModel sum = a;
  if (!a.known || !b.known) return sum;  // the residual shows both
  for (std::size_t c = 0; c < 3; ++c) {
    sum.read_sd[c] = std::hypot(a.read_sd[c], scale_of_b * b.read_sd[c]);
    sum.shot[c] = a.shot[c] + scale_of_b * b.shot[c];
  }
  sum.correlation_known = a.correlation_known && b.correlation_known;
  return sum;
}

Correction correct_by_reference(std::vector<FitTarget>& targets, const ProfileInfo& profile, const Material& initial,
                                const SolveSettings& settings, const Reference& reference,
                                const CorrectionSettings& correction, Solution& found) {
  return Corrector(targets, profile, initial, settings, reference, correction, found).run();
}

}  // namespace opaline
