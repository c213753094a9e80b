// Decks for Abaqus against docs/abaqus_keywords.csv, a table made from its manual: keywords, their
// place in the model or a step, parameters and number of fields in a row of data.
#include <algorithm>
#include <map>
#include <numbers>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "render/fea/deck.h"
#include "render/fea/element_mesh.h"
#include "render/fea/job.h"
#include "tests/support/files.h"
#include "tests/support/layouts.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, at);) {
    const std::size_t first = word.find_first_not_of(' ');
    words.push_back(first == std::string::npos ? "" : word.substr(first));
  }
  return words;
}

/// The manual's rules of a keyword.
struct Keyword {
  std::string place;                                        ///< model, step or both
  std::map<std::string, std::set<std::string>> parameters;  ///< with their values, if these are few
  std::set<std::string> required;
  std::size_t minFields = 0;
  std::size_t maxFields = 0;
};

/// Reads a cell: parameters separated by "|", each with its one value if it has one, or a single
/// parameter with all its values, as in TYPE=S4|S8R.
void addParameters(const std::string& cell, Keyword& keyword, bool isRequired) {
  std::string last;
  for (const std::string& word : split(cell, '|')) {
    const std::size_t equals = word.find('=');
    const bool isValue = equals == std::string::npos && !last.empty() &&
                         !keyword.parameters[last].empty() && cell.find(last + "=") == 0;
    if (isValue) {
      keyword.parameters[last].insert(word);
      continue;
    }
    last = word.substr(0, equals);
    keyword.parameters[last];
    if (equals != std::string::npos) keyword.parameters[last].insert(word.substr(equals + 1));
    if (isRequired) keyword.required.insert(last);
  }
}

std::map<std::string, Keyword> manual() {
  std::map<std::string, Keyword> table;
  std::istringstream lines(test::bytesOf(KIRIREEL_SOURCE_DIR "/docs/abaqus_keywords.csv"));
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    const std::vector<std::string> cells = split(line, ',');
    Keyword& keyword = table[cells.at(0)];
    keyword.place = cells.at(1);
    addParameters(cells.at(2), keyword, true);
    addParameters(cells.at(3), keyword, false);
    if (cells.at(4) == "text") {
      keyword.maxFields = 100;
    } else {
      const std::vector<std::string> bounds = split(cells.at(4), '-');
      keyword.minFields = std::stoul(bounds.front());
      keyword.maxFields = std::stoul(bounds.back());
    }
    EXPECT_TRUE(cells.at(5).starts_with("simakey-r-")) << line;
  }
  return table;
}

/// Checks decks line by line, and stores the used keywords.
class KeywordChecker {
 public:
  void read(const std::string& deck) {
    isInStep_ = false;
    std::istringstream lines(deck);
    for (std::string line; std::getline(lines, line);) {
      EXPECT_LE(line.size(), 256U);
      if (line.starts_with("**")) continue;
      line.starts_with("*") ? readKeyword(line) : readData(line);
    }
    EXPECT_FALSE(isInStep_);
  }

  std::vector<std::string> unused() const {
    std::vector<std::string> names;
    for (const auto& [name, keyword] : table_) {
      if (!used_.contains(name)) names.push_back(name);
    }
    return names;
  }

 private:
  void readKeyword(const std::string& line) {
    const std::vector<std::string> words = split(line, ',');
    const std::string name = words.at(0).substr(1);
    ASSERT_TRUE(table_.contains(name)) << line;
    keyword_ = &table_.at(name);
    used_.insert(name);
    if (name == "STEP") isInStep_ = true;
    const bool isForBoth = keyword_->place == "both";
    EXPECT_TRUE(isForBoth || (keyword_->place == "step") == isInStep_) << line;
    if (name == "END STEP") isInStep_ = false;
    std::set<std::string> missing = keyword_->required;
    for (std::size_t k = 1; k < words.size(); ++k) {
      const std::vector<std::string> parts = split(words[k], '=');
      missing.erase(parts.at(0));
      const auto found = keyword_->parameters.find(parts.at(0));
      ASSERT_NE(found, keyword_->parameters.end()) << line;
      if (found->second.empty()) continue;
      EXPECT_TRUE(parts.size() == 2 && found->second.contains(parts[1])) << line;
    }
    EXPECT_TRUE(missing.empty()) << line;
  }

  void readData(const std::string& line) const {
    ASSERT_NE(keyword_, nullptr) << line;
    const std::size_t fields = split(line, ',').size();
    EXPECT_GE(fields, keyword_->minFields) << line;
    EXPECT_LE(fields, keyword_->maxFields) << line;
  }

