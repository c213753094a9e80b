// A page is a template (render/page/web/page.html) with its places filled in:
//
//     <!--title-->, <!--program-->, <!--count-->   words
//     <!--style-->, <!--scripts-->                 page.css; three.js and our scripts
//     <!--stages-->                                a canvas and a still picture for each run
//     <!--words-->                                 facts, warnings and embedded files of each run
//     <!--data-->                                  JSON: styles for both themes, colour map, runs
//
// The file contains everything, because it is sent by mail and opened from a disk, where browsers
// refuse to load neighbouring files. The still picture is for browsers without WebGL.
//
// Text from a model (names, warnings) is escaped; the JSON is in a script element, which ends at
// "</", so every "<" is written as \u003c.
#include "render/page/page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "render/output/output_folder.h"
#include "render/picture/grid.h"
#include "render/picture/png.h"
#include "render/record/pace.h"
#include "render/record/run_pictures.h"
#include "render/record/summary.h"
#include "sim/base/error.h"
#include "sim/base/words.h"
#include "sim/model/convex_parts.h"
#include "sim/model/model.h"
#include "sim/trajectory/run_curves.h"

namespace kirireel::page {
namespace {

/// In the order of their dependence.
constexpr const char* kScripts[] = {"three.min.js", "OrbitControls.js", "packed.js",    "bricks.js",
                                    "drawing.js",   "stage.js",         "colouring.js", "curves.js",
                                    "player.js",    "page.js"};

/// Maximum size of one embedded file, bytes.
constexpr std::uintmax_t kMaxEmbedded = 1u << 30;

using Words = std::vector<std::pair<std::string, std::string>>;

/// A template with each "<!--name-->" replaced. Names without a word are removed. The replacements
/// themselves are not searched.
std::string filled(std::string_view form, const Words& words) {
  std::string text;
  while (true) {
    const std::size_t begin = form.find("<!--");
    text += form.substr(0, begin);
    if (begin == std::string_view::npos) return text;
    const std::size_t end = form.find("-->", begin);
    const std::string_view name = form.substr(begin + 4, end - begin - 4);
    for (const auto& [known, word] : words) {
      if (known == name) text += word;
    }
    form.remove_prefix(end + 3);
  }
}

/// Every copy must contain its licence notice, which the minified file lacks.
constexpr const char* kThreeNotice =
    "<script>\n/*! three.js r111, copyright 2010-2020 three.js authors, MIT licence: "
    "https://threejs.org/license */\n</script>\n";

std::string scripts() {
  std::string text = kThreeNotice;
  for (const char* name : kScripts) {
    text += fmt::format("<script>\n{}\n</script>\n", embeddedFile(name));
  }
  return text;
}

/// JSON in which no HTML parser finds the end of its element.
std::string safeJson(const Json& json) {
  std::string text = jsonText(json);
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) {
    text.replace(at, 1, "\\u003c");
  }
  return text;
}

/// Pairs of a definition list.
std::string factsHtml(const Facts& facts) {
  std::string html;
  for (const auto& [what, value] : facts) {
    html += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", picture::markupText(what),
                        picture::markupText(value));
  }
  return html;
}

std::string warningsHtml(const std::vector<std::string>& warnings) {
  std::string html;
  for (const std::string& warning : warnings) {
    html += fmt::format("<p class=\"warning\">{}</p>\n", picture::markupText(warning));
  }
  return html;
}

/// Paints three small pictures.
std::string stageHtml(const trajectory::TrajectoryReader& run,
                      const picture::Appearance& appearance) {
  const std::string still = stillPicture(run, appearance);
  const std::string picture = base64(std::as_bytes(std::span(still)));
  return filled(embeddedFile("stage.html"),
                {{"name", picture::markupText(run.subject().model.name)}, {"picture", picture}});
}

/// The media type of a file by its ending, for browsers. Files with other endings are saved and not
/// shown.
std::string mediaType(const std::filesystem::path& file) {
  const std::pair<const char*, const char*> types[] = {
      {".mp4", "video/mp4"},   {".webm", "video/webm"}, {".png", "image/png"},
      {".apng", "image/apng"}, {".gif", "image/gif"},   {".svg", "image/svg+xml"}};
  for (const auto& [ending, type] : types) {
    if (endingOf(file) == ending) return type;
  }
  return "application/octet-stream";
}

