// The direct solver: a step finds velocities that joints and contacts allow, moves the bricks by
// them, and closes the joints again.
#include "sim/mechanics/joint_solver.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "sim/mechanics/friction_region.h"
#include "sim/mechanics/rigid_pieces.h"
#include "sim/mechanics/step_system.h"

namespace kirireel::mechanics {

// ------------------------------------------------------------------------------------------------
// The step of the solver, in the plane and in space.

/// The result of trying a step.
enum class StepOutcome { Good, JointsOpen, Overlapping };

/// The end of a step with known velocities.
struct StepEnd {
  Poses poses;              ///< empty until the velocities are found
  Eigen::VectorXd closing;  ///< displacements that closed the joints
  bool jumped = false;      ///< closing moved farther than kJumpShare allows
};

/// A plane of contacts with friction.
struct FrictionPlane {
  std::size_t first = 0;        ///< of its contacts among all
  Vector3 normal;               ///< world axes
  std::vector<Vector3> points;  ///< of its contacts, world axes
  FrictionRegion region;        ///< that touches
};

/// The rows of a step's contacts. The next step starts with them.
template <int D>
struct KeptRows {
  std::vector<ContactRow<D>> contacts;  ///< held contacts, else planes that carried load
  std::vector<ContactRow<D>> supports;
  std::vector<ContactRow<D>> friction;  ///< of the contacts
  double step = 1;                      ///< length of the step of these impulses, s
};

/// The joint solver with D degrees of freedom per brick. The functions are in the order of a step.
/// Comments are at their definitions.
template <int D>
class Stepper : public JointSolver {
 public:
  Stepper(const std::vector<brick::Brick>& bricks, std::span<const brick::Pivot> pivots,
          const JointSolverSettings& settings)
      : bricks_(bricks),
        settings_(settings),
        system_(bricks, pivots, settings.lengthScale, settings.pairForces),
        loads_(bricks.size()) {
    system_.omitRepeatedRows();
    program_.multipliers = Vector::Zero(system_.jointRowCount());
    program_.x = Vector::Zero(D * bricks.size());
    pinned_.assign(bricks.size(), false);
  }

  StepReport advance(Motion& motion, double step, const LoadSource& loads,
                     brick::ContactSource* contacts) override;
  void holdContacts(const std::vector<brick::Contact>& contacts) override;
  std::vector<brick::Contact> heldContacts() const override;
  std::vector<brick::Contact> pushingContacts() const override;
  StepReport eulerStep(Motion& motion, double step, const LoadSource& loads,
                       LoadGain& given) override;
  double energy(const Motion& motion) const override;
  std::vector<double> heldForces() const override;
  void setHeldForces(const std::vector<double>& forces) override;
  double stickSlipSpeed(const Motion& start) const override;
  double timeOfReversal(const Motion& start, const Motion& end, double slow) const override;
  double project(Motion& motion) override;
  bool collide(Motion& motion) override;
  void setPinned(const std::vector<bool>& pinned) override;
  void setJointStiffness(double stiffness) override;
  void forgetSteps() override;
  bool setHalving(bool isOn) override { return std::exchange(settings_.isHalving, isOn); }
  void setFine(bool isOn) override { settings_.isFine = isOn; }
  std::vector<ContactLoad> contactLoads() const override;
  std::vector<TouchForce> touchForces(const Poses& poses) const override;
  double jointStiffness() const override { return jointStiffness_; }
  double assemble(Poses& poses) override;
  void transfer(StateTape& tape) override;

 private:
  using Space = Coordinates<D>;
  using Vector = Eigen::VectorXd;
  using Row = ContactRow<D>;

  void advanceHalving(Motion& motion, double step, const LoadSource& loads, int level, bool warm);
  void beginStep(const Motion& start, double step);
  void placeHeldRows(const Poses& poses, double step);
  void keepHeldRows(double step);
  Vector packed(const Motion& motion) const;
  static bool sticks(const Row& row);
  static Vector3 inSpace(const Row& row, const typename Row::Tangent& components);
  Vector3 slipOf(Row row, const Poses& poses, const Vector& velocities) const;
  bool solveWithFriction(const Poses& start);
  bool boundFriction(const std::vector<FrictionPlane>& planes, const Poses& poses);
  bool allowsVelocities(const Motion& motion);
  bool projectVelocities(Motion& motion, bool withFriction);
  bool factorMasses(std::vector<Row>& held);
  double closeGaps(Poses& poses, std::vector<Row> held);
  double largestGap(const Vector& gaps, const std::vector<Row>& held) const;
  void countLosses(double step, bool areHeld);
  void addGain(const Poses& poses, double step, LoadGain& given) const;
  StepOutcome tryStep(const Motion& start, double step, const LoadSource& loads, bool warm);
  StepOutcome solveContactRounds(const Poses& start, double step);
  bool appendRows(const std::vector<brick::Contact>& found, const Poses& start, double step);
  bool boundNewFriction(const Poses& start);
  std::vector<FrictionPlane> frictionPlanes(const Poses& poses, bool isHeld) const;
  void appendFriction(const FrictionPlane& plane, const Poses& poses, std::vector<Row>& rows) const;
  void startRows(const Poses& start, double step, bool warm);
  void carryOver(const Row& old, const Poses& start, double step);
  void carryRegionOver(const Row* first, const Row* last, const Poses& start, double step);
  void addSupports(const Poses& poses, double step);
  Row contactRow(const brick::Contact& contact, const Poses& start, double step) const;
  void holdPinned(Row& row) const;
  bool solveVelocities(const Poses& start);
  bool solveWithPairForces(const Poses& start, double step);
  double shareWithWork(double tolerance) const;
  void limitWork();
  bool moveAndClose(const Poses& start, double step);
  void limitEnergyAfterClosing(const Poses& start, double step);
  void standStill(const Poses& start);
  bool moveAsPieces(Motion& motion, double step, const LoadSource& loads);
  std::vector<std::pair<int, int>> pairsThatHold() const;
  bool closeJoints(const std::vector<Row>& contacts, double step);
  Vector closingMove(const Vector& gaps, const std::vector<Row>& contacts,
                     const std::function<double(const Row&)>& aim) const;
  Vector extrapolated(const Vector& move, const Vector& lastMove) const;
  double overlap(const Row& row) const;
  bool anyOverlap(const std::vector<Row>& contacts) const;
  void displace(const Vector& move);
  double product(const Vector& a, const Vector& b) const;
  double norm(const Vector& move) const;
  double energyOfMotion(const Motion& motion) const;
  void finishStep(Motion& motion) const;
  void keepMultipliers(double step);

  const std::vector<brick::Brick>& bricks_;
  JointSolverSettings settings_;
  StepSystem<D> system_;
  brick::ContactSource* contactSource_ = nullptr;
  double jointStiffness_ = std::numeric_limits<double>::infinity();
  StepReport report_;
  std::vector<bool> pinned_;

