// Each format is one row of the table exportFormats(): its name, the endings of its files, and
// their writers. The command line, the help and the list of exported files come from this table.
// isExported() uses it to recognise files, so an export never overwrites other files. Files are
//   of a state        state_####ENDING, written from one sample;
//   of elements     the same, or sheetENDING for the flat start with necks: decks, jobs and
//                   meshes. They share one mesh of elements and are written together
//                   (writeElements());
//   of a deployment   one file with its own name, written from the whole trajectory.
//
// An export selects states (export.h), reads each state's sample once and passes it to all formats.
// The files of the whole deployment follow. After an error all written files are removed again
// (WrittenFiles). exportStates() moves files into place only when all are complete (FileSet).
//
// A mesh of elements is made once per state, for decks, Gmsh and the jobs. A drive job has its own
// coarse mesh if tiles stay rigid in the motion.
#include "render/export/export.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "render/fea/job.h"
#include "render/fea/neck_solid.h"
#include "render/fea/outside_program.h"
#include "render/output/output_folder.h"
#include "render/writers/flat_sheet.h"
#include "render/writers/mesh.h"
#include "render/writers/vtk.h"
#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/base/geometry.h"
#include "sim/formats/model_formats.h"
#include "sim/formats/read_model.h"
#include "sim/formats/text_table.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/run_curves.h"

namespace kirireel::exports {
namespace {

std::vector<writers::PatternLine> patternOf(const model::Model& model,
                                            const ExportSettings& settings) {
  const double width = settings.hingeWidth;
  return writers::cutPattern(model, width != 0 ? std::optional(width) : std::nullopt);
}

class Exporter;

/// A file of a format. Files without a writer are made from elements.
struct ExportFile {
  const char* name;  ///< whole name of a deployment's file, else the part after "state_0042"
  /// Writes a state's file.
  void (*writeState)(Exporter&, const trajectory::Sample&, const std::filesystem::path&) = nullptr;
  /// Writes the file of a whole deployment.
  void (*writeDeployment)(Exporter&, const std::filesystem::path&) = nullptr;
  /// Whether these settings request the file; null: always.
  bool (*isRequested)(const fea::DeckSettings&) = nullptr;
  /// Writes the file of the flat start with necks, which replaces the states' files.
  void (*writeNecks)(Exporter&, const std::filesystem::path&) = nullptr;

  bool showsElements() const { return !writeState && !writeDeployment; }
};

/// A format: its name on the command line, and its files.
struct ExportFormat {
  const char* name;
  std::vector<ExportFile> files;
  /// Throws if the format does not support the model in any run; null: it supports all models.
  void (*require)(const model::Model&, const ExportSettings&) = nullptr;
  bool hasOwnUnit = false;  ///< ignores ExportSettings::unit
};

/// All formats, in the order of the help.
const std::vector<ExportFormat>& exportFormats();

/// Throws InputError if no format has this name.
const ExportFormat& exportFormat(const std::string& name) {
  const auto found = std::ranges::find(exportFormats(), name, &ExportFormat::name);
  if (found != exportFormats().end()) return *found;
  throw InputError(fmt::format("error: there is no format {}; give {}", name,
                               fmt::join(exportFormatNames(), ", ")));
}

/// Sheets with necks are the start. Other states need a format that has them.
void requireStart(const ExportSettings& settings) {
  if (settings.elements.joints != fea::JointStyle::Neck) return;
  const auto isOfStates = [](const ExportFile& file) {
    return !file.writeNecks && !file.showsElements();
  };
  for (const std::string& name : settings.formats) {
    if (std::ranges::any_of(exportFormat(name).files, isOfStates)) return;
  }
  const auto later = std::ranges::find_if(
      settings.states, [](const std::string& name) { return name != "initial"; });
  if (later == settings.states.end() || settings.states == ExportSettings{}.states) return;
  throw InputError(
      fmt::format("error: --states {} has no effect, because a sheet with necks has only the "
                  "start. Remove --states or choose other --joints",
                  *later));
}

/// Some formats have a unit of their own.
void requireUnitUse(const ExportSettings& settings) {
  const auto hasOwnUnit = [](const std::string& name) { return exportFormat(name).hasOwnUnit; };
  if (!settings.unit || settings.formats.empty()) return;
  if (!std::ranges::all_of(settings.formats, hasOwnUnit)) return;
  throw InputError(fmt::format(
      "error: --export-unit has no effect on {}. Remove --export-unit, or set --deck-unit for inp",
      fmt::join(settings.formats, " and ")));
}

void requireDifferent(const std::vector<std::string>& formats) {
  for (auto format = formats.begin(); format != formats.end(); ++format) {
    // Searches duplicates of each format after it; the list is short.
    if (std::find(format + 1, formats.end(), *format) == formats.end()) continue;
    throw InputError(fmt::format(
        "error: format {} is given twice, so its files would have the same name; remove one",
        *format));
  }
}

bool hasFormat(const ExportSettings& settings, const char* format) {
  return std::ranges::find(settings.formats, format) != settings.formats.end();
}

constexpr const char* kMeshFile = "_mesh.inp";
constexpr const char* kJobFile = "_job.inp";
constexpr const char* kDriveFile = "_drive.inp";
constexpr const char* kDriveMesh = "_drive_mesh.inp";
constexpr const char* kBucklingFile = "_buckle.inp";
constexpr const char* kMapFile = "_map.inp";
constexpr const char* kGmshFile = ".msh";
constexpr const char* kPeriodicFile = "_periodic.inp";
constexpr const char* kPeriodicMesh = "_periodic_mesh.inp";

// Formats with files of elements.
constexpr const char* kDeck = "inp";
constexpr const char* kGmsh = "msh";

bool exportsElements(const ExportSettings& settings) {
  return hasFormat(settings, kDeck) || hasFormat(settings, kGmsh);
}

/// Start of the names of a state's files.
std::string fileStem(const std::string& label) {
  return "state_" + label;
}

/// Start of the names of files of the flat start with necks.
constexpr const char* kSheet = "sheet";

/// The rule with the tile numbers of the model's file, for messages. Planar files are one-based,
/// folders zero-based.
fea::ElementRule numbered(fea::ElementRule rule, const model::Model& model) {
  rule.countsFrom = model.fileOrder.countsFrom;
  rule.unit = model.unit;
  return rule;
}

/// The elements of a state, with the run's springs at hinges.
fea::ElementMesh stateMesh(const trajectory::Subject& subject, const Poses& poses,
                           const fea::ElementRule& rule) {
  fea::ElementMesh mesh = fea::makeElementMesh(subject.bricks, subject.model.joints, poses, rule);
  // Springs that decks cannot have are left out; exportWarnings() reports them.
  fea::addHingeSprings(mesh, subject.bricks, brick::hingeSpringsOf(subject.pairForces), poses);
  return mesh;
}

/// The deepest overlap of two bricks that are not one part of the mesh, metres.
double overlapIn(const trajectory::Subject& subject, const trajectory::Sample& sample) {
  std::set<std::pair<int, int>> parts;
  for (const model::Joint& joint : subject.model.joints) {
    if (joint.kind == model::JointKind::Fixed) {
      parts.insert(std::minmax(joint.a.tile, joint.b.tile));
    }
  }
  if (parts.empty()) return sample.penetration;
  for (const trajectory::Penetration& pair :
       trajectory::penetrationsOutsidePivots(subject.bricks, {}, 0, sample.poses, 0)) {
    if (!parts.contains({pair.brickA, pair.brickB})) return pair.depth;
  }
  return 0;
}

/// Whether a drive has its own mesh: the user chose no elements, and tiles on ideal hinges are
/// rigid in the motion. Coarse elements need a tenth of the increments and a hundredth of the time.
/// They have no flanks apart from joints, which contact would need.
bool hasDriveMesh(const fea::ElementRule& rule, const fea::DeckSettings& decks) {
  if (decks.contactFriction) return false;
  const bool isHinged =
      rule.joints == fea::JointStyle::Shared || rule.joints == fea::JointStyle::Equation;
  return isHinged && rule.family == fea::ElementFamily::Solid && rule.perEdge == 0 &&
         rule.size == 0;
}

/// Files written to a folder. They are removed unless keep() is called.
class WrittenFiles {
 public:
  explicit WrittenFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ~WrittenFiles() {
    std::error_code ignored;
    for (const std::string& name : names_) std::filesystem::remove(folder_ / name, ignored);
  }
  WrittenFiles(const WrittenFiles&) = delete;
  WrittenFiles& operator=(const WrittenFiles&) = delete;

