#include "fit/defect_correction.h"

#include "fit/noise_weights.h"
#include "fit/reduced_picture.h"
#include "fit/reference_noise.h"
#include "fit/reference_sensitivity.h"
#include "render/stopwatch.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace opaline {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The pictures as measured, which the targets no longer have.
struct Measured {
  std::vector<MatrixXd> pictures;
  std::vector<NoiseModel> noise;

  explicit Measured(const std::vector<FitTarget>& targets) {
    for (const FitTarget& target : targets) pictures.push_back(target.picture), noise.push_back(target.noise);
  }
};

/// RMS of the reference's pictures minus the measured ones over that of the measured ones.
double relative_residual(const Measured& measured, const FitPoint& at, const std::vector<ReferencePicture>& made) {
  double off = 0, all = 0;
  for (std::size_t t = 0; t < made.size(); ++t) {
    off += (std::exp(at.ln_scale[t]) * made[t].rows - measured.pictures[t]).squaredNorm();
    all += measured.pictures[t].squaredNorm();
  }
  return std::sqrt(off / all);
}

/// Takes off what the operator gets wrong at `at`; returns its relative RMS.
double take_defect(std::vector<FitTarget>& targets, const Measured& measured, const ProfileInfo& profile,
                   const FitPoint& at, const std::vector<ReferencePicture>& made) {
  double defect = 0, all = 0;
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const double scale = std::exp(at.ln_scale[t]);
    const MatrixXd off = made[t].rows - target_rows(targets[t], profile, to_material(at.material, {}));
    defect += off.squaredNorm(), all += made[t].rows.squaredNorm();
    targets[t].offset = scale * off;
    targets[t].light = neighbours_mean(scale * made[t].rows, targets[t].op);
    targets[t].noise = sum_of_noise(measured.noise[t], made[t].noise, scale);
    replace_picture(targets[t], measured.pictures[t] - targets[t].offset);
  }
  return all > 0 ? std::sqrt(defect / all) : 0;
}

/// One place of the search: what the reference makes there, and the least-squares problem around it.
struct Place {
  FitPoint at;
  std::vector<ReferencePicture> made;
  CorrectionStep record;
  std::vector<Whitened> weights;
  MatrixXd hessian;  ///< J^T J of the data
  double cost = 0;   ///< half chi-squared
};

class Search {
 public:
  Search(std::vector<FitTarget>& targets, const ProfileInfo& profile, const SolveSettings& settings,
         const Reference& reference, const CorrectionSettings& rules, const Solution& start)
      : targets_(targets),
        profile_(profile),
        settings_(settings),
        reference_(reference),
        rules_(rules),
        bounds_(start.bounds),
        measured_(targets) {
    const FitPoint at{start.parameters, start.ln_scale};
    here_.at = at;
    out_.sensitivity = MatrixXd::Identity(start.jacobian.cols(), start.jacobian.cols());
  }

  Correction run(FitPoint& end) {
    here_ = visit(here_.at);
    renew_weights();
    out_.steps.push_back(here_.record);
    while (true) {
      if (here_.record.defect > rules_.measure_from && !out_.measured) measure();
      VectorXd full = step(0);
      if (out_.measured && settled(full) && far_from_measured()) measure(), full = step(0);
      out_.steps.back().next_step_sd = length(full);
      out_.converged = settled(full);
      if (out_.converged || static_cast<int>(out_.steps.size()) >= rules_.max_steps) break;
      advance();
    }
    if (!out_.measured) out_.renders_saved = static_cast<int>(parameter_groups(problem(here_.weights)).size());
    take_defect(targets_, measured_, profile_, here_.at, here_.made);
    end = out_.converged ? moved(step(0)) : here_.at;  // as short as it is, the last step needs no render
    return std::move(out_);
  }

 private:
  FitProblem problem(const std::vector<Whitened>& weights) const {
    return {targets_, weights, profile_, settings_, bounds_};
  }

  Place visit(const FitPoint& at) {
    Place place;
    place.at = at;
    place.made = reference_(at.material);
    ++out_.renders;
    place.record.at = at.material;
    place.record.defect = take_defect(targets_, measured_, profile_, at, place.made);
    place.record.residual = relative_residual(measured_, at, place.made);
    if (!weights_) weights_.emplace(problem(first_weights(targets_)), at);
    weigh(place);
    return place;
  }

