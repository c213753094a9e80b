// Reads the lines of SVG files (W3C, Scalable Vector Graphics 1.1, chapters 5 to 10).
//
// The tree is traversed once with a transform and a style that children inherit. Lengths: the
// root's width and height with units relative to its viewBox give metres per user unit. Without
// them a user unit is a pixel of 1/96 inch. Style: presentation attributes, then style sheet rules
// (selectors of one tag, class or id), then the style attribute. Elliptical arcs are converted to
// their centre form (appendix F.6.5).
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <unordered_map>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <pugixml.hpp>

#include "sim/base/error.h"
#include "sim/model/drawing.h"

namespace kirireel::model {
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

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kSvgBlank);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(kSvgBlank) - begin + 1);
}

/// The name of a tag or attribute without its namespace.
std::string localName(const char* name) {
  const std::string whole(name);
  const std::size_t colon = whole.rfind(':');
  return lowerCase(colon == whole.npos ? whole : whole.substr(colon + 1));
}

/// Declarations "name: value; ..." by name.
std::map<std::string, std::string> declarations(std::string_view text) {
  std::map<std::string, std::string> found;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(';', at), text.size());
    const std::string_view one = text.substr(at, end - at);
    if (const std::size_t colon = one.find(':'); colon != one.npos) {
      std::string_view value = trimmed(one.substr(colon + 1));
      if (const std::size_t mark = value.find('!'); mark != value.npos) {
        value = trimmed(value.substr(0, mark));
      }
      found[lowerCase(trimmed(one.substr(0, colon)))] = std::string(value);
    }
    at = end + 1;
  }
  return found;
}

/// Scanner for path data and lists of numbers.
class NumberScanner {
 public:
  NumberScanner(std::string_view text, const fs::path& file, DecimalCounts* decimals = nullptr)
      : text_(text), file_(file), decimals_(decimals) {}

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
    return drawnNumber(text_.substr(begin, at_ - begin), file_, decimals_);
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
  const fs::path& file_;
  DecimalCounts* decimals_;
  std::size_t at_ = 0;
};

/// Inherited properties.
struct SvgStyle {
  std::string stroke = "none";
  std::string fill = "#000000";
  bool isVisible = true;
  bool isDashed = false;
  std::string layer;
  std::vector<std::string> names;
};

class SvgReader {
 public:
  SvgReader(const fs::path& file, double flattening) : file_(file), flattening_(flattening) {}

  Drawing read(const std::string& text) {
    pugi::xml_document document;
    const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size());
    if (!parsed) {
      const auto lines = std::count(
          text.begin(), text.begin() + std::min<std::ptrdiff_t>(parsed.offset, std::ssize(text)),
          '\n');
      throw inputErrorAt({file_, static_cast<int>(lines) + 1},
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
      if (localName(child.name()) == "style") addRules(child);
      collect(child, depth + 1);
    }
  }

  void addRules(const pugi::xml_node& style) {
    std::string sheet;
    for (const pugi::xml_node& part : style.children()) sheet += part.value();
    for (std::size_t at = sheet.find("/*"); at != sheet.npos; at = sheet.find("/*", at)) {
      const std::size_t end = sheet.find("*/", at);
      sheet.erase(at, end == sheet.npos ? sheet.npos : end + 2 - at);
    }
    for (std::size_t at = 0; at < sheet.size();) {
      const std::size_t open = sheet.find('{', at);
      const std::size_t close = sheet.find('}', open == sheet.npos ? at : open);
      if (open == sheet.npos || close == sheet.npos) return;
      const auto values = declarations(std::string_view(sheet).substr(open + 1, close - open - 1));
      const std::string_view selectors = std::string_view(sheet).substr(at, open - at);
      for (std::size_t begin = 0; begin <= selectors.size();) {
        const std::size_t end = std::min(selectors.find(',', begin), selectors.size());
        const std::string selector(trimmed(selectors.substr(begin, end - begin)));
        for (const auto& [name, value] : values) rules_[selector][name] = value;
        begin = end + 1;
      }
      at = close + 1;
    }
  }