  /// Path of the file with this name.
  std::filesystem::path add(const std::string& name) {
    names_.push_back(name);
    return folder_ / name;
  }

  std::vector<std::string> keep() { return std::exchange(names_, {}); }

 private:
  std::filesystem::path folder_;
  std::vector<std::string> names_;
};

/// Writes all formats. Reads each state's sample once. The constructor refuses impossible jobs
/// before any file is written.
class Exporter {
 public:
  Exporter(const trajectory::TrajectoryReader& trajectory, const ExportSettings& settings,
           WrittenFiles& files)
      : trajectory_(trajectory),
        subject_(trajectory.subject()),
        settings_(settings),
        elements_(numbered(settings.elements, subject_.model)),
        states_(chooseStates(trajectory, settings.states)),
        files_(files) {
    requireStart(settings_);
    requireUnitUse(settings_);
    requireLaterSamples();
    requireMap();
  }

  /// First sheets with necks, then each state, then files of the whole deployment.
  void writeAll() {
    if (isNecked()) {
      writeNeckSheet();
      for (const std::string& format : settings_.formats) {
        for (const ExportFile& file : exportFormat(format).files) {
          if (file.writeNecks) file.writeNecks(*this, files_.add(std::string(kSheet) + file.name));
        }
      }
    }
    for (const ChosenState& state : states_) writeState(state, trajectory_.sample(state.sample));
    for (const std::string& format : settings_.formats) {
      for (const ExportFile& file : exportFormat(format).files) {
        if (file.writeDeployment) file.writeDeployment(*this, files_.add(file.name));
      }
    }
  }

  const trajectory::Subject& subject() const { return subject_; }
  const ExportSettings& settings() const { return settings_; }

  /// The start of the run, regardless of the requested states.
  const Poses& start() {
    if (start_.empty()) start_ = trajectory_.sample(0).poses;
    return start_;
  }

  /// Unit of a format without its own unit: the requested one, else the model's.
  LengthUnit unit() const { return settings_.unit.value_or(subject_.model.unit); }

  /// Unit of formats whose readers expect millimetres.
  LengthUnit fabricationUnit() const { return settings_.unit.value_or(millimetre()); }

  /// The tiles with their vertices in the order of the model's own file.
  std::vector<model::Tile> sheetOf(const trajectory::Sample& sample) const {
    return model::inFileOrder(brick::bottomTiles(subject_.bricks, sample.poses),
                              subject_.model.fileOrder);
  }

  /// Times in seconds and names of the states' files with this ending, for pvdText().
  std::vector<std::pair<double, std::string>> series(const char* ending) const {
    std::vector<std::pair<double, std::string>> files;
    for (const ChosenState& state : states_) {
      files.emplace_back(trajectory_.times()[state.sample], fileStem(state.label) + ending);
    }
    return files;
  }

  /// All samples of the run, regardless of the requested states.
  std::string animation() const {
    return writers::animationBytes(
        subject_.bricks, trajectory_.times().size(), [this](std::size_t k) {
          trajectory::Sample sample = trajectory_.sample(k);
          return writers::AnimationKey{sample.time, std::move(sample.poses)};
        });
  }

  /// The start and the chosen states, by time.
  std::vector<formats::FoldState> foldStates() const {
    const auto title = [](double time) { return fmt::format("t = {} s", time); };
    const double begin = trajectory_.times().front();
    std::vector<formats::FoldState> states = {{title(begin), {}}};
    for (const ChosenState& state : states_) {
      const trajectory::Sample sample = trajectory_.sample(state.sample);
      if (sample.time > begin) states.push_back({title(sample.time), sheetOf(sample)});
    }
    return states;
  }

 private:
  bool hasFormat(const char* format) const { return exports::hasFormat(settings_, format); }

  /// All files of one state.
  void writeState(const ChosenState& state, const trajectory::Sample& sample) {
    const std::string name = fileStem(state.label);
    if (exportsElements(settings_) && !isNecked()) {
      fea::ElementMesh mesh = stateMesh(subject_, sample.poses, elements_);
      const fea::DeckOrigin origin = originOf(state.label, sample);
      std::string sets;
      // The drive is written first: its node sets belong to the end of the mesh deck.
      if (isDriven(state.sample)) {
        sets = writeDrive(mesh, name, origin, state.sample, sample.poses);
      }
      writeElements(mesh, name, origin, sets);
      writeMap(std::move(mesh), name, origin);
    }
    for (const ExportFormat& format : exportFormats()) {
      if (!hasFormat(format.name)) continue;
      for (const ExportFile& file : format.files) {
        if (!file.writeState || (isNecked() && file.writeNecks)) continue;
        file.writeState(*this, sample, files_.add(name + file.name));
      }
    }
  }

