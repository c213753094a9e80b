// A model folder: vertices.txt, constraints.txt, and the optional files next to them.
#include <array>

#include "sim/formats/read_model.h"
#include "tests/fuzz/fuzz_input.h"

using namespace kirireel;

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static constexpr std::array kFiles = {"vertices.txt", "constraints.txt", "target.txt", "pull.txt",
                                        "hull.txt"};
  fuzz::placeParts(kFiles, fuzz::inputText(bytes, size));
  fuzz::read([] {
    std::vector<std::string> warnings;
    fuzz::requireSound(formats::readModel(fuzz::folder(), std::nullopt, warnings));
  });
  return 0;
}
