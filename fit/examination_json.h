// The parts of fit.json that examine a fit: what is determined, other models, repetitions, advice.
#pragma once

#include "fit/fit_job.h"

#include <nlohmann/json.hpp>

namespace opaline {

nlohmann::json diagnosis_json(const Diagnosis& diagnosis);
nlohmann::json comparison_json(const ModelComparison& comparison);
/// names: of the solver's parameters, in order.
nlohmann::json bootstrap_json(const Bootstrap& bootstrap, const nlohmann::json& names);
nlohmann::json correction_json(const Correction& correction, const nlohmann::json& names);
nlohmann::json surface_json(const SurfaceBias& surface);
nlohmann::json advice_json(const std::vector<Advice>& advice);

}  // namespace opaline
