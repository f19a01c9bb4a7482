#include "render/transfer/encoded_transfer.h"

#include "model/check.h"
#include "render/transfer/harmonics.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>

namespace opaline {
namespace {

std::vector<KeyWeight> harmonic_weights(const std::vector<TransferLight>& lights, const TransferNodes& nodes,
                                        int order) {
  const auto coefficients = static_cast<std::uint32_t>(order * order);
  std::map<std::uint32_t, Rgb> sums;
  for (const TransferLight& light : lights) {
    const auto [level, above] = nodes.level_of(light.u);
    const std::vector<double> y = harmonics(order, light.direction);
    for (std::uint32_t step = 0; step < (above > 0 ? 2u : 1u); ++step)
      for (std::uint32_t i = 0; i < coefficients; ++i)
        sums[(static_cast<std::uint32_t>(level) + step) * coefficients + i] +=
            (step ? above : 1 - above) * y[i] * light.irradiance;
  }
  std::vector<KeyWeight> weights;
  for (const auto& [key, weight] : sums) weights.push_back({key, weight});
  return weights;
}

/// The reference points' own B, four floats a point.
std::vector<float> point_values(const VertexExitance& full, std::size_t count) {
  std::vector<float> values(4 * count, 0.0f);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t c = 0; c < 3; ++c) values[4 * i + c] = full.channel[c][i];
  return values;
}

/// One frame: all blocks of vertices.
struct Frame {
  const EncodedTransfer& transfer;
  const RowWeights& weights;
  VertexExitance& out;
  std::array<EqualChannel, 3> equal{};
  std::optional<CornerBlend> blend{};
  std::atomic<std::uint64_t> done = 0, dark = 0, negative = 0;

  /// The terms of a channel that are not dark in a block.
  std::vector<RowTerm> lit_terms(std::size_t c, std::size_t b) const {
    std::vector<RowTerm> terms;
    if (equal[c].channel != static_cast<int>(c)) return terms;
    for (const RowWeight& w : weights[c])
      if (transfer.rows.lit(w.row, b)) terms.push_back(transfer.rows.term(w.row, w.weight));
    return terms;
  }

  void work(std::size_t b) {
    const CodedRows& rows = transfer.rows;
    const std::size_t begin = b * CodedRows::block, count = std::min(CodedRows::block, rows.stride() - begin);
    alignas(64) float sum[3][CodedRows::block] = {};
    std::array<std::vector<RowTerm>, 4> terms;
    std::uint64_t used = 0, all = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      terms[c] = lit_terms(c, b);
      used += terms[c].size();
      if (equal[c].channel == static_cast<int>(c)) all += weights[c].size();
    }
    for (std::size_t c = 0; c < 3; ++c) add_rows(rows.storage(), terms[c], begin, count, sum[c], terms[c + 1]);
    if (blend) add_blend(*blend, begin, count, {sum[0], sum[1], sum[2]});
    std::uint64_t below = 0;
    for (std::size_t c = 0; c < 3; ++c)
      below += store_exitance(sum[equal[c].channel], equal[c].factor, count, out.channel[c].get() + begin);
    negative += below, done += used * count, dark += (all - used) * count;
  }
};

}  // namespace

double ReferencePoints::bytes_per_vertex() const {
  const double n = static_cast<double>(triangle_of.size());
  const double number = triangles.size() < 65536 ? 2 : 4, corner = points.size() < 65536 ? 2 : 4;
  return number + 2 * sizeof(short) + static_cast<double>(points.size()) * (full->bytes_per_vertex() + 4) / n +
         3 * corner * static_cast<double>(triangles.size()) / n;
}

double EncodedTransfer::bytes_per_vertex() const {
  return rows.bytes_per_vertex() + (references ? references->bytes_per_vertex() : 0);
}

std::vector<KeyWeight> EncodedTransfer::key_weights(const std::vector<TransferLight>& lights,
                                                    const TransferNodes& nodes) const {
  if (basis == TransferBasis::harmonics) return harmonic_weights(lights, nodes, order);
  return basis == TransferBasis::vectors ? vector_weights(lights, nodes) : node_weights(lights, nodes);
}

RowWeights EncodedTransfer::weights(const std::vector<TransferLight>& lights, const TransferNodes& nodes) const {
  RowWeights result;
  for (const KeyWeight& w : key_weights(lights, nodes)) {
    const auto found = std::lower_bound(keys.begin(), keys.end(), w.key);
    OPALINE_CHECK(found != keys.end() && *found == w.key);
    const auto first = static_cast<std::uint32_t>((found - keys.begin()) * tables);
    for (int c = 0; c < 3; ++c)
      result[static_cast<std::size_t>(c)].push_back(
          {first + static_cast<std::uint32_t>(table_of[c]), static_cast<float>(w.weight[c])});
  }
  return result;
}

EqualChannel equal_channel(const EncodedTransfer& transfer, const RowWeights& weights, int c) {
  const auto& own = weights[static_cast<std::size_t>(c)];
  for (int other = 0; other < c && !transfer.references; ++other) {
    const auto& theirs = weights[static_cast<std::size_t>(other)];
    if (transfer.table_of[other] != transfer.table_of[c] || own.empty() || theirs[0].weight == 0) continue;
    const float factor = own[0].weight / theirs[0].weight;
    const bool equal = std::equal(own.begin(), own.end(), theirs.begin(), [&](const RowWeight& a, const RowWeight& b) {
      return std::abs(a.weight - factor * b.weight) <= 1e-6f * std::abs(a.weight);
    });
    if (equal && factor >= 0) return {other, factor};
  }
  return {c, 1};
}

VertexExitance EncodedTransfer::exitance(const std::vector<TransferLight>& lights, const TransferNodes& nodes,
                                         Counters& counters) const {
  VertexExitance out;
  exitance(lights, nodes, out, counters);
  return out;
}

void EncodedTransfer::exitance(const std::vector<TransferLight>& lights, const TransferNodes& nodes,
                               VertexExitance& out, Counters& counters) const {
  if (out.stride != rows.stride())
    for (auto& channel : out.channel) channel = std::make_unique_for_overwrite<float[]>(rows.stride());
  out.stride = rows.stride();
  const RowWeights row_weights = weights(lights, nodes);
  Frame frame{*this, row_weights, out};
  for (int c = 0; c < 3; ++c) frame.equal[static_cast<std::size_t>(c)] = equal_channel(*this, row_weights, c);
  std::vector<float> points;
  if (references) {
    points = point_values(references->full->exitance(lights, nodes, counters), references->points.size());
    frame.blend = CornerBlend{points.data(), &references->triangles[0].x, references->triangle_of.data(),
                              references->weights.data(), references->correction};
  }
  tbb::parallel_for(std::size_t{0}, rows.blocks(), [&](std::size_t b) { frame.work(b); });
  for (int c = 0; c < 3; ++c)
    ++(frame.equal[static_cast<std::size_t>(c)].channel == c ? counters.done["channels"]
                                                             : counters.skipped["equal_channels"]);
  counters.done["negative_values_set_to_0"] += frame.negative;
  counters.done["vertex_rows"] += frame.done;
  counters.skipped["unlit_vertex_rows"] += frame.dark;
}

}  // namespace opaline
