/// The runs of a sweep.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/error.h"

namespace kirireel::sweep {

/// One value of a parameter, as typed on a command line.
struct SweepValue {
  std::string text;       ///< "25", "0,0,-9.81", "true"
  bool isSwitch = false;  ///< true or false, not a text
  FileLocation where;     ///< in the sweep file

  /// Compares the texts, not their positions in the file.
  bool operator==(const SweepValue& other) const { return text == other.text; }
};

/// The number, if the whole text is one. Independent of the locale.
std::optional<double> numberIn(const std::string& text);

/// Order of values in tables: numbers by size, then texts by letters.
bool comesBefore(const SweepValue& a, const SweepValue& b);

/// A parameter and its values.
struct SweepAxis {
  std::string key;                 ///< an option or a parameter of a family, as in a scene file
  FileLocation where;              ///< of the key
  std::vector<SweepValue> values;  ///< in the order of the file, at least one
};

/// Numbers between two ends.
struct SweepRange {
  double from = 0;           ///< the first end
  double to = 0;             ///< the other end, above or below the first
  bool logarithmic = false;  ///< equal ratios instead of equal differences; ends are > 0
  bool whole = false;        ///< rounded to whole numbers

  /// The number at a fraction of the range, [0, 1], as text of at most 9 digits. 0 is `from`, 1 is
  /// `to`. Logarithmic: from (to / from)^share.
  std::string at(double share) const;
};

/// A range of a parameter.
struct SweepRangeAxis {
  std::string key;     ///< as of a SweepAxis
  FileLocation where;  ///< of the key
  SweepRange range;    ///< its ends and spacing
};

/// The runs of a sweep, sorted by their parameters. Runs of a grid are computed on request, so a
/// grid of any size takes no memory.
class SweepPlan {
 public:
  SweepPlan() = default;

  /// All combinations of the axes' values; the last axis changes fastest. Repeated values count
  /// once.
  static SweepPlan grid(std::vector<SweepAxis> axes);

  /// One run for each position in the lists of values, all of one length. Repeated runs count once.
  static SweepPlan list(const std::vector<SweepAxis>& axes);

  /// `count` random runs with one value in each of `count` equal parts of every range (McKay,
  /// Beckman, Conover 1979). The same seed gives the same runs on every machine.
  static SweepPlan latinHypercube(const std::vector<SweepRangeAxis>& axes, std::size_t count,
                                  std::uint64_t seed);

  /// The number of runs, at most 2^64 - 1.
  std::uint64_t size() const;

  /// In the order of the axes, as the columns of the table.
  const std::vector<std::string>& keys() const { return keys_; }

  /// The values of a run, one for each key; index < size().
  std::vector<SweepValue> run(std::uint64_t index) const;

 private:
  std::vector<std::string> keys_;
  std::vector<std::vector<SweepValue>> axes_;  ///< of a grid
  std::vector<std::vector<SweepValue>> rows_;  ///< of other plans
};

// ------------------------------------------------------------------------------------------------
// sweep.toml: the model, the varied parameters, and the files that each run keeps.

/// The files that each run of a sweep keeps, besides its record.
enum class SweepKeep {
  State,       ///< the end state and the summary
  Trajectory,  ///< also trajectory.h5
  Pictures,    ///< also a snapshot grid
  All,         ///< all files of `kirireel record`
};

/// A key with one value, as written in the file. Not yet checked.
struct SweepSetting {
  std::string key;   ///< an option or a parameter of a family
  SweepValue value;  ///< as it was written
};

/// Whether the values of a key are paths. Those of a sweep file are relative to it.
inline bool isFileKey(const std::string& key) {
  return key == "model" || key == "target" || key == "scene";
}

/// The content of a sweep file. Its keys are not yet checked.
struct Sweep {
  std::filesystem::path file;          ///< the sweep file itself
  std::string family;                  ///< of generated models; empty: `model` is given
  FileLocation familyWhere;            ///< in the sweep file
  SweepKeep keep = SweepKeep::State;   ///< the files that runs keep
  std::vector<SweepSetting> settings;  ///< of all runs, by key
  SweepPlan plan;                      ///< the runs
  /// All values of the parameters; of ranges both ends.
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
/// [list] instead of [grid] has one value per run for each key. [latin_hypercube] has runs = COUNT,
/// random_seed = NUMBER, and ranges {from, to, scale, whole}. Names of files are relative to the
/// sweep file.
///
/// Throws InputError with file:line:column.
Sweep readSweepFile(const std::filesystem::path& path);

}  // namespace kirireel::sweep
