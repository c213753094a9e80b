/// Record of a deployment: its subject, and the poses of all bricks over time.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/fields.h"
#include "sim/base/geometry.h"
#include "sim/base/step_report.h"
#include "sim/brick/brick.h"
#include "sim/brick/contact.h"
#include "sim/brick/pair_force.h"
#include "sim/model/model.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/panels.h"

namespace kirireel::trajectory {

/// Measures at the end of one step of a run, and the cost of the step. Lengths in metres.
struct StepRecord {
  double time = 0;          ///< simulated seconds from the start
  double jointGap = 0;      ///< largest
  double jointGapMean = 0;  ///< over all pivots
  double targetError = 0;   ///< largest; 0 without a target
  StepReport took;          ///< report of the solver

  static constexpr auto fields() {
    return describeFields<StepRecord>(
        field("time", &StepRecord::time, "s"), field("joint_gap", &StepRecord::jointGap, "m"),
        field("joint_gap_mean", &StepRecord::jointGapMean, "m"),
        field("target_error", &StepRecord::targetError, "m"), field("took", &StepRecord::took));
  }
};

/// Energy balance of a run with dynamics at one time, joules. The input equals the stored energy
/// plus the losses:
///   work = kinetic + spring + elastic + damped + impacted + integrated.
struct Energies {
  double kinetic = 0;  ///< of the bricks, >= 0
  /// Stored in the springs of the drive and of drags, and in compliant joints, >= 0.
  double spring = 0;
  double elastic = 0;  ///< stored in forces between pairs, such as springs at hinges; >= 0
  /// Input of the drives since before the start: they tighten, move and stiffen springs, stiffen
  /// joints, and expand the bricks. Includes gravity.
  double work = 0;
  double damped = 0;  ///< removed by dampers, >= 0
  /// Removed by contacts, through impacts and friction, and by pins that stop moving tiles.
  double impacted = 0;

  /// Loss of the integrator: the remainder.
  double integrated() const { return work - kinetic - spring - elastic - damped - impacted; }

  static constexpr auto fields() {
    return describeFields<Energies>(
        field("kinetic", &Energies::kinetic, "J", "of the bricks"),
        field("spring", &Energies::spring, "J",
              "stored in springs that pull tiles, and in compliant joints"),
        field("elastic", &Energies::elastic, "J", "stored in springs at hinges and ligaments"),
        field("work", &Energies::work, "J", "put in so far by drives and gravity"),
        field("damped", &Energies::damped, "J", "taken so far by dampers"),
        field("impacted", &Energies::impacted, "J",
              "taken so far by impacts and friction of contacts, and pins that stop tiles"));
  }
};

/// Holds of a tile in addition to joints.
enum class HoldKind {
  Pin,      ///< fixed in space
  Grip,     ///< dragged by a spring
  Contact,  ///< pushed by another tile, the ground or an obstacle
};

/// The resultant force of one pin, one grip, or all contact points between a tile and another
/// object. World axes.
struct Hold {
  /// Values of `other` for objects that are no tile; obstacle k is kFirstObstacle - k.
  static constexpr int kGround = brick::kFixed;
  /// Obstacle 0.
  static constexpr int kFirstObstacle = brick::kFirstObstacle;

  HoldKind kind = HoldKind::Contact;  ///< type of the hold
  int tile = 0;                       ///< index >= 0
  int other = kGround;  ///< the tile (index > `tile`), ground or obstacle of a contact
  Vector3 force;        ///< on the tile, newtons
  Vector3 moment;       ///< on the tile about the point, N m
  Vector3 point;        ///< a pinned tile's centre of mass, the grip's point, or the centre of the
                        ///< contact force, metres

