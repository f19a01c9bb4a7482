// What the sections ask of the records: groups, fronts, bests.
#pragma once

#include "validate/record.h"

#include <optional>
#include <string>
#include <vector>

namespace opaline {

/// The error that ranks techniques: RMS of the difference / RMS of the reference.
inline constexpr const char* headline_error = "relative_rmse";

/// All records of one scene with one material, which may be compared with each other.
struct SceneGroup {
  std::string scene, material;
  std::vector<const Record*> records;
  std::string title() const { return material.empty() ? scene : scene + ", " + material; }
};

/// Groups in the order of their first record. The records must outlive the groups.
std::vector<SceneGroup> scene_groups(const std::vector<Record>& records);

/// Names in the order of their first record, each once.
std::vector<std::string> technique_names(const std::vector<Record>& records);

/// The finite error of a finished record by that name, or nothing.
std::optional<double> error_of(const Record& record, const std::string& metric = headline_error);

/// The finite headline error against truth, where the suite asks for it.
std::optional<double> truth_error_of(const Record& record);

/// A finished record with a headline error and a frame time: one that can be ranked.
bool is_ranked(const Record& record);

/// The Pareto front of error against frame time (render, median): those ranked records than which no other is both
/// faster and at least as accurate. Fastest first, errors strictly falling.
std::vector<const Record*> frame_front(const std::vector<const Record*>& records);

/// The fastest whose error is at most that; null if there is none.
const Record* cheapest_within(const std::vector<const Record*>& records, double max_error);

/// The least error, of equal ones the fastest; null if none is ranked.
const Record* most_accurate(const std::vector<const Record*>& records);

/// "samples=64 views=camera", or "defaults".
std::string settings_text(const Record& record);

/// "image_space_sampling, gpu".
std::string contender(const Record& record);

/// Anchor of the record's row in the table of all records.
std::string record_anchor(const Record& record);

}  // namespace opaline
