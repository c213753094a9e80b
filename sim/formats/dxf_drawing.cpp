// DXF files as lines (Autodesk, DXF Reference, R12 to 2018): pairs of lines with a group code and a
// value. Code 0 begins an entity. The reader draws the entities of the section ENTITIES, and a
// block for each INSERT of it. A bulge is the tangent of a quarter of an arc's angle.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/length_unit.h"
#include "sim/formats/drawing.h"

namespace kirireel::formats {
namespace {

namespace fs = std::filesystem;

constexpr double kFullCircle = 2 * std::numbers::pi;
constexpr int kDeepestBlock = 20;

struct DxfGroup {
  int code = 0;
  std::string_view value;
  int line = 0;  ///< of the value
};

struct DxfEntity {
  std::string type;
  int line = 0;  ///< of its type
  std::vector<DxfGroup> groups;

  const DxfGroup* group(int code) const {
    const auto found = std::ranges::find(groups, code, &DxfGroup::code);
    return found == groups.end() ? nullptr : &*found;
  }
  std::optional<std::string_view> text(int code) const {
    const DxfGroup* found = group(code);
    return found ? std::optional(found->value) : std::nullopt;
  }
};

struct DxfLayer {
  int colour = 7;
  bool isDashed = false;
  bool isOff = false;
};

/// Properties that a block's entities inherit from its INSERT.
struct DxfContext {
  Eigen::Affine2d transform = Eigen::Affine2d::Identity();
  std::string layer = "0";
  std::string colour = "#000000";
  int depth = 0;
};

class DxfReader {
 public:
  DxfReader(const fs::path& file, double flattening) : file_(file), flattening_(flattening) {}

  Drawing read(const std::string& text) {
    if (text.starts_with("AutoCAD Binary DXF")) {
      throw inputErrorAt({file_}, "this is a binary DXF file; save it as ASCII DXF");
    }
    parse(text);
    readHeader();
    DxfContext context;
    context.transform.scale(drawing_.unit);
    addEntities(entities_, context);
    drawing_.rounding = decimals_.lastPlace() * drawing_.unit;
    return std::move(drawing_);
  }

 private:
  /// The line at `at` without surrounding blanks; absent at the end. Moves `at` to the next line.
  static std::optional<std::string_view> takeLine(std::string_view text, std::size_t& at) {
    if (at >= text.size()) return std::nullopt;
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line = text.substr(at, end - at);
    at = end + 1;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
    while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
    return line;
  }

  void parse(std::string_view text) {
    std::size_t at = 0;
    const auto nextLine = [&] { return takeLine(text, at); };
    std::string section, block;
    std::optional<bool> hasSections;
    DxfEntity current;
    const auto finish = [&] {
      if (current.type == "SECTION")
        section = current.text(2).value_or("");
      else if (current.type == "ENDSEC")
        section.clear();
      else if (current.type == "LAYER" && section == "TABLES")
        addLayer(current);
      else if (current.type == "BLOCK")
        block = lowerCase(current.text(2).value_or(""));
      else if (current.type == "ENDBLK")
        block.clear();
      else if (section == "BLOCKS" && !block.empty())
        blocks_[block].push_back(current);
      // Minimal files have entities without a section.
      else if (section == "ENTITIES" || (section.empty() && !*hasSections))
        entities_.push_back(current);
      if (current.type == "BLOCK") blocks_[block].push_back(current);  // its base point
    };
    std::string variable;
    int line = 0;
    while (const std::optional<std::string_view> code = nextLine()) {
      line += 2;
      const std::optional<std::string_view> value = nextLine();
      int number = -1;
      const auto [end, error] = std::from_chars(code->data(), code->data() + code->size(), number);
      if (code->empty() && !value) break;    // an empty line at the end
      if (code->starts_with('\x1a')) break;  // the end of a file of DOS
      if (!value || error != std::errc() || end != code->data() + code->size()) {
        throw inputErrorAt({file_, line - 1},
                           fmt::format("'{}' is not a group code with a value after it. Save the "
                                       "drawing as ASCII DXF",
                                       shown(*code, 24)));
      }
      if (number == 0) {
        if (hasSections)
          finish();
        else
          hasSections = *value == "SECTION";
        current = {std::string(*value), line, {}};
        continue;
      }
      if (number == 9)
        variable = *value;
      else if (section.empty() && current.type == "SECTION" && current.text(2) == "HEADER")
        header_.try_emplace(variable, DxfGroup{number, *value, line});
      current.groups.push_back({number, *value, line});
    }
    if (hasSections) finish();
  }

