/// sweep.toml: what is run, which parameters are varied, and what each run leaves.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "render/sweep/sweep_plan.h"

namespace kirireel {

/// What each run of a sweep leaves, beside its record.
enum class SweepKeep {
  State,       ///< the end state and the summary
  Trajectory,  ///< trajectory.h5 too
  Pictures,    ///< a snapshot grid too
  All,         ///< all that `kirireel record` leaves
};

/// A key with one value. As written in the file, not yet known to exist.
struct SweepSetting {
  std::string key;
  SweepValue value;
};

/// What a sweep file says. Keys are not known to exist yet.
struct Sweep {
  std::filesystem::path file;
  std::string family;        ///< of generated models; empty: the runs name a model
  FileLocation familyWhere;  ///< in the sweep file
  SweepKeep keep = SweepKeep::State;
  std::vector<SweepSetting> settings;  ///< of all runs, by key
  SweepPlan plan;
  /// Every value that the parameters can have; of ranges both ends.
  std::vector<SweepAxis> axes;
};

/// Reads a sweep file:
///
///     generate = "tessellation"     # a family of models; or model = "FOLDER"
///     scene = "scene.toml"          # optional
///     keep = "state"                # or "trajectory", "pictures", "all"
///     [base]                        # settings of all runs, by the keys of scenes and families
///     duration = 5
///     [grid]                        # every combination
///     columns = [2, 4, 6]
///     spring_stiffness = {from = 10, to = 1000, count = 5, scale = "log"}
///
/// [list] in place of [grid] has as many values for each key, one for each run; [latin_hypercube]
/// has runs = COUNT, random_seed = NUMBER, and ranges {from, to, scale, whole}. Names of files are
/// relative to the sweep file.
///
/// Throws InputError with file:line:column.
Sweep readSweepFile(const std::filesystem::path& path);

}  // namespace kirireel
