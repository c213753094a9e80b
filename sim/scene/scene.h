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
#include "sim/brick/brick.h"
#include "sim/model/model.h"
#include "sim/scene/conditions.h"

namespace kirireel::scene {

/// The horizontal ground plane.
struct Ground {
  double height = 0;      ///< z of the plane, metres
  double friction = 0.5;  ///< Coulomb coefficient, >= 0
};

/// Pairs of bricks with collision detection.
enum class ContactFilter {
  Auto,      ///< all pairs if bricks collide on the path, else none; resolved by deploy()
  None,      ///< no pairs: bricks can overlap
  Unjoined,  ///< pairs without common joint (like PyKirigami's --no_collision)
  All,       ///< every pair, away from shared pivots (see Environment::pivotZone)
};

/// Environment of the bricks.
struct Environment {
  Vector3 gravity = Vector3::Zero();             ///< m/s^2
  std::optional<Ground> ground;                  ///< absent: there is none
  std::vector<Obstacle> obstacles;               ///< fixed obstacles for all bricks
  ContactFilter contacts = ContactFilter::None;  ///< pairs of bricks with contact
  /// Contacts of joined bricks ignore the corners that they share: this fraction of the mean edge
  /// at each end, in [0, 0.4]. 0: contacts reach the pivot.
  double pivotZone = 0.05;
  double brickFriction = 0;      ///< Coulomb coefficient between bricks, >= 0
  double linearDamping = 0.05;   ///< fraction of velocity lost per second, as in PyBullet
  double angularDamping = 0.05;  ///< the same for the angular velocity
};

/// Springs from every bottom vertex to its target (paper, Algorithm 2), combined to one force at
/// the mean of the vertices and one torque about it. Without a value in N/m, a frequency, a damping
/// ratio and each brick's own mass and inertia define the constants. Motion is then independent of
/// tile size, density and unit: see springOf() for the equations.
struct TargetSpringSettings {
  double frequency =
      3.2;  ///< undamped natural frequency of one brick on its vertex springs, Hz, > 0
  double dampingRatio = 1.25;             ///< damping over the critical one, >= 0
  std::optional<double> springStiffness;  ///< k_f, N/m for each vertex, >= 0
  std::optional<double> torqueStiffness;  ///< k_tau, N/m for each vertex, >= 0
  std::optional<double> forceDamping;     ///< mu_v, N s/m, >= 0
  std::optional<double> torqueDamping;    ///< mu_omega, N m s, >= 0
  double turnShare = 1;  ///< k_tau over k_f, if both follow from the frequency, >= 0
  bool adaptive = true;  ///< double both stiffnesses when the error stalls, up to 16 times

  /// Whether the springs have stiffness; without it they only damp.
  bool pull() const { return springStiffness != 0.0 || torqueStiffness != 0.0; }
};

/// The paper's constants (100 N/m, 100 N/m, 50 N s/m, 2 N m s), for bricks of 1 kg.
TargetSpringSettings paperSprings();

/// The spring of one hinge in a file of hinges, see HingeSpring. The settings of all hinges replace
/// missing values.
struct OwnHingeSpring {
  int tileA = 0;                    ///< one tile of the hinge, in either order
  int tileB = 0;                    ///< the other tile
  std::optional<double> stiffness;  ///< N m/rad
  std::optional<double> rest;       ///< radians
  std::optional<double> damping;    ///< N m s/rad
  FileLocation where;               ///< position of the line
};

/// A neck of the sheet's material at each corner where tiles turn against each other, as thick as
/// the bricks: see neckStiffness().
struct HingeNeck {
  double width = 0;      ///< metres, > 0; 0: each joint has the neck of the model
  double length = 0;     ///< metres, >= 0
  double youngs = 0;     ///< modulus, Pa, > 0
  double poisson = 0.3;  ///< ratio, in [0, 0.5)
};

/// Ligaments of given stiffness at all corners, with the energy
///   stretch (l - length)^2 / 2 + shear (length a)^2 / 2,
/// l: distance of their ends, a: angle between the ligament and the mean rotation of both tiles.
/// The springs at their hinges give the bending stiffness. B. Deng, J. R. Raney, K. Bertoldi, V.
/// Tournat, Nonlinear waves in flexible mechanical metamaterials, J. Appl. Phys. 130, 2021.
struct LigamentStiffness {
  double stretch = 0;  ///< N/m, > 0
  double shear = 0;    ///< N/m, > 0
  double length = 0;   ///< metres, > 0
};

/// The material of tiles that stretch and bend, as thick as the bricks: see BarHingeSheet.
struct PanelMaterial {
  double youngs = 0;      ///< modulus, Pa, > 0
  double poisson = 0.3;   ///< ratio, in [0, 0.5)
  double foldLength = 0;  ///< see foldStiffness(), metres; 0: folds are as stiff as other hinges
};

/// Torsional springs at the hinges: see HingeSpring.
struct HingeSettings {
  double stiffness = 0;           ///< of all hinges, N m/rad, >= 0
  std::optional<HingeNeck> neck;  ///< gives the stiffness at corners
  /// Whether necks also stretch and shear; with grips only.
  bool areLigaments = false;
  std::optional<LigamentStiffness> ligament;  ///< ligaments that do not follow from necks
  std::optional<PanelMaterial>
      panels;  ///< tiles stretch and bend: with grips, and in motion if they are split
  std::optional<double> rest;       ///< their angle without moment, radians; absent: at the start
  double damping = 0;               ///< N m s/rad, >= 0
  std::filesystem::path file;       ///< file of single hinges; empty: none
  std::vector<OwnHingeSpring> own;  ///< contents of the file, read by completeScene()

