// Reads and writes FOLD files (1.0 to 1.2), including Kirireel's own keys.
//
// Reading has five steps.
// 1. Frames: the file's own keys are frame 0, file_frames are the others. A frame has its own keys
//    and, if it inherits, those of its parent. The model is the first frame with coordinates and
//    faces or edges. Later frames with the same faces or edges and with coordinates or fold angles
//    of their own are states of the same sheet: targets, one after the other. Others are models of
//    their own.
// 2. Faces: faces_vertices, else faces_edges, else the faces of the planar drawing (faces.h). Slits
//    and repeated vertices are removed, and faces that J edges join become one tile.
// 3. Joints: the key kirireel:joints, if it exists ([tile, vertex, tile, vertex, face, kind]
//    for each; kind 0 pivot, 1 link, 2 fixed, absent for 0), else the edges (model_formats.h). The
//    key kirireel:necks has their necks ([joint, width, length, kerf] for each, in frame_unit).
// 4. With one state, the target of a flat sheet is that state folded by its edges_foldAngle. M and
//    V edges of a flat sheet without an angle fold by 180 degrees, or by the requested fraction.
//    Frames with only angles are the same sheet, folded. The sheet may lie in any plane; its upper
//    side is where its faces run anticlockwise. A flat foldedForm is folded already, and its angles
//    of 0 and 180 degrees describe it. With other angles it is a crease pattern.
// 5. Springs at folds rest at these angles.
//
// A model keeps the vertices, edges and faces of its file (FoldSheet), and writing gives them
// again. Corners of one vertex that separate in a written state, such as the sides of an opening
// cut, get further vertices and edges at the end of the lists. Without a FoldSheet, writing merges
// corners into one vertex only if they are bitwise equal in all states. Reading then gives the same
// doubles. kirireel:joints preserves joints of corners that differ by rounding. nlohmann's
// ordered_json keeps the order of keys, so the same model gives the same bytes.
//
// The library throws if types do not fit. Every access below is checked first, so messages can name
// faces and edges.
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "sim/base/disjoint_sets.h"
#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/base/words.h"
#include "sim/formats/faces.h"
#include "sim/formats/joint_checks.h"
#include "sim/formats/model_formats.h"
#include "sim/formats/read_settings.h"
#include "sim/formats/shared_corners.h"
#include "sim/formats/text_table.h"
#include "sim/formats/tile_checks.h"
#include "sim/formats/written_digits.h"
#include "sim/model/sheet_frame.h"

namespace kirireel::formats {
namespace {

namespace fs = std::filesystem;
constexpr const char* kPlaces = "vertices_coords";
constexpr const char* kAngles = "edges_foldAngle";
constexpr const char* kOldAngles = "edges_foldAngles";  // in FOLD 1.0
constexpr const char* kJoints = "kirireel:joints";
constexpr const char* kNecks = "kirireel:necks";
constexpr const char* kPulled = "kirireel:pulled_tiles";
constexpr const char* kTargets = "kirireel:targets";

// Of the file, and of the frame that is read.
constexpr std::array kTexts = {"file_title", "file_author", "file_description", "frame_title",
                               "frame_description"};

using FoldAngles = std::vector<std::optional<double>>;  // of all edges, degrees

// An edge with a smaller angle is flat, degrees.
constexpr double kFlatEdge = 1e-6;

// FOLD has values nested five deep. Keys of other programs may have more.
constexpr int kMaxNested = 64;

// The whole file as JSON; its syntax errors as ours.
Json parsedFile(const fs::path& file) {
  try {
    return parseJson(readPlainText(file, "give a FOLD file"), kMaxNested);
  } catch (const std::length_error&) {
    throw inputErrorAt(
        {file},
        fmt::format(
            "values are nested more than {} deep, but a FOLD file has 5 levels. Give a FOLD file",
            kMaxNested));
  } catch (const Json::exception& error) {
    // The library's texts begin with "[json.exception.parse_error.101] ", which is not useful.
    const std::string_view text = error.what();
    const std::string_view reason = text.substr(text.find("] ") + 2);  // after its number
    throw inputErrorAt({file},
                       fmt::format("this is not JSON ({}). Give a FOLD file", shown(reason, 160)));
  }
}

// Numbers such as 1e99 or 2^40 are valid JSON. A cast would wrap them to an existing vertex.
bool fitsInt(const Json& value) {
  if (!value.is_number_integer()) return false;
  if (value.is_number_unsigned()) {
    return value.get<std::uint64_t>() <= std::uint64_t{std::numeric_limits<int>::max()};
  }
  return value.get<std::int64_t>() >= std::numeric_limits<int>::min();
}

/// Gives vertices other numbers. An edge that is then there twice is one. If it was the boundary on
/// both sides, it is a cut; otherwise the side that has a fold decides.
void renumber(const std::vector<int>& numbers, model::FoldSheet& drawing) {
  for (std::vector<int>& face : drawing.faces) {
    for (int& vertex : face) vertex = numbers[vertex];
  }
  std::vector<model::Crease> creases;
  std::map<std::pair<int, int>, std::size_t> known;
  for (model::Crease crease : drawing.creases) {
    crease.from = numbers[crease.from];
    crease.to = numbers[crease.to];
    if (crease.from == crease.to) continue;
    const auto [found, isNew] = known.emplace(std::minmax(crease.from, crease.to), creases.size());
    if (isNew) {
      creases.push_back(crease);
      continue;
    }
    model::Crease& first = creases[found->second];
    if (first.assignment == 'B') {
      first = crease;
      if (crease.assignment == 'B') first.assignment = 'C';
    }
  }
  drawing.creases = std::move(creases);
}

/// One frame of the file, with readers that describe faults in it.
class FoldReader {
 public:
  FoldReader(const fs::path& file, const ReadSettings& settings)
      : file_(file), whole_(parsedFile(file)) {
    if (!whole_.is_object())
      throw fault(
          fmt::format("the file is {}, not a JSON object. Give a FOLD file", found(whole_)));
    findFrames();
    chooseFrame(settings);
  }

  /// The unit in frame_unit; absent if there is none or it is not a unit of length.
  std::optional<LengthUnit> unit() const { return unitOf(frame_); }

  /// The frames of the start and of all later states of the same sheet.
  const std::vector<int>& stateFrames() const { return states_; }

  /// Whether a state has coordinates of its own. Otherwise it has only fold angles.
  bool hasOwnPlaces(int frame) const {
    const Json *theirs = find(frame, kPlaces), *start = find(kPlaces);
    return frame == frame_ || (theirs != start && *theirs != *start) ||
           anglesKey(frame) == anglesKey(frame_);
  }

  /// The coordinates of the start, followed by those of all states of the same sheet that have
  /// coordinates.
  std::vector<std::vector<Vector3>> states() const {
    std::vector<std::vector<Vector3>> states;
    for (const int frame : states_) {
      if (!hasOwnPlaces(frame)) continue;
      std::vector<Vector3>& state = states.emplace_back(points(*find(frame, kPlaces)));
      // Frames may have their own units.
      if (unit() && unitOf(frame) && *unit() != *unitOf(frame)) {
        for (Vector3& point : state) point *= unitOf(frame)->metres / unit()->metres;
      }
    }
    return states;
  }

  /// The checked edges: their ends are vertices, and there are as many letters and angles as edges.
  /// `frame`: a state of the sheet, whose fold angles they have.
  model::FoldSheet drawing(const std::vector<Vector3>& points, int frame) const {
    model::FoldSheet drawing;
    drawing.vertices = points;
    const Json edges = edgeList();
    for (const Json& edge : edges) {
      const std::vector<int> ends = wholeNumbers(edge, drawing.creases.size());
      const auto exists = [&](int end) { return end >= 0 && end < std::ssize(points); };
      if (ends.size() != 2 || !std::ranges::all_of(ends, exists)) {
        throw fault(
            fmt::format("edge {} is {}, but an edge joins two of the vertices 0-{}; correct it, or "
                        "delete edges_vertices",
                        drawing.creases.size(), found(edge), points.size() - 1));
      }
      drawing.creases.push_back({ends[0], ends[1]});
    }
    // Without a list of edges, letters and angles have no meaning.
    if (find("edges_vertices") != nullptr) {
      addLetters(drawing);
      const auto angles = foldAngles(frame, drawing.creases.size());
      drawing.hasAngles = !angles.empty();
      for (std::size_t k = 0; k < angles.size(); ++k) drawing.creases[k].foldAngle = angles[k];
    }
    addFaces(drawing);
    drawing.isFolded = isFoldedForm();
    for (const char* key : kTexts) {
      const Json* text =
          own(std::string_view(key).starts_with("file_") ? whole_ : *frames_[frame_], key);
      if (text != nullptr && text->is_string()) drawing.texts[key] = text->get<std::string>();
    }
    return drawing;
  }

  /// The fold angles of a frame with this many edges, degrees; empty if it has none.
  FoldAngles foldAngles(int frame, std::size_t count) const {
    const Json* list = anglesKey(frame);
    if (list == nullptr) return {};
    if (!list->is_array() || list->size() != count) {
      throw fault(fmt::format("{} is {}, but {} edges need as many angles. Correct or delete it",
                              find(frame, kAngles) ? kAngles : kOldAngles, found(*list), count));
    }
    FoldAngles angles;
    for (const Json& angle : *list) {
      // FOLD writes null for edges whose angle is unknown, boundaries among them.
      if (!angle.is_null() && !(angle.is_number() && std::abs(angle.get<double>()) <= 180)) {
        throw fault(fmt::format(
            "edge {} has the fold angle {}, which is neither null nor in [-180, 180] degrees. "
            "Correct it",
            angles.size(), found(angle)));
      }
      angles.push_back(angle.is_null() ? std::nullopt : std::optional(angle.get<double>()));
    }
    return angles;
  }

