/// The studies that compare other engines: their rows, and figures against ours.
#pragma once

#include <vector>

#include "sim/study/stepped_scene.h"
#include "sim/study/study.h"

namespace kirireel::bench {

extern const study::Engine kChipmunk;  ///< in the plane only; no contacts
extern const study::Engine kBox2d;     ///< the same, in single precision
extern const study::Engine kMujoco;    ///< in joint coordinates; no contacts

/// The studies with rows of Chipmunk, Box2D and MuJoCo. Names and columns are those of
/// `kirireel study`; findings compare rows with those of the other study's table.
const std::vector<study::Study>& otherStudies();

/// Throws InputError if Kirireel's table is of another extent, or from another machine: times of
/// two machines do not compare.
void requireComparable(const study::Table& own, study::Extent extent);

/// The same study with the findings of its own engines, compared with our rows in `own`.
study::Study comparedWith(const study::Study& study, const study::Table& own);

}  // namespace kirireel::bench