  // The current step.
  std::vector<brick::Load> loads_;
  bool isShortest_ = false;    // it is not halved, and discontinuities are accepted
  Vector startSpeed_;          // velocities at its start
  StepProgram<D> program_;     // for its velocities; starts from the multipliers of the last step
  double multiplierStep_ = 1;  // length of the step of these multipliers, s
  StepEnd end_;
  KeptRows<D> kept_;
  Standstill standstill_;
};

// ------------------------------------------------------------------------------------------------
// A step: loads, velocities that joints and contacts allow, poses, closing, and the treatment of
// failed steps. See JointSolver for the equations.

namespace {

// Lengths are in length scales, speeds in length scales per second.
// Tolerances of speeds are relative to the fastest brick, whose speed counts as at least kSlow.
constexpr double kSlow = 1e-3;
constexpr double kSpeedTolerance = 1e-10;        // speed of joint rows
constexpr double kContactSpeedTolerance = 1e-7;  // speed of contact rows
constexpr double kChangeTolerance = 1e-6;        // change of all rows in a round
constexpr double kFineTolerance = 1e-13;         // expected next change, for fine velocities
constexpr double kConstant = 0.9;                // smallest share of a speed that hardly decreases
constexpr double kWorkTolerance = 1e-6;          // error of impulses, relative to the loads' work
constexpr double kRecovery = 2e-6;               // largest correction of an overlap in a step
constexpr double kOverlapAccepted = 4e-5;        // largest overlap at the end of a step
constexpr double kWorkOfPair = 1000;             // cost of checking a pair, in multiplications
constexpr int kHalvings = 8;
constexpr int kContactHalvings = 5;
// Exact joints mostly need one or two rounds, singular states a few more.
constexpr int kMultiplierRounds = 6;
constexpr int kContactRounds = 25;
// Bounds of friction have converged if they change by less than this fraction.
constexpr double kBoundTolerance = 1e-7;
constexpr int kFrictionRounds = 20;
constexpr double kTouching = 1e-6;  // largest gap of points with friction
// Newton's method for forces between pairs: maximum number of rounds, relative change of speed at
// its end, and smallest fraction of a Newton step.
constexpr int kPairRounds = 20;
constexpr double kPairTolerance = 1e-8;
constexpr double kMinShare = 1e-6;

}  // namespace

// Skips a step that would only repeat a standstill.
template <int D>
StepReport Stepper<D>::advance(Motion& motion, double step, const LoadSource& loads,
                               brick::ContactSource* contacts) {
  contactSource_ = contacts;
  report_ = {};
  if (standstill_.isWhole()) loads(motion.poses, loads_);
  if (!standstill_.beginStep(motion, loads_, step)) return {.steps = 1, .unconverged = 1};
  const int before = system_.factorizations();
  const double workBefore = system_.work();
  const double pairsBefore = contacts ? contacts->pairsExamined() : 0;
  advanceHalving(motion, step, loads, 0, true);
  standstill_.endStep(motion.poses, loads_);
  report_.factorizations = system_.factorizations() - before;
  const double pairs = contacts ? contacts->pairsExamined() - pairsBefore : 0;
  report_.work = system_.work() - workBefore + kWorkOfPair * pairs;
  return report_;
}

template <int D>
void Stepper<D>::setJointStiffness(double stiffness) {
  jointStiffness_ = stiffness;
  program_.exactJoints = !std::isfinite(stiffness);
  forgetSteps();
}

template <int D>
void Stepper<D>::forgetSteps() {
  program_.multipliers.setZero();
  standstill_.forget();
}

/// `warm`: whether to start with the contacts of the previous part. The first half of a failed step
/// starts without them, because they may have caused the failure.
template <int D>
void Stepper<D>::advanceHalving(Motion& motion, double step, const LoadSource& loads, int level,
                                bool warm) {
  end_.jumped = false;
  isShortest_ = !settings_.isHalving || level == kHalvings || !standstill_.mayHalve();
  const StepOutcome outcome = tryStep(motion, step, loads, warm);
  const bool halving = outcome == StepOutcome::JointsOpen ||
                       (outcome == StepOutcome::Overlapping && level < kContactHalvings);
  if (halving && !isShortest_) {
    ++report_.halved;
    advanceHalving(motion, 0.5 * step, loads, level + 1, false);
    advanceHalving(motion, 0.5 * step, loads, level + 1, true);
    return;
  }
  ++report_.steps;
  if (outcome != StepOutcome::Good || end_.jumped) ++report_.unconverged;
  // A step whose velocities were not found has no end.
  if (outcome != StepOutcome::Good && (contactSource_ || end_.poses.empty())) {
    if (contactSource_ && moveAsPieces(motion, step, loads)) return standstill_.recordMotion();
    standstill_.recordStandstill();
    standStill(motion.poses);
  } else {
    // At a singular state, the energy of the loads may not suffice for any motion.
    if (end_.jumped && program_.x.isZero(0)) {
      standstill_.recordStandstill();
    } else {
      standstill_.recordMotion();
    }
    keepMultipliers(step);
    countLosses(step, false);
  }
  finishStep(motion);
}

/// Sets up the system and the program for a step under the current loads.
template <int D>
void Stepper<D>::beginStep(const Motion& start, double step) {
  system_.setStep(start, loads_, step, jointStiffness_);
  if (!program_.exactJoints) {
    // A constant multiplier represents the spring force k (gap + h J u) at the step's end.
    program_.multipliers = -system_.kappa() / step * system_.jointGaps(start.poses);
  }
  program_.force = system_.force();
  program_.x = packed(start);
}

/// A step from its start: loads, system, contacts of the last step.
template <int D>
StepOutcome Stepper<D>::tryStep(const Motion& start, double step, const LoadSource& loads,
                                bool warm) {
  end_.poses.clear();
  loads(start.poses, loads_);
  beginStep(start, step);
  // Without the contacts of the last step, the impulses of joints that balance them would do work.
  if (!warm && contactSource_) program_.multipliers.setZero();
  startRows(start.poses, step, warm);
  startSpeed_ = program_.x;
  return solveContactRounds(start.poses, step);
}

/// Solves the step, adds new contacts, and repeats until there are no new ones.
template <int D>
StepOutcome Stepper<D>::solveContactRounds(const Poses& start, double step) {
  for (int round = 0; round < kContactRounds; ++round) {
    if (!solveWithPairForces(start, step)) return StepOutcome::JointsOpen;
    if (boundNewFriction(start) && !solveWithPairForces(start, step))
      return StepOutcome::JointsOpen;
    limitWork();
    if (!moveAndClose(start, step)) return StepOutcome::JointsOpen;
    limitEnergyAfterClosing(start, step);
    if (!contactSource_) return StepOutcome::Good;
    std::vector<brick::Contact> found;
    const double overlap = contactSource_->appendViolated(end_.poses, found);
    if (!appendRows(found, start, step)) {
      return overlap <= kOverlapAccepted * settings_.lengthScale ? StepOutcome::Good
                                                                 : StepOutcome::Overlapping;
    }
  }
  return StepOutcome::Overlapping;
}

/// Adds rows for new contacts. Returns whether it added any.
template <int D>
bool Stepper<D>::appendRows(const std::vector<brick::Contact>& found, const Poses& start,
                            double step) {
  const std::size_t before = program_.contacts.size();
  for (const brick::Contact& contact : found) {
    const auto end = program_.contacts.begin() + static_cast<std::ptrdiff_t>(before);
    const bool known = std::any_of(program_.contacts.begin(), end,
                                   [&](const Row& row) { return row.contact == contact; });
    if (known) continue;
    Row row = contactRow(contact, start, step);
    row.active = row.trialImpulse(program_.x, system_.rho()) > 0;
    program_.contacts.push_back(row);
  }
  return program_.contacts.size() > before;
}

/// The planes of contacts with friction: of all held contacts, otherwise of pushing contacts that
/// have no friction rows yet. The region of friction has the points that touch or push. Held
/// contacts always touch.
template <int D>
std::vector<FrictionPlane> Stepper<D>::frictionPlanes(const Poses& poses, bool isHeld) const {
  std::vector<FrictionPlane> planes;
  const std::vector<Row>& rows = program_.contacts;
  for (auto first = rows.begin(), last = first; first != rows.end(); first = last) {
    last = endOfPlane<D>(first, rows.end());
    if (!first->hasNormal || first->contact.friction == 0) continue;
    const auto pushes = [](const Row& row) { return row.multiplier > 0; };
    if (!isHeld && (first->hasFrictionRows || std::none_of(first, last, pushes))) continue;
    FrictionPlane plane;
    plane.first = static_cast<std::size_t>(first - rows.begin());
    plane.normal = brick::contactNormal(first->contact, poses);
    std::vector<Vector3> touching;
    for (auto row = first; row != last; ++row) {
      plane.points.push_back(brick::contactPoints(row->contact, poses).onA);
      const bool touches =
          isHeld || pushes(*row) ||
          brick::contactGap(row->contact, poses) <= kTouching * settings_.lengthScale;
      if (touches) touching.push_back(plane.points.back());
    }
    // In planar motion friction acts along one line for any points.
    if (D == 6 && !touching.empty()) plane.region = FrictionRegion(touching, plane.normal);
    planes.push_back(std::move(plane));
  }
  return planes;
}

/// Appends the friction rows of a plane. They represent an even pressure. Appends nothing without
/// pressure.
template <int D>
void Stepper<D>::appendFriction(const FrictionPlane& plane, const Poses& poses,
                                std::vector<Row>& rows) const {
  Vector3 centre = Vector3::Zero();
  double push = 0;
  for (std::size_t k = 0; k < plane.points.size(); ++k) {
    const double multiplier = program_.contacts[plane.first + k].multiplier;
    push += multiplier;
    centre += multiplier * plane.points[k];
  }
  if (!(push > 0)) return;
  centre /= push;
  Row row;
  row.contact = program_.contacts[plane.first].contact;
  const Pose& poseA = brick::poseOf(row.contact.brickA, poses);
  const Pose& poseB = brick::poseOf(row.contact.brickB, poses);
  row.hasNormal = false;
  if (row.contact.isRegion && row.contact.isEdge) {
    row.contact.isEdge = false;
    row.contact.normal = poseB.rotation.conjugate() * plane.normal;
  }
  for (const FrictionPoint& part : plane.region.points(centre)) {
    row.contact.pointA = poseA.rotation.conjugate() * (part.point - poseA.position);
    row.contact.pointB = poseB.rotation.conjugate() * (part.point - poseB.position);
    row.slipShare = part.share;
    row.slipBound = row.contact.friction * part.share * push;
    placeRow(row, poses);
    holdPinned(row);
    rows.push_back(row);
  }
}

/// Adds friction to contacts that have begun to push. Returns whether there were any.
template <int D>
bool Stepper<D>::boundNewFriction(const Poses& start) {
  std::vector<Row> found;
  for (const FrictionPlane& plane : frictionPlanes(start, false)) {
    const std::size_t before = found.size();
    appendFriction(plane, start, found);
    program_.contacts[plane.first].hasFrictionRows = found.size() > before;
  }
  program_.contacts.insert(program_.contacts.end(), found.begin(), found.end());
  return !found.empty();
}

/// Starts with the planes that carried load in the last step and still exist.
template <int D>
void Stepper<D>::startRows(const Poses& start, double step, bool warm) {
  program_.contacts.clear();
  program_.settlesSlowContacts = false;
  addSupports(start, step);
  if (!contactSource_) return;
  contactSource_->startStep(start);
  if (!warm) return;
  for (auto first = kept_.contacts.begin(); first != kept_.contacts.end();) {
    const auto last = endOfPlane<D>(first, kept_.contacts.end());
    const bool isCurrent = std::any_of(first, last, [&](const Row& row) {
      return row.multiplier > 0 && contactSource_->isCurrent(row.contact);
    });
    if (isCurrent && first->contact.isRegion) {
      carryRegionOver(&*first, &*first + (last - first), start, step);
    } else if (isCurrent) {
      std::for_each(first, last, [&](const Row& row) { carryOver(row, start, step); });
    }
    first = last;
  }
  // The friction of these planes starts with the bound and the impulse of the last step.
  if (!boundNewFriction(start)) return;
  auto old = kept_.friction.begin();
  for (Row& row : program_.contacts) {
    if (row.slipShare == 0) continue;
    while (old != kept_.friction.end() && !onOnePlane(old->contact, row.contact)) ++old;
    if (old == kept_.friction.end()) break;
    row.slipMultiplier = step / kept_.step * (old++)->slipMultiplier;
  }
}

/// Adds the row of a contact of the last step.
template <int D>
void Stepper<D>::carryOver(const Row& old, const Poses& start, double step) {
  Row row = contactRow(old.contact, start, step);
  // Multipliers are impulses, proportional to the length of the step.
  row.multiplier = step / kept_.step * old.multiplier;
  row.active = row.multiplier > 0;
  program_.contacts.push_back(row);
}

/// Adds the current corners of a region of the last step. Each impulse of the region moves to the
/// nearest corner.
template <int D>
void Stepper<D>::carryRegionOver(const Row* first, const Row* last, const Poses& start,
                                 double step) {
  std::vector<brick::Contact> corners;
  contactSource_->appendRegion(first->contact, corners);
  for (const brick::Contact& corner : corners) {
    const bool isKnown = std::ranges::any_of(program_.contacts,
                                             [&](const Row& row) { return row.contact == corner; });
    if (!isKnown) program_.contacts.push_back(contactRow(corner, start, step));
  }
  for (; first != last; ++first) {
    if (!(first->multiplier > 0)) continue;
    Row* nearest = nullptr;
    double least = std::numeric_limits<double>::infinity();
    const Vector3 place = brick::contactPoints(first->contact, start).onA;
    for (Row& row : program_.contacts) {
      if (!row.hasNormal || !brick::onOnePlane(row.contact, first->contact)) continue;
      const double off = (brick::contactPoints(row.contact, start).onA - place).norm();
      if (off >= least) continue;
      least = off;
      nearest = &row;
    }
    if (!nearest) continue;
    nearest->multiplier += step / kept_.step * first->multiplier;
    nearest->active = true;
  }
}

template <int D>
void Stepper<D>::addSupports(const Poses& poses, double step) {
  for (std::size_t s = 0; s < settings_.supports.size(); ++s) {
    const Support& support = settings_.supports[s];
    Row row;
    row.contact = {support.brick, brick::kFixed, support.point, Vector3::Zero(), Vector3::UnitZ()};
    row.hasNormal = false;
    row.slipBound = support.largestForce * step;
    if (s < kept_.supports.size()) {
      row.slipMultiplier = step / kept_.step * kept_.supports[s].slipMultiplier;
    }
    placeRow(row, poses);
    holdPinned(row);
    program_.contacts.push_back(row);
  }
}

template <int D>
ContactRow<D> Stepper<D>::contactRow(const brick::Contact& contact, const Poses& start,
                                     double step) const {
  Row row = makeContactRow<D>(contact, start, step, kRecovery * settings_.lengthScale);
  holdPinned(row);
  return row;
}

/// Clears the rows of pinned bricks, which no contact moves.
template <int D>
void Stepper<D>::holdPinned(Row& row) const {
  const auto isHeld = [&](int body) { return brick::isBrick(body) && pinned_[body]; };
  if (isHeld(row.contact.brickA)) {
    row.normalA.setZero();
    row.tangentA.setZero();
  }
  if (isHeld(row.contact.brickB)) {
    row.normalB.setZero();
    row.tangentB.setZero();
  }
}

/// Finds the velocities of the step with the current contacts.
template <int D>
bool Stepper<D>::solveVelocities(const Poses& start) {
  system_.placeJoints(start);
  setSlipStates(program_, system_.rho());
  if (!system_.factor(program_.contacts)) return false;
  const double slow = kSlow * settings_.lengthScale;
  double last = std::numeric_limits<double>::infinity();
  double lastJointSpeed = last;
  for (int round = 0; round < kMultiplierRounds; ++round) {
    const RoundReport report = solveRound(system_, program_, slow);
    if (!report.found) return false;
    const double speed = std::max(system_.largestSpeed(program_.x), slow);
    const bool refined = report.change <= kChangeTolerance * speed &&
                         report.contactChange <= kContactSpeedTolerance * speed;
    // Changes decrease by a constant ratio.
    const double next = report.change * std::min(1.0, report.change / last);
    last = report.change;
    // Contacts may contradict the joints by rounding. Further rounds then only drift.
    const bool isConstant = report.jointSpeed > kConstant * lastJointSpeed &&
                            report.jointSpeed <= kContactSpeedTolerance * speed;
    lastJointSpeed = report.jointSpeed;
    if (settings_.isFine && next > kFineTolerance * speed && !isConstant) continue;
    if (refined && (isConstant || report.jointSpeed <= kSpeedTolerance * speed)) break;
  }
  return true;  // the gap after closing shows whether the step is good
}

/// Finds the velocities of the step with the pair forces at its end. Newton's method minimises the
/// potential from rest. Each Newton step is halved until the potential decreases, so a step gains
/// no energy for any stiffness of ligaments. The halved step is allowed, because the velocities
/// that joints and contacts allow form a convex set. Compliant joints are not part of the
/// potential. Newton steps are then complete.
template <int D>
bool Stepper<D>::solveWithPairForces(const Poses& start, double step) {
  if (!system_.hasPairBlocks()) return solveVelocities(start);
  Vector known = Vector::Zero(program_.x.size());
  double least = system_.potential(step, known);
  for (int round = 0; round < kPairRounds; ++round) {
    system_.setPairBlocksAbout(known, PairBlocks<D>::Curvature::Convex);
    program_.force = system_.force();
    if (!solveVelocities(start)) return false;
    const Vector change = program_.x - known;
    double share = 1, potential = system_.potential(step, program_.x);
    while (potential > least && share > kMinShare && program_.exactJoints) {
      share *= 0.5;
      potential = system_.potential(step, known + share * change);
    }
    const double speed = std::max(system_.largestSpeed(program_.x), kSlow * settings_.lengthScale);
    if (potential > least && program_.exactJoints) share = 0;
    known += share * change;
    least = std::min(least, potential);
    if (share == 0 || system_.largestSpeed(share * change) <= kPairTolerance * speed) break;
  }
  program_.x = known;
  return true;
}

/// Joints and contacts do no work on the bricks, so x.Ax (the energy of the motion) is at most x.f
/// (the available energy). Impulses that have not converged may violate this. Returns the largest
/// fraction of the velocities for which the energy suffices, [0, 1]. It is 1 if the energy suffices
/// to a relative tolerance, with compliant joints, and without contacts, because joints converge in
/// shorter steps.
template <int D>
double Stepper<D>::shareWithWork(double tolerance) const {
  if (program_.contacts.empty() || !program_.exactJoints) return 1;
  const double cost = program_.x.dot(system_.timesA(program_.x));
  const double means = program_.x.dot(program_.force);
  const double slow = kSlow * settings_.lengthScale;
  double slowCost = 0;
  for (const brick::Brick& brick : bricks_) slowCost += brick.mass * slow * slow;
  const double allowed = tolerance * std::max(cost, slowCost);
  return cost - means > allowed ? std::max(0.0, means / cost) : 1;
}

/// Slows all bricks if impulses are not exact, as among jammed bricks: no step gains energy. Joints
/// and contacts allow this, because they also allow rest.
template <int D>
void Stepper<D>::limitWork() {
  const double share = shareWithWork(0);
  if (share < 1) program_.x *= share;
}

/// Moves all poses by displacements, D coordinates per brick.
template <int D>
void Stepper<D>::displace(const Vector& move) {
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    Space::displace(end_.poses[i], move.segment<D>(D * i));
  }
}

