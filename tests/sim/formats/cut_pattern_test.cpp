// Cut patterns of other programs as models: drawings with known designs.
#include "sim/formats/cut_pattern.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/formats/geos_plane.h"
#include "sim/formats/middle_lines.h"
#include "sim/formats/opening_tips.h"
#include "sim/formats/read_model.h"
#include "sim/generate/families.h"
#include "tests/support/files.h"

namespace kirireel::formats {
namespace {

using test::TemporaryFolder;
using testing::HasSubstr;
using Point = Eigen::Vector2d;
using Line = std::pair<Point, Point>;

struct Reading {
  model::Model model;
  std::string note;
  std::string refusal;
};

Reading read(const std::string& name, const std::string& text, const ReadSettings& settings = {}) {
  const TemporaryFolder folder;
  folder.write(name, text);
  Reading reading;
  std::vector<std::string> warnings;
  try {
    reading.model = readModel(folder.path() / name, std::nullopt, warnings, settings);
  } catch (const InputError& error) {
    reading.refusal = error.what();
  }
  for (const std::string& one : warnings) reading.note += one + "\n";
  return reading;
}

/// A page in millimetres.
std::string page(const std::string& content) {
  return "<svg width=\"400mm\" height=\"400mm\" viewBox=\"0 0 400 400\" fill=\"none\" "
         "stroke=\"black\">" +
         content + "</svg>";
}

std::string path(const Point& from, const Point& to, int digits = 17,
                 const std::string& style = "") {
  return fmt::format("<path {}d=\"M{:.{}f} {:.{}f}L{:.{}f} {:.{}f}\"/>\n", style, from.x(), digits,
                     from.y(), digits, to.x(), digits, to.y(), digits);
}

std::string closedPath(const std::vector<Point>& points, int digits = 9) {
  std::string d;
  for (const Point& p : points)
    d += fmt::format("{}{:.{}f} {:.{}f}", d.empty() ? "M" : "L", p.x(), digits, p.y(), digits);
  return "<path d=\"" + d + "Z\"/>\n";
}

/// Rotating squares, n x n of 20 mm: at each corner the cuts along one direction pass, and those
/// along the other end one neck before them.
struct SlitGrid {
  int n = 4;
  std::vector<Line> slits;
  std::vector<Point> joints;

  SlitGrid(int count, const std::function<double()>& neck) : n(count) {
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) {
        if (i < n && j > 0 && j < n) add({i, j}, {i + 1, j}, (i + j) % 2 == 1, neck());
        if (j < n && i > 0 && i < n) add({i, j}, {i, j + 1}, (i + j) % 2 == 0, neck());
      }
    }
  }
  void add(const Point& a, const Point& b, bool isShortAtFirst, double neck) {
    const Point along = (b - a).normalized();
    Line slit(20 * a, 20 * b);
    joints.push_back(isShortAtFirst ? slit.first : slit.second);
    if (isShortAtFirst) {
      slit.first += neck * along;
    } else {
      slit.second -= neck * along;
    }
    slits.push_back(slit);
  }
  std::vector<Point> outline() const {
    const double side = 20.0 * n;
    return {{0, 0}, {side, 0}, {side, side}, {0, side}};
  }
};

/// Corners of joints and areas of tiles are those of the grid, within a tolerance in millimetres.
void expectGrid(const Reading& reading, const SlitGrid& grid, const Eigen::Affine2d& move,
                double tolerance) {
  ASSERT_EQ(reading.refusal, "");
  const model::Model& model = reading.model;
  EXPECT_EQ(std::ssize(model.tiles), grid.n * grid.n);
  ASSERT_EQ(model.joints.size(), grid.joints.size());
  for (const model::Tile& tile : model.tiles) {
    EXPECT_EQ(tile.vertices.size(), 4U);
    EXPECT_NEAR(1e6 * model::tileArea(tile), 400, 40 * tolerance);
  }
  for (const model::Joint& joint : model.joints) {
    const Vector3& a = model.tiles[joint.a.tile].vertices[joint.a.vertex];
    EXPECT_EQ(a, model.tiles[joint.b.tile].vertices[joint.b.vertex]);
    EXPECT_EQ(joint.face, model::JointFace::Both);
    double nearest = 1e9;
    for (const Point& expected : grid.joints) {
      const Point place = move * expected;
      nearest = std::min(nearest, (Point(1e3 * a.x(), -1e3 * a.y()) - place).norm());
    }
    EXPECT_LE(nearest, tolerance);
  }
}

TEST(CutPatterns, SlitGridsComeBackAtAnyAngleAndRounding) {
  std::mt19937 random(1);
  for (const int digits : {2, 3, 6, 15}) {
    for (const int n : {2, 3, 4, 7}) {
      std::uniform_real_distribution<double> width(0.1, 1.6);  // 0.5 to 8 % of a tile
      const SlitGrid grid(n, [&] { return width(random); });
      Eigen::Affine2d move(Eigen::Translation2d(150, 100) *
                           Eigen::Rotation2Dd(digits == 15 ? 0.0 : 0.3 * n));
      std::string lines;
      for (const auto& [a, b] : grid.slits) lines += path(move * a, move * b, digits);
      const std::vector<Point> outline = grid.outline();
      for (int k = 0; k < 4; ++k)
        lines += path(move * outline[k], move * outline[(k + 1) % 4], digits);
      SCOPED_TRACE(fmt::format("{} digits, {} x {}", digits, n, n));
      expectGrid(read("a.svg", page(lines)), grid, move,
                 2 * std::pow(10.0, -digits) + 1e-6 * 20 * n * std::sqrt(2.0));
    }
  }
}

TEST(CutPatterns, SlitGridsInDxfComeBack) {
  const SlitGrid grid(4, [] { return 0.7; });
  std::string text =
      "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n";
  for (const auto& [a, b] : grid.slits) {
    text += fmt::format("0\nLINE\n8\nCUT\n10\n{}\n20\n{}\n11\n{}\n21\n{}\n", a.x(), -a.y(), b.x(),
                        -b.y());
  }
  text += "0\nLWPOLYLINE\n8\nOUT\n90\n4\n70\n1\n";
  for (const Point& p : grid.outline()) text += fmt::format("10\n{}\n20\n{}\n", p.x(), -p.y());
  const Reading reading = read("a.dxf", text + "0\nENDSEC\n0\nEOF\n");
  expectGrid(reading, grid, Eigen::Affine2d::Identity(), 1e-9);
  EXPECT_THAT(reading.note,
              HasSubstr("slits: 16 tiles and 24 hinges, necks 0.7 mm, sheet 80 x 80 mm"));
}

/// A slot whose round ends have so many pieces. 2: pointed, 1: square.
std::vector<Point> stadium(const Line& line, double width, int pieces) {
  const Point along = (line.second - line.first).normalized();
  const Point left(-along.y(), along.x());
  std::vector<Point> points;
  for (const int side : {1, -1}) {
    const Point& end = side == 1 ? line.second : line.first;
    for (int k = 0; k <= pieces; ++k) {
      const double angle = std::numbers::pi * (k / static_cast<double>(pieces) - 0.5);
      points.push_back(end + 0.5 * width *
                                 (side * std::cos(angle) * along + side * std::sin(angle) * left));
    }
  }
  return points;
}

TEST(CutPatterns, SlotsComeBackWithinTheirWidth) {
  std::mt19937 random(2);
  for (const int pieces : {1, 2, 8, 20}) {
    for (const double kerf : {0.05, 0.2, 0.5}) {
      std::uniform_real_distribution<double> width(2.5 * kerf, 2.5 * kerf + 0.5);
      const SlitGrid grid(4, [&] { return width(random); });
      const Eigen::Affine2d move(Eigen::Translation2d(150, 100) * Eigen::Rotation2Dd(0.4));
      std::vector<Point> outline = grid.outline();
      for (Point& p : outline) p = move * p;
      std::string text = closedPath(outline);
      for (const auto& [a, b] : grid.slits) {
        text += closedPath(stadium({move * a, move * b}, kerf, pieces));
      }
      SCOPED_TRACE(fmt::format("{} pieces, kerf {}", pieces, kerf));
      const Reading reading = read("a.svg", page(text));
      expectGrid(reading, grid, move, 1e-6);
      EXPECT_THAT(reading.note, HasSubstr(fmt::format("slots {:.4g} mm", kerf)));
    }
  }
}

