#include "render/cmd/choose.h"
#include "render/cmd/commands.h"
#include "render/cmd/render_arguments.h"
#include "render/cmd/render_stats.h"
#include "render/scene/json_object.h"
#include "render/scene/scene.h"
#include "render/stopwatch.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <stdexcept>

namespace opaline {
namespace {

struct Arguments {
  std::string scene, out, png, stats, exit_lobe = "normalised";
  std::vector<std::string> settings;
  RenderOptions render{.technique = "", .backend = {}, .gl = {}, .settings = {}, .shared = {}, .exit_lobe = {}};
  int threads = 0;
  ChoiceRequest choice;  ///< instead of a technique
};

void check(const Arguments& a) {
  if (a.scene.empty()) throw std::invalid_argument("SCENE: name the scene file to render");
  if (asks_for_choice(a.choice)) check_choice_request(a.choice, a.render);
  if (a.render.technique.empty() && !asks_for_choice(a.choice))
    throw std::invalid_argument(
        "--technique: name one; `opaline render --list` shows them. Or give --max-error or --budget");
  if (a.out.empty()) throw std::invalid_argument("--out: name the image to write, as image.exr");
  check_output_path(a.out, ".exr");
  check_output_path(a.png, ".png");
  check_output_path(a.stats, ".json");
  if (!asks_for_choice(a.choice)) check_render_options(a.render);
}

void warn_if_empty(const Image& image) {
  for (std::size_t p = 0; p < image.pixel_count(); ++p)
    if (image.data[p * 4 + 3] > 0) return;
  fmt::print(stderr, "opaline: warning: the camera sees no object; the image is empty\n");
}

void run(Arguments& a, const ShapeLibrary& shapes, const TechniqueChooser& chooser) {
  a.render.settings = parse_assignments(a.settings);
  a.render.exit_lobe = a.exit_lobe == "jensen" ? ExitLobe::jensen : ExitLobe::normalised;
  check(a);
  const auto limit = limit_threads(a.threads);
  ProgressLine progress;
  Stopwatch watch, whole;
  progress.show("load");
  const Scene scene = load_scene(a.scene, shapes);
  if (asks_for_choice(a.choice)) choose_technique(scene, a.choice, chooser, a.render);
  const double load = watch.lap();
  const RenderResult result = render_scene(scene, a.render, [&](const std::string& stage) { progress.show(stage); });
  warn_if_empty(result.image);
  for (const std::string& note : result.notes) fmt::print(stderr, "opaline: {}\n", note);
  write_exr(a.out, with_layers(result.image, result.layers), image_header(scene, a.render, result));
  if (!a.png.empty()) write_png(a.png, result.image, auto_exposure(result.image));
  if (!a.stats.empty())
    write_text_atomically(a.stats, render_stats(a.render, result, load, whole.lap()).dump(2) + "\n");
}

void print_list(std::int64_t) {
  fmt::print("{}", describe_techniques());
  throw CLI::Success();  // ends parsing before the missing SCENE is complained about
}

}  // namespace

void add_render_command(CLI::App& app, const ShapeLibrary& shapes, const TechniqueChooser& chooser) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* render = app.add_subcommand("render", "One image of a scene by one technique");
  render->add_option("SCENE", a->scene, "Scene file (JSON)");
  render->add_option("--technique", a->render.technique, "Rendering technique; --list shows all");
  render->add_option("--backend", a->render.backend, "cpu or gpu (default: the technique's first)");
  render->add_option("--gl", a->render.gl, "GL of the gpu backend: egl or osmesa (default: hardware, else software)");
  render->add_option("--set", a->settings, "Setting of the technique, key=value; may be repeated")
      ->allow_extra_args(false);
  render->add_option("--out", a->out,
                     "Image to write (.exr: linear R, G, B, A; a technique may add layers: variance.R, ...)");
  render->add_option("--png", a->png, "Also an 8-bit sRGB preview, exposed automatically");
  render->add_option("--stats", a->stats, "Also seconds, counters and memory, as JSON");
  render->add_option("--samples", a->render.shared.samples, "Surface cells over all objects")
      ->check(CLI::Range(1, 100'000'000))
      ->capture_default_str();
  render
      ->add_option("--light-samples", a->render.shared.irradiance.area_samples,
                   "Directions per cell towards disks and environments")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  render->add_option("--exit-lobe", a->exit_lobe, "normalised (energy as in transport) or jensen (as printed)")
      ->check(CLI::IsMember({"normalised", "jensen"}))
      ->capture_default_str();
  render
      ->add_option("--seed", a->render.shared.irradiance.seed,
                   "Of the light samples and of techniques that draw random numbers")
      ->capture_default_str();
  add_threads_option(*render, a->threads);
  render->add_flag("--list", print_list, "Show every technique with its settings")->trigger_on_parse();
  render->footer("Example: opaline render scene.json --technique hierarchical --out image.exr --png image.png");
  if (chooser) add_choice_options(*render, a->choice);
  render->callback([a, chooser, &shapes] { run(*a, shapes, chooser); });
}

}  // namespace opaline
