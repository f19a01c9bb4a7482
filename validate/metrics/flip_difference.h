// FLIP, the difference a viewer notices when two images alternate on a screen: Andersson, Nilsson, Akenine-Moller,
// Oskarsson, Astrom, Fairchild 2020, "FLIP: A Difference Evaluator for Alternating Images"; for high dynamic range the
// largest over a range of exposures: Andersson, Nilsson, Shirley, Akenine-Moller 2021, "Visualizing Errors in Rendered
// High Dynamic Range Images". Written from the papers and the published constants; the viewer is the published default,
// 0.7 m from a screen 0.7 m and 3840 pixels wide.
#pragma once

#include "validate/metrics/comparison.h"

namespace opaline {

/// Pixels per degree of visual angle of that viewer: 67.02.
extern const double flip_pixels_per_degree;

/// FLIP of linear R, G, B (or one grey) in [0, 1] per pixel of the image, in [0, 1]; values outside are clipped.
std::vector<double> ldr_flip(const Comparison& comparison);

/// The exposures [stops] of HDR-FLIP: those that put the brightest and the median luminance of the reference's compared
/// pixels at 0.85 of the tone-mapped range (ACES), and max(2, ceil(last - first)) in all. Both 0 for a black reference.
struct FlipExposures {
  double first = 0, last = 0;
  int count = 2;
};
FlipExposures flip_exposures(const Comparison& comparison);

/// HDR-FLIP per pixel of the image: the largest LDR-FLIP over the exposures, tone-mapped (ACES).
std::vector<double> hdr_flip(const Comparison& comparison);

/// Mean over the compared pixels.
double mean_over_compared(const Comparison& comparison, const std::vector<double>& map);

}  // namespace opaline
