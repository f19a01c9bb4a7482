// One image of a scene from beginning to end: the shared parts, prepare, render, shade. Behind
// `opaline render` and the synthetic datasets, so that both make the same pixels.
#pragma once

#include "render/techniques/technique.h"

#include <functional>
#include <map>
#include <string>

namespace opaline {

struct RenderOptions {
  std::string technique = "hierarchical";
  std::string backend;                          ///< empty: the technique's first
  std::string gl;                               ///< which GL the gpu backend uses: "egl", "osmesa", or empty: any
  std::map<std::string, std::string> settings;  ///< of the technique; what is left out has its default
  SharedSettings shared;
  ExitLobe exit_lobe = ExitLobe::normalised;
};

/// Wall-clock seconds of each stage. gbuffer contains building the ray-tracing structure.
struct RenderSeconds {
  double gbuffer = 0, irradiance = 0, prepare = 0, render = 0;
};

struct RenderResult {
  Image image;                          ///< R, G, B, A as `shade` makes it
  std::map<std::string, Image> layers;  ///< what else the technique knows per pixel: "variance", "bound"
  std::string backend;                  ///< the one used
  std::string device;                   ///< of the gpu backend: its renderer; empty for the processor
  std::map<std::string, std::string> settings;
  std::map<std::string, double> estimates;  ///< of the whole picture (technique.h)
  Counters counters;
  std::vector<std::string> notes;  ///< what the technique picked by itself
  RenderSeconds seconds;
};

/// Called with the name of each stage before it starts: "irradiance", "prepare", "render".
using StageObserver = std::function<void(const std::string& stage)>;

/// Throws InputError for an unknown technique, setting or value, or a backend the technique lacks,
/// naming the valid ones. Needs no scene: call it before the work of loading one.
void check_render_options(const RenderOptions& options);

/// Throws InputError as check_render_options, and when the technique cannot render the scene; MachineError
/// when the gpu backend is asked for and there is no GL. Without it no GL context is made.
RenderResult render_scene(const Scene& scene, const RenderOptions& options, const StageObserver& observer = {});

/// The header of the image file, as attributes: opaline:technique, backend, settings (JSON), scene
/// (its path), camera (JSON, mm), exit_lobe, samples, light_samples, seed and version.
std::map<std::string, std::string> image_header(const Scene& scene, const RenderOptions& options,
                                                const RenderResult& result);

/// "normalised" or "jensen".
std::string exit_lobe_name(ExitLobe lobe);

/// Version of Opaline, "major.minor.patch".
std::string version();

}  // namespace opaline