// Rounding closes, opens and bends slots that are about as narrow as the last digit.
TEST(CutPatterns, SlotsMayBeAsNarrowAsTheLastDigit) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> angle(0, 6);
  const SlitGrid grid(4, [] { return 1.2; });
  for (const int digits : {1, 2, 3}) {
    const double digit = std::pow(10.0, -digits);
    for (const double kerf : {0.1, 1 / 3.0, 0.6, 1.0, 1.5, 2.0, 3.0, 5.4}) {
      for (const int pieces : {1, 8}) {
        const Eigen::Affine2d move(Eigen::Translation2d(150, 100) *
                                   Eigen::Rotation2Dd(angle(random)));
        std::vector<Point> outline = grid.outline();
        for (Point& p : outline) p = move * p;
        std::string text = closedPath(outline, digits);
        for (const auto& [a, b] : grid.slits) {
          text += closedPath(stadium({move * a, move * b}, kerf * digit, pieces), digits);
        }
        SCOPED_TRACE(
            fmt::format("{} digits, slots of {:.2g} digits, {} pieces", digits, kerf, pieces));
        const Reading reading = read("a.svg", page(text));
        EXPECT_EQ(reading.refusal, "");
        EXPECT_EQ(reading.model.tiles.size(), 16U);
        EXPECT_EQ(reading.model.joints.size(), grid.joints.size());
        double worst = 0;
        for (const model::Joint& joint : reading.model.joints) {
          const Vector3& at = reading.model.tiles[joint.a.tile].vertices[joint.a.vertex];
          double nearest = 1e9;
          for (const Point& place : grid.joints) {
            nearest = std::min(nearest, (Point(1e3 * at.x(), -1e3 * at.y()) - move * place).norm());
          }
          worst = std::max(worst, nearest);
        }
        EXPECT_LE(worst, std::max(2.0, kerf) * digit);  // measured 1.9
      }
    }
  }
}

// A slot continues from the corner at which an edge of the outline ends. Rounding moves both.
TEST(CutPatterns, SlotsContinueFromEdgesOfTheOutline) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0, 1);
  for (int k = 0; k < 1000; ++k) {
    const std::vector<Point> outline = {{-80, -40}, {0, -40}, {0, 0}, {80, 12 + 16 * share(random)},
                                        {80, 80},   {-80, 80}};
    // It leaves a neck of 0.5 mm at the upper side.
    const std::vector<Point> slot = {{-0.05, 0}, {0.05, 0}, {0.05, 79.5}, {-0.05, 79.5}};
    const Point corner(150 + share(random), 150 + share(random));
    const Eigen::Affine2d move(Eigen::Translation2d(corner) *
                               Eigen::Rotation2Dd(2 * std::numbers::pi * share(random)));
    std::string text;
    for (std::vector<Point> points : {outline, slot}) {
      for (Point& p : points) p = move * p;
      text += closedPath(points, 2);
    }
    const Reading reading = read("a.svg", page(text));
    EXPECT_EQ(reading.refusal, "") << k;
    EXPECT_EQ(reading.model.tiles.size(), 2U) << k;
    EXPECT_EQ(reading.model.joints.size(), 1U) << k;
  }
}

// Slots that are a few digits wide, on a grid of whole millimetres, keep their width and position.
// This holds for long and short ones.
TEST(CutPatterns, SlotsOfWholeNumbersKeepTheirWidth) {
  for (const int digits : {0, 1, 3}) {
    for (const int neck : {5, 7}) {
      const SlitGrid grid(4, [&] { return neck; });
      std::string text = closedPath(grid.outline(), digits);
      for (const Line& slit : grid.slits) text += closedPath(stadium(slit, 2, 1), digits);
      SCOPED_TRACE(fmt::format("necks of {} mm, {} digits", neck, digits));
      const Reading reading = read("a.svg", page(text));
      expectGrid(reading, grid, Eigen::Affine2d::Identity(), 1e-6);
      EXPECT_THAT(reading.note, HasSubstr("slots 2 mm"));
    }
  }
}

/// A closed sheet of tiles with whole common edges, as slots that stop short of its joints.
std::string slotsOf(const model::Model& model, double kerf, const Eigen::Affine2d& move,
                    const std::function<double()>& neck) {
  const auto at = [&](int tile, std::size_t k) {
    const std::vector<Vector3>& corners = model.tiles[tile].vertices;
    return Point(corners[k % corners.size()].head<2>());
  };
  std::string text;
  for (int i = 0; i < std::ssize(model.tiles); ++i) {
    for (std::size_t k = 0; k < model.tiles[i].vertices.size(); ++k) {
      Point ends[2] = {at(i, k), at(i, k + 1)};
      int neighbour = -1;
      for (int j = 0; j < std::ssize(model.tiles); ++j) {
        for (std::size_t m = 0; m < model.tiles[j].vertices.size(); ++m) {
          const double apart = (at(j, m) - ends[1]).norm() + (at(j, m + 1) - ends[0]).norm();
          if (j != i && apart < 1e-9) neighbour = j;
        }
      }
      if (neighbour < 0) text += path(move * ends[0], move * ends[1], 6);
      if (neighbour <= i) continue;
      const Point along = (move * ends[1] - move * ends[0]).normalized();
      Line slot(move * ends[0], move * ends[1]);
      for (const model::Joint& joint : model.joints) {
        if (std::minmax(joint.a.tile, joint.b.tile) != std::minmax(i, neighbour)) continue;
        const Point place = at(joint.a.tile, joint.a.vertex);
        if ((place - ends[0]).norm() < 1e-9) slot.first += (neck() + kerf) * along;
        if ((place - ends[1]).norm() < 1e-9) slot.second -= (neck() + kerf) * along;
      }
      text += closedPath(stadium(slot, kerf, 8), 6);
    }
  }
  return text;
}

TEST(CutPatterns, SlotsOfFamiliesComeBack) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> angle(0, 6), kerf(0.05, 0.4), neck(0.1, 1.5);
  for (const char* family : {"triangles", "hexagons", "tessellation", "quads"}) {
    const model::Model drawn = generate::generateModel(generate::familyNamed(family), {});
    for (int trial = 0; trial < 15; ++trial) {
      const Eigen::Affine2d move(Eigen::Translation2d(150, 150) *
                                 Eigen::Rotation2Dd(angle(random)) *
                                 Eigen::Scaling(20 / model::tileSize(drawn)));
      const std::string text = slotsOf(drawn, kerf(random), move, [&] { return neck(random); });
      const Reading reading = read("a.svg", page(text));
      SCOPED_TRACE(fmt::format("{} {}", family, trial));
      EXPECT_EQ(reading.refusal, "");
      EXPECT_EQ(reading.model.tiles.size(), drawn.tiles.size());
      EXPECT_EQ(reading.model.joints.size(), drawn.joints.size());
    }
  }
}

// Two slots stop short of others by less than their widths.
TEST(CutPatterns, SlotsThatOverlapHaveNoNeck) {
  int number = 0;
  const SlitGrid grid(4, [&] {
    ++number;
    return number == 5 || number == 14 ? 0.9 : 2.5;
  });
  std::string text = closedPath(grid.outline());
  for (const Line& slit : grid.slits) text += closedPath(stadium(slit, 1, 8));
  const Reading reading = read("a.svg", page(text));
  EXPECT_EQ(reading.model.tiles.size(), 16U) << reading.refusal;
  EXPECT_EQ(reading.model.joints.size(), 22U);
  EXPECT_THAT(reading.note, HasSubstr("2 x neck without material, as slots overlap (one at ("));
}

