#include "render/irradiance/profile_sum.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/irradiance/profile_sum.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/profile_table_kernel.h"
#include "render/irradiance/two_points.h"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace opaline::HWY_NAMESPACE {

using D = TableTag;
using V = TableVector;

/// Patches go in blocks. Sums are float within a block and double from block to block (a million equal terms would
/// drift by 1e-3); the block, its points and the tables stay in the first cache from query to query; and finding all
/// points before the first look-up keeps more of the processor busy than going from patch to patch.
constexpr std::size_t block = 32 * PatchList::lanes;

struct Points {
  HWY_ALIGN float near[block], far[block], share_of_near[block];
  HWY_ALIGN float dx[block], dy[block], dz[block], per_spread[block];  // only for several flux channels
};

template <class Lookup>
struct Sum {
  static constexpr D d{};
  const Lookup& lookup;
  const PatchList& patches;
  const float* weight;                        // of every patch, or null
  const std::vector<std::uint32_t>* skipped;  // of every query, or null
  typename Lookup::Table tables[3];

  template <bool Moments>
  HWY_INLINE void find_points(std::size_t begin, std::size_t count, const glm::vec3& position, Points& p) const {
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
      const TwoPoints<V> q = two_points(d, patches, begin + i, position);
      hn::Store(q.near, d, p.near + i);
      hn::Store(q.far, d, p.far + i);
      hn::Store(hn::Add(hn::Set(d, 0.5f), q.tilt), d, p.share_of_near + i);
      if (!Moments) continue;
      hn::Store(q.dx, d, p.dx + i);
      hn::Store(q.dy, d, p.dy + i);
      hn::Store(q.dz, d, p.dz + i);
      hn::Store(hn::Div(hn::Set(d, 1.0f), q.spread), d, p.per_spread + i);
    }
  }

  template <int Tables>
  HWY_INLINE void look_up(const Points& p, std::size_t i, V (&value)[2][Tables]) const {
    const typename Lookup::Place places[2] = {lookup.place(hn::Load(d, p.near + i)),
                                              lookup.place(hn::Load(d, p.far + i))};
    lookup.values(tables, places, value);
  }

  static HWY_INLINE V weighted(V flux, const float* weights, std::size_t i) {
    return weights ? hn::Mul(flux, hn::LoadU(d, weights + i)) : flux;
  }

  /// The weights of a block for a query whose next skipped patch is `next`; null if all are 1.
  HWY_INLINE const float* block_weights(std::size_t begin, std::size_t count, std::size_t query, std::size_t& next,
                                        float* buffer) const {
    if (weight) return weight + begin;
    if (!skipped || next == skipped[query].size() || skipped[query][next] >= begin + count) return nullptr;
    std::fill_n(buffer, block, 1.0f);
    for (; next < skipped[query].size() && skipped[query][next] < begin + count; ++next)
      buffer[skipped[query][next] - begin] = 0;
    return buffer;
  }

  /// Flux of one channel, any number of tables.
  template <int Tables>
  HWY_INLINE void add_single(std::size_t begin, std::size_t count, const glm::vec3& position, const float* weights,
                             double* total) const {
    Points p;
    find_points<false>(begin, count, position, p);
    V sum[Tables];
    for (V& s : sum) s = hn::Zero(d);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
      V value[2][Tables];
      look_up(p, i, value);
      const V mass = weighted(hn::LoadU(d, patches.mass() + begin + i), weights, i);
      const V at_near = hn::Mul(mass, hn::Load(d, p.share_of_near + i)), at_far = hn::Sub(mass, at_near);
      for (int t = 0; t < Tables; ++t)
        sum[t] = hn::MulAdd(at_near, value[0][t], hn::MulAdd(at_far, value[1][t], sum[t]));
    }
    for (int t = 0; t < Tables; ++t) total[t] += static_cast<double>(hn::GetLane(hn::SumOfLanes(d, sum[t])));
  }

  /// Three flux channels: each moves flux between the two points by its own first moment.
  HWY_INLINE void add_coloured(std::size_t begin, std::size_t count, const glm::vec3& position, const float* weights,
                               double* total) const {
    Points p;
    find_points<true>(begin, count, position, p);
    V sum[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
      V value[2][3], mass[3], px[3], py[3], pz[3];
      look_up(p, i, value);
      const std::size_t at = 3 * (begin + i);
      hn::LoadInterleaved3(d, patches.mass() + at, mass[0], mass[1], mass[2]);
      hn::LoadInterleaved3(d, patches.first_moment(0) + at, px[0], px[1], px[2]);
      hn::LoadInterleaved3(d, patches.first_moment(1) + at, py[0], py[1], py[2]);
      hn::LoadInterleaved3(d, patches.first_moment(2) + at, pz[0], pz[1], pz[2]);
      const V dx = hn::Load(d, p.dx + i), dy = hn::Load(d, p.dy + i), dz = hn::Load(d, p.dz + i);
      const V per_spread = hn::Load(d, p.per_spread + i);
      for (int c = 0; c < 3; ++c) {
        const V near = value[0][c], far = value[1][c];
        const V along = hn::MulAdd(dx, px[c], hn::MulAdd(dy, py[c], hn::Mul(dz, pz[c])));
        const V at_near = hn::MulAdd(mass[c], hn::Load(d, p.share_of_near + i), hn::Mul(along, per_spread));
        const V term = hn::MulAdd(at_near, hn::Sub(near, far), hn::Mul(mass[c], far));
        sum[c] = hn::Add(sum[c], weighted(term, weights, i));
      }
    }
    for (int c = 0; c < 3; ++c) total[c] += static_cast<double>(hn::GetLane(hn::SumOfLanes(d, sum[c])));
  }

  /// All queries against one block of patches before the next: lists longer than the cache are read once.
  template <typename AddBlock>
  HWY_INLINE void for_blocks(std::span<const glm::vec3> positions, std::array<float, 3>* sums,
                             AddBlock add_block) const {
    constexpr std::size_t queries = 64;
    HWY_ALIGN float buffer[block];
    for (std::size_t first = 0; first < positions.size(); first += queries) {
      const std::size_t together = std::min(queries, positions.size() - first);
      double total[queries][3] = {};
      std::size_t next[queries] = {};
      for (std::size_t begin = 0; begin < patches.size(); begin += block) {
        const std::size_t count = std::min(block, patches.size() - begin);
        for (std::size_t q = 0; q < together; ++q)
          add_block(begin, count, positions[first + q], block_weights(begin, count, first + q, next[q], buffer),
                    total[q]);
      }
      for (std::size_t q = 0; q < together; ++q)
        for (std::size_t c = 0; c < 3; ++c) sums[first + q][c] += static_cast<float>(total[q][c]);
    }
  }
};

