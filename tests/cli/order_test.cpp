// Fingerprints of orders depend on every option, but not on its spelling or position.
#include <algorithm>
#include <regex>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/cli/command_line.h"
#include "render/cli/option_group.h"
#include "sim/scene/settings.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using Words = std::vector<std::string>;

/// Two values of an option that are not its default; empty for a flag.
struct Sample {
  std::string option;
  Words values;
  Words needed = {};  ///< required for an effect of the option
};

/// Options that a setting requires by its conditions, e.g. --solver direct.
Words neededFor(const scene::Setting& setting) {
  Words words;
  for (const scene::Condition& condition : setting.conditions) {
    if (condition.isWithout || condition.holds(scene::openScene())) continue;
    const std::string needed = cli::spellOptions(condition.needed);
    for (const std::string_view word : scene::split(needed, ' ')) words.emplace_back(word);
  }
  return words;
}

/// The sample of a number, a word or a flag: the first two valid values that are not its default.
Sample sampleOf(const scene::Setting& setting) {
  Sample sample{cli::optionName(setting.key), {}, neededFor(setting)};
  if (setting.isSwitch) return sample;
  const Words values =
      setting.words.empty() ? Words{"0.5", "3", "0.25", "7", "0.001", "1000"} : setting.words;
  for (const std::string& value : values) {
    scene::Scene scene = scene::openScene();
    try {
      setting.read(scene, {setting.key, value});
    } catch (const InputError&) {
      continue;
    }
    if (setting.write(scene) == setting.write(scene::openScene())) continue;
    sample.values.push_back(value);
    if (sample.values.size() == 2) break;
  }
  return sample;
}

/// A scene file with a grip. Without it a load has no steps.
std::string gripScene() {
  static const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "grip.toml";
  std::ofstream(file) << "[[grip]]\ntile = 0\nmove = {x = 0.1}\n";
  return file.string();
}

