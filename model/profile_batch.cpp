#include "model/profile_batch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "model/profile_batch.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/profile_table_kernel.h"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace opaline::HWY_NAMESPACE {

constexpr TableTag d;
using V = TableVector;

template <class Lookup, int Tables>
struct Batch {
  const Lookup& lookup;
  typename Lookup::Table tables[Tables];

  Batch(const Lookup& l, const ProfileTable* const* t) : lookup(l) {
    for (int i = 0; i < Tables; ++i) tables[i] = typename Lookup::Table(*t[i], i);
  }

  template <int Points>
  HWY_INLINE void at(const float* r2, V (&value)[Points][Tables]) const {
    typename Lookup::Place places[Points];
    for (int p = 0; p < Points; ++p)
      places[p] = lookup.place(hn::LoadU(d, r2 + static_cast<std::size_t>(p) * hn::Lanes(d)));
    lookup.values(tables, places, value);
  }

  HWY_NOINLINE void evaluate(const float* r2, std::size_t n, float* const* out) const {
    const std::size_t lanes = hn::Lanes(d);
    V value[1][Tables];
    std::size_t i = 0;
    for (; i + lanes <= n; i += lanes) {
      at(r2 + i, value);
      for (int t = 0; t < Tables; ++t) hn::StoreU(value[0][t], d, out[t] + i);
    }
    if (i == n) return;
    HWY_ALIGN float rest[hn::MaxLanes(d)] = {};
    std::copy(r2 + i, r2 + n, rest);
    at(rest, value);
    for (int t = 0; t < Tables; ++t) {
      hn::Store(value[0][t], d, rest);
      std::copy(rest, rest + (n - i), out[t] + i);
    }
  }

  HWY_NOINLINE void add(const float* r2, const float* weight, std::size_t n, double* total) const {
    const std::size_t lanes = hn::Lanes(d);
    V sum[Tables];
    for (V& s : sum) s = hn::Zero(d);
    for (std::size_t i = 0; i < n; i += 2 * lanes) {
      V value[2][Tables];
      at(r2 + i, value);
      const V near = hn::LoadU(d, weight + i), far = hn::LoadU(d, weight + i + lanes);
      for (int t = 0; t < Tables; ++t) sum[t] = hn::MulAdd(near, value[0][t], hn::MulAdd(far, value[1][t], sum[t]));
    }
    for (int t = 0; t < Tables; ++t) total[t] += static_cast<double>(hn::GetLane(hn::SumOfLanes(d, sum[t])));
  }

  /// Whole blocks in place, the rest padded with terms of no weight.
  HWY_INLINE void sum(const float* r2, const float* weight, std::size_t n, double* total) const {
    constexpr std::size_t block = 512;
    std::size_t i = 0;
    for (; i + block <= n; i += block) add(r2 + i, weight + i, block, total);
    if (i == n) return;
    HWY_ALIGN float rest[block] = {}, rest_weight[block] = {};
    std::copy(r2 + i, r2 + n, rest);
    std::copy(weight + i, weight + n, rest_weight);
    add(rest, rest_weight, block, total);
  }
};

/// Calls use(batch) for the number of tables there is.
template <class Lookup, typename Use>
HWY_INLINE void with_batch(const Lookup& lookup, const ProfileTable* const* tables, int count, const Use& use) {
  if (count == 1) return use(Batch<Lookup, 1>(lookup, tables));
  if (count == 2) return use(Batch<Lookup, 2>(lookup, tables));
  use(Batch<Lookup, 3>(lookup, tables));
}

void evaluate_tables(const ProfileTable* const* tables, int count, const float* r2, std::size_t n, float* const* out) {
  with_lookup(tables, count, [&](const auto& lookup) HWY_ATTR {
    with_batch(lookup, tables, count, [&](const auto& batch) HWY_ATTR { batch.evaluate(r2, n, out); });
  });
}

void sum_tables(const ProfileTable* const* tables, int count, const float* r2, const float* weight, std::size_t n,
                double* sums) {
  with_lookup(tables, count, [&](const auto& lookup) HWY_ATTR {
    with_batch(lookup, tables, count, [&](const auto& batch) HWY_ATTR { batch.sum(r2, weight, n, sums); });
  });
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace opaline {

HWY_EXPORT(evaluate_tables);
HWY_EXPORT(sum_tables);

void evaluate_tables(const ProfileTable* const* tables, int count, const float* r2, std::size_t n, float* const* out) {
  HWY_DYNAMIC_DISPATCH(evaluate_tables)(tables, count, r2, n, out);
}

void sum_tables(const ProfileTable* const* tables, int count, const float* r2, const float* weight, std::size_t n,
                double* sums) {
  HWY_DYNAMIC_DISPATCH(sum_tables)(tables, count, r2, weight, n, sums);
}

}  // namespace opaline
#endif
