// Float images as pictures a page can hold: shrunk, tonemapped or coloured, PNG, data URI.
#pragma once

#include "render/image.h"

#include <string>

namespace opaline {

/// Ends of the one scale of all false-colour pictures, relative to the RMS of the scene's reference; the colours are
/// spread over its logarithm. Smaller and larger values have the colours of the ends.
inline constexpr double false_colour_low = 1e-4, false_colour_high = 1;

/// The image with its longer side at most `max_side` pixels, each the mean of what it covers; the same if it fits.
Image shrunk(const Image& image, int max_side);

/// RMS of R, G, B over the pixels with A > 0 (all, without A).
double rms(const Image& image);

/// |image - reference| per pixel, RMS over R, G, B, divided by `scale`, as channels "Y" and "A" (the reference's alpha,
/// 0 or 1). Throws InputError when the sizes differ or one of them lacks R, G or B.
Image relative_error(const Image& image, const Image& reference, double scale);

/// RMS over R, G, B of an image of errors ("bound"), or of the root of one of squared errors ("variance"), divided by
/// `scale`; channels as above.
Image relative_size(const Image& image, const Image& reference, double scale, bool squared);

/// PNG of R, G, B as sRGB, value * exposure clipped to [0, 1], NaN black.
std::string tonemapped_png(const Image& image, double exposure);

/// PNG of Y on the false-colour scale; transparent where A is 0, magenta where Y is not finite.
std::string false_colour_png(const Image& relative);

/// CSS gradient of that scale, low to high.
std::string false_colour_gradient();

/// "data:image/png;base64,...".
std::string data_uri(const std::string& png);

}  // namespace opaline