/// Stores the impulses for the next step. Planes with load are stored with all their points,
/// because the load may move to other points.
template <int D>
void Stepper<D>::keepMultipliers(double step) {
  kept_.step = multiplierStep_ = step;
  kept_.contacts.clear();
  kept_.supports.clear();
  kept_.friction.clear();
  const std::vector<Row>& rows = program_.contacts;
  for (auto first = rows.begin(); first != rows.end();) {
    const auto last = endOfPlane<D>(first, rows.end());
    const bool loaded = std::any_of(first, last, [](const Row& row) { return row.multiplier > 0; });
    if (!first->hasNormal) {
      (first->slipShare > 0 ? kept_.friction : kept_.supports).push_back(*first);
    } else if (loaded) {
      kept_.contacts.insert(kept_.contacts.end(), first, last);
    }
    first = last;
  }
}

/// Adds the energy that dampers and contacts dissipate in the step. A contact dissipates its
/// impulse times the mean of the velocities before and after (Kelvin). Held contacts dissipate by
/// friction only, because their points do not approach each other. If joints also hold the points
/// of a contact, single impulses are arbitrary, and only their sum is known. Impacts therefore
/// dissipate at most the work of all impulses.
template <int D>
void Stepper<D>::countLosses(double step, bool areHeld) {
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const typename Space::Vector velocity = program_.x.template segment<D>(D * i);
    report_.damped += step * velocity.dot(Space::restrict(loads_[i].damping) * velocity);
  }
  report_.damped += system_.dampedBySprings(step, program_.x);
  if (program_.contacts.empty()) return;
  const Vector mean = 0.5 * (startSpeed_ + program_.x);
  double impacts = 0, friction = 0;
  for (const Row& row : program_.contacts) {
    if (row.hasNormal) impacts -= row.multiplier * row.normalVelocity(mean);
    friction -= row.slipMultiplier.dot(row.slipVelocity(mean));
  }
  report_.impacted += friction;
  if (areHeld) return;
  const double all = mean.dot(program_.force - system_.timesA(program_.x));
  report_.impacted += std::clamp(impacts, 0.0, std::max(0.0, all - friction));
}

