/// Programs of others, run where they are installed: Gmsh and CalculiX.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kirireel::fea {

// ------------------------------------------------------------------------------------------------
// Programs of others, run where they are installed.

/// A folder for a program's files that vanishes with its owner.
class WorkFolder {
 public:
  /// Throws OutputError when it cannot be made.
  WorkFolder();
  ~WorkFolder();
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  /// The path of a file of this name within the folder, which need not exist.
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// What a program has written into a file; empty where it has written nothing. Throws InputError
/// for files above 4 GiB or that cannot be read.
std::string writtenText(const std::string& file);

/// Runs a program, looked for on the path, with its output in the file `log`, and waits for it. It
/// runs in the folder of that file, where it may leave files of its own.
/// Returns how it ended, as waitpid says: 0 when all is well. Throws InputError when there is no
/// such program; `advice` says what to do then. `words` are the program's name and its arguments,
/// none of them read by a shell.
int runProgram(std::vector<std::string> words, const std::string& log, const std::string& advice);

// ------------------------------------------------------------------------------------------------
// Gmsh as a mesher: a program of its own, looked for when it is needed.

/// The mesh that Gmsh makes of a geometry (.geo), as the text of a Gmsh 2.2 file. Runs `gmsh` on
/// one thread in a folder of its own: the same geometry gives the same mesh. Throws
/// InputError when there is no such program, RunError with its last words when it fails.
std::string meshedByGmsh(const std::string& geometry);

/// The shape of an OpenCASCADE geometry (.geo), as the text of a STEP file, which has lengths in
/// millimetres. Its date is always the same. Throws as meshedByGmsh does.
std::string stepByGmsh(const std::string& geometry);

// ------------------------------------------------------------------------------------------------
// CalculiX as a solver: a program of its own, looked for when it is needed.

/// By how much the two ends that the forces of a job of staticJob pull at part, in the deck's unit
/// of length: the work of the forces, which are 1 N at each end. The job has keywords of CalculiX;
/// `meshText` is the mesh deck that it includes, with its sets. Runs `ccx` in a folder of its own,
/// which is removed in any case. Throws InputError when there is no such program, RunError with its
/// last words when it fails. It takes as long as ccx does: a sparse direct factorisation of three
/// unknowns per node.
double openingByCalculix(const std::string& meshText, std::string jobText);

}  // namespace kirireel::fea
