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

/// The corners' own B, triangle by triangle, four floats a corner.
std::vector<float> corner_values(const ReferencePoints& references, const VertexExitance& full) {
  std::vector<float> corners(12 * references.triangles.size(), 0.0f);
  for (std::size_t t = 0; t < references.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t c = 0; c < 3; ++c)
        corners[12 * t + 4 * k + c] = full.channel[c][references.triangles[t][static_cast<int>(k)]];
  return corners;
}

/// One frame: all blocks of vertices.
struct Frame {
  const EncodedTransfer& transfer;
  const RowWeights& weights;
  VertexExitance& out;
  std::array<EqualChannel, 3> equal{};
  std::optional<CornerBlend> blend{};
  std::atomic<std::uint64_t> done = 0, dark = 0, negative = 0;

  void work(std::size_t b) {
    const CodedRows& rows = transfer.rows;
    const std::size_t begin = b * CodedRows::block, end = std::min(begin + CodedRows::block, rows.stride());
    std::uint64_t used = 0, skipped = 0;
    std::vector<RowTerm> terms;
    for (int c = 0; c < 3; ++c) {
      if (equal[static_cast<std::size_t>(c)].channel != c) continue;
      terms.clear();
      for (const RowWeight& w : weights[static_cast<std::size_t>(c)]) {
        if (rows.lit(w.row, b))
          terms.push_back(rows.term(w.row, w.weight));
        else
          ++skipped;
      }
      used += terms.size();
      add_rows(rows.storage(), terms, begin, end, out.channel[static_cast<std::size_t>(c)].data());
    }
    if (blend) add_blend(*blend, begin, end, out.channel[0].data(), out.channel[1].data(), out.channel[2].data());
    finish(begin, end);
    done += used * (end - begin), dark += skipped * (end - begin);
  }

  /// Channels that are another's times a factor, and no negative light.
  void finish(std::size_t begin, std::size_t end) {
    std::uint64_t below = 0;
    for (int c = 0; c < 3; ++c) {
      float* to = out.channel[static_cast<std::size_t>(c)].data();
      const EqualChannel& e = equal[static_cast<std::size_t>(c)];
      const float* from = out.channel[static_cast<std::size_t>(e.channel)].data();
      for (std::size_t i = begin; i < end; ++i) {
        const float value = e.channel == c ? to[i] : e.factor * from[i];
        below += value < 0;
        to[i] = std::max(value, 0.0f);
      }
    }
    negative += below;
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
  VertexExitance out{rows.stride(), {}};
  for (auto& channel : out.channel) channel.assign(rows.stride(), 0.0f);
  const RowWeights row_weights = weights(lights, nodes);
  Frame frame{*this, row_weights, out};
  for (int c = 0; c < 3; ++c) frame.equal[static_cast<std::size_t>(c)] = equal_channel(*this, row_weights, c);
  std::vector<float> corners;
  if (references) {
    corners = corner_values(*references, references->full->exitance(lights, nodes, counters));
    frame.blend = CornerBlend{corners.data(), references->triangle_of.data(), references->weights.data()};
  }
  if (!lights.empty()) tbb::parallel_for(std::size_t{0}, rows.blocks(), [&](std::size_t b) { frame.work(b); });
  for (int c = 0; c < 3; ++c)
    ++(frame.equal[static_cast<std::size_t>(c)].channel == c ? counters.done["channels"]
                                                             : counters.skipped["equal_channels"]);
  counters.done["negative_values_set_to_0"] += frame.negative;
  counters.done["vertex_rows"] += frame.done;
  counters.skipped["unlit_vertex_rows"] += frame.dark;
  return out;
}

}  // namespace opaline
