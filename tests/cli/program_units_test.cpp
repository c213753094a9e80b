// The same sheet in several units gives the same files for other programs.
#include <cmath>
#include <regex>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

/// Squares of 20 mm, as a model folder in a unit.
void writeSquares(const fs::path& folder, double millimetre) {
  fs::create_directories(folder);
  std::ostringstream vertices;
  vertices.precision(15);
  const double edge = 20 * millimetre;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      const double x = column * edge, y = row * edge;
      vertices << x << ' ' << y << " 0 " << x + edge << ' ' << y << " 0 " << x + edge << ' '
               << y + edge << " 0 " << x << ' ' << y + edge << " 0\n";
    }
  }
  writeText(folder / "vertices.txt", vertices.str());
  std::ostringstream joints;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      const int tile = 4 * row + column;
      const bool even = (row + column) % 2 == 0;
      if (column < 3)
        joints << tile << (even ? " 1 " : " 2 ") << tile + 1 << (even ? " 0\n" : " 3\n");
      if (row < 3) joints << tile << (even ? " 2 " : " 3 ") << tile + 4 << (even ? " 1\n" : " 0\n");
    }
  }
  writeText(folder / "constraints.txt", joints.str());
}

/// All numbers of a text; of a deck, only those of its nodes. Comments have figures of a run, and
/// rounding decides which of two equal nodes is in a set.
std::vector<double> numbersOf(std::string text) {
  std::vector<double> numbers;
  text = text.substr(0, text.find("*ELEMENT"));
  text = std::regex_replace(text, std::regex("(^|\n)\\*\\*[^\n]*"), "");
  const char* at = text.c_str();
  while (*at) {
    char* end = nullptr;
    const double number = std::strtod(at, &end);
    if (end != at) numbers.push_back(number);
    at = end == at ? at + 1 : end;
  }
  return numbers;
}

/// Two runs differ by rounding: 1e-9 of the sheet. Lengths in the texts are at most 1000.
void expectSameNumbers(const fs::path& a, const fs::path& b, double factor = 1) {
  const std::vector<double> left = numbersOf(readText(a)), right = numbersOf(readText(b));
  ASSERT_EQ(left.size(), right.size()) << a << b;
  ASSERT_GT(left.size(), 10u) << a;
  int different = 0;
  for (std::size_t k = 0; k < left.size(); ++k) {
    const double least = 1e-7 * (1 + std::abs(right[k]));
    const bool isSame = std::abs(left[k] - right[k]) < least;
    if (!isSame && !(std::abs(left[k] * factor - right[k]) < least)) ++different;
  }
  EXPECT_EQ(different, 0) << a << " and " << b;
}

struct UnitRun {
  const char* unit;
  double millimetre;  ///< in this unit
};

void PrintTo(const UnitRun& run, std::ostream* stream) {
  *stream << run.unit;
}

class Units : public testing::TestWithParam<UnitRun> {};

TEST_P(Units, LeaveFilesOfOneSize) {
  const TemporaryFolder scratch;
  const auto record = [&](const std::string& name, const std::string& unit, double millimetre) {
    writeSquares(scratch / name, millimetre);
    const ProgramEnd end =
        runKirireel({"simulate", (scratch / name).string(), "--unit", unit, "--out",
                     (scratch / "out" / name).string(), "--export",
                     "stl,svg,dxf,inp,fold,obj,planar", "--export-unit", "auto"});
    ASSERT_EQ(end.exitCode, 0) << end.err;
  };
  record("one", "m", 1e-3);
  record("other", GetParam().unit, GetParam().millimetre);
  const fs::path one = scratch / "out" / "one", other = scratch / "out" / "other";
  expectSameNumbers(one / "cut_pattern.svg", other / "cut_pattern.svg");
  expectSameNumbers(one / "cut_pattern.dxf", other / "cut_pattern.dxf");
  expectSameNumbers(one / "state_final_mesh.inp", other / "state_final_mesh.inp");
  EXPECT_EQ(fs::file_size(one / "state_final.stl"), fs::file_size(other / "state_final.stl"));
  const double factor = GetParam().millimetre * 1e3;
  expectSameNumbers(one / "final_vertices.txt", other / "final_vertices.txt", factor);
  expectSameNumbers(one / "deployment.fold", other / "deployment.fold", factor);
  EXPECT_NE(
      readText(other / "deployment.fold").find(std::string("\"frame_unit\":\"") + GetParam().unit),
      std::string::npos);
}

TEST_P(Units, AreThoseOfAFileOfTheRun) {
  const TemporaryFolder scratch;
  writeSquares(scratch / "sheet", GetParam().millimetre);
  ASSERT_EQ(runKirireel({"convert", (scratch / "sheet").string(), (scratch / "again").string(),
                         "--unit", GetParam().unit})
                .exitCode,
            0);
  // To the last digit.
  const std::string unit = GetParam().unit;
  EXPECT_EQ((unit == "m" ? "" : "# unit " + unit + "\n") + readText(scratch / "sheet/vertices.txt"),
            readText(scratch / "again/vertices.txt"));
}

INSTANTIATE_TEST_SUITE_P(All, Units,
                         testing::Values(UnitRun{"mm", 1}, UnitRun{"cm", 0.1}, UnitRun{"um", 1000},
                                         UnitRun{"in", 1 / 25.4}, UnitRun{"km", 1e-6}),
                         [](const auto& info) { return std::string(info.param.unit); });

TEST(NanometreSheets, Deploy) {
  const TemporaryFolder scratch;
  for (const char* unit : {"m", "nm"}) {
    writeSquares(scratch / unit, std::string(unit) == "m" ? 1e-9 : 1);
    const ProgramEnd end = runKirireel({"simulate", (scratch / unit).string(), "--unit", unit,
                                        "--out", (scratch / "out" / unit).string()});
    EXPECT_EQ(end.exitCode, 0) << end.err;
  }
}

}  // namespace
}  // namespace kirireel
