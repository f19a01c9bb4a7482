#include "render/layered/fft.h"

#include "render/input_error.h"

#include <fftw3.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <tuple>

namespace opaline {
namespace {

fftwf_complex* complex_of(float* data) { return reinterpret_cast<fftwf_complex*>(data); }

/// The parts of a transform: along x for all the rows of an image that matter, along y for all columns.
struct Plans {
  fftwf_plan rows_forward, rows_backward, columns_forward, columns_backward;
};

Plans make_plans(int width, int height, int rows) {
  const int columns = width / 2 + 1;
  float* scratch = fftwf_alloc_real(static_cast<std::size_t>(2 * columns) * static_cast<std::size_t>(height));
  fftwf_complex* spectrum = complex_of(scratch);
  const int flags = FFTW_ESTIMATE;
  const auto along_y = [&](int sign) {
    return fftwf_plan_many_dft(1, &height, columns, spectrum, nullptr, columns, 1, spectrum, nullptr, columns, 1, sign,
                               flags);
  };
  const Plans plans{
      fftwf_plan_many_dft_r2c(1, &width, rows, scratch, nullptr, 1, 2 * columns, spectrum, nullptr, 1, columns, flags),
      fftwf_plan_many_dft_c2r(1, &width, rows, spectrum, nullptr, 1, columns, scratch, nullptr, 1, 2 * columns, flags),
      along_y(FFTW_FORWARD), along_y(FFTW_BACKWARD)};
  fftwf_free(scratch);
  return plans;
}

/// Planning is not thread-safe, using a plan is.
const Plans& plans_for(int width, int height, int rows) {
  static std::mutex mutex;
  static std::map<std::tuple<int, int, int>, Plans> cache;
  const std::scoped_lock lock(mutex);
  const auto key = std::tuple(width, height, rows);
  const auto it = cache.find(key);
  return it != cache.end() ? it->second : cache.emplace(key, make_plans(width, height, rows)).first->second;
}

}  // namespace

int good_fft_size(int n) {
  for (n = std::max(2, n + n % 2);; n += 2) {
    int rest = n;
    for (const int p : {2, 3, 5})
      while (rest % p == 0) rest /= p;
    if (rest == 1) return n;
  }
}

void LayerStack::Free::operator()(float* data) const { fftwf_free(data); }

LayerStack::LayerStack(int width, int height, int layers) : width_(width), height_(height), layers_(layers) {
  const std::size_t count = offset(layers, 0);
  data_.reset(fftwf_alloc_real(std::max<std::size_t>(count, 1)));
  if (!data_) throw MachineError("not enough memory for the layers");
}

void LayerStack::forward(int layer, int rows) {
  const Plans& plans = plans_for(width_, height_, rows);
  fftwf_execute_dft_r2c(plans.rows_forward, row(layer, 0), complex_of(row(layer, 0)));
  fftwf_execute_dft(plans.columns_forward, complex_of(row(layer, 0)), complex_of(row(layer, 0)));
}

void LayerStack::backward(int layer, int rows) {
  const Plans& plans = plans_for(width_, height_, rows);
  fftwf_execute_dft(plans.columns_backward, complex_of(row(layer, 0)), complex_of(row(layer, 0)));
  fftwf_execute_dft_c2r(plans.rows_backward, complex_of(row(layer, 0)), row(layer, 0));
}

}  // namespace opaline
