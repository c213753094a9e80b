// Reads the lines of SVG files (W3C, Scalable Vector Graphics 1.1, chapters 5 to 10).
//
// The tree is traversed once with a transform and a style that children inherit. Lengths: the
// root's width and height with units relative to its viewBox give metres per user unit. Without
// them a user unit is a pixel of 1/96 inch. Style: presentation attributes, then style sheet rules
// (style_sheet.cpp), then the style attribute. Elliptical arcs are converted to their centre form
// (appendix F.6.5). Entities of the document type are replaced first, which pugixml does not.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <unordered_map>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <pugixml.hpp>

#include "sim/base/error.h"
#include "sim/formats/arrangement.h"
#include "sim/formats/drawing.h"
#include "sim/formats/middle_lines.h"
#include "sim/formats/style_sheet.h"

namespace kirireel::formats {
namespace {

namespace fs = std::filesystem;
using SvgTransform = Eigen::Affine2d;

constexpr double kInch = 0.0254;
constexpr double kPixel = kInch / 96;
constexpr int kDeepestElement = 200;
constexpr std::string_view kSvgBlank = " \t\r\n\f";

const std::map<std::string_view, double> kSvgUnits = {
    {"mm", 1e-3},   {"cm", 1e-2}, {"in", kInch},  {"pt", kInch / 72},  {"pc", kInch / 6},
    {"px", kPixel}, {"m", 1},     {"q", 0.25e-3}, {"em", 16 * kPixel}, {"ex", 8 * kPixel}};

/// Replaces entities that the document type declares, such as the styles of Illustrator: &st0;.
std::string withoutEntities(const std::string& text, const fs::path& file) {
  constexpr std::size_t kMaxText = 64'000'000;  // a limit for repeated entities
  const std::size_t type = text.find("<!DOCTYPE");
  const std::size_t open = std::min(text.find('[', type), text.find('>', type));
  if (type == text.npos || open == text.npos || text[open] != '[') return text;
  const std::size_t end = text.find("]", open);
  std::map<std::string, std::string, std::less<>> values;
  for (std::size_t at = text.find("<!ENTITY", open); at < end; at = text.find("<!ENTITY", at + 1)) {
    const std::size_t quote = text.find_first_of("\"'", at);
    const std::size_t last = quote == text.npos ? quote : text.find(text[quote], quote + 1);
    if (last == text.npos) break;
    std::string value = text.substr(quote + 1, last - quote - 1);
    std::ranges::replace(value, '\n', ' ');  // keeps the numbers of lines
    std::ranges::replace(value, '"', '\'');
    values[std::string(trimmed(std::string_view(text).substr(at + 8, quote - at - 8)))] = value;
  }
  if (values.empty()) return text;
  std::string whole;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t mark = std::min(text.find('&', at), text.size());
    whole.append(text, at, mark - at);
    if (mark == text.size()) break;
    const std::size_t semicolon = text.find(';', mark);
    const auto value = values.find(std::string_view(text).substr(mark + 1, semicolon - mark - 1));
    const bool isKnown = semicolon != text.npos && value != values.end();
    whole += isKnown ? value->second : "&";
    if (whole.size() > kMaxText) {
      throw inputErrorAt({file},
                         "the entities of the document type are too long. Save the drawing "
                         "as SVG without them");
    }
    at = isKnown ? semicolon + 1 : mark + 1;
  }
  return whole;
}

/// Scanner for path data and lists of numbers.
class NumberScanner {
 public:
  NumberScanner(std::string_view text, const FileLocation& place, DecimalCounts* decimals = nullptr)
      : text_(text), place_(place), decimals_(decimals) {}

  bool isAtEnd() {
    skip();
    return at_ >= text_.size();
  }
  /// Consumes and returns a letter; 0 if a number begins.
  char letter() {
    skip();
    const char here = text_[at_];
    const bool isLetter = (here >= 'a' && here <= 'z') || (here >= 'A' && here <= 'Z');
    if (isLetter) ++at_;
    return isLetter ? here : '\0';
  }
  double number() {
    skip();
    if (at_ >= text_.size()) {
      const std::string_view last =
          text_.substr(text_.size() - std::min<std::size_t>(text_.size(), 24));
      throw inputErrorAt(place_, fmt::format("a number is missing after '{}'. Complete the numbers",
                                             shown(last, 24)));
    }
    const std::size_t begin = at_;
    const auto digits = [&] {
      while (at_ < text_.size() && text_[at_] >= '0' && text_[at_] <= '9') ++at_;
    };
    if (at_ < text_.size() && (text_[at_] == '-' || text_[at_] == '+')) ++at_;
    digits();
    if (at_ < text_.size() && text_[at_] == '.') {
      ++at_;
      digits();
    }
    if (at_ + 1 < text_.size() && (text_[at_] == 'e' || text_[at_] == 'E') &&
        (std::string_view("+-0123456789").find(text_[at_ + 1]) != std::string_view::npos)) {
      at_ += 2;
      digits();
    }
    if (at_ == begin) at_ = std::min(at_ + 12, text_.size());  // shown in the message
    return drawnNumber(text_.substr(begin, at_ - begin), place_, decimals_);
  }
  /// Consumes and returns the letters or '%' that directly follow a number.
  std::string_view unit() {
    const std::size_t begin = at_;
    while (at_ < text_.size() &&
           (std::isalpha(static_cast<unsigned char>(text_[at_])) || text_[at_] == '%')) {
      ++at_;
    }
    return text_.substr(begin, at_ - begin);
  }
  /// A flag of an arc is one digit. A number may follow it without a blank.
  bool flag() {
    skip();
    if (at_ < text_.size() && (text_[at_] == '0' || text_[at_] == '1')) return text_[at_++] == '1';
    return number() != 0;
  }

