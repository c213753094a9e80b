// PLY meshes.
#include "sim/formats/read_model.h"
#include "tests/fuzz/fuzz_input.h"

using namespace kirireel;

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  fuzz::place("sheet.ply", fuzz::inputText(bytes, size));
  fuzz::read([] {
    std::vector<std::string> warnings;
    fuzz::requireSound(formats::readModel(fuzz::folder() / "sheet.ply", std::nullopt, warnings));
  });
  return 0;
}
