#include "render/cli/command_line.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/formats/joint_faces.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;
using Words = std::vector<std::string>;

cli::RecordOrder recordOrder(const Words& words) {
  return std::get<cli::RecordOrder>(cli::parseCommandLine(words));
}

std::string messageOf(const Words& words) {
  return test::refusalOf([&] { cli::parseCommandLine(words); });
}

std::string page(const Words& words) {
  return std::get<cli::PrintOrder>(cli::parseCommandLine(words)).text;
}

TEST(CommandLine, HelpListsTheExitCodes) {
  for (const Words& words : {Words{"--help"}, {"record", "--help"}, {"simulate", "--help"}}) {
    EXPECT_THAT(
        page(words),
        HasSubstr(
            "Exit codes: 0 done, at the target or without one; 1 failed; 2 wrong input or\n"
            "command line; 3 the target was missed, bricks overlapped, or the search used up\n"
            "its budget; 4 interrupted."));
  }
}

TEST(CommandLine, RecordNeedsOnlyAModel) {
  const cli::RecordOrder order = recordOrder({"record", "data/fan"});
  EXPECT_EQ(order.model, "data/fan");
  EXPECT_TRUE(order.settings.video && order.settings.snapshots && order.settings.meshes);
  EXPECT_FALSE(order.printJson);
  EXPECT_EQ(order.settings.size, (picture::FrameSize{1280, 720}));
  EXPECT_EQ(order.settings.framesPerSecond, 60);
  EXPECT_FALSE(order.scene.springs.springStiffness);
  EXPECT_EQ(order.scene.solver.kind, scene::SolverKind::Direct);
}

TEST(CommandLine, SimulatePaintsNothing) {
  const record::RecordSettings settings = recordOrder({"simulate", "fan"}).settings;
  EXPECT_FALSE(settings.video || settings.snapshots || settings.meshes || settings.frames);
  EXPECT_THAT(messageOf({"simulate", "fan", "--size", "10x10"}),
              HasSubstr("error: unknown option --size"));
}

TEST(CommandLine, ReadsEveryPhysicalOption) {
  const scene::Scene scene = recordOrder({"record",
                                          "fan",
                                          "--thickness",
                                          "0.1",
                                          "--mass",
                                          "prism",
                                          "--density",
                                          "500",
                                          "--spring-stiffness",
                                          "25",
                                          "--torque-stiffness",
                                          "30",
                                          "--force-damping",
                                          "20",
                                          "--torque-damping",
                                          "3",
                                          "--no-adaptive",
                                          "--gravity",
                                          "-9.81",
                                          "--ground",
                                          "--contacts",
                                          "unjoined",
                                          "--brick-friction",
                                          "0.2",
                                          "--linear-damping",
                                          "0.1",
                                          "--angular-damping",
                                          "0.2",
                                          "--duration",
                                          "3",
                                          "--solver",
                                          "bullet",
                                          "--timestep",
                                          "0.01",
                                          "--substeps",
                                          "7",
                                          "--iterations",
                                          "9",
                                          "--planar",
                                          "off",
                                          "--seed",
                                          "42",
                                          "--no-align"})
                                 .scene;
  EXPECT_EQ(scene.brick.thickness, 0.1);
  EXPECT_EQ(scene.brick.mass, brick::MassRule::Prism);
  EXPECT_EQ(scene.brick.density, 500);
  EXPECT_EQ(scene.springs.springStiffness, 25);
  EXPECT_EQ(scene.springs.torqueStiffness, 30);
  EXPECT_EQ(scene.springs.forceDamping, 20);
  EXPECT_EQ(scene.springs.torqueDamping, 3);
  EXPECT_FALSE(scene.springs.adaptive);
  EXPECT_EQ(scene.environment.gravity, Vector3(0, 0, -9.81));
  ASSERT_TRUE(scene.environment.ground);
  EXPECT_EQ(scene.environment.ground->friction, 0.5);
  EXPECT_EQ(scene.environment.contacts, scene::ContactFilter::Unjoined);
  EXPECT_EQ(scene.environment.brickFriction, 0.2);
  EXPECT_EQ(scene.environment.linearDamping, 0.1);
  EXPECT_EQ(scene.environment.angularDamping, 0.2);
  EXPECT_EQ(scene.stop.duration, 3);
  EXPECT_EQ(scene.solver.kind, scene::SolverKind::Bullet);
  EXPECT_EQ(scene.solver.timestep, 0.01);
  EXPECT_EQ(scene.solver.substeps, 7);
  EXPECT_EQ(scene.solver.iterations, 9);
  EXPECT_EQ(scene.solver.planar, false);
  EXPECT_EQ(scene.solver.seed, 42U);
  EXPECT_EQ(recordOrder({"record", "fan", "--search-effort", "5"}).scene.path.searchEffort, 5);
  EXPECT_FALSE(scene.alignment.requested);
}

