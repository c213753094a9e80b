#include "render/cli/run_options.h"

#include <CLI/CLI.hpp>

#include "render/cli/option_group.h"

namespace kirireel {
namespace {

constexpr Range kFromZero{0, 1e12};

void addBrickOptions(CLI::App& command, BrickRule& brick) {
  OptionGroup group(command, "Bricks");
  addThicknessOption(group, brick);
  group.choice<MassRule>("--mass", brick.mass,
                         {{"unit", MassRule::Unit}, {"prism", MassRule::Prism}},
                         "mass of a brick, 1 kg whatever its size or by volume");
  group.number("--density", brick.density, {1e-9, 1e12}, "KG/M3", "density, with --mass prism");
}

void addActuationOptions(CLI::App& command, Actuation& actuation) {
  OptionGroup group(command, "Actuation");
  group.choice<Drive>("--actuation", actuation.drive,
                      {{"auto", Drive::Auto},
                       {"target", Drive::Target},
                       {"expansion", Drive::Expansion},
                       {"boundary", Drive::Boundary},
                       {"none", Drive::None}},
                      "what drives the bricks: target or else expansion; springs to the target, "
                      "away from the centre, springs "
                      "from the hull to a curve round it, nothing");
  group.number("--boundary-size", actuation.boundary.size, {1e-3, 1e3}, "RATIO",
               "width of that curve over the hull's");
  group.number("--boundary-aspect", actuation.boundary.aspect, {1e-3, 1e3}, "RATIO",
               "its length along x over its width, 1 for a circle");
}

void addSpringOptions(CLI::App& command, TargetSpringSettings& springs) {
  OptionGroup group(command, "Springs to the target");
  group.number("--spring-stiffness", springs.springStiffness, kFromZero, "N/M",
               "pull on each vertex towards its target");
  group.number("--torque-stiffness", springs.torqueStiffness, kFromZero, "N/M",
               "the same pull where it only turns the brick");
  group.number("--force-damping", springs.forceDamping, kFromZero, "N*S/M",
               "damping of a brick's velocity");
  group
      .value("--torque-damping", "N*M*S", "2 times the square of the mean edge",
             "damping of a brick's turning",
             [&springs](const OptionValue& typed) {
               springs.torqueDamping = parseNumber(typed, kFromZero);
               springs.dampsByArea = false;
             })
      .saidAs([&springs] { return springs.dampsByArea ? "" : numberText(springs.torqueDamping); });
  group.flag("--no-adaptive", springs.adaptive,
             "keep the stiffness when the error stalls, instead of doubling it", false);
}

void addHingeOptions(CLI::App& command, HingeSettings& hinges) {
  OptionGroup group(command, "Hinges");
  group.number("--hinge-stiffness", hinges.stiffness, kFromZero, "N*M/RAD",
               "torsional springs at all hinges: corners in the plane or joined on both faces, and "
               "folds");
  group
      .value("--hinge-neck", "WIDTH,LENGTH,E[,NU]", "",
             "necks at all corners in place of a stiffness: metres, metres, Young's modulus in Pa "
             "and Poisson's ratio (0.3), as thick as the bricks",
             [&hinges](const OptionValue& typed) { hinges.neck = parseNeck(typed); })
      .saidAs([&hinges] {
        if (!hinges.neck) return std::string();
        const auto& [width, length, youngs, poisson] = *hinges.neck;
        return quotedText(fmt::format("{},{},{},{}", numberText(width), numberText(length),
                                      numberText(youngs), numberText(poisson)));
      });
  group.flag("--ligaments", hinges.areLigaments,
             "necks stretch, shear and bend, instead of bending about exact joints; with [[grip]]");
  group
      .value("--hinge-rest", "DEGREES", "the angle at the start",
             "angle at which they pull no more: at a corner between the tiles' edges, 0 where they "
             "lie flush; at a fold from flat, valleys above 0",
             [&hinges](const OptionValue& typed) {
               hinges.rest = parseNumber(typed, {-360, 360}) * kDegree;
             })
      .saidAs([&hinges] {
        if (!hinges.rest) return std::string();
        return numberText(numberReadAs(*hinges.rest, *hinges.rest / kDegree,
                                       [](double degrees) { return degrees * kDegree; }));
      });
  group.number("--hinge-damping", hinges.damping, kFromZero, "N*M*S/RAD",
               "damping of the hinges' angles");
  group
      .value("--hinge-file", "FILE", "",
             "springs of hinges one by one, by path or by name beside the model: a line has tile, "
             "tile, stiffness, rest angle and damping, of which - or nothing means as for all",
             [&hinges](const OptionValue& typed) { hinges.file = typed.text; })
      .saidAs([&hinges] { return quotedText(hinges.file.string()); });
}

void addPathOptions(CLI::App& command, PathSettings& path) {
  OptionGroup group(command, "Path to the target");
  group.choice<PathKind>(
      "--path", path.kind,
      {{"auto", PathKind::Auto},
       {"continuation", PathKind::Continuation},
       {"dynamic", PathKind::Dynamic},
       {"straight", PathKind::Straight},
       {"led", PathKind::Led}},
      "the mechanism is followed as geometry (continuation), or springs move masses (dynamic, "
      "which tries a straight pull and then leads each tile along its own motion); auto takes "
      "continuation where nothing given needs dynamics and that arrives");
  group.number("--walk-time", path.walkTime, {1e-6, 1e6}, "SECONDS",
               "in which a path of continuation is walked, at an even pace");
  group.number("--open-time", path.openTime, kFromZero, "SECONDS",
               "of expansion from the centre first, with --path led");
  group.number("--led-time", path.ledTime, {1e-6, 1e6}, "SECONDS", "of leading, with --path led");
  group.number("--led-stiffness", path.ledStiffness, kFromZero, "N/M",
               "pull on each vertex while led");
  group
      .value("--joint-stiffness", "N/M", "exact", "of joints while led; closed at the end",
             [&path](const OptionValue& typed) {
               path.jointStiffness = parseNumber(typed, {1e-6, 1e15});
             })
      .saidAs([&path] { return path.jointsGive() ? numberText(path.jointStiffness) : ""; });
  group.number("--search", path.searchTime, {0, 1e9}, "SECONDS",
               "that looking for a path may cost, of a reference core: work is counted, not timed, "
               "so that every machine finds the same; at most 30 for each second of --duration");
}

void addEnvironmentOptions(CLI::App& command, Environment& environment) {
  OptionGroup group(command, "Environment");
  group
      .value("--gravity", "M/S2", "0", "acceleration along z, or X,Y,Z",
             [&](const OptionValue& typed) { environment.gravity = parseGravity(typed); })
      .saidAs([&] { return vectorText(environment.gravity); });
  const auto setGround = [&environment] {
    if (!environment.ground) environment.ground = Ground{};
  };
  group
      .flag("--ground", "put a horizontal plane under the lowest point of start and target",
            setGround)
      .saidAs([&environment] { return fmt::format("{}", environment.ground.has_value()); });
  group
      .value("--ground-friction", "RATIO", "0.5",
             "Coulomb friction of the ground; implies --ground",
             [&environment, setGround](const OptionValue& typed) {
               setGround();
               environment.ground->friction = parseNumber(typed, {0, 1e3});
             })
      .saidAs([&environment] {
        return environment.ground ? numberText(environment.ground->friction) : "";
      });
  group.choice<ContactFilter>(
      "--contacts", environment.contacts,
      {{"auto", ContactFilter::Auto},
       {"none", ContactFilter::None},
       {"unjoined", ContactFilter::Unjoined},
       {"all", ContactFilter::All}},
      "pairs of bricks that may touch, others pass through each other; auto: "
      "all where bricks would meet on the way");
  group.number("--brick-friction", environment.brickFriction, {0, 1e3}, "RATIO",
               "Coulomb friction between bricks");
  group.number("--linear-damping", environment.linearDamping, {0, 1, true}, "SHARE",
               "part of the velocity lost a second");
  group.number("--angular-damping", environment.angularDamping, {0, 1, true}, "SHARE",
               "part of the turning lost a second");
}

void addSolverOptions(CLI::App& command, SolverSettings& solver) {
  OptionGroup group(command, "Solver");
  group.choice<SolverKind>("--solver", solver.kind,
                           {{"direct", SolverKind::Direct}, {"bullet", SolverKind::Bullet}},
                           "how joints are held, exactly or by Bullet's impulses");
  group.number("--tolerance", solver.tolerance, {0, 1}, "TILES",
               "error in time that a step may make, with steps as long as that lets them be; 0: "
               "fixed steps of first order");
  group.number("--timestep", solver.timestep, {1e-7, 1}, "SECONDS",
               "length of fixed steps, and of those where contacts crowd or joints are singular");
  group
      .value("--substeps", "COUNT", "1 direct, 20 bullet", "solver steps in each step",
             [&solver](const OptionValue& typed) {
               solver.substeps = static_cast<int>(parseInteger(typed, {1, 10000}));
             })
      .saidAs([&solver] { return solver.substeps ? fmt::format("{}", *solver.substeps) : ""; });
  group.integer("--iterations", solver.iterations, {1, 1000000}, "COUNT",
                "of Bullet's solver in each step");
  group.choice<std::optional<bool>>("--planar", solver.planar,
                                    {{"auto", std::nullopt}, {"on", true}, {"off", false}},
                                    "keep bricks in their plane");
  group.integer("--seed", solver.seed, {0, 4294967295.0}, "NUMBER",
                "of the nudge that leaves a start where no direction is preferred");
}

void addStopOptions(CLI::App& command, StopRules& stop) {
  OptionGroup group(command, "End of the run");
  group.number("--duration", stop.duration, {1e-6, 1e6}, "SECONDS",
               "simulated time at most; a run that comes to rest ends earlier");
}

}  // namespace

void addThicknessOption(OptionGroup& group, BrickRule& brick) {
  group
      .value("--thickness", "METRES", "0.02 of the mean edge", "thickness of the bricks",
             [&brick](const OptionValue& typed) {
               brick.thickness = parseNumber(typed, {1e-9, 1e9});
             })
      .saidAs([&brick] { return brick.thickness > 0 ? numberText(brick.thickness) : ""; });
}

void addSceneOptions(CLI::App& command, Scene& scene) {
  addBrickOptions(command, scene.brick);
  addActuationOptions(command, scene.actuation);
  addSpringOptions(command, scene.springs);
  addHingeOptions(command, scene.hinges);
  addPathOptions(command, scene.path);
  addEnvironmentOptions(command, scene.environment);
  addStopOptions(command, scene.stop);
  addSolverOptions(command, scene.solver);
}

}  // namespace kirireel
