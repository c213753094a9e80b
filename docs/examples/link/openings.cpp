// Deploys a sheet of rotating squares, prints how far it opens, and paints its end.
#include <algorithm>
#include <cstdio>
#include <exception>

#include <kirireel/render.h>

namespace {

using namespace kirireel;  // each of its modules has a namespace of its own

/// The width of the sheet along x, metres.
double width(const std::vector<model::Tile>& tiles) {
  double least = 1e300;
  double most = -1e300;
  for (const model::Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) {
      least = std::min(least, vertex.x());
      most = std::max(most, vertex.x());
    }
  }
  return most - least;
}

void openSheet(const char* picture) {
  scene::Scene scene;
  scene.model = generate::generateModel(generate::familyNamed("tessellation"), {{"columns", 6}});
  scene.brick.thickness = 0.02;
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, {});
  const Poses& end = result.trajectory.samples.back().poses;
  std::printf("%s: %zu samples, %.3f m wide at the start, %.3f m at the end\n",
              run::toString(result.outcome).c_str(), result.trajectory.samples.size(),
              width(scene.model.tiles), width(brick::bottomTiles(result.trajectory.bricks, end)));

  const picture::FrameSize size{640, 480};
  picture::StatePainter painter(size, {}, picture::makeContent(scene.model, scene.brick, {}));
  picture::writePng(painter.paint({0, end, {}}), picture);
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
