// ProfileTable for vectors of squared distances. Include inside foreach_target files only.
//
// A kernel is a template on a Lookup, which finds the place of a vector of r^2 once (`place`) and then the values of
// any of its tables (`values`: all tables at several places, interleaved so that the latencies of one hide behind the
// others). `with_lookup` chooses the fastest that the tables and the processor allow:
//   RegisterLookup<P>  AVX-512: tables of the same segments with registers().per_octave == P
//   RowLookup          tables of the same segments. Up to AVX2 a row is one 16-byte load per lane, and rows are
//                      transposed.
//   SeparateRows       any tables: as RowLookup, with a place for each
#if defined(OPALINE_PROFILE_TABLE_KERNEL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef OPALINE_PROFILE_TABLE_KERNEL_H
#undef OPALINE_PROFILE_TABLE_KERNEL_H
#else
#define OPALINE_PROFILE_TABLE_KERNEL_H
#endif

#include "model/profile_table.h"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace opaline::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using TableTag = hn::CappedTag<float, 16>;
using TableVector = hn::Vec<TableTag>;

class RowLookup {
 public:
  using V = TableVector;
  RowLookup() = default;
  explicit RowLookup(const ProfileTable& table) : shape_(table.view()) {}

  struct Place {
    HWY_ALIGN std::int32_t row[hn::MaxLanes(TableTag())];
    V f;
  };
  struct Table {
    const float* rows = nullptr;
    Table() = default;
    Table(const ProfileTable& table, int) : rows(table.view().coefficients) {}
  };

  HWY_INLINE Place place(V r2) const {
    constexpr int shift = ProfileTable::segment_shift;
    const auto bits = hn::BitCast(di, hn::Add(r2, hn::Set(d, shape_.offset)));
    const auto segment = hn::Min(hn::Sub(hn::ShiftRight<shift>(bits), hn::Set(di, shape_.first_segment)),
                                 hn::Set(di, shape_.last_segment));
    Place p;
    hn::Store(hn::ShiftLeft<2>(segment), di, p.row);
    p.f = hn::Mul(hn::ConvertTo(d, hn::And(bits, hn::Set(di, (1 << shift) - 1))), hn::Set(d, 1.0f / (1 << shift)));
    return p;
  }

  HWY_INLINE V value(const Table& table, const Place& p) const {
    V c[4];
    load_rows(table.rows, p.row, c);
    return hn::MulAdd(hn::MulAdd(hn::MulAdd(c[3], p.f, c[2]), p.f, c[1]), p.f, c[0]);
  }
  template <int Tables, int Points>
  HWY_INLINE void values(const Table* tables, const Place (&p)[Points], V (&out)[Points][Tables]) const {
    for (int t = 0; t < Tables; ++t)
      for (int i = 0; i < Points; ++i) out[i][t] = value(tables[t], p[i]);
  }

 private:
  static constexpr TableTag d{};
  static constexpr hn::RebindToSigned<TableTag> di{};
  ProfileTable::View shape_{};

  /// c[k] = coefficient k of each lane's row.
  static HWY_INLINE void load_rows(const float* rows, const std::int32_t* at, V c[4]) {
#if HWY_TARGET <= HWY_AVX3 || HWY_TARGET == HWY_SCALAR
    const auto index = hn::Load(di, at);
    for (int k = 0; k < 4; ++k) c[k] = hn::GatherIndex(d, rows + k, index);
#else
    const hn::Full128<float> quarter;
    V row[4];
    for (int lane = 0; lane < 4; ++lane) {
      const auto low = hn::LoadU(quarter, rows + at[lane]);
#if HWY_TARGET == HWY_AVX2
      row[lane] = hn::Combine(d, hn::LoadU(quarter, rows + at[lane + 4]), low);
#else
      row[lane] = low;
#endif
    }
    // A 4 x 4 transposition within each block of 128 bits.
    const hn::RebindToUnsigned<hn::Repartition<double, TableTag>> pairs;
    const V a = hn::InterleaveLower(d, row[0], row[1]), b = hn::InterleaveLower(d, row[2], row[3]);
    const V e = hn::InterleaveUpper(d, row[0], row[1]), g = hn::InterleaveUpper(d, row[2], row[3]);
    const auto pair = [&](V v) HWY_ATTR { return hn::BitCast(pairs, v); };
    c[0] = hn::BitCast(d, hn::InterleaveLower(pairs, pair(a), pair(b)));
    c[1] = hn::BitCast(d, hn::InterleaveUpper(pairs, pair(a), pair(b)));
    c[2] = hn::BitCast(d, hn::InterleaveLower(pairs, pair(e), pair(g)));
    c[3] = hn::BitCast(d, hn::InterleaveUpper(pairs, pair(e), pair(g)));
#endif
  }
};