  void addLayer(const DxfEntity& entity) {
    DxfLayer& layer = layers_[lowerCase(entity.text(2).value_or("0"))];
    const int colour = whole(entity, 62, 7);
    layer.colour = std::abs(colour);
    layer.isOff = colour < 0 || (whole(entity, 70, 0) & 1) != 0;
    layer.isDashed = isDashType(entity.text(6).value_or("continuous"));
  }

  static bool isDashType(std::string_view type) {
    const std::string name = lowerCase(type);
    return !name.empty() && name != "continuous" && name != "bylayer" && name != "byblock";
  }

  double value(const DxfGroup& group) const {
    return drawnNumber(group.value, {file_, group.line});
  }
  /// The value of a coordinate. Its decimals show the rounding of the drawing.
  double coordinate(const DxfGroup& group) {
    return drawnNumber(group.value, {file_, group.line}, &decimals_);
  }
  double number(const DxfEntity& entity, int code, std::optional<double> otherwise = {}) {
    if (const DxfGroup* group = entity.group(code)) return coordinate(*group);
    if (otherwise) return *otherwise;
    const bool isEnd = entity.type == "LINE";
    throw inputErrorAt({file_, entity.line},
                       fmt::format("a {} lacks {} (group {}); save the drawing again",
                                   shown(entity.type, 24), isEnd ? "an end" : "a number", code));
  }
  int whole(const DxfEntity& entity, int code, int otherwise) {
    const DxfGroup* group = entity.group(code);
    return group ? static_cast<int>(std::clamp(value(*group), -1e9, 1e9)) : otherwise;
  }
  Vector2 point(const DxfEntity& entity, int code) {
    const double x = number(entity, code);
    return {x, number(entity, code + 10)};
  }

  void readHeader() {
    // Units that only drawings have. The others are in lengthUnits().
    static const std::vector<LengthUnit> kOthers = {{"mile", 1609.344, 3},
                                                    {"uin", 2.54e-8, 8},
                                                    {"mil", 2.54e-5, 9},
                                                    {"yd", 0.9144, 10},
                                                    {"angstrom", 1e-10, 11},
                                                    {"dm", 0.1, 14},
                                                    {"dam", 10, 15},
                                                    {"hm", 100, 16},
                                                    {"US survey ft", 1200.0 / 3937, 21},
                                                    {"US survey in", 100.0 / 3937, 22},
                                                    {"US survey yd", 3600.0 / 3937, 23},
                                                    {"US survey mile", 5280 * 1200.0 / 3937, 24}};
    int unit = 0;
    if (const auto given = header_.find("$INSUNITS"); given != header_.end()) {
      unit = static_cast<int>(std::clamp(value(given->second), 0.0, 99.0));
    }
    drawing_.unit = 1e-3;
    drawing_.unitName = "units";
    for (const std::vector<LengthUnit>* units : {&lengthUnits(), &kOthers}) {
      const auto known = std::ranges::find(*units, unit, &LengthUnit::dxfNumber);
      if (unit == 0 || known == units->end()) continue;
      drawing_.unit = known->metres;
      drawing_.unitName = known->name;
      drawing_.hasUnit = true;
    }
    if (unit != 0 && !drawing_.hasUnit) {
      ++drawing_
            .ignored[fmt::format("$INSUNITS {}, which is not supported (`unit` decides)", unit)];
    }
  }

