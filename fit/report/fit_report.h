// A fit on one page: an HTML fragment that stands beside the pictures of write_fit and names them.
#pragma once

#include "fit/fit_job.h"

#include <string>

namespace opaline {

/// Target, refit and signed difference; the residual's histogram against the noise; the recovered profile with its 95 %
/// band; the table of parameters with intervals; correlations; convergence of every start; the models compared, the
/// repetitions and the advice where they were asked for. One <section>, no script, no outside resource but the PNGs.
std::string fit_report_html(const FitReport& report);

}  // namespace opaline
