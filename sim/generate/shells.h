/// Sheets of quads that deploy to curved surfaces. Lengths in metres, angles in radians.
///
/// Each function throws InputError when no such sheet was found, which happens for shapes that are
/// far from the usual ones.
#pragma once

#include "sim/model/model.h"

namespace kirireel {

/// A rectangular tube that becomes a slimmer, longer one: columns x rows rectangles wrapped round a
/// regular prism with as many sides as columns.
struct CylinderShape {
  int columns = 6;    ///< even, at least 4
  int rows = 6;       ///< at least 1
  double length = 2;  ///< of a tile round the tube at the start, positive
  double width = 1;   ///< of a tile along the tube at the start, positive
};
Model makeCylinder(const CylinderShape& shape);

/// A flat square that becomes a cap on a sphere.
struct CapShape {
  int size = 8;                           ///< columns and rows, even
  double radius = 3.4641016151377544;     ///< of the sphere
  double halfAngle = 0.7853981633974483;  ///< between the sphere's pole and the sides' middles
};
Model makeSphericalCap(const CapShape& shape);

/// A cube of six square sheets that becomes a sphere: six caps, joined where their tips meet in
/// both states. The angle of the shape is not used; it is pi / 4.
Model makeCubeToSphere(const CapShape& shape);

/// A flat strip that becomes a twisted band.
struct BandShape {
  int columns = 12;             ///< along the strip, even
  int rows = 2;                 ///< across, even
  int halfTwists = 1;           ///< from 0
  double radius = 3;            ///< of the band's middle line
  double angle = 1.2217304764;  ///< by which neighbours open, about
};
Model makeMoebiusBand(const BandShape& shape);

/// A cap of a sphere that becomes a saddle z = curvature (x^2 - y^2), closed in both states.
struct SaddleShape {
  int columns = 10;        ///< even
  int rows = 10;           ///< even
  double radius = 6.9;     ///< of the sphere
  double curvature = 0.4;  ///< of the saddle, 1/m
  double width = 6;        ///< of the sheet's longer side before it is lifted
};
Model makeSphereToSaddle(const SaddleShape& shape);

}  // namespace kirireel
