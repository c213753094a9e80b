#include "tests/bench/engines/other_rows.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/scene/scene_needs.h"
#include "tests/bench/engines/other_worlds.h"

namespace kirireel::bench {
namespace {

using study::Extent;
using study::Method;
using study::SheetMethod;

std::unique_ptr<engines::BrickWorld> chipmunkWorld(const Method& method, const scene::Scene& scene,
                                                   const std::vector<brick::Brick>& bricks,
                                                   const Poses& start) {
  return makeChipmunkWorld(bricks, start, brick::makePivots(scene.model.joints, bricks),
                           scene.environment, method.iterations);
}

// Box2D recommends 8 iterations for velocities and 3 for positions.
std::unique_ptr<engines::BrickWorld> box2dWorld(const Method& method, const scene::Scene& scene,
                                                const std::vector<brick::Brick>& bricks,
                                                const Poses& start) {
  return makeBox2dWorld(bricks, start, brick::makePivots(scene.model.joints, bricks),
                        scene.environment, method.iterations,
                        std::max(1, 3 * method.iterations / 8));
}

std::unique_ptr<engines::BrickWorld> mujocoWorld(const Method& /*method*/,
                                                 const scene::Scene& scene,
                                                 const std::vector<brick::Brick>& bricks,
                                                 const Poses& start) {
  return makeMujocoWorld(bricks, start, brick::makePivots(scene.model.joints, bricks),
                         scene.environment, scene::sceneNeeds(scene).planar.on);
}

/// With 20 substeps it oscillates in the closed state.
Method chipmunkBaseline() {
  return {kChipmunk, 240, 4, 50};
}

std::vector<SheetMethod> workPrecisionSheets(Extent extent) {
  std::vector<SheetMethod> sheets;
  for (const Method& method : study::sweepMethods(kChipmunk, extent)) {
    sheets.push_back({method, true});
  }
  return sheets;
}

std::vector<SheetMethod> movingSheets(Extent extent) {
  std::vector<SheetMethod> sheets;
  constexpr std::array kRates = {240, 960, 3840};
  for (const int side : {10, 20}) {
    if (side > 10 && extent == Extent::Quick) continue;
    for (const int rate : kRates) sheets.push_back({{kMujoco, rate}, true, side});
    for (const int rate : kRates) {
      for (const int iterations : {1, 2, 8}) {
        sheets.push_back({{kBox2d, rate, 1, iterations}, true, side});
      }
    }
    for (const int rate : kRates) sheets.push_back({{kChipmunk, rate, 1, 10}, true, side});
    for (const int rate : kRates) sheets.push_back({{kMujoco, rate}, false, side});
  }
  return sheets;
}

std::vector<SheetMethod> scalingSheets(Extent extent) {
  std::vector<SheetMethod> sheets;
  for (const int side : {5, 10, 20, 40, 100}) {
    if (side > 20 && extent == Extent::Quick) continue;
    sheets.push_back({chipmunkBaseline(), true, side});
  }
  return sheets;
}

std::vector<SheetMethod> tessellationSheets(Extent /*extent*/) {
  return {{chipmunkBaseline(), true}};
}

}  // namespace

constinit const study::Engine kChipmunk{"chipmunk", chipmunkWorld};
constinit const study::Engine kBox2d{"box2d", box2dWorld};
constinit const study::Engine kMujoco{"mujoco", mujocoWorld};

const std::vector<study::Study>& otherStudies() {
  static const std::vector<study::Study> all{
      study::workPrecisionStudy(workPrecisionSheets), study::movingStudy(movingSheets),
      study::scalingStudy(scalingSheets), study::tessellationStudy(tessellationSheets)};
  return all;
}

void requireComparable(const study::Table& own, Extent extent) {
  const std::string& name = own.caption.study;
  const std::string asked = extent == Extent::Quick ? "quick" : "full";
  const std::string remedy = fmt::format("make it again with kirireel study {}{}", name,
                                         asked == "quick" ? " --quick" : "");
  if (own.caption.extent != asked) {
    throw InputError(fmt::format("error: the table of {} is of a {} study, not of a {} one; {}",
                                 name, own.caption.extent, asked, remedy));
  }
  if (own.caption.machine == study::machineText()) return;
  throw InputError(fmt::format("error: the table of {} is from another machine: {}; {}", name,
                               own.caption.machine, remedy));
}

study::Study comparedWith(const study::Study& study, const study::Table& own) {
  study::Study compared = study;
  compared.findings = [findings = study.findings, own](const study::Table& others) {
    study::Table both = own;
    both.rows.insert(both.rows.end(), others.rows.begin(), others.rows.end());
    std::vector<study::Finding> found = findings(both);
    const std::vector<study::Finding> known = findings(own);
    std::erase_if(found, [&known](const study::Finding& finding) {
      return std::ranges::find(known, finding.name, &study::Finding::name) != known.end();
    });
    return found;
  };
  return compared;
}

}  // namespace kirireel::bench
