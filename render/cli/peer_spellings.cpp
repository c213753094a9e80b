#include "render/cli/peer_spellings.h"

#include <algorithm>
#include <map>

namespace kirireel {
namespace {

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
  };
  return options;
}

std::string translateName(std::string name) {
  if (name.starts_with("--")) std::replace(name.begin(), name.end(), '_', '-');
  const auto found = peerOptions().find(name);
  return found == peerOptions().end() ? name : found->second;
}

}  // namespace

std::vector<std::string> translatePeerSpellings(const std::vector<std::string>& arguments) {
  std::vector<std::string> translated;
  for (const std::string& argument : arguments) {
    if (!argument.starts_with('-')) {
      translated.push_back(argument);
      continue;
    }
    const std::size_t nameEnd = std::min(argument.find('='), argument.size());
    const std::string name = translateName(argument.substr(0, nameEnd));
    const std::string value = argument.substr(nameEnd);
    if (name == "--headless") continue;
    if (name != "--model") {
      translated.push_back(name + value);
    } else if (!value.empty()) {
      translated.push_back(value.substr(1));
    }
  }
  return translated;
}

}  // namespace kirireel