/// A file within the page: a video, a picture, or a download link. Bytes become a data: URL (RFC
/// 2397), a third larger than the file.
std::string embeddedHtml(const std::filesystem::path& file) {
  const std::string bytes = readTextFile(file, "name files of the run with --embed", kMaxEmbedded);
  const std::string type = mediaType(file), name = picture::markupText(file.filename().string());
  const std::string source =
      fmt::format("data:{};base64,{}", type, base64(std::as_bytes(std::span(bytes))));
  if (type.starts_with("video/")) {
    return fmt::format("<video controls loop src=\"{}\" aria-label=\"{}\"></video>\n", source,
                       name);
  }
  if (type.starts_with("image/")) {
    return fmt::format("<img src=\"{}\" alt=\"{}\">\n", source, name);
  }
  return fmt::format("<a download=\"{0}\" href=\"{1}\">{0}</a>\n", name, source);
}

/// Embedded files are searched in the run's folder.
std::string wordsHtml(const trajectory::TrajectoryReader& run, const std::filesystem::path& folder,
                      const std::vector<std::string>& names) {
  std::string files;
  for (const std::string& name : names) files += embeddedHtml(folder / name);
  return filled(embeddedFile("words.html"),
                {{"name", picture::markupText(run.subject().model.name)},
                 {"facts", factsHtml(factsOf(run))},
                 {"warnings", warningsHtml(warningsOf(run))},
                 {"files", files}});
}

/// `dataBytes`: the part of the page that grows with its `states`. The message suggests a number of
/// states that would fit.
void requireSize(const std::string& page, std::size_t dataBytes, std::size_t states,
                 const WebPageSettings& settings) {
  const double most = 1e6 * settings.maxMegabytes, size = static_cast<double>(page.size());
  if (size <= most) return;
  // Fewer states are farther apart, and each takes a little more space. The data must shrink by the
  // excess; `share` is the fraction of them that may stay.
  const double share = 0.8 * ((most - size) / static_cast<double>(dataBytes) + 1);
  const auto fewer = static_cast<int>(share * static_cast<double>(states));
  const std::string thinner =
      fewer < 2 ? "" : fmt::format("--samples {} or fewer in place of {}, ", fewer, states);
  throw InputError(
      fmt::format("error: the page would have {:.1f} MB and may have {:g}; give {}{}a larger "
                  "--most-size",
                  size / 1e6, settings.maxMegabytes, thinner,
                  settings.states.exact ? "no --exact, or "
                  : thinner.empty()     ? ""
                                        : "or "));
}

}  // namespace

bool canMakePages() {
  return !embeddedFile("three.min.js").empty();
}

void requirePages() {
  if (canMakePages()) return;
  throw OutputError(
      "error: this program was built without three.js, which pages need; install Debian's "
      "libjs-three, then configure and build again");
}

std::string pageText(const std::vector<std::filesystem::path>& trajectories,
                     const WebPageSettings& settings) {
  requirePages();
  Json data = {
      {"light", styleJson(picture::Theme::Light, settings.appearance)},
      {"dark", styleJson(picture::Theme::Dark, settings.appearance)},
      {"theme", settings.appearance.theme == picture::Theme::Dark ? Json("dark") : Json(nullptr)},
      {"runs", Json::array()}};
  std::string title, stages, words;
  for (const std::filesystem::path& file : trajectories) {
    const trajectory::TrajectoryReader run(file);
    data["runs"].push_back(runJson(run, settings.appearance, settings.states));
    title += (title.empty() ? "" : " and ") + run.subject().model.name;
    stages += stageHtml(run, settings.appearance);
    words += wordsHtml(run, file.parent_path(), settings.embedded);
  }
  const std::string text = safeJson(data);
  const std::string page =
      filled(embeddedFile("page.html"), {{"title", picture::markupText(title)},
                                         {"program", "Kirireel " + record::programVersion()},
                                         {"count", std::to_string(trajectories.size())},
                                         {"style", std::string(embeddedFile("page.css"))},
                                         {"stages", stages},
                                         {"words", words},
                                         {"data", text},
                                         {"scripts", scripts()}});
  requireSize(page, text.size(), data["runs"][0]["states"]["times"].size(), settings);
  return page;
}

