// Improvement of a path as a whole.
//
// The states q_0 ... q_n of a path, with fixed ends, minimise the energy
//   E = sum over i of |z_(i-1) - 2 z_i + z_(i+1)|^2 + a sum over i of C(c(q_i))
// with closed joints c(q_i) = 0 and gaps of near bricks phi(q_i) >= 0. z stacks the position x and
// the rotation matrix rho R / sqrt 2 of each brick, with its radius of gyration rho: a rotation
// counts by its arc. The second term is the price a of joints that are open on the found path, with
// the cost C of their openings (joint_openings.h).
//
// If joints count as open and the budget allows, all of them may open, without c = 0. The exponent
// p of C increases step by step: the largest opening of any joint becomes nearly as small as it can
// be. A step is one of Newton's method for all states at once (openingStep). Overlaps have a price
// there, phi^2.
//
// Otherwise joints open in the leading modes of the found path only, the first singular vectors of
// its openings over the states, and C = |c|^2. One round, as for closed joints:
// 1. B_i is an orthonormal basis of the moves of state i that keep its joints closed: the null
//    space of their Jacobian J in the metric |dx|^2 + rho^2 |dphi|^2. It is computed at one state
//    by QR and projected to its neighbours. Columns that open the joints in the modes follow.
// 2. With q_i moved by B_i y_i, the energy is quadratic and the gaps are linear in y. This is a
//    banded quadratic program, because second differences couple three states (banded_program.h).
//    Gaps may be violated at a price, because bricks that are jammed have no solution.
// 3. The states move, and Newton steps close their joints. Bricks that then overlap are pushed
//    apart by the same program, each state by itself.
// 4. The round is accepted if E falls and overlaps stay small. If not, it is tried again with more
//    damping (Levenberg, Marquardt).
//
// The states are then interpolated by cubics at constant speed, closed and pushed apart again.
// Parts that this leaves rough are improved again, with the states of the result. Where bricks
// overlap between two states, others are inserted between them.
//
// J. Nocedal, S. J. Wright, Numerical Optimization, 2nd edition, 2006, chapter 18 (sequential
// quadratic programming). N. Ratliff et al., CHOMP: gradient optimization techniques for efficient
// motion planning, ICRA 2009, minimises such an energy of robots' paths.
#include "sim/path/smoothing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "sim/path/banded_program.h"
#include "sim/path/joint_openings.h"
#include "sim/path/near_gaps.h"
#include "sim/run/assembled_state.h"
#include "sim/run/mechanism_path.h"
#include "sim/run/path_evaluation.h"
#include "sim/run/state_interpolator.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/measures.h"

namespace kirireel::path {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Lengths are fractions of a tile. Larger sheets are not improved: the null space by QR is
// O(bricks^3), and all pairs are listed.
constexpr std::size_t kMaxBricks = 250;
constexpr int kIntervals = 60;          // between the states that are improved
constexpr int kOpenIntervals = 24;      // the same if all joints may open
constexpr double kFinalSpacing = 0.02;  // spacing of the states of the result
constexpr double kMinFinal = 120;       // minimum number of intervals of the result
constexpr double kMaxFinal = 400;
// States are inserted down to this spacing, as a fraction of the path. Bricks that still overlap
// there are on different sides of a corner: states down to the second spacing lead around it.
constexpr double kMinSpacing = 1e-5;
constexpr double kMinSpacingAtCorners = 1e-6;
constexpr int kSmoothingRounds = 12;   // maximum number of accepted rounds
constexpr int kSmoothingTries = 24;    // maximum number of tried rounds
constexpr double kMinRoundGain = 0.1;  // of the energy; a smaller gain ends the rounds
// A path is smooth enough if no brick's step changes by more than this fraction of the typical
// step.
constexpr double kSmoothEnough = 0.05;
// Parts of the result with larger changes are improved again.
constexpr double kRough = 0.25;
constexpr std::size_t kRoughMargin = 10;  // states on both sides of a rough part of the result
constexpr int kModes = 24;                // maximum number of modes of openings
constexpr double kWaves = 16;             // an opening costs as much as a wave of equal size
constexpr double kOpenWaves = 8;          // the same if all joints may open
// If all joints may open: the exponents of their cost, one after the other, and what a sum of
// squares adds to it. Without this, joints far below the largest opening would have no cost.
constexpr std::array kExponents = {4.0, 8.0, 16.0, 32.0};
constexpr double kShareOfSquares = 0.01;
constexpr int kOpeningSteps = 4;              // Newton steps per exponent
constexpr double kMinOpeningGain = 1e-3;      // of the energy; a smaller gain ends them
constexpr double kPriceOfOverlap = 1e4;       // over that of a second difference
constexpr int kOverlapSteps = 4;              // to find which gaps have this price
constexpr double kMargin = 0.1;               // of gaps in the program
constexpr double kPushMargin = 0.03;          // the same while bricks are pushed apart
constexpr double kPointReach = 1e-2;          // of the points of a pair
constexpr double kOverlap = 1e-5;             // overlap that is ignored
constexpr double kFinalOverlap = 1e-5;        // the same in the result
constexpr double kMaxOverlap = 4 * kOverlap;  // limit for an accepted round
constexpr double kLongestRoundMove = 0.15;    // of a brick in a round
constexpr int kPushes = 8;
constexpr double kNoPushGain = 0.98;     // fraction of an overlap that is left by pushes that end
constexpr double kPriceOfPushing = 1e3;  // price of opening joints over that of moving
constexpr double kFirstDamping = 6e-5;
constexpr double kMinDamping = 6e-9;
constexpr double kMaxDamping = 600;
constexpr double kClosedByNewton =
    1e-11;  // tolerance of an open joint, to which Newton steps close states
constexpr double kNewtonEnd = 1e-13;
constexpr int kNewtonSteps = 20;
constexpr double kSlowNewton = 0.1;    // fraction of a gap
constexpr double kNoNewtonGain = 0.5;  // the same for steps that end
constexpr double kOpenOnPath =
    1e-9;                           // joints that are open by more on the found path are compliant
constexpr double kSingular = 1e-5;  // a singular value of the joints' Jacobian that counts as 0
// Columns are made orthonormal by the Cholesky factor of their products if the reciprocal of its
// condition is larger.
constexpr double kWellConditioned = 1e-3;
constexpr double kRegular = 1e-12;     // added to J J', which redundant joints make singular
constexpr double kClosedMove = 1e-10;  // change of a gap by moves of length 1 that keep it closed
// The budget must allow this many factorisations: about eight rounds.
constexpr double kMinFactorisations = 100;
// If all joints may open, a program has this many freedoms per state at most, and the budget must
// allow all steps for all exponents.
constexpr int kMaxFreedoms = 250;
constexpr double kMinOpeningFactorisations = kExponents.size() * kOpeningSteps;

/// Moves of smallest length that change the gaps of joints by given amounts at one state. The
/// structure of J J' is the same at all states, so it is analysed once.
class LeastMoves {
 public:
  /// Keeps a reference to the joints.
  explicit LeastMoves(const JointOpenings& joints) : joints_(joints) {
    regular_.resize(joints.rows(), joints.rows());
    regular_.setIdentity();
    regular_ *= kRegular;
  }

