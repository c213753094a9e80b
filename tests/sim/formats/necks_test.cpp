// Necks of joints: from drawings, and through the files that keep them.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/formats/read_model.h"
#include "tests/support/files.h"

namespace kirireel::formats {
namespace {

using test::TemporaryFolder;
using testing::HasSubstr;

/// A strip of three tiles: a slit that stops 2 mm short of the border, one that stops 3 mm short.
constexpr const char* kSlits =
    "<svg width=\"400mm\" height=\"400mm\" viewBox=\"0 0 400 400\" fill=\"none\" stroke=\"black\">"
    "<path d=\"M0 0H60V20H0ZM20 0V18M40 0V17\"/></svg>";
/// The same as slots 0.3 mm wide in a closed outline; the necks are 2 mm and 3 mm.
constexpr const char* kSlots =
    "<svg width=\"400mm\" height=\"400mm\" viewBox=\"0 0 400 400\" fill=\"none\" stroke=\"black\">"
    "<path d=\"M0 0H19.85V18H20.15V0H39.85V17H40.15V0H60V20H0Z\"/></svg>";

model::Model read(const std::filesystem::path& path, const ReadSettings& settings = {}) {
  std::vector<std::string> warnings;
  return readModel(path, std::nullopt, warnings, settings);
}

model::Model drawn(const std::string& text) {
  const TemporaryFolder folder;
  folder.write("a.svg", text);
  return read(folder.path() / "a.svg");
}

std::vector<model::Neck> necksOf(const model::Model& model) {
  std::vector<model::Neck> necks;
  for (const model::Joint& joint : model.joints) necks.push_back(joint.neck);
  std::ranges::sort(necks, {}, &model::Neck::width);
  return necks;
}

TEST(Necks, AreThoseOfTheDrawing) {
  const std::vector<model::Neck> slits = necksOf(drawn(kSlits));
  ASSERT_EQ(slits.size(), 2U);
  EXPECT_NEAR(slits[0].width, 0.002, 1e-12);
  EXPECT_NEAR(slits[1].width, 0.003, 1e-12);
  EXPECT_EQ(slits[0].length, 0);
  EXPECT_EQ(slits[0].kerf, 0);
  const std::vector<model::Neck> slots = necksOf(drawn(kSlots));
  ASSERT_EQ(slots.size(), 2U);
  for (int k = 0; k < 2; ++k) {
    EXPECT_NEAR(slots[k].width - slots[k].kerf / 2, 0.002 + 0.001 * k, 1e-5) << k;
    EXPECT_NEAR(slots[k].kerf, 0.0003, 1e-6) << k;
    EXPECT_EQ(slots[k].length, slots[k].kerf) << k;
  }
}

/// A slot wider than its neck at the border.
constexpr const char* kWideSlot =
    "<svg width=\"60mm\" height=\"20mm\" viewBox=\"0 0 60 20\" fill=\"none\" stroke=\"black\">"
    "<path d=\"M0 0H29.5V19.6H30.5V0H60V20H0Z\"/></svg>";

TEST(Necks, ComeBackFromFoldersAndFoldFiles) {
  for (const char* text : {kSlits, kSlots, kWideSlot}) {
    const model::Model model = drawn(text);
    const TemporaryFolder folder;
    writeModel(model, folder.path() / "sheet.fold");
    EXPECT_EQ(necksOf(read(folder.path() / "sheet.fold")), necksOf(model));
    writeModel(model, folder.path() / "sheet");
    EXPECT_EQ(necksOf(read(folder.path() / "sheet")), necksOf(model));
    // Another list of joints has no necks.
    std::filesystem::copy(folder.path() / "sheet" / "constraints.txt",
                          folder.path() / "sheet" / "others.txt");
    ReadSettings settings;
    settings.jointsFile = "others.txt";
    for (const model::Neck& neck : necksOf(read(folder.path() / "sheet", settings)))
      EXPECT_FALSE(neck);
  }
}

TEST(Necks, OfFilesAreChecked) {
  const auto refusal = [](const std::string& necks) {
    const TemporaryFolder folder;
    folder.write("vertices.txt", "0 0 0 1 0 0 1 1 0 0 1 0\n1 0 0 2 0 0 2 1 0 1 1 0\n");
    folder.write("constraints.txt", "0 1 1 0 3\n");
    folder.write("necks.txt", necks);
    try {
      read(folder.path());
    } catch (const InputError& error) {
      return std::string(error.what()).substr(folder.path().string().size());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refusal("# a comment\n0 0.1 0.02 0.01\n"), "accepted");
  EXPECT_EQ(refusal("0 0.1\n"),
            "/necks.txt:1: error: a neck does not have 2 numbers; write one neck per line, \"joint "
            "width length kerf\". Joints are rows of constraints.txt, from 0");
  EXPECT_EQ(refusal("1 0.1 0 0\n"),
            "/necks.txt:1: error: a neck names joint 1, but there are joints 0-0; correct the "
            "number");
  EXPECT_EQ(refusal("0 0 0 0\n"),
            "/necks.txt:1: error: the neck of joint 0 is 0 wide and 0 long, its kerf 0; a width is "
            "> half the kerf, a kerf >= 0 and a length at least the kerf: correct them");
  EXPECT_THAT(refusal("0 0.1 0.1 0.2\n"), HasSubstr("0.1 wide and 0.1 long, its kerf 0.2"));
  EXPECT_EQ(refusal("0 0.1 0 0\n0 0.1 0 0\n"),
            "/necks.txt:2: error: joint 0 has two necks; delete one of them");
  EXPECT_THAT(refusal("0 a 0 0\n"), HasSubstr("necks.txt:1:3: error"));
}

TEST(Necks, ScaleWithTheModel) {
  model::Model model = drawn(kSlots);
  const std::vector<model::Neck> before = necksOf(model);
  model::scaleLengths(model, 8);
  for (std::size_t k = 0; k < before.size(); ++k) {
    EXPECT_EQ(necksOf(model)[k].width, 8 * before[k].width);
    EXPECT_EQ(necksOf(model)[k].length, 8 * before[k].length);
    EXPECT_EQ(necksOf(model)[k].kerf, 8 * before[k].kerf);
  }
}

}  // namespace
}  // namespace kirireel::formats