  /// A map needs a first state and later states, with bricks.
  void requireMap() const {
    if (!settings_.decks.stateMap || !hasFormat(kDeck)) return;
    if (isNecked()) {
      throw InputError(
          "error: --state-map needs several states, but a sheet with necks has only the start; "
          "choose other --joints");
    }
    if (states_.size() > 1) return;
    throw InputError(
        "error: --state-map moves from the first state to others; choose several, as in --states "
        "initial,final");
  }

  /// A drive needs a state with later samples.
  void requireLaterSamples() const {
    const bool hasOnlyFinalStates = std::ranges::all_of(states_, [this](const ChosenState& state) {
      return state.sample + 1 == trajectory_.times().size();
    });
    if (settings_.decks.drive.kind == fea::DriveChoice::None || isNecked() || !hasOnlyFinalStates)
      return;
    throw InputError(
        "error: --drive moves tiles from a state onwards, but the final state has no motion after "
        "it; choose --states initial");
  }

  bool isNecked() const { return settings_.elements.joints == fea::JointStyle::Neck; }

  /// The flat start as it is cut, regardless of the requested states.
  void writeNeckSheet() {
    if (!exportsElements(settings_)) return;
    const double thickness = subject_.brickRule.thickness;
    const fea::ElementMesh mesh = fea::makeNeckMesh(subject_.model, thickness, elements_);
    const fea::DeckOrigin origin = originOf("flat sheet", trajectory_.sample(0));
    std::string sets;
    if (isDriven(0)) sets = writeDrive(mesh, kSheet, origin, 0, {});
    writeElements(mesh, kSheet, origin, sets);
    if (!hasFormat(kDeck) || !settings_.decks.periodic) return;
    // The cell of an infinite sheet has necks at its border, which the sheet itself does not have.
    const fea::ElementMesh cell = fea::makePeriodicNeckMesh(subject_.model, thickness, elements_);
    const std::string name = std::string(kSheet) + kPeriodicMesh;
    writeTextFile(files_.add(name), fea::meshDeck(cell, settings_.decks, origin));
    writeTextFile(files_.add(std::string(kSheet) + kPeriodicFile),
                  fea::periodicJob(cell, settings_.decks, origin, name).text);
  }

  /// `driveSets` are the sets of a drive on this mesh.
  void writeElements(const fea::ElementMesh& mesh, const std::string& name,
                     const fea::DeckOrigin& origin, const std::string& driveSets) {
    if (hasFormat(kGmsh)) {
      writeTextFile(files_.add(name + kGmshFile),
                    fea::gmshMesh(mesh, settings_.decks.sets, unit()));
    }
    if (!hasFormat(kDeck)) return;
    // Node sets for a job are at the end of the mesh deck: programs need them after the nodes.
    const fea::DeckJob job = fea::staticJob(mesh, settings_.decks, origin, name + kMeshFile);
    fea::DeckSettings decks = settings_.decks;
    decks.periodic = decks.periodic && !isNecked();
    writeTextFile(files_.add(name + kMeshFile),
                  fea::meshDeck(mesh, decks, origin) + job.sets + driveSets);
    writeTextFile(files_.add(name + kJobFile), job.text);
    if (settings_.decks.buckling) {
      writeTextFile(files_.add(name + kBucklingFile),
                    fea::bucklingJob(mesh, settings_.decks, origin, name + kMeshFile).text);
    }
    if (decks.periodic) {
      writeTextFile(files_.add(name + kPeriodicFile),
                    fea::periodicJob(mesh, settings_.decks, origin, name + kMeshFile).text);
    }
  }

  /// The job that maps the first state to this one; stores the mesh of the first.
  void writeMap(fea::ElementMesh mesh, const std::string& name, const fea::DeckOrigin& origin) {
    if (!hasFormat(kDeck) || !settings_.decks.stateMap) return;
    // The map starts at the first state. Each later state has a job on its mesh deck.
    if (!first_) {
      first_.emplace(name, std::move(mesh));
      return;
    }
    const auto& [firstName, firstMesh] = *first_;
    const fea::DeckJob job =
        fea::stateMapJob(firstMesh, mesh, settings_.decks, origin, firstName + kMeshFile);
    writeTextFile(files_.add(name + kMapFile), job.text);
  }

  /// The last sample has no later motion.
  bool isDriven(std::size_t sample) const {
    const bool hasFuture = sample + 1 < trajectory_.times().size();
    return hasFormat(kDeck) && settings_.decks.drive.kind != fea::DriveChoice::None && hasFuture;
  }

  /// Writes the drive's job, and its own mesh if it has one. Returns the sets that the job needs in
  /// the sheet's mesh.
  std::string writeDrive(const fea::ElementMesh& mesh, const std::string& name,
                         const fea::DeckOrigin& origin, std::size_t sample, const Poses& poses) {
    const bool hasOwn = hasDriveMesh(elements_, settings_.decks);
    const std::string meshFile = name + (hasOwn ? kDriveMesh : kMeshFile);
    const auto jobOn = [&](const fea::ElementMesh& driven) {
      const fea::DeckJob job =
          fea::driveJob(driven, settings_.decks, origin, meshFile, historyFrom(sample));
      writeTextFile(files_.add(name + kDriveFile), job.text);
      return job.sets;
    };
    if (!hasOwn) return jobOn(mesh);
    const fea::ElementMesh own = fea::makeElementMesh(subject_.bricks, subject_.model.joints, poses,
                                                      fea::coarsest(elements_));
    fea::DeckSettings decks = settings_.decks;
    // The coarse mesh has no control nodes, since only the periodic job uses them.
    decks.periodic = false;
    writeTextFile(files_.add(meshFile), fea::meshDeck(own, decks, origin) + jobOn(own));
    return {};
  }