  /// Requires that every vertex of the faces has coordinates.
  void requireVertices(const CornerNumbers& faces, std::size_t count) const {
    for (std::size_t face = 0; face < faces.size(); ++face) {
      for (const int number : faces[face]) {
        if (number >= 0 && number < static_cast<long>(count)) continue;
        throw fault(
            fmt::format("face {} has the vertex {}, but there are vertices 0-{}; correct "
                        "it: FOLD counts from 0",
                        face, number, count - 1));
      }
    }
  }

  /// Whether the frame is a folded state. Its letters then do not define how to fold it.
  bool isFoldedForm() const {
    const Json* classes = find("frame_classes");
    return classes != nullptr && classes->is_array() &&
           std::ranges::find(*classes, Json("foldedForm")) != classes->end();
  }

  /// Kirireel's own list of joints; null if there is none.
  const Json* ownJoints() const { return find(kJoints); }

  /// Adds necks to the rows of Kirireel's own list of joints.
  void addNecks(JointTable& table) const {
    const Json* list = find(kNecks);
    if (list == nullptr) return;
    for (const Json& entry : *list) {
      const bool isNeck = entry.is_array() && entry.size() == 4 && fitsInt(entry[0]) &&
                          std::ranges::all_of(entry, [](const Json& v) { return v.is_number(); });
      if (!isNeck) {
        throw fault(fmt::format(
            "{} has the entry {}, which is not a neck. Write joint, width, length and kerf", kNecks,
            found(entry)));
      }
      setNeck(entry[0].get<int>(),
              {entry[1].get<double>(), entry[2].get<double>(), entry[3].get<double>()}, {file_},
              table);
    }
  }

  /// The targets of a deployment's file, whose frames are samples of a run. Null in other files,
  /// empty if the run has no target.
  const Json* ownTargets() const { return find(kTargets); }

  /// Kirireel's own list of pulled tiles for this tile count; absent if all are pulled.
  std::optional<std::vector<int>> pulledTiles(std::size_t tileCount) const {
    const Json* list = find(kPulled);
    if (list == nullptr) return std::nullopt;
    std::vector<int> pulled = wholeNumbers(*list, 0);
    for (const int tile : pulled) {
      if (tile >= 0 && tile < static_cast<int>(tileCount)) continue;
      throw fault(fmt::format("{} names tile {}, but the file has tiles 0-{}. Correct the number",
                              kPulled, tile, tileCount - 1));
    }
    return pulled;
  }

  /// Whether a key is read, follows from others, or is reported with its name.
  static bool isOfFold(const std::string& key) {
    static const std::set<std::string> kKeys = {
        kPlaces,          "vertices_vertices", "vertices_edges", "vertices_faces",
        "edges_vertices", "edges_faces",       "edges_length",   "edges_assignment",
        kAngles,          kOldAngles,          "faces_vertices", "faces_edges",
        "faces_faces",    "faceOrders",        "edgeOrders"};
    const bool isOwn = key.starts_with("kirireel:") || key.starts_with("file_");
    return isOwn || key.starts_with("frame_") || kKeys.contains(key);
  }

  /// Appends one line about frames and one about keys that are not read.
  void warnOfIgnored(const ReadSettings& settings, std::vector<std::string>& warnings) const {
    const int count = static_cast<int>(frames_.size());
    // A frame may have only keys that states inherit.
    std::set<int> read;
    for (int frame : states_) {
      for (; frame >= 0; frame = parents_[static_cast<std::size_t>(frame)]) read.insert(frame);
    }
    const int others = count - static_cast<int>(read.size());
    const bool isChain = states_.size() > 2;
    const bool isSeries = isChain && states_.size() > 4 &&
                          states_.back() - states_[1] == static_cast<int>(states_.size()) - 2;
    const bool isOwn = ownTargets() != nullptr;
    if (!settings.frame && !isOwn && (others > 0 || isChain)) {
      std::string targets =
          isChain               ? fmt::format(", frames {} are targets one after the other",
                                isSeries ? fmt::format("{}-{}", states_[1], states_.back())
                                                       : fmt::format("{}", fmt::join(states_.begin() + 1,
                                                                                     states_.end(), ", ")))
                        : states_.size() == 2 ? fmt::format(", frame {} its target", states_[1])
                                : "";
      warnings.push_back(fmt::format(
          "{}: warning: of frames 0-{}, frame {} is the start{}{}; `frame = N` reads frame N only",
          file_.string(), count - 1, frame_, targets,
          others > 0 ? fmt::format(", and {} not read", counted(others, "other is", "others are"))
                     : ""));
    }
    // FOLD's "unit" is not a unit of length.
    const Json* name = find("frame_unit");
    if (name != nullptr && !unit() && *name != "unit" && !settings.unit) {
      warnings.push_back(
          fmt::format("{}: warning: frame_unit {} is not known, so lengths are in m; set `unit`",
                      file_.string(), shown(name->dump(), 24)));
    }
    std::vector<std::string> ignored, foreign;
    for (const char* key : {"faceOrders", "edgeOrders"}) {
      const Json* list = find(key);
      if (list != nullptr && !list->empty()) {
        ignored.push_back(fmt::format("the order of layers in {}", key));
      }
    }
    for (const auto& [key, value] : frames_[static_cast<std::size_t>(frame_)]->items()) {
      if (!isOfFold(key)) foreign.push_back(shown(key, 24));
    }
    if (!foreign.empty()) {
      const auto shownEnd = foreign.begin() + std::min<std::ptrdiff_t>(3, std::ssize(foreign));
      ignored.push_back(fmt::format("{} of other programs ({}{})", counted(foreign.size(), "key"),
                                    fmt::join(foreign.begin(), shownEnd, ", "),
                                    foreign.size() > 3 ? ", ..." : ""));
    }
    if (ignored.empty()) return;
    warnings.push_back(
        fmt::format("{}: warning: not read: {}", file_.string(), fmt::join(ignored, ", ")));
  }

  // A list of numbers that fit an int. `index` names the entry in the message.
  std::vector<int> wholeNumbers(const Json& list, std::size_t index) const {
    std::vector<int> numbers;
    for (const Json& value : list) {
      if (fitsInt(value)) numbers.push_back(value.get<int>());
    }
    // A value that is not a whole number makes the counts differ.
    if (list.is_array() && numbers.size() == list.size()) return numbers;
    throw fault(
        fmt::format("entry {} is {}, not a list of whole numbers. Write vertex numbers >= 0", index,
                    found(list)));
  }

  // Coordinates of all vertices, metres. The default of z is 0.
  std::vector<Vector3> points(const Json& coordinates) const {
    std::vector<Vector3> points;
    for (const Json& entry : coordinates) {
      Vector3& point = points.emplace_back(Vector3::Zero());
      // Two coordinates are a planar pattern at z = 0.
      const bool isPoint = entry.is_array() && (entry.size() == 2 || entry.size() == 3);
      for (std::size_t axis = 0; isPoint && axis < entry.size(); ++axis) {
        // NaN for a value that is not a number. The test below refuses it.
        point[static_cast<int>(axis)] = entry[axis].is_number() ? entry[axis].get<double>() : NAN;
      }
      if (isPoint && point.allFinite() && point.cwiseAbs().maxCoeff() <= kMaxCoordinate) continue;
      throw fault(
          fmt::format("vertex {} is {}, not two or three coordinates within {:g}; correct it",
                      points.size() - 1, found(entry), kMaxCoordinate));
    }
    return points;
  }

  InputError fault(const std::string& message) const { return inputErrorAt({file_}, message); }

  /// A value in a message: its text, or the length of a long list.
  static std::string found(const Json& value) {
    constexpr std::size_t kShort = 24;  // letters
    const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (value.is_array() && text.size() > kShort)
      return fmt::format("a list of {} entries", value.size());
    return shown(text, kShort);
  }

 private:
  std::optional<LengthUnit> unitOf(int frame) const {
    const Json* value = find(frame, "frame_unit");
    return value && value->is_string() ? findLengthUnit(value->get<std::string>()) : std::nullopt;
  }

  static const Json* own(const Json& object, const char* key) {
    const auto found = object.find(key);
    return found == object.end() ? nullptr : &*found;
  }

  // The value of a key in a frame or in those that it inherits from; null if none has it.
  const Json* find(int frame, const char* key) const {
    while (frame >= 0) {
      const auto at = static_cast<std::size_t>(frame);
      if (const Json* value = own(*frames_[at], key)) return value;
      frame = parents_[at];
    }
    return nullptr;
  }

  const Json* find(const char* key) const { return find(frame_, key); }

  void findFrames() {
    frames_ = {&whole_};
    const Json* frames = own(whole_, "file_frames");
    if (frames != nullptr && !frames->is_array()) {
      throw fault(fmt::format("file_frames is {}, not a list of frames. Correct or delete it",
                              found(*frames)));
    }
    for (std::size_t k = 0; frames != nullptr && k < frames->size(); ++k) {
      if (!(*frames)[k].is_object()) {
        throw fault(
            fmt::format("entry {} of file_frames is {}, not a JSON object. Correct or delete it", k,
                        found((*frames)[k])));
      }
      frames_.push_back(&(*frames)[k]);
    }
    for (std::size_t k = 0; k < frames_.size(); ++k) parents_.push_back(parentOf(k));
    requireNoCircle();
  }

