#include "render/record/versions.h"

#include <Eigen/Core>
#include <fmt/format.h>

#include "render/mesh/mesh.h"
#include "render/png/png.h"
#include "render/video/video.h"
#include "sim/trajectory/array_file.h"
#include "sim/world/bullet_world.h"

namespace kirireel {

std::string programVersion() {
  return KIRIREEL_VERSION;
}

std::vector<std::pair<std::string, std::string>> allVersions() {
  return {
      {"kirireel", programVersion()},
      {"compiler", __VERSION__},
      {"eigen",
       fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
      {"bullet", bulletVersion()},
      {"hdf5", arrayLibraryVersion()},
      {"libavcodec", encoderLibraryVersion()},
      {"libpng", pngLibraryVersion()},
      {"assimp", meshLibraryVersion()},
  };
}

std::string versionText() {
  std::string text;
  for (const auto& [name, version] : allVersions()) text += fmt::format("{} {}\n", name, version);
  return text;
}

}  // namespace kirireel
