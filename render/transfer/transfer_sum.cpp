#include "render/transfer/transfer_sum.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/transfer/transfer_sum.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/profile_table_kernel.h"
#include "render/irradiance/two_points.h"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace opaline::HWY_NAMESPACE {

using D = TableTag;
using V = TableVector;

/// So many patches that their fluxes stay in the second cache from query to query.
constexpr std::size_t transfer_block = 4 * PatchList::lanes;

template <class Lookup, int Tables>
struct TransferSum {
  static constexpr D d{};
  const Lookup& lookup;
  const TransferTree& tree;
  const PatchList& patches;
  typename Lookup::Table tables[Tables];

  /// What a patch's flux and first moments are multiplied by.
  struct Factors {
    HWY_ALIGN float of[Tables][4][transfer_block];
  };

  /// The share of its node that each patch of a block is.
  void find_shares(std::size_t begin, std::size_t count, float* share) const {
    for (std::size_t i = 0; i < count; ++i) {
      const float whole = tree.tree().mass[patches.nodes()[begin + i]];
      share[i] = whole > 0 ? patches.mass()[begin + i] / whole : 0;
    }
  }

  HWY_INLINE void find_factors(std::size_t begin, std::size_t count, const glm::vec3& position, const float* share,
                               Factors& f) const {
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
      const TwoPoints<V> q = two_points(d, patches, begin + i, position);
      const typename Lookup::Place places[2] = {lookup.place(q.near), lookup.place(q.far)};
      V value[2][Tables];
      lookup.values(tables, places, value);
      const V fraction = hn::Load(d, share + i), at_near = hn::Add(hn::Set(d, 0.5f), q.tilt);
      const V per_spread = hn::Div(fraction, q.spread);
      for (int t = 0; t < Tables; ++t) {
        const V step = hn::Sub(value[0][t], value[1][t]), along = hn::Mul(step, per_spread);
        hn::Store(hn::Mul(fraction, hn::MulAdd(at_near, step, value[1][t])), d, f.of[t][0] + i);
        hn::Store(hn::Mul(along, q.dx), d, f.of[t][1] + i);
        hn::Store(hn::Mul(along, q.dy), d, f.of[t][2] + i);
        hn::Store(hn::Mul(along, q.dz), d, f.of[t][3] + i);
      }
    }
  }

  /// However the gather cut the own element: the parts' shares add up to 1.
  void put_own(std::size_t begin, std::size_t count, const OwnDisc& own, const float* share, Factors& f) const {
    const std::uint32_t* nodes = patches.nodes() + begin;
    for (std::size_t i = 0; i < count; ++i)
      if (nodes[i] == own.node)
        for (int t = 0; t < Tables; ++t) f.of[t][0][i] = share[i] * own.mean[static_cast<std::size_t>(t)];
  }

  HWY_INLINE void add_products(std::size_t begin, std::size_t count, const Factors& f, float* sums) const {
    const std::size_t lanes = hn::Lanes(d);
    for (std::size_t k = 0; k < transfer_columns; k += 2 * lanes) {
      V sum[Tables][2];
      for (int t = 0; t < Tables; ++t)
        for (std::size_t h = 0; h < 2; ++h)
          sum[t][h] = hn::LoadU(d, sums + static_cast<std::size_t>(t) * transfer_columns + k + h * lanes);
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t node = patches.nodes()[begin + i];
        const float *mass = tree.mass(node) + k, *moments = tree.moments(node);
        add_row(mass, f, 0, i, sum);
        for (std::size_t axis = 0; moments && axis < 3; ++axis)
          add_row(moments + axis * transfer_columns + k, f, axis + 1, i, sum);
      }
      for (int t = 0; t < Tables; ++t)
        for (std::size_t h = 0; h < 2; ++h)
          hn::StoreU(sum[t][h], d, sums + static_cast<std::size_t>(t) * transfer_columns + k + h * lanes);
    }
  }

  HWY_INLINE void add_row(const float* row, const Factors& f, std::size_t which, std::size_t i,
                          V (&sum)[Tables][2]) const {
    const V first = hn::LoadU(d, row), second = hn::LoadU(d, row + hn::Lanes(d));
    for (int t = 0; t < Tables; ++t) {
      const V factor = hn::Set(d, f.of[t][which][i]);
      sum[t][0] = hn::MulAdd(factor, first, sum[t][0]);
      sum[t][1] = hn::MulAdd(factor, second, sum[t][1]);
    }
  }

  void run(std::span<const glm::vec3> positions, std::span<const OwnDisc> own, float* sums) const {
    HWY_ALIGN float share[transfer_block];
    Factors factors;
    for (std::size_t begin = 0; begin < patches.size(); begin += transfer_block) {
      const std::size_t count = std::min(transfer_block, patches.size() - begin);
      std::fill_n(share, transfer_block, 0.0f);
      find_shares(begin, count, share);
      for (std::size_t q = 0; q < positions.size(); ++q) {
        find_factors(begin, count, positions[q], share, factors);
        if (!own.empty()) put_own(begin, count, own[q], share, factors);
        add_products(begin, count, factors, sums + q * Tables * transfer_columns);
      }
    }
  }
};

template <int Tables, class Lookup>
HWY_NOINLINE void run_transfer_sum(const Lookup& lookup, const ProfileSum& profile, const TransferTree& tree,
                                   const PatchList& patches, std::span<const glm::vec3> positions,
                                   std::span<const OwnDisc> own, float* sums) {
  TransferSum<Lookup, Tables> sum{lookup, tree, patches, {}};
  for (int t = 0; t < Tables; ++t) sum.tables[t] = typename Lookup::Table(*profile.tables[t], t);
  sum.run(positions, own, sums);
}

void add_transfer_sums(const ProfileSum& profile, const TransferTree& tree, const PatchList& patches,
                       std::span<const glm::vec3> positions, std::span<const OwnDisc> own, float* sums) {
  with_lookup(profile.tables, profile.table_count, [&]<class Lookup>(const Lookup& lookup) HWY_ATTR {
    if (profile.table_count == 1) return run_transfer_sum<1>(lookup, profile, tree, patches, positions, own, sums);
    if (profile.table_count == 2) return run_transfer_sum<2>(lookup, profile, tree, patches, positions, own, sums);
    run_transfer_sum<3>(lookup, profile, tree, patches, positions, own, sums);
  });
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace opaline {

HWY_EXPORT(add_transfer_sums);

void add_transfer_sums(const ProfileSum& profile, const TransferTree& tree, const PatchList& patches,
                       std::span<const glm::vec3> positions, std::span<const OwnDisc> own, float* sums) {
  HWY_DYNAMIC_DISPATCH(add_transfer_sums)(profile, tree, patches, positions, own, sums);
}

}  // namespace opaline
#endif
