#include "fit/reference_noise.h"

#include <algorithm>
#include <cmath>

namespace opaline {

NoiseModel sum_of_noise(const NoiseModel& a, const NoiseModel& b, double scale) {
  NoiseModel sum = a;
  if (!a.known || !b.known) return sum;  // the residual shows both
  for (std::size_t c = 0; c < 3; ++c) {
    sum.read_sd[c] = std::hypot(a.read_sd[c], scale * b.read_sd[c]);
    sum.shot[c] = a.shot[c] + scale * b.shot[c];
    sum.relative[c] = std::hypot(a.relative[c], b.relative[c]);
  }
  sum.correlation_known = a.correlation_known && b.correlation_known;
  sum.rough = a.rough || b.rough;
  return sum;
}

Eigen::MatrixXd neighbours_mean(const Eigen::MatrixXd& rows, const TransportOperator& op) {
  constexpr int reach = 2;
  std::vector<Eigen::Index> row_of(static_cast<std::size_t>(op.width) * static_cast<std::size_t>(op.height), -1);
  for (std::size_t p = 0; p < op.rows(); ++p) row_of[op.pixels[p]] = static_cast<Eigen::Index>(p);
  Eigen::MatrixXd out = rows;
  for (Eigen::Index p = 0; p < rows.rows(); ++p) {
    const auto pixel = static_cast<int>(op.pixels[static_cast<std::size_t>(p)]);
    const int x = pixel % op.width, y = pixel / op.width;
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(rows.cols());
    int count = 0;
    for (int v = std::max(y - reach, 0); v <= std::min(y + reach, op.height - 1); ++v)
      for (int u = std::max(x - reach, 0); u <= std::min(x + reach, op.width - 1); ++u) {
        const Eigen::Index other = row_of[static_cast<std::size_t>(v * op.width + u)];
        if (other >= 0 && other != p) sum += rows.row(other), ++count;
      }
    if (count > 0) out.row(p) = sum / count;
  }
  return out;
}

}  // namespace opaline
