#include "model/cmd/commands.h"
#include "model/cmd/medium_options.h"
#include "model/cmd/profile_list.h"
#include "model/cmd/profile_output.h"
#include "model/cmd/profile_parameters.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>

namespace opaline {
namespace {

struct Options {
  std::vector<std::string> models = {"standard_dipole"}, settings, layers;
  std::string radii = "0:20:0.1";
  MediumOptions medium;
  bool json = false, csv = false, all = false;
};

TabulatedModel tabulated_model(const ProfileInfo& info, const std::vector<Medium<double>>& media,
                               const ProfileParameters& parameters, const std::vector<double>& radii) {
  TabulatedModel model{info.name, {}};
  for (const Medium<double>& medium : media) {
    model.channels.push_back(tabulate(info, *info.make(medium, parameters), radii));
    for (const std::string& reason : info.outside_domain(medium, parameters))
      fmt::print(stderr, "opaline: outside the domain of {}: {}\n", info.name, reason);
  }
  return model;
}

/// The media the options name; a table needs none.
std::vector<Medium<double>> media_for(const Options& o, const std::vector<const ProfileInfo*>& models,
                                      const std::vector<Layer>& stack) {
  const MediumOptions& m = o.medium;
  const bool none = m.material.empty() && m.sigma_a.empty() && m.sigma_s_prime.empty();
  require_argument(stack.empty() || none, "--layer: the first layer is the medium; give no other");
  if (!stack.empty()) return {stack.front().medium};
  if (none && models.size() == 1 && !models[0]->depends_on_medium) return {{0, 1, 1}};
  return media_of(m);
}

void run(const Options& o) {
  const auto models = models_of(o.models);
  const std::vector<Layer> stack = parse_layers(o.layers);
  std::vector<ProfileParameters> parameters = parameters_of(models, o.settings);
  if (!stack.empty()) add_layers(models, stack, parameters);
  const std::vector<double> radii = parse_radii(o.radii);
  const auto media = media_for(o, models, stack);
  std::vector<TabulatedModel> tables;
  for (std::size_t i = 0; i < models.size(); ++i)
    tables.push_back(tabulated_model(*models[i], media, parameters[i], radii));
  o.json ? print_profiles_json(tables) : print_profiles_csv(tables, o.all);
}

}  // namespace

void add_profile_command(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  CLI::App* profile = app.add_subcommand("profile", "Diffuse reflectance profiles R_d(r) of models and a material");
  profile->add_option("--model", o->models, "Profile; several to compare")->capture_default_str();
  profile->add_option("--set", o->settings, "Parameter key=value, see `opaline profile list`")->take_all();
  profile->add_option("--material", o->medium.material, "Name from `opaline material list`: three channels");
  profile->add_option("--sigma-a", o->medium.sigma_a, "Absorption [1/mm]: one number, or three with commas")
      ->delimiter(',');
  profile->add_option("--sigma-s-prime", o->medium.sigma_s_prime, "Reduced scattering [1/mm], likewise")
      ->delimiter(',');
  profile->add_option("--eta", o->medium.eta, "Refraction index, inside / outside");
  profile->add_option("--g", o->medium.g,
                      "Mean scattering cosine; a profile depends on sigma_s' = (1 - g) sigma_s alone");
  profile->add_option("--layer", o->layers, "Instead of these: sigma_a,sigma_s_prime,eta,thickness_mm, from the top");
  profile->add_option("--r", o->radii, "Radii lo:hi:step [mm]")->capture_default_str();
  CLI::Option* json = profile->add_flag("--json", o->json, "JSON, with totals, cumulative and transmittance");
  profile->add_flag("--csv", o->csv, "CSV (the default)")->excludes(json);
  profile->add_flag("--all", o->all, "CSV: also the cumulative, and the transmittance where there is one");
  profile->footer(
      "Example: opaline profile --material wholemilk --r 0:20:0.1 --json\n"
      "Example: opaline profile --model multipole --model layered --layer 0.01,1,1.4,3 --layer 0.1,2,1.4,inf");
  CLI::App* list = profile->add_subcommand("list", "What there is: parameters, domain, citation");
  const auto list_json = std::make_shared<bool>(false);
  list->add_flag("--json", *list_json, "JSON instead of text");
  list->footer("Example: opaline profile list");
  list->callback([list_json] { list_profiles(*list_json); });
  profile->callback([o, list] {
    if (!list->parsed()) run(*o);
  });
}

}  // namespace opaline
