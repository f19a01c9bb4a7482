#include "render/layered/layered_convolution.h"

#include "render/layered/layered_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

namespace opaline {
namespace {

/// Sides of a grid, before the room for the kernel.
constexpr int max_nodes = 2048;

/// A radius that holds all but 1e-5 of the profile's flux.
double flux_radius(const Profile& profile) {
  double lo = profile.core_radius(), hi = 1e9 * lo;
  for (int i = 0; i < 60; ++i) {
    const double r = std::sqrt(lo * hi);
    (profile.cumulative(r) < (1 - 1e-5) * profile.total() ? lo : hi) = r;
  }
  return hi;
}

/// Splat and lookup move two points of equal depth apart: to layers a gap apart in a third of the cases, on the
/// average. What must be taken off the squared distances [mm^2] so that the far part of the profile keeps its energy.
double depth_spread(const PlaneSpectrum& spectrum, double near_length, double gap) {
  const double wanted = spectrum(0, near_length), square = near_length * near_length;
  double lo = 0, hi = 0.5 * gap * gap;
  for (int i = 0; i < 40; ++i) {
    const double spread = 0.5 * (lo + hi);
    const double same = spectrum(0, std::sqrt(square - spread)),
                 apart = spectrum(0, std::sqrt(square + gap * gap - spread));
    (2 * same + apart < 3 * wanted ? lo : hi) = spread;
  }
  return std::min(lo, 0.9 * square);
}

/// R_d(0), or, of a profile with a sharp peak, its mean over the disc of its spread.
double peak(const PlaneSpectrum& spectrum, const Profile& profile) {
  const double length = spread_length(spectrum);
  return std::min(profile.evaluate(0), profile.total() / (pi * length * length));
}

class ObjectRender {
 public:
  ObjectRender(const SharedScene& shared, const LayeredObject& object, const LayeredSettings& settings,
               const GBuffer& view, int index, Frame& frame)
      : object_(object),
        settings_(settings),
        cells_(shared.cells[static_cast<std::size_t>(index)]),
        field_(shared.irradiance[static_cast<std::size_t>(index)]),
        mesh_(shared.scene.objects[static_cast<std::size_t>(index)].mesh),
        points_(points_of_object(view, index)),
        frame_(frame),
        counters_(frame.counters) {
    if (points_.indices.empty()) return;
    axes_ = parallel_frame(view, points_.positions);
    whole_ = frame_box(axes_, mesh_.positions);
    choice_ = choose(settings, object.spectra, whole_.hi.z - whole_.lo.z, axes_.pixel);
    for (std::size_t s = 0; s < object.spectra.size(); ++s) peak_.push_back(peak(object.spectra[s], profile_of(s)));
    frame.notes.push_back(
        fmt::format("{}: {}", shared.scene.objects[static_cast<std::size_t>(index)].name, choice_.note));
  }

  void run(LayeredBackend& backend) {
    if (points_.indices.empty()) return;
    std::map<double, std::vector<std::size_t>> groups;  // profiles of equal resolution share a grid
    for (std::size_t s = 0; s < object_.spectra.size(); ++s) groups[choice_.nodes_per_pixel[s]].push_back(s);
    for (const auto& [nodes, spectra] : groups) {
      LayeredPass pass = make_pass(nodes, spectra);
      const auto values = backend.run(pass);
      for (std::size_t lane = 0; lane < values.size(); ++lane) add(pass.lanes[lane], values[lane]);
    }
    counters_.done["channels"] += object_.spectra.size();
    counters_.skipped["equal_channels"] += 3 - object_.spectra.size();
  }

 private:
  void add(const LayerLane& lane, const std::vector<float>& values) {
    for (int c = 0; c < 3; ++c) {
      if (!lane.colours[static_cast<std::size_t>(c)]) continue;
      const auto colour = static_cast<float>(field_.colour[c]);
      for (std::size_t i = 0; i < values.size(); ++i)
        frame_.exitance[points_.indices[i]][c] = colour * std::max(values[i], 0.0f);
    }
  }

