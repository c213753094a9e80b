// Three ways to colour bricks:
//
// - kinds: a number for each shape of tile. Two tiles are congruent when their sorted sides and
//   sorted shortest diagonals agree to 1e-4. Mirror images have the same lengths. (Different
//   polygons of many corners may agree by chance; for colours that does not matter.)
// - states: at its start, on its way, at its target, within 1% of a tile's mean edge.
// - measures: a value for each brick and a scale from 0 to the largest of the run, the same for all
//   pictures. Before a run, as for the first frame of a live one, the largest is guessed.
#include "render/studio/colourist.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/measure/brick_measures.h"

namespace kirireel {
namespace {

/// Lengths of congruent tiles may differ by this part.
constexpr double kCongruence = 1e-4;

/// Shapes that colours can tell apart.
constexpr int kMostKinds = 7;

/// A brick is at its start or its target within this part of a tile's mean edge.
constexpr double kArrival = 0.01;

constexpr Colour kAtStart = {168, 178, 192};
constexpr Colour kMoving = {246, 184, 96};
constexpr Colour kAtTarget = {110, 186, 150};

/// Sides and shortest diagonals in order of length: equal for congruent polygons. Twice as many
/// numbers as corners, metres.
std::vector<double> signature(const std::vector<Vector3>& corners) {
  const std::size_t count = corners.size();
  std::vector<double> sides, diagonals;
  for (std::size_t k = 0; k < count; ++k) {
    sides.push_back((corners[(k + 1) % count] - corners[k]).norm());
    diagonals.push_back((corners[(k + 2) % count] - corners[k]).norm());
  }
  std::sort(sides.begin(), sides.end());
  std::sort(diagonals.begin(), diagonals.end());
  sides.insert(sides.end(), diagonals.begin(), diagonals.end());
  return sides;
}

bool alike(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) {
    return std::abs(x - y) <= kCongruence * std::max(x, y);
  });
}

/// The number of each entry in the list of entries that differ, in order of appearance.
template <typename T, typename Same>
/// Compares each entry with all kinds so far; there are few.
std::vector<int> numbered(const std::vector<T>& entries, const Same& same) {
  std::vector<T> known;
  std::vector<int> numbers;
  for (const T& entry : entries) {
    const auto found = std::find_if(known.begin(), known.end(),
                                    [&](const T& other) { return same(entry, other); });
    numbers.push_back(static_cast<int>(found - known.begin()));
    if (found == known.end()) known.push_back(entry);
  }
  return numbers;
}

/// Metres; 1 where there are no bricks.
double meanEdge(const std::vector<Brick>& bricks) {
  double sum = 0;
  int count = 0;
  for (const Brick& brick : bricks) {
    for (std::size_t k = 0; k < brick.bottom.size(); ++k) {
      sum += (brick.bottom[(k + 1) % brick.bottom.size()] - brick.bottom[k]).norm();
      ++count;
    }
  }
  return count > 0 ? sum / count : 1;
}

/// For the legend: "concave hexagon", "12-gon".
std::string shapeName(const Brick& brick) {
  const std::size_t corners = brick.bottom.size();
  const std::string concave = brick.parts.empty() ? "" : "concave ";
  constexpr std::array<const char*, 6> kNames = {"triangle", "quadrilateral", "pentagon",
                                                 "hexagon",  "heptagon",      "octagon"};
  if (corners >= 3 && corners - 3 < kNames.size()) return concave + kNames[corners - 3];
  return fmt::format("{}{}-gon", concave, corners);
}

const char* titleOf(Colouring colouring) {
  switch (colouring) {
    case Colouring::TargetError:
      return "target error, m";
    case Colouring::Displacement:
      return "displacement, m";
    case Colouring::Rotation:
      return "rotation, degrees";
    case Colouring::Moment:
      return "moment, N m";
    case Colouring::Energy:
      return "energy, J";
    default:
      return "joint gap, m";
  }
}