/// Writes the new state. The rotation of the step keeps the angular momentum of each brick.
template <int D>
void Stepper<D>::finishStep(Motion& motion) const {
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    Velocity velocity = Space::unpack(program_.x.template segment<D>(D * i));
    if constexpr (D == 6) {
      const Quaternion& before = motion.poses[i].rotation;
      const Quaternion& after = end_.poses[i].rotation;
      const Vector3 momentum = bricks_[i].inertia * (before.conjugate() * velocity.angular);
      const Vector3 turned = after.conjugate() * (before * momentum);
      velocity.angular = after * bricks_[i].inertia.llt().solve(turned);
    }
    motion.velocities[i] = velocity;
  }
  motion.poses = end_.poses;
}

template <int D>
void Stepper<D>::setPinned(const std::vector<bool>& pinned) {
  pinned_ = pinned;
  system_.setPinned(pinned);
  standstill_.forget();
}

template <int D>
std::vector<ContactLoad> Stepper<D>::contactLoads() const {
  std::map<std::pair<int, int>, double> forces;
  for (const Row& row : kept_.contacts) {
    const auto [low, high] = std::minmax(row.contact.brickA, row.contact.brickB);
    const std::pair<int, int> pair =
        brick::isBrick(low) ? std::pair<int, int>(low, high) : std::pair<int, int>(high, low);
    if (row.multiplier > 0) forces[pair] += row.multiplier / kept_.step;
  }
  std::vector<ContactLoad> loads;
  for (const auto& [pair, force] : forces) loads.push_back({pair.first, pair.second, force});
  std::ranges::stable_sort(loads, std::greater{}, &ContactLoad::force);
  return loads;
}

/// The vector with these components along a row's tangents, as it acts on brick A, or on brick B if
/// A is fixed. World axes.
template <int D>
Vector3 Stepper<D>::inSpace(const Row& row, const typename Row::Tangent& components) {
  // The velocity of a brick's point along a direction begins with that direction.
  constexpr int kAxes = D == 6 ? 3 : 2;
  const auto& tangents = brick::isBrick(row.contact.brickA) ? row.tangentA : row.tangentB;
  Vector3 vector = Vector3::Zero();
  vector.head<kAxes>() = tangents.template leftCols<kAxes>().transpose() * components;
  return vector;
}