  /// Whether hinges have their own springs or dashpots, for any material of the tiles.
  bool areGiven() const {
    return stiffness > 0 || neck || damping > 0 || !file.empty() || !own.empty();
  }
  /// Whether ligaments replace joints.
  bool hasLigaments() const { return areLigaments || ligament; }
  /// Whether any hinge may have a spring or a dashpot.
  bool areOn() const { return areGiven() || panels; }
};

/// Drive of the bricks.
enum class Drive {
  Auto,       ///< Target if the model has one, else Expansion; resolved by completeScene()
  Target,     ///< springs to the target; no force without a target
  Expansion,  ///< away from the common centre, k (x - centre) - c v, with the springs' k_f and mu_v
  Boundary,   ///< springs of stiffness k_f from the corners of the hull to a curve around it
  None,       ///< no force; only the environment's damping
};

/// The curve of boundary springs: an ellipse around the middle of the hull's corners.
struct BoundaryCurve {
  double size = 2;    ///< width (along y) / diameter of the circle around the hull, > 0
  double aspect = 1;  ///< its length (along x) / its width: 1 a circle, else oblong; > 0
};

/// Drive of the bricks. TargetSpringSettings have its strength.
struct Actuation {
  Drive drive = Drive::Target;  ///< kind of drive
  BoundaryCurve boundary;       ///< of boundary springs
};

/// Method to bring the tiles to their target.
enum class PathKind {
  /// Continuation if the scene needs no dynamics and the path arrives, else Dynamic.
  Auto,
  Continuation,  ///< the mechanism is followed kinematically at an even pace; see continueAlong()
  /// Springs pull the tiles: Straight if that arrives without overlaps, else Guided along the path
  /// of Continuation.
  Dynamic,
  Straight,  ///< the springs pull towards the target from the start (as in the paper)
  Guided,    ///< each tile is guided along its own rigid motion, primarily by rotation, then by
             ///< position
};

/// End of a run.
enum class Destination {
  Auto,    ///< the target; full extension without a target
  Closed,  ///< through full extension to the second compact state; a target is ignored
};

/// Method to reach the target. Straight pulling has local minima in which hard models lock.
struct PathSettings {
  PathKind kind = PathKind::Dynamic;  ///< kind of path
  /// Seconds of expansion from the common centre before the tiles are guided. It makes space for
  /// bricks that would jam. >= 0.
  double openTime = 0;
  double guideTime = 4;  ///< seconds in which the tiles are guided to the target, > 0
  /// r, the stiffness of each joint over the stiffness of one tile's guide, > 0. Infinity: exact
  /// joints. After guiding, compliant joints are closed.
  double jointRatio = std::numeric_limits<double>::infinity();
  /// Scales the cost limit of the path search after the first candidate, see SearchBudget; >= 0.
  double searchEffort = 1;
  /// Duration of the playback of a kinematic path at an even pace, seconds, > 0. A shorter duration
  /// of the run has priority.
  double playTime = 6;
  /// Least number of equilibria while the load of grips grows from 0 to 1; >= 1.
  int loadSteps = 1;
  Destination to = Destination::Auto;  ///< where the path leads