  /// Sets the state.
  void setState(const Poses& poses) {
    jacobian_ = joints_.jacobian(poses);
    const SparseMatrix square = SparseMatrix(jacobian_ * jacobian_.transpose()) + regular_;
    if (!isAnalysed_) factor_.analyzePattern(square);
    isAnalysed_ = true;
    factor_.factorize(square);
  }

  const SparseMatrix& jacobian() const { return jacobian_; }
  /// Returns one column of moves per column of changes.
  MatrixXd forChanges(const MatrixXd& changes) const {
    return jacobian_.transpose() * MatrixXd(factor_.solve(changes));
  }

 private:
  const JointOpenings& joints_;
  SparseMatrix jacobian_, regular_;
  Eigen::SimplicialLDLT<SparseMatrix> factor_;
  bool isAnalysed_ = false;
};

/// An orthonormal basis of the columns' span, in their order. Columns that are nearly orthonormal
/// cost less.
MatrixXd orthonormal(const MatrixXd& columns) {
  MatrixXd gram = MatrixXd::Zero(columns.cols(), columns.cols());
  gram.selfadjointView<Eigen::Lower>().rankUpdate(columns.transpose());
  const Eigen::LLT<MatrixXd> root(gram);
  if (root.info() == Eigen::Success && root.rcond() > kWellConditioned) {
    return root.matrixL().solve(columns.transpose()).transpose();
  }
  const Eigen::HouseholderQR<MatrixXd> qr(columns);
  return qr.householderQ() * MatrixXd::Identity(columns.rows(), columns.cols());
}

/// The energy of a path to the second order in the moves of its bricks: half its gradient and
/// half its Hessian, without overlaps.
struct NewtonStep {
  struct Gaps {
    SparseMatrix forms;  // changes by the moves
    VectorXd gaps;       // beyond the overlap that is ignored, metres
    VectorXd prices;     // of their squares: zero for bricks that stay apart
  };
  BandedMatrix hessian;
  MatrixXd gradient;
  std::vector<Gaps> near;  // of near bricks, one per state
};

class Smoothing {
 public:
  Smoothing(const scene::Scene& scene, const run::GeometricPath& found,
            scene::ContactFilter contacts, run::SearchBudget& budget,
            const PathObserver& shouldContinue)
      : found_(found),
        budget_(budget),
        shouldContinue_(shouldContinue),
        tile_(model::tileSize(scene.model)),
        isPlanar_(scene::sceneNeeds(scene).planar.on),
        maxOpening_(found.path.isRounded ? run::roundedGap(scene.model) : kClosedByNewton * tile_),
        bricks_(brick::makeBricks(scene.model.tiles, scene.brick)),
        pivots_(brick::makePivots(scene.model.joints, bricks_)),
        joints_(bricks_, pivots_, isPlanar_),
        least_(joints_) {
    if (contacts != scene::ContactFilter::None) {
      gaps_.emplace(bricks_, pivots_, contacts, scene.environment.pivotZone, isPlanar_,
                    found.path.states.front());
    }
    const double cost = kFactorisationCost * kOpenIntervals * std::pow(joints_.columns(), 3);
    allMayOpen_ = found.hasCompliantJoints && !found.path.isRounded &&
                  found.evaluation.opening > run::kAllowedOpening * tile_ &&
                  joints_.columns() <= kMaxFreedoms &&
                  kMinOpeningFactorisations * cost <= budget.left();
    takeStates(scene);
    modes_.resize(joints_.rows(), 0);
    if (allMayOpen_) {
      isOpen_.assign(count(), true);
      free_ = joints_.columns();
      bases_.assign(count(), MatrixXd::Identity(free_, free_));
      hasOwnBasis_.assign(count(), true);
    } else if (std::ranges::any_of(isOpen_, [](bool isOpen) { return isOpen; })) {
      takeModes();
    }
  }

  /// The improved states. Empty if there is no improvement.
  std::vector<Poses> find() {
    if (!prepare()) return {};
    bool isImproved = improve(0, count() - 1);
    const bool isFree = overlap_ <= run::kAllowedOverlap * tile_;
    sampleFinely();
    for (const auto& [first, last] : roughParts()) isImproved = improve(first, last) || isImproved;
    if (!isImproved) return {};
    // Bricks that overlap in many states would need many others between them.
    if (!isFree) return states_;
    return withInsertedStates();
  }

 private:
  // Whether the budget is spent or the caller stops.
  bool isOver() const { return budget_.isSpent() || (shouldContinue_ && !shouldContinue_(1)); }

  std::size_t count() const { return states_.size(); }
  /// The number of states that a round moves.
  std::size_t moving() const { return last_ - first_ - 1; }
  int freedoms() const { return free_ + static_cast<int>(modes_.cols()); }
  /// The work of a factorisation for a number of states.
  double factorisationCost(std::size_t states) const {
    return kFactorisationCost * static_cast<double>(states) * std::pow(freedoms(), 3);
  }

