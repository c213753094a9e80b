/// The public header for recording runs: <kirireel/render.h> of the target kirireel::render. The
/// promise of <kirireel/sim.h> holds for these headers too.
#pragma once

#include "render/picture/frame.h"
#include "render/picture/png.h"
#include "render/picture/state_painter.h"
#include "render/record/record.h"
#include "sim/sim.h"
