// A contracted OBJ file and the deployed one next to it.
#include <array>

#include "sim/formats/read_model.h"
#include "tests/fuzz/fuzz_input.h"

using namespace kirireel;

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static constexpr std::array kFiles = {"sheet_contracted.obj", "sheet_deployed.obj"};
  fuzz::placeParts(kFiles, fuzz::inputText(bytes, size));
  fuzz::read([] {
    std::vector<std::string> warnings;
    fuzz::requireSound(formats::readModel(fuzz::folder() / kFiles[0], std::nullopt, warnings));
  });
  return 0;
}