  /// Samples the found path at constant speed.
  void takeStates(const scene::Scene& scene) {
    const int intervals = allMayOpen_ ? kOpenIntervals : kIntervals;
    const run::MechanismPath& path = found_.path;
    run::StatesBetween between(scene, found_);
    states_.push_back(path.states.front());
    for (int k = 1; k < intervals; ++k) {
      const double length = k * path.length() / intervals;
      const auto next = std::upper_bound(path.lengths.begin() + 1, path.lengths.end() - 1, length);
      const auto state = static_cast<std::size_t>(next - path.lengths.begin());
      const double part = path.lengths[state] - path.lengths[state - 1];
      const double share = part > 0 ? (length - path.lengths[state - 1]) / part : 1;
      states_.push_back(between.at(state, share));
    }
    states_.push_back(path.states.back());
    for (const Poses& poses : states_) {
      isOpen_.push_back(found_.hasCompliantJoints && openingOf(poses) > kOpenOnPath * tile_);
    }
  }

  /// The largest opening of a state, metres.
  double openingOf(const Poses& poses) const { return trajectory::jointGap(pivots_, poses).max; }

  /// The left singular vectors of the openings, by the eigenvectors of the smaller Gram matrix.
  void takeModes() {
    MatrixXd openings(joints_.rows(), static_cast<Eigen::Index>(count()));
    for (std::size_t k = 0; k < count(); ++k) {
      openings.col(static_cast<Eigen::Index>(k)) = joints_.openings(states_[k]);
    }
    const SymmetricEigen eigen = eigenOf(openings.transpose() * openings);
    const double largest = eigen.values[eigen.values.size() - 1];
    std::vector<VectorXd> found;
    for (Eigen::Index k = eigen.values.size();
         k-- > 0 && found.size() < kModes && eigen.values[k] > 1e-12 * largest;) {
      found.push_back((openings * eigen.vectors.col(k)).normalized());
    }
    modes_.resize(joints_.rows(), static_cast<Eigen::Index>(found.size()));
    for (std::size_t k = 0; k < found.size(); ++k)
      modes_.col(static_cast<Eigen::Index>(k)) = found[k];
    modes_ = orthonormal(modes_);
  }

  /// Closes a state by Newton steps. Open joints may keep the part of their opening that lies in
  /// the modes. Returns the remaining gap, metres.
  double close(Poses& poses, bool isOpen) {
    VectorXd goal = VectorXd::Zero(joints_.rows());
    if (isOpen) goal = modes_ * (modes_.transpose() * joints_.openings(poses));
    return closeTo(goal, poses);
  }

  /// The same for any openings. A step uses the derivatives of an earlier state while each step
  /// leaves at most the fraction kSlowNewton of the gap. Tiles with a misfit cannot be closed:
  /// there steps end that hardly change the gap. If all joints may open, openings stay as they are.
  double closeTo(const VectorXd& goal, Poses& poses) {
    if (joints_.rows() == 0 || allMayOpen_) return 0;
    double before = std::numeric_limits<double>::infinity();
    bool isOwn = true;  // whether the last step used the derivatives of its own state
    for (int k = 0;; ++k) {
      const VectorXd missing = goal - joints_.openings(poses);
      const double gap = joints_.largest(missing);
      if (gap < kNewtonEnd * tile_ || k == kNewtonSteps) return gap;
      if (isOwn && gap > kNoNewtonGain * before) return gap;
      isOwn = k == 0 || gap > kSlowNewton * before;
      if (isOwn) least_.setState(poses);
      poses = joints_.moved(std::move(poses), least_.forChanges(missing));
      before = gap;
    }
  }

  /// Closes the states between the ends, finds their bases, and pushes bricks apart. Returns
  /// whether the path can be improved.
  bool prepare() {
    if (allMayOpen_) return setScale();
    for (std::size_t i = 1; i + 1 < count(); ++i) close(states_[i], isOpen_[i]);
    std::optional<MatrixXd> least;
    std::size_t from = 0;
    for (const std::size_t i : {count() / 3, count() / 2, 2 * count() / 3}) {
      MatrixXd basis = nullSpace(states_[i]);
      if (least && basis.cols() >= least->cols()) continue;
      least = std::move(basis);
      from = i;
    }
    free_ = static_cast<int>(least->cols());
    const double cost = kMinFactorisations * factorisationCost(count());
    // A single motion has one curve, which cannot be smoother.
    const int rigid = isPlanar_ ? 3 : 6;
    if (freedoms() < 2 + rigid || cost > budget_.left()) return false;
    bases_.assign(count(), *least);
    hasOwnBasis_.assign(count(), true);
    for (std::size_t i = from; i < count(); ++i) {
      bases_[i] = carriedOn(i == from ? *least : bases_[i - 1], states_[i], isOpen_[i]);
    }
    for (std::size_t i = from; i-- > 0;) {
      bases_[i] = carriedOn(bases_[i + 1], states_[i], isOpen_[i]);
    }
    for (std::size_t i = 1; i + 1 < count(); ++i) {
      pushApart(states_[i], bases_[i], isOpen_[i], kOverlap);
      makeSymmetric(states_[i], isOpen_[i]);
    }
    return setScale();
  }

  /// Sets the scale of the energy and the price of openings. Returns whether the path has a length.
  bool setScale() {
    const double length = run::pathLengths(bricks_, states_).back();
    const double mean = length / static_cast<double>(count() - 1);
    scale_ = static_cast<double>(bricks_.size()) * mean * mean;
    const double waves = allMayOpen_ ? kOpenWaves : kWaves;
    price_ = std::pow(2 * std::numbers::pi * waves / static_cast<double>(count() - 1), 4);
    return scale_ > 0;
  }

  /// Improves the states between two that stay. Returns whether a round was accepted.
  bool improve(std::size_t first, std::size_t last) {
    first_ = first;
    last_ = last;
    for (std::size_t i = first + 1; i < last; ++i) {
      if (!hasOwnBasis_[i]) bases_[i] = carriedOn(bases_[i], states_[i], isOpen_[i]);
      hasOwnBasis_[i] = true;
    }
    return allMayOpen_ ? openLess() : smooth();
  }

