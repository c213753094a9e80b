// Numbers of tiles as people write them. An index of a file is a whole number from 0 on; whether
// the model has such a tile, and counts from 0 or from 1, is known once the model is read.
#include "sim/scene/tile_numbers.h"

#include <limits>

#include <fmt/format.h>

namespace kirireel {

// Throws InputError for anything but a whole number that an int holds, from 0.
int readIndex(const TomlValue& value, const std::string& wanted) {
  const std::int64_t* number = value.whole();
  if (!number || *number < 0 || *number > std::numeric_limits<int>::max()) {
    refuseValue(value, wanted);
  }
  return static_cast<int>(*number);
}

// An empty list is refused: elsewhere it means all tiles, which would be a surprise here.
std::vector<int> readIndices(const TomlValue& value, const std::string& wanted,
                             const std::string& wantedElement) {
  const std::vector<TomlValue>* array = value.array();
  if (!array || array->empty()) refuseValue(value, wanted);
  std::vector<int> numbers;
  for (const TomlValue& element : *array) numbers.push_back(readIndex(element, wantedElement));
  return numbers;
}

// Throws InputError where the model has no such tile, with the numbers that it has.
int tileOfModel(int number, const Model& model, const FileLocation& where) {
  const int first = model.fileOrder.countsFrom;
  const int end = first + static_cast<int>(model.tiles.size());
  if (number >= first && number < end) return number - first;
  throw inputErrorAt(where, fmt::format("the model has tiles {}-{}, not {}; correct this number",
                                        first, end - 1, number));
}

}  // namespace kirireel
