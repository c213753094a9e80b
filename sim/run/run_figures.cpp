// Figures of a run, measured at its start, after and within each step, at each sample and between
// samples. The state of each maximum and minimum is stored, so it can be recomputed from the
// trajectory. Sums (mean gap, cost) follow from the records of the steps. Each sample takes the
// records up to its own time.
#include "sim/run/run_figures.h"

#include <algorithm>
#include <limits>

#include "sim/run/mechanism_path.h"
#include "sim/trajectory/measures.h"

namespace kirireel::run {
namespace {

// Marks a state that does not belong to the run.
constexpr double kNoTime = -1;

}  // namespace

// `asRead`: overlaps of this state are given, and growth is measured from it.
RunFigures::RunFigures(const model::Model& model, const std::vector<brick::Brick>& bricks,
                       std::span<const brick::Pivot> pivots, double pivotZone, const Poses& asRead,
                       const AssembledState& nearest)
    : model_(model),
      bricks_(bricks),
      pivots_(pivots),
      tileSize_(model::tileSize(model)),
      overlaps_(std::make_unique<trajectory::PenetrationMeter>(
          bricks, pivots, pivotZone, asRead, trajectory::kRoundingOverlap * tileSize_)),
      asRead_(asRead),
      assembledError_(nearest.error),
      interpolator_(model, bricks) {
  if (!model.target) return;
  accuracy_.springsRestError = nearest.restError;
  states_.push_back({kAssembledError, kNoTime, nearest.poses});
  states_.push_back({nameOfField(&Accuracy::springsRestError), kNoTime, nearest.restPoses});
}

// The start counts in means and maxima like a step of zero length.
void RunFigures::begin(const Poses& start, bool jointsAreCompliant) {
  accuracy_.assemblyMove =
      trajectory::targetError(brick::bottomTiles(bricks_, asRead_), bricks_, start);
  accuracy_.targetErrorStart = accuracy_.targetErrorMin = targetErrorOf(start);
  if (model_.target) accuracy_.rigidBound = trajectory::rigidBound(model_.tiles, *model_.target);
  observe(0, start, {}, jointsAreCompliant, {});
}

// Measures the state after a step, and states within it. `report` is the cost of the step.
void RunFigures::observe(double time, const Poses& poses, const StepReport& report,
                         bool jointsAreCompliant, const StatesWithin& within) {
  // Interruptible work comes first, before any figure changes.
  const bool isStart = gaps_.count == 0;
  double grown = accuracy_.penetrationGrownMax, grownAt = time;
  const Poses* grownIn = isStart ? &poses : nullptr;
  std::vector<const Poses*> states;
  for (const Poses& state : within.states) states.push_back(&state);
  states.push_back(&poses);
  const auto depths =
      overlaps_->atLeastEach({trajectory::kAnyDepth, trajectory::kAnyDepth, grown}, states);
  const double interval = (time - within.begin) / static_cast<double>(states.size());
  for (std::size_t k = 0; k < states.size(); ++k) {
    if (!(depths[k].grown > grown)) continue;
    grown = depths[k].grown;
    const bool isLast = k + 1 == states.size();
    grownAt = isLast ? time : within.begin + interval * static_cast<double>(k + 1);
    grownIn = states[k];
  }
  trajectory::PenetrationDepths atStart;
  if (isStart) atStart = overlaps_->at(poses);
  const TimedPoses state = {time, poses};
  cost_.took += report;
  const trajectory::JointGap gap = trajectory::jointGap(pivots_, poses);
  gaps_.before = gaps_.now;
  gaps_.now = accuracy_.jointGapEnd = gap.max;
  gaps_.sumOfMeans += gap.mean;
  raise(&Accuracy::jointGapMax, gap.max, state);
  isCompliant_ = jointsAreCompliant;
  if (isCompliant_) raise(&Accuracy::jointOpeningMax, gap.max, state);
  if (isStart) raiseOverlaps(atStart, state);
  if (grownIn) raise(&Accuracy::penetrationGrownMax, grown, {grownAt, *grownIn});
  observeTarget(state, gap);
  ++gaps_.count;
  steps_.push_back({time, gap.max, gap.mean, accuracy_.targetErrorEnd, report});
}

void RunFigures::raiseOverlaps(const trajectory::PenetrationDepths& depths,
                               const TimedPoses& state) {
  raise(&Accuracy::penetrationMax, depths.whole, state);
  raise(&Accuracy::penetrationOutsidePivotsMax, depths.outsidePivots, state);
}

void RunFigures::keepState(const char* figure, const TimedPoses& state) {
  auto kept = std::ranges::find(states_, figure, &trajectory::FigureState::figure);
  if (kept == states_.end()) kept = states_.insert(kept, trajectory::FigureState{figure, 0, {}});
  kept->time = state.time;
  kept->poses = state.poses;
}

// The first value is always taken: every figure needs a state.
void RunFigures::raise(double Accuracy::*figure, double value, const TimedPoses& state) {
  if (gaps_.count > 0 && !(value > accuracy_.*figure)) return;
  accuracy_.*figure = value;
  keepState(nameOfField(figure), state);
}

// Updates two minima: over all states, and over states with closed joints.
void RunFigures::observeTarget(const TimedPoses& state, const trajectory::JointGap& gap) {
  if (!model_.target) return;
  const double error = accuracy_.targetErrorEnd = targetErrorOf(state.poses);
  if (gaps_.count == 0 || error < accuracy_.targetErrorMin) {
    accuracy_.targetErrorMin = error;
    keepState(nameOfField(&Accuracy::targetErrorMin), state);
  }
  if (gap.max <= model::kClosedShare * tileSize_ && error < assembledError_) {
    assembledError_ = error;
    keepState(kAssembledError, state);
  }
}

double RunFigures::targetErrorOf(const Poses& poses) const {
  return model_.target ? trajectory::targetError(*model_.target, bricks_, poses) : 0;
}

bool RunFigures::areClosed(const Poses& poses) const {
  return trajectory::jointGap(pivots_, poses).max <= model::kClosedShare * tileSize_;
}

// At both ends of the last step.
bool RunFigures::wereClosed() const {
  return std::max(gaps_.before, gaps_.now) <= model::kClosedShare * tileSize_;
}

// A sample takes the records of the steps up to its time. Later records wait. Overlaps may be
// deepest between two samples: ten states between them count too.
trajectory::Sample RunFigures::sampleAt(double time, Poses poses) {
  // Interruptible work comes first, before any figure changes.
  std::vector<Poses> states;
  if (!lastSample_.poses.empty() && lastSample_.time < time) {
    states = interpolator_.momentsBetween(lastSample_.poses, poses);
  }
  const double interval = (time - lastSample_.time) / (static_cast<double>(states.size()) + 1);
  states.push_back(poses);
  std::vector<const Poses*> measured;
  for (const Poses& state : states) measured.push_back(&state);
  const auto depths = overlaps_->atLeastEach(
      {accuracy_.penetrationMax, accuracy_.penetrationOutsidePivotsMax, trajectory::kAnyDepth},
      measured);
  trajectory::Sample sample;
  sample.time = time;
  sample.poses = std::move(poses);
  sample.jointGap = trajectory::jointGap(pivots_, sample.poses).max;
  sample.targetError = targetErrorOf(sample.poses);
  sample.penetration =
      overlaps_->atLeast({0, trajectory::kAnyDepth, trajectory::kAnyDepth}, sample.poses).whole;
  for (std::size_t k = 0; k < states.size(); ++k) {
    const double moment = time - interval * static_cast<double>(states.size() - 1 - k);
    raiseOverlaps(depths[k], {moment, states[k]});
  }
  const TimedPoses state = {time, sample.poses};
  raise(&Accuracy::jointGapMax, sample.jointGap, state);
  if (isCompliant_) raise(&Accuracy::jointOpeningMax, sample.jointGap, state);
  if (model_.target && sample.targetError < accuracy_.targetErrorMin) {
    accuracy_.targetErrorMin = sample.targetError;
    keepState(nameOfField(&Accuracy::targetErrorMin), state);
  }
  lastSample_ = {time, sample.poses};
  const auto later = std::ranges::find_if(
      steps_, [&](const trajectory::StepRecord& step) { return step.time > time; });
  sample.steps.assign(steps_.begin(), later);
  steps_.erase(steps_.begin(), later);
  return sample;
}

// The final figures are those of the sample. Kept states are discarded.
void RunFigures::endWith(const trajectory::Sample& sample) {
  accuracy_.jointGapEnd = sample.jointGap;
  accuracy_.targetErrorEnd = sample.targetError;
  states_.clear();
}

void RunFigures::copyTo(DeploymentResult& result) const {
  result.accuracy = accuracy_;
  result.accuracy.jointGapMean = gaps_.sumOfMeans / static_cast<double>(gaps_.count);
  result.cost = cost_;
  result.assembledError = assembledError_;
  result.trajectory.figureStates = states_;
}

void RunFigures::transfer(StateTape& tape) {
  tape.transfer(accuracy_, assembledError_, cost_, gaps_.count, gaps_.sumOfMeans);
}

void RunFigures::transferStates(StateTape& tape) {
  tape.transfer(states_, steps_, gaps_.before, gaps_.now, lastSample_.time, lastSample_.poses,
                isCompliant_);
}

OverlapWatch::OverlapWatch(const scene::Scene& scene)
    : filter_(scene.environment.contacts),
      bricks_(brick::makeBricks(scene.model.tiles, scene.brick)),
      pivots_(brick::makePivots(scene.model.joints, bricks_)),
      meter_(overlapMeter(scene.environment, bricks_, pivots_,
                          brick::startPoses(scene.model.tiles, bricks_))) {}

void OverlapWatch::observe(const Poses& poses) {
  if (filter_ != scene::ContactFilter::Unjoined) return;
  grown_ = meter_.grownAt(poses, grown_);
}

double OverlapWatch::grown(const Accuracy& accuracy) const {
  if (filter_ == scene::ContactFilter::None) return 0;
  return filter_ == scene::ContactFilter::Unjoined ? grown_ : accuracy.penetrationGrownMax;
}

}  // namespace kirireel::run
