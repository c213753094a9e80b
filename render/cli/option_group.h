/// Options of one group in a command's help.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "render/cli/option_values.h"

namespace CLI {
class App;
}

namespace kirireel {

/// Adds options of one group to a command; each knows how to read its value, so that every wrong
/// value is reported in the same words.
class OptionGroup {
 public:
  /// `command` and every target given below must outlive the parsing.
  OptionGroup(CLI::App& command, std::string group) : command_(command), group_(std::move(group)) {}

  using Reader = std::function<void(const OptionValue&)>;

  /// An option with a value that `read` understands. `unit` and `usual` (the default, none when
  /// empty) are for the help. Given several times, the last one counts.
  void value(const std::string& name, const std::string& unit, const std::string& usual,
             const std::string& help, const Reader& read);

  /// The same for an option that may be given several times; each value is read in turn.
  void values(const std::string& name, const std::string& unit, const std::string& help,
              const Reader& read);

  /// A number within a range; the target's value is the default.
  void number(const std::string& name, double& target, Range range, const std::string& unit,
              const std::string& help);

  /// A whole number within a range; the target's value is the default.
  template <typename Integer>
  void integer(const std::string& name, Integer& target, Range range, const std::string& unit,
               const std::string& help) {
    value(name, unit, fmt::format("{}", target), help, [&target, range](const OptionValue& typed) {
      target = static_cast<Integer>(parseInteger(typed, range));
    });
  }

  /// One of several words; the first is the default.
  template <typename T, typename Target>
  void choice(const std::string& name, Target& target, const Choices<T>& choices,
              const std::string& help) {
    const std::vector<std::string> words = choiceNames(choices);
    value(name, "WORD", words.front(), fmt::format("{}: {}", help, listWords(words)),
          [&target, choices](const OptionValue& typed) { target = parseChoice(typed, choices); });
  }

  /// An option without a value.
  void flag(const std::string& name, const std::string& help, const std::function<void()>& action);

 private:
  CLI::App& command_;
  std::string group_;
};

/// Adds the argument that stands without an option's name.
void addPlace(CLI::App& command, const std::string& name, std::filesystem::path& target,
              const std::string& help);

/// Throws InputError when an argument is missing: `what` is its name.
void requireGiven(const std::filesystem::path& path, const char* what, const CLI::App& command);

/// The command with those it belongs to, e.g. "kirireel generate tessellation".
std::string fullName(const CLI::App& command);

/// The innermost command that was given, e.g. "generate tessellation".
const CLI::App& chosenCommand(const CLI::App& program);

}  // namespace kirireel
