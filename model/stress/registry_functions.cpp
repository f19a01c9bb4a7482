// Every profile as anyone gets it from the registry: validity alone, of what its Profile offers.
#include "model/profiles/profile.h"
#include "model/stress/function.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace opaline {
namespace {

bool has_thickness(const ProfileInfo& info) {
  return std::ranges::any_of(info.parameters, [](const ProfileParameter& p) { return p.name == "thickness_mm"; });
}

std::vector<ProfileSample> steep_samples() {
  std::vector<ProfileSample> samples;
  for (double r = 1e-3; r < 300; r *= 1.5) samples.push_back({r, std::exp(-r) / (r + 1e-2)});
  return samples;
}

/// What the row needs: a slab of thickness x[3], above two other layers if it takes any; a steep table.
ProfileParameters parameters_at(const ProfileInfo& info, const double* x) {
  ProfileParameters parameters;
  const double l = 1 / (x[0] + x[1]);
  if (has_thickness(info)) parameters["thickness_mm"] = x[3];
  for (const ProfileParameter& p : info.parameters) {
    if (p.kind == ParameterKind::samples) parameters[p.name] = steep_samples();
    if (p.kind != ParameterKind::layers) continue;
    parameters[p.name] = std::vector<Layer>{{{0.3 / l, 2 / l, 1.4}, 3 * l}, {{1e-3 / l, 0.5 / l, 1.2}, HUGE_VAL}};
  }
  return parameters;
}

/// Medium, thickness if the row has one, and `last`, of length 1/x[0] if `scaled`.
Domain domain_of(const ProfileInfo& info, const Axis& last, bool scaled) {
  Domain domain = medium_domain(std::max(info.domain.eta_min, 0.3), std::min(info.domain.eta_max, 3.5));
  if (has_thickness(info)) {
    domain.axes.push_back(thickness_axis());
    domain.inputs.push_back("d");
  }
  domain.axes.push_back(last);
  domain.inputs.push_back(scaled ? "r" : last.name);
  if (!has_thickness(info)) {
    domain.to_inputs = scaled ? [](Input& x) { x[3] /= x[0]; to_medium(x); } : [](Input& x) { to_medium(x); };
  } else {
    domain.to_inputs = scaled ? [](Input& x) { x[3] /= x[0]; x[4] /= x[0]; to_medium(x); }
                              : [](Input& x) { x[3] /= x[0]; to_medium(x); };
  }
  domain.hold = 512;
  return domain;
}

/// The profile of the last medium: some prepare tables.
struct Last {
  Input input{};
  std::unique_ptr<Profile> profile;

  const Profile& at(const ProfileInfo& info, const double* x) {
    const std::size_t count = has_thickness(info) ? 4 : 3;
    if (!profile || !std::equal(x, x + count, input.begin())) {
      profile = info.make({x[0], x[1], x[2]}, parameters_at(info, x));
      std::copy(x, x + count, input.begin());
    }
    return *profile;
  }
};

using Member = double (Profile::*)(double) const;

StressFunction row(const ProfileInfo& info, const std::string& what, Member member, const Axis& last, bool scaled) {
  StressFunction row;
  row.name = "profile " + info.name + what;
  row.domain = domain_of(info, last, scaled);
  row.value = [&info, member, index = row.domain.dimension() - 1, last_one = std::make_shared<Last>()](
                  const double* x) { return (last_one->at(info, x).*member)(x[index]); };
  return row;
}

StressFunction radial(const ProfileInfo& info, const std::string& what, Member member, std::optional<bool> rising) {
  StressFunction radial = row(info, what, member, radius_axis(), true);
  if (rising) radial.monotone = Monotone{radial.domain.dimension() - 1, *rising};
  return radial;
}

}  // namespace

void add_registry_functions(std::vector<StressFunction>& rows) {
  for (const ProfileInfo& info : profiles()) {
    const std::optional<bool> falling = info.monotone ? std::optional(false) : std::nullopt;
    rows.push_back(radial(info, "", &Profile::evaluate, falling));
    rows.push_back(radial(info, ".cumulative", &Profile::cumulative, true));
    rows.push_back(row(info, ".sample", &Profile::sample, share_axis(), false));
    if (info.has_transmittance) rows.push_back(radial(info, ".transmittance", &Profile::transmittance, falling));
  }
}

}  // namespace opaline