/// Samples of values beyond a setting's own description: texts, and ends of ranges.
const std::vector<Sample>& chosenSamples() {
  static const std::vector<Sample> all = {
      {"--fps", {"30", "50"}},
      {"--unit", {"mm", "km"}},
      {"--export-unit", {"mm"}, {"--export", "obj"}},
      {"--faces", {"fold", "pykirigami"}},
      {"--split-tiles", {"all", "0,2"}},
      {"--joints-file", {"a.txt"}},
      {"--frame", {"0", "3"}},
      {"--fold", {"0.5", "0.99"}},
      {"--join-coplanar", {}},
      {"--cut", {"red", "rgb(255,0,0),slits"}},
      {"--ignore", {"#0000ff"}},
      {"--widest-neck", {"0.002"}},
      {"--joint-at", {"middle"}},
      {"--target", {"a.txt"}},
      {"--pin", {"0", "3,0,7"}},
      {"--fix", {"0,1", "1,2"}},
      {"--link", {"0,1,2,3", "0,1,3,2"}},
      {"--thickness", {"0.03", "1e-3"}},
      {"--mass", {"prism"}},
      {"--density", {"2700", "1e12"}, {"--mass", "prism"}},
      {"--actuation", {"expansion", "none"}},
      {"--spring-stiffness", {"25", "0"}},
      {"--torque-stiffness", {"25", "0"}},
      {"--force-damping", {"25", "0.1"}},
      {"--torque-damping", {"25", "0.1"}},
      {"--hinge-stiffness", {"0.25", "1e6"}},
      {"--hinge-neck", {"0.1,0.3,2e9", "0.01,1,1e6,0.4", "2e9", "1e6,0.4"}},
      {"--ligaments", {}, {"--hinge-neck", "0.1,0.3,2e9"}},
      {"--ligament-stiffness", {"120,1,0.1", "1e6,3,0.02"}, {"--hinge-stiffness", "0.25"}},
      {"--panels", {"2e9", "2e9,0.4,0.05"}},
      {"--hinge-rest", {"33.3", "-7"}, {"--hinge-stiffness", "1"}},
      {"--hinge-damping", {"0.25", "1e6"}},
      {"--hinge-file", {"hinges.txt"}},
      {"--to", {"closed"}},
      {"--path", {"straight", "guided"}},
      {"--load-steps", {"3", "7"}, {"--scene", gripScene()}},
      {"--gravity", {"-9.81", "0,0.1,-9.81"}},
      {"--ground", {}},
      {"--ground-friction", {"0.3", "0"}},
      {"--no-align", {}},
      {"--solver", {"bullet"}},
      {"--timestep", {"0.01", "0.001"}},
      {"--tolerance", {"0.01", "1e-6"}},
      {"--measure-time-error", {}},
      {"--planar", {"on", "off"}},
      {"--seed", {"2", "4294967295"}},
      {"--export", {"obj", "inp,msh"}},
      {"--states", {"all", "0%,1.5s", "event:settled, \"so\""}, {"--export", "obj"}},
      {"--hinge-width", {"0.01", "0.1"}, {"--export", "svg"}},
      {"--elements-per-edge", {"4", "3"}, {"--export", "inp"}},
      {"--elements-through", {"1", "3"}, {"--export", "inp"}},
      {"--element-size", {"0.1", "0.2"}, {"--export", "inp"}},
      {"--linear", {}, {"--export", "inp"}},
      {"--joints", {"equation", "neck"}, {"--export", "inp"}},
      {"--patch-radius", {"0.1", "0.2"}, {"--export", "inp", "--joints", "patch"}},
      {"--neck-width", {"0.1", "0.2"}, {"--export", "inp", "--joints", "neck"}},
      {"--neck-length", {"0.1", "0.2"}, {"--export", "inp", "--joints", "neck"}},
      {"--neck-radius", {"0.1", "0.2"}, {"--export", "inp", "--joints", "neck"}},
      {"--kerf", {"0.1", "0.2"}, {"--export", "inp", "--joints", "neck"}},
      {"--shells", {}, {"--export", "inp"}},
      {"--plane-stress", {}, {"--export", "inp"}},
      {"--deck-solver", {"abaqus"}, {"--export", "inp"}},
      {"--sets", {"joints", "all"}, {"--export", "inp"}},
      {"--youngs", {"2e11", "1e7"}, {"--export", "inp"}},
      {"--poisson", {"0.25", "-0.5"}, {"--export", "inp"}},
      {"--deck-density", {"7850", "1200"}, {"--export", "inp"}},
      {"--deck-unit", {"mm-N"}, {"--export", "inp"}},
      {"--drive", {"all", "0,5"}, {"--export", "inp"}},
      {"--buckle", {}, {"--export", "inp"}},
      {"--periodic", {}, {"--export", "inp"}},
      {"--deck-contacts", {"0", "0.3"}, {"--export", "inp"}},
      {"--state-map", {}, {"--export", "inp"}},
      {"--size", {"640x480", "96x64"}},
      {"--grid", {"1x2", "4x4"}},
      {"--captions", {"none", "gap,time"}},
      {"--scale-bar", {}},
      {"--dpi", {"300", "72.5"}},
      {"--width", {"180mm", "88"}},
      {"--font-size", {"7pt", "8.5"}},
      {"--letters", {"a", "(a)", "A"}},
      {"--arrows", {}},
      {"--column-heads", {"flat,half,open", "0%,1°,\"x\""}},
      {"--figure", {"svg", "pdf,svg"}},
      {"--snapshots", {"time"}},
      {"--frames", {}},
      {"--frames-at", {"0,1.5,7%", "33.3%"}},
      {"--no-snapshots", {}},
      {"--svg", {}},
      {"--theme", {"dark"}},
      {"--colour", {"error", "gap"}},
      {"--colour-map", {"cividis", "coolwarm"}, {"--colour", "error"}},
      {"--colour-least", {"-1", "0.01"}, {"--colour", "error"}},
      {"--colour-most", {"0.1", "3"}, {"--colour", "error"}},
      {"--brick-colour", {"102030", "#FFFFFF", "teal"}},
      {"--back-colour", {"salmon"}},
      {"--tile-colour", {"0=teal", "hinge row:0,2-4=102030"}},
      {"--opacity", {"0.5", "0"}},
      {"--tile-opacity", {"0=0.25", "2-4=0"}},
      {"--outline-colour", {"grey"}},
      {"--outline-width", {"0.5", "2"}},
      {"--background", {"beige"}},
      {"--ground-look", {"plate", "none"}},
      {"--transparent", {}},
      {"--no-outlines", {}},
      {"--mark-joints", {}},
      {"--target-lines", {}},
      {"--trail", {"0,1", "3,2"}},
      {"--ghost", {"target", "start"}},
      {"--depth-cue", {"0.5", "0.1"}},
      {"--view", {"top", "iso", "side", "45,30", "33.3,-7.1"}},
      {"--projection", {"parallel", "perspective"}},
      {"--zoom", {"2", "0.5"}},
      {"--margin", {"0.1", "0.2"}},
      {"--distance", {"3", "0.1"}},
      {"--fit", {"run", "ends"}},
      {"--orbit", {"90", "-33.3"}},
      {"--camera-keys", {"0:50:-35:1,2.5:90:-20:1.5", "0:1.1:-2.2:3.3"}},
      {"--video", {"talk.webm", "a b.gif"}},
      {"--no-video", {}},
      {"--pace", {"real"}},
      {"--length", {"4", "12.5"}},
      {"--speed", {"0.5", "3"}},
      {"--hold", {"0.25", "3"}},
      {"--title", {"Squares \\ \"open\"", "\tat last"}},
      {"--subtitle", {"two\nlines"}},
      {"--progress-bar", {}},
      {"--inset", {"target_error", "theta"}},
      {"--crf", {"0", "30"}},
      {"--preset", {"slow", "medium"}},
      {"--occlusion", {"0", "0.3"}},
      {"--font", {"DejaVu Serif", "Liberation Sans"}},
      {"--encoder", {"libx264", "mpeg4"}},
      {"--no-meshes", {}},
  };
  return all;
}