  LayeredPass make_pass(double nodes, const std::vector<std::size_t>& spectra) {
    double reach = 0;
    for (const std::size_t s : spectra) reach = std::max(reach, flux_radius(profile_of(s)));
    const FrameBox box = region(reach);
    const CutOff cut = cut_off(reach, glm::dvec2(box.hi - box.lo));
    const FrameGrid grid = frame_grid(axes_, box, nodes, max_nodes);
    const double room = (cut.finite() ? cut.end : reach) / grid.step;
    LayeredPass pass{grid,
                     good_fft_size(grid.width + static_cast<int>(room) + 2),
                     good_fft_size(grid.height + static_cast<int>(room) + 2),
                     1,
                     place_layers(),
                     {},
                     {},
                     {}};
    pass.scale = static_cast<float>(1 / (grid.step * grid.step * pass.width * pass.height));
    const bool facing = settings_.near_surface && pass.layers.count() > 1;
    pass.sources = splat_cells(cells_, field_, axes_, grid, pass.width, pass.height, pass.layers,
                               {settings_.half, facing, pieces_of(grid, spectra)});
    if (!settings_.skip_dark)
      for (auto& lit : pass.sources.lit) std::fill(lit.begin(), lit.end(), std::uint8_t{1});
    place_points(pass);
    for (const std::size_t s : spectra) add_lanes(pass, s, cut);
    count_pass(pass);
    return pass;
  }

  /// Where a profile sees single nodes, the pieces must be spread evenly over them.
  float pieces_of(const FrameGrid& grid, const std::vector<std::size_t>& spectra) const {
    const auto narrow = [&](std::size_t s) { return beyond_grid(grid, object_.spectra[s]); };
    return std::any_of(spectra.begin(), spectra.end(), narrow) ? 0.5f : 1.0f;
  }

  /// Does much of the profile's spectrum lie beyond the frequencies of the grid?
  static bool beyond_grid(const FrameGrid& grid, const PlaneSpectrum& spectrum) {
    return spectrum(pi / grid.step, 0) > 0.1 * spectrum(0, 0);
  }

  const Profile& profile_of(std::size_t spectrum) const {
    for (int c = 0; c < 2; ++c)
      if (object_.spectrum_of[static_cast<std::size_t>(c)] == spectrum) return object_.profiles->profile(c);
    return object_.profiles->profile(2);
  }

  /// What the layers cover: of the object what is seen and what is within reach of it.
  FrameBox region(double reach) const {
    FrameBox box = whole_;
    const FrameBox seen = frame_box(axes_, points_.positions);
    for (int i = 0; i < 2; ++i) {
      box.lo[i] = std::max(box.lo[i], seen.lo[i] - reach), box.hi[i] = std::min(box.hi[i], seen.hi[i] + reach);
      if (settings_.skip_outside) continue;
      box.lo[i] = std::min(box.lo[i], axes_.film_lo[i]), box.hi[i] = std::max(box.hi[i], axes_.film_hi[i]);
    }
    return box;
  }

  CutOff cut_off(double reach, const glm::dvec2& size) const {
    CutOff cut;
    const double across = std::min(projected_diameter(axes_, mesh_.positions), glm::length(size));
    const double depth = whole_.hi.z - whole_.lo.z;
    if (reach > across) cut.start = across, cut.end = 1.2 * across;
    cut.range = std::max(cut.finite() ? cut.end : reach, depth);
    return cut;
  }

  Layers place_layers() const {
    const double lo = whole_.lo.z, hi = whole_.hi.z;
    if (!settings_.by_surface) return Layers::uniform(lo, hi, choice_.layers);
    constexpr int parts = 256;
    std::vector<double> lit(parts), seen(parts);
    const auto part = [&](double z) {
      return static_cast<std::size_t>(std::clamp(static_cast<int>(parts * (z - lo) / (hi - lo)), 0, parts - 1));
    };
    const auto width = static_cast<std::size_t>(field_.width());
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const float* e = &field_.values[i * width];
      lit[part(axes_.point(cell_centroid(cells_[i])).z)] +=
          static_cast<double>(cell_area(cells_[i]) * std::accumulate(e, e + field_.channels, 0.0f));
    }
    for (const glm::vec3& p : points_.positions) seen[part(axes_.point(p).z)] += 1;
    const double all_lit = std::accumulate(lit.begin(), lit.end(), 1e-30),
                 all_seen = std::accumulate(seen.begin(), seen.end(), 0.0);
    for (std::size_t i = 0; i < parts; ++i) lit[i] = lit[i] / all_lit + seen[i] / all_seen;
    return Layers::by_surface(lo, hi, choice_.layers, lit);
  }

  void place_points(LayeredPass& pass) const {
    for (const glm::vec3& p : points_.positions) {
      const glm::dvec3 at = axes_.point(p);
      const auto inside = [](double v, int size) {
        return static_cast<float>(std::clamp(v, 0.0, static_cast<double>(size - 1) - 1e-3));
      };
      double x = pass.grid.x(at.x), y = pass.grid.y(at.y);
      if (pass.grid.on_nodes) x = std::round(x), y = std::round(y);
      pass.points.push_back({inside(x, pass.grid.width), inside(y, pass.grid.height), pass.layers.place(at.z)});
    }
  }

