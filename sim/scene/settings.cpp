// The list of settings. Each setting is one expression: a pattern (`number`, `whole`, `choice`,
// `flag`, or `special` with its own functions) with the member path of its field, its key, range,
// unit and help. Conditions (`with`, `without`) and the need for dynamics (`needsDynamics`) follow.
//
// Defaults come from openScene() and are not repeated. The help, the range checks and the values of
// a scene made in code are therefore consistent.
#include "sim/scene/settings.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/scene/toml_file.h"

namespace kirireel::scene {
namespace {

// A bound against typing errors; springs of 1e12 N/m are beyond any material at these sizes.
constexpr Range kFromZero{0, 1e12};

/// Whether the path is one on which joints may be compliant.
bool mayOpenJoints(const Scene& scene) {
  const PathKind kind = scene.path.kind;
  return kind == PathKind::Auto || kind == PathKind::Continuation || kind == PathKind::Guided;
}

bool isGuided(const Scene& scene) {
  return scene.path.kind == PathKind::Guided;
}
bool isDirect(const Scene& scene) {
  return scene.solver.kind == SolverKind::Direct;
}
bool isBullet(const Scene& scene) {
  return scene.solver.kind == SolverKind::Bullet;
}
bool mayHaveFixedSteps(const Scene& scene) {
  return !scene.solver.isToleranceGiven();
}
bool hasTolerance(const Scene& scene) {
  return isDirect(scene) && scene.solver.tolerance > 0 && !scene.solver.substeps;
}
bool isDirectOrFixed(const Scene& scene) {
  return isDirect(scene) || mayHaveFixedSteps(scene);
}
bool hasHingeSprings(const Scene& scene) {
  return scene.hinges.stiffness > 0 || scene.hinges.neck || !scene.hinges.file.empty();
}
bool hasNecks(const Scene& scene) {
  return scene.hinges.neck.has_value();
}
bool hasNoNecks(const Scene& scene) {
  return !hasNecks(scene);
}
bool pullsToCurve(const Scene& scene) {
  return scene.actuation.drive == Drive::Boundary;
}
bool hasFrequency(const Scene& scene) {
  return !scene.springs.springStiffness || !scene.springs.torqueStiffness;
}
bool hasDampingRatio(const Scene& scene) {
  return !scene.springs.forceDamping || !scene.springs.torqueDamping;
}
bool weighsByVolume(const Scene& scene) {
  return scene.brick.mass == brick::MassRule::Prism;
}

constexpr const char* kDirect = "`solver = direct`";
constexpr const char* kGuided = "`path = guided`";
constexpr const char* kOtherSprings = "springs or damping were given";
constexpr const char* kOtherSolver = "the solver was given";

/// The field of a scene with this member path. `Path` are pointers to members, applied in sequence:
/// number<&Scene::path, &PathSettings::guideTime>(...) is the field scene.path.guideTime.
template <auto... Path>
auto& fieldOf(auto&& scene) {
  return (scene.*....*Path);
}

/// A number, by default as in an open scene.
template <auto... Path>
Setting number(const std::string& key, Range range, const std::string& unit,
               const std::string& help) {
  Setting setting{key, unit, help};
  setting.read = [range](Scene& scene, const TypedValue& typed) {
    fieldOf<Path...>(scene) = parseNumber(typed, range);
  };
  setting.write = [](const Scene& scene) { return numberText(fieldOf<Path...>(scene)); };
  setting.defaultText = fmt::format("{:.4g}", fieldOf<Path...>(openScene()));
  setting.isNumber = true;
  return setting;
}

/// A whole number.
template <auto... Path>
Setting whole(const std::string& key, Range range, const std::string& unit,
              const std::string& help) {
  Setting setting{key, unit, help};
  setting.read = [range](Scene& scene, const TypedValue& typed) {
    auto& field = fieldOf<Path...>(scene);
    field = static_cast<std::remove_reference_t<decltype(field)>>(parseInteger(typed, range));
  };
  setting.write = [](const Scene& scene) { return fmt::format("{}", fieldOf<Path...>(scene)); };
  setting.defaultText = setting.write(openScene());
  setting.isNumber = true;
  return setting;
}

/// One of several words, the first by default.
template <auto... Path, typename T>
Setting choice(const std::string& key, const Choices<T>& choices, const std::string& help) {
  Setting setting{key, "WORD", help};
  setting.words = choiceNames(choices);
  setting.help = fmt::format("{}: {}", help, listWords(setting.words));
  setting.read = [choices](Scene& scene, const TypedValue& typed) {
    fieldOf<Path...>(scene) = parseChoice(typed, choices);
  };
  setting.write = [choices](const Scene& scene) {
    return quotedText(nameOfChoice(choices, fieldOf<Path...>(scene)));
  };
  setting.defaultText = setting.words.front();
  return setting;
}

/// A setting that fits none of the patterns above.
Setting special(const std::string& key, const std::string& unit, const std::string& defaultText,
                const std::string& help, std::function<void(Scene&, const TypedValue&)> read,
                std::function<std::string(const Scene&)> write) {
  return {key, unit, help, std::move(read), std::move(write), defaultText};
}

/// The same for a number.
Setting specialNumber(const std::string& key, const std::string& unit,
                      const std::string& defaultText, const std::string& help,
                      std::function<void(Scene&, const TypedValue&)> read,
                      std::function<std::string(const Scene&)> write) {
  Setting setting = special(key, unit, defaultText, help, std::move(read), std::move(write));
  setting.isNumber = true;
  return setting;
}

/// A switch, which sets a boolean to `given`.
template <auto... Path>
Setting flag(const std::string& key, const std::string& help, bool given = true) {
  Setting setting{key, "", help};
  setting.read = [given](Scene& scene, const TypedValue&) { fieldOf<Path...>(scene) = given; };
  setting.write = [given](const Scene& scene) {
    return fmt::format("{}", fieldOf<Path...>(scene) == given);
  };
  setting.isSwitch = true;
  return setting;
}

SettingGroup brickSettings() {
  using enum brick::MassRule;
  return {"Bricks",
          "model",
          {specialNumber(
               "thickness", "LENGTH", "0.02 of the mean edge", "thickness of the bricks",
               [](Scene& scene, const TypedValue& typed) {
                 scene.brick.thickness = parseNumber(typed, {1e-15, 1e9});
               },
               [](const Scene& scene) {
                 return scene.brick.thickness > 0 ? numberText(scene.brick.thickness) : "";
               }),
           choice<&Scene::brick, &brick::BrickRule::mass>(
               "mass", Choices<brick::MassRule>{{"unit", Unit}, {"prism", Prism}},
               "mass of a brick: 1 kg, or by volume")
               .needsDynamics("masses were given"),
           number<&Scene::brick, &brick::BrickRule::density>("density", {1e-9, 1e12}, "KG/M3",
                                                             "density, with `mass = prism`")
               .with(weighsByVolume, "`mass = prism`")}};
}

SettingGroup actuationSettings() {
  using enum Drive;
  return {"Actuation",
          "actuation",
          {choice<&Scene::actuation, &Actuation::drive>(
               "actuation",
               Choices<Drive>{{"auto", Auto},
                              {"target", Target},
                              {"expansion", Expansion},
                              {"boundary", Boundary},
                              {"none", None}},
               "drive of the bricks; auto: target if there is one, else expansion from the centre; "
               "boundary: springs from the hull to a curve around it"),
           number<&Scene::actuation, &Actuation::boundary, &BoundaryCurve::size>(
               "boundary_size", {1e-3, 1e3}, "RATIO", "width of that curve over the hull's")
               .with(pullsToCurve, "`actuation = boundary`"),
           number<&Scene::actuation, &Actuation::boundary, &BoundaryCurve::aspect>(
               "boundary_aspect", {1e-3, 1e3}, "RATIO",
               "its length along x over its width, 1 for a circle")
               .with(pullsToCurve, "`actuation = boundary`")}};
}

/// A strength of the springs in newtons; the model determines its default.
template <auto... Path>
Setting givenStrength(const std::string& key, const std::string& unit,
                      const std::string& defaultText, const std::string& help) {
  return specialNumber(
      key, unit, defaultText, help,
      [](Scene& scene, const TypedValue& typed) {
        fieldOf<Path...>(scene) = parseNumber(typed, kFromZero);
      },
      [](const Scene& scene) {
        const std::optional<double>& strength = fieldOf<Path...>(scene);
        return strength ? numberText(*strength) : "";
      });
}

SettingGroup springSettings() {
  using Springs = TargetSpringSettings;
  return {"Springs to the target",
          "actuation",
          {number<&Scene::springs, &Springs::frequency>(
               "spring_frequency", {1e-6, 1e6}, "HZ",
               "natural frequency of one brick on its vertex springs")
               .without(hasFrequency, "`spring_stiffness` with `torque_stiffness`")
               .needsDynamics(kOtherSprings),
           number<&Scene::springs, &Springs::dampingRatio>(
               "damping_ratio", {0, 1e6}, "RATIO",
               "damping ratio of those springs, 1 for critical damping")
               .without(hasDampingRatio, "`force_damping` with `torque_damping`")
               .needsDynamics(kOtherSprings),
           givenStrength<&Scene::springs, &Springs::springStiffness>(
               "spring_stiffness", "N/M", "by frequency and mass",
               "stiffness of the spring from each vertex to its target, equal for all bricks")
               .needsDynamics(kOtherSprings),
           givenStrength<&Scene::springs, &Springs::torqueStiffness>(
               "torque_stiffness", "N/M", "by frequency and mass",
               "stiffness of those springs for rotations")
               .needsDynamics(kOtherSprings),
           givenStrength<&Scene::springs, &Springs::forceDamping>(
               "force_damping", "N*S/M", "by ratio and mass", "damping of a brick's velocity")
               .needsDynamics(kOtherSprings),
           givenStrength<&Scene::springs, &Springs::torqueDamping>(
               "torque_damping", "N*M*S", "by ratio and inertia", "damping of a brick's rotation")
               .needsDynamics(kOtherSprings),
           flag<&Scene::springs, &Springs::adaptive>(
               "no_adaptive", "do not double the stiffness when the error stalls", false)
               .needsDynamics(kOtherSprings)}};
}

Setting hingeRest() {
  return specialNumber(
      "hinge_rest", "DEGREES", "a fold's in a FOLD file, else the angle at the start",
      "rest angle of the springs: at a corner between the tiles' edges, at a fold from flat, with "
      "valleys above 0",
      [](Scene& scene, const TypedValue& typed) {
        scene.hinges.rest = parseNumber(typed, {-360, 360}) * kDegree;
      },
      [](const Scene& scene) {
        const std::optional<double>& rest = scene.hinges.rest;
        if (!rest) return std::string();
        return numberText(
            numberReadAs(*rest, *rest / kDegree, [](double degrees) { return degrees * kDegree; }));
      });
}

/// The parts of a value with commas. `requested` describes them in the error for fewer or more.
class NumberList {
 public:
  NumberList(const TypedValue& value, std::size_t least, std::size_t most, const char* requested)
      : name_(value.name), parts_(split(value.text, ',')) {
    if (size() < least || size() > most) throw valueError(value, requested);
  }

