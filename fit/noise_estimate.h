// The noise of a picture from the picture: variance = read^2 + shot * signal per channel, fitted to medians over
// classes of equal brightness, so that edges and outliers don't make it.
#pragma once

#include "fit/noise_model.h"
#include "render/image.h"

#include <vector>

namespace opaline {

/// From two captures of the same: half the squared difference. The noise is that of ONE capture. Also gives the
/// correlation of the channels. usable: one value per pixel, > 0 counts; empty: all.
NoiseModel noise_from_repeat(const Image& a, const Image& b, const std::vector<float>& usable);

/// From one picture, where it is locally a plane: the second difference [1 -2 1; -2 4 -2; 1 -2 1] of 3 x 3 pixels has
/// variance 36 times the noise's (Immerkaer 1996). Detail finer than that is taken for noise; compressed or demosaicked
/// pictures have neighbours that share noise, and too little of it is found.
NoiseModel noise_from_flat(const Image& picture, const std::vector<float>& usable);

/// With all three terms, from a renderer's estimate per pixel, channels variance.R, variance.G, variance.B
/// (path_traced.md). Smooth in the signal on purpose: a pixel's own estimate errs with its value, and weights from it
/// would pull a fit to the dark side. The channels share paths and so noise, by an amount that differs over the
/// picture: taken for the same everywhere it would be cancelled where it is not there, so it has no part in the
/// weights, and the model is `rough`.
NoiseModel noise_from_layer(const Image& picture, const Image& layers, const std::vector<float>& usable);

/// "uniform", "shared" (by the channels, as much as the residual shows), or READ[,SHOT] in the picture's linear units.
/// Throws InputError.
NoiseModel parse_noise(const std::string& text);

}  // namespace opaline
