// VTK's XML formats ("VTK File Formats", vtk.org), version 1.0 with 64-bit headers:
//
//     <VTKFile type="UnstructuredGrid" ... compressor="vtkZLibDataCompressor">
//       <UnstructuredGrid>
//         <FieldData>   numbers of the state, as text
//         <Piece NumberOfPoints NumberOfCells>
//           <Points>    bottom, then top corners of each brick
//           <Cells>     connectivity, offsets, types; faces and faceoffsets of polyhedra
//           <PointData> <CellData>
//
// An array is base 64 of a header of four uint64 (number of blocks, block size, size of an
// incomplete last block, compressed block size), followed by base 64 of the block. This file writes
// one block per array.
//
// Cells: a hexahedron has its bottom corners, then its top corners. The normal of a wedge's first
// triangle points out of the cell. A polyhedron has its points in the connectivity and its faces in
// a separate list: number of faces, then size and points of each. "faceoffsets" has the end of each
// cell's faces, -1 for cells without faces.
//
// Binary and compressed, because text would be several times larger.
#include "render/writers/vtk.h"

#include <array>
#include <bit>
#include <cstdint>
#include <iterator>
#include <span>

#include <fmt/format.h>

#include "sim/base/files.h"
#include "sim/trajectory/run_curves.h"