template <int D>
std::vector<TouchForce> Stepper<D>::touchForces(const Poses& poses) const {
  std::vector<TouchForce> forces;
  for (const auto* rows : {&kept_.contacts, &kept_.supports, &kept_.friction}) {
    for (Row row : *rows) {
      placeRow(row, poses);
      const auto& [a, b] = std::tie(row.contact.brickA, row.contact.brickB);
      const bool onA = brick::isBrick(a);
      TouchForce touch = {onA ? a : b, onA ? b : a, brick::contactPoints(row.contact, poses).onA,
                          inSpace(row, row.slipMultiplier / kept_.step), 0};
      // Bricks of a planar scene touch along their thickness.
      if (D == 3 && brick::isBrick(a) && brick::isBrick(b)) touch.point.z() = poses[a].position.z();
      if (row.hasNormal) {
        constexpr int kAxes = D == 6 ? 3 : 2;
        const auto& normal = onA ? row.normalA : row.normalB;
        touch.push = row.multiplier / kept_.step;
        touch.force.template head<kAxes>() +=
            touch.push * normal.template head<kAxes>().transpose();
      }
      forces.push_back(touch);
    }
  }
  return forces;
}

/// Adds the momentum and the work of the loads in a step with the program's velocities.
template <int D>
void Stepper<D>::addGain(const Poses& poses, double step, LoadGain& given) const {
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const typename Space::Vector velocity = program_.x.template segment<D>(D * i);
    const typename Space::Block resistance =
        Space::restrict(loads_[i].damping) + step * Space::restrict(loads_[i].stiffness);
    const typename Space::Vector push =
        step * (Space::restrict(loads_[i].force) - resistance * velocity);
    const Velocity impulse = Space::unpack(push);
    given.momentum.linear += impulse.linear;
    given.momentum.angular += poses[i].position.cross(impulse.linear) + impulse.angular;
    given.work += velocity.dot(push);
  }
  given.work -= system_.dampedBySprings(step, program_.x) + report_.impacted;
}

// Contacts that were held already keep their impulses.
template <int D>
void Stepper<D>::holdContacts(const std::vector<brick::Contact>& contacts) {
  std::vector<Row> held;
  for (const brick::Contact& contact : contacts) {
    const auto known = std::ranges::find_if(kept_.contacts,
                                            [&](const Row& row) { return row.contact == contact; });
    Row row = known == kept_.contacts.end() ? Row{} : *known;
    row.contact = contact;
    held.push_back(std::move(row));
  }
  kept_.contacts = std::move(held);
}

template <int D>
std::vector<brick::Contact> Stepper<D>::heldContacts() const {
  std::vector<brick::Contact> contacts;
  for (const Row& row : kept_.contacts) contacts.push_back(row.contact);
  return contacts;
}

template <int D>
std::vector<brick::Contact> Stepper<D>::pushingContacts() const {
  std::vector<brick::Contact> contacts;
  for (const Row& row : kept_.contacts) {
    if (row.multiplier > 0) contacts.push_back(row.contact);
  }
  return contacts;
}

/// Adds the rows of the held contacts. They start with the impulses of the last step.
template <int D>
void Stepper<D>::placeHeldRows(const Poses& poses, double step) {
  program_.contacts.clear();
  program_.settlesSlowContacts = true;
  addSupports(poses, step);
  for (Row row : kept_.contacts) {
    placeRow(row, poses);
    holdPinned(row);
    row.bias = 0;
    row.multiplier *= step / kept_.step;
    row.active = row.multiplier > 0;
    program_.contacts.push_back(std::move(row));
  }
  // Friction rows are in the order of the planes.
  auto plane = kept_.contacts.begin();
  double push = 0;
  for (auto old = kept_.friction.begin(); old != kept_.friction.end(); ++old) {
    if (old == kept_.friction.begin() || !onOnePlane(old->contact, std::prev(old)->contact)) {
      push = 0;
      const auto isOfPlane = [&](const Row& row) { return onOnePlane(row.contact, old->contact); };
      plane = std::find_if(plane, kept_.contacts.end(), isOfPlane);
      for (; plane != kept_.contacts.end() && isOfPlane(*plane); ++plane) push += plane->multiplier;
    }
    if (!(push > 0)) continue;
    Row row = *old;
    placeRow(row, poses);
    holdPinned(row);
    row.slipMultiplier *= step / kept_.step;
    row.slipBound = row.contact.friction * row.slipShare * push * step / kept_.step;
    program_.contacts.push_back(std::move(row));
  }
}

template <int D>
void Stepper<D>::keepHeldRows(double step) {
  kept_.step = step;
  kept_.contacts.clear();
  kept_.supports.clear();
  kept_.friction.clear();
  for (const Row& row : program_.contacts) {
    (row.hasNormal       ? kept_.contacts
     : row.slipShare > 0 ? kept_.friction
                         : kept_.supports)
        .push_back(row);
  }
}

namespace {

/// Calls visit(number, unit) for each number of rows that heldForces() has: the number is in units
/// of `unit`.
template <typename Rows, typename Visit>
void visitHeldForces(Rows& kept, const Visit& visit) {
  for (auto* rows : {&kept.contacts, &kept.supports, &kept.friction}) {
    for (auto& row : *rows) {
      visit(row.multiplier, kept.step);
      for (auto& impulse : row.slipMultiplier) visit(impulse, kept.step);
      if (row.slipShare == 0) continue;
      for (auto& place : row.contact.pointA) visit(place, 1.0);
    }
  }
}

}  // namespace

template <int D>
std::vector<double> Stepper<D>::heldForces() const {
  std::vector<double> forces;
  visitHeldForces(kept_, [&](double number, double unit) { forces.push_back(number / unit); });
  return forces;
}

template <int D>
void Stepper<D>::setHeldForces(const std::vector<double>& forces) {
  auto next = forces.begin();
  visitHeldForces(kept_, [&](double& number, double unit) { number = unit * *next++; });
  for (Row& row : kept_.contacts) row.multiplier = std::max(0.0, row.multiplier);
}

/// The velocities of a motion in the coordinates of the solver. Pinned bricks are at rest.
template <int D>
Eigen::VectorXd Stepper<D>::packed(const Motion& motion) const {
  Vector velocities(D * bricks_.size());
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    velocities.segment<D>(D * i) = Space::pack(pinned_[i] ? Velocity{} : motion.velocities[i]);
  }
  return velocities;
}

/// Whether a point of friction sticks in the last step.
template <int D>
bool Stepper<D>::sticks(const Row& row) {
  return row.slipMultiplier.norm() < (1 - kBoundTolerance) * row.slipBound;
}

/// The slip velocity of a point of friction at these poses, world axes, m/s.
template <int D>
Vector3 Stepper<D>::slipOf(Row row, const Poses& poses, const Vector& velocities) const {
  placeRow(row, poses);
  return inSpace(row, row.slipVelocity(velocities));
}

template <int D>
double Stepper<D>::stickSlipSpeed(const Motion& start) const {
  const Vector velocities = packed(start);
  double fastest = 0;
  for (const std::vector<Row>* rows : {&kept_.friction, &kept_.supports}) {
    for (const Row& row : *rows) {
      if (sticks(row)) fastest = std::max(fastest, slipOf(row, start.poses, velocities).norm());
    }
  }
  return fastest;
}

