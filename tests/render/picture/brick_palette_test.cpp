#include <algorithm>
#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "render/picture/state_painter.h"
#include "sim/base/error.h"
#include "sim/generate/lattice.h"
#include "sim/trajectory/panels.h"
#include "tests/render/picture/colours.h"
#include "tests/support/pair_forces.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

/// The background of pictures without an appearance.
using test::kWhite;

std::vector<brick::Brick> bricksOf(const std::vector<model::Tile>& tiles) {
  return brick::makeBricks(tiles, {});
}

model::Tile polygon(std::initializer_list<std::pair<double, double>> corners) {
  model::Tile tile;
  for (const auto& [x, y] : corners) tile.vertices.emplace_back(x, y, 0);
  return tile;
}

/// A tessellation whose target is 2 m above its start.
picture::PictureContent tessellationContent() {
  model::Model model = generate::makeTessellation({});
  model.target = model.tiles;
  for (model::Tile& tile : *model.target) {
    for (Vector3& vertex : tile.vertices) vertex.z() += 2;
  }
  return picture::makeContent(model, {}, std::nullopt);
}

/// Poses of the content's bricks, lifted.
Poses lifted(const picture::PictureContent& content, double height) {
  Poses poses = content.start;
  for (Pose& pose : poses) pose.position.z() += height;
  return poses;
}

picture::Appearance coloured(picture::Colouring colouring) {
  picture::Appearance appearance;
  appearance.colouring = colouring;
  return appearance;
}

TEST(ShapeKinds, CountsCongruentTilesAsOne) {
  // A triangle, its mirror image turned by a quarter, a square, the triangle twice as large.
  const std::vector<model::Tile> tiles = {
      polygon({{0, 0}, {3, 0}, {0, 1}}), polygon({{5, 5}, {6, 5}, {6, 8}}),
      polygon({{0, 0}, {1, 0}, {1, 1}, {0, 1}}), polygon({{0, 0}, {6, 0}, {0, 2}})};
  EXPECT_EQ(picture::shapeKinds(bricksOf(tiles)), (std::vector<int>{0, 0, 1, 2}));
}

TEST(ShapeKinds, DistinguishesARhombusFromASquare) {
  const double h = std::sqrt(0.75);
  const std::vector<model::Tile> tiles = {polygon({{0, 0}, {1, 0}, {1, 1}, {0, 1}}),
                                          polygon({{0, 0}, {1, 0}, {1.5, h}, {0.5, h}})};
  EXPECT_EQ(picture::shapeKinds(bricksOf(tiles)), (std::vector<int>{0, 1}));
}

TEST(ShapeKinds, CountsCornersWhenShapesAreMany) {
  std::vector<model::Tile> tiles;
  for (int k = 1; k < 9; ++k) tiles.push_back(polygon({{0, 0}, {k, 0}, {0, 1}}));
  tiles.push_back(polygon({{0, 0}, {1, 0}, {1, 1}, {0, 1}}));
  EXPECT_EQ(picture::shapeKinds(bricksOf(tiles)), (std::vector<int>{0, 0, 0, 0, 0, 0, 0, 0, 1}));
}

TEST(BrickPalette, ShowsMomentsAndEnergiesOfHingeSprings) {
  picture::PictureContent content = tessellationContent();
  // Between the first two tiles, 2 N m/rad and at rest a quarter turn ahead.
  content.pairForces = test::pairForces({{{0, 1, Vector3::UnitZ(), 0, -10, 10}, 2, 0.5, 0}});
  content.states = {content.start};
  const picture::BrickPalette moment(coloured(picture::Colouring::Moment), content);
  EXPECT_NEAR(moment.scale()->most, 1, 1e-12);  // 2 * 0.5
  EXPECT_EQ(moment.scale()->title, "moment, N m");
  EXPECT_EQ(moment.colours(content.start)[0].top,
            picture::mapColour(picture::ColourMap::Viridis, 1, kWhite));
  EXPECT_EQ(moment.colours(content.start)[2].top,
            picture::mapColour(picture::ColourMap::Viridis, 0, kWhite));
  const picture::BrickPalette energy(coloured(picture::Colouring::Energy), content);
  EXPECT_NEAR(energy.scale()->most, 0.125, 1e-12);  // half of 2 * 0.5^2 / 2
}

