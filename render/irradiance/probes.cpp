#include "render/irradiance/probes.h"

#include <array>

namespace opaline {

Probes make_probes(const SurfaceCells& cells, const IrradianceField& field) {
  constexpr std::size_t per_kind = 128;
  std::array<std::vector<double>, 3> mass;  // of every cell, summed up
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto area = static_cast<double>(cell_area(cells[i]));
    const double of_cell[3] = {area, area * static_cast<double>(brightest_light(field, i)),
                               area * static_cast<double>(light_spread(field, i))};
    for (std::size_t k = 0; k < 3; ++k) mass[k].push_back((i ? mass[k].back() : 0) + of_cell[k]);
  }
  const auto share = [&](std::size_t kind, std::size_t cell) {
    const double total = mass[kind].back();
    return total > 0 ? (mass[kind][cell] - (cell ? mass[kind][cell - 1] : 0)) / total : 0.0;
  };
  Probes probes;
  for (std::size_t kind = 0; kind < 3; ++kind) {
    if (mass[kind].back() <= 0) continue;
    for (std::size_t i = 0; i < per_kind; ++i) {
      const double target = (static_cast<double>(i) + 0.5) / per_kind * mass[kind].back();
      const auto cell =
          static_cast<std::size_t>(std::upper_bound(mass[kind].begin(), mass[kind].end(), target) - mass[kind].begin());
      if (cell >= cells.size()) continue;
      // A low-discrepancy sequence of the plane, folded into the triangle.
      float u = static_cast<float>(std::fmod(0.7548776662466927 * static_cast<double>(i + 1), 1.0)),
            v = static_cast<float>(std::fmod(0.5698402909980532 * static_cast<double>(i + 1), 1.0));
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const SurfaceCell& c = cells[cell];
      probes.positions.push_back(c.a + u * (c.b - c.a) + v * (c.c - c.a));
      const double density = share(0, cell) + share(1, cell) + share(2, cell);
      probes.weights.push_back(static_cast<double>(cell_area(c)) / density);
    }
  }
  return probes;
}

}  // namespace opaline
