// Three formats by way of assimp's exporters (assimp 5), with exact coordinates:
//
// - OBJ: text; "g TILE_00000", "v x y z", "vn x y z", "f 1//1 2//1 ...". Polygons stay whole.
// - PLY: text; a header that ends in "end_header", then one row a vertex, then "3 a b c" a
//   triangle. "property float" becomes "property double", since the digits are those of doubles.
// - STL: binary; 80 bytes of header, a count (uint32), then 50 bytes a triangle: normal and three
//   corners as floats, and two bytes that are 0.
//
// A brick of n sides has 2 n corners: the bottom's, then the top's. Faces are listed anticlockwise
// as seen from outside, so that normals by the right-hand rule point outwards: the bottom runs
// backwards, sides are (k, k+1, n+k+1, n+k).
#include "render/mesh/mesh.h"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <iterator>
#include <memory>
#include <string_view>

#include <assimp/Exporter.hpp>
#include <assimp/scene.h>
#include <assimp/version.h>
#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/interruption.h"
#include "sim/base/pending_file.h"

namespace kirireel {
namespace {

// assimp stores and prints coordinates in single precision and welds vertices that look equal. So
// it is given the numbers of the corners for x, and its rows are filled with the coordinates after.

using Face = std::vector<unsigned>;

/// Whole numbers that a float holds exactly.
constexpr std::size_t kMostCorners = 1U << 24U;

/// The corners of all bricks in world axes: of each brick its bottom, then its top. Metres.
std::vector<Vector3> worldCorners(const std::vector<Brick>& bricks, const Poses& poses) {
  std::vector<Vector3> corners;
  for (std::size_t k = 0; k < bricks.size(); ++k) {
    for (const Vector3& point : bricks[k].bottom) corners.push_back(poses[k].apply(point));
    for (const Vector3& point : bricks[k].top) corners.push_back(poses[k].apply(point));
  }
  // The readers of models allow far fewer tiles than would fill this.
  assert(corners.size() <= kMostCorners);
  return corners;
}

/// The outward faces of a brick of n sides whose first corner has this number.
std::vector<Face> facesOf(unsigned n, unsigned first) {
  Face bottom;
  Face top;
  for (unsigned k = 0; k < n; ++k) {
    bottom.push_back(first + n - 1 - k);
    top.push_back(first + n + k);
  }
  std::vector<Face> faces = {bottom, top};
  for (unsigned k = 0; k < n; ++k) {
    const unsigned next = (k + 1) % n;
    faces.push_back({first + k, first + next, first + n + next, first + n + k});
  }
  return faces;
}

/// The faces of a brick whose first corner has this number, as triangles.
std::vector<Face> brickTriangles(const Brick& brick, unsigned first) {
  std::vector<Face> triangles;
  const std::vector<std::vector<Vector3>> shapes = brickFaces(brick);
  const std::vector<Face> faces = facesOf(static_cast<unsigned>(brick.bottom.size()), first);
  for (std::size_t k = 0; k < faces.size(); ++k) {
    const Vector3 normal = k == 0 ? Vector3(-brick.normal) : brick.normal;
    // Sides are convex, whatever their normal.
    const auto cut = k < 2 ? trianglesOf(shapes[k], normal)
                           : std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}};
    for (const auto& [a, b, c] : cut) {
      triangles.push_back({faces[k][a], faces[k][b], faces[k][c]});
    }
  }
  return triangles;
}

/// The number is what the exporter will print where x stands.
aiVector3D numbered(unsigned corner) {
  return {static_cast<float>(corner), 0, 0};
}

/// Unit and outward; single precision, for normals only shade.
aiVector3D flatNormal(const Face& face, const std::vector<Vector3>& corners) {
  const Vector3& middle = corners[face[1]];
  Vector3 normal = (corners[face[2]] - middle).cross(corners[face[0]] - middle).normalized();
  // The corner of a concave face may turn inwards.
  Vector3 area = Vector3::Zero();
  for (std::size_t k = 2; k < face.size(); ++k) {
    area += (corners[face[k - 1]] - corners[face[0]]).cross(corners[face[k]] - corners[face[0]]);
  }
  if (area.dot(normal) < 0) normal = -normal;
  return {static_cast<float>(normal.x()), static_cast<float>(normal.y()),
          static_cast<float>(normal.z())};
}

// Arrays are raw because aiMesh and aiScene delete them.
template <typename T>
/// The caller's object owns the array from then on.
T* copied(const std::vector<T>& values) {
  T* array = new T[values.size()];
  std::ranges::copy(values, array);
  return array;
}

