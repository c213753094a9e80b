/// Interface of forces between pairs of bricks, such as springs at hinges and elastic ligaments.
/// Runs, energy balances, files and figures use it for every kind of force.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "sim/base/geometry.h"

namespace kirireel::brick {

struct HingeSpring;
struct Ligament;

// ------------------------------------------------------------------------------------------------
// The force of one pair of bricks.

/// The stored energy of a pair and its derivatives by six coordinates of each brick, brick A first:
/// displacement of its centre of mass (metres) and rotation vector (radians), in world axes,
/// relative to the current poses.
struct PairEnergy {
  double energy = 0;                     ///< joules
  Vector12 gradient = Vector12::Zero();  ///< N and N m: the negative of the forces on the bricks
  Matrix12 hessian = Matrix12::Zero();   ///< symmetric, possibly indefinite
};

/// The same in the plane: derivatives by x, y and rotation of brick A, then of brick B.
struct PlanarEnergy {
  double energy = 0;                   ///< joules
  Vector6 gradient = Vector6::Zero();  ///< N and N m
  Matrix6 hessian = Matrix6::Zero();   ///< symmetric; it may be indefinite
};

/// The part of an energy in space that belongs to the motion in the plane.
PlanarEnergy inPlane(const PairEnergy& energy);
/// An energy in the plane as an energy in space. The other derivatives are 0.
PairEnergy inSpace(const PlanarEnergy& energy);

// ------------------------------------------------------------------------------------------------
// Pairs as columns of numbers, as stored in trajectory.h5.

/// One or more numbers of each pair.
struct PairColumn {
  std::string name;             ///< of the array in the group of its kind
  std::string unit;             ///< empty for whole numbers
  std::size_t width = 1;        ///< numbers per pair
  std::vector<double> numbers;  ///< pair by pair
  bool isWhole = false;         ///< whether the numbers are stored as integers
};

/// The columns of one kind of force in a file.
class PairReader {
 public:
  virtual ~PairReader() = default;

  /// The two bricks of each pair. Throws InputError for bricks that do not exist. All functions
  /// here throw InputError for contents that are not valid in a file.
  virtual std::vector<std::pair<int, int>> bricks() const = 0;
  /// The finite numbers of a column for this many pairs, pair by pair.
  virtual std::vector<double> numbers(const std::string& column, std::size_t pairs,
                                      std::size_t width) const = 0;
  /// The same for a column of whole numbers of any length.
  virtual std::vector<int> wholeNumbers(const std::string& column) const = 0;
  /// Number of joints of the model.
  virtual std::size_t joints() const = 0;
  /// The unit normal of the model's start if the start is flat, else z.
  virtual Vector3 normal() const = 0;
  /// Throws InputError with this description of the error in the file.
  [[noreturn]] virtual void refuse(const std::string& what) const = 0;
};

/// Position of a column's numbers in a pair.
template <class Pair>
struct PairField {
  const char* name;             ///< of the column
  const char* unit;             ///< such as "N m/rad"
  std::size_t width;            ///< count of numbers, starting at `at`
  double* (*at)(Pair& fields);  ///< the first number
};

/// The columns of pairs, one per field.
// By value, since `at` needs references that are not const.
template <class Pair, std::size_t kFields>
std::vector<PairColumn> columnsOf(std::vector<Pair> pairs,
                                  const std::array<PairField<Pair>, kFields>& fields) {
  std::vector<PairColumn> columns;
  for (const PairField<Pair>& field : fields) {
    PairColumn& column = columns.emplace_back(PairColumn{field.name, field.unit, field.width, {}});
    for (Pair& pair : pairs) {
      column.numbers.insert(column.numbers.end(), field.at(pair), field.at(pair) + field.width);
    }
  }
  return columns;
}

/// Sets these fields of all pairs from a file. Throws InputError.
template <class Pair, std::size_t kFields>
void readFields(const PairReader& file, const std::array<PairField<Pair>, kFields>& fields,
                std::vector<Pair>& pairs) {
  for (const PairField<Pair>& field : fields) {
    const std::vector<double> numbers = file.numbers(field.name, pairs.size(), field.width);
    auto number = numbers.begin();
    for (Pair& pair : pairs) {
      std::copy_n(number, field.width, field.at(pair));
      number += static_cast<std::ptrdiff_t>(field.width);
    }
  }
}

// ------------------------------------------------------------------------------------------------
// The forces of a scene.

/// Names of a kind of force.
struct PairForceName {
  const char* group;    ///< in trajectory.h5, such as "hinges"
  const char* counted;  ///< in the summary's elasticity, such as "springs"
  const char* words;    ///< in a report, {} is the count, such as "springs at {} hinges"
};

/// One kind of force between pairs of bricks, with all its pairs, numbered from 0. It stores energy
/// and may also have dashpots.
class PairForce {
 public:
  virtual ~PairForce() = default;

  /// The same for all objects of one kind.
  virtual const PairForceName& name() const = 0;
  /// Number of pairs.
  virtual std::size_t size() const = 0;
  /// The numbers of a pair's bricks, A and B.
  virtual std::pair<int, int> bricks(std::size_t pair) const = 0;
  /// Stored energy of a pair at these poses, joules; one pose per brick.
  virtual double energy(std::size_t pair, const Poses& poses) const = 0;
  /// The same with its derivatives.
  virtual PairEnergy derivatives(std::size_t pair, const Poses& poses) const = 0;
  /// The joint that the pair replaces; kNoJoint if it replaces none.
  virtual int joint(std::size_t /*pair*/) const { return kNoJoint; }
  /// Adds the force and torque of all pairs on each brick about its centre of mass (N, N m) at this
  /// motion of the bricks, dashpots included. Without dashpots it follows from the derivatives.
  virtual void addForces(const Motion& motion, std::vector<Vector6>& forces) const;
  /// The bricks of the first pair whose energy is not continuous between these poses, for example
  /// because an angle is known only within some turns. Empty if there is none.
  virtual std::optional<std::pair<int, int>> findJump(const Poses& /*from*/,
                                                      const Poses& /*to*/) const {
    return std::nullopt;
  }
  /// All fields of the pairs except the bricks.
  virtual std::vector<PairColumn> columns() const = 0;
  /// The pairs, if their energy depends on one angle; otherwise null.
  virtual const std::vector<HingeSpring>* hingeSprings() const { return nullptr; }
  /// The pairs, if they replace joints; otherwise null.
  virtual const std::vector<Ligament>* ligaments() const { return nullptr; }

  /// Stored energy of all pairs at these poses, joules.
  double energy(const Poses& poses) const;

  /// Value of joint() for a pair that replaces no joint.
  static constexpr int kNoJoint = -1;
};

/// All forces between pairs of bricks of a scene, one object per kind. Copies share the objects.
class PairForces {
 public:
  /// Adds a kind of force. Null, or a kind without pairs, is ignored.
  void add(std::shared_ptr<const PairForce> force);

  /// Whether there are no forces.
  bool empty() const { return forces_.empty(); }
  /// The first kind, in order of addition.
  auto begin() const { return forces_.begin(); }
  /// End of the kinds.
  auto end() const { return forces_.end(); }

  /// Stored energy of all forces at these poses, joules.
  double energy(const Poses& poses) const;
  /// Whether some forces replace joints, which are compliant then.
  bool replaceJoints() const;
  /// See PairForce::findJump().
  std::optional<std::pair<int, int>> findJump(const Poses& from, const Poses& to) const;

 private:
  std::vector<std::shared_ptr<const PairForce>> forces_;
};

}  // namespace kirireel::brick
