#include "render/transfer/transfer_scene.h"

#include "model/check.h"
#include "render/input_error.h"
#include "render/transfer/transfer_file.h"
#include "render/visibility/convexity.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace opaline {
namespace {

bool harmonic(const TransferSettings& s) {
  return s.form == TransferForm::harmonics || s.form == TransferForm::references;
}

/// Nodes that the lights may need; ascending.
std::vector<std::uint32_t> needed_nodes(const Scene& scene, const TransferSettings& settings,
                                        const TransferNodes& nodes, const std::vector<TransferLight>& lights) {
  std::set<std::uint32_t> needed, levels;
  for (const KeyWeight& w : node_weights(lights, nodes)) {
    needed.insert(w.key);
    levels.insert(w.key / nodes.per_level());
  }
  if (!settings.any_light && !harmonic(settings)) return {needed.begin(), needed.end()};
  if (settings.any_light) {
    const bool points = std::any_of(scene.lights.begin(), scene.lights.end(),
                                    [](const Light& l) { return std::holds_alternative<PointLight>(l); });
    for (int level = 0; level < (points ? nodes.levels : 1); ++level) levels.insert(static_cast<std::uint32_t>(level));
  }
  std::vector<std::uint32_t> all;
  for (const std::uint32_t level : levels)
    for (std::uint32_t d = 0; d < nodes.per_level(); ++d) all.push_back(level * nodes.per_level() + d);
  return all;
}

std::vector<std::uint32_t> keys_of(const std::vector<std::uint32_t>& nodes, bool vectors) {
  if (!vectors) return nodes;
  std::vector<std::uint32_t> keys;
  for (const std::uint32_t node : nodes) keys.insert(keys.end(), {3 * node, 3 * node + 1, 3 * node + 2});
  return keys;
}

/// The object's share of the scene's surface cells. (No cell is left larger than the parts its vertices stand on.)
std::size_t cell_count(const SharedScene& shared, std::size_t object) {
  double all = 0;
  for (const Object& o : shared.scene.objects) all += surface_area(o.mesh);
  return static_cast<std::size_t>(std::lround(static_cast<double>(shared.settings.samples) *
                                              surface_area(shared.scene.objects[object].mesh) / all));
}

std::vector<std::pair<std::uint32_t, glm::vec3>> seen_points(const GBuffer& view, std::size_t object) {
  std::vector<std::pair<std::uint32_t, glm::vec3>> points;
  for (const VisiblePoint& p : view.points)
    if (p.object == static_cast<std::int32_t>(object)) points.emplace_back(p.triangle, p.position);
  return points;
}

/// Everything that the values of an object's table depend on.
std::uint64_t table_key(const Scene& scene, const TransferSettings& s, const TransferWork& work,
                        const std::vector<std::uint32_t>& keys) {
  TransferKey key;
  for (const Object& object : scene.objects)  // all of them cast shadows
    key.add(object.mesh.positions).add(object.mesh.normals).add(object.mesh.triangles);
  for (int c = 0; c < 3; ++c)
    key.add_number(work.profiles.profile(c).evaluate(0)).add_number(work.profiles.profile(c).total());
  key.add_text(s.profile).add_number(work.eta).add_number(s.max_relative_error).add_number(s.discs);
  key.add_number(s.directions).add_number(s.distances).add_number(work.columns.vectors);
  key.add_number(static_cast<double>(work.elements.cells.size()));
  key.add(std::vector<glm::vec3>(work.positions.begin(), work.positions.end())).add(keys);
  return key.value();
}

EncodedTransfer encode(TransferTable table, const TransferNodes& nodes, const TransferVertices& vertices,
                       const TransferSettings& s) {
  if (s.form == TransferForm::harmonics) return encode_harmonics(table, nodes, s.order);
  // An object that nobody sees has no vertex, so it has no points either.
  if (s.form == TransferForm::references && table.vertices > 0)
    return encode_references(table, nodes, vertices,
                             {.points = s.references ? s.references : default_references(table.vertices),
                              .selection = s.reference_selection,
                              .weights = s.reference_weights,
                              .order = s.order});
  return encode_rows(std::move(table), s.form == TransferForm::lloyd ? RowStorage::code8 : RowStorage::f32);
}

}  // namespace