/// Also sets mPrimitiveTypes, without which the exporters write broken rows.
void setFaces(aiMesh& mesh, const std::vector<Face>& faces) {
  mesh.mNumFaces = static_cast<unsigned>(faces.size());
  mesh.mFaces = new aiFace[faces.size()];
  for (std::size_t k = 0; k < faces.size(); ++k) {
    mesh.mFaces[k].mNumIndices = static_cast<unsigned>(faces[k].size());
    mesh.mFaces[k].mIndices = copied(faces[k]);
    mesh.mPrimitiveTypes |=
        faces[k].size() == 3 ? aiPrimitiveType_TRIANGLE : aiPrimitiveType_POLYGON;
  }
}

/// Faces share vertices.
std::unique_ptr<aiMesh> sharedMesh(unsigned corners, const std::vector<Face>& triangles) {
  auto mesh = std::make_unique<aiMesh>();
  std::vector<aiVector3D> vertices;
  for (unsigned k = 0; k < corners; ++k) vertices.push_back(numbered(k));
  mesh->mNumVertices = corners;
  mesh->mVertices = copied(vertices);
  setFaces(*mesh, triangles);
  return mesh;
}

/// Each face has its own vertices, so that it can have its own normal.
std::unique_ptr<aiMesh> flatMesh(const std::vector<Face>& faces,
                                 const std::vector<Vector3>& corners) {
  auto mesh = std::make_unique<aiMesh>();
  std::vector<aiVector3D> vertices;
  std::vector<aiVector3D> normals;
  std::vector<Face> renumbered;
  for (const Face& face : faces) {
    const aiVector3D normal = flatNormal(face, corners);
    Face& own = renumbered.emplace_back();
    for (const unsigned corner : face) {
      own.push_back(static_cast<unsigned>(vertices.size()));
      vertices.push_back(numbered(corner));
      normals.push_back(normal);
    }
  }
  mesh->mNumVertices = static_cast<unsigned>(vertices.size());
  mesh->mVertices = copied(vertices);
  mesh->mNormals = copied(normals);
  setFaces(*mesh, renumbered);
  return mesh;
}

/// assimp wants a material and a root node that names all meshes. The scene owns what it points to.
std::unique_ptr<aiScene> sceneOf(std::vector<std::unique_ptr<aiMesh>> meshes) {
  auto scene = std::make_unique<aiScene>();
  scene->mNumMaterials = 1;
  scene->mMaterials = new aiMaterial* [1] { new aiMaterial };
  scene->mNumMeshes = static_cast<unsigned>(meshes.size());
  scene->mMeshes = new aiMesh*[meshes.size()];
  scene->mRootNode = new aiNode("kirigami");
  scene->mRootNode->mNumMeshes = scene->mNumMeshes;
  scene->mRootNode->mMeshes = new unsigned[meshes.size()];
  for (unsigned k = 0; k < scene->mNumMeshes; ++k) {
    scene->mMeshes[k] = meshes[k].release();
    scene->mRootNode->mMeshes[k] = k;
  }
  return scene;
}

/// The bytes of a file in the format that assimp knows by this id.
std::string exported(const aiScene& scene, const char* format, const std::filesystem::path& path) {
  Assimp::Exporter exporter;
  // The blob belongs to the exporter, so its bytes are copied.
  const aiExportDataBlob* blob = exporter.ExportToBlob(&scene, format);
  if (blob == nullptr) {
    throw OutputError(fmt::format("{}: error: assimp cannot make this mesh ({})", path.string(),
                                  exporter.GetErrorString()));
  }
  return {static_cast<const char*>(blob->data), blob->size};
}