template <int D>
double Stepper<D>::timeOfReversal(const Motion& start, const Motion& end, double slow) const {
  const Vector before = packed(start), after = packed(end);
  double first = std::numeric_limits<double>::infinity();
  for (const std::vector<Row>* rows : {&kept_.friction, &kept_.supports}) {
    for (const Row& row : *rows) {
      if (sticks(row)) continue;
      const Vector3 slip = slipOf(row, start.poses, before);
      const Vector3 fall = slip - slipOf(row, end.poses, after);
      if (slip.norm() <= slow || !(slip.dot(fall) > 0)) continue;
      const double time = slip.dot(fall) / fall.squaredNorm();
      if ((slip - time * fall).norm() <= slow) first = std::min(first, time);
    }
  }
  return first;
}

/// Finds velocities with friction bounds that follow from the normal impulses of this step instead
/// of the last one. One additional round of multipliers makes impulses as accurate as speeds.
template <int D>
bool Stepper<D>::solveWithFriction(const Poses& start) {
  const std::vector<FrictionPlane> planes = frictionPlanes(start, true);
  for (int round = 0; round < kFrictionRounds; ++round) {
    if (!solveVelocities(start)) return false;
    if (program_.contacts.empty()) return true;
    if (!solveRound(system_, program_, kSlow * settings_.lengthScale).found) return false;
    if (!boundFriction(planes, start)) return true;
  }
  return true;
}

/// Sets points and bounds of friction from the normal impulses. Returns whether any changed.
/// Friction rows are the last ones.
template <int D>
bool Stepper<D>::boundFriction(const std::vector<FrictionPlane>& planes, const Poses& poses) {
  std::vector<Row>& rows = program_.contacts;
  const auto hasFriction = [](const Row& row) { return row.slipShare > 0; };
  const std::span<Row> before(std::ranges::find_if(rows, hasFriction), rows.end());
  std::vector<Row> now;
  now.reserve(before.size());
  for (const FrictionPlane& plane : planes) appendFriction(plane, poses, now);
  bool changed = before.size() != now.size();
  for (std::size_t r = 0; r < now.size() && r < before.size(); ++r) {
    const Row& old = before[r];
    Row& row = now[r];
    if (!onOnePlane(old.contact, row.contact)) changed = true;
    const double off = (old.contact.pointA - row.contact.pointA).norm();
    changed = changed || off > kBoundTolerance * settings_.lengthScale ||
              std::abs(row.slipBound - old.slipBound) > kBoundTolerance * row.slipBound;
    row.slipMultiplier = old.slipMultiplier;
    row.slipStiffness = old.slipStiffness;
  }
  rows.resize(rows.size() - before.size());
  rows.insert(rows.end(), now.begin(), now.end());
  return changed;
}

template <int D>
StepReport Stepper<D>::eulerStep(Motion& motion, double step, const LoadSource& loads,
                                 LoadGain& given) {
  const int before = system_.factorizations();
  const double workBefore = system_.work();
  loads(motion.poses, loads_);
  // Multipliers are impulses, proportional to the length of the step.
  program_.multipliers *= step / multiplierStep_;
  multiplierStep_ = step;
  beginStep(motion, step);
  if (system_.hasPairBlocks()) {
    const Vector rest = Vector::Zero(program_.x.size());
    system_.setPairBlocksAbout(rest, PairBlocks<D>::Curvature::Whole);
    program_.force = system_.force();
  }
  startSpeed_ = program_.x;
  placeHeldRows(motion.poses, step);
  report_ = {.steps = 1};
  if (!solveWithFriction(motion.poses) || shareWithWork(kWorkTolerance) < 1)
    report_.unconverged = 1;
  keepHeldRows(step);
  countLosses(step, true);
  addGain(motion.poses, step, given);
  end_.poses = motion.poses;
  displace(step * program_.x);
  finishStep(motion);
  report_.factorizations = system_.factorizations() - before;
  report_.work = system_.work() - workBefore;
  return report_;
}

template <int D>
double Stepper<D>::energyOfMotion(const Motion& motion) const {
  return system_.kineticEnergy(motion.poses, packed(motion));
}

template <int D>
double Stepper<D>::energy(const Motion& motion) const {
  double sum = energyOfMotion(motion);
  for (const std::shared_ptr<const brick::PairForce>& force : settings_.pairForces) {
    sum += force->energy(motion.poses);
  }
  return sum;
}

template <int D>
void Stepper<D>::transfer(StateTape& tape) {
  tape.transfer(jointStiffness_, pinned_, program_.multipliers, multiplierStep_, kept_.contacts,
                kept_.supports, kept_.friction, kept_.step, standstill_, system_);
  program_.exactJoints = !std::isfinite(jointStiffness_);
  system_.setPinned(pinned_);
}

std::unique_ptr<JointSolver> makeJointSolver(const std::vector<brick::Brick>& bricks,
                                             std::span<const brick::Pivot> pivots,
                                             const JointSolverSettings& settings) {
  // Forces that replace joints exist only in the plane.
  assert(settings.planar || !settings.pairForces.replaceJoints());
  if (settings.planar) return std::make_unique<Stepper<3>>(bricks, pivots, settings);
  return std::make_unique<Stepper<6>>(bricks, pivots, settings);
}

// ------------------------------------------------------------------------------------------------
// Skipped steps of jammed bricks. The result of a step without motion depends on its initial
// motion, loads and length. If all three are the same to the last bit, so is the result, and the
// step is skipped. It ended at rest, so a step with an initial speed is never skipped. Halving is
// expensive (2^8 parts). After a failure it is allowed only in every tenth step.

namespace {

constexpr int kPatience = 10;  // consecutive steps without motion before halving is tried again

// Compares exactly: any difference is a change.
bool areEqual(const Pose& a, const Pose& b) {
  return a.position == b.position && a.rotation.coeffs() == b.rotation.coeffs();
}

bool areEqual(const brick::Load& a, const brick::Load& b) {
  return a.force == b.force && a.stiffness == b.stiffness && a.damping == b.damping;
}

template <typename Value>
bool areEqual(const std::vector<Value>& a, const std::vector<Value>& b) {
  return std::ranges::equal(a, b, [](const Value& x, const Value& y) { return areEqual(x, y); });
}

bool areAtRest(const std::vector<Velocity>& velocities) {
  return std::ranges::all_of(velocities, [](const Velocity& velocity) {
    return velocity.linear.isZero(0) && velocity.angular.isZero(0);
  });
}

}  // namespace

// Returns whether to try the step of `seconds` from this motion with these loads.
bool Standstill::beginStep(const Motion& motion, const std::vector<brick::Load>& loads,
                           double seconds) {
  const bool mayHalve = steps_ % kPatience == 0;
  // With the same inputs the step has no motion again, unless halving is allowed now and was not
  // then.
  if (isWhole() && isAsBefore(motion, loads, seconds) && (halved_ || !mayHalve)) {
    ++steps_;
    return false;
  }
  mayHalve_ = mayHalve;
  seconds_ = seconds;
  stood_ = false;
  moved_ = false;
  return true;
}

// Stores the outcome. Poses and loads are stored only if no brick moved, since other steps are
// never skipped.
void Standstill::endStep(const Poses& poses, const std::vector<brick::Load>& loads) {
  steps_ = stood_ ? steps_ + 1 : 0;
  halved_ = mayHalve_;
  poses_.clear();
  loads_.clear();
  if (moved_) return;
  poses_ = poses;
  loads_ = loads;
}

// Cheap comparisons are first.
bool Standstill::isAsBefore(const Motion& motion, const std::vector<brick::Load>& loads,
                            double seconds) const {
  return seconds == seconds_ && areAtRest(motion.velocities) && areEqual(motion.poses, poses_) &&
         areEqual(loads, loads_);
}

void Standstill::transfer(StateTape& tape) {
  tape.transfer(poses_, loads_, seconds_, halved_, steps_);
}

// ------------------------------------------------------------------------------------------------
// Closing joints by Gauss-Newton steps on the gaps, from the end of a step or from any open state.
// The metric is that of the step (whose factor is available) or that of the masses. The energy of
// closing is taken from the kinetic energy.

