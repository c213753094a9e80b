// Runs that `--resume` keeps as finished: random pairs of orders with one difference. The oracle is
// the kind of difference: another spelling, or another content.
#include <algorithm>
#include <cstdlib>
#include <functional>
#include <map>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

/// An option of `simulate`, two values of it, and its table of a scene file.
struct Choice {
  std::string option;
  std::string one;
  std::string other;
  std::string table;
};

const std::vector<Choice> kChoices = {
    {"--thickness", "0.02", "0.03", "model"},
    {"--spring-stiffness", "100", "25", "actuation"},
    {"--torque-stiffness", "100", "25", "actuation"},
    {"--force-damping", "50", "25.5", "actuation"},
    {"--torque-damping", "2", "1", "actuation"},
    {"--gravity", "0", "-0.1", "environment"},
    {"--timestep", "0.004", "0.005", "solver"},
    {"--linear-damping", "0.05", "0.1", "environment"},
    {"--fps", "60", "50", "recording"},
    {"--seed", "1", "2", "solver"},
    {"--substeps", "2", "3", "solver"},
    {"--planar", "auto", "off", "solver"},
    {"--path", "straight", "guided", "actuation"},
    {"--duration", "0.02", "0.01", "stop"},
};

/// The request of a run.
struct Request {
  fs::path model;
  std::map<std::string, std::string> options;  ///< without their hyphens and with their values
  std::string scene;                           ///< text of the scene file
};

class Orders : public testing::Test {
 protected:
  Orders() {
    EXPECT_EQ(run({"generate", "tessellation", at("m"), "--columns", "2", "--rows", "2"}), 0);
    writeText(at("m/pull.txt"), "0\n1\n2\n3\n");
    fs::copy(at("m/target.txt"), at("half.txt"));
    writeText(at("rock.obj"), "v 9 9 9\nv 10 9 9\nv 9 10 9.5\nf 1 2 3\n");
    for (const char* name : {"s.fold", "s_contracted.obj"}) {
      EXPECT_EQ(run({"convert", at("m"), at(name)}), 0);
    }
  }

  std::string at(const std::string& name) const { return (scratch_ / name).string(); }
  static int run(const std::vector<std::string>& words) { return runKirireel(words).exitCode; }

  /// Files that a run of the model reads, except the scene file.
  std::vector<std::string> inputsOf(const Request& requested) const {
    std::vector<std::string> files = {at("rock.obj"), at("half.txt")};
    const std::string name = requested.model.filename().string();
    if (name == "m") {
      for (const char* file : {"vertices.txt", "constraints.txt", "target.txt", "pull.txt"}) {
        files.push_back(at("m/") + file);
      }
    } else {
      files.push_back(at(name));
      if (name.ends_with(".obj")) files.push_back(at("s_deployed.obj"));
    }
    return files;
  }

  std::vector<std::string> wordsOf(const Request& requested) const {
    writeText(at("scene.toml"), requested.scene);
    std::vector<std::string> words = {
        "simulate", requested.model.string(), "--scene", at("scene.toml"), "--out", at("out")};
    for (const auto& [option, value] : requested.options)
      words.insert(words.end(), {option, value});
    return words;
  }

  /// Whether the second is kept as finished after a run of the first.
  bool isKnown(const std::vector<std::string>& second) const {
    std::vector<std::string> words = second;
    words.emplace_back("--resume");
    return runKirireel(words).out.find("finished already") != std::string::npos;
  }

  Request randomRequest() {
    Request requested;
    requested.model = at(std::vector<std::string>{"m", "s.fold", "s_contracted.obj"}[draw(3)]);
    requested.options = {{"--duration", "0.02"}, {"--path", "straight"}};
    for (const Choice& choice : kChoices) {
      if (draw(3) == 0) requested.options[choice.option] = draw(2) == 0 ? choice.one : choice.other;
    }
    requested.scene =
        "[[timeline]]\nat = 0.005\ntarget = \"half.txt\"\n"
        "[[obstacle]]\nshape = \"mesh\"\nfile = \"rock.obj\"\nfriction = 0.5\n";
    return requested;
  }

