// Execution of the timeline. Entries are executed in their order, each as soon as it is due. An
// entry that waits for a state (rest, a target, an error) is tested only if it is the first of a
// step, because other entries may change that state. Times are compared with a small tolerance. A
// drag is a spring (forces.h) whose anchor moves along its path at constant speed. It ends by
// itself.
#include "sim/run/timeline_runner.h"

#include <algorithm>
#include <limits>
#include <variant>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace kirireel::run {
namespace {

// Times are sums of steps. Entries within this tolerance are due, seconds.
constexpr double kTimeRounding = 1e-9;

/// The point at a share ([0, 1]) of a path's length.
Vector3 pointOnPath(const std::vector<Vector3>& path, double share) {
  double length = 0;
  for (std::size_t k = 1; k < path.size(); ++k) length += (path[k] - path[k - 1]).norm();
  double left = std::clamp(share, 0.0, 1.0) * length;
  for (std::size_t k = 1; k < path.size(); ++k) {
    const double piece = (path[k] - path[k - 1]).norm();
    if (left <= piece && piece > 0) return path[k - 1] + left / piece * (path[k] - path[k - 1]);
    left -= piece;
  }
  return path.back();
}

// Tiles in a file's numbers. An empty list means all tiles.
std::string tilesText(std::vector<int> tiles, int countsFrom) {
  for (int& tile : tiles) tile += countsFrom;
  return tiles.empty() ? "all tiles" : fmt::format("tiles {}", fmt::join(tiles, ", "));
}

/// The objects of an action, for the events.
struct Describe {
  int countsFrom;  // number of the first tile
  std::string operator()(const scene::timeline::Pin& pin) const {
    return tilesText(pin.tiles, countsFrom);
  }
  std::string operator()(const scene::timeline::Unpin& unpin) const {
    return tilesText(unpin.tiles, countsFrom);
  }
  std::string operator()(const scene::timeline::Drag& drag) const {
    return fmt::format("tile {} for {:g} s", countsFrom + drag.tile, drag.seconds);
  }
  std::string operator()(const scene::timeline::Forces& forces) const {
    return forces.on ? "on" : "off";
  }
  std::string operator()(const scene::timeline::Pause& pause) const {
    return fmt::format("{:g} s", pause.seconds);
  }
  std::string operator()(const scene::timeline::GoTo& goTo) const {
    return goTo.file.empty() ? "the model's" : goTo.file.string();
  }
  template <typename Other>
  std::string operator()(const Other&) const {
    return "";
  }
};

/// For example "pin tiles 3, 4".
std::string describe(const scene::timeline::Action& action, int countsFrom) {
  const std::string what = std::visit(Describe{countsFrom}, action);
  return what.empty() ? scene::actionName(action)
                      : fmt::format("{} {}", scene::actionName(action), what);
}

// The condition of an entry, for the reason of an end.
std::string momentText(const scene::Trigger& moment, const LengthUnit& unit) {
  switch (moment.kind) {
    case scene::Trigger::Kind::AtTime:
      return fmt::format("{:g} s", moment.value);
    case scene::Trigger::Kind::After:
      return fmt::format("{:g} s after the previous entry", moment.value);
    case scene::Trigger::Kind::AtRest:
      return "rest";
    case scene::Trigger::Kind::AtTarget:
      return "the target";
    case scene::Trigger::Kind::ErrorBelow:
      return fmt::format("an error below {}", lengthText(moment.value, unit, 6));
    case scene::Trigger::Kind::ProgressAbove:
      return fmt::format("a progress of {:g}", moment.value);
  }
  return "";
}

}  // namespace

TimelineRunner::TimelineRunner(const scene::Timeline& timeline,
                               const std::vector<brick::Brick>& bricks, int countsFrom,
                               const LengthUnit& unit)
    : timeline_(timeline),
      bricks_(bricks),
      countsFrom_(countsFrom),
      unit_(unit),
      pinned_(bricks.size(), false) {}

// Removes finished drags, then executes the due entries.
bool TimelineRunner::carryOut(const TimelineView& view, TimelineStage& stage,
                              std::vector<trajectory::Event>& events) {
  // A drag that ends now must not act in the next step.
  std::erase_if(drags_, [&](const ActiveDrag& active) {
    return view.time >= active.from + dragOf(active).seconds - kTimeRounding;
  });
  const std::size_t before = next_;
  // Only the first entry may use the current state, because its action changes it.
  while (next_ < timeline_.size() && isDue(timeline_[next_].when, view)) {
    const scene::TimelineEntry& entry = timeline_[next_];
    const bool ofTime = waitsForTime();
    if (next_ > before && !ofTime) break;
    carryOut(entry.action, view, stage);
    events.push_back({view.time, describe(entry.action, countsFrom_)});
    lastTime_ = view.time;
    ++next_;
  }
  return next_ > before;
}

/// The due time of a timed entry, seconds.
double TimelineRunner::dueTime(const scene::Trigger& moment) const {
  return moment.kind == scene::Trigger::Kind::After ? lastTime_ + moment.value : moment.value;
}

// Whether an entry's condition holds. Progress is 1 - error / startError, with the error at the
// time when the target was set.
bool TimelineRunner::isDue(const scene::Trigger& moment, const TimelineView& view) const {
  switch (moment.kind) {
    case scene::Trigger::Kind::AtTime:
    case scene::Trigger::Kind::After:
      return view.time >= dueTime(moment) - kTimeRounding;
    case scene::Trigger::Kind::AtRest:
      return view.atRest;
    case scene::Trigger::Kind::AtTarget:
      return view.atTarget;
    case scene::Trigger::Kind::ErrorBelow:
      return view.error < moment.value;
    case scene::Trigger::Kind::ProgressAbove:
      return view.error <= (1 - moment.value) * view.startError;
  }
  return false;
}

