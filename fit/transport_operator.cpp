#include "fit/transport_operator.h"

#include "fit/deposit.h"
#include "fit/softened_profile.h"
#include "model/check.h"
#include "model/fresnel.h"
#include "render/irradiance/gather.h"
#include "render/irradiance/profile_gather.h"
#include "render/stopwatch.h"
#include "render/techniques/technique.h"

#include <ceres/jet.h>
#include <tbb/parallel_for.h>

#include <array>

namespace opaline {
namespace {

constexpr std::uint32_t no_row = ~0u;

/// Queries that share a traversal: fewer cells are near for a small group, fewer walks for a large one.
constexpr std::size_t group_size = 32;

/// Clusters small against their distance, whatever the profile; near the core small against r_0.
struct OpeningCriterion {
  static constexpr float moments = 1;
  float opening_squared, core_squared;

  void begin_group(const glm::vec3&, float) {}
  bool acceptable(float distance, float radius) const {
    return radius * radius <= opening_squared * (distance * distance + core_squared);
  }
  bool accept(const ClusterNode& node, float distance, float group_radius) const {
    return acceptable(std::max(0.0f, distance - group_radius), node.extent.radius);
  }
  bool accept_part(const ClusterNode& leaf, float scale, float distance, float group_radius) const {
    return acceptable(std::max(0.0f, distance - group_radius), scale * leaf.extent.radius);
  }
  void use(const float*, float) {}
  std::array<float, 3> take_bound() { return {}; }
  void tighten(float) {}
};

/// Fills the operator's rows from the deposits of one query.
struct RowSink {
  using Patches = DepositList;

  TransportOperator& op;
  const ClusterTree& tree;
  const GBuffer& view;
  const std::vector<std::uint32_t>& point_of_query;  // index into view.points
  const std::vector<std::uint32_t>& row_of_point;
  std::span<const std::uint32_t> queries{};
  std::span<const glm::vec3> positions{};
  std::vector<float> accumulators{};  // query of the group, then as the operator's row

  std::size_t stride() const {
    return static_cast<std::size_t>(op.radial.size()) * static_cast<std::size_t>(tree.masses);
  }

  void begin_group(std::span<const std::uint32_t> group, std::span<const glm::vec3> at) {
    queries = group, positions = at;
    accumulators.assign(group.size() * stride(), 0.0f);
  }
  void add(const DepositList& list, std::size_t first, std::size_t count, const std::array<float, 3>&) {
    for (std::size_t i = first; i < first + count; ++i) {
      deposit_patches(op.radial, list.patches(), nullptr, positions[i], &accumulators[i * stride()]);
      deposit_parts(op.radial, tree, list, positions[i], &accumulators[i * stride()]);
    }
  }
  float end_group() {
    for (std::size_t i = 0; i < queries.size(); ++i) write_row(point_of_query[queries[i]], &accumulators[i * stride()]);
    return 0;
  }
  void write_row(std::uint32_t point, const float* sums) {
    const double cosine = static_cast<double>(view.points[point].cos_o);
    for (int k = 0; k < op.etas.size(); ++k) {
      const auto leaving =
          static_cast<float>(fresnel_transmittance(cosine, op.etas.etas()[static_cast<std::size_t>(k)]));
      for (int c = 0; c < op.light_channels; ++c) {
        float* out = &op.values[(row_of_point[point] * static_cast<std::size_t>(op.light_channels) +
                                 static_cast<std::size_t>(c)) *
                                    op.columns() +
                                static_cast<std::size_t>(k) * static_cast<std::size_t>(op.radial.size())];
        const float* in = sums + k * op.light_channels + c;
        for (int n = 0; n < op.radial.size(); ++n) out[n] = leaving * in[n * tree.masses];
      }
    }
  }
};

/// Objects of other materials still cast shadows but give no rows; their irradiance is not needed.
std::vector<bool> fitted_objects(const Scene& scene, int material, double& largest_diameter) {
  std::vector<bool> fitted;
  largest_diameter = 0;
  for (const Object& object : scene.objects) {
    fitted.push_back(object.material == material);
    if (fitted.back()) largest_diameter = std::max(largest_diameter, diameter(object.mesh));
  }
  return fitted;
}

std::vector<SurfaceCells> cells_of(const Scene& scene, const std::vector<bool>& fitted, std::size_t samples) {
  std::vector<SurfaceCells> cells = make_surface_cells(scene, samples);
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (!fitted[i]) cells[i].clear();
  return cells;
}

/// Gives every visible point that takes part a row, in scanline order.
std::vector<std::uint32_t> number_rows(const GBuffer& view, const std::vector<bool>& fitted,
                                       const std::vector<float>& mask, TransportOperator& op) {
  std::vector<std::uint32_t> row_of_point(view.points.size(), no_row);
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const VisiblePoint& p = view.points[i];
    if (!fitted[static_cast<std::size_t>(p.object)]) {
      ++op.counters.skipped["pixels_of_other_materials"];
    } else if (!mask.empty() && !(mask[p.pixel] > 0)) {
      ++op.counters.skipped["masked_pixels"];
    } else {
      row_of_point[i] = static_cast<std::uint32_t>(op.pixels.size());
      op.pixels.push_back(p.pixel);
    }
  }
  op.values.assign(op.rows() * static_cast<std::size_t>(op.light_channels) * op.columns(), 0.0f);
  return row_of_point;
}

/// The rows of one object.
void gather_rows(const GBuffer& view, int object, const SurfaceCells& cells, const IrradianceField& field,
                 const std::vector<std::uint32_t>& row_of_point, float opening, TransportOperator& op) {
  ObjectPoints points;
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    if (view.points[i].object != object || row_of_point[i] == no_row) continue;
    points.positions.push_back(view.points[i].position);
    points.indices.push_back(static_cast<std::uint32_t>(i));
  }
  const ClusterTree tree = build_cluster_tree(cells, field);
  op.counters.skipped["dark_cells"] += tree.dark_cells;
  const OpeningCriterion criterion{opening * opening, static_cast<float>(op.radial.x_0())};
  const GatherCounts counts = gather(
      tree, cells, points.positions, [&] { return criterion; },
      [&] {
        return RowSink{op, tree, view, points.indices, row_of_point};
      },
      group_size);
  op.counters.done["nodes_visited"] += counts.nodes_visited;
  op.counters.done["clusters"] += counts.clusters;
  op.counters.done["cells"] += counts.cells;
  op.counters.done["cell_parts"] += counts.cell_parts;
  op.counters.skipped["cell_splits_at_depth_limit"] += counts.depth_limit_reached;
}

}  // namespace