  /// The frame that a frame inherits from; -1 for none.
  int parentOf(std::size_t k) const {
    if (k == 0) return -1;
    const Json& frame = *frames_[k];
    const Json* inherits = own(frame, "frame_inherit");
    const bool isState = inherits == nullptr && isBareState(frame);
    if (!isState && (inherits == nullptr || *inherits != Json(true))) return -1;
    const Json* parent = own(frame, "frame_parent");
    if (parent == nullptr) return 0;
    if (fitsInt(*parent) && parent->get<int>() >= 0 && parent->get<int>() < std::ssize(frames_)) {
      return parent->get<int>();
    }
    throw fault(
        fmt::format("frame {} has the frame_parent {}, but there are frames 0-{}; correct "
                    "it",
                    k, shown(parent->dump(), 24), frames_.size() - 1));
  }

  /// Some programs write a state without frame_inherit: it has as many coordinates as the key
  /// frame, and no other mesh data.
  bool isBareState(const Json& frame) const {
    for (const char* key : kStructure) {
      if (own(frame, key) != nullptr) return false;
    }
    const Json *coordinates = own(frame, kPlaces), *all = own(whole_, kPlaces);
    return coordinates != nullptr && all != nullptr && coordinates->size() == all->size();
  }

  void requireNoCircle() const {
    for (std::size_t k = 0; k < frames_.size(); ++k) {
      std::size_t steps = 0;
      for (int at = parents_[k]; at >= 0; at = parents_[static_cast<std::size_t>(at)]) {
        if (++steps <= frames_.size()) continue;
        throw fault(fmt::format("frame {} inherits from itself. Correct frame_parent", k));
      }
    }
  }

  bool hasCoordinates(int frame) const {
    const Json* coordinates = find(frame, kPlaces);
    return coordinates != nullptr && coordinates->is_array() && !coordinates->empty();
  }

  bool hasStructure(int frame) const {
    return std::ranges::any_of(kStructure, [&](const char* key) {
      const Json* list = find(frame, key);
      return list != nullptr && list->is_array() && !list->empty();
    });
  }

  void chooseFrame(const ReadSettings& settings) {
    const int count = static_cast<int>(frames_.size());
    if (settings.frame && *settings.frame >= count) {
      throw fault(
          fmt::format("there {}, not frame {}; correct `frame`",
                      count == 1 ? "is frame 0 only" : fmt::format("are frames 0-{}", count - 1),
                      *settings.frame));
    }
    const auto holdsModel = [&](int frame) { return hasCoordinates(frame) && hasStructure(frame); };
    frame_ = settings.frame.value_or(0);
    while (!settings.frame && frame_ + 1 < count && !holdsModel(frame_)) ++frame_;
    if (!hasCoordinates(frame_)) {
      throw fault("vertices_coords is missing. Add the coordinates of the vertices");
    }
    if (!hasStructure(frame_)) {
      throw fault(
          "faces_vertices and edges_vertices are missing. Add the faces or the edges of the sheet");
    }
    states_ = {frame_};
    if (settings.frame || ownTargets() != nullptr) return;
    for (int frame = frame_ + 1; frame < count; ++frame) {
      if (isStateOfSheet(frame)) states_.push_back(frame);
    }
  }

  /// A frame with coordinates or fold angles of its own, and the faces and edges of the start.
  bool isStateOfSheet(int frame) const {
    const Json *own = find(frame, kPlaces), *start = find(kPlaces);
    if (!hasCoordinates(frame) || own->size() != start->size() || !hasStructure(frame))
      return false;
    if (own == start && anglesKey(frame) == anglesKey(frame_)) return false;
    return std::ranges::all_of(kStructure, [&](const char* key) {
      const Json *theirs = find(frame, key), *ours = find(key);
      return theirs == nullptr || theirs == ours || (ours != nullptr && *theirs == *ours);
    });
  }

  /// edges_vertices, else the neighbours of vertices_vertices, each pair once.
  Json edgeList() const {
    const Json* edges = find("edges_vertices");
    if (edges != nullptr) {
      if (edges->is_array()) return *edges;
      throw fault(fmt::format("edges_vertices is {}, not a list of edges. Correct or delete it",
                              found(*edges)));
    }
    const Json* neighbours = find("vertices_vertices");
    Json found = Json::array();
    if (neighbours == nullptr || !neighbours->is_array()) return found;
    for (std::size_t k = 0; k < neighbours->size(); ++k) {
      for (const int other : wholeNumbers((*neighbours)[k], k)) {
        if (other >= static_cast<int>(k)) found.push_back({k, other});
      }
    }
    return found;
  }

  void addLetters(model::FoldSheet& drawing) const {
    const Json* assignment = find("edges_assignment");
    if (assignment == nullptr) return;
    const std::size_t count = drawing.creases.size();
    if (!assignment->is_array() || assignment->size() != count) {
      throw fault(fmt::format(
          "edges_assignment is {}, but {} edges need as many letters. Correct or delete it",
          found(*assignment), count));
    }
    drawing.hasLetters = true;
    for (std::size_t k = 0; k < count; ++k) {
      drawing.creases[k].assignment = letterOf((*assignment)[k]);
      if (drawing.creases[k].assignment != 0) continue;
      throw fault(fmt::format("edge {} has the assignment {}. Write one of B, M, V, F, U, C, J", k,
                              found((*assignment)[k])));
    }
  }

  /// edges_foldAngle of a frame, or the key of FOLD 1.0; null if it has neither.
  const Json* anglesKey(int frame) const {
    const Json* angles = find(frame, kAngles);
    return angles != nullptr ? angles : find(frame, kOldAngles);
  }

  /// The letter of an assignment as a capital; 0 if it is invalid.
  static char letterOf(const Json& value) {
    if (!value.is_string() || value.get_ref<const std::string&>().size() != 1) return 0;
    const char letter =
        static_cast<char>(std::toupper(static_cast<unsigned char>(value.get<std::string>()[0])));
    return model::isFoldLetter(letter) ? letter : '\0';
  }

  void addFaces(model::FoldSheet& drawing) const {
    const Json *faces = find("faces_vertices"), *ofEdges = find("faces_edges");
    if (faces != nullptr && faces->is_array() && !faces->empty()) {
      for (const Json& face : *faces) {
        drawing.faces.push_back(wholeNumbers(face, drawing.faces.size()));
      }
    } else if (ofEdges != nullptr && ofEdges->is_array() && !ofEdges->empty()) {
      for (const Json& face : *ofEdges) {
        drawing.faces.push_back(cornersBetween(wholeNumbers(face, drawing.faces.size()), drawing));
      }
    } else {
      renumber(numbersByPlace(drawing.vertices), drawing);
      drawing.faces = planarFaces(drawing.vertices, drawing.creases, file_);
    }
    requireVertices(drawing.faces, drawing.vertices.size());
  }

  /// The common vertex of each edge around a face and the previous edge.
  std::vector<int> cornersBetween(const std::vector<int>& edges,
                                  const model::FoldSheet& drawing) const {
    const std::vector<model::Crease>& all = drawing.creases;
    const std::size_t face = drawing.faces.size();
    std::vector<int> corners;
    for (std::size_t k = 0; k < edges.size(); ++k) {
      const int last = edges[(k + edges.size() - 1) % edges.size()], next = edges[k];
      const bool areThere = std::min(last, next) >= 0 && std::max(last, next) < std::ssize(all);
      const auto joins = [&](int end) { return all[next].from == end || all[next].to == end; };
      // Two edges of a face with two edges share both ends. Such a face is refused later.
      if (!areThere || (!joins(all[last].from) && !joins(all[last].to))) {
        throw fault(
            fmt::format("face {} has the consecutive edges {} and {}, which have no common vertex. "
                        "Correct faces_edges, or write faces_vertices",
                        face, last, next));
      }
      corners.push_back(joins(all[last].to) ? all[last].to : all[last].from);
    }
    return corners;
  }

  static constexpr const char* kStructure[] = {"faces_vertices", "faces_edges", "edges_vertices",
                                               "vertices_vertices"};
  fs::path file_;
  Json whole_;
  std::vector<const Json*> frames_;  ///< 0 is the key frame
  std::vector<int> parents_;         ///< parent frame of each; -1 for none
  int frame_ = 0;                    ///< of the model
  std::vector<int> states_;          ///< its frame and the frames of its other states
};

/// Tiles with the positions that checks report: faces are counted, since a FOLD file has no lines.
TileTable tableOf(const fs::path& file, const CornerNumbers& outlines,
                  const std::vector<Vector3>& points) {
  TileTable table;
  table.file = file;
  for (const std::vector<int>& outline : outlines) {
    model::Tile& tile = table.tiles.emplace_back();
    for (const int number : outline) tile.vertices.push_back(points[number]);
    table.sources.push_back({0, std::vector<int>(outline.size(), 0)});
  }
  return table;
}

/// Faces in all states.
class FacesInStates {
 public:
  FacesInStates(const CornerNumbers& faces, const std::vector<std::vector<Vector3>>& states) {
    for (const std::vector<Vector3>& points : states) {
      tiles_.push_back(tableOf({}, faces, points).tiles);
    }
    for (const std::vector<model::Tile>& state : tiles_) all_.push_back(&state);
  }
  FacesInStates(const FacesInStates&) = delete;
  FacesInStates& operator=(const FacesInStates&) = delete;

  const std::vector<const std::vector<model::Tile>*>& all() const { return all_; }