  std::vector<std::uint8_t> seen_layers(const LayeredPass& pass) const {
    std::vector<std::uint8_t> seen(static_cast<std::size_t>(pass.layers.count()), !settings_.skip_unseen);
    for (const LayerPoint& p : pass.points) {
      if (p.z.share < 1) seen[static_cast<std::size_t>(p.z.lower)] = 1;
      if (p.z.share > 0) seen[static_cast<std::size_t>(p.z.lower + 1)] = 1;
    }
    return seen;
  }

  /// Lanes of a spectrum: one for all its colours if the light has one colour, else one for each.
  void add_lanes(LayeredPass& pass, std::size_t spectrum, const CutOff& cut) {
    LayerLane lane = make_lane(pass, spectrum, cut);
    std::array<bool, 3> colours{};
    for (std::size_t c = 0; c < 3; ++c) colours[c] = object_.spectrum_of[c] == spectrum;
    if (field_.channels == 1) {
      set_products(pass, lane, spectrum, 0);
      lane.colours = colours;
      pass.lanes.push_back(std::move(lane));
      return;
    }
    for (int c = 0; c < 3; ++c) {
      if (!colours[static_cast<std::size_t>(c)]) continue;
      LayerLane one = lane;
      set_products(pass, one, spectrum, c);
      one.colours[static_cast<std::size_t>(c)] = true;
      pass.lanes.push_back(std::move(one));
    }
  }

  double near_length(const Layers& layers) const { return settings_.near_gaps * layers.largest_gap(); }

  /// Kernels of all distances between layers: the whole ones and, with near=surface, behind them the far ones.
  LayerLane make_lane(const LayeredPass& pass, std::size_t s, const CutOff& cut) const {
    const PlaneSpectrum& spectrum = object_.spectra[s];
    const Layers& layers = pass.layers;
    std::vector<double> distances;
    for (int i = 0; i < layers.separations(); ++i) distances.push_back(layers.distance(i));
    const bool near = pass.sources.stacks.size() > static_cast<std::size_t>(field_.channels);
    double near_total = 0;
    if (near) {
      const double length = near_length(layers);
      // Surface that lies in a layer needs none of it, surface between two layers more: half is taken.
      const double gap = std::sqrt(layers.mean_square_gap());
      const double spread = settings_.half ? 0 : 0.5 * depth_spread(spectrum, length, gap);
      for (int i = 0; i < layers.separations(); ++i)
        distances.push_back(std::sqrt(std::pow(layers.distance(i), 2) + length * length - spread));
      near_total = spectrum(0, 0) - spectrum(0, length);
    }
    const double k_max = std::sqrt(2.0) * pi / pass.grid.step;
    LayerLane lane{KernelTable(spectrum, distances, k_max, cut), {}, static_cast<float>(near_total), {}, {}, {}};
    const int power = window_power(pass, spectrum);
    lane.x_axis = grid_axis(pass.width, pass.grid.step, power);
    lane.y_axis = grid_axis(pass.height, pass.grid.step, power);
    return lane;
  }

  /// Linear interpolation is undone only where nothing of the profile lies beyond the grid's frequencies.
  int window_power(const LayeredPass& pass, const PlaneSpectrum& spectrum) const {
    if (settings_.pixel_kernel) return 1;
    if (beyond_grid(pass.grid, spectrum)) return 0;
    return pass.grid.on_nodes ? -2 : -4;
  }

  void set_products(const LayeredPass& pass, LayerLane& lane, std::size_t s, int channel) {
    const std::vector<std::uint8_t> seen = seen_layers(pass);
    const Layers& layers = pass.layers;
    const bool near = pass.sources.stacks.size() > static_cast<std::size_t>(field_.channels);
    const auto pairs = static_cast<std::uint64_t>(layers.count());
    lane.outputs.resize(near ? 3 : 1);
    for (int l = 0; l < layers.count(); ++l) {
      if (!seen[static_cast<std::size_t>(l)]) {
        counters_.skipped["convolutions_unseen_layers"] += pairs;
        continue;
      }
      for (auto& output : lane.outputs) output.push_back({l, {}});
      for (int j = 0; j < layers.count(); ++j) add_pair(pass, lane, s, channel, l, j);
      for (auto& output : lane.outputs)
        if (output.back().products.empty()) output.pop_back();
    }
  }

