#include "render/cli/generate_command.h"

#include <CLI/CLI.hpp>

#include "render/cli/exit_codes.h"
#include "render/cli/option_group.h"
#include "sim/model/folder.h"

namespace kirireel {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

}  // namespace

CLI::App* addGenerateCommand(CLI::App& program, GenerateOrder& order) {
  CLI::App* generate = program.add_subcommand("generate", "make a model folder from parameters");
  CLI::App* command =
      generate->add_subcommand("tessellation", "rotating rectangles, joined at their corners");
  addPlace(*command, "FOLDER", order.folder, "where the model goes");
  OptionGroup group(*command, "Shape");
  TessellationShape& shape = order.shape;
  group.integer("--columns", shape.columns, {1, 1000}, "COUNT", "tiles along x");
  group.integer("--rows", shape.rows, {1, 1000}, "COUNT", "tiles along y");
  group.number("--length", shape.length, {1e-9, 1e9}, "METRES", "of a tile along x when closed");
  group.number("--width", shape.width, {1e-9, 1e9}, "METRES", "of a tile along y when closed");
  const auto angle = [&group](const std::string& name, double& target, const std::string& help) {
    group.value(name, "DEGREES", fmt::format("{:g}", target / kDegree), help,
                [&target](const OptionValue& typed) {
                  target = parseNumber(typed, {0, 180}) * kDegree;
                });
  };
  angle("--start-angle", shape.startAngle, "between neighbours at the start, 0 is closed");
  angle("--target-angle", shape.targetAngle, "between neighbours at the target");
  group.choice<JointFace>(
      "--face", shape.face,
      {{"both", JointFace::Both}, {"bottom", JointFace::Bottom}, {"top", JointFace::Top}},
      "faces that joints lie on");
  command->footer("Example:\n  kirireel generate tessellation my_model --columns 8 --rows 5");
  return generate;
}

void requireFamily(const CLI::App& generate) {
  if (!generate.get_subcommands().empty()) return;
  throw InputError(
      "error: no family given, as in kirireel generate tessellation FOLDER; see kirireel generate "
      "--help");
}

int carryOut(const GenerateOrder& order) {
  const Model model = makeTessellation(order.shape);
  writeModelFolder(model, order.folder);
  fmt::print("{}: {} tiles, {} joints\n", order.folder.string(), model.tiles.size(),
             model.joints.size());
  return kExitDone;
}

}  // namespace kirireel
