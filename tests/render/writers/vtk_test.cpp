#include "render/writers/vtk.h"

#include <numbers>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/files.h"
#include "sim/generate/lattice.h"
#include "tests/support/files.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// A triangle, a square and a pentagon, the square moved by 1 m along z and turned by 0.5.
struct State {
  trajectory::Subject subject;
  Poses start;
  trajectory::Sample sample;

  State() {
    subject.model.tiles.resize(3);
    for (int k = 0; k < 3; ++k) {
      for (int corner = 0; corner < 3 + k; ++corner) {
        const double angle = 2 * std::numbers::pi * corner / (3 + k);
        subject.model.tiles[k].vertices.emplace_back(std::cos(angle) + 2.5 * k, std::sin(angle), 0);
      }
    }
    subject.model.joints = {{{0, 0}, {1, 2}}};
    subject.model.target = subject.model.tiles;
    subject.bricks = brick::makeBricks(subject.model.tiles, brick::BrickRule{});
    start = brick::startPoses(subject.model.tiles, subject.bricks);
    sample.time = 0.25;
    sample.jointGap = 1e-12;
    sample.poses = start;
    sample.poses[1].position.z() += 1;
    sample.poses[1].rotation = rotationFromVector({0, 0, 0.5});
  }

  std::string text() const { return writers::vtuText(subject, start, sample); }
};

/// The numbers of an array, unpacked by Python's own library if they are compressed.
std::vector<double> arrayOf(const std::string& text, const std::string& name) {
  const std::size_t start = text.find("Name=\"" + name);
  const std::size_t begin = text.find('>', start) + 1;
  const std::string card = text.substr(text.rfind('<', start), begin - text.rfind('<', start));
  std::string content = text.substr(begin, text.find("</DataArray>", begin) - begin);
  if (card.find("binary") != std::string::npos) {
    content = test::outputOf(fmt::format(
        "python3 -c \"import base64, struct, zlib; t = '{}'; h = base64.b64decode(t[:44]); "
        "n = struct.unpack('<4Q', h); b = zlib.decompress(base64.b64decode(t[44:])); "
        "assert n[0] == 1 and n[1] == len(b) and n[2] == 0; "
        "print(*[repr(v[0]) for v in struct.iter_unpack('<{}', b)])\"",
        content.substr(1, content.find('\n', 1) - 1),
        card.find("Int32") != std::string::npos ? "i" : "d"));
  }
  std::istringstream stream(content);
  std::vector<double> numbers;
  for (std::string word; stream >> word;) numbers.push_back(std::stod(word));
  return numbers;
}

TEST(Vtu, HasEveryCornerToTheLastBit) {
  const State state;
  const std::vector<double> points = arrayOf(state.text(), "points");
  std::size_t next = 0;
  for (std::size_t t = 0; t < 3; ++t) {
    for (const auto* face : {&state.subject.bricks[t].bottom, &state.subject.bricks[t].top}) {
      for (const Vector3& corner : *face) {
        const Vector3 expected = state.sample.poses[t].apply(corner);
        EXPECT_EQ(Vector3(points[next], points[next + 1], points[next + 2]), expected);
        next += 3;
      }
    }
  }
  EXPECT_EQ(next, points.size());
}

TEST(Vtu, HasTheMeasures) {
  const State state;
  const std::string text = state.text();
  EXPECT_EQ(arrayOf(text, "TimeValue"), std::vector<double>{0.25});
  EXPECT_EQ(arrayOf(text, "tile"), (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(arrayOf(text, "types"), (std::vector<double>{13, 12, 42}));  // wedge, hexahedron, other
  const std::vector<double> turns = arrayOf(text, "turn");
  EXPECT_NEAR(turns[1], 0.5, 1e-12);
  EXPECT_EQ(turns[0], 0);
  const std::vector<double> gaps = arrayOf(text, "joint_gap\" NumberOfComponents=\"1\"");
  EXPECT_GT(gaps[0], 1);
  EXPECT_EQ(gaps[0], gaps[1]);
  EXPECT_EQ(gaps[2], 0);
  const std::vector<double> distances = arrayOf(text, "target_distance");
  const std::vector<double> moves = arrayOf(text, "displacement");
  ASSERT_EQ(3 * distances.size(), moves.size());
  // Vertex 0 of the square: up by 1, and a chord of the unit circle.
  EXPECT_NEAR(distances[6], std::hypot(1, 2 * std::sin(0.25)), 1e-14);  // measured: 0
  EXPECT_EQ(moves[0], 0);
}

TEST(Vtu, OmitsAbsentParts) {
  State state;
  state.subject.model.target.reset();
  EXPECT_THAT(state.text(), Not(HasSubstr("target")));
}

TEST(Vtu, IsReadByVtk) {
  const std::string python = "/usr/bin/python3";
  if (test::outputOf(python + " -c 'import vtkmodules.vtkIOXML; print(1)'").empty()) {
    GTEST_SKIP() << "install python3-vtk9 to check VTK files with it";
  }
  const test::TemporaryFolder folder;
  const State state;
  writeTextFile(folder / "x.vtu", state.text());
  writeTextFile(folder / "read.py",
                "import sys\n"
                "from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader\n"
                "from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter\n"
                "r = vtkXMLUnstructuredGridReader()\n"
                "r.SetFileName(sys.argv[1])\n"
                "s = vtkCellSizeFilter()\n"
                "s.SetInputConnection(r.GetOutputPort())\n"
                "s.Update()\n"
                "o = s.GetOutput()\n"
                "v = o.GetCellData().GetArray('Volume')\n"
                "print(o.GetNumberOfCells(), o.GetNumberOfPoints())\n"
                "print(*[repr(v.GetValue(k)) for k in range(3)])\n"
                "print(o.GetFieldData().GetArray('TimeValue').GetValue(0))\n");
  std::istringstream read(test::outputOf(python + " '" + (folder / "read.py").string() + "' '" +
                                         (folder / "x.vtu").string() + "'"));
  int cells = 0;
  int points = 0;
  read >> cells >> points;
  EXPECT_EQ(cells, 3);
  EXPECT_EQ(points, 24);
  for (const brick::Brick& brick : state.subject.bricks) {
    double volume = 0;
    read >> volume;
    EXPECT_NEAR(volume / brick.volume, 1, 1e-12);
  }
  double time = 0;
  read >> time;
  EXPECT_EQ(time, 0.25);
}

TEST(Pvd, ListsFilesByTime) {
  EXPECT_THAT(writers::pvdText({{0, "state_0000.vtu"}, {0.5, "state_0030.vtu"}}),
              HasSubstr("<DataSet timestep=\"0\" part=\"0\" file=\"state_0000.vtu\"/>\n"
                        "<DataSet timestep=\"0.5\" part=\"0\" file=\"state_0030.vtu\"/>\n"));
}

}  // namespace
}  // namespace kirireel
