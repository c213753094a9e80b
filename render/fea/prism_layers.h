/// Prisms on quadrilaterals, layer by layer.
#pragma once

#include <array>
#include <vector>

#include "render/fea/element_mesh.h"
#include "render/fea/footprint.h"

namespace kirireel {

/// Lays the elements of a mesh's rule on quadrilaterals: solids between levels of points, shells
/// and plane elements on a single level.
class PrismLayers {
 public:
  /// How many levels of points the rule asks for; quadratic solids have one halfway up each layer.
  /// 1 for shells and plane elements, `through` + 1 for linear solids, 2 `through` + 1 for
  /// quadratic.
  static int levelCount(const ElementRule& rule);

  /// Adds the nodes. `levels` holds the points that cells refer to, bottom first, metres. The mesh
  /// must outlive this. Each level has the same number of points; `cells` index them.
  PrismLayers(ElementMesh& mesh, std::vector<std::array<int, 4>> cells,
              const std::vector<std::vector<Vector3>>& levels);

  /// Adds the elements on some cells, one layer after the other. `sides` are those of these cells,
  /// numbered from `firstCell`. The returned tile's `edges` are empty. Costs a sort of the tile's
  /// nodes.
  TileElements append(std::size_t firstCell, std::size_t cellCount,
                      const std::vector<FootprintSide>& sides);

  /// The nodes at a point, bottom first.
  std::vector<int> nodesAt(int point) const;

 private:
  int step() const { return mesh_.rule.quadratic ? 2 : 1; }
  std::size_t edgeNumber(int a, int b) const;
  Element elementOn(const std::array<int, 4>& cell, int level) const;

  ElementMesh& mesh_;
  std::vector<std::array<int, 4>> cells_;
  std::vector<std::array<int, 2>> edges_;
  std::vector<std::vector<int>> pointNode_;  ///< by level and point
  std::vector<std::vector<int>> edgeNode_;   ///< by level and edge
};

}  // namespace kirireel