  std::size_t size() const { return parts_.size(); }
  double at(std::size_t k, const Range& range) const {
    return parseNumber({name_, std::string(parts_[k])}, range);
  }

 private:
  std::string name_;
  std::vector<std::string_view> parts_;
};

/// "2e9" or "2e9,0.3": material of the model's necks. "0.1,0.3,2e9" or "0.1,0.3,2e9,0.3": also
/// their width and length.
HingeNeck parseNeck(const TypedValue& value) {
  const NumberList parts(value, 1, 4, "width, length and Young's modulus, for example 0.1,0.3,2e9");
  // Up to two numbers are only the material.
  const std::size_t material = parts.size() > 2 ? 2 : 0;
  HingeNeck neck;
  if (material > 0) {
    neck.width = parts.at(0, {1e-9, 1e6});
    neck.length = parts.at(1, {0, 1e6});
  }
  neck.youngs = parts.at(material, {1e-9, 1e15});
  if (parts.size() > material + 1) neck.poisson = parts.at(material + 1, {0, 0.5, true});
  return neck;
}

LigamentStiffness parseLigament(const TypedValue& value) {
  const NumberList parts(
      value, 3, 3, "stiffness of stretch and of shear in N/m, and a length, for example 120,1,0.1");
  return {parts.at(0, {1e-9, 1e15}), parts.at(1, {1e-9, 1e15}), parts.at(2, {1e-9, 1e6})};
}

PanelMaterial parsePanels(const TypedValue& value) {
  const NumberList parts(
      value, 1, 3, "Young's modulus, Poisson's ratio and a length of folds, for example 2e9,0.3");
  PanelMaterial panels{parts.at(0, {1e-9, 1e15})};
  if (parts.size() > 1) panels.poisson = parts.at(1, {0, 0.5, true});
  if (parts.size() > 2) panels.foldLength = parts.at(2, {0, 1e9});
  return panels;
}

SettingGroup hingeSettings() {
  return {
      "Hinges",
      "model",
      {number<&Scene::hinges, &HingeSettings::stiffness>(
           "hinge_stiffness", kFromZero, "N*M/RAD",
           "torsional springs at all hinges: corners in the plane or joined on both faces, and "
           "folds")
           .with(isDirect, kDirect),
       special(
           "hinge_neck", "[WIDTH,LENGTH,]E[,NU]", "",
           "necks at all corners instead of a stiffness: two lengths (absent: the model's own "
           "necks), Young's modulus in Pa and Poisson's ratio (0.3)",
           [](Scene& scene, const TypedValue& typed) { scene.hinges.neck = parseNeck(typed); },
           [](const Scene& scene) -> std::string {
             const std::optional<HingeNeck>& neck = scene.hinges.neck;
             if (!neck) return "";
             const std::string size =
                 neck->width > 0 ? fmt::format("{},{},", neck->width, neck->length) : "";
             return quotedText(fmt::format("{}{},{}", size, neck->youngs, neck->poisson));
           })
           .with(isDirect, kDirect),
       flag<&Scene::hinges, &HingeSettings::areLigaments>(
           "ligaments",
           "necks stretch, shear and bend, instead of bending about exact joints; in the plane")
           .with(hasNecks, "`hinge_neck`"),
       special(
           "ligament_stiffness", "STRETCH,SHEAR,LENGTH", "",
           "ligaments of this stiffness (N/m, N/m) and length at all corners; "
           "`hinge_stiffness` is their stiffness in bending; in the plane",
           [](Scene& scene, const TypedValue& typed) {
             scene.hinges.ligament = parseLigament(typed);
           },
           [](const Scene& scene) {
             const std::optional<LigamentStiffness>& own = scene.hinges.ligament;
             return own ? quotedText(fmt::format("{},{},{}", own->stretch, own->shear, own->length))
                        : "";
           })
           .with(hasHingeSprings, "`hinge_stiffness` or `hinge_file`")
           .without(hasNoNecks, "`hinge_neck`"),
       special(
           "panels", "E[,NU[,LENGTH]]", "",
           "elastic tiles: Young's modulus in Pa, Poisson's ratio (0.3), length scale of folds; "
           "they stretch and bend with [[grip]], and bend in motion with `split_tiles`",
           [](Scene& scene, const TypedValue& typed) { scene.hinges.panels = parsePanels(typed); },
           [](const Scene& scene) {
             const std::optional<PanelMaterial>& own = scene.hinges.panels;
             return own ? quotedText(
                              fmt::format("{},{},{}", own->youngs, own->poisson, own->foldLength))
                        : "";
           })
           .with(isDirect, kDirect)
           .needsSpace([](const Scene& scene) { return scene.hinges.panels.has_value(); },
                       "tiles bend"),
       hingeRest().with(hasHingeSprings, "`hinge_stiffness`, `hinge_neck` or `hinge_file`"),
       number<&Scene::hinges, &HingeSettings::damping>("hinge_damping", kFromZero, "N*M*S/RAD",
                                                       "damping of the hinges' angles")
           .with(isDirect, kDirect),
       special(
           "hinge_file", "FILE", "",
           "file with one hinge per line: tile, tile, stiffness, rest angle, damping; - as for all "
           "hinges",
           [](Scene& scene, const TypedValue& typed) { scene.hinges.file = typed.text; },
           [](const Scene& scene) { return quotedText(scene.hinges.file.string()); })
           .with(isDirect, kDirect)}};
}

SettingGroup pathSettings() {
  return {
      "Path to the target",
      "actuation",
      {choice<&Scene::path, &PathSettings::to>(
           "to", Choices<Destination>{{"auto", Destination::Auto}, {"closed", Destination::Closed}},
           "where the sheet goes; auto: to the target, else to full extension; closed: beyond full "
           "extension until the tiles meet again"),
       choice<&Scene::path, &PathSettings::kind>(
           "path",
           Choices<PathKind>{{"auto", PathKind::Auto},
                             {"continuation", PathKind::Continuation},
                             {"dynamic", PathKind::Dynamic},
                             {"straight", PathKind::Straight},
                             {"guided", PathKind::Guided}},
           "continuation: kinematic; dynamic: springs move masses, straight or along a kinematic "
           "path; guided: springs move each tile along its own motion; auto: continuation if "
           "nothing needs dynamics"),
       number<&Scene::path, &PathSettings::playTime>("walk_time", {1e-6, 1e6}, "SECONDS",
                                                     "playback time of a kinematic path"),
       whole<&Scene::path, &PathSettings::loadSteps>(
           "load_steps", {1, 1e6}, "COUNT",
           "minimum number of equilibria up to the full load, with [[grip]]"),
       number<&Scene::path, &PathSettings::openTime>(
           "open_time", kFromZero, "SECONDS",
           "duration of the initial expansion from the centre, with `path = guided`")
           .with(isGuided, kGuided),
       number<&Scene::path, &PathSettings::guideTime>("guide_time", {1e-6, 1e6}, "SECONDS",
                                                      "duration of guiding, with `path = guided`")
           .with(isGuided, kGuided),
       specialNumber(
           "joint_ratio", "R", "exact joints first, softer ones if they do not arrive",
           "stiffness of compliant joints, over the stiffness of one tile's springs",
           [](Scene& scene, const TypedValue& typed) {
             scene.path.jointRatio = parseNumber(typed, {1e-6, 1e12});
           },
           [](const Scene& scene) {
             return scene.path.jointsAreCompliant() ? numberText(scene.path.jointRatio) : "";
           })
           .with(isDirect, kDirect)
           .with(mayOpenJoints, "`path = auto`, `path = continuation` or `path = guided`"),
       number<&Scene::path, &PathSettings::searchEffort>(
           "search_effort", {0, 1e9}, "FACTOR",
           "factor on the work limit of the search for a path")}};
}

/// The ground; added if there is none yet.
Ground& groundOf(Scene& scene) {
  // Any setting of the ground adds one. Its default height comes later, from the model.
  std::optional<Ground>& ground = scene.environment.ground;
  return ground ? *ground : ground.emplace();
}

Setting groundSwitch() {
  Setting setting{"ground", "",
                  "add a horizontal plane under the lowest point of start and target"};
  setting.read = [](Scene& scene, const TypedValue&) { groundOf(scene); };
  setting.write = [](const Scene& scene) {
    return fmt::format("{}", scene.environment.ground.has_value());
  };
  setting.isSwitch = true;
  return setting;
}

Setting groundFriction() {
  return specialNumber(
      "ground_friction", "RATIO", "0.5", "Coulomb friction of the ground; implies `ground`",
      [](Scene& scene, const TypedValue& typed) {
        groundOf(scene).friction = parseNumber(typed, {0, 1e3});
      },
      [](const Scene& scene) {
        const std::optional<Ground>& ground = scene.environment.ground;
        return ground ? numberText(ground->friction) : "";
      });
}

SettingGroup environmentSettings() {
  return {
      "Environment",
      "environment",
      {special(
           "gravity", "M/S2", "0", "acceleration along z, or X,Y,Z",
           [](Scene& scene, const TypedValue& typed) {
             scene.environment.gravity = parseGravity(typed);
           },
           [](const Scene& scene) {
             return fmt::format("[{}]", fmt::join(scene.environment.gravity, ", "));
           })
           .needsDynamics("there is gravity"),
       groundSwitch().needsDynamics("there is ground or an obstacle"), groundFriction(),
       choice<&Scene::environment, &Environment::contacts>(
           "contacts",
           Choices<ContactFilter>{{"auto", ContactFilter::Auto},
                                  {"none", ContactFilter::None},
                                  {"unjoined", ContactFilter::Unjoined},
                                  {"all", ContactFilter::All}},
           "pairs of bricks that collide; auto: all if bricks would overlap on the path, else "
           "none"),
       number<&Scene::environment, &Environment::brickFriction>("brick_friction", {0, 1e3}, "RATIO",
                                                                "Coulomb friction between bricks")
           .needsDynamics("there is friction"),
       number<&Scene::environment, &Environment::linearDamping>(
           "linear_damping", {0, 1, true}, "SHARE", "fraction of velocity lost per second")
           .needsDynamics(kOtherSprings),
       number<&Scene::environment, &Environment::angularDamping>(
           "angular_damping", {0, 1, true}, "SHARE", "fraction of angular velocity lost per second")
           .needsDynamics(kOtherSprings)}};
}

SettingGroup stopSettings() {
  return {"End of the run",
          "stop",
          {number<&Scene::stop, &StopRules::duration>(
              "duration", {1e-6, 1e6}, "SECONDS",
              "limit of simulated time; a run at rest ends earlier")}};
}

SettingGroup solverSettings() {
  return {"Solver",
          "solver",
          {choice<&Scene::solver, &SolverSettings::kind>(
               "solver",
               Choices<SolverKind>{{"direct", SolverKind::Direct}, {"bullet", SolverKind::Bullet}},
               "solver of the joints: exact, or Bullet's impulses")
               .needsDynamics(kOtherSolver),
           number<&Scene::solver, &SolverSettings::tolerance>(
               "tolerance", {0, 1}, "TILES",
               "error in time allowed per step, which sets the step length; 0: fixed steps of "
               "first order")
               .with(isDirectOrFixed, kDirect)
               .needsDynamics(kOtherSolver),
           flag<&Scene::solver, &SolverSettings::measuresTimeError>(
               "measure_time_error",
               "run again with a hundredth of the tolerance and report the difference")
               .with(hasTolerance, "`tolerance` above 0")
               .needsDynamics(kOtherSolver),
           number<&Scene::solver, &SolverSettings::timestep>(
               "timestep", {1e-7, 1}, "SECONDS",
               "length of fixed steps, also used among many contacts and at singular joints"),
           specialNumber(
               "substeps", "COUNT", "1 direct, 20 bullet", "solver steps in each step",
               [](Scene& scene, const TypedValue& typed) {
                 scene.solver.substeps = static_cast<int>(parseInteger(typed, {1, 10000}));
               },
               [](const Scene& scene) {
                 return scene.solver.substeps ? fmt::format("{}", *scene.solver.substeps) : "";
               })
               .with(mayHaveFixedSteps, "`tolerance = 0`")
               .needsDynamics(kOtherSolver),
           whole<&Scene::solver, &SolverSettings::iterations>("iterations", {1, 1000000}, "COUNT",
                                                              "of Bullet's solver in each step")
               .with(isBullet, "`solver = bullet`"),
           choice<&Scene::solver, &SolverSettings::planar>(
               "planar",
               Choices<std::optional<bool>>{{"auto", std::nullopt}, {"on", true}, {"off", false}},
               "keep bricks in their plane"),
           whole<&Scene::solver, &SolverSettings::seed>(
               "seed", {0, 4294967295.0}, "NUMBER",
               "seed of the perturbation that breaks symmetric starts")}};
}

/// Whether a setting has its default, in the program or in code.
bool isDefault(const Setting& setting, const Scene& scene) {
  const std::string text = setting.write(scene);
  // Scenes made in code have the defaults of their structs, those of the program have
  // openScene()'s. Neither is a choice of the user.
  return text == setting.write(openScene()) || text == setting.write({});
}

}  // namespace

Setting Setting::with(bool (*holds)(const Scene&), const char* needed) && {
  conditions.push_back({holds, needed});
  return std::move(*this);
}

Setting Setting::without(bool (*holds)(const Scene&), const char* others) && {
  conditions.push_back({holds, others, true});
  return std::move(*this);
}

Setting Setting::needsSpace(bool (*holds)(const Scene&), const char* why) && {
  isSpatial = holds;
  space = why;
  return std::move(*this);
}

Setting Setting::needsDynamics(const char* why) && {
  dynamics = why;
  return std::move(*this);
}

const std::vector<SettingGroup>& sceneSettings() {
  static const std::vector<SettingGroup> groups = {
      brickSettings(), actuationSettings(),   springSettings(), hingeSettings(),
      pathSettings(),  environmentSettings(), stopSettings(),   solverSettings()};
  return groups;
}

const Setting& sceneSetting(const std::string& key) {
  for (const SettingGroup& group : sceneSettings()) {
    const auto found = std::ranges::find(group.settings, key, &Setting::key);
    if (found != group.settings.end()) return *found;
  }
  throw std::out_of_range("no setting " + key);
}

void requireRanges(const Scene& scene) {
  Scene read;
  for (const SettingGroup& group : sceneSettings()) {
    for (const Setting& setting : group.settings) {
      // Writing a value and reading it again checks it against its range, with the message for the
      // user.
      const std::string text = setting.isNumber ? setting.write(scene) : "";
      if (!text.empty()) setting.read(read, {setting.key, text});
    }
  }
}

std::string whySpace(const Scene& scene) {
  for (const SettingGroup& group : sceneSettings()) {
    for (const Setting& setting : group.settings) {
      if (setting.isSpatial && setting.isSpatial(scene)) return setting.space;
    }
  }
  return "";
}

std::string whyDynamics(const Scene& scene) {
  for (const SettingGroup& group : sceneSettings()) {
    for (const Setting& setting : group.settings) {
      if (!setting.dynamics.empty() && !isDefault(setting, scene)) return setting.dynamics;
    }
  }
  return "";
}

// ------------------------------------------------------------------------------------------------
// Conversion of texts to values and back. std::from_chars reads numbers independent of the locale.
// They are written with the fewest digits that read back as the same double. A converted value
// (degrees to radians) gets the digits that give the same bits when they are converted again. The
// search tries 6 to 17 digits, then the doubles next to the guess.

namespace {

template <typename T>
std::optional<T> readAll(std::string_view text) {
  // from_chars does not accept a plus sign, but users write it.
  if (text.starts_with('+')) text.remove_prefix(1);
  T number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  // The whole text must be the number.
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::string describe(Range range, const char* kind) {
  const Range all;
  if (range.least == all.least && range.most == all.most) return kind;
  if (range.most == all.most) return fmt::format("{} of at least {:g}", kind, range.least);
  return fmt::format("{} from {:g} to {}{:g}", kind, range.least,
                     range.excludesMost ? "less than " : "", range.most);
}

}  // namespace

std::optional<double> readNumber(std::string_view text) {
  return readAll<double>(text);
}

std::optional<long> readWhole(std::string_view text) {
  return readAll<long>(text);
}

// The parts refer to the text, which must outlive them.
std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

double parseNumber(const TypedValue& value, Range range) {
  const std::optional<double> number = readNumber(value.text);
  // from_chars also reads "inf" and "nan".
  if (number && std::isfinite(*number) && range.holds(*number)) return *number;
  const std::string& text = value.text;
  const bool hasUnit = !number && !text.empty() &&
                       std::isdigit(static_cast<unsigned char>(text.front())) != 0 &&
                       std::isalpha(static_cast<unsigned char>(text.back())) != 0;
  throw valueError(value, describe(range, "a number") +
                              (hasUnit ? " without a unit. `unit` sets the unit of lengths" : ""));
}

long parseInteger(const TypedValue& value, Range range) {
  const std::optional<long> number = readWhole(value.text);
  const bool fits = number && range.holds(static_cast<double>(*number));
  if (!fits) throw valueError(value, describe(range, "a whole number"));
  return *number;
}

Vector3 parseGravity(const TypedValue& value) {
  const std::vector<std::string_view> parts = split(value.text, ',');
  std::vector<double> numbers;
  for (const std::string_view part : parts) {
    const std::optional<double> number = readNumber(part);
    if (number && std::isfinite(*number)) numbers.push_back(*number);
  }
  const bool complete = numbers.size() == parts.size();
  if (complete && numbers.size() == 1) return {0, 0, numbers[0]};
  if (complete && numbers.size() == 3) return {numbers[0], numbers[1], numbers[2]};
  throw valueError(value, "one number (along z) or three as X,Y,Z, in m/s^2, as in 0,0,-9.81");
}

InputError valueError(const TypedValue& value, const std::string& requested) {
  return InputError(fmt::format("error: {}: '{}' is not allowed; give {}", value.name,
                                shown(value.text), requested));
}

std::string numberText(double number) {
  return fmt::format("{}", number);
}

std::string quotedText(const std::string& text) {
  return text.empty() ? "" : tomlText(text);
}

std::string quotedList(const std::vector<std::string>& values) {
  if (values.size() < 2) return values.empty() ? "" : values.front();
  return fmt::format("[{}]", fmt::join(values, ", "));
}

double numberReadAs(double requested, double guess, const std::function<double(double)>& read) {
  // 17 digits distinguish any two doubles, fewer are more readable.
  for (int digits = 6; digits <= 17; ++digits) {
    const double shorter = std::strtod(fmt::format("{:.{}g}", guess, digits).c_str(), nullptr);
    if (read(shorter) == requested) return shorter;
  }
  // The conversion rounds, so a number next to the guess may be the right one.
  constexpr int kNeighbours = 8;
  double below = guess;
  double above = guess;
  for (int k = 0; k < kNeighbours; ++k) {
    below = std::nextafter(below, -std::numeric_limits<double>::infinity());
    above = std::nextafter(above, std::numeric_limits<double>::infinity());
    if (read(below) == requested) return below;
    if (read(above) == requested) return above;
  }
  return guess;
}

std::string listWords(const std::vector<std::string>& words) {
  std::string list;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) list += i + 1 == words.size() ? " or " : ", ";
    list += words[i];
  }
  return list;
}

}  // namespace kirireel::scene
