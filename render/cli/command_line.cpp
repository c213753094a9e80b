// How a command line becomes an order:
//
// - 1. Replace PyKirigami's spellings by ours (command_line.h). If there are any, its constants are
//   the defaults of options that are not given. Read underscores in other names as hyphens.
// - 2. CLI11 parses the words. Each option calls a reader that writes into the order of its
//   command. A wrong value throws InputError there, with the same wording for all options. Extra
//   words are allowed at this stage.
// - 3. Reject remaining words, suggesting the nearest existing name. CLI11's own error suggests
//   none.
// - 4. The given command completes its order: it checks combinations and reads its scene file.
//
// The order is a plain value; main() visits it with carryOut(). Before that, nothing is done except
// parsing. Other callers (sweeps, the Python module, tests) make and run orders in the same way.
#include "render/cli/command_line.h"

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include <CLI/CLI.hpp>

#include "render/cli/help.h"
#include "render/cli/option_group.h"
#include "render/cli/report.h"
#include "render/cli/scene_options.h"
#include "render/record/summary.h"
#include "sim/base/error.h"
#include "sim/formats/read_settings.h"
#include "sim/scene/settings.h"

namespace kirireel::cli {
namespace {

constexpr const char* kName = "kirireel";
constexpr const char* kPurpose = "Records kirigami deployments off screen.";

/// Long names with their hyphens, for suggestions.
std::vector<std::string> optionNames(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::vector<std::string> commandNames(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* sub : command.get_subcommands({})) names.push_back(sub->get_name());
  return names;
}

/// For an unknown option: the first command that has it, else the most similar option.
std::string hintFor(const std::string& option, const CLI::App& program, const CLI::App& command) {
  for (const CLI::App* other : program.get_subcommands([](const CLI::App*) { return true; })) {
    if (other->get_option_no_throw(option)) return fmt::format("; {} has it", fullName(*other));
  }
  return suggestion(option, optionNames(command));
}

/// Arguments that CLI11 did not take: the first unknown option, else the first of all.
void requireNoExtraWords(const CLI::App& program) {
  // The remaining words of CLI11 include the "--" that ends the options.
  std::vector<std::string> left = program.remaining(true);
  std::erase(left, "--");
  if (left.empty()) return;
  const CLI::App& command = chosenCommand(program);
  const std::string help = fmt::format("see {} --help", fullName(command));
  // Report an unknown option first: its value also remains, but is not a second error.
  for (const std::string& argument : left) {
    if (!argument.starts_with('-')) continue;
    const std::string name = argument.substr(0, argument.find('='));
    const std::string replacement = replacementOf(name);
    if (!replacement.empty()) {
      throw InputError(fmt::format("error: option {} was removed{}; {}", name, replacement, help));
    }
    throw InputError(
        fmt::format("error: unknown option {}{}; {}", name, hintFor(name, program, command), help));
  }
  // After a command with subcommands, an extra word is a mistyped subcommand.
  const std::vector<std::string> commands = commandNames(command);
  if (!commands.empty()) {
    throw InputError(fmt::format("error: unknown command {}{}; {}", left.front(),
                                 suggestion(left.front(), commands), help));
  }
  throw InputError(fmt::format("error: unexpected argument '{}'; {}", left.front(), help));
}

InputError missingValue(const std::string& option, const CLI::App& command) {
  return InputError(
      fmt::format("error: {} needs a value; see {} --help", option, fullName(command)));
}

/// An empty value is mostly an unset variable of a script.
void requireNoEmptyValue(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    if (!option->get_positional() && has(option->results(), ""))
      throw missingValue(option->get_name(), command);
  }
}

/// `--letters` without one of its words is a switch: the next argument may be positional.
std::vector<std::string> withLetters(std::vector<std::string> arguments) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] != "--letters") continue;
    const std::string next = i + 1 < arguments.size() ? arguments[i + 1] : "";
    if (next != "a" && next != "(a)" && next != "A") arguments[i] += "=true";
  }
  return arguments;
}