  /// Rounds of programs. Returns whether one was accepted.
  bool smooth() {
    energy_ = energyOf(states_);
    overlap_ = overlapOf(movedStates());
    int taken = 0;
    double damping = kFirstDamping;
    for (int tries = kSmoothingTries; taken < kSmoothingRounds && !isOver();) {
      const double before = energy_;
      if (!round(damping, tries)) break;
      ++taken;
      if (energy_ <= before && energy_ > (1 - kMinRoundGain) * before) break;
      if (isSmooth() && overlap_ <= kMaxOverlap * tile_) break;
    }
    return taken > 0;
  }

  /// The states that a round moves, and their neighbours, of the improved path.
  std::span<const Poses> movedStates() const {
    return std::span(states_).subspan(first_, last_ - first_ + 1);
  }

  /// Newton steps for joints that may all open. Starts with the last exponent if the others have
  /// had their steps. Returns whether a step was accepted.
  bool openLess() {
    bool isImproved = false;
    for (const double exponent : kExponents) {
      if (exponent < exponent_) continue;
      exponent_ = exponent;
      opening_ = 0;
      for (const Poses& poses : states_) opening_ = std::max(opening_, openingOf(poses));
      energy_ = energyOf(states_);
      double damping = kFirstDamping;
      for (int k = 0; k < kOpeningSteps && !isOver(); ++k) {
        const double before = energy_;
        if (!openingStep(damping)) break;
        isImproved = true;
        if (energy_ > (1 - kMinOpeningGain) * before) break;
      }
    }
    overlap_ = overlapOf(movedStates());
    return isImproved;
  }

  /// One Newton step with damping. Returns whether the energy decreases.
  bool openingStep(double& damping) {
    NewtonStep step = newtonStep();
    for (; damping <= kMaxDamping && !isOver(); damping *= 10) {
      const MatrixXd y = solved(step, damping);
      if (y.size() == 0) continue;
      const std::vector<VectorXd> moves(y.colwise().begin(), y.colwise().end());
      const double part = std::min(1.0, kLongestRoundMove * tile_ / longest(moves));
      std::vector<Poses> tried = states_;
      for (std::size_t k = 0; k < moving(); ++k) {
        Poses& poses = tried[first_ + 1 + k];
        poses = joints_.moved(std::move(poses), part * moves[k]);
        makeSymmetric(poses, true);
      }
      const double energy = energyOf(tried);
      if (!(energy < energy_)) continue;
      states_ = std::move(tried);
      energy_ = energy;
      damping = std::max(damping / 10, kMinDamping);
      return true;
    }
    return false;
  }

  /// The moves y of all bricks that minimise the energy to the second order. Gaps that the moves
  /// would make overlaps have their price, the others none: which these are is found by repetition.
  /// Empty if there is no minimum.
  MatrixXd solved(NewtonStep& step, double damping) {
    MatrixXd y;
    for (int k = 0; k < kOverlapSteps; ++k) {
      BandedMatrix hessian = step.hessian;
      MatrixXd gradient = step.gradient;
      for (std::size_t i = 0; i < moving(); ++i) {
        const auto column = static_cast<Eigen::Index>(i);
        const auto& [forms, gaps, prices] = step.near[i];
        const SparseMatrix priced = prices.asDiagonal() * forms;
        hessian.diagonal[i] += MatrixXd(SparseMatrix(forms.transpose() * priced));
        hessian.diagonal[i].diagonal().array() += damping;
        gradient.col(column) += priced.transpose() * gaps;
      }
      BandedCholesky factor;
      budget_.spend(factorisationCost(moving()));
      if (!factor.factorize(hessian)) return {};
      y = factor.solve(-gradient);
      if (!setPrices(step, y)) break;
    }
    return y;
  }

  /// Sets the prices of the gaps that are overlaps after the moves y. Returns whether one changes.
  static bool setPrices(NewtonStep& step, const MatrixXd& y) {
    bool isChanged = false;
    for (std::size_t i = 0; i < step.near.size(); ++i) {
      auto& [forms, gaps, prices] = step.near[i];
      const VectorXd after = gaps + forms * y.col(static_cast<Eigen::Index>(i));
      for (Eigen::Index n = 0; n < gaps.size(); ++n) {
        const double price = after[n] < 0 ? kPriceOfOverlap : 0;
        isChanged = isChanged || price != prices[n];
        prices[n] = price;
      }
    }
    return isChanged;
  }

  /// The energy to the second order.
  NewtonStep newtonStep() {
    NewtonStep step;
    setDifferences(step.hessian, step.gradient);
    for (std::size_t k = 0; k < moving(); ++k) {
      const std::size_t i = first_ + 1 + k;
      const OpeningCost cost = costOf(states_[i]);
      const SparseMatrix jacobian = joints_.jacobian(states_[i]);
      step.gradient.col(static_cast<Eigen::Index>(k)) +=
          price_ * (jacobian.transpose() * cost.gradient);
      step.hessian.diagonal[k] +=
          price_ * SparseMatrix(jacobian.transpose() * cost.hessian * jacobian);
      std::vector<NearGap> near;
      if (gaps_) near = gaps_->find(states_[i], kMargin * tile_, kPointReach * tile_);
      VectorXd gaps(static_cast<Eigen::Index>(near.size()));
      for (std::size_t n = 0; n < near.size(); ++n)
        gaps[static_cast<Eigen::Index>(n)] = near[n].gap + kOverlap * tile_;
      const VectorXd prices =
          (gaps.array() < 0).select(kPriceOfOverlap, VectorXd::Zero(gaps.size()));
      step.near.push_back({formsOf(near), gaps, prices});
    }
    return step;
  }

