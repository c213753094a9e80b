// Levels are numbered from the bottom. A linear mesh has one level a layer and one more: 0, 1, 2. A
// quadratic mesh has two a layer: even levels hold corners and the middles of edges, odd levels,
// halfway up, hold the middles of upright edges alone:
//
//     level 2   o---x---o     o corner, x middle of an edge
//               |       |
//     level 1   x       x     nothing in the middle of a face or of the element: 20 nodes
//               |       |
//     level 0   o---x---o
//
// Nodes are made once a point and level, so elements that meet share them without any search by
// place.
#include "render/fea/prism_layers.h"

#include <algorithm>

namespace kirireel {
namespace {

std::vector<int> sortedOnce(std::vector<int> nodes) {
  std::ranges::sort(nodes);
  const auto repeated = std::ranges::unique(nodes);
  nodes.erase(repeated.begin(), repeated.end());
  return nodes;
}

}  // namespace

int PrismLayers::levelCount(const ElementRule& rule) {
  if (rule.family != ElementFamily::Solid) return 1;
  return rule.through * (rule.quadratic ? 2 : 1) + 1;
}

PrismLayers::PrismLayers(ElementMesh& mesh, std::vector<std::array<int, 4>> cells,
                         const std::vector<std::vector<Vector3>>& levels)
    : mesh_(mesh), cells_(std::move(cells)), edges_(edgesOf(cells_)) {
  const auto addNode = [this](const Vector3& position) {
    mesh_.nodes.push_back(position);
    return static_cast<int>(mesh_.nodes.size()) - 1;
  };
  for (std::size_t level = 0; level < levels.size(); ++level) {
    std::vector<int>& atPoints = pointNode_.emplace_back();
    std::vector<int>& atEdges = edgeNode_.emplace_back();
    for (const Vector3& point : levels[level]) atPoints.push_back(addNode(point));
    if (!mesh_.rule.quadratic || level % 2 == 1) continue;
    // In the middle of a straight edge, also where a merged corner moves later.
    for (const auto& [a, b] : edges_) {
      atEdges.push_back(addNode(0.5 * (levels[level][a] + levels[level][b])));
    }
  }
}

TileElements PrismLayers::append(std::size_t firstCell, std::size_t cellCount,
                                 const std::vector<FootprintSide>& sides) {
  const bool isSolid = mesh_.rule.family == ElementFamily::Solid;
  const int layers = isSolid ? mesh_.rule.through : 1;
  TileElements tile;
  tile.firstElement = static_cast<int>(mesh_.elements.size());
  tile.layerCount = static_cast<int>(cellCount);
  tile.elementCount = layers * tile.layerCount;
  const int last = static_cast<int>(pointNode_.size()) - 1;
  // Elements of a layer follow each other, layer on layer: surfaces of top and bottom rely on it.
  for (int layer = 0; layer < layers; ++layer) {
    for (std::size_t k = firstCell; k < firstCell + cellCount; ++k) {
      mesh_.elements.push_back(elementOn(cells_[k], layer * step()));
      const Element& element = mesh_.elements.back();
      tile.nodes.insert(tile.nodes.end(), element.nodes.begin(),
                        element.nodes.begin() + nodeCount(mesh_.rule));
    }
  }
  const auto onFace = [&](int level) {
    std::vector<int> nodes;
    for (std::size_t k = firstCell; k < firstCell + cellCount; ++k) {
      for (int c = 0; c < 4; ++c) {
        nodes.push_back(pointNode_[level][cells_[k][c]]);
        if (!mesh_.rule.quadratic) continue;
        nodes.push_back(edgeNode_[level][edgeNumber(cells_[k][c], cells_[k][(c + 1) % 4])]);
      }
    }
    return sortedOnce(std::move(nodes));
  };
  tile.nodes = sortedOnce(std::move(tile.nodes));
  tile.bottom = onFace(0);
  tile.top = onFace(last);
  for (const FootprintSide& side : sides) {
    for (int layer = 0; layer < layers; ++layer) {
      const int element = tile.firstElement + layer * tile.layerCount + side.cell;
      tile.sides.push_back({element, side.side, side.tileEdge});
    }
  }
  return tile;
}

std::vector<int> PrismLayers::nodesAt(int point) const {
  std::vector<int> nodes;
  for (const std::vector<int>& level : pointNode_) nodes.push_back(level[point]);
  return nodes;
}

/// `edges_` is sorted; the edge must be among them.
std::size_t PrismLayers::edgeNumber(int a, int b) const {
  const std::array<int, 2> edge = {std::min(a, b), std::max(a, b)};
  return std::ranges::lower_bound(edges_, edge) - edges_.begin();
}

/// The order of nodes is Abaqus's, see Element.
Element PrismLayers::elementOn(const std::array<int, 4>& cell, int level) const {
  Element element;
  int count = 0;
  const auto appendCorners = [&](int at) {
    for (const int point : cell) element.nodes[count++] = pointNode_[at][point];
  };
  const auto appendMiddles = [&](int at) {
    for (int k = 0; k < 4; ++k) {
      element.nodes[count++] = edgeNode_[at][edgeNumber(cell[k], cell[(k + 1) % 4])];
    }
  };
  const bool isSolid = mesh_.rule.family == ElementFamily::Solid;
  appendCorners(level);
  if (isSolid) appendCorners(level + step());
  if (!mesh_.rule.quadratic) return element;
  appendMiddles(level);
  if (!isSolid) return element;
  appendMiddles(level + 2);
  appendCorners(level + 1);
  return element;
}

}  // namespace kirireel