template <int Tables, class Lookup>
HWY_NOINLINE void sum_single(const Sum<Lookup>& sum, std::span<const glm::vec3> positions, std::array<float, 3>* sums) {
  sum.for_blocks(
      positions, sums,
      [&](std::size_t begin, std::size_t count, const glm::vec3& position, const float* weights, double* total)
          HWY_ATTR { sum.template add_single<Tables>(begin, count, position, weights, total); });
}

template <class Lookup>
HWY_NOINLINE void sum_coloured(const Sum<Lookup>& sum, std::span<const glm::vec3> positions,
                               std::array<float, 3>* sums) {
  sum.for_blocks(positions, sums,
                 [&](std::size_t begin, std::size_t count, const glm::vec3& position, const float* weights,
                     double* total) HWY_ATTR { sum.add_coloured(begin, count, position, weights, total); });
}

void add_profile_sums(const ProfileSum& profile, const PatchList& patches, const float* weight,
                      const std::vector<std::uint32_t>* skipped, std::span<const glm::vec3> positions,
                      std::array<float, 3>* sums) {
  with_lookup(profile.tables, profile.table_count, [&]<class Lookup>(const Lookup& lookup) HWY_ATTR {
    Sum<Lookup> sum{lookup, patches, weight, skipped, {}};
    const bool coloured = patches.masses() == 3;
    for (int i = 0; i < (coloured ? 3 : profile.table_count); ++i) {
      const int t = coloured ? profile.table_of[i] : i;
      sum.tables[i] = typename Lookup::Table(*profile.tables[t], t);
    }
    if (coloured) return sum_coloured(sum, positions, sums);
    if (profile.table_count == 1) return sum_single<1>(sum, positions, sums);
    if (profile.table_count == 2) return sum_single<2>(sum, positions, sums);
    sum_single<3>(sum, positions, sums);
  });
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace opaline {

HWY_EXPORT(add_profile_sums);

void add_profile_sums(const ProfileSum& profile, const PatchList& patches, const float* weight,
                      std::span<const glm::vec3> positions, std::array<float, 3>* sums) {
  HWY_DYNAMIC_DISPATCH(add_profile_sums)(profile, patches, weight, nullptr, positions, sums);
}

void add_profile_sums(const ProfileSum& profile, const PatchList& patches, std::span<const glm::vec3> positions,
                      const std::vector<std::uint32_t>* skipped, std::array<float, 3>* sums) {
  HWY_DYNAMIC_DISPATCH(add_profile_sums)(profile, patches, nullptr, skipped, positions, sums);
}

}  // namespace opaline
#endif