std::size_t default_references(std::size_t vertices) {
  return static_cast<std::size_t>(std::lround(1.53 * std::pow(static_cast<double>(vertices), 0.68)));
}

TransferTable make_object_table(const SharedScene& shared, const TransferSettings& s, std::size_t i,
                                const TransferNodes& nodes, TransferVertices& vertices, Counters& counters,
                                TransferFile* file) {
  const Scene& scene = shared.scene;
  const Object& object = scene.objects[i];
  const Material& material = scene.materials[static_cast<std::size_t>(object.material)];
  const ProfileInfo* info = find_profile(s.profile);
  OPALINE_CHECK(info);
  const TransferElements elements =
      s.discs ? disc_elements(vertices)
              : cell_elements(object.mesh, std::max(cell_count(shared, i), vertices.triangles.size()));
  std::vector<std::uint32_t> own(vertices.size());
  std::iota(own.begin(), own.end(), 0u);
  const std::size_t whole = vertices.size();
  if (s.fixed_view) {
    own = vertices.keep_only(object.mesh, seen_points(shared.view, i));
    counters.skipped["unseen_vertices"] += whole - own.size();
  }
  const ChannelProfiles profiles(*info, material, 1.01 * diameter(object.mesh));
  const std::vector<TransferLight> lights = transfer_lights(scene, nodes, shared.settings.irradiance.area_samples);
  const std::vector<std::uint32_t> needed = needed_nodes(scene, s, nodes, lights);
  counters.done["elements"] += elements.cells.size();
  counters.done["vertices"] += vertices.size();
  counters.done["light_nodes"] += needed.size();
  counters.skipped["light_nodes_no_light_needs"] += nodes.count() - needed.size();
  counters.skipped["equal_profiles"] += 3 - static_cast<std::uint64_t>(profiles.distinct());
  const TransferWork work{shared.rays,
                          nothing_in_shadow(scene),
                          material.eta,
                          elements,
                          profiles,
                          {nodes, s.form == TransferForm::vectors},
                          vertices.positions,
                          own,
                          s.max_relative_error};
  std::vector<std::uint32_t> keys = keys_of(needed, work.columns.vectors);
  const auto count = static_cast<double>(scene.objects.size());
  const TransferStore store = file ? file->store(i, table_key(scene, s, work, keys)) : TransferStore{};
  return make_transfer_table(work, std::move(keys), store, static_cast<double>(i) / count,
                             static_cast<double>(i + 1) / count, counters);
}

TransferScene make_transfer_scene(const SharedScene& shared, const TransferSettings& s) {
  TransferScene result;
  const auto file = s.file.empty() ? nullptr : std::make_unique<TransferFile>(s.file);
  for (std::size_t i = 0; i < shared.scene.objects.size(); ++i) {
    const Mesh& mesh = shared.scene.objects[i].mesh;
    TransferNodes nodes = transfer_nodes(mesh, s.directions, s.distances, s.interpolation);
    TransferVertices vertices(mesh, s.parts);
    TransferTable table = make_object_table(shared, s, i, nodes, vertices, result.counters, file.get());
    EncodedTransfer transfer = encode(std::move(table), nodes, vertices, s);
    result.objects.push_back({std::move(nodes), std::move(vertices), std::move(transfer)});
  }
  if (file) file->finish();
  return result;
}

std::vector<TransferLight> TransferScene::lights(const SharedScene& shared, std::size_t object) const {
  return transfer_lights(shared.scene, objects[object].nodes, shared.settings.irradiance.area_samples);
}

std::string transfer_not_applicable(const Scene& scene) { return transfer_lights_not_applicable(scene); }

PointPlaces places_of_object(const SharedScene& shared, const TransferScene& transfer, const GBuffer& view,
                             std::size_t object) {
  PointPlaces result;
  const Mesh& mesh = shared.scene.objects[object].mesh;
  for (std::uint32_t i = 0; i < view.points.size(); ++i) {
    const VisiblePoint& p = view.points[i];
    if (p.object != static_cast<std::int32_t>(object)) continue;
    result.indices.push_back(i);
    result.places.push_back(transfer.objects[object].vertices.at(mesh, p.triangle, p.position));
    if (result.places.back().corner.x == TransferVertices::none)
      throw InputError("--set view", "", "view=fixed: the table was made for another camera; take view=any");
  }
  return result;
}

}  // namespace opaline
