/// States of a trajectory as files for other programs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/fea/deck.h"
#include "render/fea/element_mesh.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel::exports {

/// The names of the formats that a state, or the whole deployment, can be written as, in the order
/// of the help: the first words of the table in export.cpp, which says what files each one has. In
/// their names #### is the state as it was asked for (final, 50pct, 1.5s, 30deg), or the number of
/// the sample with `all`.
std::vector<std::string> exportFormatNames();

/// What is to be exported. Defaults are those of the command line.
struct ExportSettings {
  std::vector<std::string> states = {"initial", "final"};  ///< as chooseStates reads them
  std::vector<std::string> formats;                        ///< of exportFormatNames()
  fea::ElementRule elements;                               ///< of decks and meshes
  fea::DeckSettings decks;                                 ///< how decks are written
  double hingeWidth = 0;  ///< of cut patterns, metres; 0: see writers::cutPattern()
  /// Of files whose formats leave the unit open; absent: millimetres for STL and DXF, else the
  /// model's unit. GLB is in metres, SVG in millimetres; decks have DeckSettings::unit.
  std::optional<LengthUnit> unit;
};

/// The settings with their lengths, which were given in this unit, in metres.
ExportSettings inMetres(ExportSettings settings, const LengthUnit& unit);

/// Throws what exportStates would throw for any run of this model: InputError for formats
/// that are none or given twice, cut patterns, elements, joint patches and necks that it cannot
/// have, and drives of tiles that it does not have. It makes the elements of the start once, which
/// is the price of an early answer.
void requireExportable(const model::Model& model, const model::BrickRule& rule,
                       const ExportSettings& settings);

/// Whether an export of some run may write a file of this name. Names of states with any sample's
/// number count.
bool isExported(const std::string& name, const ExportSettings& settings);

/// What to tell the person who asked for decks of this trajectory, one line each: bricks that
/// overlap in a state that is exported, and elements that are fewer than usual because the tiles
/// are many. Empty where no deck or mesh is asked for. Reads the samples of the states.
std::vector<std::string> exportWarnings(const trajectory::TrajectoryReader& trajectory,
                                        const ExportSettings& settings);

/// Writes the files into the folder, which is made if need be. Returns their names in order. Either
/// all of them appear or none; contents.json lists them. Throws InputError for states that are not
/// there, formats that are none or given twice, formats that the model cannot have, and where files
/// of others are in the way, see FileSet; OutputError if a file cannot be written.
std::vector<std::string> exportStates(const trajectory::TrajectoryReader& trajectory,
                                      const ExportSettings& settings,
                                      const std::filesystem::path& folder);

/// The same into a folder that is being filled: without contents.json, and files there are not
/// checked. What was written before an error is removed. The folder must exist.
std::vector<std::string> exportInto(const trajectory::TrajectoryReader& trajectory,
                                    const ExportSettings& settings,
                                    const std::filesystem::path& folder);

// ------------------------------------------------------------------------------------------------
// Which samples of a trajectory are exported.

/// A sample and what its files are called.
struct ChosenState {
  std::size_t sample = 0;  ///< its number, from 0
  std::string label;       ///< "final", "50pct", "1.5s", "30deg", "event_TEXT"; "0007" of `all`

  bool operator==(const ChosenState&) const = default;
};

/// Throws InputError for a name that is not in the list below, for any trajectory.
void requireStateName(const std::string& name);

/// A name as part of a file's: letters, digits, points and hyphens. The sample counts only for
/// `all`. Throws as requireStateName does.
std::string stateLabel(const std::string& name, std::size_t sample);

/// The samples that are named, rising. A name is one of
/// - `initial`, `final`, `all`;
/// - `25%`: a share of the simulated time, 0 to 100;
/// - `1.5` or `1.5s`: a time, from 0 to the end, seconds;
/// - `30deg`: the first sample at which some tile has turned so far from its start;
/// - `event:TEXT`: the first event whose text contains this.
///
/// Shares, times and events select the nearest sample. Throws InputError for a name that is not in
/// the list, a state that is not in the trajectory, and two names of one sample. An angle reads the
/// trajectory up to its sample; the others read only times.
std::vector<ChosenState> chooseStates(const trajectory::TrajectoryReader& trajectory,
                                      const std::vector<std::string>& names);

// ------------------------------------------------------------------------------------------------
// How much what a deck says depends on its elements.

/// One line for each state that settings export as a deck (with necks one for the flat sheet): what
/// its job gives in CalculiX, and what it gives with elements half as long. Throws InputError when
/// ccx is not installed, when there are no decks, when elements half as long are too many, and what
/// making elements throws; RunError when ccx fails. Takes as long as CalculiX does, twice for each
/// state; the finer one dominates.
std::vector<std::string> meshSensitivity(const trajectory::TrajectoryReader& trajectory,
                                         const ExportSettings& settings);

}  // namespace kirireel::exports
