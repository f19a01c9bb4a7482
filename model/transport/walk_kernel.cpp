#include "model/transport/walk_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "model/transport/walk_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/phase.h"
#include "model/transport/split_mix.h"

#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace opaline::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<D>;
using DU = hn::RebindToUnsigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;
using VU = hn::Vec<DU>;
using M = hn::Mask<D>;
constexpr D d;
constexpr DI di;
constexpr DU du;

HWY_INLINE V set(float x) { return hn::Set(d, x); }

/// One slot per photon in flight: enough of them that the latencies of one vector hide behind the others.
constexpr std::size_t slots = 64;

struct Photons {
  HWY_ALIGN float x[slots], y[slots], z[slots], ux[slots], uy[slots], uz[slots];
  HWY_ALIGN std::int32_t n[slots];  // scatterings so far; negative: nobody flies here
  HWY_ALIGN std::uint32_t random[4][slots];
};

/// xoshiro128+ (Blackman & Vigna 2018), a stream per slot.
struct Random {
  VU s0, s1, s2, s3;

  HWY_INLINE VU bits() {
    const VU result = hn::Add(s0, s3), t = hn::ShiftLeft<9>(s1);
    s2 = hn::Xor(s2, s0);
    s3 = hn::Xor(s3, s1);
    s1 = hn::Xor(s1, s2);
    s0 = hn::Xor(s0, s3);
    s2 = hn::Xor(s2, t);
    s3 = hn::Or(hn::ShiftLeft<11>(s3), hn::ShiftRight<21>(s3));
    return result;
  }

  /// In [0, 2^31): the upper bits, which are the good ones.
  HWY_INLINE VI positive() { return hn::BitCast(di, hn::ShiftRight<1>(bits())); }

  /// In (0, 1], with 31 bits near 0, where a logarithm needs them.
  HWY_INLINE V uniform() { return hn::MulAdd(hn::ConvertTo(d, positive()), set(0x1p-31f), set(0x1p-32f)); }

  /// In [-1, 1].
  HWY_INLINE V symmetric() { return hn::Mul(hn::ConvertTo(d, hn::BitCast(di, bits())), set(0x1p-31f)); }
};

struct Flight {
  V x, y, z, ux, uy, uz;
  VI n;
  Random random;

  HWY_INLINE Flight(const Photons& p, std::size_t at)
      : x(hn::Load(d, p.x + at)),
        y(hn::Load(d, p.y + at)),
        z(hn::Load(d, p.z + at)),
        ux(hn::Load(d, p.ux + at)),
        uy(hn::Load(d, p.uy + at)),
        uz(hn::Load(d, p.uz + at)),
        n(hn::Load(di, p.n + at)),
        random{hn::Load(du, p.random[0] + at), hn::Load(du, p.random[1] + at), hn::Load(du, p.random[2] + at),
               hn::Load(du, p.random[3] + at)} {}

  HWY_INLINE void store(Photons& p, std::size_t at) const {
    hn::Store(x, d, p.x + at);
    hn::Store(y, d, p.y + at);
    hn::Store(z, d, p.z + at);
    hn::Store(ux, d, p.ux + at);
    hn::Store(uy, d, p.uy + at);
    hn::Store(uz, d, p.uz + at);
    hn::Store(n, di, p.n + at);
    hn::Store(random.s0, du, p.random[0] + at);
    hn::Store(random.s1, du, p.random[1] + at);
    hn::Store(random.s2, du, p.random[2] + at);
    hn::Store(random.s3, du, p.random[3] + at);
  }
};