TEST(CommandLine, SpringsFollowFromTheModelUnlessSpelledAsPyKirigamiDoes) {
  const scene::TargetSpringSettings own = recordOrder({"record", "fan"}).scene.springs;
  EXPECT_FALSE(own.springStiffness || own.torqueStiffness || own.forceDamping || own.torqueDamping);
  const auto peerSprings = [](std::vector<std::string> more) {
    more.insert(more.begin(), {"record", "--model", "fan"});
    return recordOrder(more).scene.springs;
  };
  const scene::TargetSpringSettings peer = peerSprings({"--spring_stiffness", "25"});
  EXPECT_EQ(peer.springStiffness, 25);
  EXPECT_EQ(peer.torqueStiffness, 100);
  EXPECT_EQ(peer.forceDamping, 50);
  EXPECT_EQ(peer.torqueDamping, 2);
  const scene::TargetSpringSettings mixed = peerSprings({"--spring-frequency", "2"});
  EXPECT_EQ(mixed.frequency, 2);
  EXPECT_FALSE(mixed.springStiffness || mixed.torqueStiffness);
  EXPECT_EQ(mixed.forceDamping, 50);
}

TEST(CommandLine, ReadsEveryPictureOption) {
  const record::RecordSettings settings =
      recordOrder({"record",     "fan",         "--out",       "here",      "--size",
                   "640x360",    "--fps",       "30",          "--grid",    "2x4",
                   "--view",     "top",         "--snapshots", "time",      "--frames",
                   "--no-video", "--no-meshes", "--captions",  "angle,gap", "--scale-bar",
                   "--dpi",      "300",         "--svg",       "--gl",      "egl"})
          .settings;
  EXPECT_EQ(settings.folder, "here");
  EXPECT_EQ(settings.size, (picture::FrameSize{640, 360}));
  EXPECT_EQ(settings.framesPerSecond, 30);
  EXPECT_EQ(settings.grid, (picture::GridShape{2, 4}));
  EXPECT_EQ(settings.appearance.camera.view, picture::kTopView);
  EXPECT_EQ(settings.spacing, record::SnapshotSpacing::Time);
  EXPECT_TRUE(settings.captions->angle && settings.captions->gap);
  EXPECT_FALSE(settings.captions->time || settings.captions->error);
  EXPECT_TRUE(settings.scaleBar);
  EXPECT_EQ(settings.dotsPerInch, 300);
  EXPECT_TRUE(settings.svg);
  EXPECT_EQ(settings.graphics, picture::GraphicsLibrary::Egl);
  EXPECT_TRUE(settings.frames);
  EXPECT_FALSE(settings.video || settings.meshes);
  EXPECT_FALSE(recordOrder({"record", "fan", "--no-snapshots"}).settings.snapshots);
}