 private:
  std::vector<std::vector<model::Tile>> tiles_;
  std::vector<const std::vector<model::Tile>*> all_;
};

/// Gives vertices at one position one number, as in a mesh whose faces have their own vertices.
void mergeRepeatedVertices(const std::vector<std::vector<Vector3>>& states, const fs::path& file,
                           model::FoldSheet& drawing) {
  const FacesInStates faces(drawing.faces, states);
  const CornerNumbers merged = meshNumbers(drawing.faces, faces.all(), file);
  if (merged == drawing.faces) return;
  std::vector<int> numbers = numbersBelow(drawing.vertices.size());
  for (std::size_t face = 0; face < merged.size(); ++face) {
    for (std::size_t k = 0; k < merged[face].size(); ++k) {
      numbers[drawing.faces[face][k]] = merged[face][k];
    }
  }
  renumber(numbers, drawing);
}

/// Removes slits and repeated vertices from the faces, and joins those that J edges join.
void findTiles(const FoldReader& reader, const std::vector<std::vector<Vector3>>& states,
               model::FoldSheet& drawing) {
  CornerNumbers outlines;
  for (const std::vector<int>& face : drawing.faces) {
    outlines.push_back(faceOutline(face));
    if (outlines.back().size() >= 3) continue;
    throw reader.fault(
        fmt::format("face {} has {} vertices; a tile has at least 3: complete it or "
                    "delete it",
                    outlines.size() - 1, outlines.back().size()));
  }
  std::set<std::pair<int, int>> joined;
  for (const model::Crease& crease : drawing.creases) {
    if (crease.assignment == 'J') joined.insert(std::minmax(crease.from, crease.to));
  }
  if (joined.empty()) {
    drawing.outlines = std::move(outlines);
    drawing.tileOf = numbersBelow(drawing.faces.size());
    return;
  }
  // Faces on both sides of a J edge, if they stay coplanar in all states.
  const FacesInStates faces(outlines, states);
  JoinedFaces pieces = joinFaces(outlines, coplanarFaces(outlines, faces.all(), &joined));
  drawing.outlines = std::move(pieces.tiles);
  drawing.tileOf = std::move(pieces.tileOf);
}

/// Whether an edge has the letter of a fold, mountain or valley.
bool hasFoldLetter(const model::Crease& crease) {
  return crease.assignment == 'M' || crease.assignment == 'V';
}

/// Warns of edges without a face, of folds at the border, and of letters that contradict angles.
void warnOfEdges(const model::FoldSheet& drawing, const fs::path& file,
                 std::vector<std::string>& warnings) {
  std::map<std::pair<int, int>, int> facesAt;
  for (const std::vector<int>& face : drawing.faces) {
    for (std::size_t k = 0; k < face.size(); ++k) {
      ++facesAt[std::minmax(face[k], face[(k + 1) % face.size()])];
    }
  }
  const auto facesOf = [&](const model::Crease& crease) {
    const auto found = facesAt.find(std::minmax(crease.from, crease.to));
    return found == facesAt.end() ? 0 : found->second;
  };
  const auto warn = [&](const auto& isOne, const char* one, const char* many, const char* remedy) {
    const auto count = std::ranges::count_if(drawing.creases, isOne);
    if (count == 0) return;
    const auto first = std::ranges::find_if(drawing.creases, isOne) - drawing.creases.begin();
    warnings.push_back(fmt::format("{}: warning: {}, edge {} is the first; {}", file.string(),
                                   counted(count, one, many), first, remedy));
  };
  warn([&](const model::Crease& crease) { return facesOf(crease) == 0; },
       "edge is a side of no face and is not read", "edges are sides of no face and are not read",
       "split the faces there, or delete the edges");
  warn([&](const model::Crease& crease) { return hasFoldLetter(crease) && facesOf(crease) == 1; },
       "fold (M or V) has a face on one side only and does not fold",
       "folds (M or V) have a face on one side only and do not fold",
       "draw the border of the sheet (B) around them");
  warn(
      [&](const model::Crease& crease) {
        const double angle = crease.foldAngle.value_or(0);
        return hasFoldLetter(crease) && (crease.assignment == 'M' ? angle > 0 : angle < 0);
      },
      "edge has a letter (M or V) against the sign of its angle, which decides",
      "edges have a letter (M or V) against the sign of their angle, which decides",
      "a mountain has an angle < 0, a valley > 0");
}

/// Replaces a pivot as read by a joint of this kind.
model::Joint ofKind(model::JointKind kind, const model::Joint& pivot, const FoldReader& reader,
                    const std::vector<model::Tile>& tiles) {
  const model::Joint joint = model::toKind(kind, pivot, tiles);
  if (kind != model::JointKind::Link || joint.apart.norm() > 0) return joint;
  throw reader.fault(fmt::format(
      "the link between tiles {} and {} has no length. Remove its kind to join the corners",
      joint.a.tile, joint.b.tile));
}

/// The kinds of joints with their numbers, for messages.
std::string listedKinds() {
  std::vector<std::string> kinds;
  for (const char* name : model::kJointKinds)
    kinds.push_back(fmt::format("{} ({})", kinds.size(), name));
  return fmt::format("{}", fmt::join(kinds, ", "));
}

std::vector<model::Joint> readOwnJoints(const FoldReader& reader, const TileTable& tiles,
                                        model::Model& model, std::vector<std::string>& warnings) {
  JointTable table;
  table.file = tiles.file;
  for (const Json& entry : *reader.ownJoints()) {
    const std::vector<int> numbers = reader.wholeNumbers(entry, table.rows.size());
    if (numbers.size() != 5 && numbers.size() != 6) {
      throw reader.fault(
          fmt::format("joint {} has {} numbers; write tile, vertex, tile, vertex, "
                      "face, and kind unless it is a pivot",
                      table.rows.size(), numbers.size()));
    }
    JointRow& row = table.rows.emplace_back();
    std::copy_n(numbers.begin(), 5, row.values.begin());
    const int kind = numbers.size() == 5 ? 0 : numbers[5];
    if (kind < 0 || kind >= static_cast<int>(model::kJointKinds.size())) {
      throw reader.fault(fmt::format("joint {} has the kind {}; write one of {}",
                                     table.rows.size() - 1, kind, listedKinds()));
    }
    row.kind = static_cast<model::JointKind>(kind);
  }
  reader.addNecks(table);
  dropRepeatedJoints(table, model, warnings);
  std::vector<model::Joint> joints = checkedJoints(table, tiles);
  for (std::size_t k = 0; k < joints.size(); ++k) {
    joints[k] = ofKind(table.rows[k].kind, joints[k], reader, tiles.tiles);
  }
  return joints;
}

bool isWithoutAngle(const model::Crease& crease) {
  return hasFoldLetter(crease) && !crease.foldAngle;
}

/// Whether the sheet turns about an edge. Cuts and boundaries have one face on each side.
bool folds(const model::Crease& crease) {
  const bool isHinge = crease.assignment != 'C' && crease.assignment != 'B';
  return isHinge && std::abs(crease.foldAngle.value_or(0)) > kFlatEdge;
}

/// Gives M and V edges of a flat sheet without an angle the angle of their letter, with a warning.
/// Angles set by an option become those of the drawing.
void foldByLetters(const ReadSettings& settings, model::FoldSheet& drawing,
                   std::vector<model::Crease>& creases, const fs::path& file,
                   std::vector<std::string>& warnings) {
  const double angle = 180 * settings.fold.value_or(1);
  int count = 0, flat = 0;
  for (model::Crease& crease : creases) {
    flat += hasFoldLetter(crease) && crease.foldAngle && *crease.foldAngle == 0;
    if (!isWithoutAngle(crease)) continue;
    crease.foldAngle = crease.assignment == 'M' ? -angle : angle;
    ++count;
  }
  if (count > 0) {
    warnings.push_back(fmt::format(
        "{}: warning: {} by {:g} degrees. `fold = FRACTION` sets another fraction of 180",
        file.string(),
        counted(count, "edge has a letter (M or V) but no angle and folds",
                "edges have a letter (M or V) but no angle and fold"),
        angle));
  } else if (settings.fold) {
    throw inputErrorAt({file},
                       "`fold` is given, but no edge has a letter (M or V) without an "
                       "angle; remove `fold`, or the angles from the file");
  } else if (flat > 0 && std::ranges::all_of(creases, [](const model::Crease& crease) {
               return crease.foldAngle.value_or(0) == 0;
             })) {
    warnings.push_back(
        fmt::format("{}: warning: {} a letter (M or V) and the angle 0, so nothing folds; remove "
                    "edges_foldAngle to fold by the letters",
                    file.string(), counted(flat, "edge has", "edges have")));
  }
  if (settings.fold) {
    drawing.creases = creases;
    drawing.hasAngles = true;
  }
}

/// Gives M and V edges without an angle the angle in the target. At 180 degrees only the letter
/// defines the sign.
void takeAnglesOfTarget(const CornerNumbers& faces, const std::vector<model::Tile>& target,
                        std::vector<model::Crease>& creases) {
  if (std::ranges::none_of(creases, isWithoutAngle)) return;
  std::map<std::pair<int, int>, double> angles;
  for (const model::Crease& crease : creasesOf(faces, target)) {
    if (crease.foldAngle) angles[{crease.from, crease.to}] = std::abs(*crease.foldAngle);
  }
  for (model::Crease& crease : creases) {
    if (!isWithoutAngle(crease)) continue;
    const auto found = angles.find(std::minmax(crease.from, crease.to));
    if (found == angles.end()) continue;
    crease.foldAngle = crease.assignment == 'M' ? -found->second : found->second;
  }
}

/// A sheet folded along its creases.
struct FoldedSheet {
  std::vector<model::Tile> tiles;
  double gap = 0;       ///< largest gap of a joint, metres
  bool isOpen = false;  ///< angles around a loop are inconsistent
};

/// The flat sheet folded along its creases; the sheet itself if no crease has an angle.
FoldedSheet foldAlong(const std::vector<model::Crease>& creases, const model::Model& model,
                      const Vector3& normal) {
  FoldedSheet folded;
  folded.tiles =
      foldedTiles(model.drawing->outlines, creases, model.tiles, normal).value_or(model.tiles);
  folded.gap = model::largestJointGap(model.joints, folded.tiles);
  folded.isOpen = folded.gap > kMaxGap * model::tileSize(model);
  return folded;
}

/// `whose` and `result` complete the sentence.
std::string openFolds(const fs::path& file, const std::string& whose, double gap,
                      const char* result) {
  return fmt::format(
      "{}: warning: the fold angles {} would open joints by up to {:.2g} (the file's unit). {}",
      file.string(), whose, gap, result);
}

/// The axes of a tile: its first corner and first edge, longer than a millionth of the tile.
Eigen::Isometry3d axesOf(const model::Tile& tile) {
  const Vector3 z = model::tileNormal(tile);
  const Vector3 x = (tile.vertices[1] - tile.vertices[0]).normalized();
  Eigen::Isometry3d axes = Eigen::Isometry3d::Identity();
  axes.linear() << x, z.cross(x).normalized(), x.cross(z.cross(x)).normalized();
  axes.translation() = tile.vertices[0];
  return axes;
}

/// Coordinates by the drawing's own vertex numbers. Corners of tiles have their own coordinates,
/// ends of slits within a tile move with the tile, other vertices stay as drawn.
Json coordinatesOf(const std::vector<model::Tile>& tiles, const model::FoldSheet& drawing) {
  std::vector<std::optional<Vector3>> places(drawing.vertices.size());
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (std::size_t k = 0; k < tiles[i].vertices.size(); ++k) {
      std::optional<Vector3>& place = places[drawing.outlines[i][k]];
      if (!place) place = tiles[i].vertices[k];
    }
  }
  for (std::size_t face = 0; face < drawing.faces.size(); ++face) {
    const auto tile = static_cast<std::size_t>(drawing.tileOf[face]);
    for (const int vertex : drawing.faces[face]) {
      if (places[vertex]) continue;
      model::Tile drawn;
      for (const int corner : drawing.outlines[tile]) {
        drawn.vertices.push_back(drawing.vertices[corner]);
      }
      const bool isThere = drawn.vertices == tiles[tile].vertices;
      places[vertex] =
          isThere ? drawing.vertices[vertex]
                  : axesOf(tiles[tile]) * axesOf(drawn).inverse() * drawing.vertices[vertex];
    }
  }
  Json list = Json::array();
  for (std::size_t v = 0; v < places.size(); ++v) {
    const Vector3 place = places[v].value_or(drawing.vertices[v]);
    list.push_back({place.x(), place.y(), place.z()});
  }
  return list;
}

Json anglesJson(const FoldAngles& angles) {
  Json list = Json::array();
  for (const std::optional<double>& angle : angles) list.push_back(angle ? Json(*angle) : Json());
  return list;
}

// Three lists of equal length: ends, letters, angles in degrees.
void addCreases(const std::vector<model::Crease>& creases, bool letters, bool angles, Json& json) {
  Json edges = Json::array(), assignment = Json::array();
  FoldAngles degrees;
  for (const model::Crease& crease : creases) {
    edges.push_back({crease.from, crease.to});
    assignment.push_back(std::string(1, crease.assignment));
    degrees.push_back(crease.foldAngle);
  }
  json["edges_vertices"] = std::move(edges);
  if (letters) json["edges_assignment"] = std::move(assignment);
  if (angles) json[kAngles] = anglesJson(degrees);
}

/// A sheet with one vertex for all corners that have a common number. It has no edges.
model::FoldSheet sheetOf(const std::vector<model::Tile>& tiles, const CornerNumbers& numbers) {
  model::FoldSheet sheet;
  sheet.faces = sheet.outlines = numbers;
  sheet.tileOf = numbersBelow(numbers.size());
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (std::size_t k = 0; k < numbers[i].size(); ++k) {
      // Numbers rise in the order of first corners.
      if (numbers[i][k] == std::ssize(sheet.vertices)) {
        sheet.vertices.push_back(tiles[i].vertices[k]);
      }
    }
  }
  return sheet;
}

