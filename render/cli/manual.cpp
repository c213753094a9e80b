// Writes man(7): a line that begins with a point is a troff request, a backslash begins an escape,
// and a plain hyphen may become a dash in print. All other text is literal.
//
// A page has the sections NAME, SYNOPSIS, ARGUMENTS, COMMANDS, OPTIONS (with a subsection per group
//    of the help), NOTES or EXAMPLES from the footer, and SEE ALSO (man-pages(7)). It uses the
//    requests
//
//     .TH TITLE SECTION DATE SOURCE MANUAL    .SH heading    .SS heading within    .TP tagged entry
//     .nf / .fi  lines as they are / filled   .sp  an empty line    \fB bold  \fI italic  \fR roman
//
// Pages have no date: the same source always gives the same bytes.
#include "render/cli/manual.h"

#include <algorithm>
#include <cctype>
#include <functional>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace kirireel::cli {
namespace {

/// "\-" is a minus that can be copied from a terminal; "\e" prints a backslash.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char letter : text) {
    if (letter == '\\') {
      result += "\\e";
    } else if (letter == '-') {
      result += "\\-";
    } else {
      result += letter;
    }
  }
  // A zero-width space prevents that troff reads a line as a request.
  const bool isRequest = result.starts_with('.') || result.starts_with('\'');
  return isRequest ? "\\&" + result : result;
}

/// ASCII letters only, as in names of commands.
std::string upperCase(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

/// "kirireel-record".
std::string pageName(const CommandDescription& program, const CommandDescription& command) {
  return fmt::format("{}-{}", program.name, command.name);
}

/// whatis(1) and apropos(1) index the NAME line.
std::string header(const std::string& page, const std::string& purpose,
                   const std::string& version) {
  return fmt::format(".TH {} 1 \"\" \"kirireel {}\" \"Kirireel\"\n.SH NAME\n{} \\- {}\n",
                     escaped(upperCase(page)), escaped(version), escaped(page), escaped(purpose));
}

/// .TP uses the next line as a tag and the one after it as the text.
std::string optionText(const OptionDescription& option) {
  std::string names;
  for (const std::string& name : option.names) {
    if (!names.empty()) names += ", ";
    names += fmt::format("\\fB{}\\fR", escaped(name));
  }
  if (!option.unit.empty()) names += fmt::format(" \\fI{}\\fR", escaped(option.unit));
  return fmt::format(".TP\n{}\n{}\n", names, escaped(option.help));
}

/// The options under the headings of their groups, in the order of the help. `headingMacro` is
/// ".SH" or ".SS".
std::string optionsText(const CommandDescription& command, const char* headingMacro) {
  std::vector<std::string> groups;
  for (const OptionDescription& option : command.options) {
    if (std::ranges::find(groups, option.group) == groups.end()) groups.push_back(option.group);
  }
  std::string text;
  for (const std::string& group : groups) {
    text += fmt::format("{} \"{}\"\n", headingMacro, escaped(group));
    for (const OptionDescription& option : command.options) {
      if (option.group == group) text += optionText(option);
    }
  }
  return text;
}

/// Positional arguments, such as MODEL.
std::string placesText(const CommandDescription& command) {
  std::string text;
  for (const PlaceDescription& place : command.places) {
    text += fmt::format(".TP\n\\fI{}\\fR\n{}\n", escaped(place.name), escaped(place.help));
  }
  return text;
}

/// "kirireel record [OPTIONS] MODEL".
std::string synopsis(const std::string& name, const CommandDescription& command) {
  std::string text = fmt::format("\\fB{}\\fR", escaped(name));
  if (!command.commands.empty()) text += " \\fICOMMAND\\fR";
  text += " [\\fIOPTIONS\\fR]";
  for (const PlaceDescription& place : command.places) {
    text += fmt::format(" \\fI{}\\fR", escaped(place.name));
  }
  return text + "\n";
}

/// The commands below this one, with one phrase each.
std::string commandsText(const std::vector<CommandDescription>& commands) {
  std::string text;
  for (const CommandDescription& command : commands) {
    text += fmt::format(".TP\n\\fB{}\\fR\n{}\n", escaped(command.name), escaped(command.help));
  }
  return text;
}

/// Paragraphs that begin with "Examples:" become sections of that name, others notes. Line breaks
/// are kept (.nf), since examples are commands to be copied.
std::string footerText(const std::string& footer) {
  std::string text;
  // Text before the next line: nothing, an empty line, or a heading.
  std::string gap;
  std::string heading = "NOTES";
  std::string written;
  std::istringstream lines(footer);
  for (std::string line; std::getline(lines, line);) {
    const bool isHeading = line.ends_with(':') && !line.starts_with(' ');
    if (isHeading) heading = upperCase(line.substr(0, line.size() - 1));
    if (line.empty()) heading = "NOTES";
    if (line.empty()) gap = ".sp\n";
    if (isHeading || line.empty()) continue;
    if (heading != written) {
      gap = fmt::format("{}.SH {}\n.nf\n", written.empty() ? "" : ".fi\n", heading);
    }
    text += std::exchange(gap, "");
    written = heading;
    text += escaped(line) + "\n";
  }
  return written.empty() ? text : text + ".fi\n";
}

/// One page per line, separated by commas.
std::string seeAlso(const std::vector<std::string>& pages) {
  std::string text = ".SH SEE ALSO\n";
  for (const std::string& page : pages) {
    text += fmt::format("{}\\fB{}\\fR(1)", &page == &pages.front() ? "" : ",\n", escaped(page));
  }
  return text + "\n";
}

/// A subcommand as a section, with only its own options.
std::string sectionText(const CommandDescription& command) {
  return fmt::format(".SH {}\n{}\n{}{}", escaped(upperCase(command.name)), escaped(command.help),
                     placesText(command), optionsText(command, ".SS"));
}

/// Subcommands are many and short, so they have no page of their own.
std::string commandPage(const CommandDescription& program, const CommandDescription& command,
                        const std::string& version) {
  const std::string fullName = fmt::format("{} {}", program.name, command.name);
  std::string text = header(pageName(program, command), command.help, version);
  text += ".SH SYNOPSIS\n" + synopsis(fullName, command);
  if (!command.places.empty()) text += ".SH ARGUMENTS\n" + placesText(command);
  if (!command.commands.empty()) text += ".SH COMMANDS\n" + commandsText(command.commands);
  text += ".SH OPTIONS\n" + optionsText(command, ".SS");
  for (const CommandDescription& below : command.commands) text += sectionText(below);
  return text + footerText(command.footer) + seeAlso({program.name});
}

/// Lists commands with their purpose. Each has its own page.
std::string programPage(const CommandDescription& program, const std::string& version) {
  std::vector<std::string> others;
  for (const CommandDescription& command : program.commands) {
    others.push_back(pageName(program, command));
  }
  std::string text = header(program.name, program.help, version);
  text += ".SH SYNOPSIS\n" + synopsis(program.name, program);
  text += ".SH COMMANDS\n" + commandsText(program.commands);
  text += ".SH OPTIONS\n" + optionsText(program, ".SS");
  return text + footerText(program.footer) + seeAlso(others);
}

}  // namespace

