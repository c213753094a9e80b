// The page is chosen in two steps: which runs, then how many columns.
//
// A series is a run of neighbours in the table that differ in the last parameter alone; of a grid
// of a x b values there are a series of b. When all n runs fit (n <= 100), all are shown. Otherwise
// every so many series, and of each every so many runs, first and last among them, so that the ends
// of both parameters are on the page.
//
// With series of s pictures, a row of c columns keeps what is alike in one column when c divides s
// or s divides c. Among these c the page whose sides differ least is taken, if they differ by less
// than a factor of 4; otherwise c = ceil(sqrt n).
//
// Each picture has its own scale, because models of a sweep may differ in size by orders of
// magnitude.
#include "render/sweep/contact_sheet.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "render/studio/studio.h"
#include "render/sweep/captions.h"
#include "sim/base/error.h"
#include "sim/model/folder.h"

namespace kirireel {
namespace {

/// Pixels. A hundred of them make a page of 3200 x 2400 and a little more for captions.
constexpr FrameSize kPictureSize = {320, 240};

/// Of a series of more, when not all pictures find room. Ten by ten pictures is kMostContacts.
constexpr std::size_t kMostOfSeries = 10;

/// Rows may end where series do when the page is at most this many times longer than it is wide, or
/// wider than it is long.
constexpr double kMostStretch = 4;

/// Paints end states, all in one graphics context.
class EndStatePainter {
 public:
  /// Bricks made of the tiles where they ended look as the deployed bricks do.
  Frame paint(const ContactPicture& picture) {
    // An empty picture in the colour of the page keeps the place of a run that failed.
    if (picture.vertices.empty()) return makeFrame(kPictureSize, Style().background);
    Model model;
    model.tiles = readTileFile(picture.vertices);
    BrickRule rule;
    rule.thickness = picture.thickness;
    const Motif motif = makeMotif(model, rule, std::nullopt);
    // A graphics context takes longer to make than a small picture to paint.
    if (studio_) {
      studio_->show({}, motif);
    } else {
      studio_.emplace(kPictureSize, Look(), motif);
    }
    return studio_->take({0, motif.start, {}});
  }

 private:
  std::optional<Studio> studio_;
};

/// At most so many of the numbers from 0 on, evenly, the first and the last among them.
std::vector<std::size_t> chooseEvenly(std::size_t count, std::size_t most) {
  const std::size_t chosen = std::min(count, most);
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < chosen; ++i) {
    // Rounded down, which keeps both ends: i = chosen - 1 gives count - 1.
    numbers.push_back(chosen == 1 ? 0 : i * (count - 1) / (chosen - 1));
  }
  return numbers;
}

/// How many times longer one side of the page is than the other.
double stretch(std::size_t columns, std::size_t count) {
  const double rows = std::ceil(static_cast<double>(count) / static_cast<double>(columns));
  const double ratio = rows / static_cast<double>(columns);
  return std::max(ratio, 1 / ratio);
}

/// As many columns as rows, or as near as it goes with rows that end where series do.
GridShape shapeFor(std::size_t count, std::size_t series) {
  auto best = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  double least = kMostStretch;
  for (std::size_t columns = 1; series > 1 && series < count && columns <= count; ++columns) {
    if (series % columns != 0 && columns % series != 0) continue;
    if (stretch(columns, count) >= least) continue;
    least = stretch(columns, count);
    best = columns;
  }
  return {static_cast<int>((count + best - 1) / best), static_cast<int>(best)};
}

/// How many pictures come in a series; 1 unless all series have equally many.
std::size_t seriesLength(const std::vector<ContactPicture>& pictures) {
  const auto isAlike = [](const ContactPicture& a, const ContactPicture& b) {
    return std::equal(a.values.begin(), a.values.end() - 1, b.values.begin());
  };
  std::vector<std::size_t> lengths;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (i == 0 || !isAlike(pictures[i - 1], pictures[i])) lengths.push_back(0);
    ++lengths.back();
  }
  // A list or a Latin hypercube has no such order.
  const bool isEven = std::all_of(lengths.begin(), lengths.end(),
                                  [&](std::size_t length) { return length == lengths.front(); });
  return isEven ? lengths.front() : 1;
}

}  // namespace

ContactLayout layOutContacts(std::size_t count, std::size_t series) {
  if (count <= kMostContacts) return {chooseEvenly(count, count), shapeFor(count, series)};
  if (series == 1 || series == count) {
    return {chooseEvenly(count, kMostContacts), shapeFor(kMostContacts, 1)};
  }
  const auto across = chooseEvenly(series, kMostOfSeries);
  const auto down = chooseEvenly(count / series, kMostContacts / across.size());
  ContactLayout layout;
  for (const std::size_t one : down) {
    for (const std::size_t place : across) layout.chosen.push_back(one * series + place);
  }
  layout.shape = shapeFor(layout.chosen.size(), across.size());
  return layout;
}

Frame composeContactSheet(const std::vector<std::string>& keys,
                          const std::vector<ContactPicture>& pictures) {
  if (pictures.empty()) throw InputError("error: no run is done, there is nothing to show");
  const ContactLayout layout = layOutContacts(pictures.size(), seriesLength(pictures));
  std::vector<std::vector<std::string>> values;
  for (const std::size_t chosen : layout.chosen) values.push_back(pictures[chosen].values);
  const std::vector<std::string> captions = captionsOf(keys, values);
  EndStatePainter painter;
  std::vector<GridPicture> cells;
  for (std::size_t i = 0; i < captions.size(); ++i) {
    const ContactPicture& picture = pictures[layout.chosen[i]];
    const char* const note = picture.vertices.empty() ? ": failed" : "";
    cells.push_back({painter.paint(picture), captions[i] + note});
  }
  return composeGrid(cells, layout.shape);
}

}  // namespace kirireel
