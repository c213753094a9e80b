/// The public header for deploying models: <kirireel/sim.h> of the target kirireel::sim. Within a
/// major version of the library what these headers declare stays as it is, or gains fields and
/// arguments with defaults; what is not declared here may change with every version.
#pragma once

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/deploy/deployment.h"
#include "sim/formats/read_model.h"
#include "sim/generate/families.h"
#include "sim/model/model.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/trajectory.h"
#include "sim/trajectory/trajectory_file.h"
