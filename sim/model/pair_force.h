/// Forces between pairs of bricks, such as springs at hinges and elastic ligaments: what a run, its
/// account of energies, its file and its figures ask of them, whatever they are.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "sim/base/geometry.h"

namespace kirireel::model {

struct HingeSpring;
struct Ligament;

// ------------------------------------------------------------------------------------------------
// What one pair of bricks feels.

/// The energy that a pair's force stores, with its derivatives by six coordinates of each brick,
/// brick A first: how its centre of mass moves (metres) and how it turns (rotation vector,
/// radians), in world axes, from the poses at hand.
struct PairEnergy {
  double energy = 0;                     ///< joules
  Vector12 gradient = Vector12::Zero();  ///< N and N m: minus what the bricks are pushed with
  Matrix12 hessian = Matrix12::Zero();   ///< symmetric; it may be indefinite
};

/// The same in the plane: the derivatives are by x, y and turn of brick A, then of brick B.
struct PlanarEnergy {
  double energy = 0;                   ///< joules
  Vector6 gradient = Vector6::Zero();  ///< N and N m
  Matrix6 hessian = Matrix6::Zero();   ///< symmetric; it may be indefinite
};

/// What of an energy in space concerns the plane.
PlanarEnergy inPlane(const PairEnergy& energy);
/// An energy in the plane as one in space, whose other derivatives are 0.
PairEnergy inSpace(const PlanarEnergy& energy);

// ------------------------------------------------------------------------------------------------
// Pairs as columns of numbers, which is how trajectory.h5 keeps them.

/// A number, or several, that each pair has.
struct PairColumn {
  std::string name;             ///< of the array in the kind's group
  std::string unit;             ///< empty for whole numbers, which have none
  std::size_t width = 1;        ///< how many numbers a pair has
  std::vector<double> numbers;  ///< pair by pair
  bool isWhole = false;         ///< whether they are whole, and kept as such
};

/// The columns of one kind of force in a file.
class PairReader {
 public:
  virtual ~PairReader() = default;

  /// The bricks of each pair, of which the file has as many as numbers say. Throws InputError for
  /// bricks that are not there, as all functions here do for what a file cannot hold.
  virtual std::vector<std::pair<int, int>> bricks() const = 0;
  /// The numbers of a column for so many pairs, finite, pair by pair.
  virtual std::vector<double> numbers(const std::string& column, std::size_t pairs,
                                      std::size_t width) const = 0;
  /// The same for a column of whole numbers, however many there are.
  virtual std::vector<int> wholeNumbers(const std::string& column) const = 0;
  /// How many joints the model has.
  virtual std::size_t joints() const = 0;
  /// The unit normal of the model's start if that is flat, else z.
  virtual Vector3 normal() const = 0;
  /// Throws InputError: what is wrong with the file.
  [[noreturn]] virtual void refuse(const std::string& what) const = 0;
};

/// Where a column's numbers are in a pair.
template <class Pair>
struct PairField {
  const char* name;             ///< of the column
  const char* unit;             ///< as "N m/rad"
  std::size_t width;            ///< how many numbers there are from `at` on
  double* (*at)(Pair& fields);  ///< the first of them
};

/// The columns of pairs, by what fields they have.
// By value, since fields are reached through references that are not const.
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

/// Sets these fields of all pairs to what a file has. Throws InputError.
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

/// What a kind of force is called.
struct PairForceName {
  const char* group;    ///< in trajectory.h5, as "hinges"
  const char* counted;  ///< in the summary's elasticity, as "springs"
  const char* words;    ///< in a report, with {} for how many, as "springs at {} hinges"
};

/// One kind of force between pairs of bricks, and all its pairs, counted from 0. It stores energy;
/// dashpots may be beside that.
class PairForce {
 public:
  virtual ~PairForce() = default;

  /// The same for all objects of the kind.
  virtual const PairForceName& name() const = 0;
  /// How many pairs there are.
  virtual std::size_t size() const = 0;
  /// The numbers of a pair's bricks, A and B.
  virtual std::pair<int, int> bricks(std::size_t pair) const = 0;
  /// What a pair stores at these poses, joules; one pose a brick.
  virtual double energy(std::size_t pair, const Poses& poses) const = 0;
  /// The same with its derivatives.
  virtual PairEnergy derivatives(std::size_t pair, const Poses& poses) const = 0;
  /// The joint of the model in whose place the pair stands; kNoJoint: in that of none.
  virtual int joint(std::size_t /*pair*/) const { return kNoJoint; }
  /// Adds to each brick's force and torque about its centre of mass (N, N m) what all pairs push
  /// with while the bricks move so, dashpots included. Without those it follows from the
  /// derivatives.
  virtual void addForces(const Motion& motion, std::vector<Vector6>& forces) const;
  /// Everything that a pair has besides its bricks.
  virtual std::vector<PairColumn> columns() const = 0;
  /// The pairs of a kind whose energy is that of one angle; null for other kinds.
  virtual const std::vector<HingeSpring>* hingeSprings() const { return nullptr; }
  /// The pairs of a kind that replaces joints; null for other kinds.
  virtual const std::vector<Ligament>* ligaments() const { return nullptr; }

  /// What all pairs store at these poses, joules.
  double energy(const Poses& poses) const;

  /// No joint: the pair stands beside all of them.
  static constexpr int kNoJoint = -1;
};

/// All forces between pairs of bricks of a scene, one object a kind. Copies share them.
class PairForces {
 public:
  /// Adds a kind; one without pairs, or null, is left out.
  void add(std::shared_ptr<const PairForce> force);

  /// Whether there are none.
  bool empty() const { return forces_.empty(); }
  /// The first kind, in the order in which they were added.
  auto begin() const { return forces_.begin(); }
  /// Behind the last.
  auto end() const { return forces_.end(); }

  /// What all of them store at these poses, joules.
  double energy(const Poses& poses) const;
  /// Whether some of them stand in the place of joints, which are compliant then.
  bool replaceJoints() const;

 private:
  std::vector<std::shared_ptr<const PairForce>> forces_;
};

}  // namespace kirireel::model