/// Those, and one of every other setting of a scene.
const std::vector<Sample>& samples() {
  static const std::vector<Sample> all = [] {
    std::vector<Sample> made = chosenSamples();
    for (const scene::SettingGroup& group : scene::sceneSettings()) {
      for (const scene::Setting& setting : group.settings) {
        const auto isKnown = [&](const Sample& one) {
          return one.option == cli::optionName(setting.key);
        };
        if (std::ranges::none_of(chosenSamples(), isKnown)) made.push_back(sampleOf(setting));
      }
    }
    return made;
  }();
  return all;
}

/// Options that do not change a run: its folder, its printed text, the file of its settings, the
/// library and the number of threads of its pictures.
const std::set<std::string> kWithoutEffect = {"--help",    "--out",     "--resume", "--json",
                                              "--page",    "--scene",   "--gl",     "--strict",
                                              "--verbose", "--painters"};

cli::RecordOrder orderOf(const Words& options) {
  Words words = {"record", "model"};
  words.insert(words.end(), options.begin(), options.end());
  return std::get<cli::RecordOrder>(cli::parseCommandLine(words));
}

std::string termsOf(const Words& options) {
  return orderOf(options).text.terms;
}

Words given(const Sample& sample, std::size_t value) {
  Words words = sample.needed;
  words.push_back(sample.option);
  if (!sample.values.empty()) words.push_back(sample.values[value]);
  return words;
}

