#include "model/profiles/gaussian_sum.h"

#include <algorithm>
#include <cmath>
#include <mutex>

namespace opaline {
namespace {

/// Another profile's Gaussians. Their weights come from a least-squares fit, so gradients are differences of refits.
class GaussianSumProfile final : public Profile {
 public:
  GaussianSumProfile(const ProfileInfo& of, const Medium<double>& medium, int terms)
      : of_(of), medium_(medium), terms_(terms), sum_(fit_gaussian_sum(*of.make(medium), terms)) {}

  double evaluate(double r) const override { return sum_.evaluate(std::min(r, 1e150)); }
  double total() const override { return sum_.total(); }
  double cumulative(double r) const override { return std::min(sum_.cumulative(std::min(r, 1e150)), total()); }
  double sample(double xi) const override { return sum_.sample(xi); }
  double core_radius() const override {
    if (sum_.terms.empty()) return 1 / (medium_.sigma_a + medium_.sigma_s_prime);
    return std::sqrt(sum_.terms.front().variance);
  }

  ProfileGradient evaluate_with_gradient(double r) const override {
    std::call_once(made_, [&] { refit(); });
    const auto slope = [&](std::size_t i) {
      return steps_[i].size == 0 ? 0 : (steps_[i].above.evaluate(r) - steps_[i].below.evaluate(r)) / steps_[i].size;
    };
    return {evaluate(r), slope(0), slope(1), slope(2)};
  }

 private:
  struct Step {
    GaussianSum below, above;
    double size = 0;
  };

  GaussianSum at(const Medium<double>& medium) const {
    return fit_gaussian_sum(*of_.make(medium), terms_, sum_.left_out);
  }

  void refit() const {
    if (sum_.terms.empty()) return;
    double Medium<double>::*const members[] = {&Medium<double>::sigma_a, &Medium<double>::sigma_s_prime,
                                               &Medium<double>::eta};
    const double sigma_t_prime = medium_.sigma_a + medium_.sigma_s_prime;
    for (std::size_t i = 0; i < 3; ++i) {
      const double value = medium_.*members[i], h = value > 0 ? 1e-4 * value : 1e-9 * sigma_t_prime;
      Medium<double> low = medium_, high = medium_;
      low.*members[i] = std::max(0.0, value - h);
      high.*members[i] = value + h;
      steps_[i] = {at(low), at(high), high.*members[i] - low.*members[i]};
    }
  }

  const ProfileInfo& of_;
  Medium<double> medium_;
  int terms_;
  GaussianSum sum_;
  mutable std::once_flag made_;
  mutable std::array<Step, 3> steps_;
};

std::unique_ptr<Profile> build(const Medium<double>& medium, const ProfileParameters& parameters) {
  const std::string& of = word_of(parameters, "of");
  const ProfileInfo* info = find_profile(of);
  if (info == nullptr || !info->needs_medium_alone() || info->name == "gaussian_sum") {
    std::string names;
    for (const std::string& name : medium_profile_names()) {
      if (name != "gaussian_sum") names += (names.empty() ? "" : ", ") + name;
    }
    throw ProfileParameterError("profile gaussian_sum: of: \"" + of + "\" is none of " + names);
  }
  return std::make_unique<GaussianSumProfile>(*info, medium, static_cast<int>(number_of(parameters, "terms")));
}

}  // namespace

ProfileInfo gaussian_sum_profile() {
  return {
      .name = "gaussian_sum",
      .citation = "E. d'Eon, D. Luebke: Advanced Techniques for Realistic Real-Time Skin Rendering, GPU Gems 3, 2007",
      .domain = {.eta_min = 0.3,
                 .eta_max = 3.5,
                 .alpha_prime_min = 0.5,
                 .note = "as good as the profile it is fitted to: 6 terms put 0.6 % (standard dipole) to 5 % "
                         "(normalised diffusion) of the light at a wrong radius; beyond the last Gaussian R falls "
                         "faster than any profile"},
      .monotone = true,
      .build = &build,
      .parameters =
          {{.name = "of",
            .kind = ParameterKind::word,
            .fallback = std::string("standard_dipole"),
            .meaning = "the profile it is fitted to, one that needs a medium alone"},
           {.name = "terms", .unit = "1", .fallback = 6.0, .low = 2, .high = 16, .meaning = "Gaussians, at most"}},
      .gradient_error = 1e-4};
}

}  // namespace opaline
