// A row of the stress registry: one formula as double, dual number and 100 digits.
#pragma once

#include "model/stress/domain.h"
#include "model/stress/stress.h"
#include "model/stress/wide.h"

#include <ceres/jet.h>

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace opaline {

/// Rounding to 8 units in the last place.
constexpr double tight_limit = 8;
/// 1e-12 relative, in units of the last place (one of which is at most 2^-52 relative).
constexpr double loose_limit = 1e-12 / std::numeric_limits<double>::epsilon();

/// The value never falls (rising) or never rises with one axis; `from_one`: with its distance from 1, either way.
struct Monotone {
  std::size_t axis;
  bool rising;
  bool from_one = false;
};

struct StressFunction {
  std::string name;
  Domain domain;
  double limit = tight_limit;
  std::function<double(const double*)> value;
  std::function<Wide(const Wide*)> reference;                 ///< empty: validity is checked, nothing compared
  std::function<void(const double*, double*)> gradient = {};  ///< by the first `gradient_inputs` inputs
  std::size_t gradient_inputs = 0;
  bool (*gradient_valid)(const Input& inputs) = nullptr;  ///< nullptr: wherever the function is
  /// The change of input i that changes the function f by its own size, where a derivative is what is left over from
  /// terms of size f/scale: its error is then counted against these if they are larger. nullptr: no such cancellation.
  double (*gradient_scale)(const Input& inputs, std::size_t i) = nullptr;
  bool non_negative = true;
  std::optional<Monotone> monotone = std::nullopt;
  double unit = 1;         ///< errors and limit count in this many units of the last place of a double; 2^29 for floats
  double dark = 1e-280;    ///< below, digits are lost to underflow: the value must be small too and isn't compared
  std::uint64_t cost = 1;  ///< divides the number of points, and of corners, in 100 digits
};

/// A formula written once: `f` takes a pointer to its inputs, of any scalar.
template <typename F>
StressFunction stress_function(std::string name, Domain domain, double limit, F f) {
  StressFunction row;
  row.name = std::move(name);
  row.domain = std::move(domain);
  row.limit = limit;
  row.value = [f](const double* x) { return f(x); };
  row.reference = [f](const Wide* x) { return f(x); };
  return row;
}

/// As above, with derivatives by the first N inputs.
template <std::size_t N, typename F>
StressFunction differentiated(std::string name, Domain domain, double limit, F f) {
  using Dual = ceres::Jet<double, static_cast<int>(N)>;
  StressFunction row = stress_function(std::move(name), std::move(domain), limit, f);
  row.gradient_inputs = N;
  row.gradient = [f, dimension = row.domain.dimension()](const double* x, double* gradient) {
    std::array<Dual, most_inputs> inputs;
    for (std::size_t i = 0; i < dimension; ++i) {
      inputs[i] = i < N ? Dual(x[i], static_cast<int>(i)) : Dual(x[i]);
    }
    const Dual result = f(static_cast<const Dual*>(inputs.data()));
    for (std::size_t i = 0; i < N; ++i) gradient[i] = result.v[static_cast<int>(i)];
  };
  return row;
}

inline StressFunction with_monotone(StressFunction row, Monotone monotone) {
  row.monotone = monotone;
  return row;
}

inline StressFunction with_cost(StressFunction row, std::uint64_t cost) {
  row.cost = cost;
  return row;
}

/// The axes (sigma_t', 1 - alpha', eta) of a medium, which become the inputs (sigma_a, sigma_s', eta), and one more.
Domain medium_domain(double eta_low, double eta_high);
Domain medium_domain(double eta_low, double eta_high, Axis last, const std::string& input, void (*to_inputs)(Input&));

/// (sigma_t', 1 - alpha', ...) to (sigma_a, sigma_s', ...).
void to_medium(Input& x);

template <typename T>
Medium<T> medium_of(const T* x) {
  return {x[0], x[1], x[2]};
}

/// The same with alpha' >= 0.1, where normalised diffusion is meant to hold: its albedo's digits go like alpha'.
Domain scattering(Domain medium);

/// gradient_scale of a medium: sigma_t' for both coefficients.
double medium_scale(const Input& x, std::size_t i);

Axis share_axis();                       ///< xi in [0, 1)
Axis radius_axis();                      ///< r in transport mean free paths, 0 and 1e-12 to 1e6
Axis thickness_axis();                   ///< d likewise, 1e-6 to 1e6
Axis eta_axis(double low, double high);  ///< with 1, 1 +- 1e-9, 0.5 and 3
void add_fresnel_functions(std::vector<StressFunction>& rows);
void add_profile_functions(std::vector<StressFunction>& rows);
void add_slab_functions(std::vector<StressFunction>& rows);
void add_single_scattering_functions(std::vector<StressFunction>& rows);
void add_sampling_functions(std::vector<StressFunction>& rows);
void add_registry_functions(std::vector<StressFunction>& rows);
void add_float_functions(std::vector<StressFunction>& rows);

/// All rows. They may remember their last inputs: one thread each.
std::vector<StressFunction> stress_functions();

/// run_stress over these rows.
std::vector<StressResult> run_stress(const std::vector<StressFunction>& rows, const StressOptions& options);

}  // namespace opaline