TEST(Orders, HaveASampleOfEveryOption) {
  const std::string help =
      std::get<cli::PrintOrder>(cli::parseCommandLine({"record", "--help", "all"})).text;
  const std::regex pattern("\n  (?:-h,)?(--[a-z-]+)");
  std::set<std::string> known = kWithoutEffect;
  for (const Sample& sample : samples()) known.insert(sample.option);
  int count = 0;
  for (std::sregex_iterator match(help.begin(), help.end(), pattern), end; match != end; ++match) {
    EXPECT_TRUE(known.contains((*match)[1])) << (*match)[1];
    ++count;
  }
  EXPECT_EQ(count, static_cast<int>(known.size()));
}

TEST(Orders, DifferInEveryOption) {
  for (const Sample& sample : samples()) {
    std::set<std::string> terms = {termsOf(sample.needed)};
    const std::size_t values = std::max<std::size_t>(1, sample.values.size());
    for (std::size_t k = 0; k < values; ++k) terms.insert(termsOf(given(sample, k)));
    EXPECT_EQ(terms.size(), values + 1) << sample.option;
  }
}

/// Lengths in the unit of the model become metres; gravity and density are in SI units.
TEST(Orders, ConvertLengthsToMetres) {
  const Words words = {"record",      KIRIREEL_SOURCE_DIR "/data/tessellation_4x4",
                       "--gravity",   "-9.81",
                       "--mass",      "prism",
                       "--density",   "1000",
                       "--thickness", "20",
                       "--unit",      "mm"};
  std::vector<std::string> warnings;
  const scene::Scene scene =
      cli::prepareOrder(std::get<cli::RecordOrder>(cli::parseCommandLine(words)), warnings).scene;
  EXPECT_DOUBLE_EQ(scene.environment.gravity.z(), -9.81);
  EXPECT_DOUBLE_EQ(scene.brick.density, 1000);
  EXPECT_DOUBLE_EQ(scene.brick.thickness, 0.02);
  EXPECT_DOUBLE_EQ(model::tileSize(scene.model), 1e-3);
}

TEST(Orders, DoNotDifferInOptionsWithoutEffect) {
  const std::string plain = termsOf({});
  for (const Words& words :
       {Words{"--out", "there"}, Words{"--resume"}, Words{"--json"}, Words{"--page"},
        Words{"--verbose"}, Words{"--gl", "egl"}, Words{"--painters", "2"}}) {
    EXPECT_EQ(termsOf(words), plain) << words.front();
  }
}

// The oracle is the round trip: written words are read back as the same order.
TEST(Orders, AreMadeAgainFromTheirSettings) {
  const test::TemporaryFolder folder;
  for (const Sample& sample : samples()) {
    const std::size_t values = std::max<std::size_t>(1, sample.values.size());
    for (std::size_t k = 0; k < values; ++k) {
      const cli::OrderText text = orderOf(given(sample, k)).text;
      std::ofstream(folder / "scene.toml", std::ios::binary) << text.scene;
      const cli::OrderText again = orderOf({"--scene", (folder / "scene.toml").string()}).text;
      EXPECT_EQ(again.terms, text.terms) << sample.option;
      EXPECT_EQ(again.scene, text.scene) << sample.option;
    }
  }
}

TEST(Orders, AreTheSameInAnySpelling) {
  const Words plain = {"--thickness", "0.03", "--contacts", "unjoined"};
  for (const Words& words :
       {Words{"--thickness=0.03", "--contacts=unjoined"},
        Words{"--contacts", "unjoined", "--thickness", "3e-2"},
        Words{"--thickness", "7", "--thickness", "0.03", "--contacts", "unjoined"}}) {
    EXPECT_EQ(termsOf(words), termsOf(plain)) << words.front();
  }
  // PyKirigami's spellings select its defaults.
  Words peer = plain;
  peer.insert(peer.end(), {"--spring-stiffness", "100", "--torque-stiffness", "100",
                           "--force-damping", "50", "--torque-damping", "2", "--path", "dynamic",
                           "--actuation", "target", "--tolerance", "0"});
  for (const Words& words :
       {Words{"-bt", "0.030", "--no_collision"},
        Words{"--like", "pykirigami", "--thickness", "0.03", "--contacts", "unjoined"},
        Words{"--brick_thickness=+0.03", "--no-collision", "--fps", "60", "--headless"}}) {
    EXPECT_EQ(termsOf(words), termsOf(peer)) << words.front();
  }
  EXPECT_EQ(termsOf({"--ground"}), termsOf({"--ground-friction", "0.5"}));
  EXPECT_EQ(termsOf({"--gravity", "-9.81"}), termsOf({"--gravity", "0,0,-9.81"}));
  EXPECT_EQ(termsOf({"--captions", "gap,time"}), termsOf({"--captions", "time,gap"}));
}

