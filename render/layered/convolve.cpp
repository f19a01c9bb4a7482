#include "render/layered/convolve.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <set>
#include <utility>

namespace opaline {
namespace {

/// A kernel of the sums: an entry of the table, or the difference of two.
using Kernel = std::pair<int, int>;

struct IndexedProduct {
  int source, in;
  std::size_t kernel;
};

/// Kernel values along one row of frequencies, each twice: for the real and the imaginary part.
struct KernelRows {
  std::vector<KernelTable::Place> places;
  std::vector<float> factors, values;
};

class LayerSum {
 public:
  LayerSum(const std::vector<LayerStack>& sources, const KernelTable& table, const GridAxis& x, const GridAxis& y,
           float scale, const std::vector<OutputLayer>& outputs, LayerStack& out)
      : sources_(sources), table_(table), x_(x), y_(y), scale_(scale), out_(out), stride_(out.stride()) {
    std::set<Kernel> used;
    for (const OutputLayer& o : outputs)
      for (const LayerProduct& p : o.products) used.emplace(p.add, p.subtract);
    kernels_.assign(used.begin(), used.end());
    for (const OutputLayer& o : outputs) {
      auto& list = products_.emplace_back();
      for (const LayerProduct& p : o.products) {
        const auto at = std::lower_bound(kernels_.begin(), kernels_.end(), Kernel(p.add, p.subtract));
        list.push_back({p.source, p.in, static_cast<std::size_t>(at - kernels_.begin())});
      }
    }
  }

  /// Rows v and height - v have the same kernels.
  void run() {
    tbb::enumerable_thread_specific<KernelRows> rows;
    tbb::parallel_for(0, out_.height() / 2 + 1, [&](int v) {
      KernelRows& k = rows.local();
      prepare(k, v);
      sum(k, v);
      const int mirror = (out_.height() - v) % out_.height();
      if (mirror != v) sum(k, mirror);
    });
  }

 private:
  void prepare(KernelRows& k, int v) const {
    const std::size_t columns = out_.columns();
    k.places.resize(columns), k.factors.resize(columns), k.values.resize(kernels_.size() * stride_);
    const float ky = y_.k[static_cast<std::size_t>(v)], fy = scale_ * y_.factor[static_cast<std::size_t>(v)];
    for (std::size_t u = 0; u < columns; ++u) {
      k.places[u] = table_.place(x_.k[u] * x_.k[u] + ky * ky);
      k.factors[u] = fy * x_.factor[u];
    }
    for (std::size_t i = 0; i < kernels_.size(); ++i) {
      float* values = k.values.data() + i * stride_;
      const float* add = table_.values(kernels_[i].first);
      const float* subtract = kernels_[i].second < 0 ? nullptr : table_.values(kernels_[i].second);
      for (std::size_t u = 0; u < columns; ++u) {
        const auto [entry, share] = k.places[u];
        float value = add[entry] + share * (add[entry + 1] - add[entry]);
        if (subtract) value -= subtract[entry] + share * (subtract[entry + 1] - subtract[entry]);
        values[2 * u] = values[2 * u + 1] = k.factors[u] * value;
      }
    }
  }

  void sum(const KernelRows& k, int v) {
    for (std::size_t o = 0; o < products_.size(); ++o) {
      float* out = out_.row(static_cast<int>(o), v);
      std::fill(out, out + stride_, 0.0f);
      for (const IndexedProduct& p : products_[o]) {
        const float* in = sources_[static_cast<std::size_t>(p.source)].row(p.in, v);
        const float* kernel = k.values.data() + p.kernel * stride_;
        for (std::size_t i = 0; i < stride_; ++i) out[i] += kernel[i] * in[i];
      }
    }
  }

  const std::vector<LayerStack>& sources_;
  const KernelTable& table_;
  const GridAxis &x_, &y_;
  float scale_;
  LayerStack& out_;
  std::size_t stride_;
  std::vector<Kernel> kernels_;
  std::vector<std::vector<IndexedProduct>> products_;
};

}  // namespace

GridAxis grid_axis(int size, double step, int power) {
  GridAxis axis;
  for (int i = 0; i < size; ++i) {
    const double cycles = static_cast<double>(2 * i <= size ? i : i - size) / size, half = pi * cycles;
    axis.k.push_back(static_cast<float>(2 * pi * cycles / step));
    axis.factor.push_back(static_cast<float>(i == 0 ? 1 : std::pow(std::sin(half) / half, power)));
  }
  return axis;
}

void sum_layers(const std::vector<LayerStack>& sources, const KernelTable& table, const GridAxis& x, const GridAxis& y,
                float scale, const std::vector<OutputLayer>& outputs, LayerStack& out) {
  LayerSum(sources, table, x, y, scale, outputs, out).run();
}

}  // namespace opaline