  /// The part of the energy to the second order that second differences give, in the moves of the
  /// bases: half its gradient and half its Hessian. The bases are orthonormal in the metric of z.
  void setDifferences(BandedMatrix& hessian, MatrixXd& gradient) const {
    const std::vector<VectorXd> second = secondDifferences(placesOf(states_));
    gradient.resize(freedoms(), static_cast<Eigen::Index>(moving()));
    const auto blockOf = [&](std::size_t i, std::size_t j) -> MatrixXd {
      const SparseMatrix product = productOfChanges(states_[i], states_[j]);
      if (allMayOpen_) return product;
      return bases_[i].transpose() * MatrixXd(product * bases_[j]);
    };
    for (std::size_t k = 0; k < moving(); ++k) {
      const std::size_t i = first_ + 1 + k;
      gradient.col(static_cast<Eigen::Index>(k)) =
          bases_[i].transpose() * formOf(second[i - 1] - 2 * second[i] + second[i + 1], states_[i]);
      hessian.diagonal.push_back(secondDifferencesAt(i) *
                                 MatrixXd::Identity(freedoms(), freedoms()));
      if (k > 0) hessian.first.push_back(-4 * blockOf(i, i - 1));
      if (k > 1) hessian.second.push_back(blockOf(i, i - 2));
    }
  }

  /// The sum of the squared factors with which a state enters second differences: its own, and
  /// those of both neighbours, except at the ends of the path.
  double secondDifferencesAt(std::size_t i) const {
    return 4 + (i > 1 ? 1 : 0) + (i + 2 < count() ? 1 : 0);
  }

  OpeningCost costOf(const Poses& poses) const {
    return joints_.cost(joints_.openings(poses), exponent_, opening_,
                        allMayOpen_ ? kShareOfSquares : 0);
  }

  /// The gaps of bricks that overlap by more than kOverlap, beyond it.
  std::vector<NearGap> overlapsOf(const Poses& poses) {
    std::vector<NearGap> near;
    if (gaps_) near = gaps_->find(poses, 0, kPointReach * tile_);
    std::erase_if(near, [&](NearGap& gap) { return (gap.gap += kOverlap * tile_) >= 0; });
    return near;
  }

  /// An orthonormal basis of the moves that keep joints closed.
  MatrixXd nullSpace(const Poses& poses) const {
    const MatrixXd transposed = MatrixXd(joints_.jacobian(poses)).transpose();
    if (joints_.rows() == 0) return MatrixXd::Identity(joints_.columns(), joints_.columns());
    Eigen::ColPivHouseholderQR<MatrixXd> qr(transposed);
    qr.setThreshold(kSingular);
    const MatrixXd q = qr.householderQ();
    return q.rightCols(joints_.columns() - qr.rank());
  }

  /// The basis of a neighbour, projected onto the moves that keep this state's joints closed. If
  /// joints may open, the moves that open them in the modes follow.
  MatrixXd carriedOn(const MatrixXd& neighbour, const Poses& poses, bool isOpen) {
    if (allMayOpen_) return neighbour;
    MatrixXd basis = MatrixXd::Zero(joints_.columns(), freedoms());
    if (joints_.rows() == 0) {
      basis.leftCols(free_) = neighbour.leftCols(free_);
      return basis;
    }
    least_.setState(poses);
    MatrixXd closed = neighbour.leftCols(free_);
    for (int k = 0; k < 2; ++k) {
      const MatrixXd changes = least_.jacobian() * closed;
      if (k > 0 && joints_.largest(changes.rowwise().norm()) < kClosedMove) break;
      closed = orthonormal(closed - least_.forChanges(changes));
    }
    basis.leftCols(free_) = closed;
    if (isOpen) basis.rightCols(modes_.cols()) = orthonormal(least_.forChanges(modes_));
    return basis;
  }

  /// The rows of a state's program that keep bricks apart. Bounds allow an overlap of `overlap`
  /// metres.
  void appendGaps(const std::vector<NearGap>& near, const MatrixXd& basis, double overlap,
                  BandedProgram& program) const {
    VectorXd bounds(static_cast<Eigen::Index>(near.size()));
    for (std::size_t n = 0; n < near.size(); ++n)
      bounds[static_cast<Eigen::Index>(n)] = -near[n].gap - overlap;
    program.constraints.emplace_back(formsOf(near) * basis);
    program.bounds.push_back(std::move(bounds));
  }

  /// The changes of gaps by u, one row per gap.
  Eigen::SparseMatrix<double, Eigen::RowMajor> formsOf(const std::vector<NearGap>& near) const {
    std::vector<Eigen::Triplet<double>> entries;
    int row = 0;
    for (const NearGap& gap : near) {
      const auto add = [&](const Vector6& form, int brick) {
        for (int f = 0; f < joints_.freedoms(); ++f) {
          entries.emplace_back(row, brick * joints_.freedoms() + f, joints_.partOf(form, brick, f));
        }
      };
      add(gap.ofA, gap.brickA);
      add(gap.ofB, gap.brickB);
      ++row;
    }
    Eigen::SparseMatrix<double, Eigen::RowMajor> forms(row, joints_.columns());
    forms.setFromTriplets(entries.begin(), entries.end());
    return forms;
  }

  /// Separates bricks of one state that overlap by more than `overlap` tiles. `neighbour`: the
  /// basis of a state nearby. If the state is to be between two others, along the planes of both.
  void pushApart(Poses& poses, const MatrixXd& neighbour, bool isOpen, double overlap,
                 const std::array<Poses, 2>* ends = nullptr) {
    if (!gaps_) return;
    const double margin = kPushMargin * tile_, reach = kPointReach * tile_;
    double before = std::numeric_limits<double>::infinity();
    MatrixXd basis;
    for (int k = 0; k < kPushes; ++k) {
      const std::vector<NearGap> near = ends ? gaps_->findBetween(*ends, poses, margin, reach)
                                             : gaps_->find(poses, margin, reach);
      double deepest = 0;
      for (const NearGap& gap : near) deepest = std::max(deepest, -gap.gap);
      if (deepest <= overlap * tile_ || deepest > kNoPushGain * before) return;
      before = deepest;
      if (k == 0) basis = carriedOn(neighbour, poses, isOpen);
      BandedProgram program;
      appendGaps(near, basis, -0.5 * overlap * tile_, program);
      program.hessian.diagonal.push_back(pushingCost(poses, basis));
      program.gradient = MatrixXd::Zero(basis.cols(), 1);
      program.priceScale = deepest;
      const MatrixXd y = solve(program, program.gradient).y;
      if (y.size() == 0) return;
      poses = joints_.moved(std::move(poses), basis * y.col(0));
      close(poses, isOpen);
    }
  }

