// What the tests of model/transport share: reference tables, and a plain scalar walk to compare with.
#pragma once

#include "model/fresnel.h"

#include <cmath>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace opaline::test {

/// Rows of tests/reference/NAME, by column name. Lines with # are comments.
inline std::vector<std::map<std::string, double>> read_reference(const std::string& name) {
  std::ifstream file(std::string(OPALINE_SOURCE_DIR) + "/tests/reference/" + name);
  if (!file) throw std::runtime_error("no tests/reference/" + name);
  std::vector<std::string> columns;
  std::vector<std::map<std::string, double>> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    if (columns.empty()) {
      columns = cells;
      continue;
    }
    rows.emplace_back();
    for (std::size_t i = 0; i < columns.size(); ++i) rows.back()[columns[i]] = std::stod(cells.at(i));
  }
  return rows;
}

struct ScalarWalk {
  double albedo, g, eta, thickness, cos_incident;
};

struct ScalarTotals {
  double reflected = 0, transmitted = 0, absorbed = 0;
  std::uint64_t scatterings = 0;
};

/// The textbook loop, one photon at a time in double, absorption by chance: nothing shared with the vector code but
/// the Fresnel formula. Its scattering turns a random frame instead of one built from the direction.
inline ScalarTotals scalar_walk(const ScalarWalk& w, int walks, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  const double sine = std::sqrt(1 - w.cos_incident * w.cos_incident) / w.eta;
  ScalarTotals totals;
  for (int walk = 0; walk < walks; ++walk) {
    double z = 0, uz = std::sqrt(1 - sine * sine);
    for (bool alive = true; alive;) {
      double left = -std::log(1 - uniform(engine));
      for (;;) {
        const double wall = uz > 0 ? (w.thickness - z) / uz : -z / uz;
        if (left < wall) break;
        left -= wall;
        z = uz > 0 ? w.thickness : 0;
        if (uniform(engine) >= fresnel_reflectance(std::abs(uz), 1 / w.eta)) {
          (uz > 0 ? totals.transmitted : totals.reflected) += 1.0 / walks;
          alive = false;
          break;
        }
        uz = -uz;
      }
      if (!alive) break;
      z += uz * left;
      ++totals.scatterings;
      if (uniform(engine) >= w.albedo) {
        totals.absorbed += 1.0 / walks;
        break;
      }
      // Only the cosine with the normal matters to totals: the law of cosines with a random azimuth.
      const double s = 2 * uniform(engine) - 1;
      const double turn = w.g == 0 ? s : (1 + w.g * w.g - std::pow((1 - w.g * w.g) / (1 + w.g * s), 2)) / (2 * w.g);
      const double across = std::sqrt(std::max(0.0, (1 - uz * uz) * (1 - turn * turn)));
      uz = uz * turn + across * std::cos(2 * pi * uniform(engine));
    }
  }
  return totals;
}

}  // namespace opaline::test
