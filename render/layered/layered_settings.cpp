#include "render/layered/layered_settings.h"

#include "render/techniques/gather_technique.h"

namespace opaline {

std::vector<SettingSpec> layered_setting_specs() {
  return {
      profile_setting(),
      {"mode", "auto", "auto: layers, threshold and resolution are picked from wanted_error", {"auto", "given"}},
      {"wanted_error", "0.02", "mode=auto: relative RMS error", {}, 1e-3, 0.5},
      {"layers", "8", "mode=given: planes between the nearest and the farthest surface", {}, 1, 256, true},
      {"placement", "uniform", "of the layers: equally far apart, or where surface is", {"uniform", "surface"}},
      {"splat",
       "linear",
       "of flux onto the two nearest layers: by depth, or half to each (the paper)",
       {"linear", "half"}},
      {"near",
       "surface",
       "what is nearer than the layers' gaps: averaged along the surface, or between layers as all else (the paper)",
       {"surface", "layers"}},
      {"near_gaps", "1.5", "near=surface: how far that goes, in largest gaps", {}, 1, 10},
      {"threshold",
       "1e-3",
       "mode=given: pairs of layers with R(distance) below this part of R(0) are left out",
       {},
       0,
       1},
      {"resolution",
       "auto",
       "mode=given: nodes of the layers per pixel of the film, in percent; auto: from the profile's width",
       {"auto", "25", "50", "100", "200", "400"}},
      {"kernel",
       "compensated",
       "interpolation between nodes is undone, or the kernel is integrated over a box of the nodes' distance",
       {"compensated", "pixel"}},
      {"dark_layers", "skip", "layers without light", {"skip", "keep"}},
      {"unseen_layers", "skip", "layers that no visible point needs", {"skip", "keep"}},
      {"rectangle", "object", "what the layers cover", {"object", "film"}},
      {"equal_channels", "once", "channels with equal coefficients", {"once", "each"}}};
}

LayeredSettings read_layered_settings(const Settings& settings) {
  LayeredSettings s;
  s.profile = settings.word("profile");
  s.automatic = settings.word("mode") == "auto";
  s.wanted_error = settings.number("wanted_error");
  s.layers = static_cast<int>(settings.number("layers"));
  s.by_surface = settings.word("placement") == "surface";
  s.half = settings.word("splat") == "half";
  s.near_surface = settings.word("near") == "surface";
  s.near_gaps = settings.number("near_gaps");
  s.threshold = settings.number("threshold");
  s.nodes_per_pixel = settings.word("resolution") == "auto" ? 0 : settings.number("resolution") / 100;
  s.pixel_kernel = settings.word("kernel") == "pixel";
  s.skip_dark = settings.word("dark_layers") == "skip";
  s.skip_unseen = settings.word("unseen_layers") == "skip";
  s.skip_outside = settings.word("rectangle") == "object";
  s.equal_once = settings.word("equal_channels") == "once";
  return s;
}

}  // namespace opaline