  std::size_t draw(std::size_t count) { return generator_() % count; }

  TemporaryFolder scratch_;
  std::mt19937 generator_{20};
};

/// Changes a digit of a text, which changes a number in it.
std::string withOtherDigit(std::string text, std::size_t which) {
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < text.size(); ++k) {
    if (std::isdigit(static_cast<unsigned char>(text[k]))) places.push_back(k);
  }
  char& digit = text[places[which % places.size()]];
  digit = digit == '9' ? '8' : static_cast<char>(digit + 1);
  return text;
}

TEST_F(Orders, DependOnEachByteOfEachFile) {
  for (const char* model : {"m", "s.fold", "s_contracted.obj"}) {
    Request requested = randomRequest();
    requested.model = at(model);
    fs::remove_all(at("out"));
    run(wordsOf(requested));
    EXPECT_TRUE(isKnown(wordsOf(requested))) << model;
    for (const std::string& file : inputsOf(requested)) {
      const std::string whole = readText(file);
      writeText(file, withOtherDigit(whole, draw(whole.size())));
      EXPECT_FALSE(isKnown(wordsOf(requested))) << file;
      writeText(file, whole);
      run(wordsOf(requested));
    }
  }
}

TEST_F(Orders, DependOnTheHull) {
  writeText(at("m/hull.txt"), "0 0\n0 1\n1 1\n3 2\n2 3\n");
  const std::vector<std::string> words = {"simulate", at("m"),   "--actuation", "boundary",
                                          "--out",    at("out"), "--duration",  "0.02"};
  run(words);
  EXPECT_TRUE(isKnown(words));
  writeText(at("m/hull.txt"), "0 0\n0 1\n1 1\n3 2\n3 3\n2 3\n");
  EXPECT_FALSE(isKnown(words));
}

TEST_F(Orders, AreMadeAgainFromTheirSummaries) {
  const auto summaryOf = [this](const std::string& out) {
    return nlohmann::json::parse(readText(at(out + "/summary.json")));
  };
  Request requested = randomRequest();
  requested.options["--pin"] = "3,0";
  requested.options["--export"] = "obj,msh";
  run(wordsOf(requested));
  const nlohmann::json summary = summaryOf("out");
  writeText(at("again.toml"), summary["settings"]["scene"]);
  run({"simulate", requested.model.string(), "--scene", at("again.toml"), "--out", at("again")});
  EXPECT_EQ(summaryOf("again")["order"], summary["order"]);
  EXPECT_EQ(summaryOf("again")["contents"], summary["contents"]);
  EXPECT_GE(summary["cost"]["factorizations"], summary["cost"]["steps"]);
  EXPECT_THAT(summary["inputs"].dump(), testing::HasSubstr("rock.obj"));
}

/// Another spelling of the same request.
class Respelling {
 public:
  Respelling(const Request& requested, const fs::path& folder,
             std::function<std::size_t(std::size_t)> draw)
      : request_(requested), folder_(folder), draw_(std::move(draw)) {}

  std::vector<std::string> words(
      const std::function<std::vector<std::string>(const Request&)>& wordsFor) {
    switch (draw_(6)) {
      case 0:
        return joined(wordsFor(request_));
      case 1:
        return wordsFor(withMoreDigits());
      case 2:
        return backwards();
      case 3:
        return wordsFor(inTheSceneFile());
      case 4:
        return wordsFor(elsewhere());
      default:
        return withDefaults(wordsFor(request_));
    }
  }

 private:
  /// "--option=value".
  static std::vector<std::string> joined(const std::vector<std::string>& words) {
    std::vector<std::string> result = {words[0], words[1]};
    for (std::size_t k = 2; k < words.size(); k += 2) {
      result.push_back(words[k] + "=" + words[k + 1]);
    }
    return result;
  }

  Request withMoreDigits() const {
    Request requested = request_;
    for (auto& [option, value] : requested.options) {
      if (value.find('.') != std::string::npos) value += "0";
    }
    return requested;
  }

