/// Numbers of tiles and vertices as files and scene files have them.
#pragma once

#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/model/model.h"
#include "sim/scene/toml_file.h"

namespace kirireel {

/// A whole number from 0. Throws InputError that says what is wanted.
int readIndex(const TomlValue& value, const std::string& wanted);

/// One or more of them. Throws InputError that says what is wanted, of the list or of an element.
std::vector<int> readIndices(const TomlValue& value, const std::string& wanted,
                             const std::string& wantedElement);

/// The model's own number of a tile that has this one in the model's file. Throws InputError where
/// the model has no such tile.
int tileOfModel(int number, const Model& model, const FileLocation& where);

}  // namespace kirireel
