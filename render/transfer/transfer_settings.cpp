// The settings of precomputed_transfer.
#include "render/techniques/gather_technique.h"
#include "render/transfer/harmonics.h"
#include "render/transfer/transfer_scene.h"

namespace opaline {

std::vector<SettingSpec> transfer_setting_specs() {
  return {
      profile_setting(),
      {"form",
       "float",
       "what is kept: q as floats, Q (vectors) as floats, q as 8-bit codes, spherical harmonics, or reference points "
       "with harmonics of the difference",
       {"float", "vector", "lloyd", "harmonics", "reference"}},
      {"directions", "200", "light directions of the table", {}, DirectionSet::fewest, 100000, true},
      {"interpolation",
       "four",
       "between directions: of the four nearest, as published, or a quadratic through twelve, three times the rows for "
       "a third less error",
       {"four", "twelve"}},
      {"distances", "6", "levels of inverse distance, for point lights", {}, 1, 64, true},
      {"subdivide", "1", "cuts every triangle into k^2: more vertices to keep transfer at", {}, 1, 64, true},
      {"elements",
       "cells",
       "what is summed over: cells that are cut further near each vertex, or as published one disc for each vertex",
       {"cells", "discs"}},
      {"lights",
       "scene",
       "which lights the table must serve: those of the scene, or any (an edit of lights needs no new table)",
       {"scene", "any"}},
      {"view", "any", "any camera, or only what this one sees", {"any", "fixed"}},
      {"max_relative_error", "3e-3", "of the gather behind the table", {}, 1e-7, 1},
      {"order", "0", "of the harmonics; 0: 7, and 3 beside reference points", {}, 0, highest_order, true},
      {"references", "0", "reference points; 0: 1.53 vertices^0.68, about as published", {}, 0, 10'000'000, true},
      {"selection",
       "transfer",
       "of the reference points: by the shape alone, as published, or two in five where the transfer needs them",
       {"shape", "transfer"}},
      {"weights",
       "least_squares",
       "of the reference points: by place, as published, or by least squares",
       {"barycentric", "least_squares"}},
      {"file", "", "where the table is kept and taken up again", {}, 0, 0, false, true}};
}

TransferSettings read_transfer_settings(const Settings& s) {
  TransferSettings t;
  t.profile = s.word("profile");
  const std::string& form = s.word("form");
  t.form = form == "vector"      ? TransferForm::vectors
           : form == "lloyd"     ? TransferForm::lloyd
           : form == "harmonics" ? TransferForm::harmonics
           : form == "reference" ? TransferForm::references
                                 : TransferForm::floats;
  t.directions = static_cast<int>(s.number("directions"));
  t.interpolation = s.word("interpolation") == "twelve" ? DirectionInterpolation::twelve : DirectionInterpolation::four;
  t.distances = static_cast<int>(s.number("distances"));
  t.parts = static_cast<int>(s.number("subdivide"));
  t.discs = s.word("elements") == "discs";
  t.any_light = s.word("lights") == "any";
  t.fixed_view = s.word("view") == "fixed";
  t.max_relative_error = s.number("max_relative_error");
  t.order = static_cast<int>(s.number("order"));
  if (t.order == 0) t.order = t.form == TransferForm::references ? 3 : 7;
  t.references = static_cast<std::size_t>(s.number("references"));
  t.reference_selection = s.word("selection") == "shape" ? ReferenceSelection::shape : ReferenceSelection::transfer;
  t.reference_weights =
      s.word("weights") == "least_squares" ? ReferenceWeights::least_squares : ReferenceWeights::barycentric;
  t.file = s.word("file");
  return t;
}

}  // namespace opaline