// The energy of a neck's ligament also counts for the colours of its bricks.
TEST(BrickPalette, ShowsMomentsAndEnergiesOfLigaments) {
  picture::PictureContent content = tessellationContent();
  brick::Ligament ligament{0, 1};
  // From centre to centre: at rest at the start.
  ligament.start = content.start[1].position - content.start[0].position;
  ligament.stretchStiffness = 6;
  ligament.shearStiffness = 3;
  content.pairForces =
      test::pairForces({{{0, 1, Vector3::UnitZ(), 0, -10, 10}, 2, 0, 0}}, {ligament});
  Poses turned = content.start, parted = content.start;
  turned[1].rotation = rotationFromVector({0, 0, 0.4});
  parted[1].position += 0.5 * ligament.start.normalized();
  content.states = {turned, parted};
  // Turned, the neck is sheared by half of the angle: at brick B its end adds half of 3 * 0.2.
  const picture::BrickPalette moment(coloured(picture::Colouring::Moment), content);
  EXPECT_NEAR(moment.scale()->most, 2 * 0.4 + 0.3, 1e-12);
  EXPECT_EQ(moment.colours(parted)[0].top,
            picture::mapColour(picture::ColourMap::Viridis, 0, kWhite));
  // Parted, each brick has half of 6 * 0.5^2 / 2.
  const picture::BrickPalette energy(coloured(picture::Colouring::Energy), content);
  EXPECT_NEAR(energy.scale()->most, 0.375, 1e-12);
  EXPECT_EQ(energy.colours(parted)[1].top,
            picture::mapColour(picture::ColourMap::Viridis, 1, kWhite));
  EXPECT_EQ(energy.colours(parted)[2].top,
            picture::mapColour(picture::ColourMap::Viridis, 0, kWhite));
}

// Poses do not contain the energy of panels: their states do, at their times.
TEST(BrickPalette, ShowsEnergiesOfPanels) {
  picture::PictureContent content = tessellationContent();
  trajectory::LoadedPanels sheet;
  for (const brick::Brick& brick : content.bricks) {
    sheet.tileNodes.emplace_back(brick.bottom.size(), 0);
  }
  sheet.tileNodes[2] = {0, 1, 2, 3};
  sheet.bars = {{1, 2, 1, 8}};
  sheet.folds = {{{0, 1, 2, 3}, 2, 0, {0, 3}}};
  sheet.states = {{0, {}, {0}, {0}}, {1, {}, {0.5}, {0.5}}};
  content.panels = std::make_shared<const trajectory::LoadedPanels>(sheet);
  const auto full = picture::mapColour(picture::ColourMap::Viridis, 1, kWhite);
  const auto none = picture::mapColour(picture::ColourMap::Viridis, 0, kWhite);
  const picture::BrickPalette energy(coloured(picture::Colouring::Energy), content);
  EXPECT_NEAR(energy.scale()->most, 1, 1e-12);  // 8 * 0.5^2 / 2; a fold's half is 0.125
  EXPECT_EQ(energy.colours(content.start, 1)[2].top, full);
  EXPECT_EQ(energy.colours(content.start, 0)[2].top, none);
  EXPECT_EQ(energy.colours(content.start, 0.5)[2].top,
            picture::mapColour(picture::ColourMap::Viridis, 0.5, kWhite));
  const picture::BrickPalette moment(coloured(picture::Colouring::Moment), content);
  EXPECT_NEAR(moment.scale()->most, 1, 1e-12);  // 2 * 0.5
  EXPECT_EQ(moment.colours(content.start, 1)[3].top, full);
  EXPECT_EQ(moment.colours(content.start, 1)[2].top, none);
}

