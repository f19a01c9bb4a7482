#include "model/profiles/profile.h"
#include "model/cmd/commands.h"
#include "model/cmd/medium_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <memory>

namespace opaline {
namespace {

struct Options {
  std::string model = "standard_dipole", radii = "0:20:0.1";
  MediumOptions medium;
  bool json = false, csv = false;
};

struct Channel {
  std::vector<double> r, R;
  double total;
};

const ProfileInfo& chosen_model(const std::string& name) {
  const ProfileInfo* info = find_profile(name);
  std::vector<std::string> names;
  for (const ProfileInfo& row : profiles()) names.push_back(row.name);
  require_argument(info != nullptr,
                   fmt::format("--model: no profile \"{}\"; choose from {}", name, fmt::join(names, ", ")));
  return *info;
}

Channel tabulate(const ProfileInfo& info, const Medium<double>& medium, const std::vector<double>& radii) {
  const auto profile = info.make(medium);
  Channel channel{radii, {}, profile->total()};
  for (const double r : radii) channel.R.push_back(profile->evaluate(r));
  return channel;
}

void print_json(const std::string& model, const std::vector<Channel>& channels) {
  nlohmann::ordered_json json = {{"model", model}, {"units", {{"r", "mm"}, {"R", "1/mm^2"}, {"total", "1"}}}};
  json["channels"] = nlohmann::ordered_json::array();
  for (const Channel& c : channels) json["channels"].push_back({{"r", c.r}, {"R", c.R}, {"total", c.total}});
  fmt::print("{}\n", json.dump());
}

void print_csv(const std::vector<Channel>& channels) {
  const bool rgb = channels.size() == 3;
  fmt::print("r_mm,{}\n", rgb ? "R_red_per_mm2,R_green_per_mm2,R_blue_per_mm2" : "R_per_mm2");
  for (std::size_t i = 0; i < channels[0].r.size(); ++i) {
    fmt::print("{}", channels[0].r[i]);
    for (const Channel& c : channels) fmt::print(",{}", c.R[i]);
    fmt::print("\n");
  }
}

void run(const Options& o) {
  const ProfileInfo& info = chosen_model(o.model);
  const std::vector<double> radii = parse_radii(o.radii);
  std::vector<Channel> channels;
  for (const auto& medium : media_of(o.medium)) channels.push_back(tabulate(info, medium, radii));
  o.json ? print_json(info.name, channels) : print_csv(channels);
}

}  // namespace

void add_profile_command(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  CLI::App* profile = app.add_subcommand("profile", "Diffuse reflectance profile R_d(r) of a model and a material");
  profile->add_option("--model", o->model, "Profile")->capture_default_str();
  profile->add_option("--material", o->medium.material, "Name from `opaline material list`: three channels");
  profile->add_option("--sigma-a", o->medium.sigma_a, "Absorption [1/mm]: one number, or three with commas")
      ->delimiter(',');
  profile->add_option("--sigma-s-prime", o->medium.sigma_s_prime, "Reduced scattering [1/mm], likewise")
      ->delimiter(',');
  profile->add_option("--eta", o->medium.eta, "Refraction index, inside / outside");
  profile->add_option("--g", o->medium.g,
                      "Mean scattering cosine; a profile depends on sigma_s' = (1 - g) sigma_s alone");
  profile->add_option("--r", o->radii, "Radii lo:hi:step [mm]")->capture_default_str();
  CLI::Option* json = profile->add_flag("--json", o->json, "JSON, with each channel's total");
  profile->add_flag("--csv", o->csv, "CSV (the default)")->excludes(json);
  profile->footer("Example: opaline profile --material wholemilk --r 0:20:0.1 --json");
  profile->callback([o] { run(*o); });
}

}  // namespace opaline