  /// Whether joints are springs from the start.
  bool jointsAreCompliant() const { return std::isfinite(jointRatio); }
};

/// Solver of the joints.
enum class SolverKind {
  Direct,  ///< exact joints by a direct solve
  Bullet,  ///< Bullet's sequential impulses: the baseline
};

/// Default error in time of one dynamic step, tiles. Costs about as much as fixed steps of 1/240 s
/// with a fortieth of their error (docs/accuracy.md).
inline constexpr double kDefaultTolerance = 1e-3;

/// Settings of a time step.
struct SolverSettings {
  SolverKind kind = SolverKind::Direct;  ///< solver of the joints
  /// Length of fixed steps, and of steps to a tolerance during contact or at singular joints,
  /// seconds.
  double timestep = 1.0 / 240;
  /// Allowed error in time of one step, tiles (see Extrapolation); 0: fixed steps, of first order.
  double tolerance = 0;
  /// Whether a run is repeated with a hundredth of the tolerance to measure its error in time.
  bool measuresTimeError = false;
  std::optional<int> substeps;  ///< solver steps per time step; absent: 1 direct, 20 Bullet
  int iterations = 50;          ///< of Bullet's solver in a substep
  std::optional<bool> planar;   ///< forces 3 (true) or 6 (false) degrees of freedom per tile
  unsigned seed = 1;            ///< of the perturbation that breaks symmetric starts

  /// Whether the user set the tolerance: it differs from the default, which other settings
  /// override.
  bool isToleranceGiven() const { return tolerance > 0 && tolerance != kDefaultTolerance; }
};

/// Conditions for the end of a run.
struct StopRules {
  double duration = 20;       ///< maximum simulated seconds
  double settleSpeed = 2e-6;  ///< at rest below this speed, model sizes per second ...
  double settleTime = 0.25;   ///< ... for this many seconds
};

/// Rigid motion of targets onto the start before a run, as the start stays where the model has it.
struct StartAlignment {
  bool requested = true;    ///< false: targets keep their positions
  bool movesStart = false;  ///< moves the start onto its target instead, as PyKirigami does
  bool byHeld = false;      ///< fitted only initially pinned tiles, not all
  double moved = 0;         ///< largest displacement of a vertex of target or start, metres
  double turned = 0;        ///< rotation of the whole, radians in [0, pi]
};

/// All inputs of a run.
struct Scene {
  model::Model model;                       ///< its target is aligned, see completeScene()
  StartAlignment alignment;                 ///< alignment of start and target
  brick::BrickRule brick;                   ///< makes bricks from tiles
  Environment environment;                  ///< gravity, ground, obstacles, contacts
  Actuation actuation;                      ///< drive of the bricks
  TargetSpringSettings springs;             ///< to the target; also the strength of other drives
  HingeSettings hinges;                     ///< springs at hinges
  PathSettings path;                        ///< method to reach the target
  SolverSettings solver;                    ///< settings of time steps
  StopRules stop;                           ///< conditions for the end
  Timeline timeline;                        ///< timed actions
  std::vector<InitialVelocity> velocities;  ///< at the start; other tiles are at rest
  /// If not empty, the scene is not deployed. Its equilibria under the grips' load are followed.
  std::vector<GripSetting> grips;
  /// Why a scene that could be planar is spatial; empty: it is planar. Set by deploy().
  std::string spaceReason;
};

/// Whether a feature is modelled, with the reason.
struct Need {
  bool on = false;     ///< whether it is modelled
  std::string reason;  ///< one short phrase for the summary

  static constexpr auto fields() {
    return describeFields<Need>(field("on", &Need::on), field("reason", &Need::reason));
  }
};

/// Features that a scene needs.
struct Needs {
  Need planar;     ///< three degrees of freedom per tile instead of six
  Need contacts;   ///< collision detection between bricks
  Need ground;     ///< the ground plane as a contact
  Need obstacles;  ///< fixed obstacles

  static constexpr auto fields() {
    return describeFields<Needs>(
        field("planar", &Needs::planar), field("contacts", &Needs::contacts),
        field("ground", &Needs::ground), field("obstacles", &Needs::obstacles));
  }
};

/// "the target was moved by 1.2 m and rotated by 90 degrees to match the start (`align = false`
/// keeps its position)".
std::string describe(const StartAlignment& alignment, const LengthUnit& unit = {});

/// A scene without a model, with the program's defaults. Path, contacts, drive and thickness (here
/// 0) are later chosen by the model.
Scene openScene();

/// Sets drive and thickness from the model if they are not set.
void fillFromModel(Scene& scene);

/// Multiplies all lengths and linear speeds of a scene, except its model, by a factor > 0, because
/// the user writes a scene in the model's unit. Meshes that declare a unit are multiplied by its
/// metres instead. Targets that are read later are excluded.
void scaleLengths(Scene& scene, double factor);

/// Default drive of a model: Target if it has one, else Expansion.
Drive defaultDrive(const model::Model& model);

/// The lowest z of start and target, the default height of the ground, metres.
double lowestPoint(const model::Model& model);

/// The lowest z of the bricks at the start and at the target, metres. A ground at this height
/// touches them without force.
double lowestPoint(const Scene& scene);

}  // namespace kirireel::scene