TEST(BrickPalette, MomentsNeedSpringsAtHinges) {
  const picture::PictureContent content = tessellationContent();
  for (const picture::Colouring colouring :
       {picture::Colouring::Moment, picture::Colouring::Energy}) {
    try {
      picture::BrickPalette(coloured(colouring), content);
      FAIL() << "accepted";
    } catch (const InputError& error) {
      EXPECT_STREQ(error.what(),
                   "error: the hinges have no springs, so there is no moment or energy to show; "
                   "give another --colour or add --hinge-stiffness or --hinge-neck");
    }
  }
}

TEST(BrickPalette, LeavesPlainBricksToTheStyle) {
  const picture::PictureContent content = tessellationContent();
  const picture::BrickPalette palette({}, content);
  EXPECT_TRUE(palette.colours(content.start).empty());
  EXPECT_FALSE(palette.scale().has_value());
}

TEST(BrickPalette, SpansTheScaleFromStartToTarget) {
  const picture::PictureContent content = tessellationContent();
  const picture::BrickPalette palette(coloured(picture::Colouring::TargetError), content);
  EXPECT_EQ(palette.scale()->title, "target error, m");
  for (const picture::BrickColours& colours : palette.colours(lifted(content, 2))) {
    EXPECT_EQ(colours.top, picture::mapColour(picture::ColourMap::Viridis, 0, kWhite));
    EXPECT_EQ(colours.bottom, colours.top);
  }
  for (const picture::BrickColours& colours : palette.colours(content.start)) {
    EXPECT_EQ(colours.top, picture::mapColour(picture::ColourMap::Viridis, 1, kWhite));
  }
  EXPECT_EQ(palette.colours(lifted(content, 1))[3].top,
            picture::mapColour(picture::ColourMap::Viridis, 0.5, kWhite));
}

TEST(BrickPalette, ShowsRotationsInDegrees) {
  const picture::PictureContent content = tessellationContent();
  picture::Appearance appearance = coloured(picture::Colouring::Rotation);
  appearance.colourMost = 90;
  const picture::BrickPalette palette(appearance, content);
  EXPECT_NEAR(palette.scale()->most, 90, 1e-12);
  const picture::Colour expected = picture::mapColour(picture::ColourMap::Viridis, 0.5, kWhite);
  Poses poses = content.start;
  for (Pose& pose : poses) pose.rotation = rotationFromVector(Vector3(0, 0, M_PI / 4));
  for (const picture::BrickColours& colours : palette.colours(poses))
    EXPECT_EQ(colours.top, expected);
}

TEST(BrickPalette, SpansTheScaleOverTheRun) {
  picture::PictureContent content = tessellationContent();
  Poses turned = content.start;
  for (Pose& pose : turned) pose.rotation = rotationFromVector(Vector3(0, 0, M_PI / 6));
  content.states = {content.start, turned};
  EXPECT_NEAR(picture::BrickPalette(coloured(picture::Colouring::Rotation), content).scale()->most,
              30, 1e-12);
  content.states = {content.start};  // nothing turns
  EXPECT_EQ(picture::BrickPalette(coloured(picture::Colouring::Rotation), content).scale()->most,
            90);
}

TEST(BrickPalette, HasColoursForStartMotionAndTarget) {
  const picture::PictureContent content = tessellationContent();
  const picture::BrickPalette palette(coloured(picture::Colouring::State), content);
  const picture::BrickColours start = palette.colours(content.start)[0];
  const picture::BrickColours moving = palette.colours(lifted(content, 1))[0];
  const picture::BrickColours target = palette.colours(lifted(content, 2))[0];
  EXPECT_NE(start, moving);
  EXPECT_NE(moving, target);
  EXPECT_NE(start, target);
}

TEST(BrickPalette, NeedsATargetForItsError) {
  picture::PictureContent content = tessellationContent();
  content.target.reset();
  try {
    picture::BrickPalette(coloured(picture::Colouring::TargetError), content);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "error: the model has no target, so there is no target error to show; give "
                 "another --colour or add target.txt");
  }
}