namespace kirireel::writers {
namespace {

static_assert(std::endian::native == std::endian::little,
              "arrays are written as they lie in memory");
static_assert(sizeof(Vector3) == 3 * sizeof(double));

// VTK's cell type numbers.
constexpr int kHexahedronCell = 12;
constexpr int kWedge = 13;
constexpr int kPolyhedron = 42;

int cellType(std::size_t sides) {
  if (sides == 3) return kWedge;
  return sides == 4 ? kHexahedronCell : kPolyhedron;
}

template <typename T>
constexpr const char* kTypeName = "Float64";
template <>
constexpr const char* kTypeName<int> = "Int32";

template <typename T>
constexpr int kComponents = 1;
template <>
constexpr int kComponents<Vector3> = 3;

/// An array in VTK's compressed form: number of blocks, their size, the size of an incomplete last
/// block, and the compressed size of each, followed by the blocks. Here one full block.
template <typename T>
void appendArray(std::string& text, const char* name, const std::vector<T>& values) {
  appendText(text,
             "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"binary\">\n",
             kTypeName<T>, name, kComponents<T>);
  const std::span<const std::byte> bytes = std::as_bytes(std::span(values));
  const std::string block = compressed(bytes);
  // An empty array has a header of three zeros.
  std::array<std::uint64_t, 4> header = {1, bytes.size(), 0, block.size()};
  if (bytes.empty()) header = {};
  const std::size_t sizes = bytes.empty() ? 3 : 4;
  text += base64(std::as_bytes(std::span(header).first(sizes)));
  if (!bytes.empty()) text += base64(std::as_bytes(std::span(block)));
  text += "\n</DataArray>\n";
}

/// A single number, as text that reads back as the same double.
void appendNumber(std::string& text, const char* name, double value) {
  appendText(text,
             "<DataArray type=\"Float64\" Name=\"{}\" NumberOfTuples=\"1\" format=\"ascii\">{}"
             "</DataArray>\n",
             name, value);
}

/// Visits the bottom, then the top corners of all bricks, as brickCorners does, for any poses.
template <typename Function>
void forEachCorner(const std::vector<brick::Brick>& bricks, const Function& function) {
  for (std::size_t tile = 0; tile < bricks.size(); ++tile) {
    for (const auto* face : {&bricks[tile].bottom, &bricks[tile].top}) {
      for (std::size_t k = 0; k < face->size(); ++k) function(tile, k, (*face)[k]);
    }
  }
}

/// Cells in VTK's form: point numbers, the end of each cell, and the faces of polyhedra.
struct Cells {
  std::vector<int> connectivity;
  std::vector<int> offsets;
  std::vector<int> types;
  std::vector<int> faces;
  std::vector<int> faceOffsets;
  std::vector<int> bricks;  ///< brick of each cell
};

/// The number of faces, followed by the size and points of each.
void appendFaces(Cells& cells, int n, int first) {
  cells.faces.push_back(n + 2);
  for (const int base : {0, n}) {
    cells.faces.push_back(n);
    for (int k = 0; k < n; ++k) cells.faces.push_back(first + (base == 0 ? n - 1 - k : n + k));
  }
  for (int k = 0; k < n; ++k) {
    const int next = (k + 1) % n;
    for (const int value : {4, first + k, first + next, first + n + next, first + n + k}) {
      cells.faces.push_back(value);
    }
  }
}

/// Completes a cell whose points are in the connectivity.
void finishCell(Cells& cells, int type, int brick) {
  cells.offsets.push_back(static_cast<int>(cells.connectivity.size()));
  cells.types.push_back(type);
  const bool isPolyhedron = type == kPolyhedron;
  cells.faceOffsets.push_back(isPolyhedron ? static_cast<int>(cells.faces.size()) : -1);
  cells.bricks.push_back(brick);
}

/// A wedge on a triangle of a brick's bottom. VTK's wedges begin with the triangle whose normal
/// points outwards.
void appendWedge(Cells& cells, const std::array<int, 3>& triangle, int n, int first, int brick) {
  const auto [a, b, c] = triangle;
  for (const int corner : {a, c, b, n + a, n + c, n + b}) {
    cells.connectivity.push_back(first + corner);
  }
  finishCell(cells, kWedge, brick);
}

/// One cell per brick. Since VTK's cells are convex, concave bricks have one cell per triangle of
/// the bottom. Points are numbered in the order of forEachCorner.
Cells cellsOf(const std::vector<brick::Brick>& bricks) {
  Cells cells;
  int first = 0;
  for (int number = 0; number < std::ssize(bricks); ++number) {
    const brick::Brick& brick = bricks[number];
    const int n = static_cast<int>(brick.bottom.size());
    if (cellType(n) == kWedge || !brick.parts.empty()) {
      for (const auto& triangle : model::trianglesOf(brick.bottom, brick.normal)) {
        appendWedge(cells, triangle, n, first, number);
      }
    } else {
      for (int k = 0; k < 2 * n; ++k) cells.connectivity.push_back(first + k);
      if (cellType(n) == kPolyhedron) appendFaces(cells, n, first);
      finishCell(cells, cellType(n), number);
    }
    first += 2 * n;
  }
  return cells;
}

/// Omits lists of faces if no cell is a polyhedron.
void appendCells(std::string& text, const Cells& cells) {
  text += "<Cells>\n";
  appendArray(text, "connectivity", cells.connectivity);
  appendArray(text, "offsets", cells.offsets);
  appendArray(text, "types", cells.types);
  if (!cells.faces.empty()) {
    appendArray(text, "faces", cells.faces);
    appendArray(text, "faceoffsets", cells.faceOffsets);
  }
  text += "</Cells>\n";
}

/// World axes.
void appendPoints(std::string& text, const trajectory::Subject& subject, const Poses& poses,
                  const LengthUnit& unit) {
  std::vector<Vector3> points;
  forEachCorner(subject.bricks, [&](std::size_t tile, std::size_t, const Vector3& corner) {
    points.push_back(inUnit(poses[tile].apply(corner), unit));
  });
  text += "<Points>\n";
  appendArray(text, "points", points);
  text += "</Points>\n";
}

/// Values of bricks, repeated for each of their cells.
std::vector<double> byCells(const std::vector<double>& byBricks, const Cells& cells) {
  std::vector<double> values;
  for (const int brick : cells.bricks) values.push_back(byBricks[brick]);
  return values;
}

/// `turn` in radians.
void appendCellFields(std::string& text, const trajectory::Subject& subject, const Cells& cells,
                      const Poses& start, const Poses& poses, const LengthUnit& unit) {
  const std::vector<brick::Pivot> pivots = brick::makePivots(subject.model.joints, subject.bricks);
  std::vector<double> gaps = trajectory::brickJointGaps(pivots, poses);
  for (double& gap : gaps) gap = inUnit(gap, unit);
  text += "<CellData Scalars=\"joint_gap\">\n";
  appendArray(text, "tile", cells.bricks);
  appendArray(text, "joint_gap", byCells(gaps, cells));
  appendArray(text, "turn", byCells(trajectory::brickRotations(start, poses), cells));
  text += "</CellData>\n";
}

/// Top and bottom of a corner have the same distance, that of the bottom, which is the tile's
/// vertex.
void appendPointFields(std::string& text, const trajectory::Subject& subject, const Poses& start,
                       const Poses& poses, const LengthUnit& unit) {
  const std::optional<std::vector<model::Tile>>& target = subject.model.target;
  std::vector<Vector3> moves;
  std::vector<double> distances;
  forEachCorner(subject.bricks, [&](std::size_t tile, std::size_t k, const Vector3& corner) {
    moves.push_back(inUnit(Vector3(poses[tile].apply(corner) - start[tile].apply(corner)), unit));
    if (!target) return;
    const Vector3 vertex = poses[tile].apply(subject.bricks[tile].bottom[k]);
    distances.push_back(inUnit((vertex - (*target)[tile].vertices[k]).norm(), unit));
  });
  text += "<PointData Vectors=\"displacement\">\n";
  appendArray(text, "displacement", moves);
  if (target) appendArray(text, "target_distance", distances);
  text += "</PointData>\n";
}

/// ParaView reads the time of a file from TimeValue.
void appendMeasures(std::string& text, const trajectory::Subject& subject,
                    const trajectory::Sample& sample, const LengthUnit& unit) {
  text += "<FieldData>\n";
  appendNumber(text, "TimeValue", sample.time);
  appendNumber(text, "joint_gap", inUnit(sample.jointGap, unit));
  appendNumber(text, "penetration", inUnit(sample.penetration, unit));
  if (subject.model.target) appendNumber(text, "target_error", inUnit(sample.targetError, unit));
  text += "</FieldData>\n";
}

}  // namespace

std::string vtuText(const trajectory::Subject& subject, const Poses& start,
                    const trajectory::Sample& sample, const LengthUnit& unit) {
  std::size_t points = 0;
  for (const brick::Brick& brick : subject.bricks) points += 2 * brick.bottom.size();
  std::string text = fmt::format("<?xml version=\"1.0\"?>\n<!-- unit {} -->\n", unit.name);
  text +=
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n"
      "<UnstructuredGrid>\n";
  appendMeasures(text, subject, sample, unit);
  const Cells cells = cellsOf(subject.bricks);
  appendText(text, "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", points,
             cells.types.size());
  appendPoints(text, subject, sample.poses, unit);
  appendCells(text, cells);
  appendPointFields(text, subject, start, sample.poses, unit);
  appendCellFields(text, subject, cells, start, sample.poses, unit);
  return text.append("</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
}

std::string pvdText(const std::vector<std::pair<double, std::string>>& files) {
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n";
  for (const auto& [time, file] : files) {
    appendText(text, "<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", time, file);
  }
  return text.append("</Collection>\n</VTKFile>\n");
}

}  // namespace kirireel::writers