/// Parses into the variables of the options, or returns the requested page of help.
std::optional<PrintOrder> parseInto(CLI::App& program, const std::vector<std::string>& arguments) {
  // CLI11 expects the arguments in reverse order.
  std::vector<std::string> reversed = withLetters(translatePeerSpellings(arguments));
  const std::string group = takeHelpGroup(reversed);
  std::reverse(reversed.begin(), reversed.end());
  try {
    program.parse(reversed);
  } catch (const CLI::CallForVersion& call) {
    return PrintOrder{call.what()};
  } catch (const CLI::CallForHelp&) {
    return PrintOrder{helpText(chosenCommand(program), group)};
  } catch (const CLI::ArgumentMismatch& error) {
    // The text starts with the option without its value and a colon.
    const std::string text = error.what();
    throw missingValue(text.substr(0, text.find(':')), chosenCommand(program));
  } catch (const CLI::ConversionError& error) {
    // Only switches convert their values: "Could not convert: --ground = 3".
    const std::string text = error.what();
    const std::size_t begin = text.find("--");
    const std::size_t equals = text.find(" = ", begin);
    throw scene::valueError({text.substr(begin, equals - begin), text.substr(equals + 3)},
                            "no value, true or false");
  } catch (const CLI::ParseError& error) {
    throw InputError(
        fmt::format("error: {}; see {} --help", error.what(), fullName(chosenCommand(program))));
  }
  requireNoEmptyValue(chosenCommand(program));
  return std::nullopt;
}

/// A command of the program.
struct Command {
  CLI::App* app = nullptr;
  /// Checks the order after parsing. `peerSpelling`: the word that selects PyKirigami's constants
  /// if the command runs a scene; empty: none.
  std::function<Order(const std::string& peerSpelling)> completeOrder;
};

/// A command with its order, which its options write.
template <typename OrderType>
Command addCommand(CLI::App& program, CLI::App* (*add)(CLI::App&, OrderType&)) {
  const auto order = std::make_shared<OrderType>();
  CLI::App* app = add(program, *order);
  // Both closures share the order, which lives as long as the list of commands.
  return {app, [app, order](const std::string& peerSpelling) -> Order {
            if constexpr (std::is_same_v<OrderType, RecordOrder>)
              order->peerSpelling = peerSpelling;
            completeOrder(*app, *order);
            return *order;
          }};
}

/// Options of the program, and its commands in the order of the help.
std::vector<Command> addCommands(CLI::App& program) {
  program.allow_extras();
  setHelpLayout(program);
  program.set_version_flag("--version", record::versionText());
  program.footer(fmt::format("kirireel COMMAND --help explains a command.\n\n{}", kExitCodesHelp));
  return {addCommand(program, addRecordCommand),   addCommand(program, addSimulateCommand),
          addCommand(program, addRenderCommand),   addCommand(program, addExportCommand),
          addCommand(program, addGenerateCommand), addCommand(program, addInspectCommand),
          addCommand(program, addConvertCommand),  addCommand(program, addModelsCommand),
          addCommand(program, addStudyCommand),    addCommand(program, addPageCommand),
          addCommand(program, addCurvesCommand),   addCommand(program, addFigureCommand),
          addCommand(program, addSweepCommand),    addCommand(program, addVerifyCommand)};
}

}  // namespace

int carryOut(const PrintOrder& order) {
  fmt::print("{}", order.text);
  return kExitDone;
}

Order parseCommandLine(const std::vector<std::string>& arguments) {
  CLI::App program(kPurpose, kName);
  const std::vector<Command> commands = addCommands(program);
  if (const std::optional<PrintOrder> page = parseInto(program, arguments)) return *page;
  requireNoExtraWords(program);
  for (const Command& command : commands) {
    if (command.app->parsed()) return command.completeOrder(peerSpelling(arguments));
  }
  throw InputError(fmt::format("error: no command given; choose {}, see kirireel --help",
                               scene::listWords(commandNames(program))));
}

