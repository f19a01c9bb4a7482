#include "render/transfer/row_sum.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/transfer/row_sum.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

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

template <class Row, std::size_t Count>
HWY_INLINE void add_some(const RowTerm* terms, std::size_t begin, std::size_t end, float* out) {
  const RowD d;
  for (std::size_t i = begin; i < end; i += hn::Lanes(d)) {
    RowV sum = hn::LoadU(d, out + i);
    for (std::size_t k = 0; k < Count; ++k)
      sum = hn::MulAdd(hn::Set(d, terms[k].weight),
                       Row::load(static_cast<const typename Row::Item*>(terms[k].row) + i, terms[k].codebook), sum);
    hn::StoreU(sum, d, out + i);
  }
}

template <class Row>
HWY_NOINLINE void add_all(std::span<const RowTerm> terms, std::size_t begin, std::size_t end, float* out) {
  std::size_t k = 0;
  for (; k + together <= terms.size(); k += together) add_some<Row, together>(&terms[k], begin, end, out);
  for (; k + 4 <= terms.size(); k += 4) add_some<Row, 4>(&terms[k], begin, end, out);
  for (; k < terms.size(); ++k) add_some<Row, 1>(&terms[k], begin, end, out);
}

void add_rows(RowStorage storage, std::span<const RowTerm> terms, std::size_t begin, std::size_t end, float* out) {
  if (storage == RowStorage::f32) return add_all<FloatRow>(terms, begin, end, out);
  if (storage == RowStorage::i16) return add_all<IntegerRow<std::int16_t>>(terms, begin, end, out);
  if (storage == RowStorage::i8) return add_all<IntegerRow<std::int8_t>>(terms, begin, end, out);
  add_all<CodeRow>(terms, begin, end, out);
}

/// One vertex a step, its colours side by side: the three corners of a triangle lie together.
void add_blend(const CornerBlend& blend, std::size_t begin, std::size_t end, float* red, float* green, float* blue) {
  const hn::CappedTag<float, 4> d;
  HWY_ALIGN float sum[4];
  for (std::size_t i = begin; i < end; ++i) {
    const float* corner = blend.corners + 12 * static_cast<std::size_t>(blend.triangle[i]);
    const float a = static_cast<float>(blend.weights[2 * i]) * (1 / CornerBlend::weight_unit),
                b = static_cast<float>(blend.weights[2 * i + 1]) * (1 / CornerBlend::weight_unit);
    for (std::size_t k = 0; k < 4; k += hn::Lanes(d)) {
      const auto third = hn::Mul(hn::Set(d, 1 - a - b), hn::LoadU(d, corner + 8 + k));
      const auto second = hn::MulAdd(hn::Set(d, b), hn::LoadU(d, corner + 4 + k), third);
      hn::Store(hn::MulAdd(hn::Set(d, a), hn::LoadU(d, corner + k), second), d, sum + k);
    }
    red[i] += sum[0], green[i] += sum[1], blue[i] += sum[2];
  }
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace opaline {

HWY_EXPORT(add_rows);
HWY_EXPORT(add_blend);

std::size_t bytes_of(RowStorage storage) { return storage == RowStorage::f32 ? 4 : storage == RowStorage::i16 ? 2 : 1; }

void add_rows(RowStorage storage, std::span<const RowTerm> terms, std::size_t begin, std::size_t end, float* out) {
  HWY_DYNAMIC_DISPATCH(add_rows)(storage, terms, begin, end, out);
}

void add_blend(const CornerBlend& blend, std::size_t begin, std::size_t end, float* red, float* green, float* blue) {
  HWY_DYNAMIC_DISPATCH(add_blend)(blend, begin, end, red, green, blue);
}

}  // namespace opaline
#endif