/// Takes the first line, without its end, off the text.
std::string_view takeLine(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

/// Appends the coordinates of the corner whose number a row starts with, shortest digits that read
/// back to the same doubles.
void appendCorner(std::string& text, std::string_view row, const std::vector<Vector3>& corners) {
  unsigned corner = 0;
  std::from_chars(row.data(), row.data() + row.size(), corner);
  const Vector3& point = corners.at(corner);
  fmt::format_to(std::back_inserter(text), "{} {} {}\n", point.x(), point.y(), point.z());
}

std::string objText(const std::vector<Brick>& bricks, const std::vector<Vector3>& corners,
                    const std::filesystem::path& path) {
  std::vector<std::unique_ptr<aiMesh>> meshes;
  unsigned first = 0;
  for (const Brick& brick : bricks) {
    const auto sides = static_cast<unsigned>(brick.bottom.size());
    const std::string name = fmt::format("TILE_{:05}", meshes.size());
    meshes.push_back(flatMesh(facesOf(sides, first), corners));
    meshes.back()->mName = name;
    first += 2 * sides;
  }
  const std::string numbers = exported(*sceneOf(std::move(meshes)), "objnomtl", path);
  std::string text;
  for (std::string_view rest = numbers; !rest.empty();) {
    checkInterruption();
    const std::string_view line = takeLine(rest);
    // Rows "v" hold the number of a corner where x would be; "vn" and "f" stay as they are.
    if (line.starts_with("v ")) {
      const std::size_t digits = line.find_first_not_of(' ', 1);
      text += "v ";
      appendCorner(text, line.substr(digits), corners);
    } else {
      text.append(line).append("\n");
    }
  }
  return text;
}

/// The triangles of all bricks, by the numbers of their corners.
std::vector<Face> allTriangles(const std::vector<Brick>& bricks) {
  std::vector<Face> triangles;
  unsigned first = 0;
  for (const Brick& brick : bricks) {
    const auto sides = static_cast<unsigned>(brick.bottom.size());
    std::ranges::copy(brickTriangles(brick, first), std::back_inserter(triangles));
    first += 2 * sides;
  }
  return triangles;
}

std::unique_ptr<aiScene> sceneOf(std::unique_ptr<aiMesh> mesh) {
  std::vector<std::unique_ptr<aiMesh>> meshes;
  meshes.push_back(std::move(mesh));
  return sceneOf(std::move(meshes));
}

/// Binary STL holds single precision and no shared vertices: nothing to fill in after. Each facet
/// has its own normal; assimp would smooth them over shared corners.
std::string stlBytes(const std::vector<Brick>& bricks, const std::vector<Vector3>& corners,
                     const std::filesystem::path& path) {
  auto mesh = flatMesh(allTriangles(bricks), corners);
  for (unsigned k = 0; k < mesh->mNumVertices; ++k) {
    aiVector3D& vertex = mesh->mVertices[k];
    const Eigen::Vector3f point = corners[static_cast<std::size_t>(vertex.x)].cast<float>();
    vertex = {point.x(), point.y(), point.z()};
  }
  std::string bytes = exported(*sceneOf(std::move(mesh)), "stlb", path);
  constexpr std::size_t kHeader = 80;
  std::string header = "Kirireel: closed bricks, lengths in metres";
  header.resize(kHeader, ' ');
  // The header must not begin with "solid", by which readers tell text from binary.
  return bytes.replace(0, kHeader, header);
}

/// The header's counts are assimp's own and stay.
std::string plyText(const std::vector<Brick>& bricks, const std::vector<Vector3>& corners,
                    const std::filesystem::path& path) {
  auto mesh = sharedMesh(static_cast<unsigned>(corners.size()), allTriangles(bricks));
  const std::string numbers = exported(*sceneOf(std::move(mesh)), "ply", path);
  constexpr std::string_view kFloat = "property float ";
  std::string text;
  std::string_view rest = numbers;
  // The header, line by line, with doubles in place of floats.
  for (std::string_view line; line != "end_header" && !rest.empty();) {
    line = takeLine(rest);
    const bool isFloat = line.starts_with(kFloat);
    if (isFloat) text += "property double ";
    text.append(isFloat ? line.substr(kFloat.size()) : line).append("\n");
  }
  // Rows of vertices come in the order of the corners; the faces after them need no change.
  for (std::size_t k = 0; k < corners.size(); ++k) appendCorner(text, takeLine(rest), corners);
  return text.append(rest);
}

}  // namespace

void writeMesh(const std::filesystem::path& path, const std::vector<Brick>& bricks,
               const Poses& poses) {
  const std::vector<Vector3> corners = worldCorners(bricks, poses);
  const std::string ending = path.extension().string();
  if (ending == ".obj") {
    writeTextFile(path, objText(bricks, corners, path));
  } else if (ending == ".ply") {
    writeTextFile(path, plyText(bricks, corners, path));
  } else if (ending == ".stl") {
    writeTextFile(path, stlBytes(bricks, corners, path));
  } else {
    throw InputError(
        fmt::format("{}: error: \"{}\" is no mesh format known here; let the name end "
                    "in .obj, .ply or .stl",
                    path.string(), ending));
  }
}

std::string meshLibraryVersion() {
  return fmt::format("{}.{}.{}", aiGetVersionMajor(), aiGetVersionMinor(), aiGetVersionPatch());
}

}  // namespace kirireel
