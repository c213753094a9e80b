/// Files of named arrays with attributes: HDF5, which h5py, MATLAB and h5dump read. No HDF5 header
/// is needed to use them. Several threads may use files of their own at the same time.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/base/files.h"

namespace kirireel::trajectory {

/// The lengths of an array's dimensions, slowest first.
using Shape = std::vector<std::size_t>;

/// The number of entries of an array.
std::size_t entryCount(const Shape& shape);

/// Writes a file of arrays. Names are paths such as "model/vertices"; a group must be made before
/// its contents. Numbers are stored as IEEE doubles or 32-bit integers, little-endian, without any
/// time stamp: the same calls give the same bytes.
class ArrayWriter {
 public:
  /// Treatment of an existing file.
  enum class Opening { Replace, Extend };

  /// Creates the file, or opens a closed one for more arrays. `shownPath` is its name in messages.
  /// All functions throw OutputError if the file cannot be written.
  ArrayWriter(const std::filesystem::path& path, std::filesystem::path shownPath,
              Opening opening = Opening::Replace);
  ~ArrayWriter();
  ArrayWriter(const ArrayWriter&) = delete;
  ArrayWriter& operator=(const ArrayWriter&) = delete;

  /// A group that is made twice is an error.
  void addGroup(const std::string& name);

  /// `entries` holds entryCount(shape) numbers, the last dimension fastest.
  void write(const std::string& name, std::span<const double> entries, const Shape& shape);
  /// The same for whole numbers of 32 bits.
  void write(const std::string& name, std::span<const int> entries, const Shape& shape);
  /// A list of doubles, at least one, uncompressed and with a checksum: its attribute crc32 is
  /// computed from the bytes by zlib.
  void writeChecked(const std::string& name, std::span<const double> entries);
  /// A list of texts, UTF-8.
  void write(const std::string& name, const std::vector<std::string>& texts);

  /// Creates an array of doubles that grows along its first dimension, compressed in chunks.
  void addSeries(const std::string& name, const Shape& rowShape);
  /// Appends rows to a series. Their count follows from the row's shape. The series must exist.
  void append(const std::string& name, std::span<const double> rows);

  /// Sets an attribute of a group or an array ("/" is the file itself).
  void setAttribute(const std::string& object, const std::string& name, const std::string& text);
  /// The same for a number.
  void setAttribute(const std::string& object, const std::string& name, double number);

  /// Writes pending data and closes the file.
  void close();

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

/// Reads a file of arrays. All functions throw InputError with the file's name and the item that is
/// missing, of another type or damaged.
class ArrayReader {
 public:
  /// Opens the file. Rejects a file that is missing, truncated or of another format.
  explicit ArrayReader(std::filesystem::path path);
  ~ArrayReader();
  ArrayReader(const ArrayReader&) = delete;
  ArrayReader& operator=(const ArrayReader&) = delete;

  /// Throws an InputError with the fault and a remedy.
  [[noreturn]] void refuse(const std::string& found) const;

  /// Whether the file itself holds an array or a group of this name; links do not count.
  bool has(const std::string& name) const;
  /// Whether a group or an array has this attribute.
  bool hasAttribute(const std::string& object, const std::string& name) const;
  /// The lengths of an array, limited to what a file of this size can hold.
  Shape shape(const std::string& name) const;

  /// All entries, the last dimension fastest; the whole array is read into memory.
  std::vector<double> doubles(const std::string& name) const;
  /// A list that writeChecked() wrote.
  std::vector<double> checkedDoubles(const std::string& name) const;
  /// The whole numbers of an array of any shape. Throws InputError.
  std::vector<int> integers(const std::string& name) const;
  /// The texts of an array. Throws InputError.
  std::vector<std::string> texts(const std::string& name) const;

  /// One row of an array of doubles, index >= 0.
  std::vector<double> row(const std::string& name, std::size_t index) const;

  /// A single text, or a single number, that setAttribute() wrote.
  std::string textAttribute(const std::string& object, const std::string& name) const;
  /// A number that is an attribute. Throws InputError if there is none.
  double numberAttribute(const std::string& object, const std::string& name) const;

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

/// The version of HDF5 in use, e.g. "1.10.8".
std::string arrayLibraryVersion();

}  // namespace kirireel::trajectory
