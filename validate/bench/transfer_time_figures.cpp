// Precomputed transfer: relit frames of tables of any contents, beside what the machine's memory allows.
//
// A frame reads a table's rows and writes the exitance; nothing it computes takes as long. Its limit is the time that
// reading as many bytes takes with every core, from the caches that hold so many: small tables lie in a core's second
// cache, large ones in main memory, several times slower, and the time for a vertex differs as much. So frames are
// measured twice, warm, where the last frame left the table in the caches as far as it fits, and swept, where other
// work has passed through all caches since.
#include "datasets_synthetic/shapes/shapes.h"
#include "render/stopwatch.h"
#include "render/transfer/transfer_scene.h"
#include "validate/bench/figures.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <ctime>
#include <random>
#include <thread>

namespace opaline::bench {
namespace {

constexpr std::size_t teapot = 150510;  // vertices of the paper's

std::vector<TransferLight> one_light() { return {{glm::normalize(glm::dvec3(0.3, 0.5, 0.8)), 0, Rgb(1)}}; }

std::vector<float> noise(std::size_t count) {
  std::minstd_rand random(1);
  std::vector<float> values(count);
  for (float& v : values) v = static_cast<float>(random() % 1000) / 1000;
  return values;
}

ReferencePoints any_points(EncodedTransfer full, std::size_t vertices, std::size_t stride) {
  ReferencePoints points;
  const std::size_t count = full.vertices();
  points.full = std::make_unique<EncodedTransfer>(std::move(full));
  points.points.resize(count);
  for (std::uint32_t k = 0; k + 2 < count; ++k) points.triangles.push_back({k, k + 1, k + 2});
  for (std::size_t v = 0; v < stride; ++v)
    points.triangle_of.push_back(static_cast<std::uint32_t>(std::min(v * count / vertices, count - 3)));
  points.weights.assign(2 * stride, 3333);
  return points;
}

/// A table of three colours of any contents: time does not depend on what is in it.
EncodedTransfer any_transfer(TransferForm form, std::size_t vertices, const std::vector<std::uint32_t>& nodes) {
  EncodedTransfer t;
  t.tables = 3;
  for (int c = 0; c < 3; ++c) t.table_of[c] = c;
  const std::size_t stride = (vertices + TransferTable::lanes - 1) / TransferTable::lanes * TransferTable::lanes;
  const bool references = form == TransferForm::references, harmonic = references || form == TransferForm::harmonics;
  t.order = references ? 3 : 7;
  t.basis = harmonic ? TransferBasis::harmonics : TransferBasis::nodes;
  for (std::uint32_t i = 0; harmonic && i < static_cast<std::uint32_t>(t.order * t.order); ++i) t.keys.push_back(i);
  if (!harmonic) t.keys = nodes;
  const RowStorage storage = references                    ? ReferenceSettings{}.difference
                             : harmonic                    ? RowStorage::i16
                             : form == TransferForm::lloyd ? RowStorage::code8
                                                           : RowStorage::f32;
  t.rows = CodedRows(storage, noise(3 * t.keys.size() * stride), 3 * t.keys.size(), vertices, 3);
  if (references)
    t.references = any_points(any_transfer(TransferForm::lloyd, vertices / 29 + 3, nodes), vertices, stride);
  return t;
}

/// What a frame reads and writes; what it writes is fetched first.
double frame_bytes(const EncodedTransfer& t, const TransferNodes& nodes) {
  std::size_t rows = 0;
  for (const auto& channel : t.weights(one_light(), nodes)) rows += channel.size();
  const double of_rows = static_cast<double>(rows * bytes_of(t.rows.storage())), of_exitance = 2 * 3 * sizeof(float);
  const double of_places = t.references ? sizeof(std::uint32_t) + 2 * sizeof(short) : 0;
  return static_cast<double>(t.rows.stride()) * (of_rows + of_exitance + of_places);
}

/// Reads all of a buffer with every core.
void read_through(const std::vector<std::uint64_t>& buffer) {
  constexpr std::size_t part = 8192, together = 16;
  static std::atomic<std::uint64_t> sink;
  tbb::parallel_for(std::size_t{0}, buffer.size() / part, [&](std::size_t p) {
    std::uint64_t sums[together] = {};
    for (std::size_t i = 0; i < part; i += together)
      for (std::size_t k = 0; k < together; ++k) sums[k] ^= buffer[p * part + i + k];
    for (const std::uint64_t s : sums) sink.fetch_xor(s, std::memory_order_relaxed);
  });
}

/// Medians of a call, of the wall and of all processors [s]; swept: after reading more than the caches hold.
struct Times {
  double wall, processor;
};

template <typename Call>
Times times_of(int runs, bool swept, const Call& call) {
  static const std::vector<std::uint64_t> other_work(std::size_t{32} << 20, 1);  // 256 MiB
  std::vector<double> wall, processor;
  for (int i = 0; i <= runs; ++i) {
    if (swept) read_through(other_work);
    Stopwatch watch;
    const std::clock_t start = std::clock();
    call();
    const double used = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    if (i > 0) processor.push_back(used), wall.push_back(watch.lap());
  }
  std::sort(wall.begin(), wall.end());
  std::sort(processor.begin(), processor.end());
  return {wall[wall.size() / 2], processor[processor.size() / 2]};
}

Times frame_times(const EncodedTransfer& t, const TransferNodes& nodes, int runs, bool swept) {
  Counters counters;
  VertexExitance out;
  return times_of(runs, swept, [&] { t.exitance(one_light(), nodes, out, counters); });
}

Times limit(double bytes, int runs, bool swept) {
  const std::vector<std::uint64_t> buffer(static_cast<std::size_t>(bytes / 65536 + 1) * 8192, 1);
  return times_of(runs, swept, [&] { read_through(buffer); });
}

/// The power of vertices with which a time grows: slope of the logarithms.
class Growth {
 public:
  void add(double vertices, double seconds) {
    const double u = std::log(vertices), v = std::log(seconds);
    ++n_, x_ += u, y_ += v, xx_ += u * u, xy_ += u * v;
  }
  double exponent() const { return (xy_ - x_ * y_ / n_) / (xx_ - x_ * x_ / n_); }