TEST(BrickPalette, ReportsMeaningOfColours) {
  picture::PictureContent content;
  const std::vector<model::Tile> tiles = {polygon({{0, 0}, {3, 0}, {0, 1}}),
                                          polygon({{0, 0}, {1, 0}, {1, 1}, {0, 1}}),
                                          polygon({{5, 5}, {6, 5}, {6, 8}})};
  content.bricks = bricksOf(tiles);
  content.start = brick::startPoses(tiles, content.bricks);
  const auto textsOf = [](const picture::BrickPalette& palette) {
    std::vector<std::string> texts;
    for (const picture::LegendEntry& entry : palette.legend()) texts.push_back(entry.text);
    return texts;
  };
  EXPECT_EQ(textsOf(picture::BrickPalette(coloured(picture::Colouring::Shape), content)),
            (std::vector<std::string>{"2 triangles", "1 quadrilateral"}));
  EXPECT_EQ(textsOf(picture::BrickPalette(coloured(picture::Colouring::State), content)),
            (std::vector<std::string>{"at its start", "on its way"}));
  EXPECT_TRUE(picture::BrickPalette(coloured(picture::Colouring::Plain), content).legend().empty());
}

/// The message of a refused style.
std::string refusalOf(const picture::Appearance& appearance,
                      const picture::PictureContent& content) {
  return test::refusalOf([&] { const picture::BrickPalette palette(appearance, content); });
}

TEST(BrickPalette, SingleTilesHaveTheirOwnColours) {
  const picture::PictureContent content = tessellationContent();
  picture::Appearance appearance;
  appearance.brickColour = picture::Colour{10, 20, 30};
  appearance.tileColours = {{{1, 3}, {200, 0, 0}}, {{3}, {0, 200, 0}}};
  const std::vector<picture::BrickColours> colours =
      picture::BrickPalette(appearance, content).colours(content.start);
  ASSERT_EQ(colours.size(), content.bricks.size());
  EXPECT_EQ(colours[0], picture::plainColours(appearance));
  EXPECT_EQ(colours[1].top, (picture::Colour{200, 0, 0}));
  EXPECT_EQ(colours[3].bottom, (picture::Colour{0, 200, 0}));
  appearance.colouring = picture::Colouring::State;
  EXPECT_EQ(picture::BrickPalette(appearance, content).colours(content.start)[1].top,
            (picture::Colour{200, 0, 0}));
  appearance.tileColours = {{{static_cast<int>(content.bricks.size())}, {}}};
  EXPECT_EQ(refusalOf(appearance, content),
            fmt::format("error: --tile-colour: the model has no tile {}. Give tiles from 0 to {}",
                        content.bricks.size(), content.bricks.size() - 1));
  appearance.colouring = picture::Colouring::Rotation;
  EXPECT_EQ(
      refusalOf(appearance, content),
      "error: --tile-colour works only with --colour plain, shape or state: other colours show "
      "values. Give one of these, or remove --tile-colour");
}

TEST(BrickPalette, NamedGroupsOfTilesAreInTheLegend) {
  const picture::PictureContent content = tessellationContent();
  picture::Appearance appearance;
  appearance.tileColours = {{{1, 3}, {200, 0, 0}, "hinge row"}, {{2}, {0, 200, 0}}};
  const picture::BrickPalette palette(appearance, content);
  ASSERT_EQ(palette.legend().size(), 1);
  EXPECT_EQ(palette.legend()[0].colour, (picture::Colour{200, 0, 0}));
  EXPECT_EQ(palette.legend()[0].text, "hinge row");
  appearance.opacity = 0.4;
  appearance.tileOpacities = {{{1, 3}, 0.2}};
  EXPECT_EQ(picture::BrickPalette(appearance, content).legend()[0].colour,
            (picture::Colour{200, 0, 0, 51}));
}