std::vector<NamedText> manPages(const CommandDescription& program, const std::string& version) {
  std::vector<NamedText> pages = {{program.name + ".1", programPage(program, version)}};
  for (const CommandDescription& command : program.commands) {
    pages.emplace_back(pageName(program, command) + ".1", commandPage(program, command, version));
  }
  return pages;
}

// ------------------------------------------------------------------------------------------------
// Completion scripts for three shells from one source: the descriptions of all commands
// (command_line.h).
//
// - bash (GNU Bash manual, "Programmable Completion"): three functions that map words to lists by
//   `case`, and one that finds the command on the line and the possible last words. "kirireel
//   generate" is the command "generate"; options are looked up by "COMMAND OPTION".
// - zsh (zshcompsys(1)): a specification for _arguments for each command,
//   "--name=[help]:UNIT:(words)" or ":_files".
// - fish (fish documentation, "complete"): one `complete` line per option, with a condition for the
//   given commands.
//
// The scripts are complete tables and do not call the program. A key press does not start it, and a
// broken build cannot break a shell.

namespace {

/// Whether an option's value, or an argument, is a file or a folder. Units are the capitalised
/// words in the help.
bool namesFile(const std::string& unit) {
  static const std::set<std::string> kUnits = {"FILE",  "FOLDER", "MODEL", "TRAJECTORY",
                                               "SWEEP", "IN",     "OUT"};
  return kUnits.contains(unit);
}

/// Calls `visit` with each command and its words ("generate tessellation"; "" for the program).
/// Depth first, a command before its subcommands.
void visitAll(const CommandDescription& command, const std::string& words,
              const std::function<void(const CommandDescription&, const std::string&)>& visit) {
  visit(command, words);
  for (const CommandDescription& below : command.commands) {
    visitAll(below, words.empty() ? below.name : words + " " + below.name, visit);
  }
}

std::vector<std::string> namesOf(const std::vector<CommandDescription>& commands) {
  std::vector<std::string> names;
  for (const CommandDescription& command : commands) names.push_back(command.name);
  return names;
}

/// The text with a backslash before each of these letters.
std::string withBackslashes(const std::string& text, const std::string& letters) {
  std::string result;
  for (const char letter : text) {
    if (letters.find(letter) != std::string::npos) result += '\\';
    result += letter;
  }
  return result;
}

/// In single quotes for a shell.
std::string shellQuoted(const std::string& text) {
  std::string result = "'";
  for (const char letter : text)
    // The quotation ends, an escaped quote follows, and another one begins.
    result += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
  return result + "'";
}

// ---- bash

/// The values of an option: words, "FILES", or nothing for a value that only the user knows. One
/// row of a `case`: the option's names after its command.
std::string valueLine(const std::string& words, const OptionDescription& option) {
  std::vector<std::string> patterns;
  for (const std::string& name : option.names) patterns.push_back(shellQuoted(words + " " + name));
  std::string values = fmt::format("{}", fmt::join(option.words, " "));
  if (values.empty() && namesFile(option.unit)) values = "FILES";
  return fmt::format("    {}) values={} ;;\n", fmt::join(patterns, "|"), shellQuoted(values));
}

/// Switches have no row of values. The word after a switch is completed as an argument.
std::string bashTables(const CommandDescription& program) {
  std::string commands;
  std::string options;
  std::string values;
  visitAll(program, "", [&](const CommandDescription& command, const std::string& words) {
    std::vector<std::string> names;
    for (const OptionDescription& option : command.options) {
      names.insert(names.end(), option.names.begin(), option.names.end());
      if (!option.isSwitch) values += valueLine(words, option);
    }
    if (!command.commands.empty()) {
      commands +=
          fmt::format("    {}) commands={} ;;\n", shellQuoted(words),
                      shellQuoted(fmt::format("{}", fmt::join(namesOf(command.commands), " "))));
    }
    options += fmt::format("    {}) options={} ;;\n", shellQuoted(words),
                           shellQuoted(fmt::format("{}", fmt::join(names, " "))));
  });
  return fmt::format(
      "_kirireel_commands() {{\n  case $1 in\n{}  esac\n}}\n\n"
      "_kirireel_options() {{\n  case $1 in\n{}  esac\n}}\n\n"
      "_kirireel_values() {{\n  case $1 in\n{}    *) return 1 ;;\n  esac\n}}\n\n",
      commands, options, values);
}

constexpr const char* kBashFunction = R"(_kirireel() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}
  local command= commands= options= values= i
  # bash takes --mass=unit apart at the equals sign.
  if [[ $word == = ]]; then
    word=
  elif [[ $before == = ]]; then
    before=${COMP_WORDS[COMP_CWORD - 2]}
  fi
  for ((i = 1; i < COMP_CWORD; i++)); do
    commands=
    _kirireel_commands "$command"
    if [[ " $commands " == *" ${COMP_WORDS[i]} "* ]]; then
      command+=${command:+ }${COMP_WORDS[i]}
    fi
  done
  commands=
  _kirireel_commands "$command"
  _kirireel_options "$command"
  if _kirireel_values "$command $before"; then
    [[ $values == FILES ]] || { COMPREPLY=($(compgen -W "$values" -- "$word")); return; }
    commands=
  elif [[ $word == -* ]]; then
    COMPREPLY=($(compgen -W "$options" -- "$word"))
    return
  fi
  if [[ $commands ]]; then
    COMPREPLY=($(compgen -W "$commands" -- "$word"))
  else
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
  fi
}

