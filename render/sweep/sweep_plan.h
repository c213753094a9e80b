/// Which runs a sweep consists of.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/error.h"

namespace kirireel::sweep {

/// One value of a parameter, as it would be typed on a command line.
struct SweepValue {
  std::string text;       ///< "25", "0,0,-9.81", "true"
  bool isSwitch = false;  ///< true or false, not a text
  FileLocation where;     ///< in the sweep file

  /// Whether the texts are the same; their places do not matter.
  bool operator==(const SweepValue& other) const { return text == other.text; }
};

/// The number that a text is as a whole, if it is one. Locales do not matter.
std::optional<double> numberIn(const std::string& text);

/// Values that come before others in tables: numbers by size, before texts by letters.
bool comesBefore(const SweepValue& a, const SweepValue& b);

/// A parameter and values of it.
struct SweepAxis {
  std::string key;                 ///< an option or a parameter of a family, as in a scene file
  FileLocation where;              ///< of the key
  std::vector<SweepValue> values;  ///< in the file's order, at least one
};

/// Numbers between two ends.
struct SweepRange {
  double from = 0;           ///< the first end
  double to = 0;             ///< the other end, above or below the first
  bool logarithmic = false;  ///< equal ratios instead of equal differences; ends are positive
  bool whole = false;        ///< rounded to whole numbers

  /// The number at a share of the way, 0 to 1, as text of at most 9 digits. Share 0 is `from`, 1 is
  /// `to`. Logarithmic: from (to / from)^share.
  std::string at(double share) const;
};

/// A range of a parameter.
struct SweepRangeAxis {
  std::string key;     ///< as of a SweepAxis
  FileLocation where;  ///< of the key
  SweepRange range;    ///< its ends, and how numbers lie between them
};

/// The runs of a sweep, sorted by their parameters, one after the other. Each run of a grid is made
/// on request: the largest grid takes no memory.
class SweepPlan {
 public:
  SweepPlan() = default;

  /// All combinations of the axes' values; the last axis changes fastest. Repeated values count
  /// once.
  static SweepPlan grid(std::vector<SweepAxis> axes);

  /// One run for each place in the axes' values, which are equally many. Repeated runs count once.
  static SweepPlan list(const std::vector<SweepAxis>& axes);

  /// `count` runs that have one value in each of `count` equal parts of every range, at random
  /// (McKay, Beckman, Conover 1979). The same seed gives the same runs on every machine.
  static SweepPlan latinHypercube(const std::vector<SweepRangeAxis>& axes, std::size_t count,
                                  std::uint64_t seed);

  /// How many runs there are; the largest number when there are more. An overflow gives 2^64 - 1.
  std::uint64_t size() const;

  /// In the order of the axes, which is that of the table's columns.
  const std::vector<std::string>& keys() const { return keys_; }

  /// The values of a run, one for each key; index below size().
  std::vector<SweepValue> run(std::uint64_t index) const;

 private:
  std::vector<std::string> keys_;
  std::vector<std::vector<SweepValue>> axes_;  ///< of a grid
  std::vector<std::vector<SweepValue>> rows_;  ///< of anything else
};

// ------------------------------------------------------------------------------------------------
// sweep.toml: what is run, which parameters are varied, and what each run leaves.

/// What each run of a sweep leaves, besides its record.
enum class SweepKeep {
  State,       ///< the end state and the summary
  Trajectory,  ///< trajectory.h5 too
  Pictures,    ///< a snapshot grid too
  All,         ///< all that `kirireel record` leaves
};

/// A key with one value. As written in the file, not yet known to exist.
struct SweepSetting {
  std::string key;   ///< an option or a parameter of a family
  SweepValue value;  ///< as it was written
};

/// What a sweep file says. Keys are not known to exist yet.
struct Sweep {
  std::filesystem::path file;          ///< the sweep file itself
  std::string family;                  ///< of generated models; empty: the runs name a model
  FileLocation familyWhere;            ///< in the sweep file
  SweepKeep keep = SweepKeep::State;   ///< what runs leave in their folders
  std::vector<SweepSetting> settings;  ///< of all runs, by key
  SweepPlan plan;                      ///< which runs there are
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

}  // namespace kirireel::sweep