void writePage(const std::vector<std::filesystem::path>& trajectories,
               const WebPageSettings& settings) {
  requirePages();
  output::FileSet files(settings.folder, output::kContents);
  files.requireFree({kPageFile});
  writeTextFile(files.stage() / kPageFile, pageText(trajectories, settings));
  files.commit(std::vector<std::string>{kPageFile});
}

// ------------------------------------------------------------------------------------------------
// Makes the JSON of a run for stage.js and the other scripts. Its style (colours, lights, widths,
// cameras) comes from render/picture, so a page agrees with our pictures.
//
//     name; bricks: counts, corners, rises, triangles of concave ones; states: times, progress,
//     gap, error, poses, gaps, errors; joints: bricks, points; target; obstacles; plate; views;
//     curves
//
// Lengths are metres, times seconds. Bricks are in their own axes as floats: a float has 24 bits,
// 500 times finer than a step of positions.
//
// The states of a page are at equal fractions of motion and not of time. They are dense during
// motion.

namespace {

/// Size of each of the three pictures, pixels.
constexpr picture::FrameSize kStillSize{480, 360};
// Number of colours of a map: odd, to include the middle.
constexpr int kShades = 129;
constexpr std::array<double, 3> kStillShares = {0, 0.5, 1};

Json colourJson(picture::Colour colour) {
  return {colour.red, colour.green, colour.blue};
}

Json coloursJson(const picture::BrickColours& colours) {
  return {colourJson(colours.bottom), colourJson(colours.top), colourJson(colours.side)};
}

/// Directions are unit vectors in picture axes, strengths 0 to 1.
Json lightsJson(const picture::Style& style) {
  const auto light = [](const picture::Light& from) -> Json {
    return {{"direction", record::vectorJson(from.direction)}, {"strength", from.strength}};
  };
  return {{"ambient", style.ambient}, {"key", light(style.key)}, {"fill", light(style.fill)}};
}

/// A content of one brick: the data that a style needs independent of the run.
picture::PictureContent anyContent() {
  picture::PictureContent content;
  content.points = {Vector3::Zero(), Vector3::Ones()};
  return content;
}

/// Without settings of single tiles, which a style does not contain.
picture::Style styleOf(picture::Appearance appearance) {
  appearance.tileColours.clear();
  appearance.tileOpacities.clear();
  // Large enough that no line is thickened: the page does that for its own size.
  return picture::PictureSetup(appearance, anyContent(),
                               {picture::kMaxFrameSide, picture::kMaxFrameSide})
      .style();
}

void appendPoint(std::vector<float>& numbers, const Vector3& point) {
  for (int axis = 0; axis < 3; ++axis) numbers.push_back(static_cast<float>(point[axis]));
}

/// The corners of all polygons in sequence, and their number per polygon.
Json polygonsJson(const std::vector<model::Tile>& tiles) {
  std::vector<float> corners;
  std::vector<std::int32_t> counts;
  for (const model::Tile& tile : tiles) {
    counts.push_back(static_cast<std::int32_t>(tile.vertices.size()));
    for (const Vector3& vertex : tile.vertices) appendPoint(corners, vertex);
  }
  return {{"counts", packedArray(std::span<const std::int32_t>(counts))},
          {"corners", packedArray(std::span<const float>(corners))}};
}

/// The bricks' bottoms in their own axes, and the offsets to their tops. A brick is a prism: its
/// top is its bottom moved by one vector. One vector per brick is sufficient.
Json bricksJson(const std::vector<brick::Brick>& bricks) {
  std::vector<model::Tile> bottoms;
  std::vector<float> rises;
  Json triangles = Json::object();
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const brick::Brick& brick = bricks[i];
    bottoms.push_back({brick.bottom});
    appendPoint(rises, brick.top[0] - brick.bottom[0]);
    // The page itself divides convex polygons into fans.
    if (model::isConvexPolygon(brick.bottom, brick.normal)) continue;
    triangles[std::to_string(i)] = model::trianglesOf(brick.bottom, brick.normal);
  }
  Json json = polygonsJson(bottoms);
  json["rises"] = packedArray(std::span<const float>(rises));
  json["triangles"] = std::move(triangles);
  return json;
}