TEST(CommandLine, ReadsEveryOptionOfTheStyle) {
  const picture::Appearance appearance =
      recordOrder({"record", "fan", "--theme", "dark", "--colour", "rotation", "--colour-map",
                   "cividis", "--colour-most", "90", "--ground-look", "shadow", "--transparent",
                   "--no-outlines", "--mark-joints", "--target-lines"})
          .settings.appearance;
  EXPECT_EQ(appearance.theme, picture::Theme::Dark);
  EXPECT_EQ(appearance.colouring, picture::Colouring::Rotation);
  EXPECT_EQ(appearance.map, picture::ColourMap::Cividis);
  EXPECT_EQ(appearance.colourMost, 90);
  EXPECT_EQ(
      recordOrder({"record", "fan", "--brick-colour", "#102030"}).settings.appearance.brickColour,
      (picture::Colour{16, 32, 48}));
  EXPECT_EQ(appearance.ground, picture::GroundLook::Shadow);
  EXPECT_TRUE(appearance.transparent && appearance.jointMarks && appearance.targetLines);
  EXPECT_FALSE(appearance.outlines);
}

TEST(CommandLine, ReadsADepthCue) {
  const auto cueOf = [](const Words& words) {
    return recordOrder(words).settings.appearance.depthCue;
  };
  EXPECT_EQ(cueOf({"record", "fan"}), 0);
  EXPECT_EQ(cueOf({"record", "fan", "--depth-cue", "0.5"}), 0.5);
}

TEST(CommandLine, ReadsEveryOptionOfTheCamera) {
  const picture::Appearance appearance =
      recordOrder({"record", "fan", "--view", "-60,35", "--projection", "parallel", "--zoom", "2",
                   "--margin", "0.1", "--fit", "ends", "--orbit", "180", "--camera-keys",
                   "0:50:-35:1,2.5:90:-20:1.5"})
          .settings.appearance;
  EXPECT_EQ(appearance.camera.view, (picture::ViewAngles{-60 * kDegree, 35 * kDegree}));
  EXPECT_EQ(appearance.camera.orthographic, true);
  EXPECT_EQ(appearance.camera.zoom, 2);
  EXPECT_EQ(appearance.camera.margin, 0.1);
  EXPECT_EQ(recordOrder({"record", "fan", "--distance", "7"}).settings.appearance.camera.distance,
            7);
  EXPECT_EQ(appearance.fit, picture::FitScope::Ends);
  EXPECT_EQ(appearance.camera.orbit, M_PI);
  const picture::CameraKey last{2.5, picture::viewFromYawPitch(90 * M_PI / 180, -20 * M_PI / 180),
                                1.5};
  ASSERT_EQ(appearance.camera.keys.size(), 2U);
  EXPECT_EQ(appearance.camera.keys[1], last);
}

TEST(CommandLine, TakesPyKirigamisCommand) {
  const cli::RecordOrder peer =
      recordOrder({"record", "--model", "square2disk", "--ground_plane", "--brick_thickness", "0.1",
                   "--gravity", "-200", "--force_damping", "20", "--headless", "--no_collision"});
  EXPECT_EQ(peer.model, "square2disk");
  EXPECT_TRUE(peer.scene.environment.ground);
  EXPECT_EQ(peer.scene.brick.thickness, 0.1);
  EXPECT_EQ(peer.scene.environment.gravity.z(), -200);
  EXPECT_EQ(peer.scene.springs.forceDamping, 20);
  EXPECT_EQ(peer.scene.environment.contacts, scene::ContactFilter::Unjoined);
}

TEST(CommandLine, LastOfTwoWins) {
  EXPECT_EQ(recordOrder({"record", "fan", "--fps", "30", "--fps", "25"}).settings.framesPerSecond,
            25);
}

TEST(CommandLine, GroundFrictionImpliesGround) {
  for (const Words& words : {Words{"record", "fan", "--ground-friction", "0.3"},
                             Words{"record", "fan", "--ground-friction", "0.3", "--ground"},
                             Words{"record", "fan", "--ground", "--ground-friction", "0.3"}}) {
    const auto ground = recordOrder(words).scene.environment.ground;
    ASSERT_TRUE(ground);
    EXPECT_EQ(ground->friction, 0.3);
  }
}

