#include "render/layered/layered_pass.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace opaline {
namespace {

void transform_sources(LayeredPass& pass) {
  const int stacks = static_cast<int>(pass.sources.stacks.size()), layers = pass.layers.count();
  tbb::parallel_for(0, stacks * layers, [&](int i) {
    const auto stack = static_cast<std::size_t>(i / layers);
    if (pass.sources.lit[stack][static_cast<std::size_t>(i % layers)])
      pass.sources.stacks[stack].forward(i % layers, pass.grid.height);
  });
}

/// One output at the visible points: linear between the four nodes and the two layers.
class Lookup {
 public:
  Lookup(const LayerStack& stack, const std::vector<OutputLayer>& outputs, int layers)
      : stack_(stack), index_(static_cast<std::size_t>(layers), -1) {
    for (std::size_t i = 0; i < outputs.size(); ++i)
      index_[static_cast<std::size_t>(outputs[i].layer)] = static_cast<int>(i);
  }

  float operator()(const LayerPoint& p) const {
    float value = 0;
    if (p.z.share < 1) value += (1 - p.z.share) * in_layer(p, p.z.lower);
    if (p.z.share > 0) value += p.z.share * in_layer(p, p.z.lower + 1);
    return value;
  }

 private:
  float in_layer(const LayerPoint& p, int layer) const {
    const int at = index_[static_cast<std::size_t>(layer)];
    if (at < 0) return 0;  // nothing lit is near enough
    const float fx = std::floor(p.x), fy = std::floor(p.y), wx = p.x - fx, wy = p.y - fy;
    const auto x = static_cast<std::size_t>(fx);
    const float *upper = stack_.row(at, static_cast<int>(fy)) + x, *lower = upper + stack_.stride();
    return (1 - wy) * ((1 - wx) * upper[0] + wx * upper[1]) + wy * ((1 - wx) * lower[0] + wx * lower[1]);
  }

  const LayerStack& stack_;
  std::vector<int> index_;
};

}  // namespace

std::vector<std::vector<float>> LayeredCpu::run(LayeredPass& pass) {
  transform_sources(pass);
  std::vector<std::vector<float>> values;
  for (const LayerLane& lane : pass.lanes) {
    const std::size_t outputs = lane.outputs.size(), points = pass.points.size();
    std::vector<float> at(outputs * points);
    for (std::size_t o = 0; o < outputs; ++o) {
      if (lane.outputs[o].empty()) continue;
      LayerStack stack(pass.width, pass.height, static_cast<int>(lane.outputs[o].size()));
      sum_layers(pass.sources.stacks, lane.table, lane.x_axis, lane.y_axis, pass.scale, lane.outputs[o], stack);
      tbb::parallel_for(0, stack.layers(), [&](int l) { stack.backward(l, pass.grid.height); });
      const Lookup lookup(stack, lane.outputs[o], pass.layers.count());
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points, 4096), [&](const auto& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) at[i * outputs + o] = lookup(pass.points[i]);
      });
    }
    std::vector<float>& value = values.emplace_back(points);
    for (std::size_t i = 0; i < points; ++i) value[i] = lane_value(lane, &at[i * outputs]);
  }
  return values;
}

}  // namespace opaline