#if HWY_TARGET <= HWY_AVX3
template <int PerOctave>
class RegisterLookup {
 public:
  using V = TableVector;
  explicit RegisterLookup(const ProfileTable& table) : shape_(table.registers()) {}

  struct Place {
    hn::Vec<hn::RebindToSigned<TableTag>> segment;
    V t;
  };
  struct Table {
    const float* columns = nullptr;
    Table() = default;
    Table(const ProfileTable& table, int) : columns(table.registers().columns) {}
  };

  HWY_INLINE Place place(V r2) const {
    constexpr int shift = ProfileTable::Registers::shift(PerOctave);
    const V x = hn::Min(hn::Add(r2, hn::Set(d, shape_.offset)), hn::Set(d, shape_.x_max));
    const auto bits = hn::BitCast(di, x);
    const auto one = hn::BitCast(di, hn::Set(d, 1.0f));
    const auto mantissa = hn::OrAnd(one, bits, hn::Set(di, (1 << shift) - 1));
    return {hn::Sub(hn::ShiftRight<shift>(bits), hn::Set(di, shape_.first_segment)),
            hn::Sub(hn::BitCast(d, mantissa), hn::Set(d, 1 + 0.5f / PerOctave))};
  }

  template <int Tables, int Points>
  HWY_INLINE void values(const Table* tables, const Place (&p)[Points], V (&out)[Points][Tables]) const {
    constexpr int degree = ProfileTable::Registers::degree(PerOctave);
    for (int t = 0; t < Tables; ++t)
      for (int i = 0; i < Points; ++i) out[i][t] = coefficient(tables[t], degree, p[i]);
    for (int k = degree - 1; k >= 0; --k)
      for (int t = 0; t < Tables; ++t)
        for (int i = 0; i < Points; ++i) out[i][t] = hn::MulAdd(out[i][t], p[i].t, coefficient(tables[t], k, p[i]));
  }

 private:
  static constexpr TableTag d{};
  static constexpr hn::RebindToSigned<TableTag> di{};
  ProfileTable::Registers shape_;

  /// vpermt2ps: 32 floats in two registers, of which the lower five bits of the segment choose.
  static HWY_INLINE V coefficient(const Table& table, int k, const Place& p) {
    const float* column = table.columns + 32 * k;
    return V{_mm512_permutex2var_ps(_mm512_load_ps(column), p.segment.raw, _mm512_load_ps(column + 16))};
  }
};
#endif

class SeparateRows {
 public:
  using V = TableVector;
  SeparateRows(const ProfileTable* const* tables, int count) : count_(count) {
    for (int t = 0; t < count; ++t) lookup_[t] = RowLookup(*tables[t]);
  }

  struct Place {
    RowLookup::Place of[3];
  };
  struct Table {
    RowLookup::Table table;
    int index = 0;  ///< among the tables of the constructor
    Table() = default;
    Table(const ProfileTable& t, int which) : table(t, which), index(which) {}
  };

  HWY_INLINE Place place(V r2) const {
    Place p;
    for (int t = 0; t < count_; ++t) p.of[t] = lookup_[t].place(r2);
    return p;
  }
  template <int Tables, int Points>
  HWY_INLINE void values(const Table* tables, const Place (&p)[Points], V (&out)[Points][Tables]) const {
    for (int t = 0; t < Tables; ++t) {
      const int index = tables[t].index;
      for (int i = 0; i < Points; ++i) out[i][t] = lookup_[index].value(tables[t].table, p[i].of[index]);
    }
  }

 private:
  RowLookup lookup_[3];
  int count_;
};

/// Calls kernel(lookup) once, for up to three tables.
template <typename Kernel>
HWY_INLINE void with_lookup(const ProfileTable* const* tables, int count, const Kernel& kernel) {
  for (int t = 1; t < count; ++t)
    if (!tables[t]->same_segments(*tables[0])) return kernel(SeparateRows(tables, count));
#if HWY_TARGET <= HWY_AVX3
  if (tables[0]->registers().per_octave == 2) return kernel(RegisterLookup<2>(*tables[0]));
  if (tables[0]->registers().per_octave == 1) return kernel(RegisterLookup<1>(*tables[0]));
#endif
  kernel(RowLookup(*tables[0]));
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