// The same in sheared sheets, where a slot's rounded end leaves material on one side only.
TEST(CutPatterns, ObliqueSlotsThatOverlapAreNamed) {
  int number = 0;
  const SlitGrid grid(4, [&] {
    ++number;
    return number == 5 || number == 14 ? 0.9 : 3.0;
  });
  for (const double shear : {-0.8, 0.4, 0.8}) {
    Eigen::Affine2d move(Eigen::Translation2d(100, 50));
    move.linear() << 1, shear, 0, 1;
    std::vector<Point> outline = grid.outline();
    for (Point& p : outline) p = move * p;
    std::string text = closedPath(outline);
    for (const auto& [a, b] : grid.slits) text += closedPath(stadium({move * a, move * b}, 1, 8));
    SCOPED_TRACE(shear);
    const Reading reading = read("a.svg", page(text));
    EXPECT_EQ(reading.model.tiles.size(), 16U) << reading.refusal;
    EXPECT_EQ(reading.model.joints.size(), 22U);
    EXPECT_THAT(reading.note, HasSubstr("2 x neck without material, as slots overlap (one at ("));
  }
}

// Slots of 0.1 mm, four of which meet at one point at acute angles. Four others stop 4 mm short of
// it. The centre lines of acute slots end away from the point.
TEST(CutPatterns, NecksAimAtThePointWhereSlotsMeet) {
  const Point centre(100, 100);
  std::string text = closedPath({{50, 50}, {150, 50}, {150, 150}, {50, 150}});
  for (const auto& [degrees, isThrough] : {std::pair(0.0, true),
                                           {30, true},
                                           {180, true},
                                           {210, true},
                                           {15, false},
                                           {105, false},
                                           {195, false},
                                           {285, false}}) {
    const double angle = degrees * std::numbers::pi / 180;
    const Point along(std::cos(angle), std::sin(angle));
    const double border = 50 / along.cwiseAbs().maxCoeff();
    text += closedPath(stadium({centre + (isThrough ? 0 : 4) * along,
                                centre + (isThrough ? border - 2 : border + 1) * along},
                               0.1, 8));
  }
  const Reading reading = read("a.svg", page(text));
  EXPECT_EQ(reading.model.tiles.size(), 8U) << reading.refusal;
  EXPECT_EQ(reading.model.joints.size(), 8U);
  int atCentre = 0;
  for (const model::Joint& joint : reading.model.joints) {
    const Vector3& at = reading.model.tiles[joint.a.tile].vertices[joint.a.vertex];
    atCentre += (Point(1e3 * at.x(), -1e3 * at.y()) - centre).norm() < 1e-3;  // measured 0
  }
  EXPECT_EQ(atCentre, 4);
}

TEST(CutPatterns, SlotsMayBeHalfATileWide) {
  for (const double kerf : {3.0, 5.0, 8.0, 10.0}) {
    for (const double angle : {0.0, 0.7}) {
      const SlitGrid grid(4, [&] { return 0.5 * kerf + 1; });
      const Eigen::Affine2d move(Eigen::Translation2d(150, 100) * Eigen::Rotation2Dd(angle));
      std::vector<Point> outline = grid.outline();
      for (Point& p : outline) p = move * p;
      std::string text = closedPath(outline);
      for (const auto& [a, b] : grid.slits)
        text += closedPath(stadium({move * a, move * b}, kerf, 1));
      SCOPED_TRACE(fmt::format("slots of {} mm, {} radians", kerf, angle));
      expectGrid(read("a.svg", page(text)), grid, move, 1e-6);
    }
  }
}

// A relief at a neck of the border, wider than deep, is not a slot: the joint stays on the border.
TEST(CutPatterns, NotchesOfTheOutlineAreNotSlots) {
  const double kerf = 0.5;
  for (const double depth : {0.5 * kerf, 0.9 * kerf}) {
    const SlitGrid grid(4, [] { return 1.5; });
    std::vector<Point> outline;
    for (int k = 0; k < 4; ++k) {
      const Point from = grid.outline()[k], to = grid.outline()[(k + 1) % 4];
      const Point along = (to - from).normalized(), inwards(-along.y(), along.x());
      outline.push_back(from);
      for (int part = 1; part < grid.n; ++part) {
        const Point at = from + 20 * part * along;
        const bool isJoint = std::ranges::any_of(
            grid.joints, [&](const Point& joint) { return (joint - at).norm() < 1e-9; });
        if (!isJoint) continue;
        for (const auto& [x, y] : {std::pair(-0.5, 0.0), {-0.5, 1.0}, {0.5, 1.0}, {0.5, 0.0}}) {
          outline.emplace_back(at + x * kerf * along + y * depth * inwards);
        }
      }
    }
    ASSERT_GT(outline.size(), 4U);
    std::string text = closedPath(outline);
    for (const Line& slit : grid.slits) text += closedPath(stadium(slit, kerf, 1));
    SCOPED_TRACE(depth);
    const Reading reading =
        read("a.svg", page("<g transform=\"translate(100,100)\">" + text + "</g>"));
    expectGrid(reading, grid, Eigen::Affine2d(Eigen::Translation2d(100, 100)), 1e-6);
  }
}

/// The same grid with slots of 0.3 mm, of which those at the border are drawn in another way.
TEST(CutPatterns, SlotsAndOpenLinesAreOneSheet) {
  const SlitGrid grid(4, [] { return 1.15; });
  const Eigen::Affine2d move(Eigen::Translation2d(100, 100));
  std::vector<Point> outline = grid.outline();
  for (Point& p : outline) p = move * p;
  for (const std::string style : {"slits", "three sides", "all but one closed"}) {
    SCOPED_TRACE(style);
    std::string text = closedPath(outline) + "<path d=\"M107 107v4h3\"/>";
    bool isFirst = true;
    for (const auto& [from, to] : grid.slits) {
      Point a = move * from, b = move * to;
      const auto isAtBorder = [&](const Point& p) {
        return (p.array() == 100).any() || (p.array() == 180).any();
      };
      if (isAtBorder(b)) std::swap(a, b);
      const std::vector<Point> slot = stadium({a, b}, 0.3, 8);
      const bool isOpen = isAtBorder(a) && (isFirst || style != "all but one closed");
      if (!isOpen) {
        text += closedPath(slot);
      } else if (style == "three sides") {
        const Point left = 0.15 * Point(a.y() - b.y(), b.x() - a.x()).normalized();
        text += fmt::format("<path d=\"M{} {}L{} {} {} {} {} {}\"/>", (a + left).x(),
                            (a + left).y(), (b + left).x(), (b + left).y(), (b - left).x(),
                            (b - left).y(), (a - left).x(), (a - left).y());
      } else {
        text += path(a, b);
      }
      isFirst &= !isOpen;
    }
    const Reading reading = read("a.svg", page(text));
    expectGrid(reading, grid, move, 1e-6);
    EXPECT_THAT(reading.note, HasSubstr("slots 0.3 mm"));
    EXPECT_THAT(reading.note, HasSubstr("2 x cut that ends within a tile"));
  }
}