 private:
  void skip() {
    while (at_ < text_.size() &&
           (text_[at_] == ',' || kSvgBlank.find(text_[at_]) != kSvgBlank.npos)) {
      ++at_;
    }
  }

  std::string_view text_;
  FileLocation place_;
  DecimalCounts* decimals_;
  std::size_t at_ = 0;
};

/// The parts of a line within closed lines, or on them.
std::vector<DrawnPath> partsWithin(const std::vector<DrawnPath>& borders, const DrawnPath& line) {
  constexpr double kOnBorder = 1e-6;  // of the borders' size
  std::vector<PlaneSegment> edges;
  Eigen::AlignedBox2d box;
  for (const DrawnPath& border : borders) {
    for (std::size_t k = 0; k < border.points.size(); ++k) {
      edges.emplace_back(border.points[k], border.points[(k + 1) % border.points.size()]);
      box.extend(border.points[k]);
    }
  }
  const double near = edges.empty() ? 0 : kOnBorder * box.diagonal().norm();
  const auto isInside = [&](const Vector2& point) {
    return isWithin(edges, point) || std::ranges::any_of(edges, [&](const PlaneSegment& edge) {
             return distanceTo(edge, point) <= near;
           });
  };
  std::vector<Vector2> points = line.points;
  if (line.isClosed) points.push_back(points.front());
  std::vector<DrawnPath> parts;
  bool isWhole = true, continues = false;
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const Vector2 from = points[k], along = points[k + 1] - from;
    std::vector<double> shares = {0, 1};
    for (const auto& [a, b] : edges) {
      const auto crossing = crossingShares(from, along, a, b - a);
      if (!crossing) continue;
      const auto [share, onEdge] = *crossing;
      const bool isCrossing = onEdge > -kOnBorder && onEdge < 1 + kOnBorder;
      if (isCrossing && share > 0 && share < 1) shares.push_back(share);
    }
    std::ranges::sort(shares);
    for (std::size_t i = 0; i + 1 < shares.size(); ++i) {
      if (shares[i] == shares[i + 1]) continue;
      if (!isInside(from + 0.5 * (shares[i] + shares[i + 1]) * along)) {
        isWhole = continues = false;
        continue;
      }
      if (!continues) {
        parts.push_back(line);
        parts.back().isClosed = false;
        parts.back().points = {from + shares[i] * along};
      }
      parts.back().points.push_back(shares[i + 1] == 1 ? points[k + 1]
                                                       : Vector2(from + shares[i + 1] * along));
      continues = true;
    }
  }
  return isWhole ? std::vector{line} : parts;
}

/// Inherited properties.
struct SvgStyle {
  std::string stroke = "none";
  std::string fill = "#000000";
  bool isVisible = true;
  bool isDashed = false;
  bool isWide = true;    // the stroke's width is not 0
  bool isOpaque = true;  // the stroke's opacity is not 0
  std::string layer;
  std::vector<std::string> names;
};

class SvgReader {
 public:
  SvgReader(const fs::path& file, double flattening)
      : file_(file), place_{file, 0, 0}, flattening_(flattening) {}

