#include "fit/compare_models.h"

#include "fit/fit_problem.h"
#include "fit/noise_weights.h"
#include "model/profiles/profile.h"
#include "render/stopwatch.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

/// Do two profiles have the same values wherever the operator looks?
bool same_values(const TransportOperator& op, const ProfileInfo& a, const ProfileInfo& b, const Material& material) {
  for (int c = 0; c < 3; ++c) {
    const auto u = radial_coefficients(op, a, material.channel(c)), v = radial_coefficients(op, b, material.channel(c));
    for (std::size_t n = 0; n < u.size(); ++n)
      if (std::abs(u[n].value - v[n].value) > 1e-6 * std::abs(v[n].value) + 1e-300) return false;
  }
  return true;
}

double count_of(const std::vector<FitTarget>& targets) {
  double count = 0;
  for (const FitTarget& target : targets) count += static_cast<double>(target.rows()) * target.channels;
  return count;
}

/// The parameter in which two fits differ most, in percent of `truth`, among those that both determine.
struct Disagreement {
  int parameter = -1;
  double percent = 0;
};

Disagreement largest_disagreement(const Uncertainty& model, const Uncertainty& truth) {
  Disagreement worst;
  for (int i = 0; i < parameter_count; ++i) {
    const ParameterEstimate &a = model.parameters[static_cast<std::size_t>(i)],
                            &b = truth.parameters[static_cast<std::size_t>(i)];
    if (!a.free || !b.identifiable) continue;
    const double percent = 100 * (a.value / b.value - 1), sd = 100 * std::hypot(a.sd / a.value, b.sd / b.value);
    if (std::abs(percent) > std::max(2.0, 3 * sd) && std::abs(percent) > std::abs(worst.percent)) worst = {i, percent};
  }
  return worst;
}

/// Why a profile is left out, or nothing.
std::string not_comparable(const ProfileInfo& profile, const std::string& chosen) {
  if (profile.depends_on_direction) return "depends on the direction of the light";
  if (!profile.depends_on_medium) return "does not depend on the medium";
  if (profile.radiance && profile.name != chosen) return "for flat objects lit and seen straight on";
  return {};
}

void warn(ModelComparison& comparison, const std::string& chosen) {
  const ProfileInfo* info = find_profile(chosen);
  const std::string transport = info != nullptr && info->radiance ? chosen : "transport_table";
  const ModelFit* truth = nullptr;
  for (const ModelFit& m : comparison.models)
    if (m.name == transport) truth = &m;
  if (truth == nullptr) return;
  for (const ModelFit& m : comparison.models) {
    if (m.name == transport || !m.same_as.empty()) continue;
    const bool fits = m.solution.relative_rmse < std::max(0.02, 1.1 * truth->solution.relative_rmse);
    const Disagreement d = largest_disagreement(m.uncertainty, truth->uncertainty);
    if (fits && d.parameter >= 0)
      comparison.warnings.push_back(fmt::format(
          "{} fits to {:.2g} of the picture and still disagrees with transport: its {} is {:+.0f} % from it. A small "
          "residual is not accuracy",
          m.name, m.solution.relative_rmse, parameter_name(d.parameter), d.percent));
    if (m.name == chosen && m.delta_bic > 10)
      comparison.warnings.push_back(
          fmt::format("the data prefer another model to {} (information criterion {:.0f} worse)", chosen, m.delta_bic));
  }
  if (truth->delta_bic > 10)
    comparison.warnings.push_back(
        fmt::format("a model fits better than transport (information criterion {:.0f} better): the scene's shape, "
                    "light or scale may "
                    "be described wrongly, the curvature may matter, or the pictures were made with that model",
                    truth->delta_bic));
}

}  // namespace

ModelComparison compare_models(const std::vector<FitTarget>& targets, const std::string& chosen,
                               const Solution& solution, const Uncertainty& chosen_uncertainty,
                               const Material& material, const SolveSettings& settings, int starts) {
  Stopwatch watch;
  ModelComparison out;
  SolveSettings few = settings;
  few.starts = 1 + starts;
  std::vector<const ProfileInfo*> fitted;
  for (const std::string& name : medium_profile_names()) {
    const ProfileInfo& profile = *find_profile(name);
    if (const std::string why = not_comparable(profile, chosen); !why.empty()) {
      out.left_out.push_back(name + ": " + why);
      continue;
    }
    ModelFit model;
    model.name = name;
    for (const ProfileInfo* other : fitted)
      if (model.same_as.empty() && same_values(targets.front().op, profile, *other, material))
        model.same_as = other->name;
    if (model.same_as.empty()) fitted.push_back(&profile);
    out.models.push_back(std::move(model));
  }
  // Each model on its own: few starts alone would leave processors idle.
  tbb::parallel_for(std::size_t{0}, out.models.size(), [&](std::size_t i) {
    ModelFit& model = out.models[i];
    if (!model.same_as.empty()) return;
    const bool own = model.name == chosen;
    model.solution = own ? solution : solve(targets, *find_profile(model.name), material, few);
    model.uncertainty = own ? chosen_uncertainty : uncertainty(model.solution, settings.free);
  });
  const double n = count_of(targets);
  double best = HUGE_VAL;
  for (ModelFit& m : out.models) {
    if (!m.same_as.empty()) continue;
    m.bic = m.solution.minus_two_ln_likelihood + (n - m.solution.freedom) * std::log(n);
    best = std::min(best, m.bic);
  }
  for (ModelFit& m : out.models) m.delta_bic = m.same_as.empty() ? m.bic - best : 0;
  warn(out, chosen);
  out.seconds = watch.lap();
  return out;
}

}  // namespace opaline