  /// Reads all later samples into memory.
  fea::TileHistory historyFrom(std::size_t first) const {
    fea::TileHistory history;
    for (std::size_t k = first; k < trajectory_.times().size(); ++k) {
      history.times.push_back(trajectory_.times()[k] - trajectory_.times()[first]);
      history.poses.push_back(trajectory_.sample(k).poses);
    }
    return history;
  }

  /// `sample` gives time and overlap; the label is the requested one.
  fea::DeckOrigin originOf(const std::string& label, const trajectory::Sample& sample) const {
    return {subject_.model.name,
            label,
            sample.time,
            subject_.brickRule.thickness,
            overlapIn(subject_, sample),
            std::string("Kirireel ") + KIRIREEL_VERSION,
            runWords()};
  }

  /// Identification of this run in any folder.
  std::string runWords() const {
    const std::vector<trajectory::Event>& events = trajectory_.end().events;
    return fmt::format("trajectory.h5, {} samples to {} s{}{}", trajectory_.times().size(),
                       trajectory_.times().back(), events.empty() ? "" : "; ",
                       events.empty() ? "" : events.back().text);
  }

  const trajectory::TrajectoryReader& trajectory_;
  const trajectory::Subject& subject_;
  const ExportSettings& settings_;
  fea::ElementRule elements_;
  std::vector<ChosenState> states_;
  WrittenFiles& files_;
  Poses start_;
  std::optional<std::pair<std::string, fea::ElementMesh>> first_;  ///< of state maps: name, mesh
};

/// A surface mesh. Its ending selects the format of writeMesh().
void writeSurface(Exporter& exporter, const trajectory::Sample& sample,
                  const std::filesystem::path& file) {
  const bool isStl = file.extension() == ".stl";
  writers::writeMesh(file, exporter.subject().bricks, sample.poses,
                     isStl ? exporter.fabricationUnit() : exporter.unit());
}

void writeNeckStl(Exporter& exporter, const std::filesystem::path& file) {
  const trajectory::Subject& subject = exporter.subject();
  writeTextFile(file, fea::neckSheetStl(subject.model, exporter.settings().elements.neck,
                                        subject.brickRule.thickness, exporter.fabricationUnit()));
}

void writeNeckStep(Exporter& exporter, const std::filesystem::path& file) {
  const trajectory::Subject& subject = exporter.subject();
  writeTextFile(file, fea::neckSheetStep(subject.model, exporter.settings().elements.neck,
                                         subject.brickRule.thickness));
}

void writeBrickStep(Exporter& exporter, const trajectory::Sample& sample,
                    const std::filesystem::path& file) {
  writeTextFile(file, fea::brickStep(exporter.subject().bricks, sample.poses));
}

std::vector<writers::PatternLine> patternOf(const Exporter& exporter) {
  return patternOf(exporter.subject().model, exporter.settings());
}

void requirePattern(const model::Model& model, const ExportSettings& settings) {
  patternOf(model, settings);
}

bool isDriven(const fea::DeckSettings& decks) {
  return decks.drive.kind != fea::DriveChoice::None;
}

bool isPeriodic(const fea::DeckSettings& decks) {
  return decks.periodic;
}

// Files of a deployment have no writer for states.
ExportFile ofDeployment(const char* name, void (*write)(Exporter&, const std::filesystem::path&)) {
  return {.name = name, .writeDeployment = write};
}

// CalculiX or Abaqus decks and their jobs.
ExportFormat deckFormat() {
  return {kDeck,
          {{kMeshFile},
           {kJobFile},
           {.name = kDriveFile, .isRequested = isDriven},
           {.name = kDriveMesh, .isRequested = isDriven},
           {.name = kBucklingFile,
            .isRequested = [](const fea::DeckSettings& decks) { return decks.buckling; }},
           {.name = kMapFile,
            .isRequested = [](const fea::DeckSettings& decks) { return decks.stateMap; }},
           {.name = kPeriodicFile, .isRequested = isPeriodic},
           {.name = kPeriodicMesh, .isRequested = isPeriodic}},
          nullptr,
          true};
}

using Path = std::filesystem::path;

void writePlanarObj(Exporter& exporter, const trajectory::Sample& sample, const Path& file) {
  const std::vector<model::Tile> tiles = model::inUnit(exporter.sheetOf(sample), exporter.unit());
  writeTextFile(file, formats::unitLine(exporter.unit()) + writers::planarObjText(tiles));
}

void writeVertices(Exporter& exporter, const trajectory::Sample& sample, const Path& file) {
  formats::writeTiles(model::inUnit(exporter.sheetOf(sample), exporter.unit()), file,
                      exporter.unit());
}

void writeVtu(Exporter& exporter, const trajectory::Sample& sample, const Path& file) {
  writeTextFile(file,
                writers::vtuText(exporter.subject(), exporter.start(), sample, exporter.unit()));
}

void writePvd(Exporter& exporter, const Path& file) {
  writeTextFile(file, writers::pvdText(exporter.series(".vtu")));
}

void writeGlb(Exporter& exporter, const Path& file) {
  writeTextFile(file, exporter.animation());
}

void writeFold(Exporter& exporter, const Path& file) {
  // The states' tiles and the model in one unit, which the text states.
  const LengthUnit unit = exporter.unit();
  std::vector<formats::FoldState> states = exporter.foldStates();
  for (formats::FoldState& state : states) state.tiles = model::inUnit(state.tiles, unit);
  writeTextFile(file, formats::foldText(model::inUnit(exporter.subject().model, unit), states));
}

void writeSvg(Exporter& exporter, const Path& file) {
  writeTextFile(file, writers::patternSvg(patternOf(exporter)));
}

void writeDxf(Exporter& exporter, const Path& file) {
  writeTextFile(file, writers::patternDxf(patternOf(exporter), exporter.fabricationUnit()));
}

const std::vector<ExportFormat>& exportFormats() {
  static const std::vector<ExportFormat> formats = {
      // Closed bricks: one group per tile; triangles; binary triangles.
      {"obj", {{".obj", writeSurface}}},
      {"ply", {{".ply", writeSurface}}},
      {"stl", {{.name = ".stl", .writeState = writeSurface, .writeNecks = writeNeckStl}}},
      // The same as solids for CAD programs, in millimetres.
      {.name = "step",
       .files = {{.name = ".step", .writeState = writeBrickStep, .writeNecks = writeNeckStep}},
       .hasOwnUnit = true},
      // The bottoms of bricks, which are the tiles: polygons as in PyKirigami; as vertices.txt.
      {"planar", {{"_planar.obj", writePlanarObj}}},
      {"vertices", {{"_vertices.txt", writeVertices}}},
      deckFormat(),
      // A Gmsh 4.1 mesh of the same elements.
      {kGmsh, {{kGmshFile}}},
      // ParaView, with measures as fields.
      {"vtu", {{".vtu", writeVtu}, ofDeployment("deployment.pvd", writePvd)}},
      // The whole deployment: animated; the states as frames of a FOLD file.
      {.name = "glb", .files = {ofDeployment("deployment.glb", writeGlb)}, .hasOwnUnit = true},
      {"fold", {ofDeployment("deployment.fold", writeFold)}},
      // Cut pattern of the start.
      {.name = "svg",
       .files = {ofDeployment("cut_pattern.svg", writeSvg)},
       .require = requirePattern,
       .hasOwnUnit = true},
      {"dxf", {ofDeployment("cut_pattern.dxf", writeDxf)}, requirePattern}};
  return formats;
}

/// The smallest distance between two parallel lines that enclose a tile.
double widthOf(const brick::Brick& brick) {
  const std::vector<Vector3>& corners = brick.bottom;
  double width = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vector3 along = (corners[(k + 1) % corners.size()] - corners[k]).normalized();
    double farthest = 0, nearest = 0;
    for (const Vector3& corner : corners) {
      const double distance = brick.normal.dot(along.cross(corner - corners[k]));
      farthest = std::max(farthest, distance);
      nearest = std::min(nearest, distance);
    }
    width = std::min(width, farthest - nearest);
  }
  return width;
}

/// Constants of lockingOf().
struct Locking {
  double scale = 0, byLength = 0, bySlenderness = 0;
};

/// The deflection of a clamped square plate under its weight that CalculiX misses, as a fraction of
/// Kirchhoff's. `slenderness` is width / thickness, `perEdge` the number of elements
/// along an edge, >= 4. Few thin elements are too stiff (locking): x / (1 + x) with
///     x = c (8 / perEdge)^p slenderness^q,
/// at most 0.75 with quadratic elements of hinged tiles. Fitted to decks with 4 to 16 elements and
/// a slenderness of 50 to 1000. Hinged tiles: within 0.13 of solids, within 0.23 of shells. Sheets
/// with necks, whose meshes are irregular: within 0.04.
double lockingOf(double slenderness, double perEdge, const fea::ElementRule& rule) {
  const bool isShell = rule.family == fea::ElementFamily::Shell;
  const bool isNecked = rule.joints == fea::JointStyle::Neck;
  const Locking of = rule.quadratic ? (!isNecked ? Locking{8.5e-7, 6.3, 2}
                                       : isShell ? Locking{1.3e-4, 2.1, 0.7}
                                                 : Locking{4.65e-5, 3.25, 1.25})
                                    : (!isNecked ? Locking{isShell ? 1e-4 : 7e-5, 4, 2}
                                       : isShell ? Locking{2.6e-5, 0.8, 1.63}
                                                 : Locking{1.95e-5, 3.25, 1.8});
  const double x =
      of.scale * std::pow(8 / perEdge, of.byLength) * std::pow(slenderness, of.bySlenderness);
  return std::min(x / (1 + x), rule.quadratic && !isNecked ? 0.75 : 1.0);
}

/// Warns of tiles that are thin for their elements. The figure is of a clamped square, since it is
/// known only there. Plates of fewer than 4 quadratic elements deflect by up to 22% too far, or by
/// up to 83% too little.
void appendThinnessWarning(std::vector<std::string>& lines, const trajectory::Subject& subject,
                           const ExportSettings& settings) {
  constexpr double kMinReportedError = 0.03;
  constexpr double kThin = 100;
  constexpr double kFewest = 4;
  const fea::ElementRule& rule = settings.elements;
  const bool isNecked = rule.joints == fea::JointStyle::Neck;
  const double defaultCount = rule.perEdge > 0 ? rule.perEdge
                              : isNecked       ? fea::kDefaultPerEdge
                                               : fea::defaultPerEdge(subject.bricks, rule);
  // Elements of sheets with necks have one length in all tiles.
  const double length = rule.size > 0 ? rule.size : model::tileSize(subject.model) / defaultCount;
  double most = 0, slenderness = 0, perEdge = 0;
  std::size_t thin = 0;
  for (std::size_t t = 0; t < subject.bricks.size(); ++t) {
    const brick::Brick& brick = subject.bricks[t];
    const double width = widthOf(brick);
    const double count = isNecked        ? width / length
                         : rule.size > 0 ? std::max(1.0, std::ceil(width / rule.size))
                                         : defaultCount;
    const double error = lockingOf(width / brick.thickness, count, rule);
    if (error <= most) continue;
    most = error, slenderness = width / brick.thickness, perEdge = count, thin = t;
  }
  const auto tile = static_cast<std::size_t>(subject.model.fileOrder.countsFrom) + thin;
  if (rule.quadratic && perEdge < kFewest) {
    if (slenderness <= kThin) return;
    lines.push_back(fmt::format(
        "warning: tile {} is {:.0f} times as wide as thick; with clamped edges and fewer than {} "
        "elements per edge a square deflects wrongly by about 10% or more: use more with "
        "--elements-per-edge",
        tile, slenderness, kFewest));
  } else if (most > kMinReportedError) {
    lines.push_back(fmt::format(
        "warning: tile {} is {:.0f} times as wide as thick; a clamped square that is as thin "
        "deflects about {:.0f}% too little with {:.2g} elements per edge: use more with "
        "--elements-per-edge",
        tile, slenderness, 100 * most, perEdge));
  }
}

/// Warns of sharp corners. The figures are measured on triangles of 8 elements per edge.
void appendSharpnessWarning(std::vector<std::string>& lines, const trajectory::Subject& subject,
                            const fea::ElementRule& rule) {
  constexpr double kSharp = 10;  // degrees
  double sharpest = kSharp;
  std::optional<std::size_t> sharp;
  for (std::size_t t = 0; t < subject.bricks.size(); ++t) {
    const brick::Brick& brick = subject.bricks[t];
    const std::vector<Vector3>& corners = brick.bottom;
    const std::size_t count = corners.size();
    for (std::size_t k = 0; k < count; ++k) {
      const Vector3 next = corners[(k + 1) % count] - corners[k];
      const Vector3 previous = corners[(k + count - 1) % count] - corners[k];
      const Vector3 across = next.cross(previous);
      // Notches of concave tiles are not slivers.
      if (across.dot(brick.normal) <= 0) continue;
      const double angle = std::atan2(across.norm(), next.dot(previous)) / kDegree;
      if (angle < sharpest) sharpest = angle, sharp = t;
    }
  }
  if (!sharp) return;
  const char* measured = rule.joints != fea::JointStyle::Neck
                             ? "9% with a corner of 5 to 10 degrees, by 42 to 165%"
                         : rule.family == fea::ElementFamily::Plane
                             ? "26% with a corner of 5 to 10 degrees, by 13 to 237%"
                             : "7% with a corner of 5 to 10 degrees, by 2 to 102%";
  lines.push_back(fmt::format(
      "warning: tile {} has a corner of {:.2g} degrees, so natural frequencies may be too high: "
      "the first five of triangles with 8 elements per edge by up to {} with 1 degree. Use more "
      "with --elements-per-edge",
      static_cast<std::size_t>(subject.model.fileOrder.countsFrom) + *sharp, sharpest, measured));
}

}  // namespace

