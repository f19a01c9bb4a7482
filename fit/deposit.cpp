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

/// Four basis values in a row and the first node of each patch of a chunk, at one of its two points.
struct Landing {
  HWY_ALIGN float value[4 * chunk];
  HWY_ALIGN std::int32_t node[chunk];
};

struct Chunk {
  Landing near, far;
  HWY_ALIGN float dx[chunk], dy[chunk], dz[chunk], per_spread[chunk], tilt[chunk];
};

struct BasisConstants {
  float x_0, t_0, per_spacing;
  std::int32_t last;  // largest first node

  explicit BasisConstants(const RadialBasis& basis)
      : x_0(static_cast<float>(basis.x_0())),
        t_0(static_cast<float>(basis.t_0())),
        per_spacing(static_cast<float>(1 / basis.spacing())),
        last(basis.size() - 4) {}
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
  hn::StoreInterleaved4(hn::Neg(hn::Mul(hn::Mul(f1, b), sixth)), hn::Mul(hn::Mul(f, b), half),
                        hn::Neg(hn::Mul(hn::Mul(a, f3), half)), hn::Mul(hn::Mul(a, f2), sixth), d, out.value + 4 * at);
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
      hn::StoreU(hn::MulAdd(hn::Set(d, c.near.value[4 * at + j]), flux_near, hn::LoadU(d, a)), d, a);
    }
    for (std::size_t j = 0; j < 4; ++j) {
      float* a = far + j * masses + m;
      hn::StoreU(hn::MulAdd(hn::Set(d, c.far.value[4 * at + j]), flux_far, hn::LoadU(d, a)), d, a);
    }
  }
}

void deposit_patches(const RadialBasis& basis, const PatchList& patches, const float* weight, const glm::vec3& position,
                     float* accumulators) {
  const BasisConstants constants(basis);
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

/// The geometry of parts of one leaf's cell: its own, scaled.
template <class D, class V = hn::Vec<D>>
struct ScaledParts {
  const ClusterNode& leaf;
  V x, y, z, scale, scale_2, scale_3;

  HWY_INLINE ScaledParts(const ClusterNode& of, const float* parts) : leaf(of) {
    hn::LoadInterleaved4(D(), parts, x, y, z, scale);
    scale_2 = hn::Mul(scale, scale), scale_3 = hn::Mul(scale_2, scale);
  }
  HWY_INLINE V operator()(int row) const {
    const D d;
    if (row == 0) return x;
    if (row == 1) return y;
    if (row == 2) return z;
    if (row < 9) return hn::Mul(scale_2, hn::Set(d, leaf.covariance[row - 3]));
    if (row == 9) return hn::Mul(scale_2, hn::Set(d, leaf.extent.trace));
    const V deviation = hn::Mul(scale_2, hn::Set(d, leaf.extent.deviation));
    if (row == 10) return hn::Mul(deviation, deviation);
    if (row == 21) return hn::Mul(hn::Abs(scale), hn::Set(d, leaf.extent.radius));
    return hn::Mul(scale_3, hn::Set(d, leaf.third[static_cast<std::size_t>(row - 11)]));
  }
};

/// Shares of a leaf's flux: four for every first node, apart from each other, so that a sum is found in the place and
/// of the size in which it was left (the processor else waits for it); and the first nodes that have any.
struct Shares {
  glm::vec4 *near, *far;  // two, so that one sum need not wait for the other
  std::int32_t first, last;
};

HWY_INLINE void add_row(const Landing& at, std::size_t i, glm::vec4* shares) {
  const hn::CappedTag<float, 4> d;
  float* to = &shares[at.node[i]].x;
  for (std::size_t j = 0; j < 4; j += hn::Lanes(d))
    hn::StoreU(hn::Add(hn::LoadU(d, to + j), hn::Load(d, at.value + 4 * i + j)), d, to + j);
}

/// At most a chunk of a leaf's parts.
HWY_INLINE void share_out(const BasisConstants& basis, const ClusterNode& leaf, const float* parts, std::size_t count,
                          const glm::vec3& position, Shares& shares) {
  const hn::ScalableTag<float> d;
  const hn::RebindToSigned<decltype(d)> di;
  Landing near, far;
  auto first = hn::Set(di, shares.first), last = hn::Set(di, shares.last);
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const ScaledParts<decltype(d)> scaled(leaf, parts + 4 * i);
    const auto q = two_points(d, scaled, position);
    const auto share = hn::Mul(scaled.scale_2, hn::Add(hn::Set(d, 0.5f), q.tilt));
    land(d, basis, q.near, share, i, near);
    land(d, basis, q.far, hn::Sub(scaled.scale_2, share), i, far);
    first = hn::Min(first, hn::Load(di, near.node + i)), last = hn::Max(last, hn::Load(di, far.node + i));
  }
  for (std::size_t i = 0; i < count; ++i) {
    add_row(near, i, shares.near);
    add_row(far, i, shares.far);
  }
  shares.first = hn::GetLane(hn::MinOfLanes(di, first)), shares.last = hn::GetLane(hn::MaxOfLanes(di, last));
}

