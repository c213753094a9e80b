#include "render/export/export.h"

#include <algorithm>
#include <array>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "render/export/state_choice.h"
#include "render/fea/deck.h"
#include "render/fea/gmsh.h"
#include "render/folder/file_set.h"
#include "render/mesh/animation.h"
#include "render/mesh/mesh.h"
#include "render/sheet/cut_pattern.h"
#include "render/sheet/planar_files.h"
#include "render/vtk/vtk.h"
#include "sim/base/error.h"
#include "sim/base/pending_file.h"
#include "sim/model/folder.h"

namespace kirireel {
namespace {

void requireDifferent(const std::vector<ExportFormat>& formats) {
  for (std::size_t k = 0; k < formats.size(); ++k) {
    const auto rest = formats.begin() + static_cast<std::ptrdiff_t>(k) + 1;
    if (std::find(rest, formats.end(), formats[k]) == formats.end()) continue;
    throw InputError(
        fmt::format("error: format {} is given twice, so its files would have one "
                    "name; leave one out",
                    exportFormatNames()[static_cast<std::size_t>(formats[k])].first));
  }
}

bool wants(const ExportSettings& settings, ExportFormat format) {
  return std::ranges::find(settings.formats, format) != settings.formats.end();
}

std::vector<PatternLine> patternOf(const Model& model, const ExportSettings& settings) {
  constexpr double kHingeOfTile = 0.05;
  const double width = settings.hingeWidth;
  return cutPattern(model, width != 0 ? width : kHingeOfTile * tileSize(model));
}

/// A file of a format: one for each state, then `name` is what follows "state_0042", or one for
/// all.
struct ExportFile {
  ExportFormat format;
  bool ofEachState;
  const char* name;
};

constexpr auto kFiles = std::to_array<ExportFile>({
    {ExportFormat::Obj, true, ".obj"},
    {ExportFormat::Ply, true, ".ply"},
    {ExportFormat::Stl, true, ".stl"},
    {ExportFormat::Planar, true, "_planar.obj"},
    {ExportFormat::Vertices, true, "_vertices.txt"},
    {ExportFormat::Inp, true, "_mesh.inp"},
    {ExportFormat::Inp, true, "_job.inp"},
    {ExportFormat::Msh, true, ".msh"},
    {ExportFormat::Vtu, true, ".vtu"},
    {ExportFormat::Vtu, false, "deployment.pvd"},
    {ExportFormat::Glb, false, "deployment.glb"},
    {ExportFormat::Fold, false, "deployment.fold"},
    {ExportFormat::Svg, false, "cut_pattern.svg"},
    {ExportFormat::Dxf, false, "cut_pattern.dxf"},
});

std::string stateName(std::size_t number) {
  return fmt::format("state_{:04}", number);
}

/// The files that were written into a folder; without keep() they are removed.
class WrittenFiles {
 public:
  explicit WrittenFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ~WrittenFiles() {
    std::error_code ignored;
    for (const std::string& name : names_) std::filesystem::remove(folder_ / name, ignored);
  }
  WrittenFiles(const WrittenFiles&) = delete;
  WrittenFiles& operator=(const WrittenFiles&) = delete;

  /// Where to write the file of this name.
  std::filesystem::path add(const std::string& name) {
    names_.push_back(name);
    return folder_ / name;
  }

  std::vector<std::string> keep() { return std::exchange(names_, {}); }

 private:
  std::filesystem::path folder_;
  std::vector<std::string> names_;
};

/// Writes one format after the other.
class Exporter {
 public:
  Exporter(const TrajectoryReader& trajectory, const ExportSettings& settings, WrittenFiles& files)
      : trajectory_(trajectory),
        subject_(trajectory.subject()),
        settings_(settings),
        samples_(chooseStates(trajectory, settings.states)),
        files_(files) {}

  void writeAll() {
    for (const std::size_t number : samples_) writeState(number, trajectory_.sample(number));
    for (const ExportFormat format : settings_.formats) writeDeployment(format);
  }

 private:
  bool wants(ExportFormat format) const { return kirireel::wants(settings_, format); }

  void writeState(std::size_t number, const Sample& sample) {
    const std::string name = stateName(number);
    if (wants(ExportFormat::Inp) || wants(ExportFormat::Msh)) writeElements(name, sample);
    for (const auto& [format, ending] : {std::pair{ExportFormat::Obj, ".obj"},
                                         {ExportFormat::Ply, ".ply"},
                                         {ExportFormat::Stl, ".stl"}}) {
      if (wants(format)) writeMesh(files_.add(name + ending), subject_.bricks, sample.poses);
    }
    if (wants(ExportFormat::Vtu)) {
      if (start_.empty()) start_ = trajectory_.sample(0).poses;
      writeTextFile(files_.add(name + ".vtu"), vtuText(subject_, start_, sample));
    }
    const std::vector<Tile> tiles = sheetOf(sample);
    if (wants(ExportFormat::Planar)) {
      writeTextFile(files_.add(name + "_planar.obj"), planarObjText(tiles));
    }
    if (wants(ExportFormat::Vertices)) writeTiles(tiles, files_.add(name + "_vertices.txt"));
  }