/// The positions of dots on joints: a brick, and a point in its axes. Uses the first brick of each
/// pivot.
Json joinsJson(const std::vector<brick::Pivot>& pivots) {
  std::vector<std::int32_t> bricks;
  std::vector<float> points;
  for (const brick::Pivot& pivot : pivots) {
    bricks.push_back(pivot.brickA);
    appendPoint(points, pivot.pointA);
  }
  return {{"bricks", packedArray(std::span<const std::int32_t>(bricks))},
          {"points", packedArray(std::span<const float>(points))}};
}

/// Metres from the brick's centre of mass, the origin of its axes.
double largestRadius(const std::vector<brick::Brick>& bricks) {
  double radius = 0;
  for (const brick::Brick& brick : bricks) {
    for (const auto* face : {&brick.bottom, &brick.top}) {
      for (const Vector3& corner : *face) radius = std::max(radius, corner.norm());
    }
  }
  return radius;
}

/// Collects the states of a page and their measures one by one. The content must outlive this
/// object.
class StateCollector {
 public:
  StateCollector(const picture::PictureContent& content, const PageStates& states)
      : content_(content), poses_(stepsFor(content, states)) {}

  void add(const trajectory::Sample& sample, double progress) {
    times_.push_back(sample.time);
    progress_.push_back(progress);
    gap_.push_back(sample.jointGap);
    error_.push_back(sample.targetError);
    poses_.add(sample.poses);
    // One value per brick and state; the page colours bricks by them.
    append(gaps_, trajectory::brickJointGaps(content_.pivots, sample.poses));
    if (content_.target) {
      append(errors_,
             trajectory::brickTargetErrors(*content_.target, content_.bricks, sample.poses));
    }
  }

  Json json() const {
    const bool hasTarget = content_.target.has_value();
    return {{"times", times_},
            {"progress", progress_},
            {"gap", gap_},
            {"error", hasTarget ? Json(error_) : Json(nullptr)},
            {"poses", poses_.packed()},
            {"gaps", packedMagnitudes(gaps_)},
            {"errors", hasTarget ? packedMagnitudes(errors_) : Json(nullptr)}};
  }

 private:
  static std::optional<PoseSteps> stepsFor(const picture::PictureContent& content,
                                           const PageStates& states) {
    if (states.exact) return std::nullopt;
    const Eigen::AlignedBox3d box = boundingBox(content.points);
    return finePoseSteps(box.center(), box.diagonal().norm(), largestRadius(content.bricks));
  }

  static void append(std::vector<double>& values, const std::vector<double>& more) {
    values.insert(values.end(), more.begin(), more.end());
  }

  const picture::PictureContent& content_;
  PosePacker poses_;
  std::vector<double> times_, progress_, gap_, error_;  ///< one per state
  std::vector<double> gaps_, errors_;                   ///< by state, one per brick
};

/// States between two samples are interpolated with closed joints, see Replay.
Json statesJson(const trajectory::TrajectoryReader& run, const picture::PictureContent& content,
                const PageStates& states) {
  const record::MotionCurve motion = record::motionOf(run);
  StateCollector collector(content, states);
  if (states.samples == 0) {
    for (std::size_t k = 0; k < run.times().size(); ++k) {
      collector.add(run.sample(k), motion.shareAt(run.times()[k]));
    }
    return collector.json();
  }
  record::Replay replay(run);
  for (int k = 0; k < states.samples; ++k) {
    const double share = static_cast<double>(k) / (states.samples - 1);
    // A run without motion has its states at equal times.
    const double time = motion.length() > 0 ? motion.timeAt(share) : share * motion.endTime();
    collector.add(replay.at(time), share);
  }
  return collector.json();
}

/// Whether a diagram of a group is useful: its values vary by more than rounding. For values that
/// are always small, such as gaps, the size is useful.
bool hasVisibleVariation(const trajectory::CurveGroup& group) {
  constexpr double kRounding = 1e-12;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const trajectory::Curve& curve : group.curves) {
    for (const double value : curve.values) {
      if (std::isnan(value)) continue;
      least = std::min(least, value);
      most = std::max(most, value);
    }
  }
  if (group.isLogarithmic) return most > 0;
  const double scale = group.unit.empty() ? 1 : std::max(std::abs(least), std::abs(most));
  return most - least > kRounding * scale;
}

