// Is what is fitted flat, and lit and seen along its normal? There transport_radiance (model/profiles) is the radiance
// itself, where the exitance of transport_table with its lobe is up to tens of percent off: the light's way through the
// medium decides which direction it leaves in.
#pragma once

#include "fit/solve.h"

namespace opaline {

/// Largest angle between the normal and the view, or the light, over the visible points of a flat surface of
/// `material`, in degrees; 180 if it is not flat (to a thousandth of its size), lit by an environment, or not seen.
double off_straight_deg(const Scene& scene, int material);

/// The angle up to which both forms of transport are tried.
inline constexpr double straight_within_deg = 10;

/// The two forms of transport fitted to the same operators, and the one that the pictures prefer.
struct TransportForm {
  const ProfileInfo* profile;  ///< transport_table or transport_radiance
  Solution solution;
  std::string note;  ///< which, and by how much
};

/// `exitance`: the fit with transport_table. Radiance is what transport does, and is taken unless the information in
/// the pictures is against it by more than 10: pictures drawn by a technique with a profile leave alike in all
/// directions.
TransportForm preferred_form(const std::vector<FitTarget>& targets, const Material& initial,
                             const SolveSettings& settings, Solution exitance, double off_deg);

}  // namespace opaline
