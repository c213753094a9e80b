/// Models as they are named on the command line.
#pragma once

#include <filesystem>

#include "render/cli/option_group.h"
#include "sim/model/mending.h"
#include "sim/model/model.h"

namespace kirireel {

/// What stands for MODEL in a command's help.
inline constexpr const char* kModelHelp =
    "folder with vertices.txt and constraints.txt, any file of a planar model (NAME_vertices.txt "
    "with NAME_constraints.txt beside it), a .fold file, a contracted .obj file, a .ply mesh, or a "
    "cut pattern (.svg, .dxf)";

/// Adds --target. Empty when it was not given. The target must outlive the parsing.
void addTargetOption(OptionGroup& group, std::filesystem::path& target);

/// Adds --joints-file and --strict. Both decide how files are read, and no more. The settings must
/// outlive the parsing.
void addReadOptions(OptionGroup& group, ReadSettings& settings);

/// Where a model stands: as named, or in data/ when it stands only there, or among the models that
/// were installed with the program. As named where it stands nowhere, so that the error names what
/// the user typed.
std::filesystem::path findModel(const std::filesystem::path& named);

/// Reads the model, in data/ too when it stands only there, as PyKirigami's users name theirs.
/// Warnings are appended, also of tiles that overlap at the start. Throws InputError.
Model readModelAt(const std::filesystem::path& place, const std::filesystem::path& target,
                  const ReadSettings& settings, std::vector<std::string>& warnings);

/// The same; warnings go to standard error.
Model readModelAt(const std::filesystem::path& place, const std::filesystem::path& target,
                  const ReadSettings& settings);

/// Prints warnings on standard error, each on one line.
void printWarnings(const std::vector<std::string>& warnings);

}  // namespace kirireel