/// 0 for none.
double largest(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

/// Of the points' bounding box.
double diagonal(const std::vector<Vector3>& points) {
  Eigen::AlignedBox3d box;
  for (const Vector3& point : points) box.extend(point);
  return box.diagonal().norm();
}

}  // namespace

bool isMeasure(Colouring colouring) {
  return colouring != Colouring::Plain && colouring != Colouring::Shape &&
         colouring != Colouring::State;
}

BrickColours evenShades(Colour colour) {
  BrickColours shades = shadesOf(colour);
  shades.bottom = colour;
  return shades;
}

BrickColours plainColours(const Look& look) {
  BrickColours colours = look.brickColour ? shadesOf(*look.brickColour) : BrickColours();
  if (look.backColour) colours.bottom = *look.backColour;
  return colours;
}

std::vector<int> shapeKinds(const std::vector<Brick>& bricks) {
  std::vector<std::vector<double>> signatures;
  std::vector<std::size_t> corners;
  for (const Brick& brick : bricks) {
    signatures.push_back(signature(brick.bottom));
    corners.push_back(brick.bottom.size());
  }
  std::vector<int> kinds = numbered(signatures, alike);
  const bool many = std::any_of(kinds.begin(), kinds.end(), [](int k) { return k >= kMostKinds; });
  return many ? numbered(corners, std::equal_to<>()) : kinds;
}

Colourist::Colourist(const Look& look, const Motif& motif)
    : colouring_(look.colouring), motif_(motif) {
  if (colouring_ == Colouring::TargetError && !motif.target) {
    throw InputError(
        "error: the model has no target, so there is no target error to show; give another "
        "--colour or add target.txt");
  }
  if ((colouring_ == Colouring::Moment || colouring_ == Colouring::Energy) &&
      motif.hingeSprings.empty()) {
    throw InputError(
        "error: the hinges have no springs, so there is no moment or energy to show; give another "
        "--colour or add --hinge-stiffness or --hinge-neck");
  }
  if (colouring_ == Colouring::Shape) colourShapes();
  if (colouring_ == Colouring::State) {
    legend_ = {{kAtStart, "at its start"}, {kMoving, "on its way"}};
    if (motif.target) legend_.push_back({kAtTarget, "at its target"});
  }
  if (!look.tileColours.empty()) colourTiles(look);
  if (isMeasure(colouring_)) makeScale(look);
}

void Colourist::makeScale(const Look& look) {
  const double found = largestOfRun();
  const double most = look.colourMost.value_or(found > 0 ? found : largestExpected());
  const double least = look.colourLeast.value_or(0);
  if (least >= most) {
    throw InputError(
        fmt::format("error: --colour-least {:g} is not below {:g}, the scale's other end; give a "
                    "smaller one, or a larger --colour-most",
                    least, most));
  }
  scale_ = ColourScale{look.map, least, most, titleOf(colouring_)};
}

void Colourist::colourTiles(const Look& look) {
  if (isMeasure(colouring_)) {
    throw InputError(
        "error: --tile-colour works with --colour plain, shape or state alone, as other colours "
        "stand for values; give one of these, or leave --tile-colour away");
  }
  own_.resize(motif_.bricks.size());
  for (const auto& [tiles, colour] : look.tileColours) {
    for (const int tile : tiles) {
      if (tile >= static_cast<int>(own_.size())) {
        throw InputError(
            fmt::format("error: --tile-colour: there is no tile {}; the model's are numbered 0 to "
                        "{}",
                        tile, own_.size() - 1));
      }
      own_[tile] = evenShades(colour);
    }
  }
  if (kinds_.empty()) kinds_.assign(own_.size(), plainColours(look));
}

