// PyKirigami's command line has options in snake case, short names of two letters after one hyphen
// (-bt), which CLI11 would read as two options, and a model by --model. The words are rewritten one
// by one before parsing:
//
//     --brick_thickness 0.02  ->  --thickness 0.02
//     -bt 0.02                ->  --thickness 0.02
//     --no_collision          ->  --contacts=unjoined
//     --model cylinder        ->  cylinder
//     --camera_distance 3     ->  (nothing: it moves a window's camera)
//     --headless              ->  (nothing: no window is ever opened)
//
// A table of words, and no aliases among our options: the help stays short, and a value that looks
// like an option is left alone.
#include "render/cli/peer_spellings.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace kirireel {
namespace {

/// With hyphens for underscores. An entry may bring a value along, after an equals sign.
const std::map<std::string, std::string>& peerOptions() {
  static const std::map<std::string, std::string> options = {
      {"--brick-thickness", "--thickness"},
      {"-bt", "--thickness"},
      {"-ss", "--spring-stiffness"},
      {"-fd", "--force-damping"},
      {"--no-adaptive-stiffness", "--no-adaptive"},
      {"--ground-plane", "--ground"},
      {"-gp", "--ground"},
      {"-gf", "--ground-friction"},
      {"--filter-collision", "--contacts=unjoined"},
      {"--no-collision", "--contacts=unjoined"},
      {"--num-substeps", "--substeps"},
      {"--cm-expansion", "--actuation=expansion"},
      {"--target-vertices-file", "--target"},
  };
  return options;
}

/// Options with a value that PyKirigami reads and does nothing with, or that only move its window's
/// camera.
bool isWithoutEffect(const std::string& name) {
  static const std::set<std::string> names = {"--camera-distance", "-cd", "--max-steps",
                                              "--auto-export-interval", "--export-prefix"};
  return names.contains(name);
}

const std::string kLike = "--like";
const std::string kPeer = "pykirigami";

/// Whether the argument at i, perhaps with the next one, is "--like pykirigami".
bool asksForPeer(const std::vector<std::string>& arguments, std::size_t i) {
  if (arguments[i] == kLike) return i + 1 < arguments.size() && arguments[i + 1] == kPeer;
  return arguments[i] == kLike + "=" + kPeer;
}

/// Names without a counterpart come back as they are, with hyphens.
std::string translateName(std::string name) {
  if (name.starts_with("--")) std::replace(name.begin(), name.end(), '_', '-');
  const auto found = peerOptions().find(name);
  return found == peerOptions().end() ? name : found->second;
}

}  // namespace

std::vector<std::string> translatePeerSpellings(const std::vector<std::string>& arguments) {
  std::vector<std::string> translated;
  bool skip = false;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    // The value of an option that was left out.
    if (std::exchange(skip, false)) continue;
    if (asksForPeer(arguments, i)) {
      skip = argument == kLike;
      continue;
    }
    // Values and places. Negative numbers begin with a hyphen too; no name in the table is a
    // number.
    if (!argument.starts_with('-')) {
      translated.push_back(argument);
      continue;
    }
    const std::size_t nameEnd = std::min(argument.find('='), argument.size());
    const std::string name = translateName(argument.substr(0, nameEnd));
    const std::string value = argument.substr(nameEnd);
    if (name == "--headless") continue;
    if (isWithoutEffect(name)) {
      skip = value.empty();  // the value is the next argument
      continue;
    }
    // --model NAME: the name follows as an argument of its own and becomes the place; --model=NAME
    // has it here.
    if (name != "--model") {
      translated.push_back(name + value);
    } else if (!value.empty()) {
      translated.push_back(value.substr(1));
    }
  }
  return translated;
}

bool usesPeerSpellings(const std::vector<std::string>& arguments) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (asksForPeer(arguments, i)) return true;
  }
  return std::ranges::any_of(arguments, [](const std::string& argument) {
    if (!argument.starts_with('-')) return false;
    const std::string name = argument.substr(0, argument.find('='));
    return name == "--model" || isWithoutEffect(translateName(name)) || translateName(name) != name;
  });
}

}  // namespace kirireel
