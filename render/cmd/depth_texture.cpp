// `opaline depth-texture`: depth textures of a surface from the meshes of its layers.
#include "render/subsurface/depth_texture.h"
#include "render/cmd/commands.h"
#include "render/cmd/render_arguments.h"
#include "render/input_error.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>

namespace opaline {
namespace {

struct Arguments {
  std::string surface, out;
  std::vector<std::string> layers;
  int width = 1024, height = 1024;
  double largest_depth = 5;
};

Mesh load(const std::string& path) {
  Mesh mesh = load_mesh(path);
  validate_mesh(mesh, ZeroAreaTriangles::drop, path, "");
  return mesh;
}

/// "depths.exr"; of several textures the second is "depths_2.exr".
std::string name_of(const std::string& out, std::size_t texture) {
  return texture == 0 ? out : fmt::format("{}_{}.exr", out.substr(0, out.size() - 4), texture + 1);
}

void run(const Arguments& a) {
  check_output_path(a.out, ".exr");
  const Mesh surface = load(a.surface);
  if (surface.uvs.empty()) throw InputError(a.surface, "", "has no texture coordinates to make a texture for");
  std::vector<Mesh> layers;
  for (const std::string& path : a.layers) layers.push_back(load(path));
  Counters counters;
  const std::vector<Image> images = make_depth_textures(surface, layers, a.width, a.height, a.largest_depth, counters);
  for (std::size_t i = 0; i < images.size(); ++i) write_exr(name_of(a.out, i), images[i]);
  fmt::print(stderr, "opaline: {} rays; {} texels off the surface, {} covered more than once\n", counters.done["rays"],
             counters.skipped["texels_off_surface"], counters.skipped["texels_covered_again"]);
}

}  // namespace

void add_depth_texture_command(CLI::App& app) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("depth-texture", "Depth textures of a layered material, from layers' meshes");
  command->add_option("SURFACE", a->surface, "Mesh with texture coordinates, in mm")->required();
  command->add_option("--layer", a->layers, "Mesh where a layer ends, from the outermost inwards; may be repeated")
      ->required()
      ->allow_extra_args(false);
  command->add_option("--out", a->out, "Image to write (.exr); every four layers another")->required();
  command->add_option("--width", a->width, "Texels")->check(CLI::Range(1, 16384))->capture_default_str();
  command->add_option("--height", a->height, "Texels")->check(CLI::Range(1, 16384))->capture_default_str();
  command->add_option("--largest-depth", a->largest_depth, "What is deeper, or not met, counts as this [mm]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->footer("Example: opaline depth-texture skin.obj --layer dermis.obj --layer flesh.obj --out depths.exr");
  command->callback([a] { run(*a); });
}

}  // namespace opaline