using States = std::vector<const std::vector<model::Tile>*>;

/// Decides which corners of one vertex stay together in all written states.
class Bonds {
 public:
  /// Joints keep corners together, but in a moving sheet not those on the top faces.
  Bonds(const model::Model& model, States states, bool moves)
      : states_(std::move(states)), tolerance_(kSamePlace * model::modelSize(model)) {
    for (const model::Joint& joint : model.joints) {
      if (joint.kind == model::JointKind::Fixed)
        fixed_.insert(std::minmax(joint.a.tile, joint.b.tile));
      if (joint.kind != model::JointKind::Pivot || (moves && joint.face == model::JointFace::Top))
        continue;
      joined_.insert({keyOf(joint.a), keyOf(joint.b)});
      joined_.insert({keyOf(joint.b), keyOf(joint.a)});
    }
  }

  /// The group of each corner of one vertex: the index of the first corner in it.
  std::vector<int> groupsOf(const std::vector<model::Corner>& corners) const {
    DisjointSets groups(corners.size());
    std::vector<int> first;
    for (int b = 0; b < std::ssize(corners); ++b) {
      for (int a = 0; a < b; ++a) {
        if (areOne(corners[a], corners[b])) groups.unite(a, b);
      }
    }
    for (int k = 0; k < std::ssize(corners); ++k) first.push_back(groups.lowestOf(k));
    return first;
  }

 private:
  static std::pair<int, int> keyOf(const model::Corner& corner) {
    return {corner.tile, corner.vertex};
  }

  bool areOne(const model::Corner& a, const model::Corner& b) const {
    if (fixed_.contains(std::minmax(a.tile, b.tile))) return true;
    if (joined_.contains({keyOf(a), keyOf(b)})) return true;
    return std::ranges::all_of(states_, [&](const std::vector<model::Tile>* state) {
      const Vector3& from = (*state)[a.tile].vertices[a.vertex];
      return (from - (*state)[b.tile].vertices[b.vertex]).norm() <= tolerance_;
    });
  }

  States states_;
  double tolerance_;                     // of one position, as lengths in the file
  std::set<std::pair<int, int>> fixed_;  // tiles
  std::set<std::pair<std::pair<int, int>, std::pair<int, int>>> joined_;  // corners
};

/// Gives corners that separate from the first one of their vertex new vertices at the end of the
/// list. Returns these by tile and old vertex.
std::map<std::pair<int, int>, int> splitVertices(const Bonds& bonds, model::FoldSheet& sheet) {
  std::map<int, std::vector<model::Corner>> atVertex;
  for (int tile = 0; tile < std::ssize(sheet.outlines); ++tile) {
    for (int k = 0; k < std::ssize(sheet.outlines[tile]); ++k) {
      atVertex[sheet.outlines[tile][k]].push_back({tile, k});
    }
  }
  std::map<std::pair<int, int>, int> split;
  for (const auto& [vertex, corners] : atVertex) {
    const std::vector<int> groups = bonds.groupsOf(corners);
    std::map<int, int> numbers = {{0, vertex}};
    for (std::size_t k = 1; k < corners.size(); ++k) {
      const auto [number, isNew] =
          numbers.emplace(groups[k], static_cast<int>(sheet.vertices.size()));
      if (isNew) sheet.vertices.push_back(Vector3(sheet.vertices[vertex]));
      if (number->second == vertex) continue;
      split[{corners[k].tile, vertex}] = number->second;
      sheet.outlines[corners[k].tile][corners[k].vertex] = number->second;
    }
  }
  return split;
}

/// Gives faces and edges the new vertices. An edge whose two sides have separated becomes two: the
/// second one, at the end of the list, is a cut or a boundary.
void splitEdges(const std::map<std::pair<int, int>, int>& split, model::FoldSheet& sheet) {
  std::map<std::pair<int, int>, std::vector<std::pair<int, int>>> sides;  // by old ends
  for (std::size_t face = 0; face < sheet.faces.size(); ++face) {
    const std::vector<int> old = sheet.faces[face];
    std::vector<int>& corners = sheet.faces[face];
    for (int& vertex : corners) {
      const auto found = split.find({sheet.tileOf[face], vertex});
      if (found != split.end()) vertex = found->second;
    }
    for (std::size_t k = 0; k < old.size(); ++k) {
      const std::size_t next = (k + 1) % old.size();
      const bool isForward = old[k] < old[next];
      const std::pair<int, int> own{corners[isForward ? k : next], corners[isForward ? next : k]};
      std::vector<std::pair<int, int>>& all = sides[std::minmax(old[k], old[next])];
      if (std::ranges::find(all, own) == all.end()) all.push_back(own);
    }
  }
  for (std::size_t k = 0, count = sheet.creases.size(); k < count; ++k) {
    const model::Crease old = sheet.creases[k];
    const auto found = sides.find(std::minmax(old.from, old.to));
    if (found == sides.end()) continue;
    const std::vector<std::pair<int, int>>& all = found->second;
    const std::pair<int, int> oldEnds = std::minmax(old.from, old.to);
    const auto unchanged = std::ranges::find(all, oldEnds);
    const auto first = unchanged == all.end() ? all.begin() : unchanged;
    for (auto side = all.begin(); side != all.end(); ++side) {
      if (side != first) sheet.creases.push_back({0, 0, old.assignment == 'C' ? 'C' : 'B', {}});
      model::Crease& crease = side == first ? sheet.creases[k] : sheet.creases.back();
      crease.from = old.from < old.to ? side->first : side->second;
      crease.to = old.from < old.to ? side->second : side->first;
    }
  }
}

/// The targets of a model, in turn.
States targetsOf(const model::Model& model) {
  States targets;
  for (const std::vector<model::Tile>& state : model.waypoints) targets.push_back(&state);
  if (model.target) targets.push_back(&*model.target);
  return targets;
}