complete -F _kirireel kirireel
)";

// ---- zsh

/// Text within the brackets of an _arguments specification, in which some letters are special.
std::string zshText(const std::string& text) {
  return withBackslashes(text, "[]:\\");
}

/// "*" lets an option repeat; "=" allows both --name=value and --name value.
std::string zshOption(const OptionDescription& option, const std::string& name) {
  std::string spec =
      fmt::format("{}{}{}[{}]", option.repeats ? "*" : "", name,
                  option.isSwitch || !name.starts_with("--") ? "" : "=", zshText(option.help));
  if (!option.isSwitch) {
    std::string action = " ";
    if (namesFile(option.unit)) action = "_files";
    if (!option.words.empty()) action = fmt::format("({})", fmt::join(option.words, " "));
    spec += fmt::format(":{}:{}", zshText(option.unit), action);
  }
  return fmt::format("      {} \\\n", shellQuoted(spec));
}

/// A word that is not an option is a subcommand or a file.
std::string zshCase(const CommandDescription& command, const std::string& words) {
  std::string text = fmt::format("    {})\n      _arguments -s \\\n", shellQuoted(words));
  for (const OptionDescription& option : command.options) {
    for (const std::string& name : option.names) text += zshOption(option, name);
  }
  const std::string rest = command.commands.empty()
                               ? "*: :_files"
                               : fmt::format("*: :({})", fmt::join(namesOf(command.commands), " "));
  return text + fmt::format("      {} ;;\n", shellQuoted(rest));
}

