// Real two-dimensional Fourier transforms in single precision (FFTW), in place, for layers of one size.
//
// Forward: F[v][u] = sum_yx f[y][x] exp(-2 pi i (u x/width + v y/height)), u = 0 .. width/2. Backward is its inverse
// times width * height. Plans are made once per size in a process and shared by all threads; they are not measured
// but estimated, so that results are the same from run to run.
#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <vector>

namespace opaline {

/// The smallest number >= n of the form 2^a 3^b 5^c, even.
int good_fft_size(int n);

/// Equal images one after another, rows padded so that the spectrum fits in place of the image.
class LayerStack {
 public:
  LayerStack() = default;
  LayerStack(int width, int height, int layers);

  int width() const { return width_; }
  int height() const { return height_; }
  int layers() const { return layers_; }
  /// Floats from a row to the next.
  std::size_t stride() const { return 2 * columns(); }
  /// Complex numbers of a row of the spectrum: width / 2 + 1.
  std::size_t columns() const { return static_cast<std::size_t>(width_ / 2 + 1); }
  float* row(int layer, int y) { return data_.get() + offset(layer, y); }
  const float* row(int layer, int y) const { return data_.get() + offset(layer, y); }

  /// Rows from `rows` on are 0 (forward) or not needed (backward): their transforms along x are left out.
  void forward(int layer, int rows);
  void backward(int layer, int rows);

 private:
  struct Free {
    void operator()(float* data) const;
  };
  std::size_t offset(int layer, int y) const {
    return (static_cast<std::size_t>(layer) * static_cast<std::size_t>(height_) + static_cast<std::size_t>(y)) *
           stride();
  }
  int width_ = 0, height_ = 0, layers_ = 0;
  std::unique_ptr<float[], Free> data_;
};

}  // namespace opaline
