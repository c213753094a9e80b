/// Sheets with necks and bricks as closed solids for printers and CAD.
#pragma once

#include <string>
#include <vector>

#include "render/writers/flat_sheet.h"
#include "sim/base/geometry.h"
#include "sim/base/length_unit.h"
#include "sim/brick/brick.h"
#include "sim/model/model.h"

namespace kirireel::fea {

/// A sheet with necks as an ASCII STL of one closed surface, in the unit. Coordinates read back as
/// the same doubles. The two sides of a slit without kerf are separated by 1e-7 of the sheet's
/// size, which single precision can represent. `thickness` in metres. Throws like meshableOutline.
std::string neckSheetStl(const model::Model& model, const writers::NeckShape& neck,
                         double thickness, const LengthUnit& unit);

/// The same as a STEP file of one solid, in millimetres, by Gmsh's OpenCASCADE. Throws like
/// meshableOutline and stepByGmsh.
std::string neckSheetStep(const model::Model& model, const writers::NeckShape& neck,
                          double thickness);

/// Bricks at these poses as a STEP file with one solid each, in millimetres. Throws like
/// stepByGmsh.
std::string brickStep(const std::vector<brick::Brick>& bricks, const Poses& poses);

}  // namespace kirireel::fea
