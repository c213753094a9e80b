/// A deployment's record: what moved, and the poses of all bricks by time.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/fields.h"
#include "sim/base/geometry.h"
#include "sim/base/step_report.h"
#include "sim/model/brick.h"
#include "sim/model/contact.h"
#include "sim/model/model.h"
#include "sim/model/pair_force.h"
#include "sim/scene/scene.h"

namespace kirireel::trajectory {

/// What was measured at the end of one step of a run, and what the step took. Lengths in metres.
struct StepRecord {
  double time = 0;          ///< simulated seconds from the start
  double jointGap = 0;      ///< largest
  double jointGapMean = 0;  ///< over all pivots
  double targetError = 0;   ///< largest; 0 without a target
  StepReport took;          ///< what the solver reports

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<StepRecord>(
        field("time", &StepRecord::time, "s"), field("joint_gap", &StepRecord::jointGap, "m"),
        field("joint_gap_mean", &StepRecord::jointGapMean, "m"),
        field("target_error", &StepRecord::targetError, "m"), field("took", &StepRecord::took));
  }
};

/// Where the energy of a run with dynamics is at one time, joules. What was put in is what there is
/// and what was lost:
///   work = kinetic + spring + elastic + damped + impacted + integrated.
struct Energies {
  double kinetic = 0;  ///< of the bricks, >= 0
  /// Stored in the springs of the drive and of drags, and in compliant joints; from 0.
  double spring = 0;
  double elastic = 0;  ///< stored in forces between pairs of bricks, as springs at hinges; from 0
  /// What drives have put in since before the start: they tighten and move springs, stiffen them
  /// and the joints, expand the bricks; and gravity.
  double work = 0;
  double damped = 0;    ///< what dampers have taken, >= 0
  double impacted = 0;  ///< what contacts have taken, by impacts and friction

  /// What the integrator, and pins that caught moving tiles, have taken: the rest.
  double integrated() const { return work - kinetic - spring - elastic - damped - impacted; }

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<Energies>(
        field("kinetic", &Energies::kinetic, "J", "of the bricks"),
        field("spring", &Energies::spring, "J",
              "stored in springs that pull tiles, and in compliant joints"),
        field("elastic", &Energies::elastic, "J", "stored in springs at hinges and ligaments"),
        field("work", &Energies::work, "J", "put in so far by drives and gravity"),
        field("damped", &Energies::damped, "J", "taken so far by dampers"),
        field("impacted", &Energies::impacted, "J",
              "taken so far by impacts and friction of contacts"));
  }
};

/// What holds a tile from outside the joints.
enum class HoldKind {
  Pin,      ///< fixed to the world
  Grip,     ///< dragged along
  Contact,  ///< pushed by another tile, the ground or an obstacle
};

/// The resultant of one pin or grip, or of all points in which a tile and another thing touch.
/// World axes.
struct Hold {
  /// What a tile touches when that is no tile; obstacle k is kFirstObstacle - k.
  static constexpr int kGround = model::kFixed;
  /// Obstacle 0.
  static constexpr int kFirstObstacle = model::kFirstObstacle;

  HoldKind kind = HoldKind::Contact;  ///< what holds
  int tile = 0;                       ///< its number, >= 0
  int other = kGround;  ///< the tile (above the first), ground or obstacle of a contact
  Vector3 force;        ///< on the tile, newtons
  Vector3 moment;       ///< on the tile about the point, N m
  Vector3 point;        ///< a pinned tile's centre of mass, where it is gripped, or the middle of
                        ///< the push, metres

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<Hold>(field("kind", &Hold::kind), field("tile", &Hold::tile),
                                field("other", &Hold::other), field("force", &Hold::force, "N"),
                                field("moment", &Hold::moment, "N m"),
                                field("point", &Hold::point, "m"));
  }
};

/// What a run with dynamics knows of a state beyond its poses.
struct Mechanics {
  Energies energies;  ///< of the whole run
  /// For each joint the force on its tile a, N, world axes: of all that balance, of least norm.
  /// NaN if bricks touch and forces balance worse than 5%; then `holds` lists grips only.
  std::vector<Vector3> jointForces;
  /// One a joint: whether others keep the balance too, in which its force is another.
  std::vector<bool> isIndeterminate;
  std::vector<Hold> holds;  ///< pins and grips by tile, then contacts by tiles

  /// For files; see base/fields.h.
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
  std::vector<int> pinned;  ///< tiles fixed to the world at this time, ascending
  /// The steps since the sample before, this one's included; the start counts as one.
  std::vector<StepRecord> steps;
  /// Of runs with dynamics by the direct solver; a path is geometry, and engines do not tell.
  std::optional<Mechanics> mechanics;

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<Sample>(field("time", &Sample::time, "s"), field("poses", &Sample::poses),
                                  field("joint_gap", &Sample::jointGap, "m"),
                                  field("target_error", &Sample::targetError, "m"),
                                  field("penetration", &Sample::penetration, "m"),
                                  field("pinned", &Sample::pinned), field("steps", &Sample::steps),
                                  field("mechanics", &Sample::mechanics));
  }
};

/// The state in which a figure of the summary was reached; the figure can be computed again.
struct FigureState {
  std::string figure;  ///< its name in summary.json, such as "penetration_max"
  double time = 0;     ///< simulated seconds from the start
  Poses poses;         ///< one per brick

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<FigureState>(field("figure", &FigureState::figure),
                                       field("time", &FigureState::time, "s"),
                                       field("poses", &FigureState::poses));
  }
};

/// Something that happened during a run.
struct Event {
  double time = 0;   ///< simulated seconds from the start
  std::string text;  ///< one line

  bool operator==(const Event&) const = default;

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<Event>(field("time", &Event::time, "s"), field("what", &Event::text));
  }
};

/// What a trajectory shows: all that stays the same from the first sample to the last, and enough
/// to make pictures and meshes again without the scene.
struct Subject {
  model::Model model;                   ///< as it was simulated, aligned to its target
  model::BrickRule brickRule;           ///< how tiles became bricks
  std::vector<model::Brick> bricks;     ///< one a tile
  std::optional<scene::Ground> ground;  ///< absent when the scene had none
  std::vector<model::Tile> obstacles;   ///< the faces of what stays where it is, world axes
  model::PairForces pairForces;         ///< springs at hinges, ligaments in place of joints, ...
  std::string settings;                 ///< of the run, as JSON; may be empty
};

/// What is known once a run is over.
struct TrajectoryEnd {
  std::vector<Event> events;              ///< in order of time
  std::vector<FigureState> figureStates;  ///< one for each figure that a single state decides
  std::string findings;                   ///< of the run about its scene, as JSON; may be empty
};

/// One run: samples equally spaced in time from 0 on, and one at the end.
struct Trajectory : Subject, TrajectoryEnd {
  std::vector<Sample> samples;  ///< at least the start
};

/// What a trajectory of the scene shows, its settings left empty.
Subject subjectOf(const scene::Scene& scene);

}  // namespace kirireel::trajectory