  void addEntities(const std::vector<DxfEntity>& entities, const DxfContext& context) {
    for (std::size_t k = 0; k < entities.size(); ++k) {
      const DxfEntity& entity = entities[k];
      const std::string& type = entity.type;
      static const std::vector<std::string> kSilent = {
          "", "SECTION", "ENDSEC", "EOF", "SEQEND", "BLOCK", "ATTRIB", "VIEWPORT", "VERTEX"};
      if (std::ranges::find(kSilent, type) != kSilent.end()) continue;
      if (whole(entity, 67, 0) == 1) {
        ++drawing_.ignored["entity of a paper layout"];
        continue;
      }
      DrawnPath path = pathOf(entity, context);
      const auto layer = layers_.find(path.layer);
      if (whole(entity, 60, 0) == 1 || (layer != layers_.end() && layer->second.isOff)) {
        ++drawing_.ignored["line on a layer that is off"];
        continue;
      }
      Eigen::Affine2d transform = context.transform;
      // Arcs and polylines seen from below are mirrored.
      if (type != "LINE" && type != "ELLIPSE" && type != "SPLINE" && number(entity, 230, 1.0) < 0) {
        transform = transform * Eigen::Scaling(-1.0, 1.0);
      }
      if (type == "INSERT") {
        insert(entity, transform, path, context.depth);
        continue;
      }
      scale_ = std::sqrt(std::abs(transform.linear().determinant()));
      std::size_t vertices = k + 1;
      if (type == "POLYLINE") {
        while (vertices < entities.size() && entities[vertices].type == "VERTEX") ++vertices;
      }
      if (!addPoints(entity, entities, k + 1, vertices, path)) {
        ++drawing_.ignored[lowerCase(shown(type, 24))];
        continue;
      }
      if (!isLevel(entity, entities, k + 1, vertices, path)) {
        ++drawing_.ignored
              ["line that leaves the xy plane, which is not cut: turn the sheet into that plane"];
        continue;
      }
      for (Vector2& at : path.points) at = transform * at;
      addPath(drawing_, std::move(path), file_);
    }
  }

  /// Whether an entity with these points lies in a plane z = constant.
  bool isLevel(const DxfEntity& entity, const std::vector<DxfEntity>& all, std::size_t first,
               std::size_t last, const DrawnPath& path) const {
    constexpr double kSlope = 1e-3;
    const std::string& type = entity.type;
    std::vector<double> heights;
    const auto addHeights = [&](const DxfEntity& one) {
      for (const DxfGroup& group : one.groups) {
        if (group.code == 30 || group.code == 31) heights.push_back(value(group));
      }
    };
    if (type == "LINE" || type == "SPLINE") {
      addHeights(entity);
    } else if (const DxfGroup* normal = entity.group(230)) {
      if (std::abs(value(*normal)) < 1 - kSlope * kSlope) return false;
    }
    for (std::size_t k = first; k < last; ++k) addHeights(all[k]);
    const auto [low, high] = std::ranges::minmax(heights.empty() ? std::vector{0.0} : heights);
    return high - low <= kSlope * boundingBox(path.points).diagonal().norm();
  }

  /// The colours 1 to 7 of AutoCAD's table. Other colours are named by their number.
  static std::string colourOf(int index) {
    static const std::array<const char*, 7> kFirst = {"#ff0000", "#ffff00", "#00ff00", "#00ffff",
                                                      "#0000ff", "#ff00ff", "#000000"};
    return index >= 1 && index <= 7 ? kFirst[index - 1] : fmt::format("{}", index);
  }

