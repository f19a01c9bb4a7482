// Precomputed transfer: the paper's curves with the paper's figures beside ours, time of the precomputation and of a
// relit frame.
//
// Errors are as the paper's: RMS over all pixels of the film (background included) of images scaled to a largest value
// of 1, here over all colours and 24 lights. Errors of the number of directions are against tables made for those very
// lights; errors of what is stored against the float table of the same directions.
#include "datasets_synthetic/shapes/shapes.h"
#include "render/stopwatch.h"
#include "render/transfer/transfer_scene.h"
#include "validate/bench/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <random>

namespace opaline::bench {
namespace {

glm::dvec3 any_direction() { return glm::normalize(glm::dvec3(0.3, 0.5, 0.8)); }

constexpr int test_lights = 24, fine_directions = 100000;

Scene transfer_scene(const SceneChoice& choice, std::size_t vertices) {
  SceneChoice marble = choice;
  marble.material = "marble", marble.film = 256;
  Scene scene = bench_scene(marble);
  if (!choice.mesh.empty()) return scene;
  scene.objects[0].mesh = make_teapot(choice.height, static_cast<int>(2 * vertices));
  scene.objects[0].name = "teapot";
  scene.camera.position = {0, 2 * choice.height, 8 * choice.height};
  scene.camera.fov_y_deg = 16;
  return scene;
}

TransferSettings settings_for(int directions, TransferForm form) {
  TransferSettings s;
  s.profile = "standard_dipole";
  s.directions = directions, s.form = form, s.distances = 1, s.any_light = false;
  return s;
}

/// Nodes of a set so fine that they stand for any direction, and the scene lit from there.
std::vector<std::uint32_t> light_nodes() {
  std::vector<std::uint32_t> nodes;
  for (std::uint32_t i = 0; i < test_lights; ++i) nodes.push_back((i * fine_directions + 7919) / test_lights);
  return nodes;
}

Scene lit_from(const Scene& unlit, const DirectionSet& fine) {
  Scene scene = unlit;
  scene.lights.clear();
  for (const std::uint32_t node : light_nodes()) scene.lights.emplace_back(DirectionalLight{-fine[node], Rgb(1), 0});
  return scene;
}

/// A scene with all its lights, and images of B under each of them.
class Bench {
 public:
  explicit Bench(const Scene& scene)
      : fine_(fine_directions),
        scene_(lit_from(scene, fine_)),
        shared_(scene_, {scene.objects[0].mesh.triangles.size(), {}}, false) {}

  /// The table of those of `directions` that the lights need, or of all.
  TransferTable table(int directions, TransferForm form, bool all, Counters& counters) {
    TransferSettings s = settings_for(directions, form);
    s.any_light = all;
    TransferVertices v = vertices();
    return make_object_table(shared_, s, 0, nodes(directions), v, counters);
  }
  TransferNodes nodes(int directions) const { return transfer_nodes(mesh(), directions, 1); }
  const TransferVertices& vertices() {
    if (!vertices_) vertices_ = std::make_unique<TransferVertices>(mesh(), 1);
    return *vertices_;
  }

  using Images = std::vector<std::vector<glm::vec3>>;
  Images images(const EncodedTransfer& transfer, const TransferNodes& nodes) {
    Images result;
    Counters counters;
    for (const std::uint32_t light : light_nodes()) {
      const VertexExitance b = transfer.exitance({{fine_[light], 0, Rgb(1)}}, nodes, counters);
      std::vector<glm::vec3> image;
      for (const VisiblePoint& p : shared_.view.points)
        image.push_back(interpolated(vertices().at(mesh(), p.triangle, p.position), [&](std::uint32_t v) {
          return glm::vec3(b.channel[0][v], b.channel[1][v], b.channel[2][v]);
        }));
      result.push_back(std::move(image));
    }
    return result;
  }
  double rms(const Images& a, const Images& reference) const {
    double squares = 0;
    float largest = 0;
    for (std::size_t l = 0; l < reference.size(); ++l)
      for (std::size_t i = 0; i < reference[l].size(); ++i) {
        const glm::vec3 r = reference[l][i];
        const glm::dvec3 d = glm::dvec3(a[l][i]) - glm::dvec3(r);
        largest = std::max({largest, r.x, r.y, r.z});
        squares += glm::dot(d, d) / 3;
      }
    const double pixels = static_cast<double>(shared_.view.width * shared_.view.height) * test_lights;
    return std::sqrt(squares / pixels) / static_cast<double>(largest);
  }