 private:
  double n_ = 0, x_ = 0, y_ = 0, xx_ = 0, xy_ = 0;
};

void add_exponents(TransferForm form, const std::vector<std::uint32_t>& keys, const TransferNodes& nodes, int runs,
                   std::vector<Figure>& figures) {
  Growth growth[2], memory[2];
  std::string each[2], at_least[2];
  for (const double vertices : {1e4, 3e4, 1e5, 3e5, 1e6}) {
    const EncodedTransfer t = any_transfer(form, static_cast<std::size_t>(vertices), keys);
    for (const bool swept : {false, true}) {
      const double frame = frame_times(t, nodes, 4 * runs, swept).processor,
                   least = limit(frame_bytes(t, nodes), 4 * runs, swept).processor;
      growth[swept].add(vertices, frame), memory[swept].add(vertices, least);
      each[swept] += fmt::format(" {:.1f}", 1e9 * frame / vertices);
      at_least[swept] += fmt::format(" {:.1f}", 1e9 * least / vertices);
    }
  }
  for (const bool swept : {false, true}) {
    const std::string note = fmt::format("ns a vertex{} of processor; memory alone {:.3f},{}", each[swept],
                                         memory[swept].exponent(), at_least[swept]);
    const char* name = swept ? "swept" : "warm";
    const double power = growth[swept].exponent();
    figures.push_back(
        {fmt::format("  exponent of vertices, 1e4 to 1e6, {}, at most", name), power, 1.05, true, "", note});
    figures.push_back({"    at least", power, 0.95, false, "", ""});
  }
}

void add_frames(const EncodedTransfer& t, const char* name, const TransferNodes& nodes, int runs,
                std::vector<Figure>& figures) {
  const double cores = static_cast<double>(std::thread::hardware_concurrency());
  for (const bool swept : {false, true}) {
    const Times frame = frame_times(t, nodes, 8 * runs, swept), least = limit(frame_bytes(t, nodes), 8 * runs, swept);
    const std::string title =
        fmt::format("{}: a relit frame of {} vertices, RGB, {}", name, teapot, swept ? "swept" : "warm");
    figures.push_back({title, 1e3 * frame.processor / cores, 3, true, "ms",
                       fmt::format("of {:.0f} cores; wall {:.2f} ms; memory alone {:.2f} ms, {:.1f} MB", cores,
                                   1e3 * frame.wall, 1e3 * least.processor / cores, 1e-6 * frame_bytes(t, nodes))});
    if (t.references)
      figures.push_back({"  vertex-lights (three colours each)", 1e-6 * teapot * cores / frame.processor, 100, false,
                         "M/s", fmt::format("by the wall {:.0f}", 1e-6 * teapot / frame.wall)});
  }
}

}  // namespace

std::vector<Figure> transfer_time_figures(int runs) {
  std::vector<Figure> figures;
  const TransferNodes nodes = transfer_nodes(make_sphere(10, 320), 200, 1);
  std::vector<std::uint32_t> keys;
  for (const KeyWeight& w : node_weights(one_light(), nodes)) keys.push_back(w.key);
  const std::pair<TransferForm, const char*> forms[] = {{TransferForm::floats, "float q"},
                                                        {TransferForm::lloyd, "Lloyd codes"},
                                                        {TransferForm::harmonics, "harmonics, n = 7"},
                                                        {TransferForm::references, "reference points, n = 3"}};
  for (const auto& [form, name] : forms) {
    add_frames(any_transfer(form, teapot, keys), name, nodes, runs, figures);
    add_exponents(form, keys, nodes, runs, figures);
  }
  return figures;
}

}  // namespace opaline::bench
