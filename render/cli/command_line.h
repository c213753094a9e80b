/// The command line: what kirireel is asked to do.
#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "render/record/record.h"
#include "sim/model/tessellation.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// `kirireel record MODEL` and `kirireel simulate MODEL`.
struct RecordOrder {
  std::filesystem::path model;
  Scene scene;              ///< everything but the model; the ground's height is not known yet
  RecordSettings settings;  ///< the folder is empty when --out was not given
  bool printJson = false;   ///< the summary on standard output as JSON
};

/// `kirireel generate tessellation FOLDER`.
struct GenerateOrder {
  TessellationShape shape;
  std::filesystem::path folder;
};

/// `--help` and `--version`.
struct PrintOrder {
  std::string text;
};

/// One of the things that kirireel does.
using Order = std::variant<RecordOrder, GenerateOrder, PrintOrder>;

/// Reads the arguments that follow the program's name. Throws InputError for an unknown option
/// (suggesting the nearest), a value out of range, a missing or surplus argument.
Order parseCommandLine(const std::vector<std::string>& arguments);

}  // namespace kirireel