 private:
  const Mesh& mesh() const { return scene_.objects[0].mesh; }
  DirectionSet fine_;
  Scene scene_;
  SharedScene shared_;
  std::unique_ptr<TransferVertices> vertices_;
};

void row(const std::string& name, double reached, double paper, const std::string& size) {
  fmt::print("{:<52}{:>12.2e}{:>12}   {}\n", name, reached, paper > 0 ? fmt::format("{:.2e}", paper) : "", size);
}

void print_directions(Bench& bench) {
  Counters counters;
  // The nodes of the fine set nearest to a light are the light itself and three of no weight.
  const Bench::Images exact =
      bench.images(encode_rows(bench.table(fine_directions, TransferForm::floats, false, counters), RowStorage::f32),
                   bench.nodes(fine_directions));
  const std::pair<int, double> counts[] = {{50, 0}, {100, 0}, {200, 3e-3}, {400, 0}, {800, 0}};
  for (const auto& [count, paper] : counts) {
    const EncodedTransfer q = encode_rows(bench.table(count, TransferForm::floats, false, counters), RowStorage::f32);
    const Bench::Images of_q = bench.images(q, bench.nodes(count));
    row(fmt::format("{} directions, q", count), bench.rms(of_q, exact), paper, "");
    if (count != 200) continue;
    const EncodedTransfer v = encode_rows(bench.table(count, TransferForm::vectors, false, counters), RowStorage::f32);
    const Bench::Images of_v = bench.images(v, bench.nodes(count));
    row("200 directions, Q", bench.rms(of_v, exact), 0, "");
    row("Q against q", bench.rms(of_v, of_q), 5.26e-3, "");
  }
}

double signal_to_noise(const TransferTable& table, const CodedRows& rows) {
  double signal = 0, noise = 0;
  for (std::size_t r = 0; r < table.rows(); ++r) {
    std::vector<float> value(table.stride(), 0.0f);
    const RowTerm term = rows.term(r, 1);
    add_rows(rows.storage(), {&term, 1}, 0, table.stride(), value.data());
    for (std::size_t v = 0; v < table.vertices; ++v) {
      const auto q = static_cast<double>(table.row(r)[v]), e = static_cast<double>(value[v]) - q;
      signal += q * q, noise += e * e;
    }
  }
  return 10 * std::log10(signal / noise);
}

/// For all colours, and what one colour alone would take.
std::string size_of(const EncodedTransfer& t) {
  double shared = 0;
  if (t.references)
    shared = t.references->bytes_per_vertex() - t.references->full->bytes_per_vertex() *
                                                    static_cast<double>(t.references->points.size()) /
                                                    static_cast<double>(t.vertices());
  const double all = t.bytes_per_vertex();
  return fmt::format("{:.1f} bytes a vertex, {:.1f} of one colour", all, shared + (all - shared) / t.tables);
}

void print_forms(Bench& bench, const TransferTable& table) {
  const TransferNodes nodes = bench.nodes(200);
  const Bench::Images q = bench.images(encode_rows(table, RowStorage::f32), nodes);
  const EncodedTransfer codes = encode_rows(table, RowStorage::code8);
  row("Lloyd, 8 bits", bench.rms(bench.images(codes, nodes), q), 8.83e-4,
      fmt::format("{}; {:.1f} dB, paper 51.0", size_of(codes), signal_to_noise(table, codes.rows)));
  const double paper_orders[] = {.18, .072, .027, .020, .012, .0096, .0056};
  for (int order = 1; order <= 7; ++order) {
    const EncodedTransfer t = encode_harmonics(table, nodes, order);
    row(fmt::format("harmonics, n = {}, 16 bits", order), bench.rms(bench.images(t, nodes), q), paper_orders[order - 1],
        size_of(t));
  }
  const std::pair<std::size_t, double> points[] = {
      {390, .010}, {614, .0065}, {1264, .0034}, {2526, .0022}, {5176, .0017}};
  for (const int order : {3, 6})
    for (const ReferenceWeights weights : {ReferenceWeights::barycentric, ReferenceWeights::least_squares})
      for (const auto& [count, paper] : points) {
        const EncodedTransfer t =
            encode_references(table, nodes, bench.vertices(),
                              {.points = count, .weights = weights, .order = order, .difference = RowStorage::code8});
        row(fmt::format("{} reference points, n = {}, {}", t.references->points.size(), order,
                        weights == ReferenceWeights::barycentric ? "barycentric" : "least squares"),
            bench.rms(bench.images(t, nodes), q), order == 3 && weights == ReferenceWeights::barycentric ? paper : 0,
            size_of(t));
      }
}

// --- time -------------------------------------------------------------------------------------------

std::vector<float> noise(std::size_t count) {
  std::mt19937 random(1);
  std::vector<float> values(count);
  for (float& v : values) v = static_cast<float>(random() % 1000) / 1000;
  return values;
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
  const RowStorage storage = references                    ? RowStorage::i8
                             : harmonic                    ? RowStorage::i16
                             : form == TransferForm::lloyd ? RowStorage::code8
                                                           : RowStorage::f32;
  t.rows = CodedRows(storage, noise(3 * t.keys.size() * stride), 3 * t.keys.size(), vertices,
                     references ? static_cast<int>(3 * t.keys.size()) : 3);
  if (!references) return t;
  ReferencePoints points;
  const std::size_t count = vertices / 29 + 3;
  points.full = std::make_unique<EncodedTransfer>(any_transfer(TransferForm::lloyd, count, nodes));
  points.points.resize(count);
  for (std::uint32_t k = 0; k + 2 < count; ++k) points.triangles.push_back({k, k + 1, k + 2});
  for (std::size_t v = 0; v < stride; ++v)
    points.triangle_of.push_back(static_cast<std::uint32_t>(std::min(v / 29, count - 3)));
  points.weights.assign(2 * stride, 3333);
  t.references = std::move(points);
  return t;
}

struct FrameTime {
  double seconds, processor;
};

/// Medians of a relit frame.
FrameTime frame_time(const EncodedTransfer& t, const TransferNodes& nodes, int runs) {
  Counters counters;
  const std::vector<TransferLight> light = {{any_direction(), 0, Rgb(1)}};
  std::vector<double> processor;
  const double seconds = median_seconds(runs, [&] {
    const std::clock_t start = std::clock();
    t.exitance(light, nodes, counters);
    processor.push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  });
  std::sort(processor.begin(), processor.end());
  return {seconds, processor[processor.size() / 2]};
}

std::vector<Figure> run_time_figures(const Scene& scene, int runs) {
  std::vector<Figure> figures;
  const TransferNodes nodes = transfer_nodes(scene.objects[0].mesh, 200, 1);
  std::vector<std::uint32_t> keys;
  for (const KeyWeight& w : node_weights({{any_direction(), 0, Rgb(1)}}, nodes)) keys.push_back(w.key);
  const std::pair<TransferForm, const char*> forms[] = {{TransferForm::floats, "float q"},
                                                        {TransferForm::lloyd, "Lloyd codes"},
                                                        {TransferForm::harmonics, "harmonics, n = 7"},
                                                        {TransferForm::references, "reference points, n = 3"}};
  for (const auto& [form, name] : forms) {
    const FrameTime t = frame_time(any_transfer(form, 150510, keys), nodes, 4 * runs);
    figures.push_back({fmt::format("{}: a relit frame of 150510 vertices, RGB", name), 1e3 * t.seconds, 3, true, "ms",
                       fmt::format("{:.2f} ms of processor", 1e3 * t.processor)});
    if (form == TransferForm::references)
      figures.push_back({"  vertex-lights (three colours each)", 1e-6 * 150510 / t.seconds, 100, false, "M/s", ""});
    double x = 0, y = 0, xx = 0, xy = 0;
    for (const double vertices : {1e4, 3e4, 1e5, 3e5, 1e6}) {
      const double u = std::log(vertices),
                   v = std::log(
                       frame_time(any_transfer(form, static_cast<std::size_t>(vertices), keys), nodes, 4 * runs)
                           .processor);
      x += u / 5, y += v / 5, xx += u * u / 5, xy += u * v / 5;
    }
    const double power = (xy - x * y) / (xx - x * x);
    figures.push_back({"  exponent of vertices, 1e4 to 1e6, at most", power, 1.05, true, "", "of processor time"});
    figures.push_back({"  at least", power, 0.95, false, "", ""});
  }
  return figures;
}

}  // namespace

void print_transfer_figures(const SceneChoice& choice) {
  const Scene scene = transfer_scene(choice, choice.transfer_vertices);
  print_figures("Precomputed transfer: run time", run_time_figures(scene, choice.runs));
  Bench bench(scene);
  Counters counters;
  TransferTable table;
  const std::clock_t start = std::clock();
  const double seconds = [&] {
    Stopwatch watch;
    table = bench.table(200, TransferForm::floats, true, counters);
    return watch.lap();
  }();
  const double processor = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  const double work = 1e-6 * static_cast<double>(table.vertices * table.rows());
  print_figures("Precomputed transfer: the table",
                {{fmt::format("{} vertices x 200 directions x RGB", table.vertices), seconds, 60, true, "s",
                  fmt::format("{:.1f} s of processor", processor)},
                 {"  values", work / seconds, 0, true, "M/s", ""},
                 {"  shadow rays", 1e-6 * static_cast<double>(counters.done["shadow_rays"]), 0, true, "M", ""}});
  fmt::print("\nPrecomputed transfer, {}, {} vertices: RMS error of images in [0, 1]\n{:<52}{:>12}{:>12}   {}\n",
             scene.objects[0].name, table.vertices, "", "reached", "paper", "stored");
  print_forms(bench, table);
  table = {};
  print_directions(bench);
}

}  // namespace opaline::bench
