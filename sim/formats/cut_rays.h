/// Straight continuations of the open ends of cuts, up to the lines that the cuts stop short of.
#pragma once

#include <limits>
#include <vector>

#include "sim/formats/arrangement.h"

namespace kirireel::formats {

/// A distance that is never reached.
inline constexpr double kNever = std::numeric_limits<double>::infinity();

/// An open end of a cut, and its straight continuation. Lengths in metres.
struct CutRay {
  int node = 0;                     ///< of the arrangement; -1 for the tip of an opening
  Vector2 from = Vector2::Zero();   ///< position of the end
  Vector2 along = Vector2::Zero();  ///< unit vector
  double straight = 0;              ///< straight length of the cut up to its end
  double hit = kNever;              ///< distance of the first line from the end
  Vector2 hitPlace = Vector2::Zero();
  int partner = -1;                     ///< the ray of the end that it runs into, opposite; or -1
  double stop = kNever;                 ///< length of the ray; kNever outside of all outlines
  Vector2 stopPlace = Vector2::Zero();  ///< the vertex of the design
  bool isRunning = true;                ///< false after traceCutRays() has set its stop
  double tip = 0;         ///< distance of the end of the removed material, where the neck begins
  bool isJoined = false;  ///< no material in between: the cuts meet
  bool isFacing = false;  ///< met its partner midway, where the vertex of the neck is

  /// Width of the neck.
  double width() const { return stop - tip; }
  /// Maximum deviation of a point at this distance from the cut's aim.
  double slack(double distance, double tolerance) const;
};

/// Finds the ray of every open end and its stop. `curveError`: deviation of straight pieces from
/// their curve, metres; 0 without curves. `tolerance`: distance of points that are one, metres.
std::vector<CutRay> traceCutRays(const Arrangement& lines, double curveError, double tolerance);

/// Finds the first line of a ray. Returns the node that it aims at there, or -1.
int findHit(CutRay& ray, const Arrangement& lines, double tolerance);

/// Distances along a line at which it crosses a border; < 0 behind its start.
std::vector<double> crossingsOf(const std::vector<PlaneSegment>& border, const Vector2& from,
                                const Vector2& along);

/// Finds the tips of the rays: the last border of removed material that they cross, or of the
/// slots, which have a width `kerf` > 0, the first one. Without a border tips are 0.
void findNeckTips(std::vector<CutRay>& rays, const std::vector<PlaneSegment>& border, double kerf,
                  double tolerance);

/// The width of the material of a neck between slots, metres: without the removed material at its
/// joint. `border`: of the material.
double neckMaterial(const CutRay& ray, const std::vector<PlaneSegment>& border, double tolerance);

/// The largest width of a neck, metres: in the longest interval without a width of a ray, below
/// half of `scale`, the size of a tile.
double widestNeck(const std::vector<CutRay>& rays, double scale);

}  // namespace kirireel::formats