  /// The tiles with their vertices in the order of the model's own file.
  std::vector<Tile> sheetOf(const Sample& sample) const {
    return inFileOrder(bottomTiles(subject_.bricks, sample.poses), subject_.model.fileOrder);
  }

  void writeElements(const std::string& name, const Sample& sample) {
    const ElementMesh mesh =
        makeElementMesh(subject_.bricks, subject_.model.joints, sample.poses, settings_.elements);
    if (wants(ExportFormat::Msh)) writeTextFile(files_.add(name + ".msh"), gmshMesh(mesh));
    if (!wants(ExportFormat::Inp)) return;
    const std::string title = fmt::format("State at {} s", sample.time);
    writeTextFile(files_.add(name + "_mesh.inp"), meshDeck(mesh, title));
    writeTextFile(files_.add(name + "_job.inp"), jobDeck(mesh, name + "_mesh.inp"));
  }

  void writeDeployment(ExportFormat format) {
    if (format == ExportFormat::Vtu) writeTextFile(files_.add("deployment.pvd"), pvdText(series()));
    if (format == ExportFormat::Glb) writeTextFile(files_.add("deployment.glb"), animation());
    if (format == ExportFormat::Fold) {
      writeTextFile(files_.add("deployment.fold"), foldText(inFileOrder(subject_.model), sheets()));
    }
    const auto pattern = [this] { return patternOf(subject_.model, settings_); };
    if (format == ExportFormat::Svg) {
      writeTextFile(files_.add("cut_pattern.svg"), patternSvg(pattern()));
    }
    if (format == ExportFormat::Dxf) {
      writeTextFile(files_.add("cut_pattern.dxf"), patternDxf(pattern()));
    }
  }

  std::vector<std::pair<double, std::string>> series() const {
    std::vector<std::pair<double, std::string>> files;
    for (const std::size_t number : samples_) {
      files.emplace_back(trajectory_.times()[number], stateName(number) + ".vtu");
    }
    return files;
  }

  std::string animation() const {
    return animationBytes(subject_.bricks, trajectory_.times().size(), [this](std::size_t k) {
      Sample sample = trajectory_.sample(k);
      return AnimationKey{sample.time, std::move(sample.poses)};
    });
  }

  std::vector<SheetState> sheets() const {
    std::vector<SheetState> states;
    for (const std::size_t number : samples_) {
      const Sample sample = trajectory_.sample(number);
      states.push_back({sample.time, sheetOf(sample)});
    }
    return states;
  }

  const TrajectoryReader& trajectory_;
  const Subject& subject_;
  const ExportSettings& settings_;
  std::vector<std::size_t> samples_;
  WrittenFiles& files_;
  Poses start_;
};

}  // namespace

const std::vector<std::pair<std::string, ExportFormat>>& exportFormatNames() {
  static const std::vector<std::pair<std::string, ExportFormat>> names = {
      {"obj", ExportFormat::Obj},           {"ply", ExportFormat::Ply},
      {"stl", ExportFormat::Stl},           {"planar", ExportFormat::Planar},
      {"vertices", ExportFormat::Vertices}, {"inp", ExportFormat::Inp},
      {"msh", ExportFormat::Msh},           {"vtu", ExportFormat::Vtu},
      {"glb", ExportFormat::Glb},           {"fold", ExportFormat::Fold},
      {"svg", ExportFormat::Svg},           {"dxf", ExportFormat::Dxf},
  };
  return names;
}

void requireExportable(const Model& model, const BrickRule& rule, const ExportSettings& settings) {
  requireDifferent(settings.formats);
  const bool isPattern = wants(settings, ExportFormat::Svg) || wants(settings, ExportFormat::Dxf);
  if (isPattern) patternOf(model, settings);
  const bool isDivided = wants(settings, ExportFormat::Inp) || wants(settings, ExportFormat::Msh);
  if (!isDivided) return;
  ElementRule elements = settings.elements;
  // How well corners meet that share a node is known of the run's own states alone.
  if (elements.joints == JointStyle::Shared) elements.joints = JointStyle::Equation;
  const std::vector<Brick> bricks = makeBricks(model.tiles, rule);
  makeElementMesh(bricks, model.joints, startPoses(model.tiles, bricks), elements);
}

bool isExported(const std::string& name, const ExportSettings& settings) {
  return std::ranges::any_of(kFiles, [&](const ExportFile& file) {
    if (!wants(settings, file.format)) return false;
    if (!file.ofEachState) return name == file.name;
    return isNumbered(
        name, [&](int number) { return stateName(static_cast<std::size_t>(number)) + file.name; });
  });
}

std::vector<std::string> exportStates(const TrajectoryReader& trajectory,
                                      const ExportSettings& settings,
                                      const std::filesystem::path& folder) {
  requireDifferent(settings.formats);
  FileSet files(folder, output::kContents);
  files.requireFree([&](const std::string& name) {
    return name == output::kContents || isExported(name, settings);
  });
  std::vector<std::string> names = exportInto(trajectory, settings, files.stage());
  files.commit(names);
  return names;
}

std::vector<std::string> exportInto(const TrajectoryReader& trajectory,
                                    const ExportSettings& settings,
                                    const std::filesystem::path& folder) {
  requireDifferent(settings.formats);
  WrittenFiles files(folder);
  Exporter(trajectory, settings, files).writeAll();
  return files.keep();
}

}  // namespace kirireel