  /// The cost of moves while bricks are pushed apart: moves that open joints cost more.
  MatrixXd pushingCost(const Poses& poses, const MatrixXd& basis) const {
    VectorXd weights = VectorXd::Ones(basis.cols());
    weights.tail(modes_.cols()).setConstant(kPriceOfPushing);
    MatrixXd cost = weights.asDiagonal();
    if (allMayOpen_) {
      const SparseMatrix jacobian = joints_.jacobian(poses);
      cost += kPriceOfPushing * MatrixXd(SparseMatrix(jacobian.transpose() * jacobian));
    }
    return cost;
  }

  /// The deepest overlap beyond the start, metres.
  double overlapOf(std::span<const Poses> states) {
    double deepest = 0;
    if (!gaps_) return deepest;
    for (const Poses& poses : states) {
      for (const NearGap& near : gaps_->find(poses, 0, 0)) deepest = std::max(deepest, -near.gap);
    }
    return deepest;
  }

  /// z of a state: the position and the rotation matrix of each brick.
  VectorXd placesOf(const Poses& poses) const {
    VectorXd places(12 * static_cast<Eigen::Index>(poses.size()));
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const auto row = 12 * static_cast<Eigen::Index>(i);
      const double scale = joints_.radius(static_cast<int>(i)) * std::numbers::sqrt2 / 2;
      const Matrix3 rotation = scale * poses[i].rotation.toRotationMatrix();
      places.segment<3>(row) = poses[i].position;
      places.segment<9>(row + 3) = rotation.reshaped();
    }
    return places;
  }

