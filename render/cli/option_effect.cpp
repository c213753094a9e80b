// An option without effect is an error, reported with its reason. Otherwise a user would draw
// conclusions from a number that was not used.
//
// - Settings of a scene carry their conditions (sim/scene/settings.h), such as "--solver direct".
//   They hold for the command line and for scene files.
// - optionEffects() lists the conditions of all other options. It applies only to typed options: a
//   scene file may have settings for several uses.
// - requireConsistent() checks conditions on two settings.
#include "render/cli/option_effect.h"

#include <algorithm>
#include <initializer_list>
#include <span>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "render/cli/option_group.h"
#include "render/picture/state_painter.h"
#include "render/picture/video.h"
#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/scene/scene_needs.h"
#include "sim/scene/settings.h"

namespace kirireel::cli {
namespace {

bool isGiven(const CLI::App& command, const char* option);

/// Only the direct solver has pins, links, searches and guided paths.
bool isDirect(const scene::Scene& scene) {
  return scene.solver.kind == scene::SolverKind::Direct;
}

// ------------------------------------------------------------------------------------------------
// Pictures and videos.

bool hasGrid(const OptionContext& context) {
  return context.pictures->snapshots;
}
bool hasFrames(const OptionContext& context) {
  return context.pictures->paintsFrames();
}
bool hasFramesOrMoments(const OptionContext& context) {
  return hasFrames(context) || !context.pictures->chosenFrames.empty();
}
/// In a run, samples have the rate of the frames.
bool hasFramesOrSamples(const OptionContext& context) {
  return hasFrames(context) || context.exports != nullptr;
}
bool hasVideo(const OptionContext& context) {
  return context.pictures->video;
}
bool hasPicture(const OptionContext& context) {
  return context.pictures->paints() || context.page;
}
bool hasGridOrFrames(const OptionContext& context) {
  return hasGrid(context) || hasFrames(context);
}
bool hasPng(const OptionContext& context) {
  const record::PictureSettings& pictures = *context.pictures;
  return pictures.snapshots || pictures.frames || !pictures.chosenFrames.empty();
}
bool isFigure(const OptionContext& context) {
  return context.runs > 1;
}
bool isOneRun(const OptionContext& context) {
  return context.runs == 1;
}
/// Several runs have a video only if --video was given.
bool isOneRunOrHasVideo(const OptionContext& context) {
  return isOneRun(context) || hasFrames(context);
}
bool hasOutlines(const OptionContext& context) {
  return context.pictures->appearance.outlines;
}
bool showsMeasure(const OptionContext& context) {
  return picture::isMeasure(context.pictures->appearance.colouring);
}
bool showsMeasureOrPage(const OptionContext& context) {
  return showsMeasure(context) || context.page;
}
bool showsPlainColours(const OptionContext& context) {
  const bool hasOthers =
      showsMeasure(context) || context.pictures->appearance.colouring == picture::Colouring::Shape;
  return !hasOthers || context.page;
}
bool mayBePerspective(const OptionContext& context) {
  return context.pictures->appearance.camera.orthographic != true;
}
bool hasPreset(const OptionContext& context) {
  const record::PictureSettings& pictures = *context.pictures;
  return !pictures.encoder.empty() || endingOf(pictures.videoFile) == ".mp4";
}
/// Only a video of --video counts, not the default one.
bool mayBeTransparent(const OptionContext& context) {
  const record::PictureSettings& pictures = *context.pictures;
  if (pictures.video && picture::hasAlpha(pictures.videoFile)) return true;
  const bool isNamed = isGiven(*context.command, "--video");
  return hasPng(context) && !(pictures.video && isNamed);
}

// ------------------------------------------------------------------------------------------------
// Exports and curves.

bool exportsOneOf(const OptionContext& context, std::initializer_list<const char*> formats) {
  return std::ranges::any_of(context.exports->formats, [&](const std::string& format) {
    return std::ranges::find(formats, format) != formats.end();
  });
}
bool hasElements(const OptionContext& context) {
  return exportsOneOf(context, {"inp", "msh"});
}
bool hasDeck(const OptionContext& context) {
  return exportsOneOf(context, {"inp"});
}
bool hasPattern(const OptionContext& context) {
  return exportsOneOf(context, {"svg", "dxf"});
}
/// A cut pattern shows the start, and a GLB file all samples.
bool hasStates(const OptionContext& context) {
  return std::ranges::any_of(context.exports->formats, [](const std::string& format) {
    return format != "svg" && format != "dxf" && format != "glb";
  });
}
bool hasPatches(const OptionContext& context) {
  return context.exports->elements.joints == fea::JointStyle::Patch;
}
bool hasNecks(const OptionContext& context) {
  return context.exports->elements.joints == fea::JointStyle::Neck;
}
bool hasSolids(const OptionContext& context) {
  return context.exports->elements.family == fea::ElementFamily::Solid;
}
/// --plane-stress overrides --shells.
bool hasNoPlane(const OptionContext& context) {
  return context.exports->elements.family != fea::ElementFamily::Plane;
}
/// Sheets with necks are also exported as solids.
bool hasElementsOrNeckSolid(const OptionContext& context) {
  return hasElements(context) || (hasNecks(context) && exportsOneOf(context, {"stl", "step"}));
}
bool countsElements(const OptionContext& context) {
  return context.exports->elements.size == 0;
}
bool hasPlot(const OptionContext& context) {
  return !context.curves->plots.empty();
}
bool hasPngPlot(const OptionContext& context) {
  return std::ranges::find(context.curves->plots, picture::PageFormat::Png) !=
         context.curves->plots.end();
}

// ------------------------------------------------------------------------------------------------
// Scenes.

bool hasGrips(const OptionContext& context) {
  return !context.scene->grips.empty();
}
bool hasNoGrips(const OptionContext& context) {
  return !hasGrips(context);
}
/// Whether paths to a target may be tried. Only these trials switch contacts on by themselves.
bool mayTryPaths(const OptionContext& context) {
  const scene::Scene& scene = *context.scene;
  const scene::Drive drive = scene.actuation.drive;
  return (drive == scene::Drive::Auto || drive == scene::Drive::Target) && isDirect(scene) &&
         scene.timeline.empty() && !isGiven(*context.command, "--pin");
}
bool mayTouch(const OptionContext& context) {
  const scene::ContactFilter contacts = context.scene->environment.contacts;
  if (contacts == scene::ContactFilter::Auto) return mayTryPaths(context);
  return contacts != scene::ContactFilter::None;
}
/// A timeline may name a target later.
bool mayHaveDrive(const OptionContext& context) {
  return context.scene->actuation.drive != scene::Drive::None || !context.scene->timeline.empty();
}
/// Whether the run may be a kinematic path. The model, which is read later, decides whether targets
/// or expansion need dynamics.
bool mayBeKinematic(const OptionContext& context) {
  scene::Scene scene = *context.scene;
  if (scene.path.kind == scene::PathKind::Continuation) return true;
  if (scene.path.kind != scene::PathKind::Auto) return false;
  scene::Drive& drive = scene.actuation.drive;
  const bool mayFollow = drive == scene::Drive::Auto || drive == scene::Drive::Target ||
                         drive == scene::Drive::Expansion;
  if (!mayFollow) return false;
  drive = scene::defaultDrive(scene.model);
  std::string reason;
  return scene::isQuasiStatic(scene, reason);
}
bool hasPlayTime(const OptionContext& context) {
  return hasGrips(context) || mayBeKinematic(context);
}
bool mayBeDynamic(const OptionContext& context) {
  const scene::PathSettings& path = context.scene->path;
  return hasNoGrips(context) && path.kind != scene::PathKind::Continuation &&
         path.to != scene::Destination::Closed;
}
bool maySearch(const OptionContext& context) {
  const scene::PathKind path = context.scene->path.kind;
  return hasNoGrips(context) && isDirect(*context.scene) && path != scene::PathKind::Straight &&
         path != scene::PathKind::Guided;
}

// ------------------------------------------------------------------------------------------------
// The table.

constexpr const char* kGrid = "Remove --no-snapshots";
constexpr const char* kNoFrames = "without frames of a video";
constexpr const char* kFrames = "Remove --no-video, add --frames";
constexpr const char* kSeveral = "in a figure of several runs";
constexpr const char* kNoElements = "without finite elements";
constexpr const char* kElements = "Export inp or msh";
constexpr const char* kNoMeasure = "without a measure to colour by";
constexpr const char* kMeasure = "Add --colour error or another measure";

constexpr OptionEffect kPictureEffects[] = {
    {"--grid,--letters,--arrows,--column-heads,--width,--font-size,--figure,--svg,--snapshots",
     hasGrid, "without the snapshot grid", kGrid},
    {"--captions,--scale-bar", hasGridOrFrames, "without the snapshot grid and a video",
     "Remove --no-snapshots or --no-video"},
    {"--dpi", hasPng, "without a PNG file", kGrid},
    {"--same-view,--same-scale", isFigure, "with one run", "Give kirireel render several runs"},
    {"--no-snapshots,--fps,--length,--hold,--title,--subtitle,--progress-bar,--inset,"
     "--crf,--preset,--encoder",
     isOneRunOrHasVideo, kSeveral, "Add --video both.mp4"},
    {"--frames-at", isOneRun, kSeveral, "Render the runs one by one"},
    {"--video,--crf,--encoder,--preset", hasVideo, "without a video", "Remove --no-video"},
    {"--preset", hasPreset, "in a video that is not H.264", "Use .mp4"},
    {"--length,--hold,--title,--subtitle,--progress-bar", hasFrames, kNoFrames, kFrames},
    {"--fps", hasFramesOrSamples, kNoFrames, kFrames},
    {"--inset,--painters", hasFramesOrMoments, kNoFrames, kFrames},
    {"--transparent", mayBeTransparent, "in a video of this format, which is opaque",
     "Use .webm, .gif, .apng, .mkv or .mov, or --frames with --no-video"},
    {"--colour-map", showsMeasureOrPage, kNoMeasure, kMeasure},
    {"--colour-least,--colour-most", showsMeasure, kNoMeasure, kMeasure},
    {"--brick-colour,--back-colour", showsPlainColours, "with colours that show something else",
     "Add --colour plain"},
    {"--outline-colour,--outline-width", hasOutlines, "without outlines", "Remove --no-outlines"},
    {"--distance", mayBePerspective, "in a parallel projection", "Use --projection perspective"},
    {"Style,Camera", hasPicture, "without a picture", kGrid}};

constexpr OptionEffect kExportEffects[] = {
    {"--joints,--neck-width,--neck-length,--neck-radius,--kerf", hasElementsOrNeckSolid,
     kNoElements, kElements},
    {"--elements-per-edge,--element-size,--elements-through,--linear,--patch-radius,--shells,"
     "--plane-stress,--sets",
     hasElements, kNoElements, kElements},
    {"--patch-radius", hasPatches, "without rigid patches", "Add --joints patch"},
    {"--neck-width,--neck-length,--neck-radius,--kerf", hasNecks, "without necks",
     "Add --joints neck"},
    {"--elements-per-edge", countsElements, "next to --element-size", "Use only one of them"},
    {"--elements-through", hasSolids, "in shells and plane elements",
     "Remove --shells or --plane-stress"},
    {"--shells", hasNoPlane, "next to --plane-stress", "Use only one of them"},
    {"--deck-solver,--youngs,--poisson,--deck-density,--deck-unit,--drive,--buckle,--periodic,"
     "--deck-contacts,--state-map,--check",
     hasDeck, "without a deck", "Export inp"},
    {"--hinge-width", hasPattern, "without a cut pattern", "Export svg or dxf"},
    {"--states", hasStates, "without files of states", "Export another format than svg, dxf, glb"}};

constexpr OptionEffect kCurvesEffects[] = {
    {"--curves,--column,--against,--width,--font-size", hasPlot, "without a figure",
     "Add --plot svg"},
    {"--dpi", hasPngPlot, "without a PNG figure", "Add --plot png"}};

constexpr OptionEffect kSceneEffects[] = {
    {"--brick-friction", mayTouch, "without contacts", "Use --contacts all"},
    {"--load-steps", hasGrips, "without [[grip]] in the scene file", "Add a grip"},
    {"Springs to the target", mayHaveDrive, "without a drive", "Remove --actuation none"},
    {"--actuation,--path,--joint-ratio", hasNoGrips, "with [[grip]]", "Remove the grips"},
    {"--walk-time", hasPlayTime, "with dynamics", "Use --path continuation"},
    {"--timestep,--seed,--tolerance", mayBeDynamic, "without dynamics",
     "Use --path dynamic without [[grip]]"},
    {"--search-effort", maySearch, "without a search for a path",
     "Use --path auto with --solver direct"}};

}  // namespace

const std::vector<OptionEffect>& optionEffects() {
  static const std::vector<OptionEffect> effects = [] {
    std::vector<OptionEffect> all;
    const auto add = [&all](std::span<const OptionEffect> rows,
                            bool (*isApplicable)(const OptionContext&)) {
      for (const OptionEffect& row : rows) {
        for (const std::string_view option : scene::split(row.option, ','))
          all.push_back({option, row.holds, row.reason, row.remedy, isApplicable});
      }
    };
    add(kPictureEffects, [](const OptionContext& context) { return context.pictures != nullptr; });
    add(kExportEffects, [](const OptionContext& context) { return context.exports != nullptr; });
    add(kCurvesEffects, [](const OptionContext& context) { return context.curves != nullptr; });
    add(kSceneEffects, [](const OptionContext& context) { return context.scene != nullptr; });
    return all;
  }();
  return effects;
}

// ------------------------------------------------------------------------------------------------
// The check of the given options.

namespace {

/// The condition for an effect of this option in this command.
std::vector<scene::Condition> conditionsOf(const std::string& option) {
  // Options for the parts of the model are not settings.
  if (option == "--pin" || option == "--link") return {{isDirect, "`solver = direct`"}};
  for (const scene::SettingGroup& group : scene::sceneSettings()) {
    const auto found = std::ranges::find(group.settings, option, [](const scene::Setting& setting) {
      return optionName(setting.key);
    });
    if (found != group.settings.end()) return found->conditions;
  }
  return {};
}

/// On the command line or in a scene file, which adds its values to the same option.
bool isGiven(const CLI::App& command, const char* option) {
  const CLI::Option* found = command.get_option_no_throw(option);
  return found && found->count() > 0;
}

/// The options with this condition: one, or all of a group.
std::vector<const CLI::Option*> optionsOf(const OptionEffect& effect, const CLI::App& command) {
  const std::string name(effect.option);
  if (name.starts_with("--")) {
    const CLI::Option* option = command.get_option_no_throw(name);
    if (option) return {option};
    return {};
  }
  return command.get_options(
      [&](const CLI::Option* option) { return option->get_group() == name; });
}

[[noreturn]] void refuseEquivalent(const std::string& option, const std::string& others) {
  throw InputError(
      fmt::format("error: {} and {} are equivalent. Use only one of them", option, others));
}

[[noreturn]] void refuse(const std::string& option, const std::string& needed) {
  throw InputError(
      fmt::format("error: {0} works only with {1}. Add {1} or remove {0}", option, needed));
}

/// Whether an option was given with this word; the last one counts.
bool isChosen(const CLI::App& command, const char* option, const char* word) {
  return isGiven(command, option) && command.get_option(option)->results().back() == word;
}

}  // namespace

bool hasEffect(const std::string& option, const scene::Scene& scene) {
  return std::ranges::all_of(conditionsOf(option), [&](const scene::Condition& condition) {
    return condition.holds(scene);
  });
}

void requireConsistentPace(const CLI::App& command) {
  if (isGiven(command, "--speed") && isChosen(command, "--pace", "even")) {
    refuse("--speed", "--pace real");
  }
  if (isGiven(command, "--length") && isChosen(command, "--pace", "real")) {
    refuse("--length", "--pace even");
  }
  if (isGiven(command, "--length") && isGiven(command, "--speed")) {
    throw InputError(
        "error: --length is for an even pace and --speed for real time. Remove one of them");
  }
}

void requireConsistent(const CLI::App& command, const scene::Scene& scene) {
  requireConsistentPace(command);
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0) continue;
    for (const scene::Condition& condition : conditionsOf(option->get_name())) {
      if (condition.holds(scene)) continue;
      if (condition.isWithout) refuseEquivalent(option->get_name(), spellOptions(condition.needed));
      refuse(option->get_name(), spellOptions(condition.needed));
    }
  }
  // A guided path moves tiles to the target in its own steps, only with the direct solver.
  const bool isGuided = scene.path.kind == scene::PathKind::Guided;
  const scene::Drive drive = scene.actuation.drive;
  const bool pullsToTarget = drive == scene::Drive::Target || drive == scene::Drive::Auto;
  if (isGuided && !isDirect(scene)) refuse("--path guided", "--solver direct");
  if (isGuided && !pullsToTarget) refuse("--path guided", "--actuation target");
  for (const auto& [isSet, option] :
       {std::pair(scene.solver.isToleranceGiven(), "--tolerance"),
        std::pair(scene.solver.measuresTimeError, "--measure-time-error")}) {
    if (!isGuided || !isSet) continue;
    throw InputError(
        fmt::format("error: --path guided moves tiles in fixed steps and has no {}. Remove one of "
                    "them",
                    option));
  }
}

std::set<std::string> givenOptions(const CLI::App& command) {
  std::set<std::string> given;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() > 0) given.insert(option->get_name());
  }
  return given;
}

void requireEffect(const OptionContext& context, const std::set<std::string>& given) {
  for (const OptionEffect& effect : optionEffects()) {
    if (!effect.isApplicable(context) || effect.holds(context)) continue;
    for (const CLI::Option* option : optionsOf(effect, *context.command)) {
      if (!given.contains(option->get_name())) continue;
      throw InputError(fmt::format("error: {0} has no effect {1}. {2} or remove {0}",
                                   option->get_name(), effect.reason, effect.remedy));
    }
  }
}

}  // namespace kirireel::cli