// Each side is a separate line: the long sides of a slot are not a doubled line.
TEST(CutPatterns, SidesOfSlotsMayBeSeparateLines) {
  const SlitGrid grid(4, [] { return 1.0; });
  for (const bool areMouthsOpen : {false, true}) {
    std::string text = closedPath(grid.outline());
    for (const auto& [from, to] : grid.slits) {
      const bool isAtBorder = (from.array() == 0).any() || (from.array() == 80).any();
      const std::vector<Point> slot = stadium({from, to}, 0.2, 1);
      for (std::size_t k = 0; k < slot.size(); ++k) {
        if (k + 2 == slot.size() && areMouthsOpen && isAtBorder) continue;  // the end at the border
        text += path(slot[k], slot[(k + 1) % slot.size()]);
      }
    }
    SCOPED_TRACE(areMouthsOpen);
    const Reading reading =
        read("a.svg", page("<g transform=\"translate(100,100)\">" + text + "</g>"));
    expectGrid(reading, grid, Eigen::Affine2d(Eigen::Translation2d(100, 100)), 1e-6);
    EXPECT_THAT(reading.note, HasSubstr("slots 0.2 mm"));
  }
}

TEST(CutPatterns, ParallelLinesAreOneCut) {
  const SlitGrid grid(4, [] { return 1.0; });
  for (const double apart : {0.004, 0.1, 0.3}) {
    std::string text = closedPath(grid.outline());
    for (const auto& [a, b] : grid.slits) {
      const Point side = 0.5 * apart * Point(a.y() - b.y(), b.x() - a.x()).normalized();
      text += path(a + side, b + side) + path(b - side, a - side);
    }
    SCOPED_TRACE(apart);
    const Reading reading =
        read("a.svg", page("<g transform=\"translate(100,100)\">" + text + "</g>"));
    expectGrid(reading, grid, Eigen::Affine2d(Eigen::Translation2d(100, 100)), 1e-6);
    EXPECT_THAT(reading.note,
                HasSubstr(fmt::format("24 cuts drawn as two lines up to {:.4g} mm apart", apart)));
  }
}

// Rounding to 0.1 of a point (0.035 mm) moves ends off their lines by more than 1e-4 of the sheet.
TEST(CutPatterns, CoordinatesMayHaveOneDecimal) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> neck(1, 2), angle(0, 6);
  for (int trial = 0; trial < 12; ++trial) {
    const double width = neck(random);
    const SlitGrid grid(4, [&] { return width; });
    const Eigen::Affine2d move(Eigen::Translation2d(700, 700) * Eigen::Rotation2Dd(angle(random)) *
                               Eigen::Scaling(72 / 25.4));
    std::string d;
    const auto add = [&](char letter, const Point& p) {
      const Point q = move * p;
      d += fmt::format("{}{:.1f} {:.1f}", letter, q.x(), q.y());
    };
    for (const auto& [a, b] : grid.slits) {
      add('M', a);
      add('L', b);
    }
    for (int k = 0; k < 4; ++k) add(k ? 'L' : 'M', grid.outline()[k]);
    const Reading reading =
        read("a.svg",
             "<svg width=\"1400pt\" height=\"1400pt\" viewBox=\"0 0 1400 1400\" "
             "fill=\"none\" stroke=\"black\"><path d=\"" +
                 d + "Z\"/></svg>");
    SCOPED_TRACE(trial);
    // Two roundings of 0.025 mm.
    expectGrid(reading, grid, Eigen::Scaling(25.4 / 72) * move, 0.1);
  }
}

// The size of the page defines lengths, in any unit of the coordinates.
TEST(CutPatterns, OptionsDoNotScaleDrawingsWithAUnit) {
  const LengthUnit inch = *findLengthUnit("in");
  const auto square = [](const std::string& size, double side) {
    return fmt::format("<svg {} viewBox=\"0 0 {} {}\"><rect width=\"{}\" height=\"{}\"/></svg>",
                       size, 2 * side, 2 * side, side, side);
  };
  const auto mils = [](int unit) {
    return fmt::format(
        "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n{}\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n"
        "0\nLWPOLYLINE\n8\n0\n70\n1\n10\n0\n20\n0\n10\n40\n20\n0\n10\n40\n20\n40\n10\n0\n20\n"
        "40\n0\nENDSEC\n0\nEOF\n",
        unit);
  };
  struct Case {
    std::string name, text;
    double side;    // metres
    double inches;  // the same with `unit = in`
  };
  const std::vector<Case> cases = {
      // Pixels and other numbers on a page of 80 mm.
      {"a.svg", square("width=\"80mm\" height=\"80mm\"", 40 * 96 / 25.4), 0.04, 0.04},
      {"a.svg", square("width=\"80mm\" height=\"100%\"", 333), 0.04, 0.04},
      {"a.svg", square("width=\"8CM\" height=\"8CM\"", 100), 0.04, 0.04},
      {"a.svg", square("width=\"80px\" height=\"80px\"", 40), 40 * 0.0254 / 96, 40 * 0.0254},
      {"a.svg", square("", 40), 40 * 0.0254 / 96, 40 * 0.0254},
      {"a.dxf", mils(9), 40 * 2.54e-5, 40 * 2.54e-5},
      {"a.dxf", mils(0), 0.04, 40 * 0.0254}};
  for (const Case& one : cases) {
    SCOPED_TRACE(one.text);
    const Reading plain = read(one.name, one.text),
                  given = read(one.name, one.text, {.unit = inch});
    ASSERT_EQ(plain.model.tiles.size(), 1U) << plain.refusal;
    // Measured: 2.3e-13.
    EXPECT_NEAR(model::tileSize(plain.model) / one.side, 1, 1e-12);
    EXPECT_NEAR(model::tileSize(given.model) / one.inches, 1, 1e-12);
    EXPECT_EQ(given.model.unit, inch);
    const bool hasUnit = one.side == one.inches;
    EXPECT_EQ(plain.note.find("`unit` sets another") == std::string::npos, hasUnit) << plain.note;
    EXPECT_THAT(given.note, testing::Not(HasSubstr("`unit` sets another")));
  }
}

/// A hexagon of six triangles, joined at its corners or at its middle.
TEST(CutPatterns, CutsThatAimAtOnePointEndThere) {
  const auto corner = [](int k) {
    const double angle = k * std::numbers::pi / 3;
    return Point(100 + 30 * std::cos(angle), 100 + 30 * std::sin(angle));
  };
  const Point middle(100, 100);
  std::vector<Point> outline;
  for (int k = 0; k < 6; ++k) outline.push_back(corner(k));
  for (const bool isAtMiddle : {false, true}) {
    std::string text = closedPath(outline);
    for (int k = 0; k < 6; ++k) {
      const Point end = isAtMiddle ? middle : corner(k), other = isAtMiddle ? corner(k) : middle;
      const double neck = 0.5 + 0.2 * k;  // all different
      text += path(other, end + neck * (other - end).normalized(), 6);
    }
    const Reading reading = read("a.svg", page(text));
    ASSERT_EQ(reading.refusal, "");
    EXPECT_EQ(reading.model.tiles.size(), 6U);
    EXPECT_EQ(reading.model.joints.size(), 6U);
    for (const model::Tile& tile : reading.model.tiles) EXPECT_EQ(tile.vertices.size(), 3U);
    for (const model::Joint& joint : reading.model.joints) {
      const Vector3& at = reading.model.tiles[joint.a.tile].vertices[joint.a.vertex];
      const double off = (Point(1e3 * at.x(), -1e3 * at.y()) - middle).norm();
      EXPECT_NEAR(off, isAtMiddle ? 0 : 30, 2e-5);
    }
  }
}

/// The grid of 4 x 4 with necks of 1 mm, and more lines.
std::string gridWith(const std::string& more, const std::string& cutStyle = "stroke=\"black\"") {
  const SlitGrid grid(4, [] { return 1.0; });
  std::string lines = fmt::format("<g {}>", cutStyle) + closedPath(grid.outline());
  for (const auto& [a, b] : grid.slits) lines += path(a, b, 9);
  return page("<g transform=\"translate(100 100)\">" + lines + "</g>" + more + "</g>");
}

