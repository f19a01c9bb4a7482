#include "render/layered/splat.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace opaline {
namespace {

constexpr int band_rows = 16;

/// A cell on the grid: corners in nodes, depth in mm.
struct GridCell {
  glm::vec3 a, b, c;
  std::uint32_t cell;
  int pieces;  ///< along an edge
  bool front;
  float mass[4];  ///< of a piece: flux per channel, and area
  int first_row, last_row;
};

float extent(float a, float b, float c) { return std::max({a, b, c}) - std::min({a, b, c}); }

class Splat {
 public:
  Splat(const SurfaceCells& cells, const IrradianceField& field, const ParallelFrame& frame, const FrameGrid& grid,
        const Layers& layers, const SplatSettings& settings, LayerSources& out)
      : field_(field), frame_(frame), grid_(grid), layers_(layers), settings_(settings), out_(out) {
    const double gap = layers.count() > 1 ? layers.distance(layers.separations() - 1) / (layers.count() - 1) : HUGE_VAL;
    piece_depth_ = static_cast<float>(0.5 * gap);
    bands_.resize(static_cast<std::size_t>(grid.height / band_rows + 1));
    for (std::size_t i = 0; i < cells.size(); ++i) sort_in(cells[i], static_cast<std::uint32_t>(i));
    out.cells = cells.size();
  }

  /// Bands of rows are independent of each other: the sums don't depend on the number of threads.
  void run() {
    std::atomic<std::size_t> pieces = 0;
    tbb::parallel_for(std::size_t{0}, bands_.size(), [&](std::size_t band) {
      for (LayerStack& stack : out_.stacks) clear(stack, static_cast<int>(band));
      std::size_t count = 0;
      for (const std::uint32_t i : bands_[band]) count += splat(cells_[i], static_cast<int>(band) * band_rows);
      pieces += count;
    });
    out_.pieces = pieces;
  }

 private:
  glm::vec3 on_grid(const glm::vec3& world) const {
    const glm::dvec3 p = frame_.point(world);
    return glm::vec3(grid_.x(p.x), grid_.y(p.y), p.z);
  }

  void sort_in(const SurfaceCell& cell, std::uint32_t index) {
    GridCell g{on_grid(cell.a), on_grid(cell.b), on_grid(cell.c), index, 1, false, {}, 0, 0};
    const float width = extent(g.a.x, g.b.x, g.c.x), height = extent(g.a.y, g.b.y, g.c.y);
    const float pieces =
        std::max({width / settings_.piece, height / settings_.piece, extent(g.a.z, g.b.z, g.c.z) / piece_depth_});
    g.pieces = std::clamp(static_cast<int>(std::ceil(pieces)), 1, 512);
    // y is down: counter-clockwise from outside is clockwise here, seen from the viewer.
    const glm::vec3 ab = g.b - g.a, ac = g.c - g.a;
    g.front = ab.x * ac.y - ab.y * ac.x < 0;
    const float lo = std::min({g.a.y, g.b.y, g.c.y}), hi = std::max({g.a.y, g.b.y, g.c.y});
    if (!set_masses(g, cell_area(cell)) || !inside(g, lo, hi)) return;
    g.first_row = std::clamp(static_cast<int>(std::floor(lo)), 0, grid_.height - 1);
    g.last_row = std::clamp(static_cast<int>(std::floor(hi)) + 1, 0, grid_.height - 1);
    for (int band = g.first_row / band_rows; band <= g.last_row / band_rows; ++band)
      bands_[static_cast<std::size_t>(band)].push_back(static_cast<std::uint32_t>(cells_.size()));
    cells_.push_back(g);
  }

  /// False if there is nothing to distribute.
  bool set_masses(GridCell& g, float area) {
    const auto channels = static_cast<std::size_t>(field_.channels);
    const float share = area / static_cast<float>(g.pieces * g.pieces);
    float sum = 0;
    for (std::size_t c = 0; c < channels; ++c)
      sum += g.mass[c] = share * field_.values[g.cell * static_cast<std::size_t>(field_.width()) + c];
    g.mass[3] = share;
    out_.dark_cells += !(sum > 0);
    return sum > 0 || (settings_.facing && g.front);
  }

  bool inside(const GridCell& g, float lo, float hi) {
    const float left = std::min({g.a.x, g.b.x, g.c.x}), right = std::max({g.a.x, g.b.x, g.c.x});
    const bool met =
        hi > -1 && lo < static_cast<float>(grid_.height) && right > -1 && left < static_cast<float>(grid_.width);
    out_.cells_outside += !met;
    return met;
  }