constexpr const char* kZshFunction = R"(_kirireel() {
  local command= word
  for word in ${words[2,CURRENT-1]}; do
    if [[ " $(_kirireel_commands "$command") " == *" $word "* ]]; then
      command+=${command:+ }$word
    fi
  done
  _kirireel_arguments "$command"
}

_kirireel "$@"
)";

// ---- fish

/// Condition for exactly these commands.
std::string fishCondition(const CommandDescription& command, const std::string& words) {
  std::string condition = words.empty() ? "__fish_use_subcommand" : "";
  std::size_t start = 0;
  while (start < words.size()) {
    const std::size_t end = std::min(words.find(' ', start), words.size());
    condition += fmt::format("{}__fish_seen_subcommand_from {}", condition.empty() ? "" : "; and ",
                             words.substr(start, end - start));
    start = end + 1;
  }
  if (!words.empty() && !command.commands.empty()) {
    condition += fmt::format("; and not __fish_seen_subcommand_from {}",
                             fmt::join(namesOf(command.commands), " "));
  }
  return condition;
}

/// Only quotes and backslashes are special within single quotes.
std::string fishText(const std::string& text) {
  return "'" + withBackslashes(text, "'\\") + "'";
}

/// -r: requires a value; -f: the value is not a file.
std::string fishOption(const OptionDescription& option, const std::string& condition) {
  std::string line = fmt::format("complete -c kirireel -n {}", fishText(condition));
  for (const std::string& name : option.names) {
    const bool isLong = name.starts_with("--");
    line += fmt::format(" -{} {}", isLong ? 'l' : 's', name.substr(isLong ? 2 : 1));
  }
  if (!option.isSwitch) line += " -r";
  if (!option.isSwitch && !namesFile(option.unit)) line += " -f";
  if (!option.words.empty()) {
    line += fmt::format(" -a {}", fishText(fmt::format("{}", fmt::join(option.words, " "))));
  }
  return fmt::format("{} -d {}\n", line, fishText(option.help));
}

}  // namespace

std::string bashCompletion(const CommandDescription& program) {
  return "# bash completion of kirireel, made from the program's own options\n\n" +
         bashTables(program) + kBashFunction;
}

std::string zshCompletion(const CommandDescription& program) {
  std::string commands;
  std::string cases;
  visitAll(program, "", [&](const CommandDescription& command, const std::string& words) {
    cases += zshCase(command, words);
    if (command.commands.empty()) return;
    commands +=
        fmt::format("    {}) print -r -- {} ;;\n", shellQuoted(words),
                    shellQuoted(fmt::format("{}", fmt::join(namesOf(command.commands), " "))));
  });
  return fmt::format(
      "#compdef kirireel\n# Made from the program's own options.\n\n"
      "_kirireel_commands() {{\n  case $1 in\n{}  esac\n}}\n\n"
      "_kirireel_arguments() {{\n  case $1 in\n{}  esac\n}}\n\n{}",
      commands, cases, kZshFunction);
}