void expectPlainGrid(const Reading& reading, const std::string& part) {
  expectGrid(reading, SlitGrid(4, [] { return 1.0; }),
             Eigen::Affine2d(Eigen::Translation2d(100, 100)), 1e-6);
  EXPECT_THAT(reading.note, HasSubstr(part));
}

TEST(CutPatterns, OtherLinesAreRecognised) {
  const SlitGrid grid(4, [] { return 1.0; });
  std::string marks = "<g stroke=\"lime\">";
  for (std::size_t k = 0; k < grid.slits.size(); ++k) {
    const auto& [a, b] = grid.slits[k];
    const Point& joint = grid.joints[k];
    marks += path((a - joint).norm() < (b - joint).norm() ? a : b, joint, 9);
  }
  expectPlainGrid(read("a.svg", gridWith(marks + "</g>")), "24 #00ff00 (hinge mark)");
  const std::string arrow = "<path stroke=\"blue\" d=\"M5 5L15 15M15 15L10 14\"/>";
  expectPlainGrid(read("a.svg", gridWith(arrow)), "2 #0000ff (engraved)");
  expectPlainGrid(read("a.svg", gridWith("<path stroke-dasharray=\"1\" d=\"M0 0L80 80\"/>")),
                  "1 #000000, dashed (hinge mark)");
  expectPlainGrid(read("a.svg", gridWith("<text>name</text>")), "left out: 1 x text");
  expectPlainGrid(
      read("a.svg", gridWith("<rect x=\"-20\" y=\"-20\" width=\"120\" height=\"120\"/>")),
      "1 x frame around the sheet");
  expectPlainGrid(read("a.svg", gridWith("<path d=\"M-10 -12V-8M-12 -10H-8\"/>")),
                  "2 x line outside the sheet");
  expectPlainGrid(read("a.svg", gridWith("<circle cx=\"-10\" cy=\"-10\" r=\"2\"/>")),
                  "1 x outline without cuts");
  expectPlainGrid(read("a.svg", gridWith("<circle cx=\"10\" cy=\"10\" r=\"2\"/>")),
                  "1 x hole in a tile");
  expectPlainGrid(read("a.svg", gridWith("<path d=\"M20 80V83\"/>")),
                  "1 x end of a cut beyond the border");
  // The same cut twice.
  expectPlainGrid(read("a.svg", gridWith("<path d=\"M20 80V61\"/><path d=\"M20 59V45\"/>")),
                  "16 tiles and 24 hinges");
}

// The last digit of a part that is drawn to half its size is half as large.
TEST(CutPatterns, PartsOfADrawingMayBeScaled) {
  const SlitGrid grid(4, [] { return 1.0; });
  std::string lines;
  for (const auto& [a, b] : grid.slits) lines += path(a, b, 1);
  for (int k = 0; k < 4; ++k) {
    for (int part = 0; part < 4; ++part) {
      const Point a = grid.outline()[k], step = 0.25 * (grid.outline()[(k + 1) % 4] - a);
      lines += path(a + part * step, a + (part + 1) * step, 0);
    }
  }
  for (const double scale : {0.5, 0.3, 0.05}) {
    const Reading reading = read(
        "a.svg",
        page(lines + fmt::format("<g transform=\"translate(100)scale({})\">{}</g>", scale, lines)));
    EXPECT_EQ(reading.model.tiles.size(), 32U) << scale << reading.refusal << reading.note;
    EXPECT_EQ(reading.model.joints.size(), 48U) << scale;
  }
}

TEST(CutPatterns, RegistrationMarksAreOmitted) {
  expectPlainGrid(read("a.svg", gridWith("<path d=\"M-5 -5H-3M-4 -6V-4\"/>"
                                         "<circle cx=\"-4\" cy=\"-4\" r=\"1\"/>")),
                  "3 x line outside the sheet");
  // The same within the frame of a page.
  expectPlainGrid(read("a.svg", gridWith("<path d=\"M-5 -5H-3M-4 -6V-4\"/>"
                                         "<circle cx=\"-4\" cy=\"-4\" r=\"1\"/>"
                                         "<rect x=\"-9\" y=\"-9\" width=\"99\" height=\"99\"/>")),
                  "1 x frame around the sheet, 3 x line outside the sheet");
}

TEST(CutPatterns, FilledShapesAreSlotsIfTheSheetHasNoOthers) {
  const SlitGrid grid(4, [] { return 1.0; });
  std::string slots;
  for (const Line& slit : grid.slits) slots += closedPath(stadium(slit, 0.2, 1));
  const Reading reading =
      read("a.svg", page("<g transform=\"translate(100 100)\">" + closedPath(grid.outline()) +
                         "<g fill=\"black\" stroke=\"none\">" + slots + "</g></g>"));
  expectGrid(reading, grid, Eigen::Affine2d(Eigen::Translation2d(100, 100)), 1e-6);
  expectPlainGrid(
      read("a.svg", gridWith("<rect x=\"5\" y=\"5\" width=\"3\" height=\"0.2\" fill=\"red\" "
                             "stroke=\"none\"/>")),
      "1 x shape without a stroke");
}

TEST(CutPatterns, DashedCutsAreCutsIfTheSheetHasNoOthers) {
  const SlitGrid grid(4, [] { return 1.0; });
  std::string cuts, marks;
  for (std::size_t k = 0; k < grid.slits.size(); ++k) {
    const auto& [a, b] = grid.slits[k];
    cuts += path(a, b, 9, "stroke-dasharray=\"1,0.2\" ");
    const Point end = (a - grid.joints[k]).norm() < (b - grid.joints[k]).norm() ? a : b;
    marks += path(end, grid.joints[k], 9, "stroke-dasharray=\"0.1\" ");
  }
  const auto moved = [](const std::string& lines) {
    return page("<g transform=\"translate(100 100)\">" + lines + "</g>");
  };
  expectPlainGrid(read("a.svg", moved(closedPath(grid.outline()) + cuts)),
                  "24 #000000, dashed (cut)");
  expectPlainGrid(read("a.svg", gridWith(marks)), "dashed (hinge mark)");
}

TEST(CutPatterns, EngravingMayCrossCuts) {
  const std::string circle = "<circle cx=\"40\" cy=\"40\" r=\"15\"/>";
  const std::string line = "<path d=\"M-5 3L85 11\"/>";
  expectPlainGrid(read("a.svg", gridWith("<g id=\"Engrave\">" + circle + "</g>")), "(engraved)");
  expectPlainGrid(read("a.svg", gridWith("<g id=\"Engraving\">" + line + "</g>")), "(engraved)");
  expectPlainGrid(read("a.svg", gridWith("<g stroke=\"blue\">" + circle + "</g>")),
                  "#0000ff (engraved)");
}

TEST(CutPatterns, FaultsNameWhatIsNotApplied) {
  EXPECT_THAT(
      read("a.svg", gridWith("<g clip-path=\"url(#c)\"><path d=\"M70 20H100\"/></g>")).refusal,
      HasSubstr("(1 x clip-path, which is not applied)"));
}

TEST(CutPatterns, OptionsChooseLines) {
  const std::string text = gridWith("<path stroke=\"red\" id=\"Fold\" d=\"M0 0L80 80\"/>");
  EXPECT_THAT(read("a.svg", text).note, testing::Not(HasSubstr("16 tiles and 24 hinges,")));
  for (const char* name : {"red", "#F00", "rgb(255,0,0)", "fold"}) {
    ReadSettings settings;
    settings.ignore = {name};
    expectPlainGrid(read("a.svg", text, settings), "1 x line that was not chosen");
  }
  ReadSettings settings;
  settings.cut = {"black"};
  expectPlainGrid(read("a.svg", text, settings), "1 x line that was not chosen");
  settings.cut = {"green"};
  EXPECT_THAT(read("a.svg", text, settings).refusal,
              HasSubstr("a.svg: error: no line has the colour, layer or id 'green' of `cut`. "
                        "Available: #000000, #ff0000"));
  EXPECT_THAT(read("a.obj", "v 0 0 0\n", settings).refusal,
              HasSubstr("`cut` is only for drawings (.svg, .dxf). Remove it"));
}