/// Sine and cosine of pi t, t in [-1, 1]: Taylor polynomials of the half angle (error 6e-8), then doubled.
HWY_INLINE void sine_cosine(V t, V& sine, V& cosine) {
  const V h = hn::Mul(t, set(1.57079632679f)), q = hn::Mul(h, h);
  V s = set(-1.0f / 39916800), c = set(1.0f / 479001600);
  for (const float k : {1.0f / 362880, -1.0f / 5040, 1.0f / 120, -1.0f / 6, 1.0f}) s = hn::MulAdd(s, q, set(k));
  for (const float k : {-1.0f / 3628800, 1.0f / 40320, -1.0f / 720, 1.0f / 24, -0.5f, 1.0f})
    c = hn::MulAdd(c, q, set(k));
  s = hn::Mul(s, h);
  sine = hn::Mul(hn::Add(s, s), c);
  cosine = hn::NegMulAdd(hn::Add(s, s), s, set(1.0f));
}

HWY_INLINE V sine_of(V cosine) { return hn::Sqrt(hn::Max(hn::Zero(d), hn::NegMulAdd(cosine, cosine, set(1.0f)))); }

HWY_INLINE void scatter_isotropic(Flight& f) {
  const V cosine = f.random.symmetric(), sine = sine_of(cosine);
  V s, c;
  sine_cosine(f.random.symmetric(), s, c);
  f.ux = hn::Mul(sine, c);
  f.uy = hn::Mul(sine, s);
  f.uz = cosine;
}

HWY_INLINE V sample_cosine(float g, V xi) {
  HWY_ALIGN float lane[hn::MaxLanes(d)];
  hn::Store(xi, d, lane);
  for (std::size_t i = 0; i < hn::Lanes(d); ++i) lane[i] = sample_henyey_greenstein(lane[i], g);
  return hn::Load(d, lane);
}

/// Turns the direction u by a Henyey-Greenstein angle, in the frame that the shortest turn of +-e_z into u makes of e_x
/// and e_y (no pole, no branch). The last lines take out the drift of u's length, to first order.
HWY_INLINE void scatter_henyey_greenstein(float g, Flight& f) {
  const V cosine = sample_cosine(g, f.random.uniform()), sine = sine_of(cosine);
  V s, c;
  sine_cosine(f.random.symmetric(), s, c);
  const V one = set(1.0f), sign = hn::CopySign(one, f.uz);
  const V a = hn::Div(hn::Neg(one), hn::Add(sign, f.uz)), ax = hn::Mul(a, f.ux), b = hn::Mul(ax, f.uy);
  const V along = hn::Mul(sine, c), across = hn::Mul(sine, s);
  const V x = hn::MulAdd(along, hn::MulAdd(hn::Mul(sign, ax), f.ux, one), hn::MulAdd(across, b, hn::Mul(cosine, f.ux)));
  const V y = hn::MulAdd(along, hn::Mul(sign, b),
                         hn::MulAdd(across, hn::MulAdd(hn::Mul(a, f.uy), f.uy, sign), hn::Mul(cosine, f.uy)));
  const V z = hn::MulAdd(hn::Neg(hn::Mul(sign, along)), f.ux, hn::NegMulAdd(across, f.uy, hn::Mul(cosine, f.uz)));
  const V square = hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z)));
  const V scale = hn::NegMulAdd(set(0.5f), square, set(1.5f));
  f.ux = hn::Mul(x, scale);
  f.uy = hn::Mul(y, scale);
  f.uz = hn::Mul(z, scale);
}

/// Reflectance for light inside with this cosine: 1 beyond the critical angle, else looked up by the cosine on the
/// thin side, in which it is smooth (and the same from both sides), linear between entries.
HWY_INLINE V reflectance(const WalkConstants& k, V cosine) {
  if (k.reflectance.empty()) return hn::Zero(d);
  const V one = set(1.0f);
  const V square = hn::NegMulAdd(set(k.index_squared), hn::NegMulAdd(cosine, cosine, one), one);
  const auto last = static_cast<std::int32_t>(k.reflectance.size()) - 1;
  const V t = hn::Mul(hn::Sqrt(hn::Max(square, hn::Zero(d))), set(static_cast<float>(last)));
  const VI i = hn::Min(hn::ConvertTo(di, t), hn::Set(di, last - 1));
  const V low = hn::GatherIndex(d, k.reflectance.data(), i), high = hn::GatherIndex(d, k.reflectance.data() + 1, i);
  return hn::MulAdd(hn::Sub(t, hn::ConvertTo(d, i)), hn::Sub(high, low), low);
}