std::string fishCompletion(const CommandDescription& program) {
  std::string text = "# Made from the program's own options.\n";
  visitAll(program, "", [&](const CommandDescription& command, const std::string& words) {
    const std::string condition = fishCondition(command, words);
    for (const CommandDescription& below : command.commands) {
      text += fmt::format("complete -c kirireel -f -n {} -a {} -d {}\n", fishText(condition),
                          below.name, fishText(below.help));
    }
    for (const OptionDescription& option : command.options) text += fishOption(option, condition);
  });
  return text;
}

// ------------------------------------------------------------------------------------------------
// The Python module accepts the program's options as keyword arguments, so they share the
// documentation. Docstrings list options by group with unit and help. The stub (PEP 484, PEP 561)
// types them. A switch is bool, an option with a list of words is Literal[...]. Any other option is
// _Value: Python's text of the value is passed to the program.
//
// kStubHead and kStubRun contain the classes' own properties and must match
// render/python/bindings.cpp; a test compares the two.

namespace {

/// By key, with underscores.
std::vector<OptionDescription> optionsWithout(const CommandDescription& command,
                                              const std::vector<std::string>& leftOut) {
  std::vector<OptionDescription> options = command.options;
  std::erase_if(options, [&](const OptionDescription& option) { return has(leftOut, option.key); });
  return options;
}

/// " thickness (METRES): of the bricks (default ...)".
std::string optionLine(const OptionDescription& option) {
  const std::string unit = option.isSwitch ? "True" : option.unit;
  return fmt::format("    {}{}: {}\n", option.key, unit.empty() ? "" : fmt::format(" ({})", unit),
                     option.help);
}

/// A heading at each change of group; options of a group are consecutive.
std::string optionsDoc(const std::vector<OptionDescription>& options) {
  std::string text;
  std::string group;
  for (const OptionDescription& option : options) {
    if (option.group != group) text += fmt::format("\n{}:\n", option.group);
    group = option.group;
    text += optionLine(option);
  }
  return text;
}

/// Hyphens become underscores, as in Python names: "spring-stiffness" is spring_stiffness.
std::string pythonName(std::string name) {
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

/// The stub's alias _Value is the type of options without a list of words.
std::string typeOf(const OptionDescription& option) {
  if (option.isSwitch) return "bool";
  if (option.words.empty()) return "_Value";
  return fmt::format("Literal[\"{}\"]", fmt::join(option.words, "\", \""));
}

/// Every option is optional. None means that it is not set.
std::string parameters(const std::vector<OptionDescription>& options) {
  std::string text;
  for (const OptionDescription& option : options) {
    text += fmt::format("    {}: Optional[{}] = ...,\n", option.key, typeOf(option));
  }
  return text;
}

/// One overload per family, because each has its own parameters. Underscores are accepted in place
/// of hyphens.
std::string familyStub(const CommandDescription& family) {
  return fmt::format(
      "@overload\ndef generate(\n    family: Literal[{}],\n    *,\n{}) -> Model: ...\n",
      family.name == pythonName(family.name)
          ? fmt::format("\"{}\"", family.name)
          : fmt::format("\"{}\", \"{}\"", family.name, pythonName(family.name)),
      parameters(optionsWithout(family, {"help"})));
}

constexpr const char* kStubHead = R"(# Made from the program's own options.
from os import PathLike
from typing import Any, Callable, Dict, List, Literal, Optional, Sequence, Tuple, Union, overload

import numpy as np
from numpy.typing import NDArray

__version__: str
_Path = Union[str, "PathLike[str]"]
_Value = Union[str, float, "PathLike[str]", Sequence[float], Sequence[str], Sequence[Sequence[float]]]

class Error(Exception): ...
class InputError(Error, ValueError): ...
class OutputError(Error, OSError): ...
class RunError(Error, RuntimeError): ...

class Model:
    @property
    def name(self) -> str: ...
    @property
    def tiles(self) -> List[NDArray[np.float64]]: ...
    @property
    def target(self) -> Optional[List[NDArray[np.float64]]]: ...
    @property
    def joints(self) -> NDArray[np.int32]: ...
    def write(self, path: _Path) -> None: ...

class Sample:
    @property
    def time(self) -> float: ...
    @property
    def joint_gap(self) -> float: ...
    @property
    def target_error(self) -> float: ...
    @property
    def penetration(self) -> float: ...
    @property
    def position(self) -> NDArray[np.float64]: ...
    @property
    def rotation(self) -> NDArray[np.float64]: ...

class Trajectory:
    @property
    def model(self) -> Model: ...
    @property
    def time(self) -> NDArray[np.float64]: ...
    @property
    def position(self) -> NDArray[np.float64]: ...
    @property
    def rotation(self) -> NDArray[np.float64]: ...
    @property
    def velocity(self) -> NDArray[np.float64]: ...
    @property
    def angular_velocity(self) -> NDArray[np.float64]: ...
    @property
    def joint_gap(self) -> NDArray[np.float64]: ...
    @property
    def target_error(self) -> NDArray[np.float64]: ...
    @property
    def penetration(self) -> NDArray[np.float64]: ...
    @property
    def events(self) -> List[Tuple[float, str]]: ...
)";

constexpr const char* kStubRun = R"(
class Run(Trajectory):
    @property
    def outcome(self) -> str: ...
    @property
    def reason(self) -> str: ...
    @property
    def at_target(self) -> Optional[bool]: ...
    @property
    def shortfall(self) -> str: ...
    @property
    def summary(self) -> Dict[str, Any]: ...
    def save(self, folder: _Path) -> List[str]: ...

def open(path: _Path) -> Trajectory: ...
)";

}  // namespace