  DrawnPath pathOf(const DxfEntity& entity, const DxfContext& context) {
    DrawnPath path;
    path.layer = lowerCase(entity.text(8).value_or("0"));
    if (path.layer == "0") path.layer = context.layer;
    path.names = {path.layer};
    const auto layer = layers_.find(path.layer);
    const int colour = whole(entity, 62, 256);
    path.colour =
        entity.text(420)
            ? fmt::format("#{:06x}", static_cast<unsigned>(whole(entity, 420, 0)) & 0xffffffU)
        : colour == 256 ? colourOf(layer == layers_.end() ? 7 : layer->second.colour)
        : colour == 0   ? context.colour
                        : colourOf(colour);
    const std::string_view dashes = entity.text(6).value_or("bylayer");
    path.isDashed = isDashType(dashes) || (lowerCase(dashes) == "bylayer" &&
                                           layer != layers_.end() && layer->second.isDashed);
    return path;
  }

  void insert(const DxfEntity& entity, const Eigen::Affine2d& outer, const DrawnPath& path,
              int depth) {
    const std::string name = lowerCase(entity.text(2).value_or(""));
    const auto block = blocks_.find(name);
    if (block == blocks_.end() || depth >= kDeepestBlock) {
      throw inputErrorAt(
          {file_, entity.line},
          fmt::format("an INSERT names the block '{}', which {}. Explode it in the CAD program, "
                      "or delete it",
                      shown(name, 24),
                      block == blocks_.end()
                          ? "does not exist in this file"
                          : fmt::format("is more than {} blocks deep, or contains "
                                        "itself",
                                        kDeepestBlock)));
    }
    const int columns = std::clamp(whole(entity, 70, 1), 1, 1000);
    const int rows = std::clamp(whole(entity, 71, 1), 1, 1000);
    Vector2 base(0, 0);
    for (const DxfEntity& one : block->second) {
      if (one.type == "BLOCK") base = {number(one, 10, 0.0), number(one, 20, 0.0)};
    }
    for (int k = 0; k < rows * columns; ++k) {
      DxfContext inner;
      const Vector2 step((k % columns) * number(entity, 44, 0.0),
                         static_cast<double>(k / columns) * number(entity, 45, 0.0));
      inner.transform = outer;
      inner.transform.translate(point(entity, 10))
          .rotate(number(entity, 50, 0.0) * kDegree)
          .translate(step)
          .scale(Vector2(number(entity, 41, 1.0), number(entity, 42, 1.0)))
          .translate(-base);
      inner.layer = path.layer;
      inner.colour = path.colour;
      inner.depth = depth + 1;
      if (++inserts_ > 200'000) {
        throw inputErrorAt({file_, entity.line},
                           "there are more than 200000 inserted blocks. Explode or delete some");
      }
      addEntities(block->second, inner);
    }
  }

  void arc(std::vector<Vector2>& points, const Vector2& centre, const Vector2& first,
           const Vector2& second, double from, double sweep) {
    addArc(points, centre, first, second, from, sweep, scale_ > 0 ? flattening_ / scale_ : 1);
    drawing_.flattening = flattening_;
  }

  /// A straight or bulged piece to the next vertex.
  void addBulge(std::vector<Vector2>& points, const Vector2& to, double bulge) {
    const Vector2 from = points.back();
    if (bulge != 0 && from != to) {
      const Vector2 half = 0.5 * (to - from);
      // The centre is (1 - b^2) / (2 b) half chords to the left of the chord's middle.
      const Vector2 centre =
          from + half + (1 - bulge * bulge) / (2 * bulge) * Vector2(-half.y(), half.x());
      const Vector2 first = from - centre;
      arc(points, centre, first, Vector2(-first.y(), first.x()), 0, 4 * std::atan(bulge));
      points.back() = to;
    } else {
      points.push_back(to);
    }
  }

  void addVertices(const std::vector<Vector2>& vertices, const std::vector<double>& bulges,
                   DrawnPath& path) {
    if (vertices.empty()) return;
    path.points.push_back(vertices[0]);
    const std::size_t pieces = vertices.size() - (path.isClosed ? 0 : 1);
    for (std::size_t k = 0; k < pieces; ++k) {
      addBulge(path.points, vertices[(k + 1) % vertices.size()], bulges[k]);
    }
  }

