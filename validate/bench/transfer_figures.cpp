// Precomputed transfer: the paper's curves with the paper's figures beside ours, and time of the precomputation.
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
#include <tuple>

namespace opaline::bench {
namespace {

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
  TransferTable table(int directions, TransferForm form, bool all, Counters& counters,
                      DirectionInterpolation interpolation = DirectionInterpolation::four) {
    TransferSettings s = settings_for(directions, form);
    s.any_light = all;
    TransferVertices v = vertices();
    return make_object_table(shared_, s, 0, nodes(directions, interpolation), v, counters);
  }
  TransferNodes nodes(int directions, DirectionInterpolation interpolation = DirectionInterpolation::four) const {
    return transfer_nodes(mesh(), directions, 1, interpolation);
  }
  const TransferVertices& vertices() {
    if (!vertices_) vertices_ = std::make_unique<TransferVertices>(mesh(), 1);
    return *vertices_;
  }

  using Images = std::vector<std::vector<glm::vec3>>;
  Images images(const EncodedTransfer& transfer, const TransferNodes& nodes) {
    std::vector<glm::dvec3> lights;
    for (const std::uint32_t light : light_nodes()) lights.push_back(fine_[light]);
    return images(transfer, nodes, lights);
  }
  Images images(const EncodedTransfer& transfer, const TransferNodes& nodes, const std::vector<glm::dvec3>& lights) {
    Images result;
    Counters counters;
    for (const glm::dvec3& light : lights) {
      const VertexExitance b = transfer.exitance({{light, 0, Rgb(1)}}, nodes, counters);
      std::vector<glm::vec3> image;
      for (const VisiblePoint& p : shared_.view.points)
        image.push_back(interpolated(vertices().at(mesh(), p.triangle, p.position), [&](std::uint32_t v) {
          return glm::vec3(b.channel[0][v], b.channel[1][v], b.channel[2][v]);
        }));
      result.push_back(std::move(image));
    }
    return result;
  }
  glm::dvec3 eye() const { return glm::normalize(scene_.camera.position); }
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
    // The twelve nearest directions to a light include the four.
    constexpr DirectionInterpolation twelve = DirectionInterpolation::twelve;
    const EncodedTransfer q =
        encode_rows(bench.table(count, TransferForm::floats, false, counters, twelve), RowStorage::f32);
    const Bench::Images of_q = bench.images(q, bench.nodes(count));
    row(fmt::format("{} directions, q", count), bench.rms(of_q, exact), paper, "");
    row(fmt::format("{} directions, q, interpolated from twelve", count),
        bench.rms(bench.images(q, bench.nodes(count, twelve)), exact), paper, "");
    if (count != 200) continue;
    const EncodedTransfer v = encode_rows(bench.table(count, TransferForm::vectors, false, counters), RowStorage::f32);
    const Bench::Images of_v = bench.images(v, bench.nodes(count));
    row("200 directions, Q", bench.rms(of_v, exact), 0, "");
    row("Q against q", bench.rms(of_v, of_q), 5.26e-3, "");
  }
}

double relative_rms(const std::vector<glm::vec3>& image, const std::vector<glm::vec3>& exact) {
  double squares = 0, norm = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const glm::dvec3 d = glm::dvec3(image[i]) - glm::dvec3(exact[i]);
    squares += glm::dot(d, d), norm += glm::dot(glm::dvec3(exact[i]), glm::dvec3(exact[i]));
  }
  return std::sqrt(squares / norm);
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

constexpr std::pair<std::size_t, double> paper_points[] = {
    {390, .010}, {614, .0065}, {1264, .0034}, {2526, .0022}, {5176, .0017}};

void print_references(Bench& bench, const TransferTable& table, const Bench::Images& q) {
  const std::tuple<ReferenceSelection, ReferenceWeights, const char*> ways[] = {
      {ReferenceSelection::shape, ReferenceWeights::barycentric, "as published"},
      {ReferenceSelection::transfer, ReferenceWeights::barycentric, "by transfer"},
      {ReferenceSelection::transfer, ReferenceWeights::least_squares, "by transfer, fitted"}};
  const TransferNodes nodes = bench.nodes(200);
  for (const int order : {3, 6})
    for (const auto& [selection, weights, name] : ways)
      for (const auto& [count, paper] : paper_points) {
        if (2 * count > table.vertices) continue;
        const EncodedTransfer t =
            encode_references(table, nodes, bench.vertices(),
                              {.points = count, .selection = selection, .weights = weights, .order = order});
        row(fmt::format("{} reference points, n = {}, {}", t.references->points.size(), order, name),
            bench.rms(bench.images(t, nodes), q), order == 3 ? paper : 0, size_of(t));
      }
}

/// Relative RMS of single images lit from in front, from the side and from behind, where all that is seen is dim.
void print_sides(Bench& bench, const TransferTable& table) {
  const TransferNodes nodes = bench.nodes(200);
  const glm::dvec3 eye = bench.eye();
  const std::vector<glm::dvec3> lights = {glm::normalize(eye + glm::dvec3(0.1, 0.1, 0)),
                                          glm::normalize(glm::dvec3(1, 0.2, 0.1)),
                                          glm::normalize(-eye + glm::dvec3(0.15, 0.2, 0))};
  const Bench::Images exact = bench.images(encode_rows(table, RowStorage::f32), nodes, lights);
  fmt::print("\nRelative RMS error of single images against q{:<7}{:>12}{:>12}{:>12}\n", "", "front-lit", "side-lit",
             "back-lit");
  const auto line = [&](const std::string& name, const EncodedTransfer& t) {
    const Bench::Images images = bench.images(t, nodes, lights);
    fmt::print("{:<52}", name);
    for (std::size_t l = 0; l < 3; ++l) fmt::print("{:>12.2e}", relative_rms(images[l], exact[l]));
    fmt::print("\n");
  };
  ReferenceSettings settings{.points = default_references(table.vertices)};
  line("Lloyd, 8 bits", encode_rows(table, RowStorage::code8));
  line("harmonics, n = 7", encode_harmonics(table, nodes, 7));
  line(fmt::format("{} reference points, n = 3, as published", settings.points),
       encode_references(table, nodes, bench.vertices(), settings));
  settings.selection = ReferenceSelection::transfer, settings.weights = ReferenceWeights::least_squares;
  line("the same, by transfer, fitted", encode_references(table, nodes, bench.vertices(), settings));
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
  print_references(bench, table, q);
}

}  // namespace

void print_transfer_figures(const SceneChoice& choice) {
  const Scene scene = transfer_scene(choice, choice.transfer_vertices);
  print_figures("Precomputed transfer: run time", transfer_time_figures(choice.runs));
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
  print_sides(bench, table);
  table = {};
  fmt::print("\nRMS error of images in [0, 1] against tables made for their very lights\n");
  print_directions(bench);
}

}  // namespace opaline::bench
