#include "fit/fit_problem.h"

#include "fit/residuals/target_residual.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>

namespace opaline {

ParameterBounds searched_bounds(const std::vector<FitTarget>& targets, ParameterBounds bounds) {
  for (const FitTarget& target : targets)
    bounds.sigma_max = std::min(bounds.sigma_max, 1 / std::sqrt(target.op.radial.x_0()));
  return bounds;
}

int scale_column(const std::vector<FitTarget>& targets, std::size_t t) {
  if (!targets[t].scale_free) return -1;
  int column = parameter_count;
  for (std::size_t i = 0; i < t; ++i) column += targets[i].scale_free;
  return column;
}

bool all_grey(const std::vector<FitTarget>& targets) {
  return std::all_of(targets.begin(), targets.end(), [](const FitTarget& t) { return t.channels == 1; });
}

FitProblem::FitProblem(const std::vector<FitTarget>& targets, const std::vector<Whitened>& whitened,
                       const ProfileInfo& profile, const SolveSettings& settings, const ParameterBounds& bounds)
    : targets_(targets), whitened_(whitened), profile_(profile), settings_(settings), bounds_(bounds) {}

bool FitProblem::is_free(int i) const {
  if (all_grey(targets_) && i < eta_index && i % 3 != 0) return false;
  return settings_.free.is_free(i);
}

std::unique_ptr<ceres::Problem> FitProblem::build(FitPoint& at, int held) const {
  auto problem = std::make_unique<ceres::Problem>();
  std::vector<double*> blocks;
  for (double& block : at.material) blocks.push_back(&block);
  for (double* block : blocks) problem->AddParameterBlock(block, 1);
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    std::vector<double*> used = blocks;
    used.push_back(&at.ln_scale[t]);
    problem->AddResidualBlock(new TargetResidual(targets_[t], whitened_[t], data(t), profile_), nullptr, used);
    if (!targets_[t].scale_free) problem->SetParameterBlockConstant(&at.ln_scale[t]);
  }
  for (const Prior& prior : settings_.priors)
    problem->AddResidualBlock(new PriorResidual(prior.mean, prior.sd), nullptr,
                              blocks[static_cast<std::size_t>(prior.parameter)]);
  for (int i = 0; i < parameter_count; ++i) {
    double* block = blocks[static_cast<std::size_t>(i)];
    if (!is_free(i) || i == held) {
      problem->SetParameterBlockConstant(block);
      continue;
    }
    problem->SetParameterLowerBound(block, 0, bounds_.lower(i));
    problem->SetParameterUpperBound(block, 0, bounds_.upper(i));
  }
  return problem;
}

FitEnd FitProblem::minimise(const FitPoint& from, int held) const { return run(from, held, 1e-15); }

FitEnd FitProblem::minimise_quickly(const FitPoint& from, int held) const { return run(from, held, 1e-10); }

FitEnd FitProblem::run(const FitPoint& from, int held, double function_tolerance) const {
  FitEnd end{from};
  const auto problem = build(end.at, held);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = settings_.max_iterations;
  options.function_tolerance = function_tolerance;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem.get(), &summary);
  end.cost = summary.final_cost;
  end.converged = summary.termination_type == ceres::CONVERGENCE;
  end.message = summary.message;
  for (const ceres::IterationSummary& iteration : summary.iterations) end.history.push_back(iteration.cost);
  return end;
}

FitProblem FitProblem::with_data(const std::vector<Eigen::VectorXd>& y) const {
  FitProblem other = *this;
  other.data_ = &y;
  return other;
}

std::vector<Eigen::VectorXd> FitProblem::expected_data(const FitPoint& at) const {
  std::vector<Eigen::VectorXd> data;
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    const auto picture = reduced_picture(targets_[t], profile_, to_material(at.material, {}), false);
    Eigen::VectorXd y = Eigen::VectorXd::Zero(whitened_[t].rows());
    for (int c = 0; c < targets_[t].channels; ++c)
      whitened_[t].add(c, std::exp(at.ln_scale[t]) * picture[static_cast<std::size_t>(c)].value, y);
    data.push_back(y);
  }
  return data;
}

double FitProblem::half_chi_squared(const FitPoint& at) const {
  FitPoint copy = at;
  double cost = 0;
  build(copy, -1)->Evaluate({}, &cost, nullptr, nullptr, nullptr);
  for (const Whitened& w : whitened_) cost += w.constant / 2;
  return cost;
}

void FitProblem::set_scales(FitPoint& at) const {
  const Material material = to_material(at.material, {});
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    at.ln_scale[t] = 0;
    if (!targets_[t].scale_free) continue;
    const auto picture = reduced_picture(targets_[t], profile_, material, false);
    Eigen::VectorXd model = Eigen::VectorXd::Zero(whitened_[t].rows());
    for (int c = 0; c < targets_[t].channels; ++c)
      whitened_[t].add(c, picture[static_cast<std::size_t>(c)].value, model);
    const double up = model.dot(data(t)), down = model.squaredNorm();
    if (up > 0 && down > 0) at.ln_scale[t] = std::log(up / down);
  }
}

Eigen::MatrixXd FitProblem::jacobian(const FitPoint& at) const {
  FitPoint copy = at;
  const auto problem = build(copy, -1);
  ceres::Problem::EvaluateOptions options;
  int columns = parameter_count;
  for (double& block : copy.material) options.parameter_blocks.push_back(&block);
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    if (!targets_[t].scale_free) continue;
    options.parameter_blocks.push_back(&copy.ln_scale[t]);
    ++columns;
  }
  ceres::CRSMatrix sparse;
  problem->Evaluate(options, nullptr, nullptr, nullptr, &sparse);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(sparse.num_rows, columns);
  for (int row = 0; row < sparse.num_rows; ++row)
    for (int k = sparse.rows[static_cast<std::size_t>(row)]; k < sparse.rows[static_cast<std::size_t>(row) + 1]; ++k)
      dense(row, sparse.cols[static_cast<std::size_t>(k)]) = sparse.values[static_cast<std::size_t>(k)];
  return dense;
}

}  // namespace opaline
