#include "render/sweep/input_digest.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "render/digest/digest.h"
#include "sim/base/error.h"
#include "sim/base/input_file.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

std::string contentOf(const fs::path& file) {
  std::ifstream stream = openInputFile(file);
  std::string content{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) throw inputErrorAt({file}, "cannot be read; check its permissions");
  return content;
}

/// "square_contracted.obj" starts with "square"; a name without '_' stands alone.
std::string commonStart(const fs::path& file) {
  const std::string stem = file.stem().string();
  const std::size_t end = stem.rfind('_');
  return end == std::string::npos ? "" : stem.substr(0, end + 1);
}

std::vector<fs::path> filesOf(const fs::path& path) {
  if (!fs::is_directory(path) && commonStart(path).empty()) return {path};
  const fs::path folder = fs::is_directory(path) ? path : fs::absolute(path).parent_path();
  const std::string start = fs::is_directory(path) ? "" : commonStart(path);
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const bool isMeant = entry.path().filename().string().starts_with(start);
    if (entry.is_regular_file() && isMeant) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

void InputDigest::add(std::string_view text) {
  // The length tells "ab", "c" from "a", "bc".
  texts_ += fmt::format("{}:{}", text.size(), text);
}

std::string InputDigest::take() {
  return sha256(std::exchange(texts_, {}));
}

std::string digestOfFiles(const fs::path& path) {
  if (!fs::exists(path)) {
    throw inputErrorAt({path}, "there is no such file or folder; correct the name");
  }
  InputDigest digest;
  digest.add(path.filename().string());
  for (const fs::path& file : filesOf(path)) {
    digest.add(file.filename().string());
    digest.add(contentOf(file));
  }
  return digest.take();
}

}  // namespace kirireel