HWY_INLINE void record(WalkEnds& ends, M mask, V r2, VI n, VI how) {
  const VI key = hn::Or(hn::ShiftLeft<WalkEnds::shift>(n), how);
  hn::CompressBlendedStore(key, hn::RebindMask(di, mask), di, ends.key + ends.size);
  ends.size += hn::CompressBlendedStore(r2, mask, d, ends.r2 + ends.size);
}

/// Brings flights that went through a face out of the slab or, mirrored, back into it; returns who left.
HWY_INLINE M cross_faces(const WalkConstants& k, M flying, Flight& f, WalkEnds& ends) {
  const V zero = hn::Zero(d), thickness = set(k.thickness);
  M left = hn::Lt(zero, zero);
  for (;;) {
    const M above = hn::Lt(f.z, zero);
    const M outside = hn::And(flying, hn::Or(above, hn::Gt(f.z, thickness)));
    if (hn::AllFalse(d, outside)) return left;
    const V face = hn::IfThenElse(above, zero, thickness);
    const M through = hn::And(outside, hn::Gt(f.random.uniform(), reflectance(k, hn::Abs(f.uz))));
    if (!hn::AllFalse(d, through)) {
      const V beyond = hn::Div(hn::Sub(f.z, face), f.uz);  // length of flight outside
      const V x = hn::NegMulAdd(f.ux, beyond, f.x), y = hn::NegMulAdd(f.uy, beyond, f.y);
      const VI how = hn::IfThenElseZero(hn::RebindMask(di, hn::Not(above)), hn::Set(di, WalkEnds::transmitted));
      record(ends, through, hn::MulAdd(x, x, hn::Mul(y, y)), f.n, how);
      left = hn::Or(left, through);
    }
    flying = hn::AndNot(through, outside);
    f.z = hn::IfThenElse(flying, hn::Sub(hn::Add(face, face), f.z), f.z);
    f.uz = hn::IfThenElse(flying, hn::Neg(f.uz), f.uz);
  }
}

/// Who the roulette takes at this scattering.
HWY_INLINE M roulette(const WalkConstants& k, M scattered, Flight& f, WalkEnds& ends) {
  const auto played =
      hn::And(hn::Gt(f.n, hn::Set(di, k.free_scatterings)), hn::Gt(f.random.positive(), hn::Set(di, k.last_survivor)));
  const M killed = hn::And(scattered, hn::RebindMask(d, played));
  if (!hn::AllFalse(d, killed)) record(ends, killed, hn::Zero(d), f.n, hn::Set(di, WalkEnds::killed));
  return killed;
}

/// Photons still to start, and those in flight.
struct Queue {
  std::uint64_t waiting;
  std::size_t flying = 0;
};

/// Puts new photons where others ended; near the end of the queue only into the first of those slots.
HWY_INLINE void restart(const WalkConstants& k, M ended, Flight& f, Queue& queue) {
  if (hn::AllFalse(d, ended)) return;
  const std::size_t count = hn::CountTrue(d, ended);
  f.n = hn::IfThenElse(hn::RebindMask(di, ended), hn::Zero(di), f.n);
  if (count <= queue.waiting) {
    queue.waiting -= count;
  } else {
    HWY_ALIGN std::int32_t n[hn::MaxLanes(d)], is_new[hn::MaxLanes(d)];
    hn::Store(f.n, di, n);
    hn::Store(hn::IfThenElseZero(hn::RebindMask(di, ended), hn::Set(di, 1)), di, is_new);
    for (std::size_t i = 0; i < hn::Lanes(d); ++i) {
      if (!is_new[i]) continue;
      queue.waiting > 0 ? void(--queue.waiting) : (n[i] = -1, void(--queue.flying));
    }
    f.n = hn::Load(di, n);
  }
  f.x = hn::IfThenZeroElse(ended, f.x);
  f.y = hn::IfThenZeroElse(ended, f.y);
  f.z = hn::IfThenZeroElse(ended, f.z);
  f.ux = hn::IfThenElse(ended, set(k.sine), f.ux);
  f.uy = hn::IfThenZeroElse(ended, f.uy);
  f.uz = hn::IfThenElse(ended, set(k.cosine), f.uz);
}

