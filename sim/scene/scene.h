/// The scene: a model with all settings of its deployment.
#pragma once

#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/model/brick.h"
#include "sim/model/model.h"
#include "sim/scene/conditions.h"

namespace kirireel::scene {

/// The horizontal plane that bricks rest on.
struct Ground {
  double height = 0;      ///< z of the plane, metres
  double friction = 0.5;  ///< Coulomb coefficient, >= 0
};

/// Which pairs of bricks may touch.
enum class ContactFilter {
  Auto,      ///< all pairs if bricks collide on the path, else none; resolved by deploy()
  None,      ///< no pair: bricks pass through each other
  Unjoined,  ///< pairs that share no joint (what PyKirigami's --no_collision does)
  All,       ///< every pair, away from shared pivots (see Environment::pivotZone)
};

/// What surrounds the bricks.
struct Environment {
  Vector3 gravity = Vector3::Zero();             ///< m/s^2
  std::optional<Ground> ground;                  ///< absent: there is none
  std::vector<Obstacle> obstacles;               ///< obstacles of all bricks
  ContactFilter contacts = ContactFilter::None;  ///< which pairs may touch
  /// Contacts of joined bricks ignore the corners that they share: this fraction of the mean edge
  /// at each end, in [0, 0.4]. 0: contacts reach the pivot.
  double pivotZone = 0.05;
  double brickFriction = 0;      ///< Coulomb coefficient between bricks, >= 0
  double linearDamping = 0.05;   ///< fraction of velocity lost per second, as in PyBullet
  double angularDamping = 0.05;  ///< the same for the angular velocity
};

/// Springs from every bottom vertex to its target (paper, Algorithm 2), acting as one force at the
/// mean of the vertices and one torque about it. What is not given in N/m follows from a frequency
/// and a damping ratio by each brick's own mass and inertia. Tiles of another size, density or unit
/// then move alike: see springOf() for the equations.
struct TargetSpringSettings {
  double frequency =
      3.2;  ///< undamped natural frequency of one brick on its vertex springs, Hz, > 0
  double dampingRatio = 1.25;             ///< damping over the critical one, >= 0
  std::optional<double> springStiffness;  ///< k_f, N/m for each vertex, >= 0
  std::optional<double> torqueStiffness;  ///< k_tau, N/m for each vertex, >= 0
  std::optional<double> forceDamping;     ///< mu_v, N s/m, >= 0
  std::optional<double> torqueDamping;    ///< mu_omega, N m s, >= 0
  double turnShare = 1;                   ///< of k_f by frequency: k_tau if it is not given, >= 0
  bool adaptive = true;  ///< double both stiffnesses when the error stalls, up to 16 times

  /// Whether they pull at all; without stiffness they only damp.
  bool pull() const { return springStiffness != 0.0 || torqueStiffness != 0.0; }
};

/// The paper's constants (100 N/m, 100 N/m, 50 N s/m, 2 N m s), which are for bricks of 1 kg.
TargetSpringSettings paperSprings();

/// The spring of one hinge in a file of hinges. Missing values are those of all hinges.
struct OwnHingeSpring {
  int tileA = 0;                    ///< the hinge's tiles, in either order
  int tileB = 0;                    ///< the other
  std::optional<double> stiffness;  ///< see HingeSpring, this and the following
  std::optional<double> rest;       ///< radians, see HingeSpring
  std::optional<double> damping;    ///< N m s/rad, see HingeSpring
  FileLocation where;               ///< of the line
};

/// A neck of the sheet's material at each corner where tiles turn against each other, as thick as
/// the bricks: see neckStiffness().
struct HingeNeck {
  double width = 0;      ///< metres, > 0; 0: each joint has the neck of the model
  double length = 0;     ///< metres, >= 0
  double youngs = 0;     ///< modulus, Pa, > 0
  double poisson = 0.3;  ///< ratio, in [0, 0.5)
};

/// The material of tiles that stretch and bend, as thick as the bricks: see BarHingeSheet.
struct PanelMaterial {
  double youngs = 0;      ///< modulus, Pa, > 0
  double poisson = 0.3;   ///< ratio, in [0, 0.5)
  double foldLength = 0;  ///< see foldStiffness(), metres; 0: folds are as stiff as hinges are
};

/// Torsional springs at the hinges: see HingeSpring.
struct HingeSettings {
  double stiffness = 0;           ///< of all hinges, N m/rad, >= 0
  std::optional<HingeNeck> neck;  ///< gives the stiffness at corners
  /// Whether necks also stretch and shear; with grips only.
  bool areLigaments = false;
  std::optional<PanelMaterial>
      panels;  ///< tiles stretch and bend: with grips, and in motion if they are split
  std::optional<double> rest;       ///< their angle without moment, radians; absent: at the start
  double damping = 0;               ///< N m s/rad, >= 0
  std::filesystem::path file;       ///< file of single hinges; empty: none
  std::vector<OwnHingeSpring> own;  ///< what it holds, read by completeScene()