  Drawing read(const std::string& written) {
    pugi::xml_document document;
    const std::string text = withoutEntities(written, file_);
    for (std::size_t at = text.find('\n'); at != text.npos; at = text.find('\n', at + 1)) {
      lineEnds_.push_back(static_cast<std::ptrdiff_t>(at));
    }
    const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size());
    if (!parsed) {
      throw inputErrorAt({file_, lineOf(parsed.offset)},
                         fmt::format("this is not XML: {}. Save the drawing as SVG again",
                                     lowerCase(parsed.description())));
    }
    collect(document, 0);
    const pugi::xml_node root = document.document_element();
    drawing_.isDownwards = true;
    SvgTransform transform = rootTransform(root);
    const bool hasRoot = localName(root.name()) == "svg";
    SvgStyle style = hasRoot ? styleOf(root, SvgStyle()) : SvgStyle();
    style.names.clear();
    walkChildren(hasRoot ? root : document, transform, style, 0);
    keepStrokes();
    for (const auto& [what, count] : sheet_.ignored()) drawing_.ignored[what] += count;
    drawing_.rounding = decimals_.lastPlace() * largestScale_;
    return std::move(drawing_);
  }

 private:
  /// Collects elements by id, and rules of style sheets.
  void collect(const pugi::xml_node& node, int depth) {
    if (depth > kDeepestElement) return;
    for (const pugi::xml_node& child : node.children()) {
      if (child.type() != pugi::node_element) continue;
      if (const char* id = child.attribute("id").value(); *id) elements_.try_emplace(id, child);
      if (localName(child.name()) == "style") {
        std::string sheet;
        for (const pugi::xml_node& part : child.children()) sheet += part.value();
        sheet_.add(std::move(sheet));
      }
      collect(child, depth + 1);
    }
  }

  /// The line of the file, from an offset of the parser.
  int lineOf(std::ptrdiff_t offset) const {
    return static_cast<int>(std::ranges::lower_bound(lineEnds_, offset) - lineEnds_.begin()) + 1;
  }

  /// An element and its ancestors, for selectors.
  static std::vector<StyledElement> withAncestors(const pugi::xml_node& node) {
    std::vector<StyledElement> path;
    for (pugi::xml_node one = node; one.type() == pugi::node_element; one = one.parent()) {
      path.push_back({localName(one.name()), one.attribute("id").value(),
                      classesOf(one.attribute("class").value())});
    }
    return path;
  }

  /// A property of an element; absent if the element does not set it.
  std::optional<std::string> property(const pugi::xml_node& node, const std::string& name) {
    if (node != styled_) {
      values_ = sheet_.valuesOf(withAncestors(node));
      overrideWith(values_, declarations(node.attribute("style").value()));
      styled_ = node;
    }
    if (const auto found = values_.find(name); found != values_.end()) return found->second.text;
    const pugi::xml_attribute own = node.attribute(name.c_str());
    return own ? std::optional<std::string>(own.value()) : std::nullopt;
  }

  /// Whether a property is a number and 0, with any unit. Absent if the element does not set it.
  std::optional<bool> isZero(const pugi::xml_node& node, const std::string& name) {
    const std::optional<std::string> text = property(node, name);
    if (!text || *text == "inherit") return std::nullopt;
    char* end = nullptr;
    const double value = std::strtod(text->c_str(), &end);
    return end != text->c_str() && value == 0;
  }

  SvgStyle styleOf(const pugi::xml_node& node, const SvgStyle& parent) {
    SvgStyle style = parent;
    const auto take = [&](const char* name, std::string& value) {
      const std::optional<std::string> own = property(node, name);
      if (own && *own != "inherit") value = normalColour(*own);
    };
    take("stroke", style.stroke);
    take("fill", style.fill);
    if (const auto dashes = property(node, "stroke-dasharray")) {
      style.isDashed = *dashes != "none" && *dashes != "inherit" && *dashes != "0";
    }
    if (const auto isThin = isZero(node, "stroke-width")) style.isWide = !*isThin;
    if (const auto isTransparent = isZero(node, "stroke-opacity")) style.isOpaque = !*isTransparent;
    if (const auto visibility = property(node, "visibility")) {
      style.isVisible = *visibility != "hidden" && *visibility != "collapse";
    }
    std::string label;
    bool isLayer = false;
    for (const pugi::xml_attribute& one : node.attributes()) {
      const std::string name = localName(one.name());
      if (name == "label") label = one.value();
      if (name == "groupmode") isLayer = std::string_view(one.value()) == "layer";
    }
    const std::string id = node.attribute("id").value();
    for (const std::string& name : {label, id}) {
      if (!name.empty()) style.names.push_back(lowerCase(name));
    }
    for (const std::string& name : classesOf(node.attribute("class").value()))
      style.names.push_back(lowerCase(name));
    const bool isGroup = localName(node.name()) == "g";
    if (isGroup && (isLayer || style.layer.empty())) {
      const std::string name = label.empty() ? id : label;
      if (!name.empty()) style.layer = lowerCase(name);
    }
    return style;
  }

  /// A length of an attribute in user units; percentages refer to `whole`.
  double length(const pugi::xml_node& node, const char* name, double whole, double otherwise = 0) {
    const std::string_view text = trimmed(node.attribute(name).value());
    if (text.empty() || text == "auto") return otherwise;
    return lengthOf(text, whole);
  }

  double lengthOf(std::string_view text, double whole) {
    std::size_t end = text.size();
    while (end > 0 &&
           (std::isalpha(static_cast<unsigned char>(text[end - 1])) || text[end - 1] == '%')) {
      --end;
    }
    if (end == 0) {
      throw inputErrorAt(place_, fmt::format("the length '{}' is not a number. Give a number, with "
                                             "a unit if needed",
                                             shown(text, 24)));
    }
    return inUserUnits(drawnNumber(trimmed(text.substr(0, end)), place_, counts_), text.substr(end),
                       whole);
  }

  /// A number with its unit in user units; percentages refer to `whole`.
  double inUserUnits(double value, std::string_view unit, double whole) const {
    if (unit.empty()) return value;
    if (unit == "%") return value / 100 * whole;
    const auto known = kSvgUnits.find(lowerCase(unit));
    if (known != kSvgUnits.end()) return value * known->second / kPixel;
    throw inputErrorAt(
        place_,
        fmt::format("the length '{}{}' has an unknown unit. Use one of mm, cm, in, pt, pc, px",
                    value, shown(unit, 24)));
  }

  std::vector<double> numbers(std::string_view text) {
    NumberScanner scanner(text, place_);
    std::vector<double> found;
    while (!scanner.isAtEnd()) found.push_back(scanner.number());
    return found;
  }

  /// Transform of an element's own coordinates by viewBox and preserveAspectRatio.
  SvgTransform viewTransform(const pugi::xml_node& node, double width, double height) {
    SvgTransform transform = SvgTransform::Identity();
    const std::vector<double> box = numbers(node.attribute("viewBox").value());
    if (box.size() != 4 || !(box[2] > 0) || !(box[3] > 0)) {
      view_ = {width, height};
      return transform;
    }
    view_ = {box[2], box[3]};
    if (!(width > 0) && !(height > 0)) return transform;
    double x = width > 0 ? width / box[2] : height / box[3];
    double y = height > 0 ? height / box[3] : x;
    const std::string_view ratio = trimmed(node.attribute("preserveAspectRatio").value());
    if (!ratio.starts_with("none")) {
      // Ratios of printed digits count as equal up to rounding.
      const bool isSlice = ratio.find("slice") != ratio.npos;
      x = y = std::abs(x - y) < 1e-4 * x ? x : isSlice ? std::max(x, y) : std::min(x, y);
    }
    transform.linear() << x, 0, 0, y;
    return transform;
  }

  /// Converts the root's user units to metres, y upwards. Keeps the drawing's origin.
  SvgTransform rootTransform(const pugi::xml_node& root) {
    const std::vector<double> box = numbers(root.attribute("viewBox").value());
    const bool hasBox = box.size() == 4;
    const auto isShare = [&](const char* name) {
      const std::string_view text = trimmed(root.attribute(name).value());
      return text.empty() || text.ends_with('%') || text == "auto";
    };
    for (const char* name : {"width", "height"}) {
      const std::string text = lowerCase(trimmed(root.attribute(name).value()));
      const std::string unit = text.substr(text.find_last_of("0123456789. ") + 1);
      const bool isOfScreen = unit == "px" || unit == "em" || unit == "ex";
      drawing_.hasUnit = drawing_.hasUnit || (kSvgUnits.contains(unit) && !isOfScreen);
    }
    const double width = isShare("width") ? 0 : length(root, "width", 0);
    const double height = isShare("height") ? 0 : length(root, "height", 0);
    SvgTransform transform = viewTransform(root, width, height);
    if (!hasBox && !(view_.x() > 0)) view_ = {100, 100};
    // With one multiplication, which converts millimetres to metres without rounding.
    const auto metres = [&](int axis) {
      const double scale = transform.linear()(axis, axis);
      const double millimetres = scale * kPixel / 1e-3;
      const double whole = std::round(millimetres * 1e9) / 1e9;
      return std::abs(millimetres - whole) < 1e-12 * whole ? whole * 1e-3 : scale * kPixel;
    };
    const double x = metres(0), y = metres(1);
    transform.linear() << x, 0, 0, -y;
    drawing_.unit = x;
    const auto isUnit = [&](double unit) { return std::abs(x / unit - 1) < 1e-3; };
    drawing_.unitName = isUnit(1e-3)         ? "mm"
                        : isUnit(1e-2)       ? "cm"
                        : isUnit(kInch)      ? "in"
                        : isUnit(kInch / 72) ? "pt"
                        : isUnit(kPixel)     ? "px"
                                             : "units";
    return transform;
  }

  /// A number of a transform. Style sheets have units: "10px", "45deg".
  struct Argument {
    double value = 0;
    std::string_view unit;
  };

  double degreesOf(const Argument& angle) const {
    static const std::map<std::string_view, double> kDegrees = {
        {"", 1}, {"deg", 1}, {"grad", 0.9}, {"rad", 180 / std::numbers::pi}, {"turn", 360}};
    const auto known = kDegrees.find(angle.unit);
    if (known != kDegrees.end()) return angle.value * known->second;
    throw inputErrorAt(place_,
                       fmt::format("the angle '{}{}' has an unknown unit. Use deg, grad, rad or "
                                   "turn",
                                   angle.value, shown(angle.unit, 24)));
  }

  /// One function of a transform; absent for another name or number of arguments.
  std::optional<SvgTransform> transformOf(std::string_view name, std::vector<Argument> n) const {
    const std::size_t given = n.size();
    n.resize(6);
    SvgTransform one = SvgTransform::Identity();
    const auto along = [&](int k, int axis) {
      return inUserUnits(n[k].value, n[k].unit, view_[axis]);
    };
    const auto factor = [&](int k) { return n[k].value / (n[k].unit == "%" ? 100 : 1); };
    const auto isOf = [&](std::string_view what, std::size_t least, std::size_t most) {
      return name == what && given >= least && given <= most;
    };
    const auto tangent = [&](int k) { return std::tan(degreesOf(n[k]) * std::numbers::pi / 180); };
    if (isOf("matrix", 6, 6)) {
      one.matrix() << n[0].value, n[2].value, along(4, 0), n[1].value, n[3].value, along(5, 1), 0,
          0, 1;
    } else if (isOf("translate", 1, 2)) {
      one.translate(Vector2(along(0, 0), along(1, 1)));
    } else if (isOf("translateX", 1, 1)) {
      one.translate(Vector2(along(0, 0), 0));
    } else if (isOf("translateY", 1, 1)) {
      one.translate(Vector2(0, along(0, 1)));
    } else if (isOf("scale", 1, 2)) {
      one.scale(Vector2(factor(0), factor(given > 1 ? 1 : 0)));
    } else if (isOf("scaleX", 1, 1)) {
      one.scale(Vector2(factor(0), 1));
    } else if (isOf("scaleY", 1, 1)) {
      one.scale(Vector2(1, factor(0)));
    } else if (isOf("rotate", 1, 3)) {
      const Vector2 centre(along(1, 0), along(2, 1));
      one.translate(centre)
          .rotate(Eigen::Rotation2Dd(degreesOf(n[0]) * std::numbers::pi / 180))
          .translate(-centre);
    } else if (isOf("skewX", 1, 1)) {
      one.matrix()(0, 1) = tangent(0);
    } else if (isOf("skewY", 1, 1)) {
      one.matrix()(1, 0) = tangent(0);
    } else {
      return std::nullopt;
    }
    return one;
  }

  SvgTransform parsedTransform(std::string_view text) const {
    SvgTransform whole = SvgTransform::Identity();
    for (text = trimmed(text); !text.empty() && text != "none";) {
      const std::size_t open = text.find('(');
      const std::size_t close = std::min(text.find(')'), text.size());
      std::optional<SvgTransform> one;
      if (open < close && close < text.size()) {
        std::vector<Argument> n;
        NumberScanner scanner(text.substr(open + 1, close - open - 1), place_);
        while (!scanner.isAtEnd()) {
          const double value = scanner.number();
          n.push_back({value, scanner.unit()});
        }
        one = transformOf(trimmed(text.substr(0, open)), std::move(n));
      }
      if (!one) {
        throw inputErrorAt(
            place_, fmt::format("'{}' is not a transform of SVG. Allowed: matrix of 6 numbers, "
                                "translate and scale of 1 or 2, rotate of 1 or 3, skewX, skewY",
                                shown(text.substr(0, close + 1))));
      }
      whole = whole * *one;
      text = trimmed(text.substr(close + 1));
      while (text.starts_with(',')) text = trimmed(text.substr(1));
    }
    return whole;
  }

  /// A transform about its origin, which is the zero of the coordinates by default.
  SvgTransform transformOf(const pugi::xml_node& node) {
    const SvgTransform transform = parsedTransform(property(node, "transform").value_or(""));
    const std::optional<std::string> given = property(node, "transform-origin");
    if (!given || transform.isApprox(SvgTransform::Identity(), 0)) return transform;
    const std::string box = property(node, "transform-box").value_or("view-box");
    if (box != "view-box") {
      throw inputErrorAt(place_, fmt::format("the transform-box '{}' is not supported. Apply the "
                                             "transforms in the editor",
                                             shown(box, 24)));
    }
    std::array<std::string_view, 2> words = {"50%", "50%"};
    std::string_view rest = trimmed(*given);
    for (std::string_view& word : words) {
      if (rest.empty()) break;
      word = rest.substr(0, rest.find_first_of(" \t\r\n\f,"));
      rest = trimmed(rest.substr(word.size()));
      while (rest.starts_with(',')) rest = trimmed(rest.substr(1));
    }
    const auto isVertical = [](std::string_view word) { return word == "top" || word == "bottom"; };
    if (isVertical(words[0]) || words[1] == "left" || words[1] == "right") {
      std::swap(words[0], words[1]);
    }
    static const std::map<std::string_view, std::string_view> kSides = {
        {"left", "0"}, {"top", "0"}, {"center", "50%"}, {"right", "100%"}, {"bottom", "100%"}};
    Vector2 origin;
    for (int axis = 0; axis < 2; ++axis) {
      const auto side = kSides.find(words[axis]);
      origin[axis] = lengthOf(side == kSides.end() ? words[axis] : side->second, view_[axis]);
    }
    return Eigen::Translation2d(origin) * transform * Eigen::Translation2d(-origin);
  }

  void walkChildren(const pugi::xml_node& node, const SvgTransform& transform,
                    const SvgStyle& style, int depth) {
    if (depth > kDeepestElement) {
      throw inputErrorAt(place_,
                         fmt::format("groups or uses are nested more than {} deep; ungroup them",
                                     kDeepestElement));
    }
    for (const pugi::xml_node& child : node.children()) walk(child, transform, style, depth);
  }

  void walk(const pugi::xml_node& node, const SvgTransform& outer, const SvgStyle& parent,
            int depth) {
    if (node.type() != pugi::node_element) return;
    const std::string tag = localName(node.name());
    static const std::vector<std::string> kSilent = {
        "style",   "title",  "desc",           "metadata",       "namedview",
        "defs",    "symbol", "clippath",       "mask",           "pattern",
        "marker",  "script", "lineargradient", "radialgradient", "filter",
        "animate", "pgf",    "i:pgf",          "aipgfref",       "perspective"};
    if (std::ranges::find(kSilent, tag) != kSilent.end()) return;
    place_.line = lineOf(node.offset_debug());
    const auto isSet = [&](const char* name) {
      const auto value = property(node, name);
      return value && *value != "none" && *value != "inherit";
    };
    const auto display = property(node, "display");
    if ((display && *display == "none") || isZero(node, "opacity").value_or(false)) {
      ++drawing_.ignored["hidden element"];
      return;
    }
    if (isSet("mask")) ++drawing_.ignored["mask, which is not applied"];
    const std::size_t first = drawing_.paths.size();
    const SvgStyle style = styleOf(node, parent);
    const SvgTransform transform = outer * transformOf(node);
    if (tag == "g" || tag == "a" || tag == "switch") {
      walkChildren(node, transform, style, depth + 1);
    } else if (tag == "svg") {
      walkViewport(node, transform, style, depth);
    } else if (tag == "use") {
      walkUse(node, transform, style, depth);
    } else if (!addShape(node, tag, transform, style)) {
      ++drawing_.ignored[tag == "tspan" || tag == "flowroot" ? "text" : shown(tag, 24)];
    }
    if (isSet("clip-path")) clip(first, *property(node, "clip-path"), transform, depth);
  }

  /// Keeps the parts of the lines from number `first` on that are within a clip path (chapter
  /// 14.3).
  void clip(std::size_t first, const std::string& reference, const SvgTransform& transform,
            int depth) {
    const std::size_t begin = reference.find('#');
    const std::size_t end = std::min(reference.find_first_of("\"')", begin), reference.size());
    const auto found =
        elements_.find(begin < end ? reference.substr(begin + 1, end - begin - 1) : std::string());
    const bool isOne = found != elements_.end() && localName(found->second.name()) == "clippath";
    if (!isOne ||
        std::string_view(found->second.attribute("clipPathUnits").value()) == "objectBoundingBox") {
      ++drawing_.ignored["clip-path, which is not applied"];
      return;
    }
    if (++uses_ > 200'000) {
      throw inputErrorAt(place_,
                         "there are more than 200000 clip paths. Release some in the editor");
    }
    const auto taken = [&] {
      std::vector<DrawnPath> paths(
          std::make_move_iterator(drawing_.paths.begin() + static_cast<std::ptrdiff_t>(first)),
          std::make_move_iterator(drawing_.paths.end()));
      drawing_.paths.resize(first);
      return paths;
    };
    const std::vector<DrawnPath> lines = taken();
    walkChildren(found->second, transform * transformOf(found->second), {}, depth + 1);
    const std::vector<DrawnPath> borders = taken();
    for (const DrawnPath& line : lines) {
      const std::vector<DrawnPath> parts = partsWithin(borders, line);
      const bool isWhole = parts.size() == 1 && parts[0].points == line.points;
      drawing_.ignored["line outside its clip path, which is not cut there"] += isWhole ? 0 : 1;
      drawing_.paths.insert(drawing_.paths.end(), parts.begin(), parts.end());
    }
    std::erase_if(drawing_.ignored, [](const auto& one) { return one.second == 0; });
  }

  /// A nested svg, or a symbol, whose size its use may give.
  void walkViewport(const pugi::xml_node& node, const SvgTransform& outer, const SvgStyle& style,
                    int depth, const pugi::xml_node& use = {}) {
    const Vector2 view = view_;
    SvgTransform transform = outer;
    transform.translate(Vector2(length(node, "x", view.x()), length(node, "y", view.y())));
    const auto sizeOf = [&](const char* name, double whole) {
      return length(use.attribute(name) ? use : node, name, whole, whole);
    };
    const double width = sizeOf("width", view.x()), height = sizeOf("height", view.y());
    const SvgTransform inner = viewTransform(node, width, height);
    const std::vector<double> box = numbers(node.attribute("viewBox").value());
    const std::string_view ratio = node.attribute("preserveAspectRatio").value();
    if (box.size() == 4 && ratio.find("none") == ratio.npos) {
      // Shares of the excess length before the drawing; half of it by default.
      const auto shareOf = [&](std::string_view least, std::string_view most) {
        return ratio.find(least) != ratio.npos ? 0.0 : ratio.find(most) != ratio.npos ? 1.0 : 0.5;
      };
      const Vector2 used(inner.linear()(0, 0) * box[2], inner.linear()(1, 1) * box[3]);
      transform.translate(Vector2(shareOf("xMin", "xMax") * (width - used.x()),
                                  shareOf("YMin", "YMax") * (height - used.y())));
    }
    transform = transform * inner;
    if (box.size() == 4) transform.translate(Vector2(-box[0], -box[1]));
    walkChildren(node, transform, style, depth + 1);
    view_ = view;
  }

  void walkUse(const pugi::xml_node& node, SvgTransform transform, const SvgStyle& style,
               int depth) {
    std::string reference;
    for (const pugi::xml_attribute& one : node.attributes()) {
      if (localName(one.name()) == "href") reference = one.value();
    }
    if (!reference.empty() && reference[0] != '#') {
      throw inputErrorAt(place_, fmt::format("a 'use' names '{}' in another file. Insert that "
                                             "drawing into this one",
                                             shown(reference, 24)));
    }
    const auto found = elements_.find(reference.empty() ? "" : reference.substr(1));
    if (found == elements_.end()) {
      throw inputErrorAt(place_, fmt::format("a 'use' names '{}', which does not exist. Remove it, "
                                             "or give an element this id",
                                             shown(reference, 24)));
    }
    if (depth >= kDeepestElement || ++uses_ > 200'000) {
      throw inputErrorAt(place_, fmt::format("the element '{}' uses itself, or there are more than "
                                             "200000 uses. Replace them by copies",
                                             shown(reference, 24)));
    }
    transform.translate(Vector2(length(node, "x", view_.x()), length(node, "y", view_.y())));
    const std::string tag = localName(found->second.name());
    if (tag == "symbol" || tag == "svg") {
      transform = transform * transformOf(found->second);
      walkViewport(found->second, transform, styleOf(found->second, style), depth + 1, node);
    } else {
      walk(found->second, transform, style, depth + 1);
    }
  }

  /// Whether the element is a shape; adds its lines.
  bool addShape(const pugi::xml_node& node, const std::string& tag, const SvgTransform& transform,
                const SvgStyle& style) {
    transform_ = &transform;
    style_ = &style;
    counts_ = &decimals_;
    const bool isShape = addShapeOf(node, tag);
    counts_ = nullptr;
    return isShape;
  }

  bool addShapeOf(const pugi::xml_node& node, const std::string& tag) {
    const double scale = std::sqrt(std::abs(transform_->linear().determinant()));
    localFlattening_ = scale > 0 ? flattening_ / scale : flattening_;
    const auto x = [&](const char* name) { return length(node, name, view_.x()); };
    const auto y = [&](const char* name) { return length(node, name, view_.y()); };
    if (tag == "path") {
      addPathData(node.attribute("d").value());
    } else if (tag == "line") {
      add({{x("x1"), y("y1")}, {x("x2"), y("y2")}}, false);
    } else if (tag == "polyline" || tag == "polygon") {
      NumberScanner scanner(node.attribute("points").value(), place_, counts_);
      std::vector<Vector2> points;
      while (!scanner.isAtEnd()) {
        const double first = scanner.number();
        if (!scanner.isAtEnd()) points.emplace_back(first, scanner.number());
      }
      add(std::move(points), tag == "polygon");
    } else if (tag == "rect") {
      addRectangle(node);
    } else if (tag == "circle" || tag == "ellipse") {
      const double whole = view_.norm() / std::sqrt(2.0);
      const bool isCircle = tag == "circle";
      const double rx = length(node, isCircle ? "r" : "rx", isCircle ? whole : view_.x());
      const double ry = isCircle ? rx : length(node, "ry", view_.y());
      std::vector<Vector2> points;
      curve(points, {x("cx"), y("cy")}, {rx, 0}, {0, ry}, 0, 2 * std::numbers::pi);
      if (rx > 0 && ry > 0) add(std::move(points), true);
    } else {
      return false;
    }
    return true;
  }

  void curve(std::vector<Vector2>& points, const Vector2& centre, const Vector2& first,
             const Vector2& second, double from, double sweep) {
    addArc(points, centre, first, second, from, sweep, localFlattening_);
    drawing_.flattening = flattening_;
  }

  void addRectangle(const pugi::xml_node& node) {
    const double x = length(node, "x", view_.x()), y = length(node, "y", view_.y());
    const double w = length(node, "width", view_.x()), h = length(node, "height", view_.y());
    double rx = length(node, "rx", view_.x(), -1), ry = length(node, "ry", view_.y(), -1);
    if (rx < 0) rx = std::max(ry, 0.0);
    if (ry < 0) ry = rx;
    rx = std::min(rx, w / 2);
    ry = std::min(ry, h / 2);
    if (!(w > 0) || !(h > 0)) return;
    if (!(rx > 0) || !(ry > 0)) return add({{x, y}, {x + w, y}, {x + w, y + h}, {x, y + h}}, true);
    std::vector<Vector2> points;
    const Vector2 centres[] = {
        {x + w - rx, y + ry}, {x + w - rx, y + h - ry}, {x + rx, y + h - ry}, {x + rx, y + ry}};
    for (int k = 0; k < 4; ++k) {
      const double from = (k - 1) * std::numbers::pi / 2;
      points.push_back(centres[k] + Vector2(rx * std::cos(from), ry * std::sin(from)));
      curve(points, centres[k], {rx, 0}, {0, ry}, from, std::numbers::pi / 2);
    }
    add(std::move(points), true);
  }

  void add(std::vector<Vector2> points, bool isClosed) {
    if (!style_->isVisible || points.empty()) return;
    DrawnPath path;
    const bool isFilled = style_->stroke == "none" || style_->stroke == "transparent" ||
                          !style_->isWide || !style_->isOpaque;
    path.colour = isFilled ? "fill " + style_->fill : style_->stroke;
    path.layer = style_->layer;
    path.names = style_->names;
    path.isDashed = style_->isDashed;
    path.isClosed = isClosed;
    const auto& m = transform_->matrix();
    for (const Vector2& p : points) {
      path.points.emplace_back(m(0, 0) * p.x() + m(0, 1) * p.y() + m(0, 2),
                               0.0 + m(1, 0) * p.x() + m(1, 1) * p.y() + m(1, 2));
    }
    largestScale_ =
        std::max(largestScale_, std::sqrt(std::abs(transform_->linear().determinant())));
    addPath(drawing_, std::move(path), file_);
  }

  /// Whether a smooth curve continues a curve of the same degree.
  static bool isSmoothAfter(char kind, char before) {
    return (kind == 'S' && before == 'C') || (kind == 'T' && before == 'Q');
  }

  /// Handles the commands C, S, Q and T. Returns the curve's end; `control` is its last control
  /// point.
  template <typename ReadPoint>
  Vector2 addCurve(std::vector<Vector2>& points, char kind, bool continues, const Vector2& at,
                   Vector2& control, ReadPoint point) {
    const bool isCubic = kind == 'C' || kind == 'S';
    const bool isSmooth = kind == 'S' || kind == 'T';
    Vector2 a = isSmooth ? (continues ? Vector2(2 * at - control) : at) : point();
    control = isCubic ? point() : a;
    const Vector2 end = point();
    Vector2 b = control;
    if (!isCubic) {
      b = end + 2.0 / 3 * (a - end);
      a = at + 2.0 / 3 * (a - at);
    }
    addCubic(points, at, a, b, end);
    return end;
  }

  /// Handles the command A. Returns the arc's end.
  template <typename ReadPoint>
  Vector2 addArcCommand(std::vector<Vector2>& points, NumberScanner& scanner, const Vector2& at,
                        ReadPoint point) {
    const double rx = scanner.number(), ry = scanner.number(), turn = scanner.number();
    const bool isLarge = scanner.flag(), isPositive = scanner.flag();
    const Vector2 end = point();
    addEllipticalArc(points, at, end, rx, ry, turn * std::numbers::pi / 180, isLarge, isPositive);
    return end;
  }

  /// Handles all commands of path data (chapter 8.3).
  void addPathData(std::string_view data) {
    NumberScanner scanner(data, place_, counts_);
    std::vector<Vector2> points;
    Vector2 at(0, 0), first(0, 0), control(0, 0);
    char command = '\0', before = '\0';
    const auto finish = [&](bool isClosed) {
      if (points.size() > 1) add(std::move(points), isClosed);
      points.clear();
    };
    while (!scanner.isAtEnd()) {
      if (const char letter = scanner.letter()) {
        command = letter;
      } else if (command == '\0' || command == 'z' || command == 'Z') {
        throw inputErrorAt(place_, "path data begin without a command; begin it with M");
      }
      const bool isRelative = command >= 'a';
      const Vector2 base = isRelative ? at : Vector2(0, 0);
      const auto point = [&] {
        const double x = scanner.number();
        return Vector2(base + Vector2(x, scanner.number()));
      };
      const char kind = isRelative ? static_cast<char>(command - 'a' + 'A') : command;
      if (points.empty() && kind != 'M' && kind != 'Z') points.push_back(at);
      switch (kind) {
        case 'M':
          finish(false);
          at = first = point();
          points.push_back(at);
          command = isRelative ? 'l' : 'L';  // further pairs are lines
          break;
        case 'L':
          points.push_back(at = point());
          break;
        case 'H':
        case 'V':
          at[kind == 'V'] = base[kind == 'V'] + scanner.number();
          points.push_back(at);
          break;
        case 'C':
        case 'S':
        case 'Q':
        case 'T':
          at = addCurve(points, kind, kind == before || isSmoothAfter(kind, before), at, control,
                        point);
          break;
        case 'A':
          at = addArcCommand(points, scanner, at, point);
          break;
        case 'Z':
          finish(true);
          at = first;
          break;
        default:
          throw inputErrorAt(place_, fmt::format("'{}' is not a command of path data. Allowed: M L "
                                                 "H V C S Q T A Z",
                                                 command));
      }
      before = kind;
    }
    finish(false);
  }

  void addCubic(std::vector<Vector2>& points, const Vector2& from, const Vector2& a,
                const Vector2& b, const Vector2& to) {
    // |B''| <= 6 max |second differences|; the chord's error is |B''| / (8 n^2).
    const double bend = 6 * std::max((from - 2 * a + b).norm(), (a - 2 * b + to).norm());
    int pieces = std::clamp(static_cast<int>(std::ceil(std::sqrt(bend / (8 * localFlattening_)))),
                            bend > 0 ? 4 : 1, 400);
    pieces += bend > 0 ? pieces % 2 : 0;  // an S has its inflection in the middle
    for (int k = 1; k <= pieces; ++k) {
      const double t = static_cast<double>(k) / pieces, s = 1 - t;
      points.push_back(k == pieces ? to
                                   : Vector2(s * s * s * from + 3 * s * s * t * a +
                                             3 * s * t * t * b + t * t * t * to));
    }
    // A finer reading of a straight curve gives the same points.
    if (bend > 0) drawing_.flattening = flattening_;
  }

  void addEllipticalArc(std::vector<Vector2>& points, const Vector2& from, const Vector2& to,
                        double rx, double ry, double turn, bool isLarge, bool isPositive) {
    rx = std::abs(rx);
    ry = std::abs(ry);
    if (!(rx > 0) || !(ry > 0) || from == to) return points.push_back(to);
    const Eigen::Rotation2Dd rotation(turn);
    const Vector2 half = rotation.inverse() * Vector2(0.5 * (from - to));
    const double large = std::pow(half.x() / rx, 2) + std::pow(half.y() / ry, 2);
    if (large > 1) {
      rx *= std::sqrt(large);
      ry *= std::sqrt(large);
    }
    const double a = rx * rx * half.y() * half.y() + ry * ry * half.x() * half.x();
    const double root = std::sqrt(std::max(0.0, (rx * rx * ry * ry - a) / a));
    const double sign = isLarge == isPositive ? -root : root;
    const Vector2 inner(sign * rx * half.y() / ry, -sign * ry * half.x() / rx);
    const Vector2 centre = rotation * inner + 0.5 * (from + to);
    const auto angle = [&](const Vector2& v) { return std::atan2(v.y() / ry, v.x() / rx); };
    const double begin = angle(half - inner);
    double sweep = angle(-half - inner) - begin;
    if (isPositive && sweep < 0) sweep += 2 * std::numbers::pi;
    if (!isPositive && sweep > 0) sweep -= 2 * std::numbers::pi;
    curve(points, centre, rotation * Vector2(rx, 0), rotation * Vector2(0, ry), begin, sweep);
    points.back() = to;
  }

  /// If other lines have strokes, sets filled shapes apart: backgrounds, letters, logos, slots.
  void keepStrokes() {
    const auto isFill = [](const DrawnPath& path) { return path.colour.starts_with("fill "); };
    const auto isNothing = [](const DrawnPath& path) {
      return path.colour == "fill none" || path.colour == "fill transparent";
    };
    if (std::ranges::any_of(drawing_.paths, [&](const DrawnPath& p) { return !isFill(p); })) {
      for (const DrawnPath& path : drawing_.paths) {
        if (isFill(path) && !isNothing(path)) drawing_.shapes.push_back(path);
      }
      const auto count = std::erase_if(drawing_.paths, isFill);
      if (count > 0) drawing_.ignored[kShapeWithoutStroke] += static_cast<int>(count);
    } else if (!std::ranges::all_of(drawing_.paths, isNothing)) {
      std::erase_if(drawing_.paths, isNothing);
    }
  }

  const fs::path& file_;
  FileLocation place_;  // of the current element
  std::vector<std::ptrdiff_t> lineEnds_;
  double flattening_;  // metres
  double localFlattening_ = 1;
  Drawing drawing_;
  Vector2 view_ = Vector2::Zero();  // reference of percentages, user units
  std::unordered_map<std::string, pugi::xml_node> elements_;
  StyleSheet sheet_;
  pugi::xml_node styled_;  // the element of values_
  StyleValues values_;
  const SvgTransform* transform_ = nullptr;
  const SvgStyle* style_ = nullptr;
  DecimalCounts decimals_;
  DecimalCounts* counts_ = nullptr;  // of shapes only
  double largestScale_ = 0;
  int uses_ = 0;
};

}  // namespace

