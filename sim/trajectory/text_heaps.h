/// The heaps in which HDF5 files keep texts: HDF5 itself reads them without looking.
#pragma once

#include <filesystem>

namespace kirireel {

/// Whether every heap of texts in an HDF5 file (a "global heap collection", version 1; HDF5 File
/// Format Specification 3.0, III.E) is whole: it ends within the file, and its entries fill it one
/// after the other. HDF5 runs in circles through, or beyond, one that is not. Reads the whole file;
/// what cannot be read is not whole.
bool hasWholeTextHeaps(const std::filesystem::path& file);

}  // namespace kirireel
