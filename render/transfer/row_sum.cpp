#include "render/transfer/row_sum.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/transfer/row_sum.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <hwy/cache_control.h>

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace opaline::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using RowD = hn::CappedTag<float, 16>;
using RowV = hn::Vec<RowD>;

/// Rows go together so many at a time, as the sum stays in a register meanwhile.
constexpr std::size_t together = 8;

struct FloatRow {
  using Item = float;
  static HWY_INLINE RowV load(const Item* row, const float*) { return hn::LoadU(RowD(), row); }
};

template <typename Integer>
struct IntegerRow {
  using Item = Integer;
  static HWY_INLINE RowV load(const Item* row, const float*) {
    const hn::Rebind<Integer, RowD> d;
    const hn::RebindToSigned<RowD> wide;
    return hn::ConvertTo(RowD(), hn::PromoteTo(wide, hn::LoadU(d, row)));
  }
};

struct CodeRow {
  using Item = std::uint8_t;
  static HWY_INLINE RowV load(const Item* row, const float* codebook) {
    const hn::Rebind<std::uint8_t, RowD> d;
    const hn::RebindToSigned<RowD> wide;
    return hn::GatherIndex(RowD(), codebook, hn::PromoteTo(wide, hn::LoadU(d, row)));
  }
};

/// What comes after the terms at work: lines of it are fetched while these are summed.
struct Ahead {
  const RowTerm* terms;
  std::size_t count;
};

template <class Row>
HWY_INLINE void fetch(const Ahead& ahead, std::size_t i) {
  constexpr std::size_t line = 64 / sizeof(typename Row::Item);
  if (i % line != 0) return;
  for (std::size_t k = 0; k < ahead.count; ++k)
    hwy::Prefetch(static_cast<const typename Row::Item*>(ahead.terms[k].row) + i);
}

template <class Row, std::size_t Count>
HWY_INLINE void add_some(const RowTerm* terms, const Ahead& ahead, std::size_t begin, std::size_t count, float* out) {
  const RowD d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    fetch<Row>(ahead, begin + i);
    RowV sum = hn::LoadU(d, out + i);
    for (std::size_t k = 0; k < Count; ++k)
      sum = hn::MulAdd(hn::Set(d, terms[k].weight),
                       Row::load(static_cast<const typename Row::Item*>(terms[k].row) + begin + i, terms[k].codebook),
                       sum);
    hn::StoreU(sum, d, out + i);
  }
}

template <class Row>
HWY_NOINLINE void add_all(std::span<const RowTerm> terms, std::size_t begin, std::size_t count, float* out,
                          std::span<const RowTerm> next) {
  std::size_t k = 0;
  const auto ahead = [&](std::size_t after) {
    const std::span<const RowTerm> rest = after < terms.size() ? terms.subspan(after) : next;
    return Ahead{rest.data(), std::min(rest.size(), together)};
  };
  for (; k + together <= terms.size(); k += together)
    add_some<Row, together>(&terms[k], ahead(k + together), begin, count, out);
  for (; k + 4 <= terms.size(); k += 4) add_some<Row, 4>(&terms[k], ahead(k + 4), begin, count, out);
  for (; k < terms.size(); ++k) add_some<Row, 1>(&terms[k], ahead(k + 1), begin, count, out);
}

void add_rows(RowStorage storage, std::span<const RowTerm> terms, std::size_t begin, std::size_t count, float* out,
              std::span<const RowTerm> next) {
  if (storage == RowStorage::f32) return add_all<FloatRow>(terms, begin, count, out, next);
  if (storage == RowStorage::i16) return add_all<IntegerRow<std::int16_t>>(terms, begin, count, out, next);
  if (storage == RowStorage::i8) return add_all<IntegerRow<std::int8_t>>(terms, begin, count, out, next);
  add_all<CodeRow>(terms, begin, count, out, next);
}

/// The colours of a vertex side by side.
HWY_INLINE void blend_vertex(const CornerBlend& blend, std::size_t i, float* out) {
  const hn::CappedTag<float, 4> d;
  const std::uint32_t* corner = blend.triangles + 3 * static_cast<std::size_t>(blend.triangle_of[i]);
  const float* at[3];
  for (std::size_t k = 0; k < 3; ++k) at[k] = blend.points + 4 * static_cast<std::size_t>(corner[k]);
  const float a = static_cast<float>(blend.weights[2 * i]) * (1 / CornerBlend::weight_unit),
              b = static_cast<float>(blend.weights[2 * i + 1]) * (1 / CornerBlend::weight_unit);
  for (std::size_t k = 0; k < 4; k += hn::Lanes(d)) {
    const auto third = hn::Mul(hn::Set(d, 1 - a - b), hn::LoadU(d, at[2] + k));
    const auto second = hn::MulAdd(hn::Set(d, b), hn::LoadU(d, at[1] + k), third);
    hn::StoreU(hn::MulAdd(hn::Set(d, a), hn::LoadU(d, at[0] + k), second), d, out + k);
  }
}

void add_blend(const CornerBlend& blend, std::size_t begin, std::size_t count, const std::array<float*, 3>& colour) {
  constexpr std::size_t some = 16;
  const RowD d;
  HWY_ALIGN float sum[4 * some];
  for (std::size_t first = 0; first < count; first += some) {
    for (std::size_t i = 0; i < some; ++i) blend_vertex(blend, begin + first + i, sum + 4 * i);
    for (std::size_t i = 0; i < some; i += hn::Lanes(d)) {
      RowV of[4];
      hn::LoadInterleaved4(d, sum + 4 * i, of[0], of[1], of[2], of[3]);
      for (std::size_t c = 0; c < 3; ++c) {
        float* to = colour[c] + first + i;
        const RowV most = hn::Mul(hn::Set(d, blend.correction), hn::Abs(of[c]));
        hn::StoreU(hn::Add(hn::Clamp(hn::LoadU(d, to), hn::Neg(most), most), of[c]), d, to);
      }
    }
  }
}

std::size_t store_exitance(const float* sum, float factor, std::size_t count, float* out) {
  const RowD d;
  const RowV zero = hn::Zero(d), times = hn::Set(d, factor);
  std::size_t negative = 0;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const RowV value = hn::Mul(times, hn::LoadU(d, sum + i));
    negative += hn::CountTrue(d, hn::Lt(value, zero));
    hn::StoreU(hn::Max(value, zero), d, out + i);
  }
  return negative;
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace opaline {

HWY_EXPORT(add_rows);
HWY_EXPORT(add_blend);
HWY_EXPORT(store_exitance);

std::size_t bytes_of(RowStorage storage) { return storage == RowStorage::f32 ? 4 : storage == RowStorage::i16 ? 2 : 1; }

void add_rows(RowStorage storage, std::span<const RowTerm> terms, std::size_t begin, std::size_t count, float* out,
              std::span<const RowTerm> next) {
  HWY_DYNAMIC_DISPATCH(add_rows)(storage, terms, begin, count, out, next);
}

void add_blend(const CornerBlend& blend, std::size_t begin, std::size_t count, const std::array<float*, 3>& colour) {
  HWY_DYNAMIC_DISPATCH(add_blend)(blend, begin, count, colour);
}

std::size_t store_exitance(const float* sum, float factor, std::size_t count, float* out) {
  return HWY_DYNAMIC_DISPATCH(store_exitance)(sum, factor, count, out);
}

}  // namespace opaline
#endif
