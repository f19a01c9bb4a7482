#include "datasets_synthetic/dataset.h"
#include "datasets_synthetic/cmd/commands.h"
#include "datasets_synthetic/layered/layered_datasets.h"
#include "render/cmd/render_arguments.h"

#include <fmt/format.h>

#include <memory>
#include <optional>

namespace opaline {
namespace {

using Json = nlohmann::ordered_json;

void list_recipes(bool as_json) {
  Json rows = Json::array();
  for (const Recipe& r : shipped_recipes()) {
    rows.push_back({{"name", r.name},
                    {"summary", r.summary},
                    {"film", r.scene.at("film")},
                    {"material", r.material},
                    {"noise_relative", r.noise_relative},
                    {"seed", r.seed},
                    {"starts", r.starts},
                    {"samples", r.samples},
                    {"technique", r.technique}});
    if (!as_json) fmt::print("{:<20} {}\n", r.name, r.summary);
  }
  for (const LayeredDataset& d : layered_datasets()) {
    rows.push_back({{"name", d.name}, {"summary", d.summary}, {"layered", true}});
    if (!as_json) fmt::print("{:<20} {} (layers: scene and depths, nothing to fit)\n", d.name, d.summary);
  }
  if (as_json) fmt::print("{}\n", rows.dump(2));
}

struct Arguments {
  std::string recipe, out;
  std::optional<int> size;
  std::optional<double> noise;
  std::optional<std::uint64_t> seed;
  std::optional<std::size_t> samples;
  int threads = 0;
};

void make(const Arguments& a, const ShapeLibrary& shapes) {
  if (const LayeredDataset* layered = find_layered_dataset(a.recipe)) return write_layered_dataset(*layered, a.out);
  Recipe recipe = find_recipe(a.recipe);
  if (a.size) recipe.scene["film"] = {{"width", *a.size}, {"height", *a.size}};
  recipe.noise_relative = a.noise.value_or(recipe.noise_relative);
  recipe.seed = a.seed.value_or(recipe.seed);
  recipe.samples = a.samples.value_or(recipe.samples);
  const auto limit = limit_threads(a.threads);
  ProgressLine progress;
  make_dataset(recipe, a.out, shapes, [&](const std::string& stage) { progress.show(stage); });
}

}  // namespace

void add_dataset_command(CLI::App& app, const ShapeLibrary& shapes) {
  CLI::App* dataset = app.add_subcommand("dataset", "Synthetic datasets with a certified answer: list them, make one");
  dataset->require_subcommand(1);
  dataset->footer("Example: opaline dataset make bust_skin1 --out bust");

  const auto as_json = std::make_shared<bool>(false);
  CLI::App* list = dataset->add_subcommand("list", "The built-in recipes");
  list->add_flag("--json", *as_json, "JSON instead of a table");
  list->footer("Example: opaline dataset list --json");
  list->callback([as_json] { list_recipes(*as_json); });

  const auto a = std::make_shared<Arguments>();
  CLI::App* command = dataset->add_subcommand("make", "Render a recipe: scene, truth, clean and noisy image");
  command->add_option("RECIPE", a->recipe, "Built-in recipe, or a file that ends in .json")->required();
  command->add_option("--out", a->out, "Folder to write; made if it is missing")->required();
  command->add_option("--size", a->size, "Width and height of the film [pixels]")->check(CLI::Range(1, 16384));
  command->add_option("--noise", a->noise, "Standard deviation relative to each channel's RMS")
      ->check(CLI::Range(0.0, 10.0));
  command->add_option("--seed", a->seed, "Of the noise and the light samples")->check(CLI::Range(0, 2147483647));
  command->add_option("--samples", a->samples, "Surface cells over all objects")->check(CLI::Range(1, 100'000'000));
  add_threads_option(*command, a->threads);
  command->footer("Example: opaline dataset make sphere_wholemilk --out milk --size 64 --noise 0.02");
  command->callback([a, &shapes] { make(*a, shapes); });
}

}  // namespace opaline