  /// (dz/du)' v for a change v of z at a state.
  VectorXd formOf(const VectorXd& v, const Poses& poses) const {
    VectorXd form(joints_.columns());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const auto row = 12 * static_cast<Eigen::Index>(i);
      const Matrix3 turned = std::numbers::sqrt2 / 2 * v.segment<9>(row + 3).reshaped(3, 3) *
                             poses[i].rotation.toRotationMatrix().transpose();
      Vector6 ofBrick;
      ofBrick << v.segment<3>(row), turned(2, 1) - turned(1, 2), turned(0, 2) - turned(2, 0),
          turned(1, 0) - turned(0, 1);
      for (int f = 0; f < joints_.freedoms(); ++f) {
        form[static_cast<Eigen::Index>(i) * joints_.freedoms() + f] = ofBrick[joints_.component(f)];
      }
    }
    return form;
  }

  /// (dz/du)' at one state times dz/du at another: a block per brick. With M = R_to R_from', the
  /// block of rotations is (I tr M - M) / 2.
  SparseMatrix productOfChanges(const Poses& from, const Poses& to) const {
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t i = 0; i < from.size(); ++i) {
      const Matrix3 turn = (to[i].rotation * from[i].rotation.conjugate()).toRotationMatrix();
      Eigen::Matrix<double, 6, 6> block = Eigen::Matrix<double, 6, 6>::Identity();
      block.bottomRightCorner<3, 3>() = 0.5 * (turn.trace() * Matrix3::Identity() - turn);
      const auto first = static_cast<int>(i) * joints_.freedoms();
      for (int row = 0; row < joints_.freedoms(); ++row) {
        for (int column = 0; column < joints_.freedoms(); ++column) {
          const double value = block(joints_.component(row), joints_.component(column));
          if (value != 0) entries.emplace_back(first + row, first + column, value);
        }
      }
    }
    SparseMatrix product(joints_.columns(), joints_.columns());
    product.setFromTriplets(entries.begin(), entries.end());
    return product;
  }

  std::vector<VectorXd> placesOf(const std::vector<Poses>& states) const {
    std::vector<VectorXd> places;
    for (const Poses& poses : states) places.push_back(placesOf(poses));
    return places;
  }

  /// Second differences of z; zero at the ends of the path.
  static std::vector<VectorXd> secondDifferences(const std::vector<VectorXd>& z) {
    std::vector<VectorXd> second(z.size(), VectorXd::Zero(z.front().size()));
    for (std::size_t i = 1; i + 1 < z.size(); ++i) second[i] = z[i - 1] - 2 * z[i] + z[i + 1];
    return second;
  }

  /// The part of the energy that depends on the states that a round moves.
  double energyOf(const std::vector<Poses>& states) {
    const std::vector<VectorXd> second = secondDifferences(placesOf(states));
    double energy = 0;
    for (std::size_t i = first_; i <= last_; ++i) {
      energy += second[i].squaredNorm();
      if (i == first_ || i == last_) continue;
      if (modes_.cols() > 0 || allMayOpen_) energy += price_ * costOf(states[i]).value;
      if (!allMayOpen_) continue;
      for (const NearGap& deep : overlapsOf(states[i]))
        energy += kPriceOfOverlap * deep.gap * deep.gap;
    }
    return energy / scale_;
  }

  /// The largest second difference of a brick at each state, over the typical step.
  std::vector<double> stepChanges() const {
    const std::vector<VectorXd> z = placesOf(states_);
    std::vector<double> changes;
    double typical = 0;
    for (const VectorXd& second : secondDifferences(z)) {
      double largest = 0;
      for (Eigen::Index row = 0; row < second.size(); row += 12) {
        largest = std::max(largest, second.segment<12>(row).norm());
      }
      changes.push_back(largest);
    }
    for (std::size_t i = 1; i < z.size(); ++i) {
      for (Eigen::Index row = 0; row < z[i].size(); row += 12) {
        typical += (z[i] - z[i - 1]).segment<12>(row).norm();
      }
    }
    typical /= static_cast<double>(bricks_.size() * (z.size() - 1));
    for (double& change : changes) change /= typical;
    return changes;
  }

  /// Whether the steps of all bricks change little at the states that a round moves.
  bool isSmooth() const {
    const std::vector<double> changes = stepChanges();
    return std::ranges::all_of(changes.begin() + static_cast<std::ptrdiff_t>(first_),
                               changes.begin() + static_cast<std::ptrdiff_t>(last_) + 1,
                               [](double change) { return change <= kSmoothEnough; });
  }

  /// The program of a round, without damping.
  BandedProgram programOf() {
    BandedProgram program;
    setDifferences(program.hessian, program.gradient);
    for (std::size_t k = 0; k < moving(); ++k) {
      const std::size_t i = first_ + 1 + k;
      if (modes_.cols() > 0) {
        const MatrixXd openings = joints_.jacobian(states_[i]) * bases_[i];
        program.gradient.col(static_cast<Eigen::Index>(k)) +=
            price_ * openings.transpose() * costOf(states_[i]).gradient;
        program.hessian.diagonal[k] += price_ * openings.transpose() * openings;
      }
      std::vector<NearGap> near;
      if (gaps_) near = gaps_->find(states_[i], kMargin * tile_, kPointReach * tile_);
      appendGaps(near, bases_[i], 0.5 * kOverlap * tile_, program);
    }
    program.priceScale = program.gradient.colwise().norm().maxCoeff();
    return program;
  }

  /// The longest move of a brick, metres.
  double longest(const std::vector<VectorXd>& moves) const {
    double most = 0;
    for (const VectorXd& u : moves) {
      for (Eigen::Index i = 0; i < u.size(); i += joints_.freedoms()) {
        most = std::max(most, u.segment(i, joints_.freedoms()).norm());
      }
    }
    return most;
  }

  /// The moves of all bricks for moves y of the bases.
  std::vector<VectorXd> movesOf(const MatrixXd& y) const {
    std::vector<VectorXd> moves;
    for (Eigen::Index k = 0; k < y.cols(); ++k) {
      moves.push_back(bases_[first_ + 1 + static_cast<std::size_t>(k)] * y.col(k));
    }
    return moves;
  }

  /// Tries rounds until one is accepted. Returns whether one was. Moves without constraints are
  /// about as long as with them and cost much less. So they decide about the damping: after a
  /// round that is not accepted, they must be half as long.
  bool round(double& damping, int& tries) {
    const BandedProgram program = programOf();
    double limit = 2 * kLongestRoundMove;
    for (; tries > 0 && damping <= kMaxDamping && !isOver();) {
      BandedProgram damped = program;
      for (MatrixXd& block : damped.hessian.diagonal) block.diagonal().array() += damping;
      MatrixXd unconstrained = unconstrainedMinimum(damped);
      budget_.spend(factorisationCost(moving()));
      const double most = longest(movesOf(unconstrained)) / tile_;
      if (unconstrained.size() == 0 || most > limit) {
        damping *= unconstrained.size() > 0 && most < 3 * limit ? 3 : 10;
        continue;
      }
      limit = 0.5 * most;
      const auto [y, factorisations] = solve(damped, std::move(unconstrained));
      budget_.spend(factorisations * factorisationCost(moving()));
      --tries;
      if (y.size() > 0) {
        const std::vector<VectorXd> moves = movesOf(y);
        const double longestMove = longest(moves) / tile_;
        if (take(moves, std::min(1.0, kLongestRoundMove / longestMove))) {
          const double factor = longestMove < 0.5 * kLongestRoundMove ? 10
                                : longestMove < kLongestRoundMove     ? 3
                                                                      : 1;
          damping = std::max(damping / factor, kMinDamping);
          return true;
        }
      }
      damping *= 10;
    }
    return false;
  }

  /// Moves all states by a fraction of the moves. Keeps them if that is better.
  bool take(const std::vector<VectorXd>& moves, double part) {
    std::vector<Poses> tried = states_;
    for (std::size_t i = first_ + 1; i < last_; ++i) {
      tried[i] = joints_.moved(std::move(tried[i]), part * moves[i - first_ - 1]);
      const double gap = close(tried[i], isOpen_[i]);
      if (gap > maxOpening_) return false;
      pushApart(tried[i], bases_[i], isOpen_[i], kOverlap);
      makeSymmetric(tried[i], isOpen_[i]);
    }
    const double overlap = overlapOf(std::span(tried).subspan(first_, last_ - first_ + 1));
    const double energy = energyOf(tried);
    const double allowed = std::max(kMaxOverlap * tile_, overlap_);
    const bool isBetter = (energy < energy_ && overlap <= allowed) ||
                          (overlap < 0.7 * overlap_ && overlap_ > kMaxOverlap * tile_);
    if (!isBetter) return false;
    states_ = std::move(tried);
    for (std::size_t i = first_ + 1; i < last_; ++i) {
      bases_[i] = carriedOn(bases_[i], states_[i], isOpen_[i]);
    }
    energy_ = energy;
    overlap_ = overlap;
    return true;
  }

  /// The mean of a state's images under the symmetries, with its joints closed again.
  void makeSymmetric(Poses& poses, bool isOpen) {
    if (found_.path.symmetries.size() < 2) return;
    poses = model::symmetricMean(poses, found_.path.symmetries);
    close(poses, isOpen);
  }

  /// Replaces the states by those of the result: at constant speed on cubics through them.
  void sampleFinely() {
    const std::vector<double> from = run::pathLengths(bricks_, states_);
    const double number =
        std::clamp(std::ceil(from.back() / (kFinalSpacing * tile_)), kMinFinal, kMaxFinal);
    std::vector<Poses> fine = {states_.front()};
    std::vector<MatrixXd> bases = {bases_.front()};
    std::vector<bool> areOpen = {isOpen_.front()};
    for (double k = 1; k <= number; ++k) {
      const double length = from.back() * (k / number);
      fine.push_back(k < number ? stateAt(from, length) : states_.back());
      const auto next = std::upper_bound(from.begin() + 1, from.end() - 1, length);
      const auto i = static_cast<std::size_t>(next - from.begin());
      areOpen.push_back(k < number ? isOpen_[i - 1] || isOpen_[i] : isOpen_.back());
      bases.push_back(bases_[nearest(from, i, length)]);
    }
    states_ = std::move(fine);
    bases_ = std::move(bases);
    isOpen_ = std::move(areOpen);
    hasOwnBasis_.assign(count(), false);
    setScale();
  }

  using Parts = std::vector<std::pair<std::size_t, std::size_t>>;

  /// Parts of the path in which steps change much, with a margin: their first and last states.
  Parts roughParts() const {
    Parts parts;
    const std::vector<double> changes = stepChanges();
    for (std::size_t i = 1; i < count(); ++i) {
      if (!(changes[i] > kRough)) continue;
      const std::size_t first = i - std::min(i, kRoughMargin);
      const std::size_t last = std::min(i + kRoughMargin, count() - 1);
      if (parts.empty() || first > parts.back().second) {
        parts.emplace_back(first, last);
      } else {
        parts.back().second = last;
      }
    }
    return parts;
  }

  /// The states with others between two of them where bricks overlap there.
  std::vector<Poses> withInsertedStates() {
    const std::vector<double> from = run::pathLengths(bricks_, states_);
    std::vector<std::pair<double, Poses>> next;  // with their lengths, the last first
    for (std::size_t i = count(); --i > 0;) next.emplace_back(from[i], states_[i]);
    const std::size_t most = 2 * next.size();
    std::vector<Poses> found = {states_.front()};
    double last = 0;
    while (!next.empty()) {
      const auto& [length, poses] = next.back();
      const double spacing = (length - last) / from.back();
      if (found.size() + next.size() < most && spacing > kMinSpacingAtCorners &&
          overlapsBetween(found.back(), poses)) {
        const std::array<Poses, 2> ends = {found.back(), poses};
        const double middle = 0.5 * (last + length);
        next.emplace_back(middle, stateAt(from, middle, spacing > kMinSpacing ? nullptr : &ends));
        continue;
      }
      last = length;
      found.push_back(std::move(next.back().second));
      next.pop_back();
    }
    return found;
  }

  /// Whether bricks overlap between two neighbouring states by more than in them.
  bool overlapsBetween(const Poses& from, const Poses& to) {
    if (!gaps_) return false;
    const auto closedAt = [&](double share) {
      Poses poses = interpolate(from, to, share);
      closeTo((1 - share) * joints_.openings(from) + share * joints_.openings(to), poses);
      return poses;
    };
    const std::array<Poses, 2> thirds = {closedAt(1.0 / 3), closedAt(2.0 / 3)};
    const double deepest = std::max(overlapOf(std::array{from, to}), kMaxOverlap * tile_);
    return overlapOf(run::momentsThrough(from, thirds, to)) > deepest;
  }

  /// The state at a length between the ends, `lengths` being those of the improved states. `ends`:
  /// see pushApart().
  Poses stateAt(const std::vector<double>& lengths, double length,
                const std::array<Poses, 2>* ends = nullptr) {
    const auto next = std::upper_bound(lengths.begin() + 1, lengths.end() - 1, length);
    const auto i = static_cast<std::size_t>(next - lengths.begin());
    const bool isOpen = isOpen_[i - 1] || isOpen_[i];
    Poses poses = onCubic(lengths, i, length);
    if (isOpen) {
      const double share = (length - lengths[i - 1]) / (lengths[i] - lengths[i - 1]);
      closeTo((1 - share) * joints_.openings(states_[i - 1]) + share * joints_.openings(states_[i]),
              poses);
    } else {
      close(poses, false);
    }
    pushApart(poses, bases_[nearest(lengths, i, length)], isOpen, kFinalOverlap, ends);
    makeSymmetric(poses, isOpen);
    return poses;
  }

  /// The nearer end of the interval before state i.
  static std::size_t nearest(const std::vector<double>& lengths, std::size_t i, double length) {
    return length - lengths[i - 1] < lengths[i] - length ? i - 1 : i;
  }

  /// The cubic through the four states around the interval before state i.
  Poses onCubic(const std::vector<double>& lengths, std::size_t i, double length) const {
    const std::size_t first = std::min(i > 2 ? i - 2 : 0, count() - 4);
    return run::polynomialAt(length, std::span(lengths).subspan(first, 4),
                             std::span(states_).subspan(first, 4), states_[i]);
  }

  const run::GeometricPath& found_;
  run::SearchBudget& budget_;
  const PathObserver& shouldContinue_;
  double tile_;  // metres
  bool isPlanar_;
  double maxOpening_;  // after Newton steps, metres
  std::vector<brick::Brick> bricks_;
  std::vector<brick::Pivot> pivots_;
  JointOpenings joints_;
  LeastMoves least_;
  std::optional<NearGapFinder> gaps_;  // absent if bricks may not touch
  std::vector<Poses> states_;
  std::size_t first_ = 0, last_ = 0;  // a round moves the states between these two
  std::vector<bool> isOpen_;          // whether joints of a state are open
  MatrixXd modes_;                    // of openings, orthonormal columns
  int free_ = 0;                      // motions that keep joints closed
  std::vector<MatrixXd> bases_;       // one per state
  std::vector<bool> hasOwnBasis_;     // if not, the basis is that of a state nearby
  bool allMayOpen_ = false;           // all joints, instead of in the modes only
  double exponent_ = 2;               // of the cost of openings
  double opening_ = 1;                // the scale of this cost: the largest opening, metres
  double price_ = 0;                  // of the cost of openings
  double scale_ = 0;                  // of the energy, square metres
  double energy_ = 0;
  double overlap_ = 0;  // the deepest beyond the start, metres
};

}  // namespace

std::optional<run::MechanismPath> smoothed(const scene::Scene& scene,
                                           const run::GeometricPath& found,
                                           scene::ContactFilter contacts, run::SearchBudget& budget,
                                           const PathObserver& shouldContinue) {
  const run::MechanismPath& old = found.path;
  if (!(old.length() > 0) || old.states.front().size() > kMaxBricks) return std::nullopt;
  std::vector<Poses> states = Smoothing(scene, found, contacts, budget, shouldContinue).find();
  if (states.empty()) return std::nullopt;
  run::MechanismPath path = old;
  path.states = std::move(states);
  path.lengths = run::pathLengths(brick::makeBricks(scene.model.tiles, scene.brick), path.states);
  return path;
}

}  // namespace kirireel::path