/// The fold angles in a target that the file gives by angles; absent for edges of other targets.
FoldAngles targetAngles(const model::FoldSheet& sheet, std::size_t target) {
  FoldAngles angles;
  for (const model::Crease& crease : sheet.creases) {
    const bool isKnown = target < crease.targetAngles.size();
    angles.push_back(isKnown ? crease.targetAngles[target] : std::nullopt);
  }
  return angles;
}

/// Whether fold angles or letters give a target. Otherwise coordinates do.
bool isFoldedTarget(const model::FoldSheet& sheet, std::size_t target) {
  if (target == 0 && sheet.givesTarget) return true;
  return std::ranges::any_of(targetAngles(sheet, target),
                             [](const std::optional<double>& angle) { return angle.has_value(); });
}

/// The vertices, edges and faces to write for a model in the order of its file: its own if they
/// match its tiles, otherwise those of its joints. `samples`: states of a run, if any.
model::FoldSheet sheetToWrite(const model::Model& model, const std::vector<FoldState>& samples) {
  const auto isAlike = [](const std::vector<int>& outline, const model::Tile& tile) {
    return outline.size() == tile.vertices.size();
  };
  const bool moves = !samples.empty();
  const bool isKept =
      model.drawing && std::ranges::equal(model.drawing->outlines, model.tiles, isAlike);
  if (!isKept) return sheetOf(model.tiles, sharedNumbers(model, !moves));
  model::FoldSheet sheet = *model.drawing;
  States states = {&model.tiles};
  const States targets = targetsOf(model);
  for (std::size_t k = 0; k < targets.size(); ++k) {
    if (moves || !isFoldedTarget(sheet, k)) states.push_back(targets[k]);
  }
  for (std::size_t k = 1; k < samples.size(); ++k) states.push_back(&samples[k].tiles);
  const auto split = splitVertices(Bonds(model, states, moves), sheet);
  if (!split.empty()) splitEdges(split, sheet);
  return sheet;
}

/// Adds the edges of a sheet: those of its file, otherwise those of the model, see creasesOf().
void addEdges(const model::FoldSheet& sheet, const model::Model& inOrder,
              const std::optional<Vector3>& normal, Json& json) {
  if (!sheet.creases.empty()) {
    return addCreases(sheet.creases, sheet.hasLetters, sheet.hasAngles, json);
  }
  addCreases(creasesOf(sheet.outlines, inOrder, normal), true, true, json);
}

Json jointRows(const std::vector<model::Joint>& joints) {
  Json rows = Json::array();
  for (const model::Joint& joint : joints) {
    Json row = {joint.a.tile, joint.a.vertex, joint.b.tile, joint.b.vertex,
                static_cast<int>(joint.face)};
    if (joint.kind != model::JointKind::Pivot) row.push_back(static_cast<int>(joint.kind));
    rows.push_back(row);
  }
  return rows;
}

/// Rows of all joints with a neck.
Json neckRows(const std::vector<model::Joint>& joints) {
  Json rows = Json::array();
  for (std::size_t k = 0; k < joints.size(); ++k) {
    const model::Neck& neck = joints[k].neck;
    if (neck) rows.push_back({k, neck.width, neck.length, neck.kerf});
  }
  return rows;
}

/// A frame that differs from the key frame only in one key: its coordinates or its fold angles.
Json stateFrame(const std::string& title, const char* key, Json value) {
  Json frame;
  frame["frame_title"] = title;
  frame["frame_classes"] = {key == std::string_view(kPlaces) ? "foldedForm" : "creasePattern"};
  frame["frame_parent"] = 0;
  frame["frame_inherit"] = true;
  frame[key] = std::move(value);
  return frame;
}

/// Appends a target given by coordinates. `tables` receives it for checkTargets().
void addTarget(const std::vector<Vector3>& points, model::Model& model, const fs::path& file,
               std::vector<TileTable>& tables) {
  tables.push_back(tableOf(file, model.drawing->outlines, points));
  model.waypoints.push_back(tables.back().tiles);
}

/// Appends the targets of a deployment's file.
void addOwnTargets(const FoldReader& reader, const TileTable& start, model::Model& model,
                   std::vector<std::string>& warnings) {
  std::vector<TileTable> tables;
  for (const Json& target : *reader.ownTargets()) {
    const std::vector<Vector3> points = reader.points(target);
    if (points.size() != model.drawing->vertices.size()) {
      throw reader.fault(
          fmt::format("{} has {} vertices, vertices_coords has {}; correct or delete it", kTargets,
                      points.size(), model.drawing->vertices.size()));
    }
    addTarget(points, model, start.file, tables);
  }
  checkTargets(tables, model, start, warnings);
}

/// Appends the states after the first. `states` have coordinates; `angles` are the creases of those
/// without, in the order of their frames. The angles of the start then give the first target,
/// unless they are 0.
void addStates(const FoldReader& reader, const std::vector<std::vector<Vector3>>& states,
               const std::vector<std::vector<model::Crease>>& angles, const TileTable& start,
               const std::optional<Vector3>& normal, model::Model& model,
               std::vector<std::string>& warnings) {
  model::FoldSheet& drawing = *model.drawing;
  if (!angles.empty() && !normal) {
    warnings.push_back(
        fmt::format("{}: warning: {} not read, because fold angles need a flat start",
                    start.file.string(), counted(angles.size(), "frame is", "frames are")));
  }
  std::vector<int> open;  // frames
  double widest = 0;
  const auto fold = [&](const std::vector<model::Crease>& creases, int frame) {
    if (!normal) return false;
    FoldedSheet folded = foldAlong(creases, model, *normal);
    if (folded.isOpen) {
      open.push_back(frame);
      widest = std::max(widest, folded.gap);
    } else {
      model.waypoints.push_back(std::move(folded.tiles));
    }
    return !folded.isOpen;
  };
  std::vector<TileTable> tables;
  const std::vector<int>& frames = reader.stateFrames();
  if (!angles.empty() && std::ranges::any_of(drawing.creases, folds)) {
    drawing.givesTarget = fold(drawing.creases, frames.front());
  }
  auto nextState = states.begin() + 1;
  auto nextAngles = angles.begin();
  for (std::size_t k = 1; k < frames.size(); ++k) {
    if (reader.hasOwnPlaces(frames[k])) {
      addTarget(*nextState++, model, start.file, tables);
    } else if (const std::vector<model::Crease>& creases = *nextAngles++;
               fold(creases, frames[k])) {
      for (std::size_t edge = 0; edge < creases.size(); ++edge) {
        drawing.creases[edge].targetAngles.resize(model.waypoints.size());
        drawing.creases[edge].targetAngles.back() = creases[edge].foldAngle;
      }
    }
  }
  checkTargets(tables, model, start, warnings);
  // With coordinates in all frames, angles of the first one are those of the last.
  if (angles.empty() && normal && !model.waypoints.empty()) {
    takeAnglesOfTarget(drawing.outlines, model.waypoints.back(), drawing.creases);
    drawing.hasAngles |= std::ranges::any_of(
        drawing.creases, [](const model::Crease& crease) { return crease.foldAngle.has_value(); });
  }
  if (open.size() == 1) {
    warnings.push_back(openFolds(start.file, fmt::format("of frame {}", open[0]), widest,
                                 "This frame is not read"));
  } else if (!open.empty()) {
    warnings.push_back(openFolds(start.file,
                                 fmt::format("of {} frames (first: {})", open.size(), open[0]),
                                 widest, "These frames are not read"));
  }
}

/// Whether an edge is neither flat nor folded by 180 degrees.
bool isPartlyFolded(const model::Crease& crease) {
  return folds(crease) && std::abs(*crease.foldAngle) < 180 - kFlatEdge;
}

/// The normal of a crease pattern; absent for a folded sheet.
std::optional<Vector3> patternNormal(const model::Model& model) {
  if (model.drawing && model.drawing->isFolded) return std::nullopt;
  return sheetNormal(model);
}

/// Takes a flat foldedForm whose angles are not those of a flat sheet as a crease pattern.
void refuteFoldedForm(const fs::path& file, model::Model& model,
                      std::vector<std::string>& warnings) {
  model::FoldSheet& drawing = *model.drawing;
  if (!drawing.isFolded || std::ranges::none_of(drawing.creases, isPartlyFolded)) return;
  if (!sheetNormal(model)) return;
  warnings.push_back(
      fmt::format("{}: warning: the frame is a foldedForm, but flat and with fold "
                  "angles; it is read as a creasePattern",
                  file.string()));
  drawing.isFolded = false;
}

/// Makes the last state the target, or folds a flat sheet in one state. Returns the creases with
/// the rest angles of springs.
std::vector<model::Crease> setTarget(const FoldReader& reader, const ReadSettings& settings,
                                     const std::optional<Vector3>& normal, const fs::path& file,
                                     model::Model& model, std::vector<std::string>& warnings) {
  model::FoldSheet& drawing = *model.drawing;
  std::vector<model::Crease> creases = drawing.creases;
  const bool isOwn = reader.ownTargets() != nullptr;
  if (model.waypoints.empty() && !isOwn && normal) {
    foldByLetters(settings, drawing, creases, file, warnings);
    if (std::ranges::any_of(creases, folds)) {
      FoldedSheet folded = foldAlong(creases, model, *normal);
      if (folded.isOpen) {
        warnings.push_back(
            openFolds(file, "in the file", folded.gap,
                      "So the model has no target, and springs at folds rest at these angles"));
      } else if (!std::ranges::equal(folded.tiles, model.tiles, {}, &model::Tile::vertices,
                                     &model::Tile::vertices)) {
        // Otherwise folds are only at edges without two faces.
        model.target = std::move(folded.tiles);
      }
    }
    drawing.givesTarget = model.target.has_value();
    return creases;
  }
  if (settings.fold) {
    throw inputErrorAt({file},
                       "`fold` folds a flat sheet by its letters, but the file has a target "
                       "or a folded start; remove `fold`, or choose a flat frame by `frame`");
  }
  if (model.waypoints.empty()) return creases;
  model.target = std::move(model.waypoints.back());
  model.waypoints.pop_back();
  if (normal && !isOwn) takeAnglesOfTarget(drawing.outlines, *model.target, creases);
  return creases;
}

}  // namespace

