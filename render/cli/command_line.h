/// Parses the command line.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "render/cli/figure_command.h"
#include "render/cli/model_commands.h"
#include "render/cli/record_command.h"
#include "render/cli/run_commands.h"
#include "render/cli/sweep_command.h"

namespace CLI {
class App;
}

namespace kirireel::cli {

/// `--help` and `--version`. The text is the whole page, made while parsing.
struct PrintOrder {
  std::string text;  ///< complete output with line ends
};

/// Prints the text. Returns the exit code. Always 0.
int carryOut(const PrintOrder& order);

/// A parsed command. It contains all values that carryOut() needs and no references to the parser.
using Order = std::variant<RecordOrder, RenderOrder, ExportOrder, GenerateOrder, InspectOrder,
                           ConvertOrder, ModelsOrder, StudyOrder, SweepOrder, VerifyOrder,
                           CurvesOrder, FigureOrder, PageOrder, PrintOrder>;

/// A model in memory, with the files, options and warnings of its reading.
struct LoadedModel {
  model::Model model;                 ///< the model itself
  std::filesystem::path place;        ///< the folder or file as named; may be empty
  std::vector<std::string> options;   ///< of `record`, used for reading
  std::vector<InputFile> inputs;      ///< its files
  std::vector<std::string> warnings;  ///< about these files, one line each
};

/// Reads a model like `kirireel record MODEL OPTIONS`; the options are --joints-file and --strict.
/// Throws the errors of readModel() and parseCommandLine().
LoadedModel loadModel(const std::filesystem::path& place, const std::vector<std::string>& options);

/// The complete order of `kirireel record` with these options for a model in memory. Throws the
/// errors of parseCommandLine().
RecordOrder parseRunOptions(const LoadedModel& loaded, const std::vector<std::string>& options);

/// Reads the arguments that follow the program's name. Throws InputError for an unknown option
/// (suggesting the nearest), a value out of range, a missing or extra argument. Reads scene files
/// that the arguments name, but no models.
Order parseCommandLine(const std::vector<std::string>& arguments);

// ------------------------------------------------------------------------------------------------
// The commands and options of the program as plain values, for man pages, completions and stubs.

/// An option of a command. All texts are as in --help; a text that does not apply is empty.
struct OptionDescription {
  std::vector<std::string> names;  ///< with hyphens, e.g. "-h", "--help"; the last one is long
  std::string key;                 ///< its name in a scene file or a program, e.g. "thickness"
  std::string table;               ///< of a scene file; "" if no scene file can set it
  std::string group;               ///< heading in the help, e.g. "Bricks"
  std::string unit;                ///< of the value, e.g. "LENGTH"; may be empty
  std::string help;                ///< one phrase, with the default
  std::vector<std::string> words;  ///< the allowed values; empty if any value is allowed
  bool isSwitch = false;           ///< has no value
  bool repeats = false;            ///< may be repeated, each value counts
};

/// A positional argument.
struct PlaceDescription {
  std::string name;  ///< e.g. "MODEL"
  std::string help;  ///< one line
};

/// A command, or the program itself.
struct CommandDescription {
  std::string name;    ///< as typed, such as "record"
  std::string help;    ///< one phrase
  std::string footer;  ///< paragraphs after the options, an empty line between two
  std::vector<PlaceDescription> places;      ///< positional arguments, in their order
  std::vector<OptionDescription> options;    ///< in the order of its help
  std::vector<CommandDescription> commands;  ///< below it
};

/// Reads a command's description from the command itself without changing it. Options and commands
/// are in the order of the help. The command must not have been parsed.
CommandDescription describeCommand(CLI::App& command);

/// Describes the whole program, "kirireel". `commands` are those of the program, with their own
/// subcommands.
CommandDescription describeProgram();

/// The subcommand with this name. Throws std::out_of_range if there is none.
const CommandDescription& commandNamed(const CommandDescription& program, const std::string& name);

// ------------------------------------------------------------------------------------------------
// Command lines of other programs, accepted for their users.
//
// Our own spellings pass through unchanged. A line may mix both.

/// The arguments with PyKirigami's spellings replaced by Kirireel's. Underscores in the names of
/// long options become hyphens, --brick_thickness or -bt becomes --thickness, --no_collision
/// becomes --contacts=unjoined (its effect there), --model NAME becomes the positional model.
/// --headless is removed, because no window is ever opened, and so is --like pykirigami. Values are
/// unchanged. Does not throw: the parser reports unknown options.
std::vector<std::string> translatePeerSpellings(const std::vector<std::string>& arguments);

/// The first argument that is PyKirigami's own name or "--like pykirigami". It selects PyKirigami's
/// defaults. Empty without such an argument. Other underscores are only read as hyphens.
std::string peerSpelling(const std::vector<std::string>& arguments);

}  // namespace kirireel::cli
