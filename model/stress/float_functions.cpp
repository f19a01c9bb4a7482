// The float paths: batch dipole and table kernel, on the vector target in force, against the dipole in 100 digits.
// Errors count in units of the last place of a float. Squared distances are floats, coefficients doubles.
#include "model/profile_batch.h"
#include "model/profiles/dipole_batch.h"
#include "model/profiles/standard_dipole.h"
#include "model/stress/function.h"

#include <cmath>
#include <limits>
#include <memory>

namespace opaline {
namespace {

constexpr double float_epsilon = static_cast<double>(std::numeric_limits<float>::epsilon());

/// sigma_t' within [1e-3, 1e3]: floats hold R_d down to 1e-30 there, for any reach.
Domain float_domain(double furthest, std::vector<double> corners) {
  Domain domain = medium_domain(0.3, 3.5, {"r/l", std::move(corners), 1e-6, furthest}, "r^2", [](Input& x) {
    const double r = x[3] / x[0];
    to_medium(x);
    x[3] = static_cast<double>(static_cast<float>(r * r));
  });
  domain.axes[0] = {"sigma_t'", {1e-3, 1, 1e3}, 1e-3, 1e3};
  return domain;
}

StressFunction float_row(const std::string& name, Domain domain, double relative_error) {
  StressFunction row;
  row.name = name;
  row.domain = std::move(domain);
  row.limit = relative_error / float_epsilon;
  row.unit = 0x1p29;
  row.dark = 1e-30;
  row.reference = [](const Wide* x) { return StandardDipole<Wide>(medium_of(x)).evaluate_squared(x[3]); };
  return row;
}

double batch_dipole(const double* x) {
  const StandardDipole<double> dipole(medium_of(x));
  const float r2 = static_cast<float>(x[3]);
  float out[3];
  evaluate_dipoles_rgb({dipole, dipole, dipole}, &r2, 1, {&out[0], &out[1], &out[2]});
  return static_cast<double>(out[1]);
}

/// Keeps the table of its last medium.
struct TableOfMedium {
  Medium<double> medium{-1, -1, -1};
  ProfileTable table;

  double value(const double* x, double core_radii) {
    const Medium<double> m = medium_of(x);
    if (m.sigma_a != medium.sigma_a || m.sigma_s_prime != medium.sigma_s_prime || m.eta != medium.eta) {
      const StandardDipole<double> dipole(m);
      medium = m;
      table = ProfileTable([&](double r) { return dipole.evaluate(r); }, dipole.core_radius(),
                           core_radii * dipole.core_radius());
    }
    const ProfileTable* tables[] = {&table};
    const float r2 = static_cast<float>(x[3]);
    float value;
    float* out[] = {&value};
    evaluate_tables(tables, 1, &r2, 1, out);
    return static_cast<double>(value);
  }
};

StressFunction table_row(const std::string& name, double core_radii) {
  // Where the profile falls no faster than r^-6: errors grow with the seventh power beyond (profile_table.h).
  Domain domain = float_domain(core_radii, {0, 1e-6, 1, core_radii});
  domain.hold = 512;
  domain.valid = [](const Input& x) { return 3 * x[0] * (x[0] + x[1]) * x[3] < 9; };
  StressFunction row = float_row(name, std::move(domain), 1e-5);
  row.value = [core_radii, last = std::make_shared<TableOfMedium>()](const double* x) {
    return last->value(x, core_radii);
  };
  return row;
}

}  // namespace

void add_float_functions(std::vector<StressFunction>& rows) {
  rows.push_back(float_row("standard_dipole batch (float)", float_domain(1e6, {0, 1e-6, 1, 1e6}), 1e-6));
  rows.back().value = &batch_dipole;
  rows.push_back(table_row("profile table to 100 core radii (float)", 100));
  rows.push_back(table_row("profile table to 10000 core radii (float)", 10000));
}

}  // namespace opaline
