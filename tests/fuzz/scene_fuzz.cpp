// A scene file.
#include "sim/scene/scene_file.h"
#include "tests/fuzz/fuzz_input.h"

using namespace kirireel;

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  fuzz::place("scene.toml", fuzz::inputText(bytes, size));
  fuzz::read([] { scene::readSceneFile(fuzz::folder() / "scene.toml"); });
  return 0;
}