LoadedModel loadModel(const std::filesystem::path& place, const std::vector<std::string>& options) {
  LoadedModel loaded{{}, place, options, {}, {}};
  formats::ReadSettings settings;
  CLI::App program(kPurpose, kName);
  program.allow_extras();
  OptionGroup group(program, "Model");
  addReadOptions(group, settings);
  // --help ends parsing with a page of help, which other callers cannot use.
  if (parseInto(program, options)) throw InputError("error: a model is read without --help");
  requireNoExtraWords(program);
  const InputRecord record(loaded.inputs);
  loaded.model = readModelAt(place, {}, settings, loaded.warnings);
  return loaded;
}

RecordOrder parseRunOptions(const LoadedModel& loaded, const std::vector<std::string>& options) {
  CLI::App program(kPurpose, kName);
  program.allow_extras();
  RecordOrder order;
  order.madeModel = loaded.model;
  CLI::App* command = addRecordCommand(program, order);
  // The words of `kirireel record MODEL`: first the options of the model's reading, then the new
  // ones. The later of two values counts.
  std::vector<std::string> words = {command->get_name()};
  if (!loaded.place.empty()) words.push_back(loaded.place.string());
  words.insert(words.end(), loaded.options.begin(), loaded.options.end());
  words.insert(words.end(), options.begin(), options.end());
  if (parseInto(program, words)) throw InputError("error: a model is deployed without --help");
  requireNoExtraWords(program);
  completeOrder(*command, order);
  order.inputs.insert(order.inputs.end(), loaded.inputs.begin(), loaded.inputs.end());
  return order;
}

CommandDescription describeProgram() {
  CLI::App program(kPurpose, kName);
  const std::vector<Command> commands = addCommands(program);
  return describeCommand(program);
}

// ------------------------------------------------------------------------------------------------
// Reads descriptions from CLI11's objects, after all commands were added and before parsing. Manual
// pages, shell completions, the Python stubs and the tests of documentation follow from these
// values, so none of them can differ from --help.

