// The sums over layers in the frequency domain: out_l(k) = sum_j K(k; |z_l - z_j|) in_j(k), for pairs of layers.
//
// Every layer is transformed once and every result once: 2n transforms for n layers, not n^2. Kernels need none: their
// spectra are tabulated over |k|, one row per distance, and serve both halves of the plane.
#pragma once

#include "render/layered/fft.h"
#include "render/layered/kernel_spectrum.h"
#include "render/layered/layers.h"

#include <cstdint>
#include <vector>

namespace opaline {

/// Along an axis of `size` nodes: frequencies [1/mm] in the order of the transform, and what each is multiplied with.
struct GridAxis {
  std::vector<float> k, factor;
};

/// factor = sinc(k step / 2)^power: 1 is a box of the step's width, -2 undoes linear interpolation between nodes.
GridAxis grid_axis(int size, double step, int power);

/// One product: layer `in` of stack `source` with kernel `add` of the table, less kernel `subtract` (-1: none).
struct LayerProduct {
  int source, in, add, subtract = -1;
};

/// What one output layer is the sum of.
struct OutputLayer {
  int layer;
  std::vector<LayerProduct> products;
};

/// Fills the spectra of output layer i with `outputs[i]`. The axes are those of the stacks; `scale` multiplies all.
void sum_layers(const std::vector<LayerStack>& sources, const KernelTable& table, const GridAxis& x, const GridAxis& y,
                float scale, const std::vector<OutputLayer>& outputs, LayerStack& out);

}  // namespace opaline