  std::map<std::string, Keyword> table_ = manual();
  std::set<std::string> used_;
  const Keyword* keyword_ = nullptr;
  bool isInStep_ = false;
};

/// All decks and jobs on a mesh at these poses.
void checkAll(KeywordChecker& checker, const fea::ElementMesh& mesh, const Poses& poses,
              fea::DeckSettings settings = {}) {
  const fea::DeckOrigin origin = {"squares", "final", 0.5, 0.02, 0, "Kirireel", "a run"};
  settings.solver = fea::Solver::Abaqus;
  settings.drive = {fea::DriveChoice::All, {}};
  checker.read(fea::meshDeck(mesh, settings, origin));
  for (const fea::DeckJob& job :
       {fea::staticJob(mesh, settings, origin, "x_mesh.inp"),
        fea::bucklingJob(mesh, settings, origin, "x_mesh.inp"),
        fea::driveJob(mesh, settings, origin, "x_mesh.inp", {{0, 1}, {poses, poses}})}) {
    checker.read(job.sets);
    checker.read(job.text);
  }
}

/// Those of squares on hinges with these elements.
void checkDecks(KeywordChecker& checker, const fea::ElementRule& rule,
                model::JointFace face = model::JointFace::Both) {
  model::Model model = generate::makeTessellation(test::squares(2, 2, 0.7));
  for (model::Joint& joint : model.joints) joint.face = face;
  const test::Layout layout = test::layoutOf(model.tiles, model.joints);
  checkAll(checker, fea::makeElementMesh(layout.bricks, layout.joints, layout.poses, rule),
           layout.poses);
}

TEST(AbaqusDecks, OfNecksHaveTheKeywordsOfTheManual) {
  if (!test::hasProgram("gmsh")) GTEST_SKIP() << "install gmsh to mesh sheets with necks";
  KeywordChecker abaqus;
  const model::Model model = generate::makeTessellation(test::squares(2, 2, 0));
  const Poses poses = test::layoutOf(model.tiles, model.joints).poses;
  for (const fea::ElementFamily family :
       {fea::ElementFamily::Solid, fea::ElementFamily::Shell, fea::ElementFamily::Plane}) {
    for (const bool isQuadratic : {true, false}) {
      const fea::ElementRule rule{.perEdge = 2,
                                  .quadratic = isQuadratic,
                                  .joints = fea::JointStyle::Neck,
                                  .family = family,
                                  .neck = {.width = 0.05, .length = 0.1}};
      checkAll(abaqus, fea::makeNeckMesh(model, 0.02, rule), poses);
    }
  }
}

TEST(AbaqusDecks, HaveTheKeywordsOfTheManual) {
  KeywordChecker abaqus;
  for (const fea::JointStyle style :
       {fea::JointStyle::Shared, fea::JointStyle::Equation, fea::JointStyle::Patch}) {
    checkDecks(abaqus, {.perEdge = 4, .joints = style});
    checkDecks(abaqus, {.perEdge = 4, .quadratic = false, .joints = style});
  }
  checkDecks(abaqus, {.family = fea::ElementFamily::Shell});
  checkDecks(abaqus, {.quadratic = false, .family = fea::ElementFamily::Shell},
             model::JointFace::Top);
  const test::Layout layout = test::hingedSquares();
  fea::ElementMesh patched = fea::makeElementMesh(layout.bricks, layout.joints, layout.poses,
                                                  {.perEdge = 4, .joints = fea::JointStyle::Patch});
  patched.springs = {{0, 0, 1, 5, 0.1}, {1, 0, 1, 5, 0.1, {0.6, 0, 0.8}}};
  checkAll(abaqus, patched, layout.poses);
  const fea::ElementMesh shared =
      fea::makeElementMesh(layout.bricks, layout.joints, layout.poses, {.perEdge = 4});
  fea::DeckSettings settings;
  settings.contactFriction = 0.3;
  settings.periodic = true;
  checkAll(abaqus, shared, layout.poses, settings);
  settings.solver = fea::Solver::Abaqus;
  const fea::DeckOrigin origin;
  abaqus.read(fea::periodicJob(shared, settings, origin, "x_mesh.inp").text);
  abaqus.read(fea::stateMapJob(shared, shared, settings, origin, "x_mesh.inp").text);
  // Every keyword of the table is in some deck.
  EXPECT_EQ(abaqus.unused(), std::vector<std::string>());
}

}  // namespace
}  // namespace kirireel