  void add_pair(const LayeredPass& pass, LayerLane& lane, std::size_t s, int channel, int l, int j) {
    const int separation = pass.layers.separation(l, j), far = separation + pass.layers.separations();
    const double distance = pass.layers.distance(separation);
    if (!pass.sources.any(j)) {
      ++counters_.skipped["convolutions_dark_layers"];
      return;
    }
    if (profile_of(s).evaluate(distance) < choice_.threshold * peak_[s]) {
      ++counters_.skipped["convolutions_below_threshold"];
      return;
    }
    ++counters_.done["convolutions"];
    const auto add = [&](std::size_t output, int source, int kernel, int less) {
      if (pass.sources.lit[static_cast<std::size_t>(source)][static_cast<std::size_t>(j)])
        lane.outputs[output].back().products.push_back({source, j, kernel, less});
    };
    if (lane.outputs.size() == 1) return add(0, channel, separation, -1);
    add(0, channel, far, -1);
    add(0, field_.channels + channel, separation, -1);
    if (distance > near_length(pass.layers)) return;
    add(1, channel, separation, far);
    add(2, 2 * field_.channels, separation, far);
  }

  void count_pass(const LayeredPass& pass) {
    const auto layers = static_cast<std::uint64_t>(pass.layers.count());
    std::uint64_t forward = 0, backward = 0, outputs = 0;
    for (const auto& lit : pass.sources.lit)
      forward += static_cast<std::uint64_t>(std::count(lit.begin(), lit.end(), 1));
    for (const LayerLane& lane : pass.lanes)
      for (const auto& output : lane.outputs) backward += output.size(), ++outputs;
    counters_.done["transforms"] += forward + backward;
    counters_.skipped["transforms_dark_layers"] += layers * pass.sources.lit.size() - forward;
    counters_.skipped["transforms_unseen_layers"] += layers * outputs - backward;
    counters_.done["layers"] += layers;
    const auto nodes = static_cast<std::uint64_t>(pass.grid.width) * static_cast<std::uint64_t>(pass.grid.height);
    const glm::dvec2 film = (axes_.film_hi - axes_.film_lo) / pass.grid.step;
    const auto of_film = static_cast<std::uint64_t>(film.x * film.y);
    counters_.done["layer_nodes"] += nodes * layers;
    counters_.skipped["layer_nodes_outside_rectangle"] += (of_film > nodes ? of_film - nodes : 0) * layers;
    counters_.done["cell_pieces"] += pass.sources.pieces;
    counters_.skipped["dark_cells"] += pass.sources.dark_cells;
    counters_.skipped["cells_out_of_reach"] += pass.sources.cells_outside;
  }

  const LayeredObject& object_;
  const LayeredSettings& settings_;
  const SurfaceCells& cells_;
  const IrradianceField& field_;
  const Mesh& mesh_;
  ObjectPoints points_;
  Frame& frame_;
  Counters& counters_;
  ParallelFrame axes_;
  FrameBox whole_;
  LayeredChoice choice_;
  std::vector<double> peak_;  ///< per profile: what the threshold is relative to [1/mm^2]
};

}  // namespace

std::vector<LayeredObject> layered_objects(const Scene& scene, const LayeredSettings& settings) {
  std::vector<LayeredObject> objects;
  for (const Object& object : scene.objects) {
    LayeredObject o;
    o.profiles = std::make_unique<ChannelProfiles>(*find_profile(settings.profile),
                                                   scene.materials[static_cast<std::size_t>(object.material)],
                                                   1.01 * diameter(object.mesh));
    for (int c = 0; c < 3; ++c) {
      const int table = o.profiles->sum().table_of[c];
      std::size_t& of = o.spectrum_of[static_cast<std::size_t>(c)];
      of = o.spectra.size();
      if (settings.equal_once)
        for (int earlier = 0; earlier < c; ++earlier)
          if (o.profiles->sum().table_of[earlier] == table) of = o.spectrum_of[static_cast<std::size_t>(earlier)];
      if (of == o.spectra.size()) o.spectra.emplace_back(o.profiles->profile(c));
    }
    objects.push_back(std::move(o));
  }
  return objects;
}

Frame render_layered(const SharedScene& shared, const std::vector<LayeredObject>& objects,
                     const LayeredSettings& settings, const GBuffer& view, LayeredBackend& backend) {
  Frame frame;
  frame.exitance.assign(view.points.size(), glm::vec3(0));
  for (std::size_t i = 0; i < objects.size(); ++i)
    ObjectRender(shared, objects[i], settings, view, static_cast<int>(i), frame).run(backend);
  return frame;
}

}  // namespace opaline