TransportOperator build_operator(const Scene& scene, int material, const EtaNodes& etas,
                                 const OperatorSettings& settings, const std::vector<float>& mask) {
  Stopwatch watch;
  double size = 0;
  const std::vector<bool> fitted = fitted_objects(scene, material, size);
  OPALINE_CHECK(size > 0);
  TransportOperator op{RadialBasis(settings.core_fraction * size, 1.01 * size, settings.spacing), etas};
  const RayScene rays(scene);
  const GBuffer view = make_gbuffer(scene, rays);
  op.width = view.width, op.height = view.height;
  op.counters = view.counters;
  const std::vector<SurfaceCells> cells =
      refine_at_light_edges(scene, rays, cells_of(scene, fitted, settings.samples), settings.irradiance, op.counters);
  const std::vector<std::vector<double>> eta_nodes(scene.objects.size(), etas.etas());
  const std::vector<IrradianceField> fields =
      compute_irradiance(scene, rays, cells, eta_nodes, settings.irradiance, op.counters);
  op.light_channels = fields.front().channels;
  op.colour = fields.front().colour;
  const std::vector<std::uint32_t> row_of_point = number_rows(view, fitted, mask, op);
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    if (fitted[i])
      gather_rows(view, static_cast<int>(i), cells[i], fields[i], row_of_point, static_cast<float>(settings.opening),
                  op);
  op.counters.done["rows"] += op.rows();
  op.counters.done["columns"] += op.columns();
  op.seconds = watch.lap();
  return op;
}

TransportOperator some_rows(const TransportOperator& op, const std::vector<float>& mask) {
  TransportOperator out = op;
  out.pixels.clear(), out.values.clear();
  const std::size_t length = op.columns() * static_cast<std::size_t>(op.light_channels);
  for (std::size_t p = 0; p < op.rows(); ++p) {
    if (!(mask[op.pixels[p]] > 0)) {
      ++out.counters.skipped["masked_pixels"];
      continue;
    }
    out.pixels.push_back(op.pixels[p]);
    out.values.insert(out.values.end(), op.row(p, 0), op.row(p, 0) + length);
  }
  out.counters.done["rows"] = out.rows();
  return out;
}

EtaFactors eta_factors(const TransportOperator& op, double eta) {
  using Dual = ceres::Jet<double, 1>;
  const Dual variable(eta, 0);
  const Dual scale = 1.0 / (pi * exit_lobe_normalisation(variable, op.lobe));
  EtaFactors out;
  for (const Dual& l : op.etas.basis(variable)) {
    out.value.push_back((scale * l).a);
    out.d_eta.push_back((scale * l).v[0]);
  }
  return out;
}