  void addPolyline(const DxfEntity& entity, DrawnPath& path) {
    std::vector<Vector2> vertices;
    std::vector<double> bulges;
    for (const DxfGroup& group : entity.groups) {
      if (group.code == 10) {
        vertices.emplace_back(coordinate(group), 0);
        bulges.push_back(0);
      } else if (group.code == 20 && !vertices.empty()) {
        vertices.back().y() = coordinate(group);
      } else if (group.code == 42 && !bulges.empty()) {
        bulges.back() = value(group);
      }
    }
    path.isClosed = (whole(entity, 70, 0) & 1) != 0;
    addVertices(vertices, bulges, path);
  }

  /// A polyline of R12, whose vertices are separate entities; false for meshes.
  bool addOldPolyline(const DxfEntity& entity, const std::vector<DxfEntity>& all, std::size_t first,
                      std::size_t last, DrawnPath& path) {
    const int flags = whole(entity, 70, 0);
    if ((flags & (16 | 64)) != 0) return false;
    std::vector<Vector2> vertices;
    std::vector<double> bulges;
    for (std::size_t k = first; k < last; ++k) {
      if ((whole(all[k], 70, 0) & 16) != 0) continue;  // of a spline's frame
      vertices.push_back(point(all[k], 10));
      const DxfGroup* bulge = all[k].group(42);
      bulges.push_back(bulge ? value(*bulge) : 0);
    }
    path.isClosed = (flags & 1) != 0;
    addVertices(vertices, bulges, path);
    return true;
  }

  /// The entity's lines in its own coordinates; false if it has no lines.
  bool addPoints(const DxfEntity& entity, const std::vector<DxfEntity>& all, std::size_t first,
                 std::size_t last, DrawnPath& path) {
    const std::string& type = entity.type;
    if (type == "LINE") {
      path.points = {point(entity, 10), point(entity, 11)};
    } else if (type == "LWPOLYLINE") {
      addPolyline(entity, path);
    } else if (type == "POLYLINE") {
      return addOldPolyline(entity, all, first, last, path);
    } else if (type == "CIRCLE" || type == "ARC") {
      const Vector2 centre = point(entity, 10);
      const double radius = number(entity, 40);
      const bool isArc = type == "ARC";
      const double from = isArc ? number(entity, 50) * kDegree : 0;
      double sweep =
          isArc ? std::fmod(number(entity, 51) * kDegree - from, kFullCircle) : kFullCircle;
      if (sweep <= 0) sweep += kFullCircle;
      path.isClosed = !isArc;
      if (isArc) path.points.push_back(centre + radius * Vector2(std::cos(from), std::sin(from)));
      arc(path.points, centre, {radius, 0}, {0, radius}, from, sweep);
    } else if (type == "ELLIPSE") {
      const Vector2 centre = point(entity, 10), major = point(entity, 11);
      const double ratio = number(entity, 40) * (number(entity, 230, 1.0) < 0 ? -1 : 1);
      const Vector2 minor = ratio * Vector2(-major.y(), major.x());
      const double from = number(entity, 41, 0.0);
      double sweep = number(entity, 42, kFullCircle) - from;
      if (sweep <= 0) sweep += kFullCircle;
      path.isClosed = sweep > kFullCircle - 1e-9;
      if (!path.isClosed)
        path.points.push_back(centre + std::cos(from) * major + std::sin(from) * minor);
      arc(path.points, centre, major, minor, from, sweep);
    } else if (type == "SPLINE") {
      addSpline(entity, path);
    } else {
      return false;
    }
    return true;
  }