namespace {

// Lengths are in length scales.
constexpr double kGapTolerance = 1e-12;     // requested gap of closing
constexpr double kGapAccepted = 1e-10;      // largest gap of a good step
constexpr double kOverlapTolerance = 1e-9;  // smaller overlaps of contacts are not corrected
constexpr double kJumpShare = 0.3;          // most displacement of closing, times that of the step
constexpr double kJumpFloor = 1e-9;
constexpr double kBend = 0.01;        // below this fraction closing only follows a curved path
constexpr double kForeseeable = 0.1;  // largest ratio of closing moves for extrapolation
// A factor is used again for the next move if gaps are small and the move reduced them by
// kFactorKept. With wide gaps, old factors would make the total displacement longer.
constexpr double kSmallGap = 1e-2;
constexpr double kFactorKept = 0.03;
constexpr int kClosingRounds = 12;
constexpr int kOverlapRounds = 3;
constexpr int kAssemblyRounds = 100;

}  // namespace

/// Moves to the step's end and closes the joints there. Pushing contacts keep their gaps. If this
/// fails, as in compact states, it closes the joints without contacts. Returns whether the joints
/// closed without changing to another branch.
template <int D>
bool Stepper<D>::moveAndClose(const Poses& start, double step) {
  end_.poses = start;
  displace(step * program_.x);
  if (!program_.exactJoints) return true;
  if (closeJoints(program_.contacts, step)) return true;
  if (program_.contacts.empty()) return false;
  end_.poses = start;
  displace(step * program_.x);
  system_.placeJoints(start);
  return system_.factor({}) && closeJoints({}, step);
}

/// Limits the energy at the end of a step, including closing, to the energy at its start. The
/// excess is taken from the bricks' speed. If the speed does not suffice, the bricks do not move.
/// On a smooth path closing does no net work, and the speed is unchanged. If closing jumps among
/// bricks that may touch, the state is singular: some velocities that the joints allow do not begin
/// a motion. The displacement of closing then counts as part of the velocity.
template <int D>
void Stepper<D>::limitEnergyAfterClosing(const Poses& start, double step) {
  const bool isSingular = contactSource_ && end_.jumped;
  if ((program_.contacts.empty() && !isSingular) || !program_.exactJoints) return;
  const Vector move = step * program_.x;
  if (norm(end_.closing) <= kBend * norm(move)) return;
  const double before = system_.kineticEnergy(start, startSpeed_);
  const double work = system_.workAgainst(loads_, Vector::Zero(move.size()), move) +
                      system_.workAgainst(loads_, move, end_.closing);
  if (isSingular) program_.x += end_.closing / step;
  const double after = system_.kineticEnergy(start, program_.x);
  const double excess = after + work - before;
  if (excess <= 0) return;
  program_.x *= std::sqrt(std::max(0.0, 1 - excess / after));
  if (excess > after) standStill(start);
}

/// The end of a step without motion, which joints and contacts always allow.
template <int D>
void Stepper<D>::standStill(const Poses& start) {
  end_.poses = start;
  program_.x.setZero();
}

/// The pairs of bricks that joints, forces or contacts of the current step connect.
template <int D>
std::vector<std::pair<int, int>> Stepper<D>::pairsThatHold() const {
  std::vector<std::pair<int, int>> pairs;
  for (const brick::Pivot& pivot : system_.pivots()) pairs.emplace_back(pivot.brickA, pivot.brickB);
  for (const std::shared_ptr<const brick::PairForce>& force : settings_.pairForces) {
    for (std::size_t pair = 0; pair < force->size(); ++pair) pairs.push_back(force->bricks(pair));
  }
  for (const Row& row : program_.contacts) {
    if (!brick::isBrick(row.contact.brickA) || !brick::isBrick(row.contact.brickB)) continue;
    pairs.emplace_back(row.contact.brickA, row.contact.brickB);
  }
  return pairs;
}

/// Makes a step in which connected bricks move as one rigid piece, which joints and contacts always
/// allow. Relative velocities within a piece are lost, as in a plastic impact. Returns false and
/// changes nothing if all pieces are pinned, if none moves, or if each brick is a piece.
template <int D>
bool Stepper<D>::moveAsPieces(Motion& motion, double step, const LoadSource& loads) {
  const RigidPieces pieces(bricks_, motion.poses, pairsThatHold());
  if (pieces.bodies().size() == bricks_.size()) return false;
  std::vector<bool> pinned(pieces.bodies().size(), false);
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    if (pinned_[i]) pinned[pieces.pieceOf(static_cast<int>(i))] = true;
  }
  if (std::ranges::find(pinned, false) == pinned.end()) return false;
  JointSolverSettings settings = {.planar = D == 3,
                                  .lengthScale = settings_.lengthScale,
                                  .isHalving = settings_.isHalving && standstill_.mayHalve()};
  for (Support support : settings_.supports) {
    support.point = pieces.placeInPiece(support.brick).apply(support.point);
    support.brick = pieces.pieceOf(support.brick);
    settings.supports.push_back(support);
  }
  Stepper<D> solver(pieces.bodies(), {}, settings);
  solver.setPinned(pinned);
  PieceContacts contacts(pieces, *contactSource_);
  const LoadSource onPieces = [&](const Poses& poses, std::vector<brick::Load>& out) {
    loads(pieces.posesOfBricks(poses), loads_);
    out = pieces.loadsOnPieces(poses, loads_);
  };
  Motion whole = pieces.motionOf(motion, D == 3);
  const Motion before = pieces.motionOfBricks(whole);
  const double lost = energyOfMotion(motion) - energyOfMotion(before);
  StepReport report = solver.advance(whole, step, onPieces, &contacts);
  Vector move(D * whole.velocities.size());
  for (std::size_t p = 0; p < whole.velocities.size(); ++p) {
    move.segment<D>(D * p) = step * Space::pack(whole.velocities[p]);
  }
  if (move.lpNorm<Eigen::Infinity>() <= kGapTolerance * settings_.lengthScale) return false;
  report.steps = report.unconverged = 0;  // this step is counted already
  report.impacted += lost;
  report_ += report;
  motion = pieces.motionOfBricks(whole);
  return true;
}

/// Gauss-Newton on the joints' gaps with the current factor: the smallest displacement in the
/// metric A for which pushing contacts keep their gaps. The first rounds also correct overlaps.
/// Since the factor is that of the step's start, moves decrease by a constant ratio, and the
/// remaining ones are extrapolated (Broyden's good update with a memory of one: Kelley 2003,
/// "Solving Nonlinear Equations with Newton's Method", 4.2).
template <int D>
bool Stepper<D>::closeJoints(const std::vector<Row>& contacts, double step) {
  const double scale = settings_.lengthScale;
  const double allowed = kJumpShare * step * norm(program_.x) + kJumpFloor * scale;
  double moved = 0;
  Vector gaps = system_.jointGaps(end_.poses);
  double gap = system_.largestOfPivots(gaps);
  bool refactored = false, isLast = false;
  end_.closing = Vector::Zero(program_.x.size());
  Vector lastMove = end_.closing;
  for (int round = 0; round < kClosingRounds && (moved <= allowed || isShortest_); ++round) {
    const bool overlapping = round < kOverlapRounds && anyOverlap(contacts);
    if (gap <= kGapTolerance * scale && !overlapping) {
      if (!settings_.isFine || isLast || round == 0) break;
      isLast = true;
    }
    const auto aim = [&](const Row& row) { return overlapping ? overlap(row) : 0; };
    const Vector move = extrapolated(closingMove(gaps, contacts, aim), lastMove);
    lastMove = move;
    end_.closing += move;
    displace(move);
    moved += norm(move);
    const double before = gap;
    gaps = system_.jointGaps(end_.poses);
    gap = system_.largestOfPivots(gaps);
    if (!std::isfinite(gap)) return false;
    if (gap <= std::max(0.2 * before, kGapTolerance * scale) || overlapping) continue;
    if (gap <= 0.1 * kGapAccepted * scale && refactored) break;
    system_.placeJoints(end_.poses);
    if (!system_.factor(contacts)) return false;
    refactored = true;
    lastMove.setZero();
  }
  end_.jumped = moved > allowed;
  return gap <= kGapAccepted * scale && (!end_.jumped || isShortest_);
}

