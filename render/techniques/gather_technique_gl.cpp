// brute_force and hierarchical on the GPU: the cluster tree as a buffer with skip pointers, a query per invocation.
#include "model/check.h"
#include "render/gl/profile_texture.h"
#include "render/techniques/gather_technique.h"

#include <algorithm>

namespace opaline {
namespace {

using gl::Buffer;
using Criterion = GatherSettings::Criterion;

/// As gather.comp reads it.
struct GlNode {
  glm::vec4 centroid, covariance, more;
  glm::uvec4 links;
};

std::vector<GlNode> gl_nodes(const ClusterTree& tree) {
  std::vector<GlNode> nodes;
  nodes.reserve(tree.nodes.size());
  for (const ClusterNode& n : tree.nodes) {
    const float* c = n.covariance;
    nodes.push_back({glm::vec4(n.centroid, n.extent.radius),
                     {c[0], c[1], c[2], c[3]},
                     {c[4], c[5], n.area, 0},
                     {n.skip, n.cell, 0, 0}});
  }
  return nodes;
}

std::vector<glm::vec4> gl_cells(const SurfaceCells& cells) {
  std::vector<glm::vec4> corners;
  corners.reserve(3 * cells.size());
  for (const SurfaceCell& cell : cells)
    for (const glm::vec3& p : {cell.a, cell.b, cell.c}) corners.emplace_back(p, 0);
  return corners;
}

struct GlObject {
  ChannelProfiles profiles;
  gl::ProfileTexture texture;
  std::unique_ptr<GatherSurface> surface;
  const ClusterTree& tree;
  Buffer nodes, mass, first_moment, cells;

  GlObject(const gl::Context& context, std::unique_ptr<GatherSurface> s, ChannelProfiles p, double r_max)
      : profiles(std::move(p)),
        texture(context, profiles, r_max),
        surface(std::move(s)),
        tree(surface->own.tree),
        nodes(context, gl_nodes(tree)),
        mass(context, tree.mass),
        first_moment(context, tree.first_moment),
        cells(context, gl_cells(*surface->cells)) {}
};

class GlGather : public PreparedTechnique {
 public:
  GlGather(const SharedScene& shared, const ProfileInfo& profile, const GatherChoice& choice,
           const gl::Context& context)
      : shared_(shared), settings_(choice.clusters), context_(context) {
    for (std::size_t i = 0; i < shared.scene.objects.size(); ++i) {
      const Object& object = shared.scene.objects[i];
      const double r_max = 1.01 * diameter(object.mesh);
      ChannelProfiles profiles(profile, shared.scene.materials[static_cast<std::size_t>(object.material)], r_max);
      auto surface = gather_surface(shared, i, profiles, choice, counters_);
      if (choice.discretisation_error > 0) error_ = std::max(error_, surface->own.error);
      objects_.push_back(std::make_unique<GlObject>(context, std::move(surface), std::move(profiles), r_max));
    }
  }

  Frame render(const GBuffer& view) const override {
    Frame frame;
    frame.counters = counters_;
    if (error_ >= 0) frame.estimates["discretisation_error"] = error_;
    frame.exitance.assign(view.points.size(), glm::vec3(0));
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      const ObjectPoints points = points_of_object(view, static_cast<int>(i));
      if (!points.indices.empty() && !objects_[i]->tree.nodes.empty()) gather(i, points, frame);
      frame.counters.done["queries"] += points.indices.size();
      frame.counters.done["channels"] += static_cast<std::uint64_t>(objects_[i]->profiles.distinct());
      frame.counters.skipped["equal_channels"] += 3 - static_cast<std::uint64_t>(objects_[i]->profiles.distinct());
      frame.counters.skipped["dark_cells"] += objects_[i]->tree.dark_cells;
    }
    return frame;
  }

