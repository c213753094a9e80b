/// Runs installed external programs: Gmsh and CalculiX.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kirireel::fea {

// ------------------------------------------------------------------------------------------------
// External programs.

/// A temporary folder for a program's files, removed with this object.
class WorkFolder {
 public:
  /// Throws OutputError if it cannot be made.
  WorkFolder();
  ~WorkFolder();
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  /// The path for a file with this name in the folder; the file need not exist.
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// The contents of a program's output file; empty if it has written nothing. Throws InputError for
/// files above 4 GiB and for unreadable files.
std::string writtenText(const std::string& file);

/// Runs a program from the search path and waits for it. The file `log` gets its output, and its
/// working folder is that of `log`. `words` are the program's name and its arguments, without a
/// shell. Returns its status as in waitpid, 0 for success. Throws InputError if there is no such
/// program, with `advice` for the user.
int runProgram(std::vector<std::string> words, const std::string& log, const std::string& advice);

// ------------------------------------------------------------------------------------------------
// Gmsh as a mesher: an external program, required only when used.

/// Gmsh's mesh of a geometry (.geo), as the text of a Gmsh 2.2 file. Runs `gmsh` on one thread in a
/// temporary folder: equal geometries give equal meshes. Throws InputError if there is no such
/// program, RunError with its last output if it fails.
std::string meshedByGmsh(const std::string& geometry);

/// The shape of an OpenCASCADE geometry (.geo), as the text of a STEP file in millimetres. Its date
/// is constant. Throws like meshedByGmsh.
std::string stepByGmsh(const std::string& geometry);

// ------------------------------------------------------------------------------------------------
// CalculiX as a solver: an external program, required only when used.

/// Throws InputError if there is no such program.
void requireCalculix();

/// The relative displacement of the two loaded ends in a job of staticJob, in the deck's unit of
/// length. It is computed as the work of the forces, which are 1 N. The job uses CalculiX's
/// keywords. `meshText` is the included mesh deck with its sets. Runs `ccx` in a temporary folder,
/// which is always removed. Throws InputError if there is no such program, RunError with its last
/// output if it fails. The time is that of ccx: a sparse direct factorisation of three unknowns per
/// node.
double openingByCalculix(const std::string& meshText, std::string jobText);

}  // namespace kirireel::fea