  static constexpr auto fields() {
    return describeFields<Hold>(field("kind", &Hold::kind), field("tile", &Hold::tile),
                                field("other", &Hold::other), field("force", &Hold::force, "N"),
                                field("moment", &Hold::moment, "N m"),
                                field("point", &Hold::point, "m"));
  }
};

/// Mechanics of a state in a run with dynamics, in addition to its poses.
struct Mechanics {
  Energies energies;  ///< of the whole run
  /// For each joint the force on its tile a, N, world axes: the equilibrium forces of least norm.
  /// NaN if bricks touch and the imbalance exceeds 5%; then `holds` lists grips only.
  std::vector<Vector3> jointForces;
  /// For each joint whether its force is indeterminate: other equilibrium forces exist.
  std::vector<bool> isIndeterminate;
  std::vector<Hold> holds;  ///< pins and grips by tile, then contacts by tiles

  static constexpr auto fields() {
    return describeFields<Mechanics>(field("energies", &Mechanics::energies),
                                     field("joint_forces", &Mechanics::jointForces, "N"),
                                     field("is_indeterminate", &Mechanics::isIndeterminate),
                                     field("holds", &Mechanics::holds));
  }
};

/// The state at one time, with its measures. Lengths in metres.
struct Sample {
  double time = 0;          ///< simulated seconds from the start
  Poses poses;              ///< one per brick
  double jointGap = 0;      ///< largest
  double targetError = 0;   ///< largest; 0 without a target
  double penetration = 0;   ///< deepest
  std::vector<int> pinned;  ///< tiles fixed in space at this time, ascending
  /// The steps since the previous sample, including this one's. The start counts as a step.
  std::vector<StepRecord> steps;
  /// For runs with dynamics by the direct solver; kinematic paths and engines have none.
  std::optional<Mechanics> mechanics;

  static constexpr auto fields() {
    return describeFields<Sample>(field("time", &Sample::time, "s"), field("poses", &Sample::poses),
                                  field("joint_gap", &Sample::jointGap, "m"),
                                  field("target_error", &Sample::targetError, "m"),
                                  field("penetration", &Sample::penetration, "m"),
                                  field("pinned", &Sample::pinned), field("steps", &Sample::steps),
                                  field("mechanics", &Sample::mechanics));
  }
};

/// The state in which a figure of the summary was reached. The figure can be recomputed from it.
struct FigureState {
  std::string figure;  ///< its name in summary.json, such as "penetration_max"
  double time = 0;     ///< simulated seconds from the start
  Poses poses;         ///< one per brick

  static constexpr auto fields() {
    return describeFields<FigureState>(field("figure", &FigureState::figure),
                                       field("time", &FigureState::time, "s"),
                                       field("poses", &FigureState::poses));
  }
};

/// An event of a run.
struct Event {
  double time = 0;   ///< simulated seconds from the start
  std::string text;  ///< one line

  bool operator==(const Event&) const = default;

  static constexpr auto fields() {
    return describeFields<Event>(field("time", &Event::time, "s"), field("what", &Event::text));
  }
};

/// The subject of a trajectory: everything that does not change between samples. It is enough to
/// make pictures and meshes without the scene.
struct Subject {
  model::Model model;                   ///< as it was simulated, aligned to its target
  brick::BrickRule brickRule;           ///< rule that made bricks from tiles
  std::vector<brick::Brick> bricks;     ///< one per tile
  std::optional<scene::Ground> ground;  ///< absent if the scene has none
  std::vector<model::Tile> obstacles;   ///< faces of fixed objects, world axes
  brick::PairForces pairForces;         ///< springs at hinges, ligaments in place of joints, ...
  std::string settings;                 ///< of the run, as JSON; may be empty
};

/// Data that are known at the end of a run.
struct TrajectoryEnd {
  std::vector<Event> events;              ///< in order of time
  std::vector<FigureState> figureStates;  ///< one per figure that a single state determines
  std::string findings;                   ///< results about the scene, as JSON; may be empty
  /// Of tiles that stretch and bend under grips; null for other runs. It never changes.
  std::shared_ptr<const LoadedPanels> panels;
};

/// One run: samples equally spaced in time from 0, and one at the end.
struct Trajectory : Subject, TrajectoryEnd {
  std::vector<Sample> samples;  ///< at least the start
};

/// The subject of a scene's trajectory, with empty settings.
Subject subjectOf(const scene::Scene& scene);

}  // namespace kirireel::trajectory
