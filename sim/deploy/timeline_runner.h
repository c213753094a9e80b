/// Carries out a scene's timeline while a deployment runs.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/deploy/forces.h"
#include "sim/model/brick.h"
#include "sim/scene/conditions.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::deploy {

/// What the timeline looks at.
struct TimelineView {
  double time = 0;               ///< simulated seconds
  bool atRest = false;           ///< nothing moves any more
  double error = 0;              ///< to the present target, metres
  double startError = 0;         ///< the same when that target was set
  bool atTarget = false;         ///< at rest where rigid tiles come no nearer to the present target
  const Poses* poses = nullptr;  ///< one a brick
};

/// What the timeline does to a run, beyond pushing its bricks.
class TimelineStage {
 public:
  virtual ~TimelineStage() = default;
  /// Fixes these bricks to the world from now on, and frees all others; one entry a brick.
  virtual void setPinned(const std::vector<bool>& pinned) = 0;
  /// `target`: one tile a brick; null for the model's own.
  virtual void goTo(const std::vector<model::Tile>* target) = 0;
  /// Brings all bricks back to the start, at rest.
  virtual void reset() = 0;
  /// Ends the run.
  virtual void quit() = 0;
};

/// A tile that is dragged along, and the spring that it hangs on.
struct DragSpring {
  int tile = 0;        ///< its number, from 0
  PointSpring spring;  ///< between a point of its brick and one of the world
};

/// Watches a run and does what is due. Drags are loads, asked for in each step.
class TimelineRunner {
 public:
  /// The timeline must outlive the runner. `countsFrom`: the first tile's number in events.
  TimelineRunner(const scene::Timeline& timeline, const std::vector<model::Brick>& bricks,
                 int countsFrom = 0, const LengthUnit& unit = {});

  /// Does everything that is due now and appends it to the events. Returns whether anything was.
  bool carryOut(const TimelineView& view, TimelineStage& stage,
                std::vector<trajectory::Event>& events);

  /// Adds what drags pull with at this time.
  void addDrags(double time, const Poses& poses, std::vector<model::Load>& loads) const;

  /// The drags under way at this time, as the springs that they pull with.
  std::vector<DragSpring> dragSprings(double time) const;

  /// Whether the drive acts.
  bool forcesAreOn() const { return forcesOn_; }
  /// Whether tiles are held still at this time, seconds.
  bool isPaused(double time) const { return time < pausedUntil_; }
  /// Whether anything is to come or still under way.
  bool isOver(double time) const;
  /// When, after this time, the next entry comes due by itself, or a drag or a pause ends; infinity
  /// where nothing does.
  double nextMoment(double time) const;
  /// Whether the next entry comes due by itself, even where nothing moves.
  bool waitsForTime() const;
  /// Whether the next entry waits for rest, a target, an error or a progress, and no drag or pause
  /// is under way that could bring it.
  bool waitsForState() const;
  /// Which tiles are pinned, one entry a brick.
  const std::vector<bool>& pinned() const { return pinned_; }
  /// The same as a list, ascending.
  std::vector<int> pinnedTiles() const;
  /// What is waited for: "line 12 of scene.toml waits for ..." ; empty when nothing is to come.
  std::string pending() const;

  /// What has been done and what is under way.
  void transfer(StateTape& tape);

 private:
  /// A drag under way: the path with the point that it started from.
  struct ActiveDrag {
    std::size_t entry = 0;      // of the timeline
    Vector3 point;              // tied to the spring, in the brick's axes
    std::vector<Vector3> path;  // from where the point was
    double from = 0;            // seconds

    /// For files; see base/fields.h.
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
  const std::vector<model::Brick>& bricks_;
  int countsFrom_;   // the first tile, in events
  LengthUnit unit_;  // of lengths in words
  std::size_t next_ = 0;
  double lastTime_ = 0;  // of the entry before
  double pausedUntil_ = 0;
  bool forcesOn_ = true;
  std::vector<bool> pinned_;
  std::vector<ActiveDrag> drags_;
};

}  // namespace kirireel::deploy
