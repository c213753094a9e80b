/// Gaps between near bricks, with their derivatives.
#pragma once

#include <array>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sim/brick/brick.h"
#include "sim/contacts/contact_finder.h"
#include "sim/scene/scene.h"

namespace kirireel::path {

/// One point of a brick against a plane of another. A move of both bricks changes the gap by
/// ofA . (dx_a, dphi_a) + ofB . (dx_b, dphi_b), to the first order.
struct NearGap {
  int brickA = 0;  ///< index >= 0
  int brickB = 0;  ///< index >= 0
  double gap = 0;  ///< metres, plus the overlap of the pair at the start
  Vector6 ofA;     ///< by displacement (1) and by rotation about the centre of mass (m/rad)
  Vector6 ofB;     ///< the same for brick B
};

/// Finds the gaps of bricks that may touch. For each pair of convex pieces nearer than a margin, it
/// uses the best separating plane and the points close to it. Joined bricks are compared without
/// the corners that they share (sim/brick/contact.h).
class NearGapFinder {
 public:
  /// `contacts`: which pairs may touch. `planar`: uses only the outlines in the plane. Pairs may
  /// keep the overlap that they have at `start`. Bricks are copied.
  NearGapFinder(const std::vector<brick::Brick>& bricks, std::span<const brick::Pivot> pivots,
                scene::ContactFilter contacts, double pivotZone, bool planar, const Poses& start);

  /// The gaps of pairs that are nearer than `margin` metres, in order of bricks. Each pair has the
  /// points within `reach` metres of its nearest point.
  std::vector<NearGap> find(const Poses& poses, double margin, double reach);
  /// The same for a state between two others, by the planes that separate the pairs in these two.
  /// Each of these two then has planes in common with the state. So bricks that are apart along
  /// both planes are also apart on the moves between the states (to the second order).
  std::vector<NearGap> findBetween(const std::array<Poses, 2>& ends, const Poses& poses,
                                   double margin, double reach);

 private:
  /// A convex piece of a brick, perhaps without corners.
  struct PlacedPiece {
    int brick = 0;
    contacts::Outline outline;
    Vector3 centre;                  // brick axes
    double radius = 0;               // about the centre, metres
    contacts::PlacedOutline placed;  // in the last state in which it was near another piece
    long state = 0;                  // the number of this state
  };
  struct PiecePair {
    std::size_t a = 0, b = 0;  // pieces
    const std::vector<contacts::SeparatingPlane>* planes = nullptr;
    double kept = 0;        // overlap at the start, metres
    std::size_t known = 0;  // plane that separated the pair at the last check
    std::array<std::optional<std::size_t>, 2> ofEnds;  // findBetween(): planes of near pairs
  };
  struct NearBrickPair {
    int a = 0, b = 0;
    std::vector<PiecePair> pieces;
  };

  std::vector<std::size_t> addPieces(const std::vector<brick::BrickPiece>& pieces, int brick,
                                     const std::vector<int>& withoutCorners, double length);
  void addPair(int a, int b, const std::vector<std::size_t>& piecesA,
               const std::vector<std::size_t>& piecesB);
  const contacts::PlacedOutline& place(std::size_t piece, const Poses& poses);
  bool areNear(const NearBrickPair& pair, double margin, const Poses& poses) const;
  double separate(PiecePair& pair, double margin, const Poses& poses);
  void append(const PiecePair& pair, double distance, double reach, const Poses& poses,
              std::vector<NearGap>& gaps) const;

  bool planar_;
  std::vector<double> radii_;       // of the bricks, metres
  std::deque<PlacedPiece> pieces_;  // placed outlines keep their address
  std::map<std::array<std::size_t, 4>, std::vector<contacts::SeparatingPlane>> planeLists_;
  std::vector<NearBrickPair> pairs_;
  long state_ = 0;  // number of states so far
};

}  // namespace kirireel::path