  /// A property of an element; absent if the element does not set it.
  std::optional<std::string> property(const pugi::xml_node& node, const std::string& name) const {
    const auto inlined = declarations(node.attribute("style").value());
    if (const auto found = inlined.find(name); found != inlined.end()) return found->second;
    const auto ruled = [&](const std::string& selector) -> std::optional<std::string> {
      const auto rule = rules_.find(selector);
      if (rule == rules_.end()) return std::nullopt;
      const auto value = rule->second.find(name);
      return value == rule->second.end() ? std::nullopt : std::optional(value->second);
    };
    const std::string tag = localName(node.name());
    if (!rules_.empty()) {
      if (auto value = ruled(fmt::format("#{}", node.attribute("id").value()))) return value;
      for (const std::string& one : classesOf(node)) {
        if (auto value = ruled(fmt::format("{}.{}", tag, one))) return value;
        if (auto value = ruled("." + one)) return value;
      }
      if (auto value = ruled(tag)) return value;
      if (auto value = ruled("*")) return value;
    }
    const pugi::xml_attribute own = node.attribute(name.c_str());
    return own ? std::optional<std::string>(own.value()) : std::nullopt;
  }

  static std::vector<std::string> classesOf(const pugi::xml_node& node) {
    std::vector<std::string> classes;
    const std::string_view all = node.attribute("class").value();
    for (std::size_t at = all.find_first_not_of(kSvgBlank); at != all.npos;) {
      const std::size_t end = std::min(all.find_first_of(kSvgBlank, at), all.size());
      classes.emplace_back(all.substr(at, end - at));
      at = all.find_first_not_of(kSvgBlank, end);
    }
    return classes;
  }

