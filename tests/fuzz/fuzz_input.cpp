#include "tests/fuzz/fuzz_input.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <system_error>

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include "sim/base/error.h"
#include "sim/base/interruption.h"

namespace kirireel::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSeparator = "%%\n";
// Largest length of a message: the file's name and a sentence or two, with short parts of the
// input.
constexpr std::size_t kLongestMessage = 1000;
// Largest CPU time of an input, under sanitizers. Wall time depends on other programs.
constexpr double kMaxSeconds = 1;

class Folder {
 public:
  Folder() {
    const fs::path memory = "/dev/shm";
    std::error_code ignored;
    const fs::path above = fs::is_directory(memory, ignored) ? memory : fs::temp_directory_path();
    std::string name = (above / "kirireel_fuzz_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

void require(bool holds, const char* claim) {
  if (holds) return;
  std::fprintf(stderr, "a reader lets through what others rely on not to meet: %s\n", claim);
  std::abort();
}

void requireMessage(const std::string& message) {
  const bool isOneLine = std::none_of(message.begin(), message.end(), [](unsigned char letter) {
    return letter < ' ' || letter == 127;
  });
  if (isOneLine && message.size() <= kLongestMessage) return;
  std::fprintf(stderr, "this is not a short line: %s\n", message.c_str());
  std::abort();
}

bool hasCorner(const std::vector<model::Tile>& tiles, const model::Corner& corner) {
  return corner.tile >= 0 && corner.tile < std::ssize(tiles) && corner.vertex >= 0 &&
         corner.vertex < std::ssize(tiles[corner.tile].vertices);
}

void requireTiles(const std::vector<model::Tile>& tiles) {
  require(!tiles.empty(), "a model without tiles");
  for (const model::Tile& tile : tiles) {
    require(tile.vertices.size() >= 3, "a tile without an inside");
    for (const Vector3& vertex : tile.vertices) {
      require(vertex.allFinite(), "a vertex at infinity");
    }
  }
}

void requireJoint(const model::Joint& joint, const std::vector<model::Tile>& tiles) {
  require(hasCorner(tiles, joint.a) && hasCorner(tiles, joint.b), "a joint of no corner");
  require(joint.a.tile != joint.b.tile, "a tile joined to itself");
  require(joint.face >= model::JointFace::Bottom && joint.face <= model::JointFace::Both,
          "a face of no name");
  require(joint.kind >= model::JointKind::Pivot && joint.kind <= model::JointKind::Fixed,
          "a kind of no name");
  require(joint.kind != model::JointKind::Link || joint.apart.norm() > 0, "a link without length");
}

}  // namespace

const fs::path& folder() {
  static const Folder folder;
  return folder.path();
}

void place(const std::string& name, std::string_view text) {
  // Mutated inputs have most parts in common, and overwriting a file is faster than a new one. This
  // is most of the cost of an execution.
  static std::map<std::string, std::string> placed;
  const auto [known, isNew] = placed.try_emplace(name, text);
  if (!isNew && known->second == text && ::access((folder() / name).c_str(), F_OK) == 0) return;
  known->second = text;
  const int file = ::open((folder() / name).c_str(), O_WRONLY | O_CREAT, 0600);
  const bool isWritten = ::write(file, text.data(), text.size()) == std::ssize(text) &&
                         ::ftruncate(file, std::ssize(text)) == 0;
  ::close(file);
  if (!isWritten) std::abort();
}

void placeParts(std::span<const char* const> names, std::string_view input) {
  std::optional<std::string_view> rest = input;
  for (const char* name : names) {
    if (!rest) {
      ::unlink((folder() / name).c_str());
      continue;
    }
    const std::size_t end = rest->find(kSeparator);
    place(name, rest->substr(0, end));
    rest = end == rest->npos ? std::nullopt : std::optional(rest->substr(end + kSeparator.size()));
  }
}

void read(const std::function<void()>& reader) {
  const double start = threadCpuSeconds();
  try {
    reader();
  } catch (const Error& error) {
    requireMessage(error.what());
  }
  const double seconds = threadCpuSeconds() - start;
  if (seconds <= kMaxSeconds) return;
  std::fprintf(stderr, "reading this takes %g s of the processor's time\n", seconds);
  std::abort();
}

void requireSound(const model::Model& model) {
  requireTiles(model.tiles);
  if (model.target) {
    requireTiles(*model.target);
    require(model.target->size() == model.tiles.size(), "a target of another size");
  }
  for (const model::Joint& joint : model.joints) requireJoint(joint, model.tiles);
  for (const int tile : model.pulledTiles.value_or(std::vector<int>())) {
    require(hasCorner(model.tiles, {tile, 0}), "a pull at no tile");
  }
  for (const model::Corner& corner : model.hull.value_or(std::vector<model::Corner>())) {
    require(hasCorner(model.tiles, corner), "a hull of no corner");
  }
}

}  // namespace kirireel::fuzz
