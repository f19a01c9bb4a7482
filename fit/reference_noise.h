// A reference's own noise (defect_correction.h): what it adds to that of the data, and what it must not do to the
// weights.
#pragma once

#include "fit/whitening.h"

namespace opaline {

/// The noise of a + scale * b, two independent pictures.
NoiseModel sum_of_noise(const NoiseModel& a, const NoiseModel& b, double scale);

/// Every pixel's mean of the fitted pixels around it in a window of 5 x 5, itself left out: as bright, but with nothing
/// of the pixel's own noise in it, which would give its darker values the larger weights. rows: of the operator's
/// pixels x channels; a pixel without neighbours keeps its value.
Eigen::MatrixXd neighbours_mean(const Eigen::MatrixXd& rows, const TransportOperator& op);

}  // namespace opaline