TEST(CommandLine, GeneratesFamilies) {
  const cli::GenerateOrder order = std::get<cli::GenerateOrder>(cli::parseCommandLine(
      {"generate", "tessellation", "here", "--columns", "3", "--rows", "2", "--length", "2",
       "--width", "0.5", "--start-angle", "30", "--target-angle", "120", "--face", "bottom"}));
  EXPECT_EQ(order.family, "tessellation");
  EXPECT_EQ(order.folder, "here");
  EXPECT_EQ(order.values, (std::map<std::string, double>{{"columns", 3},
                                                         {"rows", 2},
                                                         {"length", 2},
                                                         {"width", 0.5},
                                                         {"start-angle", 30},
                                                         {"target-angle", 120}}));
  EXPECT_EQ(order.face, model::JointFace::Bottom);
  const cli::GenerateOrder cap =
      std::get<cli::GenerateOrder>(cli::parseCommandLine({"generate", "cap", "there"}));
  EXPECT_EQ(cap.family, "cap");
  EXPECT_TRUE(cap.values.empty());
  EXPECT_FALSE(cap.face);
}

TEST(CommandLine, InspectsAndConverts) {
  const cli::InspectOrder inspect = std::get<cli::InspectOrder>(cli::parseCommandLine(
      {"inspect", "fan", "--json", "--picture", "a.png", "--thickness", "0.1"}));
  EXPECT_EQ(inspect.model, "fan");
  EXPECT_EQ(inspect.picture, "a.png");
  EXPECT_TRUE(inspect.printJson);
  EXPECT_EQ(inspect.scene.brick.thickness, 0.1);
  const cli::ConvertOrder convert = std::get<cli::ConvertOrder>(
      cli::parseCommandLine({"convert", "fan", "fan.fold", "--target", "open"}));
  EXPECT_EQ(convert.input, "fan");
  EXPECT_EQ(convert.output, "fan.fold");
  EXPECT_EQ(convert.target, "open");
  EXPECT_EQ(messageOf({"convert", "fan"}),
            "error: OUT is missing, as in kirireel convert IN OUT; see kirireel convert --help");
}

TEST(CommandLine, ChoosesFacesOfJoints) {
  const auto facesOf = [](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"record", "fan"});
    return std::get<cli::RecordOrder>(cli::parseCommandLine(arguments)).faces;
  };
  EXPECT_FALSE(facesOf({}));
  EXPECT_FALSE(facesOf({"--faces", "model"}));
  EXPECT_EQ(facesOf({"--faces", "fold"}), formats::FaceRule::Fold);
  EXPECT_EQ(facesOf({"--faces", "pykirigami"}), formats::FaceRule::PyKirigami);
  EXPECT_EQ(facesOf({"--auto_detect_connections"}), formats::FaceRule::PyKirigami);
}

TEST(CommandLine, UnknownOptionSuggestsTheNearest) {
  EXPECT_EQ(messageOf({"record", "fan", "--spring-stifness", "3"}),
            "error: unknown option --spring-stifness, did you mean --spring-stiffness?; see "
            "kirireel record --help");
  EXPECT_EQ(messageOf({"record", "fan", "--purple"}),
            "error: unknown option --purple; see kirireel record --help");
}

TEST(CommandLine, UnknownCommandSuggestsTheNearest) {
  EXPECT_EQ(messageOf({"recrod", "fan"}),
            "error: unknown command recrod, did you mean record?; see kirireel --help");
  EXPECT_EQ(messageOf({"generate", "tesselation", "x"}),
            "error: unknown command tesselation, did you mean tessellation?; see kirireel generate "
            "--help");
}