TEST(BrickPalette, TilesHaveTheRequestedOpacity) {
  const picture::PictureContent content = tessellationContent();
  for (const picture::Colouring colouring :
       {picture::Colouring::Plain, picture::Colouring::State, picture::Colouring::Rotation}) {
    picture::Appearance appearance;
    appearance.colouring = colouring;
    const std::vector<picture::BrickColours> opaque =
        picture::BrickPalette(appearance, content).colours(content.start);
    appearance.opacity = 0.4;
    appearance.tileOpacities = {{{1, 3}, 0.2}, {{3}, 0}};
    const std::vector<picture::BrickColours> colours =
        picture::BrickPalette(appearance, content).colours(content.start);
    ASSERT_EQ(colours.size(), content.bricks.size());
    for (const auto& [brick, alpha] : {std::pair(0, 102), {1, 51}, {3, 0}}) {
      EXPECT_EQ(colours[brick].top.alpha, alpha);
      EXPECT_EQ(colours[brick].side.alpha, alpha);
      EXPECT_EQ(colours[brick].bottom.alpha, alpha);
      const picture::BrickColours whole =
          opaque.empty() ? picture::plainColours(appearance) : opaque[brick];
      EXPECT_EQ(picture::withOpacity(colours[brick], 1), whole);
    }
    EXPECT_EQ(picture::isDrawn(colours[1]), true);
    EXPECT_EQ(picture::isDrawn(colours[3]), false);
    appearance.tileOpacities = {{{static_cast<int>(content.bricks.size())}, 0.5}};
    EXPECT_EQ(
        refusalOf(appearance, content),
        fmt::format("error: --tile-opacity: the model has no tile {}. Give tiles from 0 to {}",
                    content.bricks.size(), content.bricks.size() - 1));
  }
}

TEST(BrickPalette, OutlinesHaveOneColourThatAllBricksShow) {
  const picture::PictureContent content = tessellationContent();
  const auto minContrast = [&content](const picture::Appearance& appearance) {
    const picture::Style style = picture::PictureSetup(appearance, content, {320, 240}).style();
    double least = 21;
    for (const picture::Colour hue : picture::BrickPalette(appearance, content).hues()) {
      least = std::min(least, picture::contrastOf(hue, style.edge));
    }
    return least;
  };
  for (const auto theme : {picture::Theme::Light, picture::Theme::Dark}) {
    picture::Appearance appearance = coloured(picture::Colouring::TargetError);
    appearance.theme = theme;
    for (const auto map :
         {picture::ColourMap::Viridis, picture::ColourMap::Cividis, picture::ColourMap::CoolWarm}) {
      appearance.map = map;
      EXPECT_GT(minContrast(appearance), 1.9);  // 2.1 to 4.9
    }
    appearance.colouring = picture::Colouring::Plain;
    EXPECT_GT(minContrast(appearance), 4);  // 5.6, 8.0
    appearance.brickColour = picture::Colour{0, 0, 128};
    EXPECT_GT(minContrast(appearance), 4);  // 10.7
    // A black tile keeps the dark outlines of a light page, but not those of a dark one.
    appearance.brickColour = std::nullopt;
    appearance.tileColours = {{{3}, test::kBlack, ""}};
    EXPECT_GT(minContrast(appearance), 1.5);  // 1.6
  }
}

TEST(BrickPalette, ScalesBeginAtTheRequestedValue) {
  const picture::PictureContent content = tessellationContent();
  picture::Appearance appearance = coloured(picture::Colouring::Rotation);
  appearance.map = picture::ColourMap::CoolWarm;
  appearance.colourLeast = -30;
  appearance.colourMost = 30;
  EXPECT_EQ(picture::BrickPalette(appearance, content).colours(content.start)[0].top,
            picture::mapColour(appearance.map, 0.5, kWhite));
  appearance.colourLeast = 30;
  EXPECT_EQ(refusalOf(appearance, content),
            "error: --colour-least 30 is not below 30, the scale's other end; give a smaller one, "
            "or a larger --colour-most");
}

}  // namespace
}  // namespace kirireel