/// Adds the leaf's fluxes times the shares, and clears these.
template <class D>
HWY_INLINE void add_fluxes(D d, const float* flux, std::size_t masses, Shares& shares, float* accumulators) {
  glm::vec4 ahead(0);  // shares of node n and the next three
  for (std::int32_t n = shares.first; n <= shares.last + 3; ++n) {
    ahead = glm::vec4(ahead.y, ahead.z, ahead.w, 0) + (shares.near[n] + shares.far[n]);
    shares.near[n] = shares.far[n] = glm::vec4(0);
    const auto share = hn::Set(d, ahead.x);
    float* to = accumulators + static_cast<std::size_t>(n) * masses;
    for (std::size_t m = 0; m < masses; m += hn::Lanes(d))
      hn::StoreU(hn::MulAdd(share, hn::LoadU(d, flux + m), hn::LoadU(d, to + m)), d, to + m);
  }
}

void deposit_parts(const RadialBasis& basis, const ClusterTree& tree, const DepositList& list,
                   const glm::vec3& position, float* accumulators) {
  const BasisConstants constants(basis);
  const auto nodes = static_cast<std::size_t>(basis.size()), masses = static_cast<std::size_t>(tree.masses);
  std::vector<glm::vec4> sums(2 * nodes, glm::vec4(0));
  Shares shares{&sums[0], &sums[nodes], 0, 0};
  for (std::size_t r = 0; r < list.run_count(); ++r) {
    const std::size_t leaf = list.run(r).leaf, first = list.run(r).first, count = list.run(r + 1).first - first;
    shares.first = constants.last, shares.last = 0;
    for (std::size_t i = 0; i < count; i += chunk)
      share_out(constants, tree.nodes[leaf], list.part(first + i), std::min(chunk, count - i), position, shares);
    const float* flux = &tree.mass[leaf * masses];
    if (masses % 8 == 0) {
      add_fluxes(hn::CappedTag<float, 8>(), flux, masses, shares, accumulators);
    } else {
      add_fluxes(hn::CappedTag<float, 1>(), flux, masses, shares, accumulators);
    }
  }
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace opaline {

HWY_EXPORT(deposit_patches);
HWY_EXPORT(deposit_parts);

void deposit_patches(const RadialBasis& basis, const PatchList& patches, const float* weight, const glm::vec3& position,
                     float* accumulators) {
  HWY_DYNAMIC_DISPATCH(deposit_patches)(basis, patches, weight, position, accumulators);
}

void deposit_parts(const RadialBasis& basis, const ClusterTree& tree, const DepositList& list,
                   const glm::vec3& position, float* accumulators) {
  HWY_DYNAMIC_DISPATCH(deposit_parts)(basis, tree, list, position, accumulators);
}

}  // namespace opaline
#endif
