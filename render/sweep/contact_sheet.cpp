#include "render/sweep/contact_sheet.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "render/grid/grid.h"
#include "render/studio/studio.h"
#include "sim/base/error.h"
#include "sim/model/folder.h"

namespace kirireel {
namespace {

constexpr FrameSize kPictureSize = {320, 240};

/// Paints end states, all in one graphics context.
class EndStatePainter {
 public:
  /// Bricks made of the tiles where they ended look as the deployed bricks do.
  Frame paint(const std::filesystem::path& vertices) {
    Model model;
    model.tiles = readTileFile(vertices);
    const Motif motif = makeMotif(model, {}, std::nullopt);
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

GridShape shapeFor(std::size_t pictures) {
  const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(pictures))));
  const int count = static_cast<int>(pictures);
  return {(count + columns - 1) / columns, columns};
}

}  // namespace

Frame composeContactSheet(const std::vector<ContactPicture>& pictures) {
  if (pictures.empty()) throw InputError("error: no run is done, there is nothing to show");
  const std::size_t count = std::min(pictures.size(), kMostContacts);
  EndStatePainter painter;
  std::vector<GridPicture> cells;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t chosen = count == 1 ? 0 : i * (pictures.size() - 1) / (count - 1);
    cells.push_back({painter.paint(pictures[chosen].vertices), pictures[chosen].caption});
  }
  return composeGrid(cells, shapeFor(count));
}

}  // namespace kirireel
