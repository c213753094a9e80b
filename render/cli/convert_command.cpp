// Reads a model in any format that readModel() knows and writes it in the one that the ending of
// OUT names. Positions are written to the last bit; what a format cannot hold (a .fold file has no
// faces of joints in thick bricks, for example) is for writeModel() to say.
#include "render/cli/convert_command.h"

#include <CLI/CLI.hpp>

#include "render/cli/exit_codes.h"
#include "render/cli/model_place.h"
#include "render/cli/option_group.h"
#include "sim/model/read_model.h"

namespace kirireel {

CLI::App* addConvertCommand(CLI::App& program, ConvertOrder& order) {
  CLI::App* command = program.add_subcommand("convert", "write a model in another format");
  addPlace(*command, "IN", order.input, kModelHelp);
  addPlace(*command, "OUT", order.output,
           "a .fold file, an .obj file (the target goes to NAME_deployed.obj), NAME_vertices.txt "
           "for the planar files of the quasicrystal simulator, or a folder");
  OptionGroup group(*command, "Model");
  addTargetOption(group, order.target);
  addReadOptions(group, order.reading);
  command->footer(
      "Examples:\n  kirireel convert data/tessellation_4x4 sheet.fold\n"
      "  kirireel convert NAME_contracted.obj my_model\n"
      "  kirireel convert data/penrose_30 penrose_vertices.txt");
  return command;
}

void completeOrder(const CLI::App& command, ConvertOrder& order) {
  requireGiven(order.input, "IN", command);
  requireGiven(order.output, "OUT", command);
}

int carryOut(const ConvertOrder& order) {
  const Model model = readModelAt(order.input, order.target, order.reading);
  writeModel(model, order.output);
  fmt::print("{}: {} tiles, {} joints{}\n", order.output.string(), model.tiles.size(),
             model.joints.size(), model.target ? ", a target" : "");
  return kExitDone;
}

}  // namespace kirireel