/// The values with the digits that a diagram can show. Groups without useful diagrams are omitted;
/// missing values are null.
Json curvesJson(const trajectory::RunCurves& curves) {
  Json groups = Json::array();
  for (const trajectory::CurveGroup& group : curves.groups) {
    if (!group.hasLine() || !hasVisibleVariation(group)) continue;
    Json lines = Json::array();
    for (const trajectory::Curve& curve : group.curves) {
      // A spatial sheet has some measures only at its start.
      const auto missing =
          std::ranges::count_if(curve.values, [](double value) { return std::isnan(value); });
      if (2 * missing >= static_cast<long>(curve.values.size())) continue;
      Json values = Json::array();
      for (const double value : curve.values)
        // Six digits: a text of fewer digits is shorter as JSON too.
        values.push_back(std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr));
      lines.push_back({{"label", curve.name}, {"values", std::move(values)}});
    }
    if (lines.empty()) continue;
    groups.push_back({{"name", group.name},
                      {"unit", group.unit},
                      {"logarithmic", group.isLogarithmic},
                      {"lines", std::move(lines)}});
  }
  return groups;
}

/// Metres; null if there is no plate.
Json plateJson(const std::optional<picture::GroundPlate>& plate) {
  if (!plate) return nullptr;
  return {{"height", plate->height},
          {"centre", {plate->centre.x(), plate->centre.y()}},
          {"half_size", plate->halfSize},
          {"visible", plate->visible},
          {"shadow", plate->shadow}};
}

record::PictureSettings stillSettings(const picture::Appearance& appearance) {
  record::PictureSettings settings;
  settings.appearance = appearance;
  settings.size = kStillSize;
  return settings;
}

/// Shades of a colour map from its first end to the other.
Json mapJson(picture::ColourMap map, picture::Colour background) {
  Json shades = Json::array();
  for (int k = 0; k < kShades; ++k) {
    shades.push_back(
        coloursJson(picture::evenShades(picture::mapColour(map, k / (kShades - 1.0), background))));
  }
  return shades;
}

}  // namespace

Json styleJson(picture::Theme theme, const picture::Appearance& appearance) {
  picture::Appearance themed = appearance;
  themed.theme = theme;
  themed.colouring = picture::Colouring::Plain;
  const picture::Style style = styleOf(themed);
  themed.colouring = picture::Colouring::Displacement;
  return {{"background", colourJson(style.background)},
          {"brick", coloursJson(style.brick)},
          {"map", mapJson(appearance.map, style.background)},
          {"edge", colourJson(style.edge)},
          {"measure_edge", colourJson(styleOf(themed).edge)},
          {"ground", colourJson(style.ground)},
          {"scenery", colourJson(style.scenery)},
          {"shadow", colourJson(style.shadow)},
          {"shadow_source", record::vectorJson(style.shadowSource)},
          {"mark", colourJson(style.mark)},
          {"overlay", colourJson(style.overlay)},
          {"slit_width", appearance.outlines ? appearance.outlineWidths.slits : 0},
          {"silhouette_width", appearance.outlines ? appearance.outlineWidths.silhouettes : 0},
          {"mark_size", style.markSize},
          {"mark_lift", picture::kDotLift},
          {"overlay_width", style.overlayWidth},
          {"thinnest_overlay", picture::kThinnestOverlay},
          {"lights", lightsJson(style)},
          {"measure_lights", lightsJson(styleOf(themed))}};
}

Json runJson(const trajectory::TrajectoryReader& run, const picture::Appearance& appearance,
             const PageStates& states) {
  const trajectory::Subject& subject = run.subject();
  const picture::PictureContent content = record::contentOf(run, stillSettings(appearance));
  const picture::PictureSetup setup(appearance, content, kStillSize);
  Json statesOfPage = statesJson(run, content, states);
  Json curves = curvesJson(trajectory::curvesAt(trajectory::curvesOf(run), statesOfPage["times"]));
  return {{"name", subject.model.name},
          {"unit", {{"name", subject.model.unit.name}, {"metres", subject.model.unit.metres}}},
          {"bricks", bricksJson(subject.bricks)},
          {"states", std::move(statesOfPage)},
          {"joints", joinsJson(content.pivots)},
          {"target", content.target ? polygonsJson(*content.target) : Json(nullptr)},
          {"obstacles", polygonsJson(content.obstacles)},
          {"plate", plateJson(setup.style().plate)},
          {"views", camerasJson(appearance, content)},
          {"curves", std::move(curves)}};
}

