#include "render/irradiance/profile_sum.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/irradiance/profile_sum.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/irradiance/two_points.h"

HWY_BEFORE_NAMESPACE();
namespace opaline::HWY_NAMESPACE {

/// ProfileTable::View for a vector of squared distances: the same bits, the same cubic.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V look_up(D d, const ProfileTable::View& table, V r2) {
  const hn::RebindToSigned<D> di;
  const auto bits = hn::BitCast(di, hn::Add(r2, hn::Set(d, table.offset)));
  const auto segment =
      hn::Min(hn::Sub(hn::ShiftRight<ProfileTable::segment_shift>(bits), hn::Set(di, table.first_segment)),
              hn::Set(di, table.last_segment));
  const auto mask = hn::Set(di, (1 << ProfileTable::segment_shift) - 1);
  const V f = hn::Mul(hn::ConvertTo(d, hn::And(bits, mask)), hn::Set(d, 1.0f / (1 << ProfileTable::segment_shift)));
  const auto at = hn::ShiftLeft<2>(segment);
  const V c0 = hn::GatherIndex(d, table.coefficients, at), c1 = hn::GatherIndex(d, table.coefficients + 1, at),
          c2 = hn::GatherIndex(d, table.coefficients + 2, at), c3 = hn::GatherIndex(d, table.coefficients + 3, at);
  return hn::MulAdd(hn::MulAdd(hn::MulAdd(c3, f, c2), f, c1), f, c0);
}

/// Calls add_block(begin, end) for blocks of patches: sums are float within a block and double from block to
/// block, or a million equal terms would drift by 1e-3.
template <typename AddBlock>
HWY_INLINE void for_blocks(std::size_t patches, AddBlock add_block) {
  constexpr std::size_t block = 64 * PatchList::lanes;
  for (std::size_t begin = 0; begin < patches; begin += block) add_block(begin, std::min(begin + block, patches));
}

template <int Tables>
HWY_INLINE void sum_single(const ProfileSum& profile, const PatchList& patches, const float* weight,
                           const glm::vec3& position, float* sums) {
  const hn::ScalableTag<float> d;
  using V = hn::Vec<decltype(d)>;
  ProfileTable::View tables[Tables];
  double total[Tables] = {};
  for (int t = 0; t < Tables; ++t) tables[t] = profile.tables[t]->view();
  for_blocks(patches.size(), [&](std::size_t begin, std::size_t end) HWY_ATTR {
    V sum[Tables];
    for (int t = 0; t < Tables; ++t) sum[t] = hn::Zero(d);
    for (std::size_t i = begin; i < end; i += hn::Lanes(d)) {
      const TwoPoints<V> q = two_points(d, patches, i, position);
      V half = hn::Mul(hn::Set(d, 0.5f), hn::LoadU(d, patches.mass() + i));
      if (weight) half = hn::Mul(half, hn::LoadU(d, weight + i));
      for (int t = 0; t < Tables; ++t)
        sum[t] = hn::MulAdd(half, hn::Add(look_up(d, tables[t], q.near), look_up(d, tables[t], q.far)), sum[t]);
    }
    for (int t = 0; t < Tables; ++t) total[t] += static_cast<double>(hn::GetLane(hn::SumOfLanes(d, sum[t])));
  });
  for (int t = 0; t < Tables; ++t) sums[t] += static_cast<float>(total[t]);
}

/// Three flux channels: each moves flux between the two points by its own first moment.
HWY_INLINE void sum_coloured(const ProfileSum& profile, const PatchList& patches, const float* weight,
                             const glm::vec3& position, float* sums) {
  const hn::ScalableTag<float> d;
  using V = hn::Vec<decltype(d)>;
  double total[3] = {};
  for_blocks(patches.size(), [&](std::size_t begin, std::size_t end) HWY_ATTR {
    V sum[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    for (std::size_t i = begin; i < end; i += hn::Lanes(d)) {
      const TwoPoints<V> q = two_points(d, patches, i, position);
      const V per_spread = hn::Div(hn::Set(d, 1.0f), hn::Add(q.spread, hn::Set(d, 1e-30f)));
      V mass[3], px[3], py[3], pz[3];
      hn::LoadInterleaved3(d, patches.mass() + 3 * i, mass[0], mass[1], mass[2]);
      hn::LoadInterleaved3(d, patches.first_moment(0) + 3 * i, px[0], px[1], px[2]);
      hn::LoadInterleaved3(d, patches.first_moment(1) + 3 * i, py[0], py[1], py[2]);
      hn::LoadInterleaved3(d, patches.first_moment(2) + 3 * i, pz[0], pz[1], pz[2]);
      for (int c = 0; c < 3; ++c) {
        const ProfileTable::View table = profile.tables[profile.table_of[c]]->view();
        const V near = look_up(d, table, q.near), far = look_up(d, table, q.far);
        const V along = hn::MulAdd(q.dx, px[c], hn::MulAdd(q.dy, py[c], hn::Mul(q.dz, pz[c])));
        V term = hn::Mul(hn::Mul(hn::Set(d, 0.5f), mass[c]), hn::Add(near, far));
        term = hn::MulAdd(hn::Mul(along, per_spread), hn::Sub(near, far), term);
        if (weight) term = hn::Mul(term, hn::LoadU(d, weight + i));
        sum[c] = hn::Add(sum[c], term);
      }
    }
    for (int c = 0; c < 3; ++c) total[c] += static_cast<double>(hn::GetLane(hn::SumOfLanes(d, sum[c])));
  });
  for (int c = 0; c < 3; ++c) sums[c] += static_cast<float>(total[c]);
}

void add_profile_sum(const ProfileSum& profile, const PatchList& patches, const float* weight,
                     const glm::vec3& position, float* sums) {
  if (patches.masses() == 3) return sum_coloured(profile, patches, weight, position, sums);
  if (profile.table_count == 1) return sum_single<1>(profile, patches, weight, position, sums);
  if (profile.table_count == 2) return sum_single<2>(profile, patches, weight, position, sums);
  sum_single<3>(profile, patches, weight, position, sums);
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace opaline {

HWY_EXPORT(add_profile_sum);

void add_profile_sum(const ProfileSum& profile, const PatchList& patches, const float* weight,
                     const glm::vec3& position, float* sums) {
  HWY_DYNAMIC_DISPATCH(add_profile_sum)(profile, patches, weight, position, sums);
}

}  // namespace opaline
#endif
