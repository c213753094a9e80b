#include "render/cli/model_place.h"

#include <optional>

#include "sim/model/read_model.h"

namespace kirireel {

std::filesystem::path findModel(const std::filesystem::path& named) {
  const std::filesystem::path inData = "data" / named;
  const bool onlyInData = !std::filesystem::exists(named) && std::filesystem::exists(inData);
  return onlyInData ? inData : named;
}

void addTargetOption(OptionGroup& group, std::filesystem::path& target) {
  group.value("--target", "MODEL", "the model's own", "another model whose start is the target",
              [&target](const OptionValue& typed) { target = typed.text; });
}

Model readModelAt(const std::filesystem::path& place, const std::filesystem::path& target) {
  std::optional<std::filesystem::path> named;
  if (!target.empty()) named = findModel(target);
  std::vector<std::string> warnings;
  Model model = readModel(findModel(place), named, warnings);
  for (const std::string& warning : warnings) fmt::print(stderr, "kirireel: {}\n", warning);
  return model;
}

}  // namespace kirireel