/// Fills colours and legend; kinds are in order of appearance, so a new one is always the next
/// number.
void Colourist::colourShapes() {
  const std::vector<int> kinds = shapeKinds(motif_.bricks);
  std::vector<int> counts;
  std::vector<std::string> names;
  for (std::size_t brick = 0; brick < kinds.size(); ++brick) {
    const int kind = kinds[brick];
    kinds_.push_back(shadesOf(kindColour(kind)));
    if (kind == static_cast<int>(counts.size())) {
      counts.push_back(0);
      names.push_back(shapeName(motif_.bricks[brick]));
    }
    ++counts[kind];
  }
  for (std::size_t kind = 0; kind < counts.size(); ++kind) {
    legend_.push_back(
        {kindColour(static_cast<int>(kind)),
         fmt::format("{} {}{}", counts[kind], names[kind], counts[kind] == 1 ? "" : "s")});
  }
}

/// The largest value in the states of the run; 0 before it.
double Colourist::largestOfRun() const {
  double most = 0;
  for (const Poses& poses : motif_.states) most = std::max(most, largest(values(poses)));
  return most;
}

/// What is to be expected before the run, in the scale's unit.
double Colourist::largestExpected() const {
  switch (colouring_) {
    case Colouring::TargetError:
    case Colouring::Displacement:
      // All the way to the target, or without one half of what is in sight.
      return motif_.target ? largest(brickTargetErrors(*motif_.target, motif_.bricks, motif_.start))
                           : 0.5 * diagonal(motif_.points);
    case Colouring::Rotation:
      return 90;
    case Colouring::Moment:
    case Colouring::Energy:
      return 1;
    default:
      // Exact joints stay far below this, a baseline solver's do not.
      return 1e-6 * meanEdge(motif_.bricks);
  }
}

/// One a brick, in the unit of titleOf().
std::vector<double> Colourist::values(const Poses& poses) const {
  switch (colouring_) {
    case Colouring::TargetError:
      return brickTargetErrors(*motif_.target, motif_.bricks, poses);
    case Colouring::Displacement:
      return brickDisplacements(motif_.start, poses);
    case Colouring::Rotation: {
      std::vector<double> degrees = brickRotations(motif_.start, poses);
      for (double& angle : degrees) angle /= kDegree;
      return degrees;
    }
    case Colouring::Moment:
      return brickMoments(motif_.hingeSprings, poses);
    case Colouring::Energy:
      return brickElasticEnergies(motif_.hingeSprings, poses);
    default:
      return brickJointGaps(motif_.pivots, poses);
  }
}

/// At the target counts before at the start, so that a sheet whose target is its start shows as
/// arrived.
std::vector<BrickColours> Colourist::stateColours(const Poses& poses) const {
  const double near = kArrival * meanEdge(motif_.bricks);
  const std::vector<double> moved = brickDisplacements(motif_.start, poses);
  const std::vector<double> turned = brickRotations(motif_.start, poses);
  std::vector<double> away(poses.size(), near + 1);
  if (motif_.target) away = brickTargetErrors(*motif_.target, motif_.bricks, poses);
  std::vector<BrickColours> colours;
  for (std::size_t brick = 0; brick < poses.size(); ++brick) {
    const bool atStart = moved[brick] < near && turned[brick] < kArrival;
    const Colour colour = away[brick] < near ? kAtTarget : atStart ? kAtStart : kMoving;
    colours.push_back(shadesOf(colour));
  }
  return colours;
}

std::vector<BrickColours> Colourist::colours(const Poses& poses) const {
  std::vector<BrickColours> colours;
  if (!scale_) {
    colours = colouring_ == Colouring::State ? stateColours(poses) : kinds_;
    for (std::size_t brick = 0; brick < own_.size(); ++brick) {
      colours[brick] = own_[brick].value_or(colours[brick]);
    }
    return colours;
  }
  for (const double value : values(poses)) {
    colours.push_back(evenShades(mapColour(scale_->map, shareOf(*scale_, value))));
  }
  return colours;
}

}  // namespace kirireel
