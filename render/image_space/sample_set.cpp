#include "render/image_space/sample_set.h"

#include "render/irradiance/light_sampler.h"

#include <cmath>

namespace opaline {
namespace {

/// The distinct profiles, in the order of the tables, and how many samples each draws.
struct Strategies {
  std::vector<const Profile*> profiles;
  std::vector<int> counts;
  int on_disc = 0;
  double disc_radius = 0;

  double density(double r) const {
    double sum = r < disc_radius ? on_disc / (pi * disc_radius * disc_radius) : 0;
    for (std::size_t t = 0; t < profiles.size(); ++t)
      if (profiles[t]->total() > 0) sum += counts[t] * profiles[t]->evaluate(r) / profiles[t]->total();
    return sum;
  }
};

Strategies make_strategies(const ChannelProfiles& profiles, const SampleSettings& settings) {
  Strategies s;
  for (int t = 0; t < profiles.distinct(); ++t)
    for (int c = 2; c >= 0; --c)
      if (profiles.sum().table_of[c] == t) {
        s.profiles.push_back(&profiles.profile(c));
        break;
      }
  s.on_disc = static_cast<int>(std::lround(settings.samples * settings.uniform_share));
  s.disc_radius = settings.disc_radius;
  const int importance = settings.samples - s.on_disc, tables = profiles.distinct();
  for (int t = 0; t < tables; ++t) s.counts.push_back(importance / tables + (t < importance % tables));
  return s;
}

/// Adds a sample unless its weight is no number.
void add_sample(const Strategies& strategies, double r, double turn, SampleSet& set, std::uint64_t& without_weight) {
  const double density = strategies.density(r);
  if (!(density > 1e-30)) {
    ++without_weight;
    return;
  }
  set.u.push_back(static_cast<float>(r * std::cos(2 * pi * turn)));
  set.v.push_back(static_cast<float>(r * std::sin(2 * pi * turn)));
  set.weight.push_back(static_cast<float>(1 / density));
  for (std::size_t t = 0; t < strategies.profiles.size(); ++t)
    set.share[t].push_back(static_cast<float>(strategies.profiles[t]->evaluate(r) / density));
  ++set.count;
}

void pad(SampleSet& set) {
  const std::size_t padded = PatchList::padded(set.count);
  for (std::vector<float>* row : {&set.u, &set.v, &set.weight, &set.share[0], &set.share[1], &set.share[2]})
    row->resize(padded, 0.0f);
}

SampleSet make_set(const Strategies& strategies, std::uint64_t seed, std::uint64_t& without_weight) {
  SampleSet set;
  for (std::size_t t = 0; t < strategies.profiles.size(); ++t)
    for (int i = 0; i < strategies.counts[t]; ++i) {
      const auto [xi, turn] = shifted_r2(8 * seed + t, static_cast<std::uint32_t>(i));
      add_sample(strategies, strategies.profiles[t]->sample(static_cast<double>(xi)), static_cast<double>(turn), set,
                 without_weight);
    }
  for (int i = 0; i < strategies.on_disc; ++i) {
    const auto [xi, turn] = shifted_r2(8 * seed + 7, static_cast<std::uint32_t>(i));
    add_sample(strategies, strategies.disc_radius * std::sqrt(static_cast<double>(xi)), static_cast<double>(turn), set,
               without_weight);
  }
  pad(set);
  return set;
}

}  // namespace

SampleSets make_sample_sets(const ChannelProfiles& profiles, const SampleSettings& settings) {
  const Strategies strategies = make_strategies(profiles, settings);
  SampleSets sets;
  sets.pattern = settings.pattern;
  const auto count = static_cast<std::uint64_t>(settings.pattern) * static_cast<std::uint64_t>(settings.pattern);
  for (std::uint64_t s = 0; s < count; ++s)
    sets.sets.push_back(make_set(strategies, settings.seed * 0x9e3779b97f4a7c15ull + s, sets.without_weight));
  for (std::size_t t = 0; t < strategies.profiles.size(); ++t) {
    const double total = strategies.profiles[t]->total();
    sets.density.per_table[t] = total > 0 ? static_cast<float>(strategies.counts[t] / total) : 0.0f;
  }
  if (strategies.on_disc > 0) {
    const double r = strategies.disc_radius;
    sets.density.on_disc = static_cast<float>(strategies.on_disc / (pi * r * r));
    sets.density.disc_squared = static_cast<float>(r * r);
  }
  return sets;
}

double disc_radius(const ChannelProfiles& profiles, double share, double r_max) {
  double radius = 0;
  for (int c = 0; c < 3; ++c) {
    const Profile& profile = profiles.profile(c);
    double low = 0, high = r_max;
    if (profile.cumulative(high) < share * profile.total()) low = high;
    for (int i = 0; i < 60 && low < high; ++i) {
      const double middle = 0.5 * (low + high);
      (profile.cumulative(middle) < share * profile.total() ? low : high) = middle;
    }
    radius = std::max(radius, high);
  }
  return radius;
}

}  // namespace opaline