model::Model readFold(const fs::path& file, const ReadSettings& settings,
                      std::vector<std::string>& warnings) {
  const FoldReader reader(file, settings);
  const std::vector<std::vector<Vector3>> states = reader.states();
  const auto sheetIn = [&](int frame) {
    model::FoldSheet sheet = reader.drawing(states.front(), frame);
    if (reader.ownJoints() == nullptr) mergeRepeatedVertices(states, file, sheet);
    return sheet;
  };
  model::Model model;
  model.name = file.stem().string();
  model.declaredUnit = reader.unit();
  model::FoldSheet& drawing = model.drawing.emplace(sheetIn(reader.stateFrames().front()));
  std::vector<std::vector<model::Crease>> angles;
  for (const int frame : reader.stateFrames()) {
    if (!reader.hasOwnPlaces(frame)) angles.push_back(sheetIn(frame).creases);
  }
  findTiles(reader, states, drawing);
  reader.warnOfIgnored(settings, warnings);
  warnOfEdges(drawing, file, warnings);
  const CornerNumbers& outlines = drawing.outlines;
  const TileTable start = tableOf(file, outlines, states.front());
  checkTiles(start);
  model.tiles = start.tiles;
  model.joints = reader.ownJoints() != nullptr
                     ? readOwnJoints(reader, start, model, warnings)
                     : jointsOfCreases(outlines, drawing.creases, start.tiles);
  refuteFoldedForm(file, model, warnings);
  const std::optional<Vector3> normal = patternNormal(model);
  if (reader.ownTargets() != nullptr) {
    addOwnTargets(reader, start, model, warnings);
  } else {
    addStates(reader, states, angles, start, normal, model, warnings);
  }
  const std::vector<model::Crease> creases =
      setTarget(reader, settings, normal, file, model, warnings);
  model.pulledTiles = reader.pulledTiles(model.tiles.size());
  // Faces of a folded sheet may be turned over.
  if (!drawing.isFolded) turnClockwiseTiles(start, model, warnings);
  model.foldAngles = foldAnglesOf(outlines, creases, model, normal, file);
  return model;
}

std::string foldText(const model::Model& inOrder, const std::vector<FoldState>& samples) {
  const model::Model model = model::inFileOrder(inOrder);
  const model::FoldSheet sheet = sheetToWrite(model, samples);
  // Edges of a flat start, a crease pattern, have the angles of the target. Otherwise they have
  // those of the start.
  const std::optional<Vector3> normal = patternNormal(model);
  Json frames = Json::array(), targets = Json::array();
  for (std::size_t k = 1; k < samples.size(); ++k) {
    frames.push_back(stateFrame(samples[k].title, kPlaces, coordinatesOf(samples[k].tiles, sheet)));
  }
  const States states = targetsOf(model);
  for (std::size_t k = 0; k < states.size(); ++k) {
    const char* title = k < model.waypoints.size() ? "target before the last" : "target";
    if (!samples.empty()) {
      targets.push_back(coordinatesOf(*states[k], sheet));
    } else if (!isFoldedTarget(sheet, k)) {
      frames.push_back(stateFrame(title, kPlaces, coordinatesOf(*states[k], sheet)));
    } else if (k > 0 || !sheet.givesTarget) {
      frames.push_back(stateFrame(title, kAngles, anglesJson(targetAngles(sheet, k))));
    }
  }
  Json json;
  json["file_spec"] = 1.2;
  json["file_creator"] = "Kirireel";
  json["file_classes"] = {frames.empty() ? "singleModel" : "animation"};
  json["frame_title"] = samples.empty() ? "start" : samples.front().title;
  for (const auto& [key, text] : sheet.texts) json[key] = text;
  json["frame_classes"] = {normal ? "creasePattern" : "foldedForm"};
  // A FOLD file without a unit gets none. The states of a run always have one.
  const bool hasUnit = !samples.empty() || !model.drawing || model.declaredUnit ||
                       model.unit.name != LengthUnit{}.name;
  if (hasUnit) json["frame_unit"] = model.unit.name;
  json[kPlaces] = coordinatesOf(model.tiles, sheet);
  json["faces_vertices"] = sheet.faces;
  addEdges(sheet, inOrder, normal, json);
  if (!samples.empty()) json[kTargets] = std::move(targets);
  if (!frames.empty()) json["file_frames"] = std::move(frames);
  json[kJoints] = jointRows(model.joints);
  if (Json necks = neckRows(model.joints); !necks.empty()) json[kNecks] = std::move(necks);
  if (model.pulledTiles) json[kPulled] = *model.pulledTiles;
  return jsonText(json) + "\n";
}

void writeFold(const model::Model& model, const fs::path& file) {
  writeTextFile(file, foldText(model));
}

// ------------------------------------------------------------------------------------------------
// Converts edges to joints, and joints to edges.
//
// 1. *Joints.* All corners at one vertex are joined, unless a cut edge ends there. In that
//    case the corners are divided into groups with common uncut edges at the vertex. Two
//    faces with a common uncut edge are in the same group. Each group is a chain of
//    joints.
// 2. *Folding.* An isometry T of the flat sheet places a face. Across an edge with the fold angle a
//    (radians) it places the neighbour by
//      T' = T P R(-a, e) P^-1
//    P moves the origin to a point of the edge. R(-a, e) turns by -a about the edge's direction e,
//    with the first face on its left seen from the upper side of the sheet. A positive angle
//    therefore lifts the neighbour, on the right of e, to the upper side: a valley. Folding starts
//    at one face of each piece and proceeds outwards. Loops of edges are not checked here.
//    Inconsistent angles leave open joints at the last edge of a loop, and the caller measures
//    these.
// 3. *Angles* of a folded state: a = -atan2((n x n') . e, n . n'), with the unit normals n and
//    n' of both faces. atan2 is accurate near 0 and near 180 degrees, unlike an arc cosine, which
//    loses half of the digits.
//
// Source: E. D. Demaine, J. S. Ku, R. J. Lang, A new file standard to represent folded structures,
// Fall Workshop on Computational Geometry, 2016.

namespace {

using Ends = std::pair<int, int>;  // vertex numbers, the smaller first

/// A side of a face: from corner k to the next.
struct FaceSide {
  int face = 0;
  int corner = 0;
};

// A std::map orders the edges by their vertex numbers. Results then do not depend on addresses or
// hashes.
std::map<Ends, std::vector<FaceSide>> sidesByEnds(const CornerNumbers& faces) {
  std::map<Ends, std::vector<FaceSide>> sides;
  for (int face = 0; face < std::ssize(faces); ++face) {
    const int count = static_cast<int>(faces[face].size());
    for (int k = 0; k < count; ++k) {
      sides[std::minmax(faces[face][k], faces[face][(k + 1) % count])].push_back({face, k});
    }
  }
  return sides;
}

const Vector3& startOf(const std::vector<model::Tile>& tiles, const FaceSide& side) {
  return tiles[side.face].vertices[side.corner];
}

const Vector3& endOf(const std::vector<model::Tile>& tiles, const FaceSide& side) {
  const std::vector<Vector3>& vertices = tiles[side.face].vertices;
  return vertices[(side.corner + 1) % vertices.size()];
}

/// Pairs of faces that uncut edges connect.
struct HeldFaces {
  std::map<int, FacePairs> atVertex;    ///< hinged faces at a vertex, by an edge that ends there
  std::set<std::pair<int, int>> fixed;  ///< parts of one rigid piece, the smaller number first
};

// Visits all uncut edges of two or more faces.
HeldFaces heldFaces(const CornerNumbers& faces, const std::map<Ends, char>& assignments) {
  HeldFaces held;
  for (const auto& [ends, sides] : sidesByEnds(faces)) {
    const auto found = assignments.find(ends);
    const char assignment = found == assignments.end() ? 'U' : found->second;
    // An edge of three or more faces connects each face with the next.
    for (std::size_t k = 1; k < sides.size() && assignment != 'C'; ++k) {
      const std::pair<int, int> two = std::minmax(sides[k - 1].face, sides[k].face);
      held.atVertex[ends.first].push_back(two);
      held.atVertex[ends.second].push_back(two);
      if (assignment == 'J' && two.first != two.second) held.fixed.insert(two);
    }
  }
  return held;
}

// Corners of the faces at each vertex, by ascending face.
std::map<int, std::vector<model::Corner>> cornersByVertex(const CornerNumbers& faces) {
  std::map<int, std::vector<model::Corner>> corners;
  for (int face = 0; face < std::ssize(faces); ++face) {
    for (int k = 0; k < std::ssize(faces[face]); ++k) corners[faces[face][k]].push_back({face, k});
  }
  return corners;
}

/// Groups of corners at one vertex that its uncut edges connect.
std::vector<std::vector<model::Corner>> groupsAt(const std::vector<model::Corner>& corners,
                                                 const FacePairs& held) {
  std::vector<std::size_t> group(corners.size());
  std::iota(group.begin(), group.end(), 0);
  const auto placeOf = [&](int face) {
    return static_cast<std::size_t>(
        std::find_if(corners.begin(), corners.end(),
                     [face](const model::Corner& corner) { return corner.tile == face; }) -
        corners.begin());
  };
  for (const auto& [a, b] : held) {
    const std::size_t kept = group[placeOf(a)], lost = group[placeOf(b)];
    // A vertex has few corners, so renaming a group is cheaper than a tree of sets.
    std::replace(group.begin(), group.end(), lost, kept);
  }
  std::map<std::size_t, std::vector<model::Corner>> groups;
  for (std::size_t k = 0; k < corners.size(); ++k) groups[group[k]].push_back(corners[k]);
  std::vector<std::vector<model::Corner>> result;
  for (auto& [number, members] : groups) result.push_back(std::move(members));
  return result;
}

}  // namespace

