/// What the commands and options of the program are, as plain values: for pages, completions and
/// stubs, which all say what the command line itself says.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace kirireel {

/// An option of a command. All texts are those that --help shows; a text that does not apply is
/// empty.
struct OptionDescription {
  std::vector<std::string> names;  ///< with hyphens, e.g. "-h", "--help"; the last one is long
  std::string key;                 ///< its name in a scene file or a program, e.g. "thickness"
  std::string table;               ///< of a scene file; "" where no scene file can set it
  std::string group;               ///< heading in the help, e.g. "Bricks"
  std::string unit;                ///< of the value, e.g. "METRES"; may be empty
  std::string help;                ///< one phrase, with the default
  std::vector<std::string> words;  ///< the values that are allowed; empty where they are no list
  bool isSwitch = false;           ///< has no value
  bool repeats = false;            ///< may be given several times, each counts
};

/// An argument that stands without an option's name.
struct PlaceDescription {
  std::string name;  ///< e.g. "MODEL"
  std::string help;
};

/// A command, or the program itself.
struct CommandDescription {
  std::string name;
  std::string help;    ///< one phrase
  std::string footer;  ///< paragraphs after the options, an empty line between two
  std::vector<PlaceDescription> places;
  std::vector<OptionDescription> options;
  std::vector<CommandDescription> commands;  ///< below it
};

/// Reads a command's description off the command itself, and leaves that as it was. The order of
/// options and commands is that of the help. The command must not have been parsed.
CommandDescription describeCommand(CLI::App& command);

/// The whole program. Its name is "kirireel"; `commands` are those of the program, with theirs
/// below them.
CommandDescription describeProgram();

/// The command below it that has this name. Throws std::out_of_range where there is none.
const CommandDescription& commandNamed(const CommandDescription& program, const std::string& name);

}  // namespace kirireel