const std::vector<std::string>& optionsNotForRuns() {
  static const std::vector<std::string> names = {
      "help",          "out",    "json", "resume", "joints_file", "frame",       "fold",
      "join_coplanar", "strict", "page", "cut",    "ignore",      "widest_neck", "joint_at"};
  return names;
}

std::vector<std::string> optionsNotForPictures(const CommandDescription& program) {
  static const std::vector<std::string> groups = {"Style", "Camera"};
  static const std::vector<std::string> keys = {"size", "gl"};
  std::vector<std::string> names;
  for (const OptionDescription& option : commandNamed(program, "render").options) {
    if (!has(groups, option.group) && !has(keys, option.key)) names.push_back(option.key);
  }
  return names;
}

std::string deployDoc(const CommandDescription& program) {
  return "Deploys a model as `kirireel record` would, in memory. Returns a Run.\n"
         "\n"
         "on_sample is called with each Sample; the run ends if it returns False. Ctrl-C raises\n"
         "KeyboardInterrupt. A scene.toml in the model's folder is read, as by the program. "
         "Lengths\n"
         "of options are in the unit of the model, those of results in metres; times are "
         "simulated\n"
         "seconds, masses kilograms.\n" +
         optionsDoc(optionsWithout(commandNamed(program, "record"), optionsNotForRuns()));
}

std::string generateDoc(const CommandDescription& program) {
  std::string text =
      "Makes a model of a family, as `kirireel generate` does. Returns a Model.\n\n"
      "Parameters by family; lengths in metres, angles in degrees.\n";
  for (const CommandDescription& family : commandNamed(program, "generate").commands) {
    text += fmt::format("\n{}: {}\n", pythonName(family.name), family.help);
    for (const OptionDescription& option : optionsWithout(family, {"help"})) {
      text += optionLine(option);
    }
  }
  return text;
}

std::string renderDoc(const CommandDescription& program) {
  return "Paints the sample nearest to a time (simulated seconds; None: the last one). Returns an\n"
         "array height x width x 4 of bytes, RGBA, rows from the top.\n" +
         optionsDoc(
             optionsWithout(commandNamed(program, "render"), optionsNotForPictures(program)));
}

std::string pythonStub(const CommandDescription& program) {
  std::string text = kStubHead;
  text += fmt::format(
      "    def render(\n    self,\n    time: Optional[float] = ...,\n    *,\n{}    ) -> "
      "NDArray[np.uint8]: ...\n{}",
      parameters(optionsWithout(commandNamed(program, "render"), optionsNotForPictures(program))),
      kStubRun);
  // The options of reading are those of `convert`.
  text +=
      fmt::format("def read(\n    path: _Path,\n    *,\n{}) -> Model: ...\n",
                  parameters(optionsWithout(commandNamed(program, "convert"), {"help", "target"})));
  for (const CommandDescription& family : commandNamed(program, "generate").commands) {
    text += familyStub(family);
  }
  return text +
         fmt::format(
             "def deploy(\n    model: Model,\n    *,\n    on_sample: "
             "Optional[Callable[[Sample], Optional[bool]]] = ...,\n{}) -> Run: ...\n",
             parameters(optionsWithout(commandNamed(program, "record"), optionsNotForRuns())));
}

}  // namespace kirireel::cli