TEST(CommandLine, MissingAndSurplusArgumentsAreErrors) {
  EXPECT_EQ(messageOf({}),
            "error: no command given; choose record, simulate, render, export, generate, inspect, "
            "convert, models, study, page, curves, figure, sweep or verify, see "
            "kirireel --help");
  EXPECT_EQ(messageOf({"record"}),
            "error: MODEL is missing, as in kirireel record MODEL; see kirireel record --help");
  EXPECT_EQ(messageOf({"generate", "tessellation"}),
            "error: FOLDER is missing, as in kirireel generate tessellation FOLDER; see kirireel "
            "generate tessellation --help");
  EXPECT_EQ(messageOf({"generate"}),
            "error: no family given, as in kirireel generate tessellation FOLDER; see kirireel "
            "generate --help");
  EXPECT_EQ(messageOf({"record", "fan", "cylinder"}),
            "error: unexpected argument 'cylinder'; see kirireel record --help");
  EXPECT_EQ(messageOf({"record", "fan", "--fps"}),
            "error: --fps needs a value; see kirireel record --help");
  for (const char* option : {"--out", "--target", "--title"}) {
    EXPECT_EQ(messageOf({"record", "fan", option, ""}),
              std::string("error: ") + option + " needs a value; see kirireel record --help");
  }
}

TEST(CommandLine, MessagesGiveAllFormsOfAValue) {
  EXPECT_EQ(messageOf({"record", "fan", "--view", "up"}),
            "error: --view: 'up' is not allowed; give auto, top, bottom, front, back, side, left, "
            "iso, oblique or AZIMUTH,ELEVATION[,ROLL] in degrees");
  EXPECT_EQ(messageOf({"record", "fan", "--thickness", "3mm"}),
            "error: --thickness: '3mm' is not allowed; give a number from 1e-15 to 1e+09 without a "
            "unit. `unit` sets the unit of lengths");
}

TEST(CommandLine, UnknownOptionsNameACommandThatHasThem) {
  EXPECT_EQ(
      messageOf({"simulate", "fan", "--no-meshes"}),
      "error: unknown option --no-meshes; kirireel record has it; see kirireel simulate --help");
}

TEST(CommandLine, PicturesOfInspectArePng) {
  EXPECT_EQ(messageOf({"inspect", "fan", "--picture", "a.jpg"}),
            "error: --picture: 'a.jpg' is not allowed; give a name that ends with .png");
}

TEST(CommandLine, SwitchesAreTrueOrFalse) {
  EXPECT_EQ(messageOf({"record", "fan", "--ground=maybe"}),
            "error: --ground: 'maybe' is not allowed; give no value, true or false");
  const cli::Order order = cli::parseCommandLine({"record", "fan", "--ground=false"});
  EXPECT_FALSE(std::get<cli::RecordOrder>(order).scene.environment.ground.has_value());
}

TEST(CommandLine, HelpNamesTheTableOfAGroup) {
  EXPECT_THAT(page({"record", "--help", "end"}),
              HasSubstr("End of the run ([stop] in scene.toml):"));
  EXPECT_THAT(page({"render", "--help", "camera"}), HasSubstr("Camera:"));
}

TEST(CommandLine, HelpTeaches) {
  const std::string help = page({"record", "--help", "all"});
  for (const char* part :
       {"Usage: kirireel record", "--thickness LENGTH", "thickness of the bricks",
        "Examples:", "kirireel record data/tessellation_4x4", "PyKirigami", "--headless"}) {
    EXPECT_THAT(help, HasSubstr(part));
  }
  EXPECT_THAT(page({"--help"}), HasSubstr("simulate"));
  EXPECT_THAT(page({"generate", "tessellation", "--help"}), HasSubstr("--target-angle DEGREES"));
}

std::size_t widestLine(const std::string& text) {
  std::size_t widest = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) widest = std::max(widest, line.size());
  return widest;
}