std::string stillPicture(const trajectory::TrajectoryReader& run,
                         const picture::Appearance& appearance) {
  const record::PictureSettings settings = stillSettings(appearance);
  const record::MotionCurve motion = record::motionOf(run);
  picture::StatePainter painter(kStillSize, appearance, record::contentOf(run, settings));
  record::Replay replay(run);
  std::vector<picture::GridPicture> pictures;
  for (const double share : kStillShares) {
    const trajectory::Sample sample = replay.at(motion.timeAt(share));
    pictures.push_back({painter.paint({sample.time, sample.poses, {}, share}),
                        fmt::format("{:.0f}%", 100 * share)});
  }
  picture::GridStyle style;
  style.background = painter.setup().style().background;
  style.text = painter.setup().style().text;
  return picture::pngBytes(
      picture::composeGrid(pictures, {1, static_cast<int>(pictures.size())}, style));
}

// ------------------------------------------------------------------------------------------------
// Describes a run in text, only from trajectory.h5: a page can be made even without summary.json.
// "Findings" is the JSON text that record() stores in the trajectory (path, warnings).

namespace {

/// The findings of the run; empty if it has none.
Json findingsOf(const trajectory::TrajectoryReader& run) {
  const Json findings = parseJsonOrDiscard(run.end().findings);
  return findings.is_object() ? findings : Json::object();
}

/// The sides of the box along x, y and z.
std::string sizeText(const std::vector<model::Tile>& tiles, const LengthUnit& unit) {
  const Vector3 sides = model::boxOf(tiles).sizes() / unit.metres;
  return fmt::format("{:.4g} × {:.4g} × {:.4g} {}", sides.x(), sides.y(), sides.z(), unit.name);
}

/// Adds nothing for models without a target.
void addErrors(const trajectory::TrajectoryReader& run, Facts& facts) {
  const model::Model& model = run.subject().model;
  if (!model.target) return;
  const trajectory::Sample first = run.sample(0);
  const trajectory::Sample last = run.sample(run.times().size() - 1);
  facts.emplace_back("Distance from the target, start",
                     model::lengthInTiles(first.targetError, model, 3));
  facts.emplace_back("Distance from the target, end",
                     model::lengthInTiles(last.targetError, model, 3));
}

/// Joint gaps are known for every step, overlaps only for the samples.
void addAccuracy(const trajectory::TrajectoryReader& run, Facts& facts) {
  const model::Model& model = run.subject().model;
  double gap = 0, overlap = 0;
  for (const trajectory::StepRecord& step : run.steps()) gap = std::max(gap, step.jointGap);
  for (std::size_t k = 0; k < run.times().size(); ++k) {
    const trajectory::Sample sample = run.sample(k);
    gap = std::max(gap, sample.jointGap);
    overlap = std::max(overlap, sample.penetration);
  }
  facts.emplace_back("Widest joint gap", model::lengthInTiles(gap, model, 3));
  facts.emplace_back("Deepest overlap", model::lengthInTiles(overlap, model, 3));
}

}  // namespace

Facts factsOf(const trajectory::TrajectoryReader& run) {
  const trajectory::Subject& subject = run.subject();
  const model::Model& model = subject.model;
  Facts facts = {
      {"Sheet", counted(model.tiles.size(), "tile") + ", " + counted(model.joints.size(), "joint")},
      {"Thickness", model::lengthInTiles(subject.brickRule.thickness, model, 3)},
      {"Size, start", sizeText(model.tiles, model.unit)}};
  const trajectory::Sample last = run.sample(run.times().size() - 1);
  facts.emplace_back("Size, end",
                     sizeText(brick::bottomTiles(subject.bricks, last.poses), model.unit));
  facts.emplace_back("Simulated time", fmt::format("{:.4g} s", run.times().back()));
  if (!run.end().events.empty()) facts.emplace_back("End", run.end().events.back().text);
  const Json findings = findingsOf(run);
  if (findings.contains("path")) {
    facts.emplace_back("Path", findings["path"].value("reason", ""));
  }
  addErrors(run, facts);
  addAccuracy(run, facts);
  if (!run.hasMechanics()) facts.emplace_back("Energies and forces", trajectory::kNoMechanics);
  // A fact without a value is omitted.
  std::erase_if(facts, [](const auto& fact) { return fact.second.empty(); });
  return facts;
}

std::vector<std::string> warningsOf(const trajectory::TrajectoryReader& run) {
  const Json findings = findingsOf(run);
  return findings.value("warnings", std::vector<std::string>());
}