ExportSettings inMetres(ExportSettings settings, const LengthUnit& unit) {
  fea::ElementRule& elements = settings.elements;
  for (double* length :
       {&settings.hingeWidth, &elements.patchRadius, &elements.size, &elements.neck.width,
        &elements.neck.length, &elements.neck.radius, &elements.neck.kerf}) {
    *length *= unit.metres;
  }
  return settings;
}

std::vector<std::string> exportFormatNames() {
  std::vector<std::string> names;
  for (const ExportFormat& format : exportFormats()) names.emplace_back(format.name);
  return names;
}

void requireExportable(const model::Model& model, const brick::BrickRule& rule,
                       const ExportSettings& settings) {
  requireDifferent(settings.formats);
  fea::requireValidRule(settings.elements);
  fea::requireDrivable(settings.decks.drive, model.tiles.size(), model.fileOrder.countsFrom);
  requireStart(settings);
  requireUnitUse(settings);
  // Checks everything that depends only on the start before the run, including necks.
  for (const std::string& name : settings.formats) {
    const ExportFormat& format = exportFormat(name);
    if (format.require) format.require(model, settings);
  }
  const bool hasSolid = hasFormat(settings, "stl") || hasFormat(settings, "step");
  if (settings.elements.joints == fea::JointStyle::Neck &&
      (hasSolid || exportsElements(settings))) {
    fea::meshableOutline(model, settings.elements.neck);
    return;
  }
  if (!exportsElements(settings)) return;
  fea::ElementRule elements = numbered(settings.elements, model);
  // The gaps at shared corners are known only from the run's states.
  if (elements.joints == fea::JointStyle::Shared) elements.joints = fea::JointStyle::Equation;
  // Making the mesh is the check: it throws now instead of after a run of hours.
  const std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, rule);
  fea::makeElementMesh(bricks, model.joints, brick::startPoses(model.tiles, bricks), elements);
}