  void clear(LayerStack& stack, int band) const {
    // The last band has all rows to the end of the stack.
    const int first = band * band_rows;
    const int last = static_cast<std::size_t>(band) + 1 == bands_.size() ? stack.height() : first + band_rows;
    for (int layer = 0; layer < stack.layers(); ++layer)
      std::fill(stack.row(layer, first),
                stack.row(layer, first) + static_cast<std::size_t>(last - first) * stack.stride(), 0.0f);
  }

  std::size_t splat(const GridCell& g, int first_row) {
    const float step = 1.0f / static_cast<float>(g.pieces);
    const auto piece = [&](float i, float j) {
      add(g, g.a + (i * step) * (g.b - g.a) + (j * step) * (g.c - g.a), first_row);
    };
    constexpr float third = 1.0f / 3.0f;
    for (int i = 0; i < g.pieces; ++i)
      for (int j = 0; i + j < g.pieces; ++j) {
        piece(static_cast<float>(i) + third, static_cast<float>(j) + third);
        if (i + j + 1 < g.pieces) piece(static_cast<float>(i) + 2 * third, static_cast<float>(j) + 2 * third);
      }
    return static_cast<std::size_t>(g.pieces) * static_cast<std::size_t>(g.pieces);
  }

  void add(const GridCell& g, const glm::vec3& at, int first_row) {
    const float fx = std::floor(at.x), fy = std::floor(at.y);
    const int x = static_cast<int>(fx), y = static_cast<int>(fy);
    if (x < -1 || x >= grid_.width || y < -1 || y >= grid_.height) return;
    const Layers::Place z = layers_.place(static_cast<double>(at.z));
    const float wz = settings_.half && layers_.count() > 1 ? 0.5f : z.share, wx = at.x - fx, wy = at.y - fy;
    for (int k = 0; k < 2; ++k) {
      const float in_z = k ? wz : 1 - wz;
      if (in_z == 0) continue;
      for (int j = 0; j < 2; ++j) {
        const int row = y + j;
        if (row < std::max(first_row, 0) || row >= std::min(first_row + band_rows, grid_.height)) continue;
        add_row(g, z.lower + k, row, x, wx, in_z * (j ? wy : 1 - wy));
      }
    }
  }

  void add_row(const GridCell& g, int layer, int row, int x, float wx, float weight) {
    const int channels = field_.channels, first = settings_.facing && !g.front ? channels : 0;
    const auto put = [&](int stack, float mass) {
      float* out = out_.stacks[static_cast<std::size_t>(stack)].row(layer, row);
      if (x >= 0) out[x] += mass * weight * (1 - wx);
      if (x + 1 < grid_.width) out[x + 1] += mass * weight * wx;
    };
    for (int c = 0; c < channels; ++c) put(first + c, g.mass[c]);
    if (settings_.facing && g.front) put(2 * channels, g.mass[3]);
  }

  const IrradianceField& field_;
  const ParallelFrame& frame_;
  const FrameGrid& grid_;
  const Layers& layers_;
  const SplatSettings& settings_;
  LayerSources& out_;
  float piece_depth_;
  std::vector<GridCell> cells_;
  std::vector<std::vector<std::uint32_t>> bands_;
};

std::uint8_t anything(const LayerStack& stack, int layer, const FrameGrid& grid) {
  for (int y = 0; y < grid.height; ++y) {
    const float* row = stack.row(layer, y);
    if (std::any_of(row, row + grid.width, [](float v) { return v != 0; })) return 1;
  }
  return 0;
}

}  // namespace

LayerSources splat_cells(const SurfaceCells& cells, const IrradianceField& field, const ParallelFrame& frame,
                         const FrameGrid& grid, int width, int height, const Layers& layers,
                         const SplatSettings& settings) {
  LayerSources sources;
  const int stacks = settings.facing ? 2 * field.channels + 1 : field.channels;
  for (int s = 0; s < stacks; ++s) sources.stacks.emplace_back(width, height, layers.count());
  Splat splat(cells, field, frame, grid, layers, settings, sources);
  splat.run();
  for (const LayerStack& stack : sources.stacks) {
    auto& lit = sources.lit.emplace_back(static_cast<std::size_t>(layers.count()));
    tbb::parallel_for(0, layers.count(), [&](int l) { lit[static_cast<std::size_t>(l)] = anything(stack, l, grid); });
  }
  return sources;
}

}  // namespace opaline
