// Reads every file of the given folders with the linked fuzz target.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>

#include "tests/fuzz/fuzz_input.h"

namespace fs = std::filesystem;

namespace {

std::vector<fs::path> inputsIn(const fs::path& folder) {
  std::vector<fs::path> inputs;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.is_regular_file()) inputs.push_back(entry.path());
  }
  std::sort(inputs.begin(), inputs.end());
  return inputs;
}

void replay(const fs::path& input) {
  // If the process ends, the last named input is the cause.
  std::printf("%s\n", input.c_str());
  std::fflush(stdout);
  std::ifstream stream(input, std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(stream), {});
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
}

}  // namespace

int main(int argumentCount, char** arguments) {
  int count = 0;
  for (int k = 1; k < argumentCount; ++k) {
    for (const fs::path& input : inputsIn(arguments[k])) {
      replay(input);
      ++count;
    }
  }
  if (count == 0) std::fprintf(stderr, "no input was given; name folders that hold some\n");
  return count == 0 ? 1 : 0;
}