std::vector<model::Joint> jointsOfCreases(const CornerNumbers& faces,
                                          const std::vector<model::Crease>& creases,
                                          const std::vector<model::Tile>& tiles) {
  std::map<Ends, char> assignments;
  std::set<int> cutAt;  // vertices
  for (const model::Crease& crease : creases) {
    assignments[std::minmax(crease.from, crease.to)] = crease.assignment;
    if (crease.assignment == 'C') cutAt.insert({crease.from, crease.to});
  }
  const HeldFaces held = heldFaces(faces, assignments);
  std::vector<model::Joint> joints;
  for (const auto& [vertex, corners] : cornersByVertex(faces)) {
    const auto pairs = held.atVertex.find(vertex);
    const bool isCut = cutAt.contains(vertex);
    const auto groups =
        !isCut ? std::vector<std::vector<model::Corner>>{corners}
               : groupsAt(corners, pairs == held.atVertex.end() ? FacePairs{} : pairs->second);
    for (const std::vector<model::Corner>& group : groups) {
      for (std::size_t k = 1; k < group.size(); ++k) {
        const std::pair<int, int> two = std::minmax(group[k - 1].tile, group[k].tile);
        // A joint within one tile has no effect, and one within a rigid piece is redundant to the
        // fixed joint.
        if (two.first == two.second || held.fixed.contains(two)) continue;
        joints.push_back({group[k - 1], group[k], model::JointFace::Bottom});
      }
    }
  }
  for (const auto& [a, b] : held.fixed) joints.push_back(model::makeFixedJoint(tiles, a, b));
  return joints;
}

std::optional<Vector3> sheetNormal(const model::Model& model) {
  const std::vector<model::Tile>& tiles = model.tiles;
  const double flat = model::flatTolerance(model);
  const Vector3 origin = tiles.front().vertices.front();
  const bool isLevel = model::liesFlat(tiles, flat);
  Vector3 normal =
      model::meanNormal(tiles, isLevel ? Vector3::UnitZ() : model::tileNormal(tiles.front()));
  // Keeps all digits of a level sheet.
  if (isLevel) normal = Vector3(0, 0, normal.z() < 0 ? -1 : 1);
  // The coordinates are rounded, and so is the normal computed from them.
  const double tolerance = std::max(flat, 2 * roundingOf(tiles));
  for (const model::Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) {
      if (std::abs(normal.dot(vertex - origin)) > (isLevel ? 2 * flat : tolerance)) return {};
    }
  }
  return normal;
}

// Depth-first search from the lowest face of each piece. The first edge that reaches a face places
// it.
std::optional<std::vector<model::Tile>> foldedTiles(const CornerNumbers& faces,
                                                    const std::vector<model::Crease>& creases,
                                                    const std::vector<model::Tile>& tiles,
                                                    const Vector3& normal) {
  if (std::ranges::none_of(creases, folds)) return std::nullopt;
  std::map<Ends, double> angles;
  for (const model::Crease& crease : creases) {
    if (crease.assignment == 'C' || crease.assignment == 'B') continue;
    angles[std::minmax(crease.from, crease.to)] = crease.foldAngle.value_or(0);
  }
  const auto sides = sidesByEnds(faces);
  std::vector<std::optional<Eigen::Isometry3d>> placed(faces.size());
  for (std::size_t root = 0; root < faces.size(); ++root) {
    if (placed[root]) continue;
    placed[root] = Eigen::Isometry3d::Identity();
    std::vector<int> waiting = {static_cast<int>(root)};
    while (!waiting.empty()) {
      const int face = waiting.back();
      waiting.pop_back();
      const int count = static_cast<int>(faces[face].size());
      for (int k = 0; k < count; ++k) {
        const Ends ends = std::minmax(faces[face][k], faces[face][(k + 1) % count]);
        const auto angle = angles.find(ends);
        if (angle == angles.end()) continue;
        for (const FaceSide& other : sides.at(ends)) {
          // Only the first path to a face places it.
          if (placed[other.face]) continue;
          const FaceSide own{face, k};
          // Along the edge with this face on the left, seen from the upper side.
          const double sense = model::tileNormal(tiles[face]).dot(normal) > 0 ? 1 : -1;
          const Vector3 along = sense * (endOf(tiles, own) - startOf(tiles, own)).normalized();
          const Vector3& hinge = startOf(tiles, own);
          Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
          turn.translate(hinge);
          turn.rotate(Eigen::AngleAxisd(-angle->second * kDegree, along));
          turn.translate(-hinge);
          placed[other.face] = *placed[face] * turn;
          waiting.push_back(other.face);
        }
      }
    }
  }
  std::vector<model::Tile> folded = tiles;
  for (std::size_t face = 0; face < faces.size(); ++face) {
    for (Vector3& vertex : folded[face].vertices) vertex = *placed[face] * vertex;
  }
  return folded;
}

namespace {

/// 1 if a file's angle counts from the upper side of a tile in the model, else -1.
double fileSign(const model::Model& model, const std::optional<Vector3>& normal, int tile) {
  if (normal) return model::tileNormal(model.tiles[tile]).dot(*normal) < 0 ? -1 : 1;
  const std::vector<bool>& isReversed = model.fileOrder.isReversed;
  return !isReversed.empty() && isReversed[tile] ? -1 : 1;
}

void foldBy(double degrees, model::Crease& crease) {
  crease.foldAngle = std::abs(degrees) > kFlatEdge ? degrees : 0;
  crease.assignment = *crease.foldAngle > 0 ? 'V' : *crease.foldAngle < 0 ? 'M' : 'F';
}

}  // namespace

std::map<std::pair<int, int>, double> foldAnglesOf(const CornerNumbers& faces,
                                                   const std::vector<model::Crease>& creases,
                                                   const model::Model& model,
                                                   const std::optional<Vector3>& normal,
                                                   const fs::path& file) {
  const auto sides = sidesByEnds(faces);
  std::map<std::pair<int, int>, double> angles;
  for (const model::Crease& crease : creases) {
    const auto both = sides.find(std::minmax(crease.from, crease.to));
    const bool folds = std::string_view("BCJ").find(crease.assignment) == std::string_view::npos;
    if (!crease.foldAngle || !folds || both == sides.end() || both->second.size() != 2) continue;
    const FaceSide &first = both->second[0], &second = both->second[1];
    if (first.face == second.face) continue;
    const double inFile = *crease.foldAngle * kDegree;
    const double angle = fileSign(model, normal, first.face) * inFile;
    const auto [known, isNew] = angles.try_emplace({first.face, second.face}, angle);
    if (!isNew && std::abs(known->second - angle) > kFlatEdge * kDegree) {
      throw inputErrorAt(
          {file},
          fmt::format("two edges of the tiles {} and {} fold by {:g} and {:g} degrees, but "
                      "two tiles have one angle. Correct the angle or the letter of one edge",
                      first.face, second.face, known->second / kDegree, angle / kDegree));
    }
    // Faces with the same orientation traverse their common edge in opposite directions.
    const bool isAlike =
        normal || faces[first.face][first.corner] != faces[second.face][second.corner];
    angles.try_emplace({second.face, first.face},
                       fileSign(model, normal, second.face) * (isAlike ? inFile : -inFile));
  }
  return angles;
}

std::vector<model::Crease> creasesOf(const CornerNumbers& faces,
                                     const std::vector<model::Tile>& state) {
  std::vector<model::Crease> creases;
  for (const auto& [ends, both] : sidesByEnds(faces)) {
    model::Crease& crease = creases.emplace_back(model::Crease{ends.first, ends.second, 'B', {}});
    // A boundary edge has no angle.
    if (both.size() == 1) continue;
    const FaceSide &first = both[0], &second = both[1];
    const Vector3 along = (endOf(state, first) - startOf(state, first)).normalized();
    const Vector3 normal = model::tileNormal(state[first.face]);
    // Faces with the same orientation traverse their common edge in opposite directions.
    const bool isAlike = faces[first.face][first.corner] != faces[second.face][second.corner];
    const Vector3 other = (isAlike ? 1 : -1) * model::tileNormal(state[second.face]);
    const double angle = -std::atan2(normal.cross(other).dot(along), normal.dot(other)) / kDegree;
    foldBy(angle, crease);
  }
  return creases;
}

// Edges have the order of sidesByEnds(). Reversed tiles have the angles of the sheet in its current
// orientation.
std::vector<model::Crease> creasesOf(const CornerNumbers& faces, const model::Model& inOrder,
                                     const std::optional<Vector3>& normal) {
  const model::Model model = model::inFileOrder(inOrder);
  std::vector<model::Crease> creases =
      creasesOf(faces, model.target && normal ? *model.target : model.tiles);
  auto crease = creases.begin();
  for (const auto& [ends, both] : sidesByEnds(faces)) {
    model::Crease& own = *crease++;
    if (both.size() != 2) continue;
    const auto found = inOrder.foldAngles.find({both[0].face, both[1].face});
    if (found != inOrder.foldAngles.end()) {
      foldBy(fileSign(inOrder, normal, both[0].face) * found->second / kDegree, own);
    } else {
      foldBy(fileSign(model, normal, both[0].face) * *own.foldAngle, own);
    }
  }
  return creases;
}

}  // namespace kirireel::formats
