/// Sheets that repeat: nodes at opposite ends that move alike but for what control nodes say.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "render/fea/deck_text.h"
#include "render/fea/element_mesh.h"

namespace kirireel {

/// Which ends of a sheet are tied to each other.
struct Periodicity {
  std::array<bool, 2> axes{};      ///< x, y
  std::array<double, 2> period{};  ///< of the axes that are tied, metres
  std::vector<PeriodicTie> ties;   ///< by rising node
};

/// The ties of a mesh along x and y, where the nodes of XMIN have partners in XMAX at the same
/// place but for the period, and likewise in y. Throws InputError for shells, and for sheets that
/// repeat along neither. Partners agree to 1e-5 of the sheet's size. Costs the product of the
/// numbers of nodes at two opposite ends.
Periodicity periodicity(const ElementMesh& mesh);

/// Appends *EQUATION for each tie; the control node of the first axis that is tied has the number
/// `firstControl`, from 0, that of the other the next. Two directions for plane elements, three for
/// solids.
void appendTies(std::string& text, const Periodicity& periodic, const ElementMesh& mesh,
                int firstControl);

/// The control nodes' positions, one for each tied axis: beside the sheet, metres.
std::vector<Vector3> controlPositions(const Periodicity& periodic, const ElementMesh& mesh);

}  // namespace kirireel