  /// De Boor's algorithm on homogeneous points.
  static Eigen::Vector3d splinePoint(const std::vector<double>& knots,
                                     const std::vector<Eigen::Vector3d>& control, int degree,
                                     int span, double t) {
    std::vector<Eigen::Vector3d> d(control.begin() + (span - degree), control.begin() + span + 1);
    for (int r = 1; r <= degree; ++r) {
      for (int j = degree; j >= r; --j) {
        const double low = knots[j + span - degree], high = knots[j + 1 + span - r];
        const double part = high > low ? (t - low) / (high - low) : 0;
        d[j] = (1 - part) * d[j - 1] + part * d[j];
      }
    }
    return d[degree];
  }

  void addSpline(const DxfEntity& entity, DrawnPath& path) {
    std::vector<double> knots, weights;
    std::vector<Eigen::Vector3d> control;
    std::vector<Vector2> fit;
    for (const DxfGroup& group : entity.groups) {
      if (group.code == 40) knots.push_back(value(group));
      if (group.code == 41) weights.push_back(value(group));
      if (group.code == 10) control.emplace_back(coordinate(group), 0, 1);
      if (group.code == 20 && !control.empty()) control.back().y() = coordinate(group);
      if (group.code == 11) fit.emplace_back(coordinate(group), 0);
      if (group.code == 21 && !fit.empty()) fit.back().y() = coordinate(group);
    }
    path.isClosed = (whole(entity, 70, 0) & 1) != 0;
    const int degree = whole(entity, 71, 3);
    if (control.empty()) {
      ++drawing_.ignored["control point of a spline, which has fit points only: drawn straight"];
      path.points = fit;
      return;
    }
    const int count = static_cast<int>(control.size());
    if (degree < 1 || degree > 20 || count <= degree ||
        knots.size() != control.size() + static_cast<std::size_t>(degree) + 1 ||
        !std::ranges::is_sorted(knots)) {
      throw inputErrorAt({file_, entity.line},
                         fmt::format("a SPLINE of degree {} has {} knots and {} control "
                                     "points; save its curve as a polyline",
                                     degree, knots.size(), count));
    }
    for (int k = 0; k < count; ++k) {
      if (weights.size() == control.size()) control[k] *= weights[k];
    }
    if (degree > 1) drawing_.flattening = flattening_;
    const bool isRational = weights.size() == control.size();
    const auto at = [&](int span, double t) {
      const Eigen::Vector3d place = splinePoint(knots, control, degree, span, t);
      return Vector2(place.head<2>() / (isRational ? place.z() : 1));
    };
    for (int span = degree; span < count; ++span) {
      const double from = knots[span], to = knots[span + 1];
      if (!(to > from)) continue;
      if (path.points.empty()) path.points.push_back(at(span, from));
      // Pieces are halved until the middle of each is within the tolerance.
      int pieces = degree == 1 ? 1 : 2;
      const double enough = scale_ > 0 ? flattening_ / scale_ : 1;
      for (; pieces < 256 && degree > 1; pieces *= 2) {
        double worst = 0;
        for (int k = 0; k < pieces; ++k) {
          const double a = from + (to - from) * k / pieces,
                       b = from + (to - from) * (k + 1) / pieces;
          worst =
              std::max(worst, (at(span, 0.5 * (a + b)) - 0.5 * (at(span, a) + at(span, b))).norm());
        }
        if (worst <= enough) break;
      }
      for (int k = 1; k <= pieces; ++k) {
        path.points.push_back(at(span, from + (to - from) * k / pieces));
      }
    }
  }

  const fs::path& file_;
  double flattening_;  // metres
  Drawing drawing_;
  std::map<std::string, DxfLayer> layers_;
  std::map<std::string, std::vector<DxfEntity>> blocks_;
  std::vector<DxfEntity> entities_;
  std::map<std::string, DxfGroup, std::less<>> header_;
  double scale_ = 1;
  DecimalCounts decimals_;
  int inserts_ = 0;
};

}  // namespace

Drawing readDxfDrawing(const fs::path& file, const std::string& text, double flattening) {
  return DxfReader(file, flattening).read(text);
}

}  // namespace kirireel::formats
