// Checks of HDF5's global heap collections, byte by byte, by the HDF5 File Format Specification,
// III.E.
//
// A collection begins with "GCOL", its version (1), 3 zero bytes and its size (8 bytes, this header
// included). Entries follow: number (2 bytes), references (2), 4 zero bytes, size (8), then the
// bytes, padded to a multiple of 8. An entry with the number 0 is the free space at the end, and
// its size counts its own header. All numbers are little-endian. A collection is whole where
// walking from entry to entry ends exactly within its size.
//
// The collections are found by their signature anywhere in the file, since only HDF5 itself knows
// the places that it will follow. A text that happens to contain the signature makes a sound file
// look damaged; none that the program writes does.
#include "sim/trajectory/text_heaps.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kirireel {
namespace {

constexpr std::string_view kSignature("GCOL\x01\0\0\0", 8);
constexpr std::uint64_t kHeader = 16;       // the signature and the heap's size
constexpr std::uint64_t kEntryHeader = 16;  // number, references, 4 bytes, size

/// An unsigned number in `size` bytes, the lowest first; 0 beyond the end of the file.
std::uint64_t numberAt(std::istream& file, std::uint64_t place, int size) {
  std::string bytes(static_cast<std::size_t>(size), '\0');
  // A stream that once reached the end refuses to seek until it is cleared.
  file.clear();
  file.seekg(static_cast<std::streamoff>(place));
  file.read(bytes.data(), size);
  std::uint64_t number = 0;
  for (int k = size; k-- > 0;) number = number << 8 | static_cast<unsigned char>(bytes[k]);
  return number;
}

/// How far it is from an entry to the next, 0 when it goes beyond `left` bytes.
std::uint64_t stepAt(std::istream& file, std::uint64_t place, std::uint64_t left) {
  const bool isFreeSpace = numberAt(file, place, 2) == 0;
  const std::uint64_t size = numberAt(file, place + 8, 8);
  if (size > left) return 0;
  const std::uint64_t step = isFreeSpace ? size : kEntryHeader + (size + 7) / 8 * 8;
  return step <= left ? step : 0;
}

// Walks the heap's entries; each must end within the heap.
bool isWhole(std::istream& file, std::uint64_t heap, std::uint64_t fileSize) {
  const std::uint64_t size = numberAt(file, heap + kSignature.size(), 8);
  if (size < kHeader || size > fileSize - heap) return false;
  // What is too short for another entry is not used.
  std::uint64_t place = kHeader;
  while (place + kEntryHeader <= size) {
    const std::uint64_t step = stepAt(file, heap + place, size - place);
    if (step == 0) return false;
    place += step;
  }
  return true;
}

/// Where heaps begin. The file is read in blocks that overlap by a signature.
std::vector<std::uint64_t> heapsIn(std::istream& file, std::uint64_t fileSize) {
  constexpr std::uint64_t kBlock = 1 << 20;
  std::vector<std::uint64_t> heaps;
  std::string block(std::min(kBlock + kSignature.size() - 1, fileSize), '\0');
  for (std::uint64_t start = 0; start < fileSize; start += kBlock) {
    file.clear();
    file.seekg(static_cast<std::streamoff>(start));
    file.read(block.data(), std::ssize(block));
    const std::string_view bytes(block.data(), static_cast<std::size_t>(file.gcount()));
    for (std::size_t at = bytes.find(kSignature); at != bytes.npos;
         at = bytes.find(kSignature, at + 1)) {
      heaps.push_back(start + at);
    }
  }
  return heaps;
}

}  // namespace

bool hasWholeTextHeaps(const std::filesystem::path& file) {
  std::ifstream stream = openInputFile(file);
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(file, error);
  if (!stream || error) return false;
  const std::vector<std::uint64_t> heaps = heapsIn(stream, size);
  return std::all_of(heaps.begin(), heaps.end(),
                     [&](std::uint64_t heap) { return isWhole(stream, heap, size); });
}

bool TextPlaces::hold(std::uint64_t heap, std::uint64_t number, std::uint64_t length) {
  const auto [known, isNew] = heaps_.try_emplace(heap);
  if (isNew) known->second = entriesOf(heap);
  const auto entry = known->second.find(number);
  return entry != known->second.end() && entry->second == length;
}

// Nothing where no heap begins at this place.
TextPlaces::Entries TextPlaces::entriesOf(std::uint64_t heap) {
  std::string beginning(kSignature.size(), '\0');
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(heap));
  file_.read(beginning.data(), std::ssize(beginning));
  if (!file_ || beginning != kSignature) return {};
  Entries entries;
  const std::uint64_t size = numberAt(file_, heap + kSignature.size(), 8);
  for (std::uint64_t place = kHeader; place + kEntryHeader <= size;) {
    const std::uint64_t number = numberAt(file_, heap + place, 2);
    const std::uint64_t bytes = numberAt(file_, heap + place + 8, 8);
    // Of two with one number neither can be meant: no text is as long as that.
    if (!entries.emplace(number, bytes).second) entries[number] = size;
    const std::uint64_t step = stepAt(file_, heap + place, size - place);
    if (step == 0) return {};
    place += step;
  }
  entries.erase(0);  // free space
  return entries;
}

}  // namespace kirireel
