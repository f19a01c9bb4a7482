// Does a residual look like noise? Noise of one pixel says nothing of the next; what a model cannot explain does.
#pragma once

#include "render/image.h"

namespace opaline {

/// Mean correlation of the difference (R, G, B, A; A > 0 where fitted) with its right and lower neighbours, over the
/// channels. Of independent noise 0 with a standard error of about 1/sqrt(number of pixels).
double neighbour_correlation(const Image& difference);

}  // namespace opaline