bool isExported(const std::string& name, const ExportSettings& settings) {
  const auto isOfState = [&](const std::string& state, const char* ending) {
    const auto nameOf = [&](std::size_t sample) {
      return fileStem(stateLabel(state, sample)) + ending;
    };
    // Names with the number of a sample: any number counts, since the number of samples of a run is
    // not known yet.
    return name == nameOf(0) ||
           output::isNumbered(name, [&](int k) { return nameOf(static_cast<std::size_t>(k)); });
  };
  const auto isOfFile = [&](const ExportFile& file) {
    if (file.isRequested && !file.isRequested(settings.decks)) return false;
    if (file.writeDeployment) return name == file.name;
    const bool hasNecks = settings.elements.joints == fea::JointStyle::Neck;
    const bool isOfSheet = hasNecks && name == std::string(kSheet) + file.name;
    if (hasNecks && file.showsElements()) return isOfSheet;
    if (file.writeNecks && isOfSheet) return true;
    return std::ranges::any_of(
        settings.states, [&](const std::string& state) { return isOfState(state, file.name); });
  };
  return std::ranges::any_of(settings.formats, [&](const std::string& format) {
    return std::ranges::any_of(exportFormat(format).files, isOfFile);
  });
}

std::vector<std::string> exportWarnings(const trajectory::TrajectoryReader& trajectory,
                                        const ExportSettings& settings) {
  std::vector<std::string> lines;
  if (!exportsElements(settings)) return lines;
  const std::vector<brick::Brick>& bricks = trajectory.subject().bricks;
  const bool isNecked = settings.elements.joints == fea::JointStyle::Neck;
  // Large sheets get fewer elements than the default; the user must know this.
  if (!isNecked && fea::isCoarsened(bricks, settings.elements)) {
    lines.push_back(
        fmt::format("warning: a sheet of {} tiles has {} elements per edge; 8 would bend more "
                    "accurately. Use --elements-per-edge or --element-size",
                    bricks.size(), fea::defaultPerEdge(bricks, settings.elements)));
  }
  // Plane elements do not bend.
  if (settings.elements.family != fea::ElementFamily::Plane) {
    appendThinnessWarning(lines, trajectory.subject(), settings);
  }
  appendSharpnessWarning(lines, trajectory.subject(), settings.elements);
  if (isNecked || !hasFormat(settings, kDeck)) return lines;
  const std::vector<brick::HingeSpring>& springs =
      brick::hingeSpringsOf(trajectory.subject().pairForces);
  const bool hasSprings = std::ranges::any_of(springs, [](auto& one) { return one.stiffness > 0; });
  const auto folds = std::ranges::count_if(
      springs, [&](auto& one) { return one.stiffness > 0 && fea::isFold(one.hinge, bricks); });
  // Only patches have rotations for springs.
  if (hasSprings && settings.elements.joints != fea::JointStyle::Patch) {
    lines.emplace_back(
        "warning: these decks lack the run's springs at hinges, which need rigid patches; choose "
        "--joints patch");
  } else if (folds > 0) {
    lines.push_back(fmt::format(
        "warning: these decks lack the run's springs at folds ({} of {}). Only hinges across the "
        "tiles have springs",
        folds, springs.size()));
  }
  if (trajectory.subject().pairForces.replaceJoints()) {
    lines.emplace_back(
        "warning: these decks join tiles exactly, but the run's ligaments stretch and shear; "
        "--joints neck gives the start with its necks");
  }
  const double thickness = trajectory.subject().brickRule.thickness;
  for (const ChosenState& state : chooseStates(trajectory, settings.states)) {
    const double overlap = overlapIn(trajectory.subject(), trajectory.sample(state.sample));
    if (!fea::isReportableOverlap(overlap, thickness)) continue;
    lines.push_back(
        fmt::format("warning: in state {} bricks overlap by {}, {:.0f}% of their thickness; "
                    "an analysis with contact would start overclosed",
                    state.label, lengthText(overlap, trajectory.subject().model.unit, 2),
                    100 * overlap / thickness));
  }
  return lines;
}

