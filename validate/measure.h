// One cell from beginning to end.
#pragma once

#include "render/gl/context.h"
#include "validate/measured_scene.h"

namespace opaline {

struct MeasureContext {
  const Suite& suite;
  const std::string& folder;  ///< of the records
  const gl::Context* gl;      ///< null without a GL
  const std::string& no_gl;   ///< why there is none
  const CellChoice& choice;   ///< for the commands in the records
};

/// Fills the record of the cell, whose names are set: status, times, errors, images, counters. Never throws for what a
/// technique does: that is a failed cell, or one that is not applicable.
void measure_cell(const MeasureContext& context, const Cell& cell, MeasuredScene& scene, Record& record);

/// Names, settings, hash and machine of a record that is about to be measured.
Record new_record(const Suite& suite, const SceneCase& scene, const Cell& cell);

}  // namespace opaline
