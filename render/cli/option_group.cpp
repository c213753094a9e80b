// A layer over CLI11 that gives every option three things: how its value is read, how it is said
// again, and which table of a scene file it belongs to. CLI11 has no place for the last two and for
// the list of words, so they are kept where it has one that goes unused:
//
// - what an option says, in its default_function, which CLI11 calls only when it is asked to
//   capture a default;
// - words and tables, as validators that never run (active(false)) with a name and a text.
//
// A second list of options beside CLI11's would have to be kept in step with it.
#include "render/cli/option_group.h"

#include <sstream>

#include <CLI/CLI.hpp>
#include <fmt/ranges.h>

namespace kirireel {
namespace {

// Notes on an option: the words that it accepts, and its table of a scene file.
constexpr const char* kWords = "words";
constexpr const char* kTable = "table";

/// Notes a text on an option, as a check that checks nothing: values are read, and refused, in one
/// place for all options. `kind` is the validator's name, by which noteOf() finds it.
void addNote(CLI::Option& option, const char* kind, const std::string& text) {
  CLI::Validator validator([](std::string&) { return std::string(); }, text, kind);
  option.check(validator.active(false));
}

/// What was noted; "" where nothing was.
std::string noteOf(CLI::Option& option, const char* kind) {
  try {
    // CLI11 tells the text of a check only while it is active.
    CLI::Validator validator = *option.get_validator(kind);
    return validator.active().get_description();
  } catch (const CLI::OptionNotFound&) {
    return "";
  }
}

/// As typed; all values of an option that takes several.
std::string typedText(const CLI::Option& option) {
  std::vector<std::string> texts;
  for (const std::string& text : option.results()) texts.push_back(quotedText(text));
  return quotedList(texts);
}

}  // namespace

OptionGroup::Statement& OptionGroup::Statement::saidAs(const Writer& write) {
  // CLI11's own place for the text of what an option is bound to. It is asked for after parsing, so
  // that the help does not show it.
  option_->default_function(write);
  return *this;
}

OptionGroup::Statement& OptionGroup::Statement::decidesNothing() {
  return saidAs([] { return std::string(); });
}

OptionGroup::Statement& OptionGroup::Statement::accepts(const std::vector<std::string>& words) {
  addNote(*option_, kWords, fmt::format("{}", fmt::join(words, "\n")));
  return *this;
}

OptionGroup::Statement OptionGroup::added(CLI::Option* option) {
  option->group(heading_);
  if (!table_.empty()) addNote(*option, kTable, table_);
  return Statement(option);
}

OptionGroup::Statement OptionGroup::value(const std::string& name, const std::string& unit,
                                          const std::string& usual, const std::string& help,
                                          const Reader& read) {
  // The default is said in words, since CLI11 would print what is bound, and nothing is bound here.
  const std::string text = usual.empty() ? help : fmt::format("{} (default {})", help, usual);
  const auto readText = [name, read](const std::string& typed) { read({name, typed}); };
  CLI::Option* option = command_.add_option_function<std::string>(name, readText, text)
                            ->type_name(unit)
                            ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  return added(option).saidAs([option] { return typedText(*option); });
}

OptionGroup::Statement OptionGroup::values(const std::string& name, const std::string& unit,
                                           const std::string& help, const Reader& read) {
  const auto readTexts = [name, read](const std::vector<std::string>& typed) {
    for (const std::string& text : typed) read({name, text});
  };
  CLI::Option* option =
      command_.add_option_function<std::vector<std::string>>(name, readTexts, help)
          ->type_name(unit)
          ->expected(1)
          ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  return added(option).saidAs([option] { return typedText(*option); });
}

void OptionGroup::setting(const Setting& setting, Scene& scene) {
  const std::string name = setting.option();
  // Settings stand as long as the program runs.
  const auto write = [&setting, &scene] { return setting.write(scene); };
  if (setting.isSwitch) {
    flag(name, setting.help, [&setting, &scene, name] {
      setting.read(scene, {name, ""});
    }).saidAs(write);
    return;
  }
  Statement statement =
      value(name, setting.unit, setting.usual, setting.help,
            [&setting, &scene](const TypedValue& typed) { setting.read(scene, typed); });
  statement.saidAs(write);
  if (!setting.words.empty()) statement.accepts(setting.words);
}

void OptionGroup::number(const std::string& name, double& target, Range range,
                         const std::string& unit, const std::string& help) {
  value(name, unit, fmt::format("{:.4g}", target), help, [&target, range](const TypedValue& typed) {
    target = parseNumber(typed, range);
  }).saidAs([&target] { return numberText(target); });
}

OptionGroup::Statement OptionGroup::flag(const std::string& name, bool& target,
                                         const std::string& help, bool given) {
  return flag(name, help, [&target, given] { target = given; }).saidAs([&target, given] {
    return fmt::format("{}", target == given);
  });
}

OptionGroup::Statement OptionGroup::flag(const std::string& name, const std::string& help,
                                         const std::function<void()>& action) {
  CLI::Option* option = command_.add_flag_callback(name, action, help);
  return added(option).saidAs([option] { return fmt::format("{}", option->count() > 0); });
}

/// Runs the option's writer: CLI11 keeps what it gives as the default's text.
std::string saidBy(CLI::Option& option) {
  return option.capture_default_str()->get_default_str();
}

std::vector<std::string> allowedWords(CLI::Option& option) {
  std::vector<std::string> words;
  std::istringstream lines(noteOf(option, kWords));
  for (std::string word; std::getline(lines, word);) words.push_back(word);
  return words;
}

std::string settingTable(CLI::Option& option) {
  return noteOf(option, kTable);
}

void addPlace(CLI::App& command, const std::string& name, std::filesystem::path& target,
              const std::string& help) {
  command.add_option(name, target, help)->type_name("");
}

void requireGiven(const std::filesystem::path& path, const char* what, const CLI::App& command) {
  if (!path.empty()) return;
  const std::string name = fullName(command);
  throw InputError(fmt::format("error: {0} is missing, as in {1} {0}; see {1} --help", what, name));
}

const CLI::App& chosenCommand(const CLI::App& program) {
  const CLI::App* command = &program;
  // CLI11 lists the commands that were parsed, and only one can be.
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  return *command;
}

std::string fullName(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return parent == nullptr ? command.get_name() : fullName(*parent) + " " + command.get_name();
}

}  // namespace kirireel