namespace {

/// Short names first, as in the help.
std::vector<std::string> hyphenedNames(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

/// `key` and `table` are those of a scene file; "" if none can set it.
OptionDescription describeOption(CLI::Option& option) {
  // In CLI11 a switch is an option without values.
  const bool isSwitch = option.get_items_expected_max() == 0;
  OptionDescription described;
  described.names = hyphenedNames(option);
  described.key = settingKey(option);
  described.table = settingTable(option);
  described.group = option.get_group();
  described.unit = isSwitch ? "" : option.get_type_name();
  described.help = option.get_description();
  described.words = allowedWords(option);
  described.isSwitch = isSwitch;
  // Options that may be repeated take all values; others the last one.
  described.repeats = option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
  return described;
}

}  // namespace

CommandDescription describeCommand(CLI::App& command) {
  CommandDescription described;
  described.name = command.get_name();
  described.help = command.get_description();
  described.footer = command.get_footer();
  // Positional arguments are options without hyphens in CLI11.
  for (CLI::Option* option : command.get_options()) {
    if (option->get_positional()) {
      described.places.push_back({option->get_name(true), option->get_description()});
    } else {
      described.options.push_back(describeOption(*option));
    }
  }
  for (CLI::App* below : command.get_subcommands({})) {
    described.commands.push_back(describeCommand(*below));
  }
  return described;
}

const CommandDescription& commandNamed(const CommandDescription& program, const std::string& name) {
  const auto found = std::ranges::find(program.commands, name, &CommandDescription::name);
  if (found == program.commands.end()) throw std::out_of_range("no command " + name);
  return *found;
}

// ------------------------------------------------------------------------------------------------
// PyKirigami's options are in snake case. It has short names of two letters after one hyphen (-bt),
// which CLI11 would read as two options, and --model for the model. The words are rewritten one by
// one before parsing:
//
//     --brick_thickness 0.02  ->  --thickness 0.02
//     -bt 0.02                ->  --thickness 0.02
//     --no_collision          ->  --contacts=unjoined
//     --model cylinder        ->  cylinder
//     --camera_distance 3     ->  (nothing: moves the camera of a window)
//     --headless              ->  (nothing: there is no window)
//
// A table of words instead of aliases keeps the help short, and does not change values that start
// with a hyphen.

namespace {

/// All names of PyKirigami and of its paper with their counterparts here; "" for those that have no
/// effect in it or only move its window's camera. An entry may have a value after an equals sign.
/// Names that are the same in both programs are not listed.
const std::map<std::string, std::string>& peerOptions() {
  static const std::map<std::string, std::string> options = {
      {"--brick_thickness", "--thickness"},
      {"-bt", "--thickness"},
      {"--spring_stiffness", "--spring-stiffness"},
      {"-ss", "--spring-stiffness"},
      {"--torque_stiffness", "--torque-stiffness"},
      {"--force_damping", "--force-damping"},
      {"-fd", "--force-damping"},
      {"--torque_damping", "--torque-damping"},
      {"--linear_damping", "--linear-damping"},
      {"--angular_damping", "--angular-damping"},
      {"--no_adaptive_stiffness", "--no-adaptive"},
      {"--ground_plane", "--ground"},
      {"-gp", "--ground"},
      {"--ground_friction", "--ground-friction"},
      {"-gf", "--ground-friction"},
      {"--filter_collision", "--contacts=none"},
      {"--no_collision", "--contacts=unjoined"},
      {"--auto_detect_connections", "--faces=pykirigami"},
      {"--num_substeps", "--substeps"},
      {"--cm_expansion", "--actuation=expansion"},
      {"--target_vertices_file", "--target"},
      {"--model", "--model"},
      {"--camera_distance", ""},
      {"-cd", ""},
      {"--max_steps", ""},
      {"--auto_export_interval", ""},
      {"--export_prefix", ""},
  };
  return options;
}

const std::string kLike = "--like";
const std::string kPeer = "pykirigami";

/// Whether the argument at i, by itself or with the next one, is "--like pykirigami".
bool selectsPeer(const std::vector<std::string>& arguments, std::size_t i) {
  if (arguments[i] == kLike) return i + 1 < arguments.size() && arguments[i + 1] == kPeer;
  return arguments[i] == kLike + "=" + kPeer;
}

/// Replaces the hyphens or underscores within the name of a long option.
std::string withSeparators(std::string name, char from, char to) {
  if (name.starts_with("--")) std::replace(name.begin() + 2, name.end(), from, to);
  return name;
}

/// The counterpart of a name, with hyphens.
std::string translateName(const std::string& name) {
  const auto found = peerOptions().find(withSeparators(name, '-', '_'));
  return found == peerOptions().end() ? withSeparators(name, '_', '-') : found->second;
}

/// Whether an option has PyKirigami's spelling. With hyphens some of its names are ours.
bool isPeerName(const std::string& name) {
  const auto found = peerOptions().find(withSeparators(name, '-', '_'));
  return found != peerOptions().end() && (found->first == name || found->second != name);
}

}  // namespace

std::vector<std::string> translatePeerSpellings(const std::vector<std::string>& arguments) {
  std::vector<std::string> translated;
  bool skip = false;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    // The value of an option without a counterpart.
    if (std::exchange(skip, false)) continue;
    if (selectsPeer(arguments, i)) {
      skip = argument == kLike;
      continue;
    }
    // Values and positional arguments. Negative numbers also begin with a hyphen, but no name in
    // the table is a number.
    if (!argument.starts_with('-')) {
      translated.push_back(argument);
      continue;
    }
    const std::size_t nameEnd = std::min(argument.find('='), argument.size());
    const std::string name = translateName(argument.substr(0, nameEnd));
    const std::string value = argument.substr(nameEnd);
    if (name == "--headless") continue;
    if (name.empty()) {
      skip = value.empty();  // the value is the next argument
      continue;
    }
    // --model NAME: the next argument becomes positional. --model=NAME has the name here.
    if (name != "--model") {
      translated.push_back(name + value);
    } else if (!value.empty()) {
      translated.push_back(value.substr(1));
    }
  }
  return translated;
}

std::string peerSpelling(const std::vector<std::string>& arguments) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (selectsPeer(arguments, i)) return fmt::format("{} {}", kLike, kPeer);
    const std::string name = arguments[i].substr(0, arguments[i].find('='));
    if (isPeerName(name)) return name;
  }
  return "";
}

}  // namespace kirireel::cli