  SvgStyle styleOf(const pugi::xml_node& node, const SvgStyle& parent) const {
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
    if (const auto seen = property(node, "visibility")) {
      style.isVisible = *seen != "hidden" && *seen != "collapse";
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
    for (const std::string& name : classesOf(node)) style.names.push_back(lowerCase(name));
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
    std::size_t end = text.size();
    while (end > 0 &&
           (std::isalpha(static_cast<unsigned char>(text[end - 1])) || text[end - 1] == '%')) {
      --end;
    }
    const std::string unit = lowerCase(text.substr(end));
    const double value = drawnNumber(trimmed(text.substr(0, end)), file_, counts_);
    if (unit.empty()) return value;
    if (unit == "%") return value / 100 * whole;
    const auto known = kSvgUnits.find(unit);
    if (known == kSvgUnits.end()) {
      throw inputErrorAt(
          {file_},
          fmt::format("the length '{}' has an unknown unit. Use one of mm, cm, in, pt, pc, px",
                      shown(text, 24)));
    }
    return value * known->second / kPixel;
  }

  std::vector<double> numbers(std::string_view text) {
    NumberScanner scanner(text, file_);
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

  SvgTransform parsedTransform(std::string_view text) {
    SvgTransform whole = SvgTransform::Identity();
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t open = text.find('(', at);
      const std::size_t close = text.find(')', at);
      if (open == text.npos || close == text.npos || close < open) break;
      std::string_view name = trimmed(text.substr(at, open - at));
      while (name.starts_with(',')) name = trimmed(name.substr(1));
      std::vector<double> n = numbers(text.substr(open + 1, close - open - 1));
      const std::size_t given = n.size();
      n.resize(6, 0);
      SvgTransform one = SvgTransform::Identity();
      const auto turn = [](double degrees) {
        return Eigen::Rotation2Dd(degrees * std::numbers::pi / 180);
      };
      if (name == "matrix" && given == 6)
        one.matrix() << n[0], n[2], n[4], n[1], n[3], n[5], 0, 0, 1;
      else if (name == "translate")
        one.translate(Vector2(n[0], n[1]));
      else if (name == "scale")
        one.scale(Vector2(n[0], given > 1 ? n[1] : n[0]));
      else if (name == "rotate")
        one.translate(Vector2(n[1], n[2])).rotate(turn(n[0])).translate(Vector2(-n[1], -n[2]));
      else if (name == "skewX")
        one.matrix()(0, 1) = std::tan(n[0] * std::numbers::pi / 180);
      else if (name == "skewY")
        one.matrix()(1, 0) = std::tan(n[0] * std::numbers::pi / 180);
      else
        throw inputErrorAt({file_}, fmt::format("'{}' is not a transform of SVG", shown(name, 24)));
      whole = whole * one;
      at = close + 1;
    }
    return whole;
  }

  void walkChildren(const pugi::xml_node& node, const SvgTransform& transform,
                    const SvgStyle& style, int depth) {
    if (depth > kDeepestElement) {
      throw inputErrorAt({file_},
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
    if (const auto display = property(node, "display"); display && *display == "none") {
      ++drawing_.ignored["hidden element"];
      return;
    }
    const SvgStyle style = styleOf(node, parent);
    const SvgTransform transform =
        outer * parsedTransform(property(node, "transform").value_or(""));
    if (tag == "g" || tag == "a" || tag == "switch") {
      walkChildren(node, transform, style, depth + 1);
    } else if (tag == "svg") {
      walkViewport(node, transform, style, depth);
    } else if (tag == "use") {
      walkUse(node, transform, style, depth);
    } else if (!addShape(node, tag, transform, style)) {
      ++drawing_.ignored[tag == "tspan" || tag == "flowroot" ? "text" : oneLine(tag)];
    }
  }

  void walkViewport(const pugi::xml_node& node, const SvgTransform& outer, const SvgStyle& style,
                    int depth) {
    const Vector2 view = view_;
    SvgTransform transform = outer;
    transform.translate(Vector2(length(node, "x", view.x()), length(node, "y", view.y())));
    const double width = length(node, "width", view.x(), view.x());
    const double height = length(node, "height", view.y(), view.y());
    const SvgTransform inner = viewTransform(node, width, height);
    const std::vector<double> box = numbers(node.attribute("viewBox").value());
    if (box.size() == 4 &&
        !std::string_view(node.attribute("preserveAspectRatio").value()).starts_with("none")) {
      // Excess length in one direction is split equally, as in xMidYMid.
      const Vector2 used(inner.linear()(0, 0) * box[2], inner.linear()(1, 1) * box[3]);
      transform.translate(0.5 * (Vector2(width, height) - used));
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
    const auto found = elements_.find(reference.empty() ? "" : reference.substr(1));
    if (found == elements_.end() || depth >= kDeepestElement || ++uses_ > 200'000) {
      throw inputErrorAt({file_},
                         fmt::format("a 'use' names '{}', which does not exist or contains itself",
                                     shown(reference, 24)));
    }
    transform.translate(Vector2(length(node, "x", view_.x()), length(node, "y", view_.y())));
    const std::string tag = localName(found->second.name());
    if (tag == "symbol") {
      walkViewport(found->second, transform, styleOf(found->second, style), depth + 1);
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
      NumberScanner scanner(node.attribute("points").value(), file_, counts_);
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
    const bool isFilled = style_->stroke == "none" || style_->stroke == "transparent";
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
    NumberScanner scanner(data, file_, counts_);
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
        throw inputErrorAt({file_}, "path data begin without a command; begin it with M");
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
          throw inputErrorAt({file_}, fmt::format("'{}' is not a command of path data", command));
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
    // A straight curve needs no second reading.
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

  /// If other lines have strokes, removes filled shapes: backgrounds, letters, logos.
  void keepStrokes() {
    const auto isFill = [](const DrawnPath& path) { return path.colour.starts_with("fill "); };
    const auto isNothing = [](const DrawnPath& path) {
      return path.colour == "fill none" || path.colour == "fill transparent";
    };
    if (std::ranges::any_of(drawing_.paths, [&](const DrawnPath& p) { return !isFill(p); })) {
      const auto count = std::erase_if(drawing_.paths, isFill);
      if (count > 0) drawing_.ignored["shape without a stroke"] += static_cast<int>(count);
    } else if (!std::ranges::all_of(drawing_.paths, isNothing)) {
      std::erase_if(drawing_.paths, isNothing);
    }
  }

  const fs::path& file_;
  double flattening_;  // metres
  double localFlattening_ = 1;
  Drawing drawing_;
  Vector2 view_ = Vector2::Zero();  // reference of percentages, user units
  std::unordered_map<std::string, pugi::xml_node> elements_;
  std::map<std::string, std::map<std::string, std::string>> rules_;
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
  return SvgReader(file, flattening).read(text);
}

}  // namespace kirireel::model
