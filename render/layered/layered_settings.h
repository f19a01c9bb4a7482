// The settings of layered_convolution, as declared and as read. See render/techniques/layered_convolution.md.
#pragma once

#include "render/techniques/settings.h"

namespace opaline {

struct LayeredSettings {
  std::string profile;
  bool automatic = true;       ///< mode=auto: layers, threshold and resolution are picked from wanted_error
  double wanted_error = 0.02;  ///< relative RMS
  int layers = 8;
  bool by_surface = false;   ///< placement=surface
  bool half = false;         ///< splat=half
  bool near_surface = true;  ///< near=surface
  double near_gaps = 1.5;
  double threshold = 1e-3;
  double nodes_per_pixel = 0;  ///< 0: resolution=auto
  bool pixel_kernel = false;   ///< kernel=pixel
  bool skip_dark = true, skip_unseen = true, skip_outside = true, equal_once = true;
};

std::vector<SettingSpec> layered_setting_specs();
LayeredSettings read_layered_settings(const Settings& settings);

}  // namespace opaline
