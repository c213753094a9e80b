/// Reads models and compares them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sim/formats/read_model.h"

namespace kirireel::test {

/// Reads a model with its own target, if it has one. Drops warnings.
inline model::Model read(const std::filesystem::path& path) {
  std::vector<std::string> warnings;
  return formats::readModel(path, std::nullopt, warnings);
}

/// The same vertices, bit by bit.
inline void expectSameTiles(const std::vector<model::Tile>& a, const std::vector<model::Tile>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_EQ(a[i].vertices, b[i].vertices) << "tile " << i;
}

/// The same tiles, joints, target and pulled tiles.
inline void expectSameModel(const model::Model& a, const model::Model& b) {
  expectSameTiles(a.tiles, b.tiles);
  ASSERT_EQ(a.joints.size(), b.joints.size());
  for (std::size_t i = 0; i < a.joints.size(); ++i) {
    EXPECT_EQ(a.joints[i].a, b.joints[i].a);
    EXPECT_EQ(a.joints[i].b, b.joints[i].b);
    EXPECT_EQ(a.joints[i].face, b.joints[i].face);
    EXPECT_EQ(a.joints[i].kind, b.joints[i].kind);
    EXPECT_EQ(a.joints[i].apart, b.joints[i].apart);
  }
  ASSERT_EQ(a.target.has_value(), b.target.has_value());
  if (a.target) expectSameTiles(*a.target, *b.target);
  EXPECT_EQ(a.pulledTiles, b.pulledTiles);
}

}  // namespace kirireel::test