/// The smallest displacement in the metric A that closes these gaps and moves the bricks of active
/// contacts apart by these distances. The weight of joints in the factor leaves an error of 1e-6 of
/// the gaps along the mechanism. A fine solver removes it by a second solution.
template <int D>
Eigen::VectorXd Stepper<D>::closingMove(const Vector& gaps, const std::vector<Row>& contacts,
                                        const std::function<double(const Row&)>& aim) const {
  Vector move = Vector::Zero(program_.x.size());
  for (int solution = 0; solution < (settings_.isFine ? 2 : 1); ++solution) {
    Vector rest = -system_.timesA(move);
    system_.addJointImpulse(-system_.kappa(), gaps + system_.jointVelocity(move), rest);
    for (const Row& row : contacts) {
      if (row.active) row.addNormal(system_.rho() * (aim(row) - row.normalVelocity(move)), rest);
      if (!row.hasFriction()) continue;
      row.addTangent(-system_.rho() * (row.slipStiffness * row.slipVelocity(move)), rest);
    }
    system_.solveInPlace(rest);
    move += rest;
  }
  return move;
}

/// The sum of this move and of all later ones, if they decrease by the ratio of the last two.
template <int D>
Eigen::VectorXd Stepper<D>::extrapolated(const Vector& move, const Vector& lastMove) const {
  const double square = product(lastMove, lastMove);
  const double ratio = square > 0 ? product(move, lastMove) / square : 0;
  return std::abs(ratio) < kForeseeable ? Vector(move / (1 - ratio)) : move;
}

/// The requested gap of a contact minus its gap, metres, >= 0.
template <int D>
double Stepper<D>::overlap(const Row& row) const {
  return std::max(0.0, row.aim - brick::contactGap(row.contact, end_.poses));
}

template <int D>
bool Stepper<D>::anyOverlap(const std::vector<Row>& contacts) const {
  return std::any_of(contacts.begin(), contacts.end(), [&](const Row& row) {
    return row.active && overlap(row) > kOverlapTolerance * settings_.lengthScale;
  });
}

/// Scalar product of two moves of all bricks, m^2. Rotations count as displacements at a distance
/// of one length scale from the centre.
template <int D>
double Stepper<D>::product(const Vector& a, const Vector& b) const {
  double sum = 0;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const Velocity partOfA = Space::unpack(a.segment<D>(D * i));
    const Velocity partOfB = Space::unpack(b.segment<D>(D * i));
    sum += partOfA.linear.dot(partOfB.linear) +
           settings_.lengthScale * settings_.lengthScale * partOfA.angular.dot(partOfB.angular);
  }
  return sum;
}

template <int D>
double Stepper<D>::norm(const Vector& move) const {
  return std::sqrt(product(move, move));
}

/// Projects the velocities, in the metric of the masses, onto those that joints and held contacts
/// allow.
template <int D>
bool Stepper<D>::projectVelocities(Motion& motion, bool withFriction) {
  const Vector warm = program_.multipliers;
  system_.setMasses(motion.poses);
  program_.x = packed(motion);
  program_.force = system_.timesA(program_.x);
  program_.multipliers.setZero();
  program_.contacts.clear();
  program_.settlesSlowContacts = true;
  for (Row row : kept_.contacts) {
    placeRow(row, motion.poses);
    holdPinned(row);
    row.bias = row.multiplier = 0;
    row.active = row.trialImpulse(program_.x, system_.rho()) > 0;
    program_.contacts.push_back(std::move(row));
  }
  const bool found = withFriction ? solveWithFriction(motion.poses) : solveVelocities(motion.poses);
  program_.multipliers = warm;
  if (!found || shareWithWork(kWorkTolerance) < 1) return false;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    motion.velocities[i] = Space::unpack(program_.x.template segment<D>(D * i));
  }
  return true;
}

/// Whether joints, pins and held contacts allow the velocities.
template <int D>
bool Stepper<D>::allowsVelocities(const Motion& motion) {
  const Vector x = packed(motion);
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    if (x.segment<D>(D * i) != Space::pack(motion.velocities[i])) return false;
  }
  system_.placeJoints(motion.poses);
  const double allowed =
      kSpeedTolerance * std::max(system_.largestSpeed(x), kSlow * settings_.lengthScale);
  return system_.largestOfPivots(system_.jointVelocity(x)) <= allowed &&
         std::ranges::all_of(kept_.contacts, [&](Row row) {
           placeRow(row, motion.poses);
           return row.normalVelocity(x) >= -allowed;
         });
}

template <int D>
bool Stepper<D>::collide(Motion& motion) {
  return allowsVelocities(motion) || projectVelocities(motion, true);
}

template <int D>
double Stepper<D>::project(Motion& motion) {
  std::vector<Row> pushing;
  for (const Row& row : kept_.contacts) {
    if (row.multiplier > 0) pushing.push_back(row);
  }
  const double gap = closeGaps(motion.poses, std::move(pushing));
  if (!system_.hasJoints() && kept_.contacts.empty()) return gap;
  return projectVelocities(motion, false) ? gap : std::numeric_limits<double>::infinity();
}

template <int D>
double Stepper<D>::assemble(Poses& poses) {
  return closeGaps(poses, {});
}

/// The largest of the given joint gaps and of the gaps of these contacts, metres.
template <int D>
double Stepper<D>::largestGap(const Vector& gaps, const std::vector<Row>& held) const {
  double largest = system_.largestOfPivots(gaps);
  for (const Row& row : held) {
    largest = std::max(largest, std::abs(brick::contactGap(row.contact, end_.poses)));
  }
  return largest;
}

/// Factors the masses with the joints and these contacts at the current poses.
template <int D>
bool Stepper<D>::factorMasses(std::vector<Row>& held) {
  system_.setMasses(end_.poses);
  system_.placeJoints(end_.poses);
  for (Row& row : held) {
    placeRow(row, end_.poses);
    holdPinned(row);
    row.active = true;
    row.slipBound = 0;
  }
  return system_.factor(held);
}

/// Closes the joints and the gaps of these contacts by the smallest displacement in the metric of
/// the masses. Returns the largest remaining gap, metres.
template <int D>
double Stepper<D>::closeGaps(Poses& poses, std::vector<Row> held) {
  const double scale = settings_.lengthScale;
  end_.poses = poses;
  Vector gaps = system_.jointGaps(end_.poses);
  double gap = largestGap(gaps, held);
  bool isCurrent = false, isLast = false;
  const auto aim = [&](const Row& row) { return -brick::contactGap(row.contact, end_.poses); };
  for (int round = 0; round < kAssemblyRounds; ++round) {
    if (gap <= kGapTolerance * scale) {
      if (!settings_.isFine || isLast || round == 0) break;
      isLast = true;
    }
    if (!isCurrent && !factorMasses(held)) break;
    displace(closingMove(gaps, held, aim));
    const double before = gap;
    gaps = system_.jointGaps(end_.poses);
    gap = largestGap(gaps, held);
    isCurrent = before <= kSmallGap * scale && gap < kFactorKept * before;
    if (gap > 0.9 * before && gap < kGapAccepted * scale) break;
  }
  poses = end_.poses;
  return gap;
}

template class Stepper<3>;
template class Stepper<6>;

}  // namespace kirireel::mechanics
