#include "model/stress/stress.h"

#include "model/stress/reference.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

namespace opaline {
namespace {

constexpr double dark = 1e-280;            // below, intermediate results lose digits to gradual underflow
constexpr double monotone_margin = 1e-12;  // relative, times 1 + condition: what rounding may do to two neighbours

std::vector<double> used_inputs(const StressFunction& row, const Input& input) {
  return {input.begin(), input.begin() + static_cast<std::ptrdiff_t>(row.domain.dimension())};
}

StressResult empty_result(const StressFunction& row, bool derivative) {
  StressResult result;
  result.name = row.name;
  result.derivative = derivative;
  result.domain = describe(row.domain);
  result.limit = derivative ? loose_limit : row.limit;
  for (std::size_t i = 0; i < row.domain.dimension(); ++i) result.inputs.push_back(row.domain.input_name(i));
  return result;
}

void keep_worst(WorstCase& worst, double value, double condition, const StressFunction& row, const Input& input) {
  if (value > worst.value) worst = {value, condition, used_inputs(row, input)};
}

/// Counts one invalid value in `counter`.
void count_invalid(std::uint64_t& counter, StressResult& result, const StressFunction& row, const Input& input) {
  if (result.invalid() == 0) result.invalid_at = used_inputs(row, input);
  ++counter;
}

/// Whether `value` is a number a function may return.
bool check_value(double value, StressResult& result, const StressFunction& row, const Input& input) {
  ++result.checked;
  if (std::isnan(value)) {
    count_invalid(result.nan, result, row, input);
  } else if (std::isinf(value)) {
    count_invalid(result.infinite, result, row, input);
  } else if (value < 0 && row.non_negative && !result.derivative) {
    count_invalid(result.negative, result, row, input);
  } else {
    return true;
  }
  return false;
}

void compare(double value, const Exact& exact, StressResult& result, const StressFunction& row, const Input& input) {
  ++result.points;
  if (exact.size != 0 && exact.size < row.dark) {
    ++result.dark;
    if (std::abs(value) > 2 * row.dark) keep_worst(result.scaled, HUGE_VAL, exact.condition, row, input);
    return;
  }
  const double error = ulp_error(value, exact) / row.unit;
  keep_worst(result.plain, error, exact.condition, row, input);
  keep_worst(result.scaled, error / (1 + exact.condition), exact.condition, row, input);
}

/// A point further along the row's monotone axis, still inside it.
Input further(const StressFunction& row, Input axis_values, double factor) {
  const Axis& axis = row.domain.axes[row.monotone->axis];
  double& value = axis_values[row.monotone->axis];
  if (row.monotone->from_one && value < 1) {
    value = std::max(value / factor, axis.low);
  } else {
    const double top = axis.spread == Spread::share ? 1 - 0x1p-53 : axis.high;
    value = std::max(value, std::min(std::max(value * factor, axis.low), top));
  }
  return axis_values;
}

/// Where a drop is small its excuse may be the condition, which only the reference knows.
double margin_at(const StressFunction& row, const Input& input) {
  return monotone_margin * (row.reference ? 1 + exact_value(row, input).condition : 1);
}

void check_monotone(double value, const Input& axis_values, double factor, StressResult& result,
                    const StressFunction& row) {
  const Input here = row.domain.inputs_at(axis_values), there = row.domain.inputs_at(further(row, axis_values, factor));
  if (!row.domain.contains(there)) return;
  const double change = row.value(there.data()) - value, wrong = row.monotone->rising ? -change : change;
  const double size = std::abs(value);
  if (wrong <= monotone_margin * size || size < dark) return;
  if (wrong > margin_at(row, here) * size) count_invalid(result.not_monotone, result, row, here);
}

/// Checks in double alone at axis values inside the domain.
void check_point(const Input& axis_values, SplitMix& random, StressResult& result, const StressFunction& row) {
  const Input input = row.domain.inputs_at(axis_values);
  if (!row.domain.contains(input)) return;
  const double value = row.value(input.data());
  if (check_value(value, result, row, input) && row.monotone) {
    check_monotone(value, axis_values, 1 + log_uniform(random, 1e-3, 10), result, row);
  }
}

/// Calls visit(axis values): every `stride`-th corner from a random one, then `count` random points.
template <typename Visit>
void visit_points(const StressFunction& row, std::uint64_t count, SplitMix& random, const Visit& visit,
                  std::uint64_t stride = 1) {
  const std::vector<Input> corners = corner_points(row.domain);
  for (std::size_t i = stride > 1 ? random() % stride : 0; i < corners.size(); i += stride) visit(corners[i]);
  Input point{};
  for (std::uint64_t i = 0; i < count; ++i) {
    point = random_point(row.domain, random, point, i % row.domain.hold != 0);
    visit(point);
  }
}

/// A costly row gets fewer random points too, yet some.
std::uint64_t random_points(const StressFunction& row, std::uint64_t points) {
  return std::max<std::uint64_t>(2, points / row.cost);
}

/// A costly row leaves out corners when few points are asked for.
std::uint64_t corner_stride(const StressFunction& row, const StressOptions& options) {
  return std::max<std::uint64_t>(1, 64 * row.cost / std::max<std::uint64_t>(64, options.points));
}

StressResult stress_values(const StressFunction& row, const StressOptions& options, std::uint64_t seed) {
  StressResult result = empty_result(row, false);
  SplitMix random{seed};
  visit_points(row, options.count, random, [&](const Input& point) { check_point(point, random, result, row); });
  if (!row.reference) return result;
  visit_points(
      row, random_points(row, options.points), random,
      [&](const Input& point) {
        const Input input = row.domain.inputs_at(point);
        if (!row.domain.contains(input)) return;
        const double value = row.value(input.data());
        if (std::isfinite(value)) compare(value, exact_value(row, input), result, row, input);
      },
      corner_stride(row, options));
  return result;
}

void stress_gradient(const Input& input, StressResult& result, const StressFunction& row) {
  std::array<double, most_inputs> gradient{};
  row.gradient(input.data(), gradient.data());
  for (std::size_t by = 0; by < row.gradient_inputs; ++by) {
    if (check_value(gradient[by], result, row, input)) {
      compare(gradient[by], exact_derivative(row, input, by), result, row, input);
    }
  }
}

StressResult stress_derivatives(const StressFunction& row, const StressOptions& options, std::uint64_t seed) {
  StressResult result = empty_result(row, true);
  SplitMix random{seed};
  visit_points(
      row, random_points(row, options.points / 8), random,
      [&](const Input& point) {
        const Input input = row.domain.inputs_at(point);
        const bool valid = row.gradient_valid == nullptr || row.gradient_valid(input);
        if (valid && row.domain.contains(input)) stress_gradient(input, result, row);
      },
      corner_stride(row, options));
  return result;
}

struct Task {
  const StressFunction* row;
  bool derivative;
  std::uint64_t seed;
};

std::vector<Task> tasks_of(const std::vector<StressFunction>& rows, const StressOptions& options) {
  std::vector<Task> tasks;
  SplitMix seeds{options.seed};
  for (const StressFunction& row : rows) {
    const std::uint64_t value_seed = seeds(), gradient_seed = seeds();
    if (row.name.find(options.only) == std::string::npos) continue;
    tasks.push_back({&row, false, value_seed});
    if (row.gradient) tasks.push_back({&row, true, gradient_seed});
  }
  return tasks;
}

}  // namespace

std::vector<std::string> stress_function_names() {
  std::vector<std::string> names;
  for (const StressFunction& row : stress_functions()) names.push_back(row.name);
  return names;
}

std::vector<StressResult> run_stress(const StressOptions& options) { return run_stress(stress_functions(), options); }

std::vector<StressResult> run_stress(const std::vector<StressFunction>& rows, const StressOptions& options) {
  const std::vector<Task> tasks = tasks_of(rows, options);
  std::vector<StressResult> results(tasks.size());
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < tasks.size(); i = next++) {
      const Task& task = tasks[i];
      results[i] = (task.derivative ? stress_derivatives : stress_values)(*task.row, options, task.seed);
    }
  };
  const unsigned wanted =
      options.threads > 0 ? static_cast<unsigned>(options.threads) : std::max(1u, std::thread::hardware_concurrency());
  std::vector<std::jthread> threads;
  for (unsigned i = 1; i < wanted; ++i) threads.emplace_back(work);
  work();
  threads.clear();
  return results;
}

}  // namespace opaline
