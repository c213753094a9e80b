// A record (summary.json, contents.json) lists files as
//
//     "contents": { "NAME": { "bytes": SIZE, "sha256": "64 digits" }, ... }
//
// with names relative to its folder. A file counts as ours when its size and hash are those of a
// sealed record; the size is compared first, since it costs no reading. Names that lead out of the
// folder are ignored, so that a forged record cannot make us remove files elsewhere.
#include "render/folder/left_files.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "render/folder/output_folder.h"
#include "sim/base/error.h"
#include "sim/base/input_file.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// The text of a record; "" when it cannot be read.
std::string sealedText(const fs::path& record) {
  std::error_code ignored;
  if (!fs::is_regular_file(record, ignored)) return "";
  try {
    const std::string text = readTextFile(record, "");
    return isSealed(text) ? text : "";
  } catch (const InputError&) {
    return "";
  }
}

/// Also a link that leads nowhere, which exists() denies.
bool isThere(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(fs::symlink_status(path, ignored));
}

/// Whether a folder between the two is a link: what is beyond it is not ours to touch.
bool leadsThroughLink(const fs::path& folder, const fs::path& name) {
  std::error_code ignored;
  fs::path place = folder;
  for (const fs::path& part : name.parent_path()) {
    place /= part;
    if (fs::is_symlink(place, ignored)) return true;
  }
  return false;
}

}  // namespace

FileList listedFiles(const fs::path& record) {
  FileList files;
  const Json json = Json::parse(sealedText(record), nullptr, false);
  try {
    if (!json.is_object()) return {};
    for (const auto& [name, noted] : json.at("contents").items()) {
      if (!staysInside(name)) continue;
      files[name] = {name, noted.at("bytes").get<std::uintmax_t>(),
                     noted.at("sha256").get<std::string>()};
    }
  } catch (const Json::exception&) {
    return {};  // sealed, but no record of ours
  }
  return files;
}

std::string contentsText(const FileList& files) {
  Json contents = Json::object();
  for (const auto& [name, file] : files) {
    contents[name] = {{"bytes", file.bytes}, {"sha256", file.sha256}};
  }
  return sealed(Json{{"contents", contents}}.dump(2) + "\n");
}

LeftFiles::LeftFiles(fs::path folder) : folder_(std::move(folder)) {
  // merge() keeps what is there already, so contents.json counts more.
  for (const char* record : {output::kContents, output::kSummary}) {
    const std::string text = sealedText(folder_ / record);
    if (text.empty()) continue;
    files_.merge(listedFiles(folder_ / record));
    // The records themselves are ours, too.
    files_[record] = {record, text.size(), sha256(text)};
  }
}

bool LeftFiles::isForeign(const std::string& name) const {
  return isThere(folder_ / name) && !stands(name);
}

bool LeftFiles::stands(const std::string& name) const {
  const auto noted = files_.find(name);
  return noted != files_.end() && !leadsThroughLink(folder_, name) &&
         difference(folder_, noted->second).empty();
}

bool staysInside(const fs::path& name) {
  return !name.empty() && name.is_relative() &&
         std::none_of(name.begin(), name.end(), [](const fs::path& part) { return part == ".."; });
}

std::string difference(const fs::path& folder, const FileDigest& noted) {
  if (!staysInside(noted.name)) return "this is no name of a file in the folder";
  std::error_code ignored;
  if (!fs::is_regular_file(folder / noted.name, ignored)) return "the file is missing";
  const std::uintmax_t bytes = fs::file_size(folder / noted.name, ignored);
  if (bytes != noted.bytes)
    return fmt::format("{} bytes where the run left {}", bytes, noted.bytes);
  try {
    if (digestOf(folder, noted.name).sha256 == noted.sha256) return "";
  } catch (const InputError&) {
    return "the file cannot be read";
  }
  return "other bytes than the run left";
}

}  // namespace kirireel
