/// What Kirireel has left in a folder, so that nothing else in it is ever overwritten or removed.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "render/digest/digest.h"

namespace kirireel {

/// Files by their names, relative to their folder.
using FileList = std::map<std::string, FileDigest>;

/// The files that a sealed record in a folder lists under "contents": summary.json or
/// contents.json. Empty where there is none, or it is not as it was written. Entries whose names
/// lead out of the folder are left out.
FileList listedFiles(const std::filesystem::path& record);

/// The text of contents.json: the files, sealed.
std::string contentsText(const FileList& files);

/// The files that earlier runs, exports and renderings say they left in a folder. A record that was
/// changed since says nothing.
class LeftFiles {
 public:
  explicit LeftFiles(std::filesystem::path folder);

  /// Whether something stands under this name that is not as one of them left it: another file, a
  /// folder, a link that leads nowhere. A link to the very bytes may be replaced. Reads the file
  /// where its size agrees.
  bool isForeign(const std::string& name) const;

  /// Whether a file stands there as one of them left it, not reached through a link on the way.
  bool stands(const std::string& name) const;

  /// All that the records list; what contents.json says of a file counts more than summary.json.
  const FileList& files() const { return files_; }

 private:
  std::filesystem::path folder_;
  FileList files_;
};

/// Whether a name means a file in the folder or below it.
bool staysInside(const std::filesystem::path& name);

/// What is wrong with a file in a folder; empty when it is as noted. One line without the file's
/// name.
std::string difference(const std::filesystem::path& folder, const FileDigest& noted);

}  // namespace kirireel
