#include "model/cmd/commands.h"
#include "model/cmd/medium_options.h"
#include "model/cmd/transport_table.h"
#include "model/transport/walk.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <memory>

namespace opaline {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  MediumOptions medium;
  double thickness = std::numeric_limits<double>::infinity(), cosine = 1;
  std::string radii = "0:10:1";
  std::uint64_t walks = 10000000, seed = 1;
};

Json to_json(const Estimate& e) { return {{"value", e.value}, {"standard_error", e.standard_error}}; }

Json to_json(const std::vector<AnnulusEstimate>& annuli) {
  Json rows = Json::array();
  for (const AnnulusEstimate& a : annuli) {
    rows.push_back({{"inner_mm", a.inner},
                    {"outer_mm", a.outer},
                    {"exitance_per_mm2", to_json(a.exitance)},
                    {"scattered_once_per_mm2", to_json(a.once)}});
  }
  return rows;
}

Json to_json(const SearchlightResult& r) {
  return {{"conventions", "per flux that has entered, without the beam's specular reflection; one standard error"},
          {"walks", r.walks},
          {"scatterings", r.scatterings},
          {"specular_per_incident", r.specular},
          {"reflected", to_json(r.reflected)},
          {"reflected_per_incident", to_json(r.reflected_per_incident())},
          {"reflected_per_incident_with_specular", to_json(r.reflected_per_incident_with_specular())},
          {"transmitted", to_json(r.transmitted)},
          {"transmitted_unscattered", to_json(r.unscattered_transmitted)},
          {"absorbed", to_json(r.absorbed)},
          {"reflectance", to_json(r.reflectance)},
          {"transmittance", to_json(r.transmittance)}};
}

void walk(const Options& o) {
  const std::vector<Medium<double>> media = media_of(o.medium);
  require_argument(media.size() == 1, "--sigma-a, --sigma-s-prime: a walk takes one channel, one number each");
  require_argument(o.thickness > 0, "--thickness: must be above 0 mm");
  const Searchlight light{media[0], o.medium.g, o.cosine, parse_radii(o.radii), o.walks, o.seed};
  fmt::print("{}\n",
             to_json(std::isfinite(o.thickness) ? walk_slab(light, o.thickness) : walk_half_space(light)).dump(2));
}

void add_walk(CLI::App& transport) {
  const auto o = std::make_shared<Options>();
  CLI::App* app = transport.add_subcommand("walk", "Monte-Carlo of a pencil beam on a half space or slab, as JSON");
  app->add_option("--sigma-a", o->medium.sigma_a, "Absorption [1/mm]")->required()->delimiter(',');
  app->add_option("--sigma-s-prime", o->medium.sigma_s_prime, "Reduced scattering [1/mm]")->required()->delimiter(',');
  app->add_option("--eta", o->medium.eta, "Refraction index, inside / outside")->required();
  app->add_option("--g", o->medium.g, "Mean scattering cosine (Henyey-Greenstein)")->capture_default_str();
  app->add_option("--thickness", o->thickness, "Of a slab [mm]; without it a half space");
  app->add_option("--cosine", o->cosine, "Of the beam with the normal, outside")->capture_default_str();
  app->add_option("--r", o->radii, "Edges of the annuli lo:hi:step [mm]")->capture_default_str();
  app->add_option("--walks", o->walks, "Number of photons")->capture_default_str();
  app->add_option("--seed", o->seed, "Same seed, same numbers")->capture_default_str();
  app->footer("Example: opaline transport walk --sigma-a 0.1 --sigma-s-prime 0.9 --eta 1.3 --walks 1000000");
  app->callback([o] { walk(*o); });
}

}  // namespace

void add_transport_command(CLI::App& app) {
  CLI::App* transport = app.add_subcommand("transport", "The truth for plane media: walks, the table, models' errors");
  transport->require_subcommand(1);
  transport->footer("Example: opaline transport errors");
  add_walk(*transport);
  add_transport_table_commands(*transport);
}

}  // namespace opaline
