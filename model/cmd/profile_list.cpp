// `opaline profile list`.
#include "model/cmd/profile_list.h"

#include "model/profiles/profile.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace opaline {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinity: null.
Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json to_json(const ProfileParameter& p) {
  Json json = {{"name", p.name}, {"unit", p.unit}, {"meaning", p.meaning}};
  if (p.kind == ParameterKind::number) json["range"] = {finite(p.low), finite(p.high)};
  json["default"] = p.fallback ? Json(describe(*p.fallback)) : Json();
  return json;
}

Json to_json(const ProfileInfo& info) {
  const ProfileDomain& d = info.domain;
  Json json = {{"name", info.name}, {"citation", info.citation}};
  json["domain"] = {{"eta", {d.eta_min, finite(d.eta_max)}},
                    {"alpha_prime_min", d.alpha_prime_min},
                    {"thickness_min_mfp", d.thickness_min_mfp},
                    {"note", d.note}};
  json["monotone"] = info.monotone;
  json["conserves_energy"] = info.conserves_energy;
  json["depends_on_direction"] = info.depends_on_direction;
  json["has_transmittance"] = info.has_transmittance;
  json["needs_medium_alone"] = info.needs_medium_alone();
  json["parameters"] = Json::array();
  for (const ProfileParameter& p : info.parameters) json["parameters"].push_back(to_json(p));
  return json;
}

void print(const ProfileInfo& info) {
  const ProfileDomain& d = info.domain;
  fmt::print("{}\n    {}\n", info.name, info.citation);
  if (info.depends_on_medium) {
    fmt::print("    eta {} .. {}, alpha' >= {}", d.eta_min, d.eta_max, d.alpha_prime_min);
    if (d.thickness_min_mfp > 0) fmt::print(", layers >= {}/sigma_t'", d.thickness_min_mfp);
    fmt::print("{}{}\n", info.depends_on_direction ? "; depends on the direction of incidence" : "",
               info.conserves_energy ? "" : "; may reflect more than falls in");
  }
  fmt::print("    {}\n", d.note);
  for (const ProfileParameter& p : info.parameters) {
    fmt::print("    --set {}=... [{}] {} ({})\n", p.name, p.unit, p.meaning,
               p.fallback ? "default " + describe(*p.fallback) : "required");
  }
}

}  // namespace

void list_profiles(bool as_json) {
  Json rows = Json::array();
  for (const ProfileInfo& info : profiles()) as_json ? void(rows.push_back(to_json(info))) : print(info);
  if (as_json) fmt::print("{}\n", rows.dump(2));
}

}  // namespace opaline