// Executes one action. `view` is the state before it.
void TimelineRunner::carryOut(const scene::timeline::Action& action, const TimelineView& view,
                              TimelineStage& stage) {
  if (const auto* pinning = std::get_if<scene::timeline::Pin>(&action)) {
    pin(pinning->tiles, true, stage);
  } else if (const auto* unpinning = std::get_if<scene::timeline::Unpin>(&action)) {
    pin(unpinning->tiles, false, stage);
  } else if (const auto* drag = std::get_if<scene::timeline::Drag>(&action)) {
    startDrag(*drag, view);
  } else if (const auto* forces = std::get_if<scene::timeline::Forces>(&action)) {
    forcesOn_ = forces->on;
  } else if (const auto* pause = std::get_if<scene::timeline::Pause>(&action)) {
    pausedUntil_ = view.time + pause->seconds - kTimeRounding;
  } else if (const auto* goTo = std::get_if<scene::timeline::GoTo>(&action)) {
    stage.goTo(goTo->file.empty() ? nullptr : &goTo->tiles);
  } else if (std::holds_alternative<scene::timeline::Reset>(action)) {
    reset(stage);
  } else if (std::holds_alternative<scene::timeline::Quit>(action)) {
    stage.quit();
  }  // snapshots and exports are handled by readers of the events
}

/// An empty list means all tiles.
void TimelineRunner::pin(const std::vector<int>& tiles, bool pinned, TimelineStage& stage) {
  if (tiles.empty()) pinned_.assign(pinned_.size(), pinned);
  for (const int tile : tiles) pinned_[tile] = pinned;
  stage.setPinned(pinned_);
}

// The path starts at the point's current position.
void TimelineRunner::startDrag(const scene::timeline::Drag& drag, const TimelineView& view) {
  const Vector3 point =
      drag.vertex ? bricks_[drag.tile].bottom[*drag.vertex] : Vector3(Vector3::Zero());
  std::vector<Vector3> path = {(*view.poses)[drag.tile].apply(point)};
  path.insert(path.end(), drag.path.begin(), drag.path.end());
  drags_.push_back({next_, point, std::move(path), view.time});
}

// Ends all drags, switches forces on, frees all tiles and restores the start. The timeline
// continues with its next entry.
void TimelineRunner::reset(TimelineStage& stage) {
  drags_.clear();
  forcesOn_ = true;
  pin({}, false, stage);
  stage.reset();
}

// The springs of all drags at a time (seconds). Anchors move at constant speed: the share of the
// path equals the share of the time.
std::vector<DragSpring> TimelineRunner::dragSprings(double time) const {
  std::vector<DragSpring> grips;
  for (const ActiveDrag& active : drags_) {
    const scene::timeline::Drag& drag = dragOf(active);
    const double share = (time - active.from) / drag.seconds;
    grips.push_back(
        {drag.tile, {active.point, pointOnPath(active.path, share), drag.stiffness, drag.damping}});
  }
  return grips;
}

void TimelineRunner::addDrags(double time, const Poses& poses,
                              std::vector<brick::Load>& loads) const {
  for (const DragSpring& grip : dragSprings(time))
    addPointSpring(grip.spring, poses[grip.tile], loads[grip.tile]);
}

void TimelineRunner::transfer(StateTape& tape) {
  tape.transfer(next_, lastTime_, pausedUntil_, forcesOn_, pinned_, drags_);
}

bool TimelineRunner::isOver(double time) const {
  return next_ == timeline_.size() && drags_.empty() && !isPaused(time);
}

// Steps end at this time: timed entries are executed exactly when due.
double TimelineRunner::nextMoment(double time) const {
  double next = std::numeric_limits<double>::infinity();
  const auto consider = [&](double moment) {
    if (moment > time + kTimeRounding) next = std::min(next, moment);
  };
  if (waitsForTime()) consider(dueTime(timeline_[next_].when));
  for (const ActiveDrag& active : drags_) consider(active.from + dragOf(active).seconds);
  consider(pausedUntil_ + kTimeRounding);
  return next;
}

// A run at rest must not end before such an entry.
bool TimelineRunner::waitsForTime() const {
  if (next_ == timeline_.size()) return false;
  const scene::Trigger::Kind kind = timeline_[next_].when.kind;
  return kind == scene::Trigger::Kind::AtTime || kind == scene::Trigger::Kind::After;
}

// A run at rest would wait for such an entry forever.
bool TimelineRunner::waitsForState() const {
  return next_ < timeline_.size() && !waitsForTime() && drags_.empty();
}

std::vector<int> TimelineRunner::pinnedTiles() const {
  std::vector<int> tiles;
  for (std::size_t i = 0; i < pinned_.size(); ++i) {
    if (pinned_[i]) tiles.push_back(static_cast<int>(i));
  }
  return tiles;
}

// Empty if all entries have been executed.
std::string TimelineRunner::pending() const {
  if (next_ == timeline_.size()) return "";
  const scene::TimelineEntry& entry = timeline_[next_];
  return fmt::format("the timeline still waits for {} to {}", momentText(entry.when, unit_),
                     scene::actionName(entry.action));
}

}  // namespace kirireel::run
