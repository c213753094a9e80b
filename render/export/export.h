/// Exports states of a trajectory to files for other programs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/fea/deck.h"
#include "render/fea/element_mesh.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel::exports {

/// The names of the export formats of a state or the whole deployment, in the order of the help:
/// the first column of the table in export.cpp, which has the files of each format. In file names
/// #### is the requested state (final, 50pct, 1.5s, 30deg), or the number of the sample for `all`.
std::vector<std::string> exportFormatNames();

/// Selection of exports. Defaults are those of the command line.
struct ExportSettings {
  std::vector<std::string> states = {"initial", "final"};  ///< in the syntax of chooseStates
  std::vector<std::string> formats;                        ///< of exportFormatNames()
  fea::ElementRule elements;                               ///< of decks and meshes
  fea::DeckSettings decks;                                 ///< options of decks
  double hingeWidth = 0;  ///< of cut patterns, metres; 0: see writers::cutPattern()
  /// For formats without a fixed unit; absent: millimetres for STL and DXF, else the model's unit.
  /// GLB is in metres, SVG in millimetres; decks have DeckSettings::unit.
  std::optional<LengthUnit> unit;
};

/// The settings with lengths converted from this unit to metres.
ExportSettings inMetres(ExportSettings settings, const LengthUnit& unit);

/// Throws like exportStates for any run of this model: InputError for unknown or repeated formats,
/// and for impossible cut patterns, elements, joint patches and necks, and for drives of tiles that
/// do not exist. Makes the elements of the start once, which is the cost of this early check.
void requireExportable(const model::Model& model, const brick::BrickRule& rule,
                       const ExportSettings& settings);

/// Whether an export of some run may write a file with this name. Names of states with any sample
/// number count.
bool isExported(const std::string& name, const ExportSettings& settings);

/// Warnings for users who request decks of this trajectory, one line each: overlaps of bricks in an
/// exported state, and fewer elements than the default because of many tiles. Empty without
/// requested decks or meshes. Reads the samples of the states.
std::vector<std::string> exportWarnings(const trajectory::TrajectoryReader& trajectory,
                                        const ExportSettings& settings);

/// Writes all files or none to the folder and creates it if needed. Returns their names in order.
/// contents.json lists them. Throws InputError for states that do not exist, for unknown, repeated
/// or impossible formats, and if a file that Kirireel did not write has a name of the export, see
/// FileSet. Throws OutputError if a file cannot be written.
std::vector<std::string> exportStates(const trajectory::TrajectoryReader& trajectory,
                                      const ExportSettings& settings,
                                      const std::filesystem::path& folder);

/// The same for a folder that is being filled: without contents.json and without a check of
/// existing files. After an error all written files are removed. The folder must exist.
std::vector<std::string> exportInto(const trajectory::TrajectoryReader& trajectory,
                                    const ExportSettings& settings,
                                    const std::filesystem::path& folder);

// ------------------------------------------------------------------------------------------------
// Selection of the exported samples of a trajectory.

/// A sample and its label in file names.
struct ChosenState {
  std::size_t sample = 0;  ///< zero-based
  std::string label;       ///< "final", "50pct", "1.5s", "30deg", "event_TEXT"; "0007" of `all`

  bool operator==(const ChosenState&) const = default;
};

/// Throws InputError for a name that is not in the list below.
void requireStateName(const std::string& name);

/// A name in a form for file names: letters, digits, points and hyphens. `sample` is used only for
/// `all`. Throws like requireStateName.
std::string stateLabel(const std::string& name, std::size_t sample);

/// The named samples, ascending. A name is one of
/// - `initial`, `final`, `all`;
/// - `25%`: a fraction of the simulated time, 0 to 100;
/// - `1.5` or `1.5s`: a time, >= 0, at most the end, seconds;
/// - `30deg`: the first sample at which some tile has rotated by this angle from its start;
/// - `event:TEXT`: the first event whose text contains TEXT.
///
/// Fractions, times and events select the nearest sample. Throws InputError for a name that is not
/// in the list, a state that is not in the trajectory, and two names of one sample. Only `initial`
/// and `final` may be one sample, of a run that has no other: one state with the first of these
/// names. An angle reads the trajectory up to its sample. The others read only times.
std::vector<ChosenState> chooseStates(const trajectory::TrajectoryReader& trajectory,
                                      const std::vector<std::string>& names);

// ------------------------------------------------------------------------------------------------
// Sensitivity of a deck's results to its elements.

/// One line for each state that is exported as a deck (with necks one for the flat sheet): the
/// result of its job in CalculiX, and the result with elements half as long. Throws InputError if
/// ccx is not installed, if there are no decks, if elements half as long are too many, and like
/// making elements. Throws RunError if ccx fails. The time is that of two CalculiX runs for each
/// state. The finer one dominates.
std::vector<std::string> meshSensitivity(const trajectory::TrajectoryReader& trajectory,
                                         const ExportSettings& settings);

}  // namespace kirireel::exports
