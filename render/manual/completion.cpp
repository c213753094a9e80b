// Three shells, three languages, one source: the descriptions of all commands (cli/command_tree.h).
//
// - bash (GNU Bash manual, "Programmable Completion"): three functions that map words to lists by
//   `case`, and one that finds out which command stands on the line and what its last word may be.
//   "kirireel generate" is the command "generate"; options are looked up by "COMMAND OPTION".
// - zsh (zshcompsys(1)): a specification for _arguments for each command,
//   "--name=[help]:UNIT:(words)" or ":_files".
// - fish (fish documentation, "complete"): one `complete` line an option, with a condition that
//   tells which commands were given.
//
// The scripts are complete tables and do not call the program, so that a key press costs no start
// of it, and a broken build cannot break a shell.
#include "render/manual/completion.h"

#include <functional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace kirireel {
namespace {

/// Whether an option's value, or an argument, names a file or a folder. Units are the words in
/// capitals that the help shows.
bool namesFile(const std::string& unit) {
  static const std::set<std::string> kUnits = {"FILE",  "FOLDER", "MODEL", "TRAJECTORY",
                                               "SWEEP", "IN",     "OUT"};
  return kUnits.contains(unit);
}

/// Calls `visit` with each command and its words ("generate tessellation"; "" for the program).
/// Depth first, the command itself before those below it.
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

/// In single quotes for a shell.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char letter : text)
    // The quotation ends, an escaped quote follows, and another one begins.
    result += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
  return result + "'";
}

// ---- bash

/// What follows an option: words, "FILES", or nothing for a value that only the user knows. One row
/// of a `case`: the option's names after its command.
std::string valueLine(const std::string& words, const OptionDescription& option) {
  std::vector<std::string> patterns;
  for (const std::string& name : option.names) patterns.push_back(quoted(words + " " + name));
  std::string values = fmt::format("{}", fmt::join(option.words, " "));
  if (values.empty() && namesFile(option.unit)) values = "FILES";
  return fmt::format("    {}) values={} ;;\n", fmt::join(patterns, "|"), quoted(values));
}

/// Switches have no row among the values, so that what follows them is completed as an argument.
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
      commands += fmt::format("    {}) commands={} ;;\n", quoted(words),
                              quoted(fmt::format("{}", fmt::join(namesOf(command.commands), " "))));
    }
    options += fmt::format("    {}) options={} ;;\n", quoted(words),
                           quoted(fmt::format("{}", fmt::join(names, " "))));
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

/// Within the brackets of a specification of _arguments, where some letters have a meaning.
std::string zshText(const std::string& text) {
  std::string result;
  for (const char letter : text) {
    if (letter == '[' || letter == ']' || letter == ':' || letter == '\\') result += '\\';
    result += letter;
  }
  return result;
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
  return fmt::format("      {} \\\n", quoted(spec));
}

/// What is no option is a command below, or else a file.
std::string zshCase(const CommandDescription& command, const std::string& words) {
  std::string text = fmt::format("    {})\n      _arguments -s \\\n", quoted(words));
  for (const OptionDescription& option : command.options) {
    for (const std::string& name : option.names) text += zshOption(option, name);
  }
  const std::string rest = command.commands.empty()
                               ? "*: :_files"
                               : fmt::format("*: :({})", fmt::join(namesOf(command.commands), " "));
  return text + fmt::format("      {} ;;\n", quoted(rest));
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

/// True where exactly these commands were given.
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

/// Only quotes and backslashes have a meaning within single quotes.
std::string fishText(const std::string& text) {
  std::string result = "'";
  for (const char letter : text) {
    if (letter == '\'' || letter == '\\') result += '\\';
    result += letter;
  }
  return result + "'";
}

/// -r: needs a value; -f: which is no file.
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
    commands += fmt::format("    {}) print -r -- {} ;;\n", quoted(words),
                            quoted(fmt::format("{}", fmt::join(namesOf(command.commands), " "))));
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

}  // namespace kirireel