TEST(CutPatterns, CirclesRelieveTheEndsOfSlits) {
  const SlitGrid grid(4, [] { return 2.0; });
  std::string text = closedPath(grid.outline()), circles;
  for (std::size_t k = 0; k < grid.slits.size(); ++k) {
    const auto& [a, b] = grid.slits[k];
    text += path(a, b, 9);
    const Point end = (a - grid.joints[k]).norm() < (b - grid.joints[k]).norm() ? a : b;
    // Around the end, or with the end on its near side.
    const Point centre = k % 2 ? end : Point(end + 0.5 * (grid.joints[k] - end).normalized());
    circles += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"0.5\"/>", centre.x(), centre.y());
  }
  for (const char* colour : {"black", "blue"}) {
    SCOPED_TRACE(colour);
    const Reading reading =
        read("a.svg", page(fmt::format("<g transform=\"translate(100,100)\">{}<g stroke=\"{}\">{}"
                                       "</g></g>",
                                       text, colour, circles)));
    expectGrid(reading, grid, Eigen::Affine2d(Eigen::Translation2d(100, 100)), 1e-6);
    EXPECT_THAT(reading.note, HasSubstr("necks 1 to 1.50"));
    EXPECT_THAT(reading.note, HasSubstr("24 x relief at the end of a slit"));
  }
}

/// An open sheet as the outlines of its material: tiles of 20 mm, with a square of neck at each
/// joint.
std::string openSheet(const model::Model& model, double neck) {
  const double scale = 20 / model::tileSize(model);
  std::vector<PlaneRing> parts;
  for (const model::Tile& tile : model.tiles) {
    PlaneRing& ring = parts.emplace_back();
    for (const Vector3& vertex : tile.vertices) ring.push_back(scale * vertex.head<2>());
  }
  for (const model::Joint& joint : model.joints) {
    const Point at = scale * model.tiles[joint.a.tile].vertices[joint.a.vertex].head<2>();
    const double half = neck / 2;
    parts.push_back({at + Point(half, half), at + Point(-half, half), at + Point(-half, -half),
                     at + Point(half, -half)});
  }
  GeosPlane plane;
  std::string text;
  for (const PlaneRing& ring : plane.rings(plane.united(parts))) text += closedPath(ring, 5);
  return "<g transform=\"translate(200 200)\">" + text + "</g>";
}

// Openings with parallel sides as wide as tiles are not slots.
TEST(CutPatterns, OpenSheetsComeBack) {
  for (const auto& [family, angle] :
       {std::pair("tessellation", 25.0), {"tessellation", 65.0}, {"fan", 25.0}}) {
    SCOPED_TRACE(fmt::format("{} {}", family, angle));
    const model::Model drawn =
        generate::generateModel(generate::familyNamed(family), {{"start-angle", angle}});
    const Reading reading = read("a.svg", page(openSheet(drawn, 0.4)));
    EXPECT_EQ(reading.refusal, "");
    EXPECT_EQ(reading.model.tiles.size(), drawn.tiles.size());
    EXPECT_EQ(reading.model.joints.size(), drawn.joints.size());
  }
}

TEST(CutPatterns, WithoutHingesNameTheOptions) {
  EXPECT_THAT(read("a.svg", page("<rect x=\"10\" y=\"10\" width=\"80\" height=\"80\"/>"
                                 "<circle cx=\"50\" cy=\"50\" r=\"20\"/>"))
                  .note,
              HasSubstr("1 tile and 0 hinges (to find more, set `neck_width`, or `cut` and "
                        "`ignore`)"));
}

// Ellipses at the corners of 4 x 4 squares of 20 mm, alternately along x and y. Tips stop short of
// the sides of other ellipses. Those on the border end inside it at one tip.
TEST(CutPatterns, EllipsesHaveTips) {
  for (const auto& [length, width] : {std::pair(15.0, 4.0), {12.0, 6.5}}) {
    std::string text = "<rect x=\"10\" y=\"10\" width=\"80\" height=\"80\"/>";
    for (int i = 0; i <= 4; ++i) {
      for (int j = 0; j <= 4; ++j) {
        const bool isBesideX = i % 4 == 0, isBesideY = j % 4 == 0, isAlongX = (i + j) % 2 == 1;
        if ((isBesideX && isBesideY) || (isBesideX && !isAlongX) || (isBesideY && isAlongX)) {
          continue;
        }
        text += fmt::format("<ellipse cx=\"{}\" cy=\"{}\" rx=\"{}\" ry=\"{}\"/>", 10 + 20 * i,
                            10 + 20 * j, isAlongX ? length : width, isAlongX ? width : length);
      }
    }
    const Reading reading = read("a.svg", page(text));
    EXPECT_EQ(reading.model.tiles.size(), 10U) << reading.refusal;
    EXPECT_EQ(reading.model.joints.size(), 18U);
    EXPECT_THAT(reading.note, HasSubstr(fmt::format("necks {:.3g}", 20 - length - width)));
  }
}

// The hinges are cut in dashes, in the colour of the cuts. The joint is at the line that the dashes
// lead to.
TEST(CutPatterns, HingesMayBeCutInDashes) {
  const SlitGrid grid(4, [] { return 2.0; });
  for (const int dashes : {1, 2, 4}) {
    std::string text = closedPath(grid.outline());
    for (std::size_t k = 0; k < grid.slits.size(); ++k) {
      const auto& [a, b] = grid.slits[k];
      text += path(a, b);
      const Point& joint = grid.joints[k];
      const Point end = (a - joint).norm() < (b - joint).norm() ? a : b;
      for (int dash = 1; dash <= dashes; ++dash) {
        const auto at = [&](double place) {
          return Point(end + place / (dashes + 1) * (joint - end));
        };
        text += path(at(dash - 0.2), at(dash + 0.2));
      }
    }
    SCOPED_TRACE(dashes);
    expectGrid(read("a.svg", page(text)), grid, Eigen::Affine2d::Identity(), 1e-9);
  }
}

TEST(CutPatterns, CurvedOutlinesAndCuts) {
  // A disk in four quarters, joined at its rim; one in two halves along an S.
  const Reading quarters =
      read("a.svg",
           page("<circle cx=\"50\" cy=\"50\" r=\"40\"/><path d=\"M50 50V11M50 50V89M50 50H11M50 "
                "50H89\"/>"));
  EXPECT_EQ(quarters.refusal, "");
  EXPECT_EQ(quarters.model.tiles.size(), 4U);
  EXPECT_EQ(quarters.model.joints.size(), 4U);
  for (const model::Tile& tile : quarters.model.tiles) {
    EXPECT_NEAR(1e6 * model::tileArea(tile), 400 * std::numbers::pi, 1);  // measured 0.7
  }
  const Reading halves =
      read("a.svg", page("<circle cx=\"50\" cy=\"50\" r=\"40\"/><path d=\"M10 50A20 "
                         "20 0 0 1 50 50A20 20 0 0 0 89.875 52.2331\"/>"));
  EXPECT_EQ(halves.refusal, "");
  EXPECT_EQ(halves.model.tiles.size(), 2U);
  EXPECT_EQ(halves.model.joints.size(), 1U);
}

/// The largest depth of a corner of one tile inside another one.
double deepestCorner(const model::Model& model) {
  double deepest = 0;
  for (const model::Tile& tile : model.tiles) {
    for (const model::Tile& other : model.tiles) {
      if (&tile == &other) continue;
      std::vector<Point> ring;
      for (const Vector3& vertex : other.vertices) ring.emplace_back(vertex.head<2>());
      for (const Vector3& vertex : tile.vertices) {
        const Point point = vertex.head<2>();
        if (!isWithinRing(ring, point)) continue;
        double nearest = 1e9;
        for (std::size_t k = 0; k < ring.size(); ++k) {
          nearest = std::min(nearest, distanceTo({ring[k], ring[(k + 1) % ring.size()]}, point));
        }
        deepest = std::max(deepest, nearest);
      }
    }
  }
  return deepest;
}

