#include "render/export/file_set.h"

#include <system_error>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/pending_file.h"

namespace kirireel {
FileSet::FileSet(std::filesystem::path folder)
    : folder_(std::move(folder)), stage_(folder_ / "export.part") {
  makeFolder(stage_);
}

FileSet::~FileSet() {
  std::error_code ignored;
  std::filesystem::remove_all(stage_, ignored);
}

std::filesystem::path FileSet::add(const std::string& name) {
  names_.push_back(name);
  return stage_ / name;
}

std::vector<std::string> FileSet::commit() {
  for (const std::string& name : names_) {
    std::error_code error;
    std::filesystem::rename(stage_ / name, folder_ / name, error);
    if (error) {
      throw OutputError(fmt::format("{}: error: cannot be put in place ({})",
                                    (folder_ / name).string(), error.message()));
    }
  }
  return names_;
}

}  // namespace kirireel