  /// Whether hinges have their own springs or dashpots, for any material of the tiles.
  bool areGiven() const {
    return stiffness > 0 || neck || damping > 0 || !file.empty() || !own.empty();
  }
  /// Whether any hinge may have a spring or a dashpot.
  bool areOn() const { return areGiven() || panels; }
};

/// What drives the bricks.
enum class Drive {
  Auto,       ///< Target where the model has one, else Expansion; resolved by completeScene()
  Target,     ///< springs to the target; nothing where there is none
  Expansion,  ///< away from the common centre, k (x - centre) - c v, with the springs' k_f and mu_v
  Boundary,   ///< springs of stiffness k_f from the corners of the hull to a curve round it
  None,       ///< no force, no damping but the environment's
};

/// The curve that boundary springs pull to: an ellipse round the middle of the hull's corners.
struct BoundaryCurve {
  double size = 2;    ///< its width (along y) over that of the smallest circle round the hull, > 0
  double aspect = 1;  ///< its length (along x) over its width: 1 a circle, else an oblong; above 0
};

/// What drives the bricks. Its strength is in TargetSpringSettings.
struct Actuation {
  Drive drive = Drive::Target;  ///< what it is
  BoundaryCurve boundary;       ///< of boundary springs
};

/// How the springs bring the tiles to their target.
enum class PathKind {
  /// Continuation where the scene needs no dynamics and that arrives, else Dynamic.
  Auto,
  Continuation,  ///< the mechanism is followed as geometry, at an even pace; see continueAlong()
  /// By springs: straight where that arrives, else guided, on joints as stiff as arrives.
  Dynamic,
  Straight,  ///< the springs pull towards the target from the start (as in the paper)
  Guided,    ///< each tile is guided along its own rigid motion, more by its rotation than by its
             ///< position
};

/// Where a run leads.
enum class Destination {
  Auto,    ///< to the target, without one to full extension
  Closed,  ///< through full extension to the second compact state; a target is ignored
};

/// The path to the target. Straight pulling has local minima in which hard models lock.
struct PathSettings {
  PathKind kind = PathKind::Dynamic;  ///< how tiles get there
  /// Seconds of expansion from the common centre before the tiles are guided: room for bricks that
  /// would jam. >= 0.
  double openTime = 0;
  double guideTime = 4;  ///< seconds in which the tiles are guided to the target, > 0
  /// r, the stiffness of each joint over that by which one tile is held at its place, > 0.
  /// Infinity: exact joints. While guided, compliant joints are closed at the end.
  double jointRatio = std::numeric_limits<double>::infinity();
  /// Scales what finding a path may cost after the first candidate, see SearchBudget, >= 0.
  double searchEffort = 1;
  /// Seconds in which a kinematic path is played back, at an even pace, > 0. A shorter duration of
  /// the run comes first.
  double walkTime = 6;
  /// Least number of equilibria while the load of grips grows from 0 to 1; >= 1.
  int loadSteps = 1;
  Destination to = Destination::Auto;  ///< where the path leads

