// Deploys a sheet of rotating squares, prints how far it opens, and paints its end.
#include <algorithm>
#include <cstdio>
#include <exception>

#include <kirireel/render.h>

namespace {

/// The width of the sheet along x, metres.
double width(const std::vector<kirireel::Tile>& tiles) {
  double least = 1e300;
  double most = -1e300;
  for (const kirireel::Tile& tile : tiles) {
    for (const kirireel::Vector3& vertex : tile.vertices) {
      least = std::min(least, vertex.x());
      most = std::max(most, vertex.x());
    }
  }
  return most - least;
}

void openSheet(const char* picture) {
  kirireel::Scene scene;
  scene.model = kirireel::generateModel(kirireel::familyNamed("tessellation"), {{"columns", 6}});
  scene.brick.thickness = 0.02;
  const kirireel::DeploymentResult run = kirireel::deploy(scene, 1.0 / 60, {});
  const kirireel::Poses& end = run.trajectory.samples.back().poses;
  std::printf("%s: %zu samples, %.3f m wide at the start, %.3f m at the end\n",
              kirireel::toString(run.outcome).c_str(), run.trajectory.samples.size(),
              width(scene.model.tiles), width(kirireel::bottomTiles(run.trajectory.bricks, end)));

  const kirireel::FrameSize size{640, 480};
  kirireel::StatePainter painter(size, {}, kirireel::makeContent(scene.model, scene.brick, {}));
  kirireel::writePng(painter.paint({0, end, {}}), picture);
}

}  // namespace

int main(int argumentCount, char** arguments) {
  if (argumentCount != 2) {
    std::fprintf(stderr, "use: openings PICTURE.png\n");
    return 2;
  }
  try {
    openSheet(arguments[1]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "openings: %s\n", error.what());
    return 1;
  }
}
