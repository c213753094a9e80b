/// Where a page's viewers may stand, by the same fit as our pictures.
#pragma once

#include "render/page/packed_array.h"
#include "render/studio/studio.h"

namespace kirireel {

/// A list of {"name", "key", "fits": [{"aspect", "eye", "centre", "up", "orthographic",
/// "field_of_view", "view_height"}, ...]}: first the view of the look, as pictures have it, then
/// others. Of a view's fits, narrowest first, the page takes the widest that its canvas holds.
/// Aspect is width by height. Costs five fits a view, each a look at all points of the motif.
Json camerasJson(const Look& look, const Motif& motif);

}  // namespace kirireel