TEST(CommandLine, HelpFitsTheTerminal) {
  for (const cli::CommandDescription& command : cli::describeProgram().commands) {
    EXPECT_LE(widestLine(page({command.name, "--help", "all"})), 80U) << command.name;
    const std::string help = page({command.name, "--help"});
    // Families of models are one list.
    if (command.commands.empty()) {
      EXPECT_LE(std::ranges::count(help, '\n'), 48) << command.name;
    }
    for (const cli::OptionDescription& option : command.options) {
      if (option.group == "Options") continue;
      const std::string group = page({command.name, "--help", option.group});
      EXPECT_LE(std::ranges::count(group, '\n'), 48) << option.group;
      EXPECT_THAT(group, HasSubstr("\n  " + option.names.front())) << option.group;
    }
  }
}

TEST(CommandLine, HelpListsGroups) {
  const std::string help = page({"record", "--help"});
  EXPECT_THAT(help, HasSubstr("\n  output        --out "));
  EXPECT_THAT(help, HasSubstr("\n  video "));
  EXPECT_THAT(page({"record", "--help", "springs"}),
              testing::StartsWith("Springs to the target ([actuation] in scene.toml):\n"));
  EXPECT_EQ(messageOf({"verify", "--help", "vidoe"}),
            "error: kirireel verify has no group of options 'vidoe'; choose all");
  EXPECT_THAT(messageOf({"record", "--help", "vidoe"}), HasSubstr("'vidoe', did you mean video?;"));
}

TEST(CommandLine, VersionNamesTheLibraries) {
  const std::string version = page({"--version"});
  EXPECT_TRUE(version.starts_with("kirireel 0.1.0\n")) << version;
  EXPECT_THAT(version, HasSubstr("bullet 3."));
}

TEST(CommandLine, RenderOfSeveralRunsNeedsAFolder) {
  const auto order = std::get<cli::RenderOrder>(cli::parseCommandLine(
      {"render", "out/fan/trajectory.h5", "out/cap/trajectory.h5", "--out", "x"}));
  EXPECT_EQ(order.trajectories.size(), 2);
  EXPECT_THAT(
      messageOf({"render", "a.h5", "b.h5"}),
      HasSubstr("error: a figure of several runs needs its own folder; choose it with --out"));
}

TEST(CommandLine, RemovedSpellingsNameTheirReplacement) {
  EXPECT_EQ(messageOf({"record", "fan", "--yaw", "30"}),
            "error: option --yaw was removed; give --view AZ,EL with AZ = yaw - 90; see kirireel "
            "record --help");
  EXPECT_EQ(messageOf({"export", "run", "--format", "inp", "--quadratic"}),
            "error: option --quadratic was removed; give nothing, since it is the default; see "
            "kirireel export --help");
  for (const char* word :
       {"--pitch", "--state", "--format", "--search", "--joint-stiffness", "--guide-stiffness"}) {
    EXPECT_THAT(messageOf({"record", "fan", word, "1"}), HasSubstr(" was removed; give --"));
  }
}

TEST(CommandLine, RenderTakesPictureAndVideoOptions) {
  const auto order = std::get<cli::RenderOrder>(cli::parseCommandLine(
      {"render", "out/fan/trajectory.h5", "--video", "deployment.webm", "--fps", "25", "--speed",
       "0.5", "--hold", "1", "--crf", "30", "--view", "iso"}));
  EXPECT_EQ(order.trajectories.front(), "out/fan/trajectory.h5");
  EXPECT_EQ(order.settings.videoFile, "deployment.webm");
  EXPECT_EQ(order.settings.framesPerSecond, 25);
  EXPECT_EQ(order.settings.speed, 0.5);
  EXPECT_EQ(order.settings.pace, record::Pace::Real);
  EXPECT_EQ(order.settings.hold, 1);
  EXPECT_EQ(order.settings.crf, 30);
  EXPECT_THROW(cli::parseCommandLine({"render"}), InputError);
  EXPECT_THROW(cli::parseCommandLine({"render", "x.h5", "--video", "there/talk.webm"}), InputError);
}

}  // namespace
}  // namespace kirireel
