/// Gaps between near bricks, with their derivatives.
#pragma once

#include <array>
#include <map>
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

 private:
  struct PiecePair {
    int brickA = 0, brickB = 0;
    std::size_t a = 0, b = 0;  // outlines
    const std::vector<contacts::SeparatingPlane>* planes = nullptr;
    double kept = 0;        // overlap at the start, metres
    std::size_t known = 0;  // plane that separated the pair at the last check
  };

  std::vector<std::size_t> addOutlines(const std::vector<brick::BrickPiece>& pieces,
                                       const std::vector<int>& withoutCorners, double length);
  void addPairs(int a, int b, const std::vector<std::size_t>& outlinesA,
                const std::vector<std::size_t>& outlinesB);
  void place(const PiecePair& pair, const Poses& poses);
  double separate(PiecePair& pair, double margin);
  void append(const PiecePair& pair, double distance, double reach, const Poses& poses,
              std::vector<NearGap>& gaps) const;

  bool planar_;
  std::vector<double> radii_;  // of the bricks, metres
  std::vector<contacts::Outline> outlines_;
  std::map<std::array<std::size_t, 4>, std::vector<contacts::SeparatingPlane>> planeLists_;
  std::vector<std::vector<PiecePair>> pairs_;  // grouped by pair of bricks
  contacts::PlacedOutline placedA_, placedB_;
};

}  // namespace kirireel::path