namespace {

std::vector<ProfileGradient> evaluated_coefficients(const TransportOperator& op, const ProfileInfo& profile,
                                                    const Medium<double>& medium) {
  const std::unique_ptr<Profile> formula = profile.make(medium);
  const SoftenedProfile visible(*formula, std::sqrt(op.radial.x_0()));
  std::vector<ProfileGradient> out;
  for (int n = 0; n < op.radial.size(); ++n) {
    const ProfileGradient g = visible.evaluate_with_gradient(op.radial.radius(n));
    const double w = op.radial.weight(n);
    out.push_back({w * g.value, w * g.d_sigma_a, w * g.d_sigma_s_prime, w * g.d_eta});
  }
  return out;
}

/// What the coefficients depend on, to the last bit.
struct CoefficientKey {
  std::unique_ptr<Profile> (*build)(const Medium<double>&, const ProfileParameters&) = nullptr;
  std::array<double, 6> numbers{};
  bool operator==(const CoefficientKey&) const = default;
};

/// The last media that this thread asked for: several views of one object, and a solver that looks at a point first and
/// then at its slope, want the same ones again.
class LastCoefficients {
 public:
  template <typename Make>
  const std::vector<ProfileGradient>& get(const CoefficientKey& key, const Make& make) {
    for (const Entry& e : entries_)
      if (e.key == key) return e.values;
    Entry& oldest = entries_[next_];
    next_ = (next_ + 1) % entries_.size();
    oldest.values = make();
    oldest.key = key;
    return oldest.values;
  }

 private:
  struct Entry {
    CoefficientKey key;
    std::vector<ProfileGradient> values;
  };
  std::array<Entry, 6> entries_;
  std::size_t next_ = 0;
};

}  // namespace

std::vector<ProfileGradient> radial_coefficients(const TransportOperator& op, const ProfileInfo& profile,
                                                 const Medium<double>& medium) {
  thread_local LastCoefficients last;
  const RadialBasis& r = op.radial;
  const CoefficientKey key{
      profile.build,
      {r.x_0(), r.spacing(), static_cast<double>(r.size()), medium.sigma_a, medium.sigma_s_prime, medium.eta}};
  return last.get(key, [&] { return evaluated_coefficients(op, profile, medium); });
}

ColumnCoefficients column_coefficients(const TransportOperator& op, const ProfileInfo& profile,
                                       const Medium<double>& medium, int channel) {
  EtaFactors factors = eta_factors(op, medium.eta);
  for (std::size_t k = 0; k < factors.value.size(); ++k) {
    factors.value[k] *= op.light_colour(channel);
    factors.d_eta[k] *= op.light_colour(channel);
  }
  const std::vector<ProfileGradient> radial = radial_coefficients(op, profile, medium);
  ColumnCoefficients out;
  for (std::vector<double>* v : {&out.value, &out.d_sigma_a, &out.d_sigma_s_prime, &out.d_eta})
    v->reserve(op.columns());
  for (std::size_t k = 0; k < factors.value.size(); ++k)
    for (const ProfileGradient& g : radial) {
      out.value.push_back(factors.value[k] * g.value);
      out.d_sigma_a.push_back(factors.value[k] * g.d_sigma_a);
      out.d_sigma_s_prime.push_back(factors.value[k] * g.d_sigma_s_prime);
      out.d_eta.push_back(factors.value[k] * g.d_eta + factors.d_eta[k] * g.value);
    }
  return out;
}

Image operator_image(const TransportOperator& op, const ProfileInfo& profile, const Material& material) {
  Image image(op.width, op.height, {"R", "G", "B", "A"});
  for (int c = 0; c < 3; ++c) {
    const std::vector<double> x = column_coefficients(op, profile, material.channel(c), c).value;
    tbb::parallel_for(std::size_t{0}, op.rows(), [&](std::size_t p) {
      const float* row = op.row(p, op.light_channel(c));
      double sum = 0;
      for (std::size_t j = 0; j < x.size(); ++j) sum += x[j] * static_cast<double>(row[j]);
      image.data[static_cast<std::size_t>(op.pixels[p]) * 4 + static_cast<std::size_t>(c)] = static_cast<float>(sum);
      image.data[static_cast<std::size_t>(op.pixels[p]) * 4 + 3] = 1;
    });
  }
  return image;
}

}  // namespace opaline