TEST(Orders, AreTheSameWithTheModelLast) {
  for (const Sample& sample : samples()) {
    const Words options = given(sample, 0);
    Words words = {"record"};
    words.insert(words.end(), options.begin(), options.end());
    words.push_back("model");
    const auto order = std::get<cli::RecordOrder>(cli::parseCommandLine(words));
    EXPECT_EQ(order.model, "model") << sample.option;
    EXPECT_EQ(order.text.terms, termsOf(options)) << sample.option;
  }
}

TEST(Orders, AreTheSameInASceneFile) {
  const test::TemporaryFolder folder;
  const auto termsOfScene = [&](const std::string& scene) {
    std::ofstream(folder / "scene.toml", std::ios::binary) << scene;
    return termsOf({"--scene", (folder / "scene.toml").string()});
  };
  EXPECT_EQ(termsOfScene("[model]\nthickness = 0.030 # metres\n[environment]\nground = true\n"),
            termsOf({"--ground", "--thickness", "0.03"}));
  EXPECT_EQ(termsOfScene("[environment]\ngravity = [0, 0, -1]\n"), termsOf({"--gravity", "-1"}));
  // The content of timelines and obstacles matters, not their spelling.
  const std::string moved = termsOfScene(
      "[[obstacle]]\nshape = 'sphere'\nradius = 1\nposition = [0, 0, 1]\n"
      "[[timeline]]\nat = 1\npin = [0]\n");
  EXPECT_EQ(termsOfScene("[[timeline]]\npin=[0]\nat=1.0\n\n# a ball\n"
                         "[[obstacle]]\nposition=[0,0,1.0]\nshape=\"sphere\"\nradius=1.0\n"),
            moved);
  EXPECT_NE(termsOfScene("[[timeline]]\npin=[0]\nat=1.5\n"
                         "[[obstacle]]\nposition=[0,0,1.0]\nshape=\"sphere\"\nradius=1.0\n"),
            moved);
}

TEST(OrderFingerprints, DependOnContentNotOnFolders) {
  const InputFile vertices{"m/vertices.txt", "aa"};
  const InputFile pulled{"m/pull.txt", "bb"};
  const auto print = [](const std::vector<InputFile>& files, const std::string& folder) {
    return cli::orderFingerprint("", {"m", files}, {folder});
  };
  const std::string plain = print({vertices, pulled}, "m");
  EXPECT_EQ(print({{"./m/vertices.txt", "aa"}, {"./m/pull.txt", "bb"}}, "./m"), plain);
  EXPECT_EQ(print({{"/m/vertices.txt", "aa"}, {"/m/pull.txt", "bb"}}, "/m"), plain);
  EXPECT_NE(print({vertices, {"m/pull.txt", "bc"}}, "m"), plain);
  EXPECT_NE(print({vertices, {"m/hull.txt", "bb"}}, "m"), plain);
  EXPECT_NE(print({vertices}, "m"), plain);
  EXPECT_EQ(print({{"rock.obj", "aa"}}, "m"), print({{"x/stone.obj", "aa"}}, "m"));
  EXPECT_EQ(plain.size(), 64U);
}

}  // namespace
}  // namespace kirireel
