// How `opaline profile` prints what it tabulated.
#pragma once

#include "model/profiles/profile.h"

#include <string>
#include <vector>

namespace opaline {

/// One model and channel over the radii.
struct TabulatedChannel {
  std::vector<double> r, R, cumulative, transmittance;  ///< mm, 1/mm^2, 1, 1/mm^2 (empty: none)
  double total = 0, total_transmittance = 0;
};

struct TabulatedModel {
  std::string name;
  std::vector<TabulatedChannel> channels;
};

TabulatedChannel tabulate(const ProfileInfo& info, const Profile& profile, const std::vector<double>& radii);

/// One model as {"model", "units", "channels"}; several as {"units", "models": [...]}, each after the first with its
/// ratio of totals to the first and the mean |log| of their ratio over the radii.
void print_profiles_json(const std::vector<TabulatedModel>& models);

/// A column for each model and channel; with `all` also cumulative and transmittance.
void print_profiles_csv(const std::vector<TabulatedModel>& models, bool all);

}  // namespace opaline
