// The precomputed transfer of a scene's objects: what the techniques' CPU and GPU halves share.
#pragma once

#include "render/techniques/technique.h"
#include "render/transfer/encode.h"

namespace opaline {

class TransferFile;

enum class TransferForm { floats, vectors, lloyd, harmonics, references };

struct TransferSettings {
  std::string profile;
  TransferForm form = TransferForm::floats;
  int directions = 200, distances = 6, parts = 1;
  DirectionInterpolation interpolation = DirectionInterpolation::four;
  bool discs = false, any_light = false, fixed_view = false;
  double max_relative_error = 3e-3;
  int order = 0;               ///< 0: 7 for harmonics, 3 for reference points
  std::size_t references = 0;  ///< 0: 1.53 vertices^0.68
  ReferenceSelection reference_selection = ReferenceSelection::transfer;
  ReferenceWeights reference_weights = ReferenceWeights::least_squares;
  std::string file;  ///< empty: nothing is loaded or kept
};

/// About as many reference points as the paper's for each of its meshes (table I): 1034 of 14521 vertices, 12330 of
/// 543652.
std::size_t default_references(std::size_t vertices);

std::vector<SettingSpec> transfer_setting_specs();
TransferSettings read_transfer_settings(const Settings& settings);

struct TransferObject {
  TransferNodes nodes;
  TransferVertices vertices;
  EncodedTransfer transfer;
};

struct TransferScene {
  std::vector<TransferObject> objects;
  Counters counters;

  /// What lights the object, as its table sees it.
  std::vector<TransferLight> lights(const SharedScene& shared, std::size_t object) const;
};

/// Throws InputError for settings that don't go together.
TransferScene make_transfer_scene(const SharedScene& shared, const TransferSettings& settings);

/// The table itself, all nodes that the settings ask for, before it is encoded.
TransferTable make_object_table(const SharedScene& shared, const TransferSettings& settings, std::size_t object,
                                const TransferNodes& nodes, TransferVertices& vertices, Counters& counters,
                                TransferFile* file = nullptr);

/// Empty if every material and light of the scene has a place in a table.
std::string transfer_not_applicable(const Scene& scene);

/// The three numbers of an object's vertices and their weights for every visible point of it; InputError if the table
/// was made for another view.
struct PointPlaces {
  std::vector<std::uint32_t> indices;  ///< into view.points
  std::vector<TransferVertices::Place> places;
};
PointPlaces places_of_object(const SharedScene& shared, const TransferScene& transfer, const GBuffer& view,
                             std::size_t object);

/// B at a place, from that of vertices.
template <typename AtVertex>
glm::vec3 interpolated(const TransferVertices::Place& place, const AtVertex& at_vertex) {
  return place.weight.x * at_vertex(place.corner.x) + place.weight.y * at_vertex(place.corner.y) +
         place.weight.z * at_vertex(place.corner.z);
}

std::unique_ptr<PreparedTechnique> prepare_transfer_gl(const SharedScene& shared, const Settings& settings,
                                                       const gl::Context& context);

}  // namespace opaline