  /// The least-squares problem at a place, whose corrected pictures the targets hold.
  void weigh(Place& place) const {
    place.weights = weights_->whiten(targets_);
    const FitProblem problem = this->problem(place.weights);
    place.cost = problem.half_chi_squared(place.at);
    const MatrixXd j = problem.jacobian(place.at);
    const auto data = j.topRows(j.rows() - static_cast<Index>(settings_.priors.size()));
    place.hessian = data.transpose() * data;
  }

  /// Where the noise is not known it is what the residual shows, and that has become smaller.
  void renew_weights() {
    if (std::all_of(targets_.begin(), targets_.end(), [](const FitTarget& t) { return t.noise.known; })) return;
    weights_.emplace(problem(here_.weights), here_.at);
    weigh(here_);
  }

  void measure() {
    out_.sensitivity = reference_sensitivity(problem(here_.weights), here_.weights, here_.at, here_.made,
                                             [&](const ParameterVector& p) { return ++out_.renders, reference_(p); });
    out_.measured = true;
    measured_at_ = here_.at.material;
  }

  /// ((J A)^T J A + P) with P of the priors.
  MatrixXd curvature() const {
    MatrixXd sum = out_.sensitivity.transpose() * here_.hessian * out_.sensitivity;
    for (const Prior& prior : settings_.priors) sum(prior.parameter, prior.parameter) += 1 / (prior.sd * prior.sd);
    return sum;
  }

  /// The priors, and one at the present place for every free parameter that holds it there: Marquardt's damping.
  SolveSettings damped(double damping) const {
    SolveSettings with = settings_;
    const FitProblem problem = this->problem(here_.weights);
    for (int i = 0; i < parameter_count && damping > 0; ++i)
      if (const double size = here_.hessian(i, i); problem.is_free(i) && size > 0)
        with.priors.push_back({i, here_.at.material[static_cast<std::size_t>(i)], 1 / std::sqrt(damping * size)});
    return with;
  }

  /// To the operator's own minimum of the corrected pictures (valleys bend, and the operator's bends with the
  /// reference's), d, and by A to where the reference's is expected: with priors P about m,
  ///   ((J A)^T J A + P) step = A^T (J^T J d - P (m - theta - d)) + P (m - theta)
  /// which is A^-1 d without priors, and d for A = 1.
  VectorXd step(double damping) const {
    const SolveSettings with = damped(damping);
    const FitPoint to = FitProblem(targets_, here_.weights, profile_, with, bounds_).minimise(here_.at).at;
    const MatrixXd& a = out_.sensitivity;
    VectorXd d = VectorXd::Zero(a.cols());
    for (Index i = 0; i < parameter_count; ++i)
      d[i] = to.material[static_cast<std::size_t>(i)] - here_.at.material[static_cast<std::size_t>(i)];
    for (std::size_t t = 0; t < targets_.size(); ++t)
      if (const int column = scale_column(targets_, t); column >= 0) d[column] = to.ln_scale[t] - here_.at.ln_scale[t];
    if (!out_.measured) return d;
    VectorXd data = here_.hessian * d, pull = VectorXd::Zero(a.cols());
    MatrixXd c = a.transpose() * here_.hessian * a;
    for (const Prior& prior : with.priors) {
      const Index i = prior.parameter;
      const double p = 1 / (prior.sd * prior.sd), away = prior.mean - here_.at.material[static_cast<std::size_t>(i)];
      c(i, i) += p;
      pull[i] += p * away;
      data[i] -= p * (away - d[i]);
    }
    const VectorXd unit = c.diagonal().cwiseSqrt().cwiseMax(1e-6).cwiseInverse();
    MatrixXd scaled = unit.asDiagonal() * c * unit.asDiagonal();
    scaled.diagonal().array() += 1e-10;  // directions that no picture shows stay where they are
    return unit.asDiagonal() * scaled.ldlt().solve(unit.asDiagonal() * (a.transpose() * data + pull));
  }

