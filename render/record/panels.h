/// Sheets of pictures: states of one run or of several, side by side, as pixels and as vector
/// graphics.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "render/record/record.h"
#include "render/record/replay.h"
#include "render/studio/studio.h"

namespace kirireel {

/// States of one run that stand in a row on a sheet, cell after cell. Rows of a figure may have
/// different models; those of one run have one row, which fills all cells.
struct PanelRow {
  Look look;
  Motif motif;
  std::vector<FrameState> states;
  std::vector<std::string> captions;  ///< one a state
};

/// The name of the sheet's file in this format. PNG has a name of its own, see output::kSnapshots.
const char* pageFile(PageFormat format);

/// What a picture of a state shows.
Moment stillOf(const FrameState& state);

/// One sheet. Belongs to the thread that makes it.
class PanelSheet {
 public:
  /// The rows' states fill the shape from its upper left cell on. What is passed must outlive the
  /// sheet.
  PanelSheet(const std::vector<PanelRow>& rows, GridShape shape, const PictureSettings& settings,
             PictureReport& report)
      : rows_(rows), shape_(shape), settings_(settings), report_(report) {}

  /// Writes snapshots.png and whatever else of the sheet the settings ask for. Throws OutputError.
  /// Paints every picture once, twice where the sheet has a width in print.
  void write();

 private:
  void takeAll(FrameSize size);
  void writeDrawings();
  double enlargement(const PictureBox& part, const GridStyle& style) const;
  int textSize(const PictureBox& part, const GridStyle& style) const;
  void writePage(PageFormat format, const PictureBox& part, const GridLayout& layout,
                 const GridStyle& style);

  const std::vector<PanelRow>& rows_;
  GridShape shape_;
  const PictureSettings& settings_;
  PictureReport& report_;
  std::vector<std::unique_ptr<Studio>> studios_;  ///< one a row
  std::vector<GridPicture> pictures_;
};

}  // namespace kirireel