std::string normalColour(std::string_view text) {
  static const std::map<std::string, std::string> kNames = {
      {"black", "#000000"},   {"white", "#ffffff"},  {"red", "#ff0000"},    {"lime", "#00ff00"},
      {"blue", "#0000ff"},    {"green", "#008000"},  {"yellow", "#ffff00"}, {"cyan", "#00ffff"},
      {"aqua", "#00ffff"},    {"gray", "#808080"},   {"grey", "#808080"},   {"magenta", "#ff00ff"},
      {"fuchsia", "#ff00ff"}, {"orange", "#ffa500"}, {"purple", "#800080"}, {"navy", "#000080"}};
  std::string colour = lowerCase(trimmed(text));
  if (const auto known = kNames.find(colour); known != kNames.end()) return known->second;
  if (colour.size() == 4 && colour[0] == '#') {
    return {'#', colour[1], colour[1], colour[2], colour[2], colour[3], colour[3]};
  }
  if (!colour.starts_with("rgb")) return colour;
  std::array<int, 3> parts{};
  std::size_t part = 0;
  for (std::size_t at = colour.find('(') + 1; at < colour.size() && part < 3; ++part) {
    const std::size_t end = std::min(colour.find_first_of(",)/ ", at), colour.size());
    double value = std::strtod(colour.substr(at, end - at).c_str(), nullptr);
    if (colour.substr(at, end - at).ends_with('%')) value *= 2.55;
    parts[part] = static_cast<int>(std::lround(std::clamp(value, 0.0, 255.0)));
    at = std::min(colour.find_first_not_of(",)/ ", end), colour.size());
  }
  return fmt::format("#{:02x}{:02x}{:02x}", parts[0], parts[1], parts[2]);
}

Drawing readSvgDrawing(const fs::path& file, const std::string& text, double flattening) {
  if (text.starts_with("\x1f\x8b")) {
    throw inputErrorAt({file},
                       "this drawing is compressed. Unpack it with gunzip, or save it as "
                       "plain SVG");
  }
  return SvgReader(file, flattening).read(text);
}

}  // namespace kirireel::formats
