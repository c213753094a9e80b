/// Snapshot grids: several pictures on one sheet with a caption under each.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/picture/frame.h"
#include "render/picture/label.h"

namespace kirireel::picture {

/// Strip above pictures with their header or title, and its baseline; ems.
inline constexpr double kHeadEms = 1.6;
inline constexpr double kHeadBaselineEms = 1.1;

/// Drawn between consecutive pictures.
inline constexpr const char* kArrow = "\u2192";

/// Rows and columns of a grid, each at least 1.
struct GridShape {
  int rows = 3;     ///< >= 1
  int columns = 3;  ///< >= 1

  /// Number of cells.
  int cells() const { return rows * columns; }
  bool operator==(const GridShape&) const = default;
};

/// One cell of a grid.
struct GridPicture {
  Frame frame;          ///< the whole picture
  std::string caption;  ///< printed centred under the picture, UTF-8; may be empty
};

/// A part of a picture, pixels from its upper left corner.
struct PictureBox {
  int left = 0;    ///< pixels from the left side of the grid
  int upper = 0;   ///< pixels from its upper side
  FrameSize size;  ///< of the picture

  /// The same part of a picture enlarged by `scale`.
  PictureBox scaled(double scale) const;
};

/// The part without the empty margins that all pictures share. A small margin and a caption's width
/// remain. Pixels that equal the first picture's upper left pixel are empty. The pictures, one or
/// more, must have one size.
PictureBox filledPart(const std::vector<GridPicture>& pictures);

/// The part of a picture; it must lie within the picture.
Frame cutOut(const Frame& frame, const PictureBox& part);

/// Letters that name pictures, or rows of a figure.
enum class PanelLetters {
  None,
  Plain,      ///< (a), (b), ... over each picture
  Bracketed,  ///< the same in bold; in a figure of several runs one per row, as for the next
  Small,      ///< a, b, ... in bold
  Capital,    ///< A, B, ... in bold
};

/// Draws the letter of panel `number` (>= 0), if there are letters, and a text to its right.
void drawHead(Surface& surface, PanelLetters form, int number, const std::string& text, double left,
              double baseline, int em, Colour colour);

/// A row of a figure of several runs.
struct GridRow {
  FrameSize picture;  ///< of each of its pictures, at most as wide as a cell
  std::string head;   ///< over the row, UTF-8
  /// Scale of its pictures, if rows have their own scales: a bar in its header.
  std::optional<PictureScale> scale;
};

/// The style of a grid. Lengths are in heights of one picture, so grids of any size appear similar.
struct GridStyle {
  Colour background = {255, 255, 255};  ///< between and around pictures
  Colour text = {30, 30, 30};           ///< of captions
  double captionSize = 0.065;           ///< em of the text; short captions need less height
  double gap = 0.04;                    ///< between cells and around the sheet
  /// Em of all text, pixels, for pictures of any size. Longer captions get more lines.
  std::optional<int> textSize;
  PanelLetters letters = PanelLetters::None;
  bool arrows = false;  ///< from each picture to the next in its row
  /// Headers of the columns, one for each; empty: none.
  std::vector<std::string> heads;
  /// One for each row; empty if all pictures have one size and rows have no headers.
  std::vector<GridRow> rows;
  /// Meaning of the colours of all pictures, drawn below them if present.
  std::optional<ColourScale> colourScale;
  /// The same if colours show kinds of bricks.
  std::vector<LegendEntry> legend;
  /// Scale of all pictures: if present, a bar of a round length is below them.
  std::optional<PictureScale> scale;
};

/// Positions of the cells of a grid, pixels.
struct GridLayout {
  FrameSize sheet;              ///< the whole grid
  FrameSize picture;            ///< one picture; in a figure of several runs, the largest
  int gap = 0;                  ///< around every cell
  int columnGap = 0;            ///< from one column to the next
  int headHeight = 0;           ///< strip above the first row with the columns' headers
  int letterHeight = 0;         ///< strip above each picture
  int captionHeight = 0;        ///< strip below each picture
  int textSize = 0;             ///< em of the caption
  int scaleHeight = 0;          ///< strip for each scale below all pictures, and for a legend
  int scales = 0;               ///< strips below all pictures
  int rowHeadHeight = 0;        ///< strip above each row with its header
  std::vector<FrameSize> rows;  ///< of the pictures of each row, if they differ

  /// Size of the pictures of a row.
  FrameSize pictureOf(int row) const { return rows.empty() ? picture : rows[row]; }
  /// Left edge of a column of cells.
  int left(int column) const { return gap + column * (picture.width + columnGap); }
  /// Left edge of a picture centred in its cell.
  int left(int column, int row) const {
    return left(column) + (picture.width - pictureOf(row).width) / 2;
  }
  /// Upper edge of a row of pictures.
  int upper(int row) const {
    int y = gap + headHeight + rowHeadHeight + letterHeight;
    for (int k = 0; k < row; ++k) {
      y += pictureOf(k).height + captionHeight + gap + rowHeadHeight + letterHeight;
    }
    return y;
  }
};

/// The gap between columns, in heights of a picture. Wider if it has arrows.
double columnGap(const GridStyle& style);

/// The layout of a grid of pictures of one size, with this number of caption lines below each.
/// Throws InputError if the shape is empty, the number of headers differs from that of columns, or
/// the sheet would be larger than kMaxFrameSide.
GridLayout layOutGrid(FrameSize picture, GridShape shape, const GridStyle& style = {},
                      int captionLines = 1);

/// The same with as many lines as the widest of the captions needs.
GridLayout layOutGrid(FrameSize picture, GridShape shape, const GridStyle& style,
                      const std::vector<std::string>& captions);

/// Draws everything on the sheet except the pictures and the background. `columns` of the grid;
/// captions in the order of cells. Throws OutputError if the font is missing.
void drawGridText(Surface& surface, const GridLayout& layout, const GridStyle& style,
                  const std::vector<std::string>& captions, int columns);

/// The captions of pictures.
std::vector<std::string> captionsOf(const std::vector<GridPicture>& pictures);

/// The sheet: pictures fill rows from the left, top row first; other cells stay blank. Throws
/// InputError if there is no picture, more pictures than cells, or their sizes differ; OutputError
/// if the font is missing.
Frame composeGrid(const std::vector<GridPicture>& pictures, GridShape shape,
                  const GridStyle& style = {});

/// Parts of a picture's caption.
struct CaptionParts {
  bool progress = false;  ///< fraction of the motion
  bool time = false;      ///< simulated seconds
  bool angle = false;     ///< largest rotation angle of a brick from its start
  bool error = false;     ///< target error; omitted without a target
  bool gap = false;       ///< largest joint gap
};

/// The state that a caption describes.
struct CaptionValues {
  double progress = 0;          ///< fraction of the motion, [0, 1]
  double time = 0;              ///< simulated seconds
  double angle = 0;             ///< radians
  std::optional<double> error;  ///< metres
  double gap = 0;               ///< metres
  LengthUnit unit;              ///< of lengths in the text
};

/// For example "12.5%, t = 1.25 s, turned 45.0°, error 0.0012 m"; empty when it has no parts.
std::string captionText(const CaptionParts& parts, const CaptionValues& values);

}  // namespace kirireel::picture
