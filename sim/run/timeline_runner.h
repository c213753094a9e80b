/// Executes a scene's timeline during a deployment.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/brick/brick.h"
#include "sim/run/forces.h"
#include "sim/scene/conditions.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::run {

/// State of the run that conditions of the timeline use.
struct TimelineView {
  double time = 0;               ///< simulated seconds
  bool atRest = false;           ///< the run is at rest
  double error = 0;              ///< target error, metres
  double startError = 0;         ///< target error when the current target was set, metres
  bool atTarget = false;         ///< at rest, and no nearer state of rigid tiles is known
  const Poses* poses = nullptr;  ///< one per brick
};

/// Actions of the timeline on a run, other than loads.
class TimelineStage {
 public:
  virtual ~TimelineStage() = default;
  /// Fixes these bricks in space and frees all others. One entry per brick.
  virtual void setPinned(const std::vector<bool>& pinned) = 0;
  /// `target`: one tile per brick; null for the model's own target.
  virtual void goTo(const std::vector<model::Tile>* target) = 0;
  /// Restores the start, at rest.
  virtual void reset() = 0;
  /// Ends the run.
  virtual void quit() = 0;
};

/// A tile that is dragged, and its spring.
struct DragSpring {
  int tile = 0;        ///< index >= 0
  PointSpring spring;  ///< between a point of its brick and a fixed point
};

/// Executes the due entries of a timeline. Drags are loads, evaluated in each step.
class TimelineRunner {
 public:
  /// Keeps a reference to the timeline. `countsFrom`: the first tile's number in events.
  TimelineRunner(const scene::Timeline& timeline, const std::vector<brick::Brick>& bricks,
                 int countsFrom = 0, const LengthUnit& unit = {});

  /// Executes all due entries and appends them to the events. Returns whether there were any.
  bool carryOut(const TimelineView& view, TimelineStage& stage,
                std::vector<trajectory::Event>& events);

  /// Adds the loads of the drags at this time.
  void addDrags(double time, const Poses& poses, std::vector<brick::Load>& loads) const;

  /// The springs of the drags that are active at this time.
  std::vector<DragSpring> dragSprings(double time) const;

  /// Whether the drive acts.
  bool forcesAreOn() const { return forcesOn_; }
  /// Whether tiles are held fixed at this time, seconds.
  bool isPaused(double time) const { return time < pausedUntil_; }
  /// Whether no entry, drag or pause remains.
  bool isOver(double time) const;
  /// Time of the next timed entry, end of a drag or end of a pause after `time`, seconds. Infinity
  /// if there is none.
  double nextMoment(double time) const;
  /// Whether the next entry depends only on time.
  bool waitsForTime() const;
  /// Whether the next entry waits for rest, a target, an error or a progress, and no drag is active
  /// that could cause it.
  bool waitsForState() const;
  /// The pinned tiles, one entry per brick.
  const std::vector<bool>& pinned() const { return pinned_; }
  /// The same as a list, ascending.
  std::vector<int> pinnedTiles() const;
  /// For example "the timeline still waits for rest to ..."; empty if all entries are done.
  std::string pending() const;

  /// Records or plays back the progress.
  void transfer(StateTape& tape);

 private:
  /// An active drag.
  struct ActiveDrag {
    std::size_t entry = 0;      // index in the timeline
    Vector3 point;              // end of the spring, in the brick's axes, metres
    std::vector<Vector3> path;  // starts at the point's first position, metres
    double from = 0;            // start time, seconds

    static constexpr auto fields() {
      return describeFields<ActiveDrag>(
          field("entry", &ActiveDrag::entry), field("point", &ActiveDrag::point, "m"),
          field("path", &ActiveDrag::path, "m"), field("from", &ActiveDrag::from, "s"));
    }
  };

  const scene::timeline::Drag& dragOf(const ActiveDrag& active) const {
    return std::get<scene::timeline::Drag>(timeline_.at(active.entry).action);
  }

  double dueTime(const scene::Trigger& moment) const;
  bool isDue(const scene::Trigger& moment, const TimelineView& view) const;
  void carryOut(const scene::timeline::Action& action, const TimelineView& view,
                TimelineStage& stage);
  void pin(const std::vector<int>& tiles, bool pinned, TimelineStage& stage);
  void startDrag(const scene::timeline::Drag& drag, const TimelineView& view);
  void reset(TimelineStage& stage);

  const scene::Timeline& timeline_;
  const std::vector<brick::Brick>& bricks_;
  int countsFrom_;   // number of the first tile in events
  LengthUnit unit_;  // of lengths in texts
  std::size_t next_ = 0;
  double lastTime_ = 0;  // time of the previous entry
  double pausedUntil_ = 0;
  bool forcesOn_ = true;
  std::vector<bool> pinned_;
  std::vector<ActiveDrag> drags_;
};

}  // namespace kirireel::run
