// One command a family of models (sim/generate/families.h), made from the family's list of
// parameters: name, range, default, unit. A new family needs no line here.
#include "render/cli/generate_command.h"

#include <CLI/CLI.hpp>

#include "render/cli/exit_codes.h"
#include "render/cli/option_group.h"
#include "sim/generate/families.h"
#include "sim/model/folder.h"

namespace kirireel {
namespace {

/// Values are kept by name; what was not given is absent, and the family has its own default.
void addParameter(OptionGroup& group, const FamilyParameter& parameter, GenerateOrder& order) {
  const Range range{parameter.least, parameter.most};
  const auto read = [&order, range, name = parameter.name,
                     whole = parameter.whole](const TypedValue& typed) {
    order.values[name] =
        // Whole numbers are kept as doubles, which hold them exactly up to 2^53.
        whole ? static_cast<double>(parseInteger(typed, range)) : parseNumber(typed, range);
  };
  const auto write = [&order, parameter] {
    const auto given = order.values.find(parameter.name);
    return numberText(given == order.values.end() ? parameter.usual : given->second);
  };
  group
      .value("--" + parameter.name, parameter.unit, fmt::format("{:.6g}", parameter.usual),
             parameter.help, read)
      .saidAs(write);
}

}  // namespace

CLI::App* addFamily(CLI::App& generate, const Family& family, GenerateOrder& order) {
  CLI::App* command = generate.add_subcommand(family.name, family.help);
  addPlace(*command, "FOLDER", order.folder, "where the model goes");
  OptionGroup shape(*command, kShapeGroup);
  for (const FamilyParameter& parameter : family.parameters) addParameter(shape, parameter, order);
  shape.choice<std::optional<JointFace>>("--face", order.face,
                                         {{"auto", std::nullopt},
                                          {"both", JointFace::Both},
                                          {"bottom", JointFace::Bottom},
                                          {"top", JointFace::Top}},
                                         "faces that joints lie on");
  // Called for the family that was given alone, so the order learns its name.
  command->parse_complete_callback([&order, name = family.name] { order.family = name; });
  command->footer(fmt::format("Example:\n  kirireel generate {} my_model", family.name));
  return command;
}

CLI::App* addGenerateCommand(CLI::App& program, GenerateOrder& order) {
  CLI::App* generate = program.add_subcommand("generate", "make a model folder from parameters");
  for (const Family& family : families()) addFamily(*generate, family, order);
  generate->footer("kirireel generate FAMILY --help explains a family.");
  return generate;
}

void completeOrder(const CLI::App& generate, GenerateOrder& order) {
  if (generate.get_subcommands().empty()) {
    throw InputError(
        "error: no family given, as in kirireel generate tessellation FOLDER; see kirireel "
        "generate --help");
  }
  requireGiven(order.folder, "FOLDER", chosenCommand(generate));
}

Model makeModel(const GenerateOrder& order) {
  Model model = generateModel(familyNamed(order.family), order.values);
  if (order.face) {
    for (Joint& joint : model.joints) joint.face = *order.face;
  }
  return model;
}

int carryOut(const GenerateOrder& order) {
  const Model model = makeModel(order);
  writeModelFolder(model, order.folder);
  fmt::print("{}: {} tiles, {} joints\n", order.folder.string(), model.tiles.size(),
             model.joints.size());
  return kExitDone;
}

}  // namespace kirireel