std::vector<std::string> exportStates(const trajectory::TrajectoryReader& trajectory,
                                      const ExportSettings& settings,
                                      const std::filesystem::path& folder) {
  requireDifferent(settings.formats);
  output::FileSet files(folder, output::kContents);
  // Before writing anything: refuse names of files that Kirireel did not write.
  files.requireFree([&](const std::string& name) { return isExported(name, settings); });
  std::vector<std::string> names = exportInto(trajectory, settings, files.stage());
  files.commit(names);
  return names;
}

std::vector<std::string> exportInto(const trajectory::TrajectoryReader& trajectory,
                                    const ExportSettings& settings,
                                    const std::filesystem::path& folder) {
  requireDifferent(settings.formats);
  WrittenFiles files(folder);
  Exporter(trajectory, settings, files).writeAll();
  return files.keep();
}

// ------------------------------------------------------------------------------------------------
// A state's name is parsed into a kind and a number, which give the nearest sample of the
// trajectory. File names contain the request (state_25pct) and not the sample number, so scripts
// find them for any number of samples.

namespace {

/// `allowed` describes the contents of the trajectory.
InputError unknownState(const std::string& name, const std::string& allowed) {
  return InputError(fmt::format("error: state '{}' is not in the trajectory; {}", name, allowed));
}

/// The number before the ending. The text before the ending must be a finite number.
std::optional<double> numberBefore(const std::string& text, const std::string& ending) {
  if (!text.ends_with(ending)) return std::nullopt;
  double number = 0;
  const char* last = text.data() + text.size() - ending.size();
  const auto [end, error] = std::from_chars(text.data(), last, number);
  const bool isWhole = error == std::errc() && end == last && std::isfinite(number);
  return isWhole ? std::optional(number) : std::nullopt;
}

/// A fraction of time, not of motion: 50% of a run of 4 s is the sample nearest to 2 s. Sampling
/// can end a fraction of an interval before the end time of the run.
std::size_t sampleAtTime(const std::vector<double>& times, double time, const std::string& name) {
  // Times up to half a sample after the end count as the end.
  const double slack = times.size() > 1 ? 0.5 * (times[1] - times[0]) : 0;
  if (time < 0 || time > times.back() + slack) {
    throw unknownState(name, fmt::format("it goes from 0 to {:.6g} s", times.back()));
  }
  return trajectory::nearestIndex(times, time);
}

/// Reads sample by sample until one has rotated far enough.
std::size_t sampleAtAngle(const trajectory::TrajectoryReader& trajectory, double degrees,
                          const std::string& name) {
  const Poses start = trajectory.sample(0).poses;
  const double requestedTurn = degrees * kDegree;
  double largest = 0;
  for (std::size_t k = 0; k < trajectory.times().size(); ++k) {
    const double turn =
        std::ranges::max(trajectory::brickRotations(start, trajectory.sample(k).poses));
    if (turn >= requestedTurn) return k;
    largest = std::max(largest, turn);
  }
  throw unknownState(name,
                     fmt::format("its tiles rotate by at most {:.4g} degrees", largest / kDegree));
}

/// The first event whose text contains `text` counts.
std::size_t sampleAtEvent(const trajectory::TrajectoryReader& trajectory, const std::string& text,
                          const std::string& name) {
  std::string known;
  for (const trajectory::Event& event : trajectory.end().events) {
    if (event.text.find(text) != std::string::npos) {
      return trajectory::nearestIndex(trajectory.times(), event.time);
    }
    known += fmt::format("{}'{}'", known.empty() ? "" : ", ", event.text);
  }
  throw unknownState(name, known.empty() ? "it has no events" : "its events are " + known);
}

/// Parsed name of a state.
struct StateName {
  enum Kind { Initial, Final, All, Share, Time, Angle, Event } kind = Initial;
  double number = 0;  ///< per cent, seconds or degrees
  std::string text;   ///< of an event
};

/// Does not check whether the trajectory has such a state.
StateName readName(const std::string& name) {
  constexpr std::string_view kEvent = "event:";
  if (name == "initial") return {StateName::Initial};
  if (name == "final") return {StateName::Final};
  if (name == "all") return {StateName::All};
  if (name.starts_with(kEvent)) return {StateName::Event, 0, name.substr(kEvent.size())};
  // "deg" before "s", and the empty ending last, because it fits every number.
  for (const auto& [ending, kind] : {std::pair{"%", StateName::Share},
                                     {"deg", StateName::Angle},
                                     {"s", StateName::Time},
                                     {"", StateName::Time}}) {
    const auto number = numberBefore(name, ending);
    if (!number) continue;
    if (kind == StateName::Share && !(*number >= 0 && *number <= 100)) {
      throw unknownState(name, "shares go from 0% to 100%");
    }
    return {kind, *number};
  }
  throw InputError(
      fmt::format("error: '{}' is not a state; use initial, final, all, a share (25%), a time (1.5 "
                  "or 1.5s), an angle (30deg) or an event (event:TEXT)",
                  name));
}

/// The first and the last sample of a name, equal for all names but `all`.
std::pair<std::size_t, std::size_t> samplesNamed(const trajectory::TrajectoryReader& trajectory,
                                                 const std::string& name) {
  const std::vector<double>& times = trajectory.times();
  const StateName read = readName(name);
  const auto one = [](std::size_t sample) { return std::pair{sample, sample}; };
  switch (read.kind) {
    case StateName::Final:
      return one(times.size() - 1);
    case StateName::All:
      return {0, times.size() - 1};
    case StateName::Share:
      return one(trajectory::nearestIndex(times, read.number / 100 * times.back()));
    case StateName::Time:
      return one(sampleAtTime(times, read.number, name));
    case StateName::Angle:
      return one(sampleAtAngle(trajectory, read.number, name));
    case StateName::Event:
      return one(sampleAtEvent(trajectory, read.text, name));
    case StateName::Initial:
      break;
  }
  return one(0);
}

/// Refuses equal labels, such as "50%" and "50.0%", or events that differ only in replaced letters.
void requireDifferentLabels(const std::vector<ChosenState>& states) {
  for (std::size_t a = 0; a < states.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      if (states[a].label != states[b].label) continue;
      throw InputError(
          fmt::format("error: samples {} and {} would both be written as {}; name them differently",
                      states[b].sample, states[a].sample, states[a].label));
    }
  }
}

}  // namespace