/// One free flight, and the scattering or the end that follows, for a vector of photons.
template <bool Isotropic>
HWY_INLINE std::size_t step(const WalkConstants& k, Flight& f, Queue& queue, WalkEnds& ends) {
  const M flying = hn::RebindMask(d, hn::Gt(f.n, hn::Set(di, -1)));
  const V length = hn::Neg(hn::Log(d, f.random.uniform()));
  f.x = hn::MulAdd(f.ux, length, f.x);
  f.y = hn::MulAdd(f.uy, length, f.y);
  f.z = hn::MulAdd(f.uz, length, f.z);
  const M left = cross_faces(k, flying, f, ends);
  const M scattered = hn::AndNot(left, flying);
  f.n = hn::Sub(f.n, hn::VecFromMask(di, hn::RebindMask(di, scattered)));  // a true lane is -1
  Isotropic ? scatter_isotropic(f) : scatter_henyey_greenstein(k.g, f);
  restart(k, hn::Or(left, roulette(k, scattered, f, ends)), f, queue);
  return hn::CountTrue(d, scattered);
}

void start(const WalkConstants& k, std::uint64_t seed, Queue& queue, Photons& p) {
  SplitMix mix{seed};
  for (std::size_t i = 0; i < slots; ++i) {
    for (std::size_t word = 0; word < 4; ++word) p.random[word][i] = static_cast<std::uint32_t>(mix() >> 32);
    const bool flies = queue.waiting > 0;
    p.x[i] = p.y[i] = p.z[i] = p.uy[i] = 0;
    p.ux[i] = k.sine;
    p.uz[i] = k.cosine;
    p.n[i] = flies ? 0 : -1;
    queue.waiting -= flies;
    queue.flying += flies;
  }
}

template <bool Isotropic>
std::uint64_t walk_all(const WalkConstants& k, std::uint64_t seed, Queue queue,
                       const std::function<void(const WalkEnds&)>& sink) {
  Photons photons;
  WalkEnds ends;
  std::uint64_t scatterings = 0;
  start(k, seed, queue, photons);
  while (queue.flying > 0) {
    for (std::size_t at = 0; at < slots; at += hn::Lanes(d)) {
      Flight f(photons, at);
      scatterings += step<Isotropic>(k, f, queue, ends);
      f.store(photons, at);
    }
    if (ends.size <= WalkEnds::capacity - 2 * slots) continue;
    sink(ends);
    ends.size = 0;
  }
  sink(ends);
  return scatterings;
}

std::uint64_t run_walks(const WalkConstants& constants, std::uint64_t seed, std::uint64_t walks,
                        const std::function<void(const WalkEnds&)>& sink) {
  const Queue queue{walks};
  return constants.g == 0 ? walk_all<true>(constants, seed, queue, sink)
                          : walk_all<false>(constants, seed, queue, sink);
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace opaline {

HWY_EXPORT(run_walks);

std::uint64_t run_walks(const WalkConstants& constants, std::uint64_t seed, std::uint64_t walks,
                        const std::function<void(const WalkEnds&)>& sink) {
  return HWY_DYNAMIC_DISPATCH(run_walks)(constants, seed, walks, sink);
}

}  // namespace opaline
#endif
