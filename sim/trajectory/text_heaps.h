/// The heaps in which HDF5 files keep texts: HDF5 itself reads them without looking.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>

#include "sim/base/input_file.h"

namespace kirireel {

/// Whether every heap of texts in an HDF5 file (a "global heap collection", version 1; HDF5 File
/// Format Specification 3.0, III.E) is whole: it ends within the file, and its entries fill it one
/// after the other. HDF5 runs in circles through, or beyond, one that is not. Reads the whole file;
/// what cannot be read is not whole.
bool hasWholeTextHeaps(const std::filesystem::path& file);

/// Where the texts of an HDF5 file stand, of which every heap must be whole.
class TextPlaces {
 public:
  explicit TextPlaces(const std::filesystem::path& file) : file_(openInputFile(file)) {}

  /// Whether a heap begins at this byte of the file and has one entry of this number, of just so
  /// many bytes. HDF5 reads beyond its memory where that is not so.
  bool hold(std::uint64_t heap, std::uint64_t number, std::uint64_t length);

 private:
  /// Bytes of a heap's entries by their numbers.
  using Entries = std::map<std::uint64_t, std::uint64_t>;
  Entries entriesOf(std::uint64_t heap);

  std::ifstream file_;
  std::map<std::uint64_t, Entries> heaps_;  // those that were asked for
};

}  // namespace kirireel
