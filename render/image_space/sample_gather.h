// The inner loop of image-space sampling: a sample set on one point's tangent plane, projected into the irradiance
// maps of one or several views and summed. Vectorised over samples.
//
// Several views. A surface point may be seen by more than one view; each view's samples are weighted by the balance
// heuristic over the area densities D_v(p) = (density of samples on the tangent plane) / J_v with which the views
// would have found p (0 where a view doesn't see p), so that every point any view sees counts once.
#pragma once

#include "render/image_space/irradiance_map.h"
#include "render/image_space/sample_set.h"

#include <span>

namespace opaline {

/// Orthonormal frame of a plane; turns as little as the normal does.
struct TangentFrame {
  glm::vec3 normal, tangent, bitangent;
};
TangentFrame tangent_frame(const glm::vec3& normal);

/// The normal, turned towards (or away from) the viewer until the cosine between them is at least min_cosine in size.
/// Any plane through the point will do, as the Jacobian knows which it is. On a plane seen edge-on, samples far apart
/// fall on the same surface near by: a few of them carry all the weight.
glm::vec3 turned_to(const glm::vec3& viewer, const glm::vec3& normal, float min_cosine);

struct SampleGather {
  static constexpr std::size_t max_views = 16;
  std::span<const IrradianceMap> views;
  ProfileSum profiles;
  SampleDensity density;       ///< of the set; used with several views
  bool jacobian = true;        ///< the maps are weighted
  bool count_valid = false;    ///< fill `valid`
  float min_plane_cosine = 0;  ///< see turned_to; 0: the tangent plane itself
  /// The profiles of the point's own material per channel, where it isn't the one that the sets follow: read in place
  /// of the tables, slower. Needs three irradiance channels. Equal channels may share one.
  const Profile* own[3] = {};
};

struct GatherResult {
  float sums[3] = {};   ///< per distinct profile (one irradiance channel), or per channel (three)
  float valid[3] = {};  ///< per distinct profile: shares of the samples that met the object, over all views
  std::uint64_t met = 0, lit = 0, looked_up = 0;  ///< samples that met the object; met light; whose profile was read
};

/// Adds to the result. All views have the same number of irradiance channels.
void gather_samples(const SampleGather& gather, const SampleSet& set, const glm::vec3& position,
                    const glm::vec3& normal, GatherResult& result);

}  // namespace opaline