// ------------------------------------------------------------------------------------------------
// A page's canvas may have any shape, and the camera that shows the whole run depends on it. For
// each view this code computes five cameras with the fit of our own pictures. The page uses the
// widest one that fits in its canvas. A wider canvas shows more at the sides.
//
// A camera is eye, centre and up (metres, world axes) with the vertical field of view (radians) or
// the height of the visible region (metres).

namespace {

/// Sizes with the aspects of typical canvases, from an upright telephone to a wide screen. The last
/// is that of our pictures.
constexpr std::array<picture::FrameSize, 5> kSizes = {
    {{450, 800}, {600, 800}, {800, 800}, {800, 600}, {1280, 720}}};

/// Metres and radians.
Json cameraJson(const picture::Camera& camera, double aspect) {
  return {{"aspect", aspect},
          {"eye", record::vectorJson(camera.eye)},
          {"centre", record::vectorJson(camera.centre)},
          {"up", record::vectorJson(camera.up)},
          {"orthographic", camera.orthographic},
          {"field_of_view", camera.fieldOfView},
          {"view_height", camera.viewHeight}};
}

/// From the narrowest canvas to the widest.
Json viewJson(const char* name, const picture::Appearance& appearance,
              const picture::PictureContent& content) {
  Json fits = Json::array();
  for (const picture::FrameSize size : kSizes) {
    const picture::PictureSetup setup(appearance, content, size);
    fits.push_back(cameraJson(setup.camera({0, content.start, {}}), size.aspect()));
  }
  return {{"name", name}, {"fits", std::move(fits)}};
}

}  // namespace

Json camerasJson(const picture::Appearance& appearance, const picture::PictureContent& content) {
  Json views = {viewJson("Default", appearance, content)};
  const std::pair<const char*, picture::ViewAngles> others[] = {
      {"Top", picture::kTopView},
      {"Front", picture::kFrontView},
      {"Side", picture::kRightView},
      {"Corner", picture::kIsometricView}};
  for (const auto& [name, view] : others) {
    picture::Appearance other = appearance;
    other.camera.view = view;
    views.push_back(viewJson(name, other, content));
  }
  return views;
}

// ------------------------------------------------------------------------------------------------
// Encodes poses as text. Positions are counted in steps of s = size / 32768 (metres) from an
// origin, components of quaternions in steps of r = s / (2 radius). A corner at the distance
// `radius` from its brick's centre then moves by at most
//
//     sqrt(3) s / 2              by rounding the position,
//     2 radius (2 r / 2) = s     by rounding the four parts of the quaternion, half a step each,
//
// together below 1.9 s.
//
// Rounded entries e(k) of one number over the samples k are stored as second differences, which are
// exactly invertible in whole numbers:
//   d(k) = e(k) - 2 e(k-1) + e(k-2)
// Motion is smooth, so d is a few steps, fits into 16 bits and compresses well. Zigzag coding maps
// 0, -1, 1, -2 to 0, 1, 2, 3 and so on: the upper bytes of small numbers of either sign are zero.
//
// The text is base 64 of zlib (RFC 1950) of planes of bytes. Browsers have a decompressor but no
// HDF5, and JSON numbers would take several times as much.

namespace {

/// Number of position steps across the visible region.
constexpr double kPositionSteps = 32768;

template <typename Number>
Json packedAs(const char* type, std::span<const Number> entries) {
  const std::span<const std::byte> bytes = std::as_bytes(entries);
  std::vector<std::byte> planes;
  planes.reserve(bytes.size());
  // Byte `plane` of every entry; little-endian, so the last plane is the highest.
  for (std::size_t plane = 0; plane < sizeof(Number); ++plane) {
    for (std::size_t k = plane; k < bytes.size(); k += sizeof(Number)) planes.push_back(bytes[k]);
  }
  const std::string small = compressed(planes);
  return {
      {"type", type}, {"count", entries.size()}, {"data", base64(std::as_bytes(std::span(small)))}};
}

/// Differences wrap around as 32-bit numbers do, here and in the page.
std::int32_t zigzag(std::int64_t difference) {
  const auto wrapped = static_cast<std::int32_t>(static_cast<std::uint32_t>(difference));
  // 2 d for d >= 0, -2 d - 1 below; the arithmetic shift gives all ones for negative numbers.
  return static_cast<std::int32_t>((static_cast<std::uint32_t>(wrapped) << 1) ^
                                   static_cast<std::uint32_t>(wrapped >> 31));
}

}  // namespace

