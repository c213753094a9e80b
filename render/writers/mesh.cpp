// Three formats through assimp's exporters (assimp 5), with exact coordinates:
//
// - OBJ: text; "g TILE_00000", "v x y z", "vn x y z", "f 1//1 2//1 ...". Polygons are kept.
// - PLY: text; a header that ends in "end_header", one row per vertex, one row "3 a b c" per
//   triangle. "property float" becomes "property double", because the digits are those of doubles.
// - STL: binary; 80 bytes of header, a count (uint32), then 50 bytes per triangle: normal and three
//   corners as floats, and two zero bytes.
//
// A brick of n sides has 2 n corners: the bottom's, then the top's. Faces are anticlockwise seen
// from outside, so their normals point outwards by the right-hand rule. The bottom is reversed,
// sides are (k, k+1, n+k+1, n+k).
#include "render/writers/mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <memory>
#include <string_view>

#include <assimp/Exporter.hpp>
#include <assimp/scene.h>
#include <assimp/version.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/base/interruption.h"

namespace kirireel::writers {
namespace {

// assimp stores and prints coordinates in single precision and merges equal vertices. It therefore
// gets the numbers of the corners as x, and its rows are filled with the coordinates afterwards.

using Face = std::vector<unsigned>;

/// The corners of all bricks in world axes, metres: for each brick its bottom, then its top.
std::vector<Vector3> worldCorners(const std::vector<brick::Brick>& bricks, const Poses& poses) {
  std::vector<Vector3> corners;
  for (std::size_t k = 0; k < bricks.size(); ++k) {
    for (const Vector3& point : bricks[k].bottom) corners.push_back(poses[k].apply(point));
    for (const Vector3& point : bricks[k].top) corners.push_back(poses[k].apply(point));
  }
  // A float holds these numbers exactly. The readers of models allow far fewer tiles.
  assert(corners.size() <= std::size_t{1} << 24U);
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
std::vector<Face> brickTriangles(const brick::Brick& brick, unsigned first) {
  std::vector<Face> triangles;
  const std::vector<std::vector<Vector3>> shapes = brick::brickFaces(brick);
  const std::vector<Face> faces = facesOf(static_cast<unsigned>(brick.bottom.size()), first);
  for (std::size_t k = 0; k < faces.size(); ++k) {
    const Vector3 normal = k == 0 ? Vector3(-brick.normal) : brick.normal;
    // Sides are always convex.
    const auto cut = k < 2 ? model::trianglesOf(shapes[k], normal)
                           : std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}};
    for (const auto& [a, b, c] : cut) {
      triangles.push_back({faces[k][a], faces[k][b], faces[k][c]});
    }
  }
  return triangles;
}

/// The exporter prints this number in place of x.
aiVector3D numbered(unsigned corner) {
  return {static_cast<float>(corner), 0, 0};
}

/// The outward normal of a face, whose corner 1 may turn inwards.
Vector3 normalOf(const std::vector<Vector3>& face) {
  // The fan's area vector points outwards, even if individual corners do not.
  const Vector3 normal = (face[2] - face[1]).cross(face[0] - face[1]).normalized();
  return doubledVectorArea(face).dot(normal) < 0 ? Vector3(-normal) : normal;
}

/// The normal in single precision, since it only affects shading.
aiVector3D flatNormal(const Face& face, const std::vector<Vector3>& corners) {
  std::vector<Vector3> points;
  for (const unsigned corner : face) points.push_back(corners[corner]);
  const Eigen::Vector3f normal = normalOf(points).cast<float>();
  return {normal.x(), normal.y(), normal.z()};
}

// Arrays are raw because aiMesh and aiScene delete them.
template <typename T>
T* copied(const std::vector<T>& values) {
  T* array = new T[values.size()];
  std::ranges::copy(values, array);
  return array;
}

/// Sets the faces and mPrimitiveTypes, without which the exporters write invalid rows.
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

/// Each face has its own vertices with its own normal.
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

/// assimp needs a material and a root node with all meshes. The scene owns its pointers.
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

/// The bytes of a file in the format with this assimp id.
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

/// Removes the first line from the text and returns it without its end.
std::string_view takeLine(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

/// The corner number at the start of a row.
std::size_t cornerOf(std::string_view row) {
  std::size_t corner = 0;
  std::from_chars(row.data(), row.data() + row.size(), corner);
  return corner;
}

/// Appends the coordinates of the corner whose number is at the start of a row, with the shortest
/// digits that read back as the same doubles.
void appendCorner(std::string& text, std::string_view row, const std::vector<Vector3>& corners) {
  const Vector3& point = corners.at(cornerOf(row));
  appendText(text, "{} {} {}\n", point.x(), point.y(), point.z());
}

/// Appends a row "f 1//1 2//1 3//1" with the vertex numbers replaced by `rows`.
void appendFace(std::string& text, std::string_view line, const std::vector<std::size_t>& rows) {
  while (!line.empty()) {
    const std::size_t digit = std::min(line.find_first_of("0123456789"), line.size());
    text.append(line.substr(0, digit));
    line.remove_prefix(digit);
    if (line.empty()) break;
    text += std::to_string(rows.at(cornerOf(line) - 1));
    line.remove_prefix(std::min(line.find_first_not_of("0123456789"), line.size()));
    const std::size_t next = std::min(line.find(' '), line.size());
    text.append(line.substr(0, next));
    line.remove_prefix(next);
  }
  text += '\n';
}

std::string objText(const std::vector<brick::Brick>& bricks, const std::vector<Vector3>& corners,
                    const std::filesystem::path& path) {
  std::vector<std::unique_ptr<aiMesh>> meshes;
  unsigned first = 0;
  for (const brick::Brick& brick : bricks) {
    const auto sides = static_cast<unsigned>(brick.bottom.size());
    const std::string name = fmt::format("TILE_{:05}", meshes.size());
    meshes.push_back(flatMesh(facesOf(sides, first), corners));
    meshes.back()->mName = name;
    first += 2 * sides;
  }
  const std::string numbers = exported(*sceneOf(std::move(meshes)), "objnomtl", path);
  std::string text;
  std::vector<std::size_t> rowOf(corners.size(), 0);  // of each corner in the text, from 1
  std::vector<std::size_t> rowsOfExporter;            // the same for each row of the exporter
  std::size_t rows = 0;
  for (std::string_view rest = numbers; !rest.empty();) {
    checkInterruption();
    const std::string_view line = takeLine(rest);
    // Rows "v" hold the number of a corner as x. assimp 5.4 repeats a corner for each of its faces,
    // assimp 5.2 does not.
    if (line.starts_with("v ")) {
      const std::string_view row = line.substr(line.find_first_not_of(' ', 1));
      std::size_t& place = rowOf.at(cornerOf(row));
      if (place == 0) {
        place = ++rows;
        text += "v ";
        appendCorner(text, row, corners);
      }
      rowsOfExporter.push_back(place);
    } else if (line.starts_with("f ")) {
      appendFace(text, line, rowsOfExporter);
    } else {
      text.append(line).append("\n");
    }
  }
  return text;
}

/// The triangles of all bricks, by the numbers of their corners.
std::vector<Face> allTriangles(const std::vector<brick::Brick>& bricks) {
  std::vector<Face> triangles;
  unsigned first = 0;
  for (const brick::Brick& brick : bricks) {
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

/// Origin for single precision: the world origin, or the centre of points so far from it that they
/// would lose more than a digit.
Vector3 singleOrigin(const std::vector<Vector3>& points) {
  constexpr double kFar = 10;  // diagonals
  const Eigen::AlignedBox3d box = boundingBox(points);
  const bool isFar = box.center().norm() > kFar * box.diagonal().norm();
  return isFar ? Vector3(box.center()) : Vector3::Zero();
}

/// Binary STL holds single precision and no shared vertices, so nothing is filled in afterwards.
/// Each facet has its own normal; assimp would smooth them over shared corners.
std::string stlBytes(const std::vector<brick::Brick>& bricks, const std::vector<Vector3>& corners,
                     const LengthUnit& unit, const std::filesystem::path& path) {
  auto mesh = flatMesh(allTriangles(bricks), corners);
  const Vector3 origin = singleOrigin(corners);
  for (unsigned k = 0; k < mesh->mNumVertices; ++k) {
    aiVector3D& vertex = mesh->mVertices[k];
    const Eigen::Vector3f point =
        (corners[static_cast<std::size_t>(vertex.x)] - origin).cast<float>();
    vertex = {point.x(), point.y(), point.z()};
  }
  std::string bytes = exported(*sceneOf(std::move(mesh)), "stlb", path);
  constexpr std::size_t kHeader = 80;
  std::string header = fmt::format("Kirireel: closed bricks, unit {}", unit.name);
  if (!origin.isZero()) {
    header += fmt::format(", origin {:.7g} {:.7g} {:.7g}", origin.x(), origin.y(), origin.z());
  }
  header.resize(kHeader, ' ');
  // The header must not begin with "solid", which marks text files.
  return bytes.replace(0, kHeader, header);
}

/// Keeps assimp's counts in the header.
std::string plyText(const std::vector<brick::Brick>& bricks, const std::vector<Vector3>& corners,
                    const LengthUnit& unit, const std::filesystem::path& path) {
  auto mesh = sharedMesh(static_cast<unsigned>(corners.size()), allTriangles(bricks));
  const std::string numbers = exported(*sceneOf(std::move(mesh)), "ply", path);
  constexpr std::string_view kPlyFloat = "property float ";
  std::string text;
  std::string_view rest = numbers;
  // Replaces floats by doubles in the header.
  for (std::string_view line; line != "end_header" && !rest.empty();) {
    line = takeLine(rest);
    const bool isFloat = line.starts_with(kPlyFloat);
    if (isFloat) text += "property double ";
    text.append(isFloat ? line.substr(kPlyFloat.size()) : line).append("\n");
    if (line.starts_with("format ")) appendText(text, "comment unit {}\n", unit.name);
  }
  // Vertex rows have the order of the corners; the faces after them stay unchanged.
  for (std::size_t k = 0; k < corners.size(); ++k) appendCorner(text, takeLine(rest), corners);
  return text.append(rest);
}

}  // namespace

void writeMesh(const std::filesystem::path& path, const std::vector<brick::Brick>& bricks,
               const Poses& poses, const LengthUnit& unit) {
  std::vector<Vector3> corners = worldCorners(bricks, poses);
  for (Vector3& corner : corners) corner = inUnit(corner, unit);
  const std::string ending = path.extension().string();
  if (ending == ".obj") {
    writeTextFile(path, fmt::format("# unit {}\n", unit.name) + objText(bricks, corners, path));
  } else if (ending == ".ply") {
    writeTextFile(path, plyText(bricks, corners, unit, path));
  } else if (ending == ".stl") {
    writeTextFile(path, stlBytes(bricks, corners, unit, path));
  } else {
    throw InputError(fmt::format(
        "{}: error: \"{}\" is not a known mesh format; use a name that ends in .obj, .ply or .stl",
        path.string(), ending));
  }
}

std::string meshLibraryVersion() {
  return fmt::format("{}.{}.{}", aiGetVersionMajor(), aiGetVersionMinor(), aiGetVersionPatch());
}

// ------------------------------------------------------------------------------------------------
// Writes a binary glTF 2.0 file (Khronos, glTF 2.0 Specification, section "GLB File Format"),
// little-endian throughout:
//
//     magic "glTF" (0x46546C67), version 2, length of the file      3 x 4 bytes
//     length, type "JSON", JSON text filled up with spaces          chunk 0
//     length, type "BIN\0", binary buffer filled up with zeros      chunk 1
//
// The JSON describes the buffer. Buffer views are ranges of bytes. Accessors are typed arrays
// within them: count, component type, offset. There are six views:
//
//     positions  3 floats per vertex   normals  3 floats per vertex   indices  1 uint32 per corner
//     times      1 float per key       moves    3 floats per brick and key
//     turns      4 floats per brick and key: quaternion x, y, z, w
//
// Each brick is a mesh in its own axes and a node with translation and rotation. The animation has
// two channels per node. The geometry is therefore stored once for any number of keys. Between keys
// viewers interpolate positions linearly and quaternions spherically.
//
// glTF has y up, Kirireel z up: the root node rotates by -90 degrees about x, the quaternion
// (-sqrt(1/2), 0, 0, sqrt(1/2)).

namespace {

static_assert(std::endian::native == std::endian::little, "glTF is little-endian");

// Constants of glTF.
constexpr int kGltfFloat = 5126;
constexpr int kUnsigned = 5125;
constexpr int kVertexTarget = 34962;
constexpr int kIndexTarget = 34963;
constexpr std::uint32_t kMagic = 0x46546C67;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinaryChunk = 0x004E4942;

template <typename T>
void appendBytes(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Three floats, 12 bytes.
void appendVector(std::string& bytes, const Vector3& v) {
  for (const double x : {v.x(), v.y(), v.z()}) appendBytes(bytes, static_cast<float>(x));
}

/// The sections of the binary part, which become glTF's buffer views.
enum View { kPositions, kNormals, kIndices, kTimes, kMoves, kTurns, kViewCount };

/// The JSON and the bytes that it describes.
struct Asset {
  Json accessors = Json::array();
  std::array<std::string, kViewCount> views;

  /// Declares `count` values of a view. Returns the accessor's number.
  std::size_t declare(View view, const char* type, int componentType, std::size_t count,
                      std::size_t byteOffset) {
    accessors.push_back({{"bufferView", view},
                         {"byteOffset", byteOffset},
                         {"componentType", componentType},
                         {"count", count},
                         {"type", type}});
    return accessors.size() - 1;
  }
};

/// Each face has its own vertices with its own normal.
Json meshJson(const brick::Brick& brick, const std::string& name, Asset& asset) {
  const std::vector<std::vector<Vector3>> faces = brick::brickFaces(brick);
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  for (const std::vector<Vector3>& face : faces) {
    vertices += face.size();
    triangles += face.size() - 2;
  }
  // The accessor starts at the current end of the view. Its values are appended afterwards.
  const auto declareNext = [&](View view, const char* type, int componentType, std::size_t count) {
    return asset.declare(view, type, componentType, count, asset.views[view].size());
  };
  const std::size_t positions = declareNext(kPositions, "VEC3", kGltfFloat, vertices);
  const std::size_t normals = declareNext(kNormals, "VEC3", kGltfFloat, vertices);
  const std::size_t indices = declareNext(kIndices, "SCALAR", kUnsigned, 3 * triangles);
  // Indices are zero-based within the mesh. glTF requires min and max of the stored floats, not of
  // the doubles.
  Eigen::AlignedBox3f bounds;
  std::uint32_t first = 0;
  for (const std::vector<Vector3>& face : faces) {
    const Vector3 normal = normalOf(face);
    for (const Vector3& point : face) {
      appendVector(asset.views[kPositions], point);
      appendVector(asset.views[kNormals], normal);
      bounds.extend(point.cast<float>());
    }
    for (const auto& triangle : model::trianglesOf(face, normal)) {
      for (const int corner : triangle) {
        appendBytes(asset.views[kIndices], first + static_cast<std::uint32_t>(corner));
      }
    }
    first += static_cast<std::uint32_t>(face.size());
  }
  const Eigen::Vector3f &least = bounds.min(), &most = bounds.max();
  asset.accessors[positions]["min"] = {least.x(), least.y(), least.z()};
  asset.accessors[positions]["max"] = {most.x(), most.y(), most.z()};
  return {
      {"name", name},
      {"primitives", Json::array({{{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}},
                                   {"indices", indices},
                                   {"material", 0}}})}};
}

/// Writes single precision numbers at their position in a view.
template <std::size_t count>
void place(std::string& view, std::size_t index, const std::array<double, count>& numbers) {
  std::array<float, count> rounded{};
  for (std::size_t k = 0; k < count; ++k) rounded[k] = static_cast<float>(numbers[k]);
  std::memcpy(view.data() + index * sizeof rounded, rounded.data(), sizeof rounded);
}

/// Reads keys in sequence into glTF's order by brick, relative to the `origin` of the first key.
/// Returns the poses of the first key. Quaternions keep their sign between keys, because viewers
/// would otherwise rotate by more than half a turn.
Poses readKeys(const std::vector<brick::Brick>& bricks, std::size_t keyCount,
               const std::function<AnimationKey(std::size_t)>& key, Asset& asset, Vector3& origin) {
  const std::size_t brickCount = bricks.size();
  asset.views[kMoves].resize(brickCount * keyCount * 3 * sizeof(float));
  asset.views[kTurns].resize(brickCount * keyCount * 4 * sizeof(float));
  Poses first;
  Poses last;
  for (std::size_t k = 0; k < keyCount; ++k) {
    AnimationKey read = key(k);
    if (k == 0) origin = singleOrigin(worldCorners(bricks, read.poses));
    for (Pose& pose : read.poses) pose.position -= origin;
    appendBytes(asset.views[kTimes], static_cast<float>(read.time));
    for (std::size_t brick = 0; brick < brickCount; ++brick) {
      const Vector3& p = read.poses[brick].position;
      Quaternion& q = read.poses[brick].rotation;
      // q and -q are the same rotation, but interpolate differently.
      if (k > 0 && q.dot(last[brick].rotation) < 0) q.coeffs() = -q.coeffs();
      place<3>(asset.views[kMoves], brick * keyCount + k, {p.x(), p.y(), p.z()});
      place<4>(asset.views[kTurns], brick * keyCount + k, {q.x(), q.y(), q.z(), q.w()});
    }
    if (k == 0) first = read.poses;
    last = std::move(read.poses);
  }
  return first;
}

/// The end time in single precision, as stored.
Json animationJson(std::size_t brickCount, std::size_t keyCount, float endTime, Asset& asset) {
  // All samplers share the times.
  const std::size_t times = asset.declare(kTimes, "SCALAR", kGltfFloat, keyCount, 0);
  asset.accessors[times]["min"] = {0.0};
  asset.accessors[times]["max"] = {endTime};
  Json samplers = Json::array();
  Json channels = Json::array();
  const auto add = [&](std::size_t output, std::size_t brick, const char* path) {
    channels.push_back(
        {{"sampler", samplers.size()}, {"target", {{"node", brick + 1}, {"path", path}}}});
    samplers.push_back({{"input", times}, {"output", output}});
  };
  for (std::size_t brick = 0; brick < brickCount; ++brick) {
    const std::size_t first = brick * keyCount;
    add(asset.declare(kMoves, "VEC3", kGltfFloat, keyCount, first * 3 * sizeof(float)), brick,
        "translation");
    add(asset.declare(kTurns, "VEC4", kGltfFloat, keyCount, first * 4 * sizeof(float)), brick,
        "rotation");
  }
  return {{"name", "deployment"}, {"samplers", samplers}, {"channels", channels}};
}

/// The brick's pose at the first key, for viewers without animation.
Json nodeJson(const Pose& pose, const std::string& name, std::size_t mesh) {
  const auto f = [](double x) { return static_cast<float>(x); };
  const Vector3& p = pose.position;
  const Quaternion& q = pose.rotation;
  return {{"name", name},
          {"mesh", mesh},
          {"translation", {f(p.x()), f(p.y()), f(p.z())}},
          {"rotation", {f(q.x()), f(q.y()), f(q.z()), f(q.w())}}};
}

Json materialJson() {
  return {{"name", "sheet"},
          {"pbrMetallicRoughness",
           {{"baseColorFactor", {0.35, 0.55, 0.75, 1.0}}, {"metallicFactor", 0.0}}}};
}

/// Node 0 is the root, node k + 1 the brick k.
Json nodesJson(const Poses& start, const Vector3& origin) {
  Json children = Json::array();
  for (std::size_t k = 0; k < start.size(); ++k) children.push_back(k + 1);
  const double half = std::sqrt(0.5);
  Json nodes = Json::array();
  nodes.push_back(
      {{"name", "kirigami"}, {"rotation", {-half, 0, 0, half}}, {"children", children}});
  // In glTF's axes.
  if (!origin.isZero()) nodes[0]["translation"] = {origin.x(), origin.z(), -origin.y()};
  for (std::size_t k = 0; k < start.size(); ++k) {
    nodes.push_back(nodeJson(start[k], fmt::format("TILE_{:05}", k), k));
  }
  return nodes;
}

/// Views are in the buffer in the order of the enum. All have entries of 4 bytes, so all offsets
/// are multiples of 4, as glTF requires.
Json viewsJson(const Asset& asset) {
  Json views = Json::array();
  std::size_t offset = 0;
  for (int view = 0; view < kViewCount; ++view) {
    Json json = {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", asset.views[view].size()}};
    const bool isVertex = view == kPositions || view == kNormals;
    if (isVertex) json["byteStride"] = 3 * sizeof(float);
    if (isVertex) json["target"] = kVertexTarget;
    if (view == kIndices) json["target"] = kIndexTarget;
    offset += asset.views[view].size();
    views.push_back(std::move(json));
  }
  return views;
}

/// Chunks begin at multiples of four bytes.
void appendChunk(std::string& file, std::uint32_t type, const std::string& bytes, char filler) {
  const std::size_t padding = (4 - bytes.size() % 4) % 4;
  appendBytes(file, static_cast<std::uint32_t>(bytes.size() + padding));
  appendBytes(file, type);
  file.append(bytes).append(padding, filler);
}

/// The file's length is a 32-bit number.
void requireAddressable(std::size_t bytes) {
  constexpr std::size_t kMax = std::size_t{7} << 29U;  // leaves half a GiB for the JSON
  if (bytes <= kMax) return;
  throw InputError(fmt::format(
      "error: the animation would have {} bytes, at most {} fit into a .glb; record fewer samples",
      bytes, kMax));
}

/// The length in the header includes the header.
std::string glbFile(const std::string& json, const std::string& binary) {
  std::string chunks;
  appendChunk(chunks, kJsonChunk, json, ' ');
  appendChunk(chunks, kBinaryChunk, binary, '\0');
  std::string file;
  appendBytes(file, kMagic);
  appendBytes(file, std::uint32_t{2});
  appendBytes(file, static_cast<std::uint32_t>(12 + chunks.size()));
  return file + chunks;
}

}  // namespace

std::string animationBytes(const std::vector<brick::Brick>& bricks, std::size_t keyCount,
                           const std::function<AnimationKey(std::size_t)>& key) {
  Asset asset;
  Json meshes = Json::array();
  for (std::size_t k = 0; k < bricks.size(); ++k) {
    meshes.push_back(meshJson(bricks[k], fmt::format("TILE_{:05}", k), asset));
  }
  Vector3 origin = Vector3::Zero();
  const Poses start = readKeys(bricks, keyCount, key, asset, origin);
  float endTime = 0;
  std::memcpy(&endTime, &asset.views[kTimes].end()[-4], sizeof endTime);
  Json json = {{"asset", {{"version", "2.0"}, {"generator", "Kirireel"}}},
               {"scene", 0},
               {"scenes", Json::array({{{"nodes", {0}}}})},
               {"nodes", nodesJson(start, origin)},
               {"meshes", std::move(meshes)},
               {"materials", Json::array({materialJson()})}};
  json["animations"] = Json::array({animationJson(bricks.size(), keyCount, endTime, asset)});
  std::string binary;
  json["accessors"] = std::move(asset.accessors);
  json["bufferViews"] = viewsJson(asset);
  for (const std::string& view : asset.views) binary += view;
  requireAddressable(binary.size());
  json["buffers"] = {{{"byteLength", binary.size()}}};
  return glbFile(jsonText(json), binary);
}

}  // namespace kirireel::writers