TEST(CutPatterns, TilesShareTheCornersOfCurves) {
  const SlitGrid grid(4, [] { return 1.2; });
  std::string text = closedPath(grid.outline());
  for (const auto& [a, b] : grid.slits) {
    const Point side = 0.15 * Point(a.y() - b.y(), b.x() - a.x());
    const Point first = a + (b - a) / 3 + side, second = b + (a - b) / 3 - side;
    text += fmt::format("<path d=\"M{} {}C{} {} {} {} {} {}\"/>", a.x(), a.y(), first.x(),
                        first.y(), second.x(), second.y(), b.x(), b.y());
  }
  const Reading reading = read("a.svg", page(text));
  EXPECT_EQ(reading.model.joints.size(), 24U) << reading.refusal;
  EXPECT_LE(deepestCorner(reading.model), 1e-12);  // metres; measured: 0
}

TEST(CutPatterns, SeveralSheetsAreOneModel) {
  const std::string one = "<path d=\"M0 0H40V20H0ZM20 0V19\"/>";
  const Reading reading =
      read("a.svg", page(one + "<g transform=\"translate(0 50)\">" + one + "</g>"));
  EXPECT_EQ(reading.model.tiles.size(), 4U);
  EXPECT_EQ(reading.model.joints.size(), 2U);
}

TEST(CutPatterns, SheetsThatCannotOpenInTheirPlaneHaveBallJoints) {
  // Three triangles round a triangular hole: a truss. One neck less is a chain.
  const auto ring = [](const char* last) {
    return page(fmt::format(
        "<path d=\"M0 0L40 0L20 35ZM14 8H26L20 18ZM14 8L1 0.57M26 8L39 0.57M20 18V{}\"/>", last));
  };
  const Reading truss = read("a.svg", ring("34"));
  ASSERT_EQ(truss.model.joints.size(), 3U) << truss.refusal;
  for (const model::Joint& joint : truss.model.joints)
    EXPECT_EQ(joint.face, model::JointFace::Bottom);
  EXPECT_THAT(truss.note, HasSubstr("no motion in its plane, so its hinges are ball joints"));
  const Reading chain = read("a.svg", ring("35"));
  ASSERT_EQ(chain.model.joints.size(), 2U) << chain.refusal;
  for (const model::Joint& joint : chain.model.joints)
    EXPECT_EQ(joint.face, model::JointFace::Both);
}

TEST(CutPatterns, JointsMayBeInTheMiddleOfTheirNecks) {
  ReadSettings settings;
  settings.areJointsInNecks = true;
  const std::string text = page("<path d=\"M0 0H40V20H0ZM20 0V18\"/>");
  for (const bool isInNeck : {false, true}) {
    settings.areJointsInNecks = isInNeck;
    const Reading reading = read("a.svg", text, settings);
    ASSERT_EQ(reading.model.joints.size(), 1U) << reading.refusal;
    const model::Corner& corner = reading.model.joints[0].a;
    const Vector3& at = reading.model.tiles[corner.tile].vertices[corner.vertex];
    EXPECT_NEAR(at.x(), 0.020, 1e-12);
    EXPECT_NEAR(at.y(), isInNeck ? -0.019 : -0.020, 1e-12);
  }
}

TEST(CutPatterns, TheWidestNeckMayBeGiven) {
  // Two slits, one 2 mm and one 9 mm short of the border.
  const std::string text = page("<path d=\"M0 0H60V20H0ZM20 0V18M40 0V11\"/>");
  ReadSettings settings;
  for (const auto& [width, tiles] : {std::pair(1.0, 1U), {2.0, 2U}, {9.0, 3U}}) {
    settings.neckWidth = width;
    EXPECT_EQ(read("a.svg", text, settings).model.tiles.size(), tiles) << width;
  }
}

TEST(CutPatterns, ReportsWhatIsWrongAndWhere) {
  EXPECT_THAT(read("a.svg", "<svg><text>a</text></svg>").refusal,
              HasSubstr("a.svg: error: the drawing has no lines of a sheet, but 1 x text. Draw"));
  EXPECT_THAT(read("a.svg", page("<path d=\"M0 0H40V20H0M20 0V18\"/>")).refusal,
              HasSubstr("a.svg: error: the outline is open: the line that ends at (0, 0) mm leaves "
                        "the sheet. Close the outline, or end the line at it"));
  EXPECT_THAT(read("a.svg", page("<path d=\"M0 0H40V20H0V1M20 0V18\"/>")).refusal,
              HasSubstr("the outline is open"));
  EXPECT_THAT(read("a.svg", page("<path d=\"M0 0H60V20H0ZM20 0V20M40 0V18\"/>")).refusal,
              HasSubstr("the piece at (10, 10) mm hangs by nothing. End a cut around it"));
  // Creases, or cuts that meet all others.
  EXPECT_THAT(
      read("a.svg", page("<path d=\"M0 0H60V20H0Z\"/><path stroke=\"red\" d=\"M20 0V20\"/>"
                         "<path stroke=\"blue\" d=\"M40 0V20\"/>"))
          .refusal,
      HasSubstr("the drawing has 3 pieces without necks, such as the one at (10, 10) mm: no "
                "cut stops short of another line. End cuts before the lines that they meet. "
                "Creases are read from FOLD files"));
  ReadSettings narrow;
  narrow.neckWidth = 0.5;
  EXPECT_THAT(read("a.svg", page("<path d=\"M0 0H60V20H0ZM20 0V20M40 0V18\"/>"), narrow).refusal,
              HasSubstr("or by too much. Give `widest_neck`"));
  // A sheet in the xz plane of a DXF file.
  const SlitGrid upright(4, [] { return 0.7; });
  std::string dxf = "0\nSECTION\n2\nENTITIES\n";
  const auto addLine = [&](const Point& a, const Point& b) {
    dxf += fmt::format("0\nLINE\n8\n0\n10\n{}\n20\n0\n30\n{}\n11\n{}\n21\n0\n31\n{}\n", a.x(),
                       a.y(), b.x(), b.y());
  };
  for (const auto& [a, b] : upright.slits) addLine(a, b);
  for (int k = 0; k < 4; ++k) addLine(upright.outline()[k], upright.outline()[(k + 1) % 4]);
  EXPECT_THAT(
      read("a.dxf", dxf + "0\nENDSEC\n0\nEOF\n").refusal,
      HasSubstr("(14 x line that leaves the xy plane, which is not cut: turn the sheet into "
                "that plane)"));
  // A gap in the outline, next to a slit that stops short of it.
  EXPECT_THAT(read("a.svg", page("<path d=\"M10 0H40V20H0V0H9.5M10 1V20\"/>")).refusal,
              HasSubstr("the outline is open at (10, 0) mm, 0.5 mm from the next line; close it"));
  // A side of the outline is missing. A slit leaves the sheet there, or ends at one of its ends.
  EXPECT_THAT(read("a.svg", page("<path d=\"M0 0V40H40V0M20 39V1M1 20H39\"/>")).refusal,
              HasSubstr("the outline is open: the line that ends at (0, 0) mm leaves the sheet"));
  EXPECT_THAT(read("a.svg", page("<path d=\"M20 0V19M0 0V40H60V0H40M20 40V21M40 40V1M1 20H59\"/>"
                                 "<path d=\"M0 0H20\"/>"))
                  .refusal,
              HasSubstr("the outline is open at (40, 0) mm, 20 mm from the next line"));
  // A slit that crosses another one by mistake, and one that crosses it to cut four tiles.
  EXPECT_THAT(read("a.svg", page("<path d=\"M0 0H80V80H0ZM40 2V78M2 40H42\"/>")).refusal,
              HasSubstr("a.svg: error: a cut crosses a line at (40, 40) mm and ends 2 mm beyond "
                        "it. End it at the line, or before the line to keep a neck"));
  EXPECT_EQ(read("a.svg", page("<path d=\"M0 0H80V80H0ZM40 2V78M2 40H78\"/>")).model.tiles.size(),
            4U);
  // A slot whose outline crosses itself.
  EXPECT_THAT(read("a.svg", page("<path d=\"M0 0H60V40H0Z\"/><path d=\"M30 2V38H30.3V2Z\"/>"
                                 "<path d=\"M2 20H10L10.3 20.3H2L6 19Z\"/>"))
                  .refusal,
              HasSubstr("an outline crosses itself at ("));
  // Two sheets, one drawn over the other.
  const SlitGrid small(2, [] { return 2.0; });
  std::string twice;
  for (const double shift : {0.0, 7.0}) {
    const Point by(shift, 2 * shift);
    std::vector<Point> outline = small.outline();
    for (Point& p : outline) p += by;
    twice += closedPath(outline);
    for (const auto& [a, b] : small.slits) twice += path(a + by, b + by);
  }
  EXPECT_THAT(read("a.svg", page(twice)).refusal,
              HasSubstr("a.svg: error: outlines of two sheets cross at (7, 40) mm. Draw the sheets "
                        "next to each other"));
  // Ribbons.
  std::string ribbons = "<path d=\"M0 0H60V50H0Z";
  for (int row = 1; row < 5; ++row) {
    ribbons += row % 2 ? fmt::format("M5 {0}H25M35 {0}H55", 10 * row)
                       : fmt::format("M0 {0}H10M20 {0}H40M50 {0}H60", 10 * row);
  }
  EXPECT_THAT(read("a.svg", page(ribbons + "\"/>")).refusal,
              HasSubstr("It can only bend and is not a rigid tile"));
  // A living hinge of slots: the necks are narrower than half a slot.
  std::string slots = "<path d=\"M0 0H54V50H0Z\"/>";
  for (int row = 0; row < 13; ++row) {
    for (const double y : row % 2 ? std::vector{0.0, 25.5} : std::vector{1.0, 17.5, 34.0}) {
      slots += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"2.25\" height=\"{}\"/>", 1.75 + 4 * row,
                           y, row % 2 ? 23.5 : 15.5);
    }
  }
  EXPECT_THAT(read("a.svg", page(slots)).refusal, HasSubstr("It can only bend"));
  EXPECT_THAT(read("a.svg", gridWith("<path stroke=\"red\" d=\"M-10 10H30\"/>")).refusal,
              HasSubstr("`cut` and `ignore` choose"));
}

