#include "fit/deposit.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/deposit.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/irradiance/two_points.h"

#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace opaline::HWY_NAMESPACE {

constexpr std::size_t chunk = 64;

/// Four basis values and the first node of each patch of a chunk, at one of its two points.
struct Landing {
  HWY_ALIGN float value[4][chunk];
  HWY_ALIGN std::int32_t node[chunk];
};

struct Chunk {
  Landing near, far;
  HWY_ALIGN float dx[chunk], dy[chunk], dz[chunk], per_spread[chunk], tilt[chunk];
};

struct BasisConstants {
  float x_0, t_0, per_spacing;
  std::int32_t last;  // largest first node
};

template <class D, class V = hn::Vec<D>>
HWY_INLINE void land(D d, const BasisConstants& basis, V q, V scale, std::size_t at, Landing& out) {
  const hn::RebindToSigned<D> di;
  const V x = hn::Add(q, hn::Set(d, basis.x_0));
  const V t = hn::Mul(hn::Set(d, 0.5f), hn::Log(d, x));
  const V u = hn::Mul(hn::Sub(t, hn::Set(d, basis.t_0)), hn::Set(d, basis.per_spacing));
  const auto node =
      hn::Max(hn::Min(hn::Sub(hn::ConvertTo(di, u), hn::Set(di, 1)), hn::Set(di, basis.last)), hn::Zero(di));
  hn::Store(node, di, out.node + at);
  const V f = hn::Sub(u, hn::ConvertTo(d, node));
  const V one = hn::Set(d, 1.0f), f1 = hn::Sub(f, one), f2 = hn::Sub(f1, one), f3 = hn::Sub(f2, one);
  const V root = hn::Sqrt(x), w = hn::Div(scale, hn::Mul(root, hn::Sqrt(root)));  // scale x^(-3/4)
  const V sixth = hn::Mul(w, hn::Set(d, 1.0f / 6)), half = hn::Mul(w, hn::Set(d, 0.5f));
  const V a = hn::Mul(f, f1), b = hn::Mul(f2, f3);
  hn::Store(hn::Neg(hn::Mul(hn::Mul(f1, b), sixth)), d, out.value[0] + at);
  hn::Store(hn::Mul(hn::Mul(f, b), half), d, out.value[1] + at);
  hn::Store(hn::Neg(hn::Mul(hn::Mul(a, f3), half)), d, out.value[2] + at);
  hn::Store(hn::Mul(hn::Mul(a, f2), sixth), d, out.value[3] + at);
}

HWY_INLINE void prepare_chunk(const BasisConstants& basis, const PatchList& patches, const float* weight,
                              const glm::vec3& position, std::size_t begin, std::size_t end, Chunk& out) {
  const hn::ScalableTag<float> d;
  for (std::size_t i = begin; i < end; i += hn::Lanes(d)) {
    const std::size_t at = i - begin;
    const auto q = two_points(d, patches, i, position);
    const auto scale = weight ? hn::LoadU(d, weight + i) : hn::Set(d, 1.0f);
    land(d, basis, q.near, scale, at, out.near);
    land(d, basis, q.far, scale, at, out.far);
    hn::Store(q.dx, d, out.dx + at);
    hn::Store(q.dy, d, out.dy + at);
    hn::Store(q.dz, d, out.dz + at);
    hn::Store(hn::Div(hn::Set(d, 1.0f), q.spread), d, out.per_spread + at);
    hn::Store(q.tilt, d, out.tilt + at);
  }
}

/// Adds one patch's fluxes, `D` lanes of channels at a time.
template <class D>
HWY_INLINE void scatter(D d, const PatchList& patches, std::size_t i, const Chunk& c, std::size_t at,
                        float* accumulators) {
  const auto masses = static_cast<std::size_t>(patches.masses());
  float* near = accumulators + static_cast<std::size_t>(c.near.node[at]) * masses;
  float* far = accumulators + static_cast<std::size_t>(c.far.node[at]) * masses;
  for (std::size_t m = 0; m < masses; m += hn::Lanes(d)) {
    const auto mass = hn::LoadU(d, patches.mass() + i * masses + m);
    auto shift = hn::Mul(hn::Set(d, c.tilt[at]), mass);
    if (masses > 1) {
      const std::size_t o = i * masses + m;
      auto along = hn::Mul(hn::Set(d, c.dx[at]), hn::LoadU(d, patches.first_moment(0) + o));
      along = hn::MulAdd(hn::Set(d, c.dy[at]), hn::LoadU(d, patches.first_moment(1) + o), along);
      along = hn::MulAdd(hn::Set(d, c.dz[at]), hn::LoadU(d, patches.first_moment(2) + o), along);
      shift = hn::MulAdd(along, hn::Set(d, c.per_spread[at]), shift);
    }
    const auto half = hn::Mul(hn::Set(d, 0.5f), mass);
    const auto flux_near = hn::Add(half, shift), flux_far = hn::Sub(half, shift);
    for (std::size_t j = 0; j < 4; ++j) {
      float* a = near + j * masses + m;
      hn::StoreU(hn::MulAdd(hn::Set(d, c.near.value[j][at]), flux_near, hn::LoadU(d, a)), d, a);
    }
    for (std::size_t j = 0; j < 4; ++j) {
      float* a = far + j * masses + m;
      hn::StoreU(hn::MulAdd(hn::Set(d, c.far.value[j][at]), flux_far, hn::LoadU(d, a)), d, a);
    }
  }
}

void deposit_patches(const RadialBasis& basis, const PatchList& patches, const float* weight, const glm::vec3& position,
                     float* accumulators) {
  const BasisConstants constants{static_cast<float>(basis.x_0()), static_cast<float>(basis.t_0()),
                                 static_cast<float>(1 / basis.spacing()), basis.size() - 4};
  Chunk c;
  for (std::size_t begin = 0; begin < patches.size(); begin += chunk) {
    const std::size_t end = std::min(begin + chunk, patches.size());
    prepare_chunk(constants, patches, weight, position, begin, end, c);
    for (std::size_t i = begin; i < end; ++i) {
      if (weight && weight[i] == 0) continue;
      if (patches.masses() % 8 == 0) {
        scatter(hn::CappedTag<float, 8>(), patches, i, c, i - begin, accumulators);
      } else {
        scatter(hn::CappedTag<float, 1>(), patches, i, c, i - begin, accumulators);
      }
    }
  }
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace opaline {

HWY_EXPORT(deposit_patches);

void deposit_patches(const RadialBasis& basis, const PatchList& patches, const float* weight, const glm::vec3& position,
                     float* accumulators) {
  HWY_DYNAMIC_DISPATCH(deposit_patches)(basis, patches, weight, position, accumulators);
}

}  // namespace opaline
#endif