  /// Whether joints are springs from the start on.
  bool jointsAreCompliant() const { return std::isfinite(jointRatio); }
};

/// Which solver holds the joints.
enum class SolverKind {
  Direct,  ///< exact joints by a direct solve
  Bullet,  ///< Bullet's sequential impulses: the baseline
};

/// Default error in time of one step of a run with dynamics, tiles: about what 1/240 s costs in
/// fixed steps, for a fortieth of their error (docs/accuracy.md).
inline constexpr double kDefaultTolerance = 1e-3;

/// How a step is computed.
struct SolverSettings {
  SolverKind kind = SolverKind::Direct;  ///< which one
  /// Of fixed steps, and of steps to a tolerance where bricks touch or joints are singular,
  /// seconds.
  double timestep = 1.0 / 240;
  /// Error in time that one step may make, tiles (see Extrapolation); 0: fixed steps, of first
  /// order.
  double tolerance = 0;
  /// Whether a run is repeated with a tenth of the tolerance, to measure its error in time.
  bool measuresTimeError = false;
  std::optional<int> substeps;  ///< solver steps in each; absent: 1 direct, 20 Bullet
  int iterations = 50;          ///< of Bullet's solver in a substep
  std::optional<bool> planar;   ///< force 3 (true) or 6 (false) degrees of freedom a tile
  unsigned seed = 1;            ///< of the perturbation that breaks symmetric starts

  /// Whether the tolerance was set by the user: it differs from the default, which other settings
  /// override.
  bool isToleranceGiven() const { return tolerance > 0 && tolerance != kDefaultTolerance; }
};

/// When a run ends.
struct StopRules {
  double duration = 20;       ///< simulated seconds at most
  double settleSpeed = 2e-6;  ///< settled below this many model sizes a second ...
  double settleTime = 0.25;   ///< ... for this many seconds
};

/// How the start is moved onto the target, as a rigid whole, before a run.
struct StartAlignment {
  bool requested = true;  ///< false: the start keeps its position in the model
  bool byHeld = false;    ///< the tiles that are pinned from the start on were fitted, not all
  double moved = 0;       ///< of the farthest vertex, metres
  double turned = 0;      ///< of the whole, radians in [0, pi]
};

/// Everything that a run depends on.
struct Scene {
  model::Model model;            ///< its start aligned, see completeScene()
  StartAlignment alignment;      ///< how it was aligned
  model::BrickRule brick;        ///< how tiles become bricks
  Environment environment;       ///< what is around them
  Actuation actuation;           ///< what drives them
  TargetSpringSettings springs;  ///< to the target; their strength serves other drives too
  HingeSettings hinges;          ///< what joins tiles
  PathSettings path;             ///< how they get to the target
  SolverSettings solver;         ///< how steps are computed
  StopRules stop;                ///< when the run ends
  Timeline timeline;             ///< what happens on the way
  std::vector<InitialVelocity> velocities;  ///< at the start; tiles that none names are at rest
  /// Where there are any, the scene is not deployed: its equilibria are followed as they load it.
  std::vector<GripSetting> grips;
  /// Why a scene that could stay in its plane leaves it; empty: it stays. Found by deploy().
  std::string spaceReason;
};

/// Whether something is modelled, and why.
struct Need {
  bool on = false;     ///< whether it is modelled
  std::string reason;  ///< one short phrase for the summary

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<Need>(field("on", &Need::on), field("reason", &Need::reason));
  }
};

/// What a scene needs.
struct Needs {
  Need planar;     ///< three degrees of freedom a tile instead of six
  Need contacts;   ///< collision detection between bricks
  Need ground;     ///< the ground plane as a contact
  Need obstacles;  ///< fixed obstacles

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<Needs>(
        field("planar", &Needs::planar), field("contacts", &Needs::contacts),
        field("ground", &Needs::ground), field("obstacles", &Needs::obstacles));
  }
};

/// "the start was moved by 1.2 m and turned by 90 degrees onto its target (`align = false` keeps
/// its position)".
std::string describe(const StartAlignment& alignment, const LengthUnit& unit = {});

/// A scene without a model, with the program's defaults. Path, contacts and drive are found from
/// the model later, and thickness (here 0).
Scene openScene();

/// Sets drive and thickness from the model if they are not set.
void fillFromModel(Scene& scene);

/// Multiplies all lengths of a scene by a factor > 0, but those of its model: a scene is typed in
/// the model's unit. Linear speeds too. Targets that are read later are not in it.
void scaleLengths(Scene& scene, double factor);

/// What drives a model by default: Target where it has one, else Expansion.
Drive defaultDrive(const model::Model& model);

/// The lowest z of start and target: default height of the ground, metres.
double lowestPoint(const model::Model& model);

/// The lowest z of the bricks at the start and at the target: the height of a ground that touches
/// them without pushing. Metres.
double lowestPoint(const Scene& scene);

}  // namespace kirireel::scene
