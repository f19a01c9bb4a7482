#include "model/transport/transport_table_maker.h"

#include "model/profiles/transport_table.h"
#include "model/transport/searchlight_mixture.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

using Shape = TransportTableShape;

/// Values at the Chebyshev points of one variable to coefficients, in place; `stride` apart.
void transform(std::vector<double>& values, std::size_t first, std::size_t stride, std::size_t count) {
  std::vector<double> coefficients(count);
  std::size_t j = 0;
  chebyshev_fit(
      count, [&](double) { return values[first + stride * j++]; }, coefficients);
  for (std::size_t k = 0; k < count; ++k) values[first + stride * k] = coefficients[k];
}

void to_series(std::vector<double>& values) {
  constexpr std::size_t row = Shape::radii, plane = row * Shape::albedos;
  for (std::size_t i = 0; i < Shape::indices * Shape::albedos; ++i) transform(values, i * row, 1, Shape::radii);
  for (std::size_t e = 0; e < Shape::indices; ++e)
    for (std::size_t r = 0; r < row; ++r) transform(values, e * plane + r, row, Shape::albedos);
  for (std::size_t i = 0; i < plane; ++i) transform(values, i, plane, Shape::indices);
}

}  // namespace

double transport_table_value(const SearchlightMixture& mixture, double absorbed, double rho) {
  const double d = std::sqrt(1 + rho * rho), kd = mixture.decay * d;
  const double log_pole = std::log1p(kd) - kd - 3 * std::log(d) - std::log(2 * pi);
  return mixture.log_evaluate(rho) - 2 * std::log1p(-absorbed) - log_pole;
}

TransportTableCoefficients make_transport_table(SearchlightExit exit,
                                                const std::function<void(std::size_t, std::size_t)>& progress) {
  std::vector<double> absorbed, albedos;
  for (std::size_t a = 0; a < Shape::albedos; ++a) {
    absorbed.push_back(Shape::absorbed_at(chebyshev_point(a, Shape::albedos)));
    albedos.push_back(1 - absorbed.back());
  }
  TransportTableCoefficients table;
  std::vector<double> values;
  for (std::size_t e = 0; e < Shape::indices; ++e) {
    const double eta = Shape::eta_at(chebyshev_point(e, Shape::indices));
    const std::vector<SearchlightMixture> mixtures = searchlight_mixtures(eta, albedos, 1.3, exit);
    for (std::size_t a = 0; a < Shape::albedos; ++a) {
      const double reach = Shape::reach(absorbed[a]);
      for (std::size_t r = 0; r < Shape::radii; ++r) {
        const double rho = Shape::radius_at(chebyshev_point(r, Shape::radii), reach);
        values.push_back(transport_table_value(mixtures[a], absorbed[a], rho));
      }
      table.worst_residual = std::max(table.worst_residual, mixtures[a].residual);
    }
    progress(e + 1, Shape::indices);
  }
  to_series(values);
  if (exit == SearchlightExit::exitance) values[0] -= Shape::margin;
  for (const double v : values) table.values.push_back(static_cast<std::int32_t>(std::lround(v / Shape::unit)));
  return table;
}

}  // namespace opaline