void requireStateName(const std::string& name) {
  readName(name);
}

std::string stateLabel(const std::string& name, std::size_t sample) {
  const StateName read = readName(name);
  switch (read.kind) {
    case StateName::All:
      return fmt::format("{:04}", sample);
    case StateName::Share:
      return fmt::format("{}pct", read.number);
    case StateName::Time:
      return fmt::format("{}s", read.number);
    case StateName::Angle:
      return fmt::format("{}deg", read.number);
    case StateName::Event:
      break;
    default:
      return name;
  }
  std::string label = "event_" + read.text;
  for (char& letter : label) {
    const bool isPlain =
        std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '.' || letter == '-';
    // One underscore per byte: letters beyond ASCII give several.
    if (!isPlain) letter = '_';
  }
  return label;
}

std::vector<ChosenState> chooseStates(const trajectory::TrajectoryReader& trajectory,
                                      const std::vector<std::string>& names) {
  const auto isEnd = [](const std::string& name) { return name == "initial" || name == "final"; };
  // By sample: states are in the order of time, for any order of names.
  std::map<std::size_t, std::pair<std::string, std::string>> chosen;  // names and labels
  for (const std::string& name : names) {
    const auto [first, last] = samplesNamed(trajectory, name);
    // `all` names each sample itself, so other names are not allowed with it.
    for (std::size_t sample = first; sample <= last; ++sample) {
      const auto [place, isNew] = chosen.try_emplace(sample, name, stateLabel(name, sample));
      // The only sample of a run is its initial and its final state: the default names both.
      const bool isBothEnds =
          place->second.first != name && isEnd(place->second.first) && isEnd(name);
      if (isNew || isBothEnds) continue;
      throw InputError(
          fmt::format("error: states '{}' and '{}' are both sample {}; remove one of them",
                      place->second.first, name, sample));
    }
  }
  std::vector<ChosenState> states;
  for (const auto& [sample, words] : chosen) states.push_back({sample, words.second});
  requireDifferentLabels(states);
  return states;
}

// ------------------------------------------------------------------------------------------------
// The opening d of a sheet under 1 N at both ends (outside_program.h) is its compliance in m/N, one
// number for the whole mesh. It is computed with the chosen elements, d1, and with elements half as
// long, d2. The reported change is 100 (d2 / d1 - 1) per cent. It is small for a sufficiently fine
// mesh. With single-node joints the number grows without limit, which this check reveals. The job
// is that of the deck: moments of springs that are not at rest also move the ends.
//
// Half the length in the plane gives four times as many elements. The number through the thickness
// stays, because the check is about bending.

namespace {

/// The rule with elements half as long. `defaultCount` lie along edges if the rule has no number.
/// Necks and patches keep their sizes: they are part of the result.
fea::ElementRule halved(fea::ElementRule rule, int defaultCount) {
  if (rule.size > 0) {
    rule.size /= 2;
  } else {
    rule.perEdge = 2 * (rule.perEdge > 0 ? rule.perEdge : defaultCount);
  }
  return rule;
}

/// The job uses CalculiX's keywords and metres for any settings, without unused sets.
double openingOf(const fea::ElementMesh& mesh, fea::DeckSettings settings,
                 const fea::DeckOrigin& origin) {
  settings.solver = fea::Solver::Calculix;
  settings.sets = fea::SetChoice::None;
  settings.unit = fea::DeckUnit::Model;
  settings.periodic = false;
  const fea::DeckJob job = fea::staticJob(mesh, settings, origin, "mesh.inp");
  return fea::openingByCalculix(fea::meshDeck(mesh, settings, origin) + job.sets, job.text);
}

/// Metres, in the model's unit with four digits, and the change in per cent.
std::string lineOf(const std::string& name, bool hasMoments, double own, double finer,
                   const LengthUnit& unit) {
  return fmt::format(
      "check: {}: 1 N at both ends {} them apart by {}, {} with elements half as "
      "long ({:+.2f}%)",
      name, hasMoments ? "and the moments of its springs move" : "moves", lengthText(own, unit, 4),
      lengthText(finer, unit, 4), 100 * (finer / own - 1));
}

}  // namespace

std::vector<std::string> meshSensitivity(const trajectory::TrajectoryReader& trajectory,
                                         const ExportSettings& settings) {
  if (!hasFormat(settings, kDeck)) {
    throw InputError("error: --check runs the jobs of decks; add inp to --format");
  }
  const trajectory::Subject& subject = trajectory.subject();
  fea::DeckOrigin origin;
  origin.thickness = subject.brickRule.thickness;
  std::vector<std::string> lines;
  // `meshBy` makes the mesh of a rule; called twice.
  const auto check = [&](const std::string& name, const auto& meshBy, int defaultCount) {
    const fea::ElementMesh mesh = meshBy(settings.elements);
    const bool hasMoments =
        std::ranges::any_of(mesh.springs, [](auto& one) { return one.moment != 0; });
    const double own = openingOf(mesh, settings.decks, origin);
    const double finer =
        openingOf(meshBy(halved(settings.elements, defaultCount)), settings.decks, origin);
    lines.push_back(lineOf(name, hasMoments, own, finer, subject.model.unit));
  };
  if (settings.elements.joints == fea::JointStyle::Neck) {
    const auto meshBy = [&](const fea::ElementRule& rule) {
      return fea::makeNeckMesh(subject.model, origin.thickness, rule);
    };
    check("flat sheet", meshBy, fea::kDefaultPerEdge);
    return lines;
  }
  for (const ChosenState& state : chooseStates(trajectory, settings.states)) {
    const Poses poses = trajectory.sample(state.sample).poses;
    const auto meshBy = [&](const fea::ElementRule& rule) {
      return stateMesh(subject, poses, rule);
    };
    check(state.label, meshBy, fea::defaultPerEdge(subject.bricks, settings.elements));
  }
  return lines;
}

}  // namespace kirireel::exports
