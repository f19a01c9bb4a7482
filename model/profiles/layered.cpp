#include "model/profiles/layered_profile.h"
#include "model/profiles/profile.h"

#include <ceres/jet.h>

#include <mutex>

namespace opaline {
namespace {

using Dual = ceres::Jet<double, 3>;

template <typename T>
std::vector<SlabSource<T>> slabs_of(const Medium<T>& top, const ProfileParameters& p) {
  std::vector<StackLayer<T>> layers = {{top, T(number_of(p, "thickness_mm"))}};
  for (const Layer& layer : std::get<std::vector<Layer>>(p.at("layers"))) {
    const Medium<double>& m = layer.medium;
    layers.push_back({{T(m.sigma_a), T(m.sigma_s_prime), T(m.eta)}, T(layer.thickness)});
  }
  return stack_of(layers, T(number_of(p, "index_below")));
}

class LayeredProfile final : public Profile {
 public:
  LayeredProfile(const Medium<double>& top, const ProfileParameters& parameters)
      : slabs_(slabs_of(top, parameters)),
        duals_(slabs_of(Medium<Dual>{Dual(top.sigma_a, 0), Dual(top.sigma_s_prime, 1), Dual(top.eta, 2)}, parameters)),
        decays_(decays(slabs_)),
        whole_(stack_response(slabs_, 0.0)),
        kernels_(reflectance_kernels(slabs_, decays_)) {
    double sum = 0;
    for (const auto& kernel : kernels_) flux_up_to_.push_back(sum += kernel.weight);
  }

  double evaluate(double r) const override { return evaluate_kernels(kernels_, r); }

  ProfileGradient evaluate_with_gradient(double r) const override {
    std::call_once(dual_made_, [&] { dual_kernels_ = reflectance_kernels(duals_, decays_); });
    const Dual value = evaluate_kernels(dual_kernels_, r);
    return {value.a, value.v[0], value.v[1], value.v[2]};
  }

  double total() const override { return whole_.reflected; }
  double cumulative(double r) const override { return std::min(kernels_within(kernels_, r), total()); }
  double core_radius() const override { return slabs_.front().depth; }

  /// A kernel by its flux, then its closed inverse, reusing xi: not monotone in xi.
  double sample(double xi) const override {
    if (kernels_.empty()) return 0;
    const double flux = xi * flux_up_to_.back();
    const auto above = std::upper_bound(flux_up_to_.begin(), flux_up_to_.end() - 1, flux);
    const std::size_t i = static_cast<std::size_t>(above - flux_up_to_.begin());
    const double share = (flux - (i > 0 ? flux_up_to_[i - 1] : 0)) / kernels_[i].weight;
    return std::sqrt(-4 * kernels_[i].t * std::log1p(-std::clamp(share, 0.0, 1 - 0x1p-53)));
  }

  double transmittance(double r) const override {
    if (slabs_.back().infinite) return 0;
    std::call_once(transmitted_made_, [&] { transmitted_ = transmittance_kernels(slabs_, decays_.back()); });
    return evaluate_kernels(transmitted_, r);
  }
  double total_transmittance() const override { return whole_.transmitted - straight_through(slabs_); }

 private:
  std::vector<SlabSource<double>> slabs_;
  std::vector<SlabSource<Dual>> duals_;
  std::vector<double> decays_;
  Response<double> whole_;
  std::vector<HeatKernel<double>> kernels_;
  std::vector<double> flux_up_to_;
  mutable std::once_flag dual_made_, transmitted_made_;
  mutable std::vector<HeatKernel<Dual>> dual_kernels_;
  mutable std::vector<HeatKernel<double>> transmitted_;
};

std::unique_ptr<Profile> build(const Medium<double>& medium, const ProfileParameters& parameters) {
  const bool more = !std::get<std::vector<Layer>>(parameters.at("layers")).empty();
  if (more && !std::isfinite(number_of(parameters, "thickness_mm")))
    throw ProfileParameterError("profile layered: thickness_mm: the top layer needs a finite thickness above others");
  return std::make_unique<LayeredProfile>(medium, parameters);
}

}  // namespace

ProfileInfo layered_profile() {
  return {.name = "layered",
          .citation = "C. Donner, H. W. Jensen: Light Diffusion in Multi-Layered Translucent Materials, SIGGRAPH 2005",
          .domain = {.eta_min = 0.3,
                     .eta_max = 3.5,
                     .alpha_prime_min = 0.8,
                     .thickness_min_mfp = 2,
                     .note = "the medium is the top layer, gradients are by it. Every layer is lit as if by a normal "
                             "beam, so a slab cut in two is not the slab; limits of each layer as in multipole"},
          .monotone = true,
          .build = &build,
          .parameters = {{.name = "thickness_mm",
                          .unit = "mm",
                          .fallback = HUGE_VAL,
                          .low = 1e-60,
                          .high = HUGE_VAL,
                          .meaning = "of the top layer; infinite: a half space"},
                         {.name = "layers",
                          .kind = ParameterKind::layers,
                          .unit = "mm",
                          .fallback = std::vector<Layer>{},
                          .meaning = "what lies under the top layer, downwards"},
                         {.name = "index_below",
                          .unit = "1",
                          .fallback = 1.0,
                          .low = 1e-3,
                          .high = 1e3,
                          .meaning = "refraction index of the space under the stack over that above it"}},
          .has_transmittance = true};
}

}  // namespace opaline