  std::vector<std::string> backwards() const {
    std::vector<std::string> words = {"simulate"};
    for (auto option = request_.options.rbegin(); option != request_.options.rend(); ++option) {
      words.insert(words.end(), {option->first, option->second});
    }
    words.insert(words.end(), {"--out", (folder_ / "out").string(), "--scene",
                               (folder_ / "scene.toml").string(), request_.model.string()});
    return words;
  }

  Request inTheSceneFile() const {
    Request requested = request_;
    std::map<std::string, std::string> tables;
    for (const Choice& choice : kChoices) {
      const auto given = requested.options.find(choice.option);
      if (given == requested.options.end()) continue;
      std::string key = choice.option.substr(2);
      std::replace(key.begin(), key.end(), '-', '_');
      tables[choice.table] += key + " = \"" + given->second + "\"\n";
      requested.options.erase(given);
    }
    std::string text;
    for (const auto& [table, lines] : tables) text += "[" + table + "]\n" + lines;
    requested.scene = text + "# moved\n" + requested.scene;
    return requested;
  }

  /// A copy of the model, and another spelling of its path.
  Request elsewhere() const {
    Request requested = request_;
    const fs::path copy = folder_ / "copy" / ".." / "copy" / requested.model.filename();
    fs::remove_all(folder_ / "copy");
    fs::create_directory(folder_ / "copy");
    fs::copy(requested.model, copy, fs::copy_options::recursive);
    if (copy.extension() == ".obj") {
      fs::copy(folder_ / "s_deployed.obj", folder_ / "copy/s_deployed.obj");
    }
    requested.model = copy;
    return requested;
  }

  static std::vector<std::string> withDefaults(std::vector<std::string> words) {
    words.insert(words.end(), {"--angular-damping", "0.050", "--contacts", "auto"});
    return words;
  }

  const Request& request_;
  fs::path folder_;
  std::function<std::size_t(std::size_t)> draw_;
};

// 24 pairs here; KIRIREEL_ORDER_PAIRS asks for more.
TEST_F(Orders, AreFinishedIfTheyAreTheSame) {
  const char* asked = std::getenv("KIRIREEL_ORDER_PAIRS");
  const int pairs = asked ? std::atoi(asked) : 24;
  const auto wordsFor = [this](const Request& requested) { return wordsOf(requested); };
  int same = 0;
  for (int k = 0; k < pairs; ++k) {
    Request requested = randomRequest();
    fs::remove_all(at("out"));
    run(wordsOf(requested));
    ASSERT_TRUE(fs::exists(at("out/summary.json"))) << k;
    const std::string before = readText(at("out/summary.json"));
    std::string shown;
    const auto expectKnown = [&](const std::vector<std::string>& words, bool isSame) {
      for (const std::string& word : words) shown += word + " ";
      EXPECT_EQ(isKnown(words), isSame) << "pair " << k << ": " << shown;
      if (!isSame) return;
      EXPECT_TRUE(readText(at("out/summary.json")) == before) << shown;
    };
    switch (draw(4)) {
      case 0: {  // another value
        const Choice& choice = kChoices[draw(kChoices.size())];
        const std::string value = requested.options[choice.option];
        if (value.empty())
          requested.options[choice.option] = choice.other;
        else
          requested.options[choice.option] = value == choice.one ? choice.other : choice.one;
        expectKnown(wordsOf(requested), false);
        break;
      }
      case 1: {  // another byte in a file
        const std::vector<std::string> files = inputsOf(requested);
        const std::string file = files[draw(files.size())];
        const std::string whole = readText(file);
        shown = file + " ";
        writeText(file, withOtherDigit(whole, draw(whole.size())));
        expectKnown(wordsOf(requested), false);
        writeText(file, whole);
        break;
      }
      default:
        ++same;
        expectKnown(
            Respelling(requested, scratch_.path(), [this](std::size_t n) { return draw(n); })
                .words(wordsFor),
            true);
    }
  }
  EXPECT_GT(same, pairs / 4);
  EXPECT_LT(same, 3 * pairs / 4 + 1);
}

}  // namespace
}  // namespace kirireel
