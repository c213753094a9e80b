/// Options for reading a model.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/length_unit.h"

namespace kirireel::formats {

/// Options for reading a model.
struct ReadSettings {
  std::filesystem::path jointsFile;  ///< replaces the model's own list of joints, if not empty
  bool strict = false;               ///< refuse input that needs a repair
  bool joinCoplanar = false;         ///< in meshes: coplanar faces with a common edge form one tile
  std::optional<int> frame;          ///< of a FOLD file: read only this frame, 0 is the key frame
  std::optional<double> fold;  ///< of a FOLD file: fold of letters without an angle, as a fraction
                               ///< of 180 degrees, (0, 1]; absent: 1

  // Options of cut patterns.
  std::vector<std::string> cut;     ///< colours, layers and ids of lines to cut; empty: all
  std::vector<std::string> ignore;  ///< the same of lines to ignore
  double neckWidth = 0;             ///< largest gap at the end of a cut, in `unit`; 0: automatic
  bool areJointsInNecks = false;    ///< joints in the middle of their necks, not at cut ends
  /// Unit of lengths in options and in written files, and of the file's lengths unless the file
  /// declares a unit. Absent: the unit that the file declares, else `undeclaredUnit`.
  std::optional<LengthUnit> unit;
  LengthUnit undeclaredUnit;  ///< of lengths without a declared unit, if `unit` is absent
};

}  // namespace kirireel::formats