// A second copy of all slits, off by 5e-6 of the drawing's size at most, with all digits.
TEST(CutPatterns, LinesThatAreDrawnTwiceCountOnce) {
  const SlitGrid grid(4, [] { return 1.2; });
  std::string text = closedPath(grid.outline());
  for (const Line& slit : grid.slits) text += closedPath(stadium(slit, 0.3, 8));
  const Reading reading = read("a.svg", page(text + text));
  expectGrid(reading, grid, Eigen::Affine2d::Identity(), 1e-6);
  EXPECT_THAT(reading.note, HasSubstr("25 x line that is drawn twice"));
}

TEST(CutPatterns, ReadsLinesThatAreDrawnTwiceNotQuiteAlike) {
  const SlitGrid grid(4, [] { return 1.5; });
  std::mt19937 random(7);
  std::uniform_real_distribution<double> off(-4e-4, 4e-4);
  std::string text = closedPath(grid.outline());
  for (const auto& [from, to] : grid.slits) {
    text += path(from, to);
    text += path(from + Point(off(random), off(random)), to + Point(off(random), off(random)));
  }
  const Reading reading = read("a.svg", page(text));
  EXPECT_EQ(reading.refusal, "");
  EXPECT_EQ(reading.model.tiles.size(), 16U) << reading.note;
  EXPECT_EQ(reading.model.joints.size(), 24U) << reading.note;
}

/// The drawing's fault; none for a sheet.
std::optional<DrawingFault> faultOf(const std::string& text) {
  const TemporaryFolder folder;
  folder.write("a.svg", text);
  std::vector<std::string> warnings;
  try {
    readDrawnSheet(folder.path() / "a.svg", {}, warnings);
  } catch (const DrawingFault& fault) {
    return fault;
  }
  return std::nullopt;
}

TEST(CutPatterns, FaultsHaveTheirPlaceAndTheDrawing) {
  const auto open = faultOf(page("<path d=\"M0 0H40V20H0M20 0V18\"/>"));
  ASSERT_TRUE(open);
  ASSERT_EQ(open->places().size(), 1U);
  // The open end is a corner of the drawing's only closed box.
  EXPECT_EQ(open->lines().size(), 2U);
  bool isAnEnd = false;
  for (const DrawnPath& line : open->lines()) {
    isAnEnd |= (line.points.front() - open->places()[0]).norm() < 1e-9;
  }
  EXPECT_TRUE(isAnEnd);
  const auto loose = faultOf(page("<path d=\"M0 0H60V20H0ZM20 0V20M40 0V18\"/>"));
  ASSERT_TRUE(loose);
  Eigen::AlignedBox2d box;
  for (const DrawnPath& line : loose->lines()) {
    for (const Vector2& point : line.points) box.extend(point);
  }
  // The left third: 20 of 60 mm wide.
  const Vector2 within = loose->places().at(0) - box.min();
  EXPECT_NEAR(within.x(), 0.01, 1e-9);
  EXPECT_NEAR(within.y(), 0.01, 1e-9);
  // The message with the list of lines keeps the place.
  EXPECT_TRUE(
      faultOf(page("<path d=\"M0 0H60V20H0ZM20 0V20M40 0V18\"/>"
                   "<path stroke=\"red\" d=\"M30 0V18\"/>")));
  EXPECT_FALSE(faultOf(page("<path d=\"M0 0H40V20H0ZM20 0V18\"/>")));
}

TEST(CutPatterns, ListsTheLinesThatItIgnores) {
  const TemporaryFolder folder;
  folder.write("a.svg", page("<path d=\"M0 0H40V20H0ZM20 0V18\"/>"
                             "<path stroke=\"blue\" d=\"M8 8H12\"/>"
                             "<path stroke=\"blue\" d=\"M28 8H32\"/>"));
  std::vector<std::string> warnings;
  for (const bool isChosen : {false, true}) {
    ReadSettings settings;
    if (isChosen) settings.ignore = {"blue"};
    const DrawnSheet sheet = readDrawnSheet(folder.path() / "a.svg", settings, warnings);
    EXPECT_EQ(sheet.model.tiles.size(), 2U);
    ASSERT_EQ(sheet.ignored.size(), 2U);
    for (const DrawnPath& line : sheet.ignored) {
      EXPECT_NEAR((line.points.back() - line.points.front()).norm(), 0.004, 1e-9);
    }
  }
}

// A star of twelve points is not a slot, although its perimeter is long.
TEST(OpeningTips, StarsHaveTipsAndSlotsHaveNone) {
  std::vector<Point> star;
  for (int k = 0; k < 24; ++k) {
    const double angle = -k * std::numbers::pi / 12, radius = k % 2 ? 50 : 100;
    star.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  EXPECT_EQ(openingTips({star}, 1e-6).size(), 12U);
  EXPECT_EQ(openingTips({{{0, 0}, {0, 1}, {30, 1}, {30, 0}}}, 1e-6).size(), 0U);
}

}  // namespace
}  // namespace kirireel::formats