Json packedArray(std::span<const float> entries) {
  return packedAs("f32", entries);
}
Json packedArray(std::span<const double> entries) {
  return packedAs("f64", entries);
}
Json packedArray(std::span<const std::int32_t> entries) {
  return packedAs("i32", entries);
}
Json packedArray(std::span<const std::uint16_t> entries) {
  return packedAs("u16", entries);
}
Json packedArray(std::span<const std::uint8_t> entries) {
  return packedAs("u8", entries);
}

PoseSteps finePoseSteps(const Vector3& origin, double size, double radius) {
  const double step = size / kPositionSteps;
  // Half a step in each of four parts turns by at most two steps.
  return {origin, step, 0.5 * step / radius};
}

void PosePacker::add(const Poses& poses) {
  // The first sample has itself as predecessor.
  if (before_.empty()) before_ = poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    // q and -q are the same rotation; the nearer one to the previous sample is stored.
    before_[i] = {poses[i].position, poses[i].rotation.dot(before_[i].rotation) < 0
                                         ? Quaternion(-poses[i].rotation.coeffs())
                                         : poses[i].rotation};
  }
  const PoseSteps steps = steps_.value_or(PoseSteps{});
  std::vector<double> entries;
  entries.reserve(7 * poses.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (const Pose& pose : before_) {
      entries.push_back((pose.position[axis] - steps.origin[axis]) / steps.position);
    }
  }
  for (const int part : {3, 0, 1, 2}) {  // Eigen keeps x, y, z, w
    for (const Pose& pose : before_) {
      entries.push_back(pose.rotation.coeffs()[part] / steps.rotation);
    }
  }
  if (steps_) {
    addRounded(entries);
  } else {
    exact_.insert(exact_.end(), entries.begin(), entries.end());
  }
}

void PosePacker::addRounded(const std::vector<double>& entries) {
  // Limits the positions of bricks that fly away to the range of numbers.
  constexpr double kMax = std::numeric_limits<std::int32_t>::max();
  last_.resize(entries.size());
  lastButOne_.resize(entries.size());
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const std::int64_t entry = std::llround(std::clamp(entries[k], -kMax, kMax));
    // last_ and lastButOne_ are zero before the first sample.
    differences_.push_back(zigzag(entry - 2 * last_[k] + lastButOne_[k]));
    lastButOne_[k] = last_[k];
    last_[k] = entry;
  }
}

/// In 16 bits if all of them fit, which is faster to unpack.
Json PosePacker::packedDifferences() const {
  const bool areSmall = std::ranges::all_of(differences_, [](std::int32_t difference) {
    return difference >= 0 && difference <= std::numeric_limits<std::uint16_t>::max();
  });
  if (!areSmall) return packedArray(std::span<const std::int32_t>(differences_));
  const std::vector<std::uint16_t> small(differences_.begin(), differences_.end());
  return packedArray(std::span<const std::uint16_t>(small));
}

Json PosePacker::packed() const {
  const PoseSteps steps = steps_.value_or(PoseSteps{});
  return {{"exact", !steps_.has_value()},
          {"origin", record::vectorJson(steps.origin)},
          {"position_step", steps.position},
          {"rotation_step", steps.rotation},
          {"entries", steps_ ? packedDifferences() : packedArray(std::span<const double>(exact_))}};
}

Json packedMagnitudes(std::span<const double> values) {
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (const double value : values) {
    most = std::max(most, value);
    if (value > 0) least = std::min(least, value);
  }
  if (most == 0) least = most = 1;
  // If all values are equal the range is 0, and any small number is correct.
  const double range = std::max(std::log(most / least), 1e-12);
  std::vector<std::uint8_t> codes;
  codes.reserve(values.size());
  for (const double value : values) {
    const double share = value > 0 ? std::log(value / least) / range : 0;
    // 1 for the least, 255 for the largest.
    codes.push_back(value > 0 ? static_cast<std::uint8_t>(1 + std::lround(254 * share)) : 0);
  }
  return {{"least", least},
          {"most", most},
          {"codes", packedArray(std::span<const std::uint8_t>(codes))}};
}

}  // namespace kirireel::page
