// What a run keeps in a checkpoint, and how it goes on from one: its state apart from its figures,
// then each sample with the figures so far, so that samples can be shown again.
#include <algorithm>
#include <variant>
#include <vector>

#include "sim/deploy/run.h"

namespace kirireel {

/// Keeps a sample with the figures so far, for the next checkpoint.
void Run::note(Sample& sample) {
  checkpoints_->samples().transfer(sample);
  transferFigures(checkpoints_->samples());
}

void Run::transferFigures(StateTape& tape) {
  tape.transfer(lookCount_, sinceLook_, length_, sampleCount_, lastSampleTime_, figures_);
}

/// What the run goes on from, apart from its figures.
void Run::transfer(StateTape& tape) {
  std::vector<const std::vector<Tile>*> targets = {nullptr};
  if (scene_.model.target) targets.push_back(&*scene_.model.target);
  for (const TimelineEntry& entry : scene_.timeline) {
    const auto* going = std::get_if<timeline::GoTo>(&entry.action);
    if (going) targets.push_back(&going->tiles);
  }
  double spent = spentSeconds();
  auto number = std::find(targets.begin(), targets.end(), target_) - targets.begin();
  bool isLed = follower_.has_value();
  transferFigures(tape);
  tape.transfer(motion_, number, targetStartError_, leastError_, departure_, departureTime_,
                openedAt_, isLed, stiffness_, timeline_, nudged_, restTime_, restNeeded_, misfit_,
                heldOpen_, jamStart_, result_.trajectory.events, before_, spent, *dynamics_);
  figures_.transferStates(tape);
  if (mechanics_) tape.transfer(*mechanics_);
  if (!tape.isPlaying()) return;
  earlierSeconds_ = spent;
  target_ = targets.at(static_cast<std::size_t>(number));
  if (hasSprings()) tieSprings();
  if (!isLed) follower_.reset();
}

void Run::saveState() {
  StateTape tape;
  transfer(tape);
  checkpoints_->save({time(), tape.numbers()});
}

/// Shows the samples of the processes before this one, then takes over where they ended.
void Run::goOnFrom(const RunState& state) {
  StateTape tape(state.numbers);
  transfer(tape);
  StateTape figures;
  transferFigures(figures);
  Sample shown;
  checkpoints_->playSamples([&](StateTape& samples) {
    samples.transfer(shown);
    transferFigures(samples);
    isAskedToEnd_ = observers_.sample && !observers_.sample(shown);
    return !isAskedToEnd_;
  });
  if (isAskedToEnd_ && shown.time < state.time) return endWith(shown);
  StateTape latest(figures.numbers());
  transferFigures(latest);
}

/// Ends a run on the way to its checkpoint, which stays as it is. Which states the figures so far
/// were reached in is not known here.
void Run::endWith(const Sample& shown) {
  isReplayed_ = true;
  motion_.poses = shown.poses;
  figures_.endWith(shown);
  std::erase_if(result_.trajectory.events,
                [&](const Event& event) { return event.time > shown.time; });
  interrupt();
}

}  // namespace kirireel
