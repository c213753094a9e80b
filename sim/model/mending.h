/// What readers put right in files that say something odd but clear, and how it is told.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/model/joint_checks.h"
#include "sim/model/model.h"

namespace kirireel {

/// How a model is to be read.
struct ReadSettings {
  std::filesystem::path jointsFile;  ///< in place of the model's own list of joints; empty for that
  bool strict = false;               ///< refuse what would be mended
};

/// "file:line: mended: what was found; what was done".
std::string toString(const Mend& mend);

/// Adds a mend to the model and its line to the warnings.
void noteMend(Mend mend, Model& model, std::vector<std::string>& warnings);

/// Throws InputError for the first mend of the model, which says how to put its file right.
void refuseMends(const Model& model);

/// Drops rows that hold corners on no face that earlier rows do not hold already, in either order
/// of the two ends, and cuts others down to the faces that are new.
/// `model` gets the mend; the joints themselves are still rows of `table`. O(rows log rows).
void dropRepeatedJoints(JointTable& table, Model& model, std::vector<std::string>& warnings);

/// Notes that a file of joints holds nothing, not even a comment: its tiles are loose.
void noteNoJoints(const std::filesystem::path& file, Model& model,
                  std::vector<std::string>& warnings);

/// Joints whose corners stand apart by what rounding explains, collected to be told as one mend.
class RoundedCorners {
 public:
  explicit RoundedCorners(const Model& model);

  /// `gap` in metres, at most samePlaceTolerance(); `place` says where the joint is written.
  void add(const Joint& joint, double gap, const std::string& place);

  /// Notes them, if there are any.
  void note(Model& model, std::vector<std::string>& warnings);

 private:
  Mend mend_;
  double lastPlace_;
  double least_;  // that is told: below it a gap is the design's own precision
  double largest_ = 0;
};

/// Where a table names what is not there, but all of it is there when counted from the other of 0
/// and 1, shifts the rows' numbers.
/// Nothing happens where the usual base fits. The model's fileOrder learns the base of its file.
void mendBase(JointTable& table, const TileTable& tiles, Model& model,
              std::vector<std::string>& warnings);

/// Gives all tiles of a flat start the same sense, anticlockwise seen from above: of those that run
/// clockwise the vertices are reversed, in every state, and with them the corners of joints, hull
/// and mends; model.fileOrder notes which. A start that is all clockwise stays as it is when its
/// target leaves the plane, since the joints' faces hang on it; a warning tells. To be called once
/// the model is whole. `table` says where tiles stand.
void turnClockwiseTiles(const TileTable& table, Model& model, std::vector<std::string>& warnings);

}  // namespace kirireel