  double length(const VectorXd& step) const { return std::sqrt(std::max(0.0, step.dot(curvature() * step))); }

  double values() const {
    double sum = 0;
    for (const FitTarget& target : targets_) sum += static_cast<double>(target.rows()) * target.channels;
    return sum;
  }

  bool settled(const VectorXd& step) const {
    return step.cwiseAbs().maxCoeff() < rules_.least_step ||
           length(step) < (noisy() ? rules_.small_step_of_noisy : rules_.small_step) *
                              std::sqrt(free_count(problem(here_.weights)));
  }

  bool noisy() const {
    return std::any_of(here_.made.begin(), here_.made.end(), [](const ReferencePicture& p) { return p.noise.known; });
  }

  /// A tenth, in any parameter: derivatives are others here.
  bool far_from_measured() const {
    double most = 0;
    for (std::size_t i = 0; i < parameter_count; ++i)
      most = std::max(most, std::abs(here_.at.material[i] - measured_at_[i]));
    return most > 0.1;
  }

  FitPoint moved(const VectorXd& step) const {
    FitPoint to = here_.at;
    for (int i = 0; i < parameter_count; ++i) {
      const int from = all_grey(targets_) && i < eta_index ? i - i % 3 : i;
      double& value = to.material[static_cast<std::size_t>(i)];
      value = std::clamp(value + step[from], bounds_.lower(i), bounds_.upper(i));
    }
    for (std::size_t t = 0; t < targets_.size(); ++t)
      if (const int column = scale_column(targets_, t); column >= 0) to.ln_scale[t] += step[column];
    return to;
  }

  /// To a better place: a shorter step, or fresh derivatives, where the one tried is worse.
  void advance() {
    constexpr double longest = 1;  // of ln sigma: beyond, derivatives say nothing
    VectorXd step = this->step(damping_);
    step *= std::min(1.0, longest / step.cwiseAbs().maxCoeff());
    Place there = visit(moved(step));
    // The end is where J^T (reference - t) = 0, which by a little is not where the cost is least; and noise has its
    // own opinion of which of two good places is the better one.
    const double alike = noisy() ? std::sqrt(2 * values()) : 5e-5 * values();
    there.record.better = there.cost < here_.cost + alike;
    out_.steps.push_back(there.record);
    if (there.record.better) {
      here_ = std::move(there);
      renew_weights();
      damping_ /= 10;
    } else if (out_.measured && here_.at.material != measured_at_) {
      measure();
    } else {
      damping_ = std::max(10 * damping_, 1e-3);
    }
  }

  std::vector<FitTarget>& targets_;
  const ProfileInfo& profile_;
  const SolveSettings& settings_;
  const Reference& reference_;
  const CorrectionSettings& rules_;
  const ParameterBounds bounds_;
  const Measured measured_;
  std::optional<FixedWeights> weights_;
  Place here_;
  double damping_ = 0;
  ParameterVector measured_at_{};
  Correction out_;
};

}  // namespace

Correction correct_by_reference(std::vector<FitTarget>& targets, const ProfileInfo& profile, const Material& initial,
                                const SolveSettings& settings, const Reference& reference,
                                const CorrectionSettings& correction, Solution& found) {
  Stopwatch watch;
  FitPoint end;
  Correction out = Search(targets, profile, settings, reference, correction, found).run(end);
  // Weights, residual and Jacobian there; from so near the operator's own minimum is that of the search.
  SolveSettings near = settings;
  near.starts = 1;
  Solution corrected = solve(targets, profile, to_material(end.material, initial, settings.free), near);
  corrected.starts = std::move(found.starts), corrected.best_start = found.best_start;
  for (StartRecord& start : corrected.starts)  // they are ends of another fit: no part of the intervals of this one
    start.excess = std::numeric_limits<double>::infinity();
  corrected.iterations += found.iterations, corrected.seconds += found.seconds;
  corrected.parameters = end.material, corrected.ln_scale = end.ln_scale;
  corrected.jacobian.topRows(corrected.jacobian.rows() - corrected.prior_rows) *= out.sensitivity;
  corrected.converged &= out.converged;
  found = std::move(corrected);
  out.seconds = watch.lap();
  return out;
}

}  // namespace opaline