 private:
  void gather(std::size_t i, const ObjectPoints& points, Frame& frame) const {
    const GlObject& object = *objects_[i];
    std::vector<glm::vec4> positions;
    for (const glm::vec3& p : points.positions) positions.emplace_back(p, 0);
    const Buffer queries(context_, positions), sums(context_, std::vector<glm::vec4>(positions.size(), glm::vec4(0)));
    const std::vector<glm::vec4> zeros(positions.size(), glm::vec4(0));
    const Buffer carries(context_, zeros), walks(context_, zeros);
    const Buffer* buffers[] = {&object.nodes, &object.mass, &object.first_moment, &object.cells, &queries, &sums,
                               &carries,      &walks};
    for (unsigned binding = 0; binding < 8; ++binding) buffers[binding]->bind_storage(binding);
    const gl::Program& program = program_for(object.tree.masses);
    object.texture.bind(program, 0);
    set_uniforms(program, object);
    frame.counters.done["dispatches"] += dispatch(program, positions.size());
    const std::vector<glm::vec4> result = sums.read<glm::vec4>();
    for (std::size_t k = 0; k < result.size(); ++k)
      for (int c = 0; c < 3; ++c) {
        const int s = object.tree.masses == 1 ? object.profiles.sum().table_of[c] : c;
        frame.exitance[points.indices[k]][c] = result[k][s] * static_cast<float>(shared_.irradiance[i].colour[c]);
      }
  }

  void set_uniforms(const gl::Program& program, const GlObject& object) const {
    program.set("node_count", static_cast<int>(object.tree.nodes.size()));
    program.set("tolerance", static_cast<float>(settings_.max_relative_error));
    program.set("quality", static_cast<float>(settings_.quality));
    program.set("core_squared", object.texture.core_squared());
    const int* table = object.profiles.sum().table_of;
    program.set("tables", glm::vec3(table[0], table[1], table[2]));
  }

  /// The shader for one mass or three, compiled when first needed.
  const gl::Program& program_for(int masses) const {
    std::unique_ptr<gl::Program>& program = programs_[masses == 3];
    if (program) return *program;
    const auto word = [](bool value) { return value ? "true;\n" : "false;\n"; };
    const std::string constants = "const int masses = " + std::to_string(masses) +
                                  ";\nconst bool clusters = " + word(settings_.criterion == Criterion::error) +
                                  "const bool solid_angle = " + word(settings_.criterion == Criterion::solid_angle);
    program = std::make_unique<gl::Program>(
        context_, std::vector<gl::Stage>{{gl::StageKind::compute,
                                          {{"constants", constants},
                                           gl::shader_file("render/gl/profile.glsl"),
                                           gl::shader_file("render/techniques/gather.comp")}}});
    return *program;
  }

  /// In parts of at most 1e9 steps, lest a driver thinks that the device hangs, each repeated until all its queries
  /// are through the tree; returns the number of dispatches.
  std::uint64_t dispatch(const gl::Program& program, std::size_t queries) const {
    constexpr std::size_t group = 64, steps = 4096, part = 1'000'000'000 / steps / group * group;
    std::uint64_t count = 0;
    program.set("steps", static_cast<int>(steps));
    for (std::size_t first = 0; first < queries; first += part) {
      const std::size_t last = std::min(first + part, queries);
      program.set("first_query", static_cast<int>(first));
      program.set("last_query", static_cast<int>(last));
      for (int unfinished = 1; unfinished > 0; ++count) {
        const Buffer progress(context_, std::vector<int>{0});
        progress.bind_storage(8);
        program.dispatch(static_cast<unsigned>((last - first + group - 1) / group));
        unfinished = progress.read<int>()[0];
      }
    }
    context_.check_errors();
    return count;
  }

  const SharedScene& shared_;
  GatherSettings settings_;
  const gl::Context& context_;
  Counters counters_;  ///< of the preparation
  double error_ = -1;  ///< estimated, of the discretisation; below 0: it wasn't looked at
  mutable std::unique_ptr<gl::Program> programs_[2];  ///< for one mass and for three
  std::vector<std::unique_ptr<GlObject>> objects_;
};

}  // namespace

std::unique_ptr<PreparedTechnique> prepare_gather_gl(const SharedScene& shared, const GatherChoice& choice,
                                                     const gl::Context& context) {
  const ProfileInfo* info = find_profile(choice.profile);
  OPALINE_CHECK(info);
  return std::make_unique<GlGather>(shared, *info, choice, context);
}

}  // namespace opaline
