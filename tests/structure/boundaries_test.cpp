// The boundaries between modules and the rules of the code, checked in the sources.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace {

namespace fs = std::filesystem;
using ::testing::IsEmpty;
using ::testing::SizeIs;

struct SourceFile {
  std::string path;  ///< relative to the repository
  std::set<std::string> includes;
};

std::string readText(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

std::set<std::string> includesOf(const std::string& text) {
  static const std::regex pattern("#\\s*include\\s*[<\"]([^>\"]+)[>\"]");
  std::set<std::string> includes;
  for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match) {
    includes.insert((*match)[1]);
  }
  return includes;
}

/// All C++ files of sim/ and render/.
const std::vector<SourceFile>& sources() {
  static const std::vector<SourceFile> files = [] {
    std::vector<SourceFile> found;
    const fs::path root = KIRIREEL_SOURCE_DIR;
    for (const char* floor : {"sim", "render"}) {
      for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / floor)) {
        const fs::path ending = entry.path().extension();
        if (ending != ".h" && ending != ".cpp") continue;
        found.push_back(
            {fs::relative(entry.path(), root).string(), includesOf(readText(entry.path()))});
      }
    }
    return found;
  }();
  return files;
}

/// "FILE includes HEADER" for every include that matches, in files whose path starts so.
std::vector<std::string> uses(const std::string& module, const std::string& headerPattern) {
  const std::regex pattern(headerPattern);
  std::vector<std::string> found;
  for (const SourceFile& file : sources()) {
    if (!file.path.starts_with(module)) continue;
    for (const std::string& header : file.includes) {
      if (std::regex_match(header, pattern)) found.push_back(file.path + " includes " + header);
    }
  }
  return found;
}

/// The files anywhere that include a matching header.
std::set<std::string> usersOf(const std::string& headerPattern) {
  const std::regex pattern(headerPattern);
  std::set<std::string> users;
  for (const SourceFile& file : sources()) {
    for (const std::string& header : file.includes) {
      if (std::regex_match(header, pattern)) users.insert(file.path);
    }
  }
  return users;
}

constexpr const char* kBullet = "(bt[A-Z]|Bullet|LinearMath|bullet/).*";

TEST(Boundaries, SourcesAreFound) {
  // Otherwise all checks below would pass.
  EXPECT_GT(sources().size(), 50U);
  EXPECT_THAT(uses("sim/base/", "sim/base/error\\.h"), testing::Not(IsEmpty()));
}

TEST(Boundaries, SimulationNeverIncludesRendering) {
  EXPECT_THAT(uses("sim/", "render/.*"), IsEmpty());
}

TEST(Boundaries, OnlyContactsAndEnginesIncludeBullet) {
  for (const std::string& user : usersOf(kBullet)) {
    EXPECT_TRUE(user.starts_with("sim/contacts/") || user.starts_with("sim/engines/")) << user;
  }
  EXPECT_FALSE(usersOf(kBullet).empty());
}

/// "sim/run/run" of run.h and run.cpp.
std::string unitOf(const std::string& path) {
  return path.substr(0, path.rfind('.'));
}

// A unit is a header with its source. Units that include each other, directly or through others,
// can only be read and changed together.
TEST(Boundaries, NoUnitsIncludeEachOther) {
  std::map<std::string, std::set<std::string>> included;
  for (const SourceFile& file : sources()) {
    for (const std::string& header : file.includes) {
      if (unitOf(header) != unitOf(file.path)) included[unitOf(file.path)].insert(unitOf(header));
    }
  }
  // Adds what each unit reaches until nothing changes.
  std::map<std::string, std::set<std::string>> reached = included;
  for (bool grows = true; grows;) {
    grows = false;
    for (auto& [unit, others] : reached) {
      const std::size_t before = others.size();
      for (const std::string& other : std::set<std::string>(others)) {
        const auto found = reached.find(other);
        if (found != reached.end()) others.insert(found->second.begin(), found->second.end());
      }
      grows = grows || others.size() > before;
    }
  }
  EXPECT_GT(reached.size(), 100U);
  for (const auto& [unit, others] : reached) EXPECT_FALSE(others.contains(unit)) << unit;
}

// Modules that the three main jobs do not need can change independently.
TEST(Boundaries, LeavesAreIncludedByFewModules) {
  const std::map<std::string, std::set<std::string>> allowed = {{"sim/generate/", {"sim/study/"}},
                                                                {"sim/path/", {"sim/deploy/"}},
                                                                {"sim/statics/", {"sim/deploy/"}},
                                                                {"sim/study/", {}},
                                                                {"render/fea/", {"render/export/"}},
                                                                {"render/report/", {}},
                                                                {"render/page/", {}},
                                                                {"render/sweep/", {}}};
  for (const auto& [leaf, others] : allowed) {
    int count = 0;
    for (const SourceFile& file : sources()) {
      const bool isAllowed =
          file.path == "sim/sim.h" || file.path.starts_with(leaf) ||
          file.path.starts_with("render/cli/") || file.path.starts_with("render/python/") ||
          std::ranges::any_of(
              others, [&file](const std::string& module) { return file.path.starts_with(module); });
      for (const std::string& header : file.includes) {
        if (!header.starts_with(leaf)) continue;
        ++count;
        EXPECT_TRUE(isAllowed) << file.path << " includes " << header;
      }
    }
    EXPECT_GT(count, 0) << leaf;
  }
}

TEST(Boundaries, MechanicsAndMeasuresDoNotIncludeContacts) {
  EXPECT_THAT(uses("sim/mechanics/", "sim/(contacts|engines)/.*"), IsEmpty());
  EXPECT_THAT(uses("sim/trajectory/", "sim/(contacts|engines)/.*"), IsEmpty());
}

TEST(Boundaries, ContactsDoNotIncludeTheEngines) {
  EXPECT_THAT(uses("sim/contacts/", "sim/engines/.*"), IsEmpty());
}

TEST(Boundaries, EachLibraryStaysInOneSourceFile) {
  EXPECT_THAT(usersOf("GL/osmesa\\.h"), SizeIs(1));
  EXPECT_THAT(usersOf("EGL/.*"), SizeIs(1));
  EXPECT_THAT(usersOf("libav.*|libsw.*"), SizeIs(1));
  EXPECT_THAT(usersOf("png\\.h"), SizeIs(1));
  EXPECT_THAT(usersOf("hdf5\\.h|H5.*|highfive/.*"), SizeIs(1));
  EXPECT_THAT(usersOf("zlib\\.h"), SizeIs(1));
  EXPECT_THAT(usersOf("geos.*"), SizeIs(1));
  EXPECT_THAT(usersOf("pugixml.*"), SizeIs(1));
  EXPECT_THAT(usersOf("assimp/.*"), SizeIs(1));
  EXPECT_THAT(usersOf("openssl/.*"), SizeIs(1));
  EXPECT_THAT(usersOf("toml\\+\\+/.*"), SizeIs(1));
  EXPECT_THAT(usersOf("cairo.*"), SizeIs(1));
  EXPECT_THAT(usersOf("fontconfig/.*"), SizeIs(1));
  EXPECT_THAT(usersOf("ft2build\\.h|FT_.*|freetype/.*"), SizeIs(1));
  EXPECT_THAT(usersOf("fribidi.*"), SizeIs(1));
  EXPECT_THAT(usersOf("hb\\.h|hb-.*|harfbuzz/.*"), SizeIs(1));
}

TEST(Boundaries, SimulationHasNoOptionalLibraries) {
  EXPECT_THAT(usersOf("(chipmunk|box2d|mujoco)/.*"), IsEmpty());
  // Nobody compiles a branch for a build without a library. Conditions on existing libraries, and
  // on the processor, are listed.
  const std::regex condition("# *(?:if|ifdef|ifndef|elif|elifdef|elifndef)\\b[^\n]*");
  std::vector<std::string> found;
  for (const SourceFile& file : sources()) {
    if (!file.path.starts_with("sim/")) continue;
    const std::string text = readText(fs::path(KIRIREEL_SOURCE_DIR) / file.path);
    for (std::sregex_iterator match(text.begin(), text.end(), condition), end; match != end;
         ++match) {
      found.push_back(file.path + ": " + match->str());
    }
  }
  EXPECT_THAT(found, testing::UnorderedElementsAre(
                         "sim/mechanics/block_cholesky.cpp: #ifdef KIRIREEL_HAS_AVX2_KERNELS",
                         "sim/scene/toml_file.cpp: #if "
                         "__has_include(<toml++/impl/unicode_autogenerated.h>)",
                         "sim/trajectory/array_file.cpp: #ifndef H5_HAVE_THREADSAFE"));
  // CMake would hide a source instead.
  for (const fs::directory_entry& module :
       fs::directory_iterator(fs::path(KIRIREEL_SOURCE_DIR) / "sim")) {
    if (!module.is_directory()) continue;
    const std::string text = readText(module.path() / "CMakeLists.txt");
    EXPECT_FALSE(
        std::regex_search(text, std::regex("_FOUND|NOTFOUND|find_library|find_path|QUIET")))
        << module.path();
  }
}

TEST(Boundaries, CommandLineLibraryStaysInTheCommandLine) {
  for (const std::string& user : usersOf("CLI/.*")) EXPECT_TRUE(user.starts_with("render/cli/"));
}

TEST(Boundaries, PythonStaysInItsModule) {
  for (const std::string& user : usersOf("pybind11/.*")) {
    EXPECT_TRUE(user.starts_with("render/python/")) << user;
  }
}

// The keys of scene files and of Python are settings' names; only the command line has options.
TEST(Boundaries, SimulationNamesNoOption) {
  const std::regex option("\"[^\"\n]*--[a-z{][^\"\n]*\"");
  std::vector<std::string> found;
  for (const SourceFile& file : sources()) {
    if (!file.path.starts_with("sim/")) continue;
    const std::string text = readText(fs::path(KIRIREEL_SOURCE_DIR) / file.path);
    for (std::sregex_iterator match(text.begin(), text.end(), option), end; match != end; ++match) {
      found.push_back(file.path + ": " + match->str());
    }
  }
  EXPECT_THAT(found, IsEmpty());
}

TEST(Boundaries, EveryHeaderIsIncludedOnce) {
  for (const SourceFile& file : sources()) {
    if (!file.path.ends_with(".h")) continue;
    const std::string text = readText(fs::path(KIRIREEL_SOURCE_DIR) / file.path);
    EXPECT_NE(text.find("#pragma once"), std::string::npos) << file.path;
    EXPECT_TRUE(text.starts_with("/// ")) << file.path << " has no comment with its purpose";
  }
}

/// The product's own text files, tests apart.
std::vector<fs::path> productFiles() {
  std::vector<fs::path> files;
  const fs::path root = KIRIREEL_SOURCE_DIR;
  const std::set<std::string> apart = {".git", ".cache", "build", "out", "tests"};
  for (const fs::directory_entry& top : fs::directory_iterator(root)) {
    if (apart.contains(top.path().filename().string())) continue;
    if (top.is_regular_file()) files.push_back(top.path());
    if (!top.is_directory()) continue;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(top.path())) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
  }
  return files;
}

TEST(Boundaries, ProductDependsOnNothingOutsideTheRepository) {
  for (const fs::path& file : productFiles()) {
    EXPECT_EQ(readText(file).find("../shared"), std::string::npos) << file;
    EXPECT_EQ(readText(file).find("/work/"), std::string::npos) << file;
  }
}

TEST(Boundaries, OnlyGmshAndCalculixAreStarted) {
  const std::regex start(
      "::(system|popen|execl|execle|execlp|execv|execve|execvp|execvpe|fexecve|"
      "posix_spawn|posix_spawnp|wordexp|dlopen)\\s*\\(");
  std::vector<std::string> starters;
  for (const SourceFile& file : sources()) {
    const std::string text = readText(fs::path(KIRIREEL_SOURCE_DIR) / file.path);
    if (std::regex_search(text, start)) starters.push_back(file.path);
  }
  EXPECT_THAT(starters, testing::ElementsAre("render/fea/outside_program.cpp"));
}

// A name that the system refuses must not end in its exception.
TEST(Boundaries, NamesAreLookedUpWithoutExceptions) {
  const std::regex throwing("\\b(fs|filesystem)::(exists|is_\\w+)\\([^;{]*\\)");
  const std::regex quiet("status|error|ignored");
  for (const SourceFile& file : sources()) {
    const std::string text = readText(fs::path(KIRIREEL_SOURCE_DIR) / file.path);
    for (std::sregex_iterator found(text.begin(), text.end(), throwing), end; found != end; ++found)
      EXPECT_TRUE(std::regex_search(found->str(), quiet)) << file.path << ": " << found->str();
  }
}

// In a folder that lists its sources, a new test is not in the build unless it is listed.
TEST(Boundaries, EveryTestIsBuilt) {
  int tests = 0;
  for (const fs::directory_entry& entry :
       fs::recursive_directory_iterator(fs::path(KIRIREEL_SOURCE_DIR) / "tests")) {
    if (!entry.path().filename().string().ends_with("_test.cpp")) continue;
    ++tests;
    const std::string lists = readText(entry.path().parent_path() / "CMakeLists.txt");
    const bool hasAll = lists.find("SOURCES") == std::string::npos;
    EXPECT_TRUE(hasAll || lists.find(entry.path().filename().string()) != std::string::npos)
        << entry.path();
  }
  EXPECT_GT(tests, 100);
}

// New versions of fmt declare `join` only there.
TEST(Boundaries, FilesThatJoinTextsIncludeItsHeader) {
  for (const SourceFile& file : sources()) {
    const std::string text = readText(fs::path(KIRIREEL_SOURCE_DIR) / file.path);
    if (text.find("fmt::join(") == std::string::npos) continue;
    EXPECT_TRUE(file.includes.contains("fmt/ranges.h")) << file.path;
  }
}

// The files that a run reads identify it, so all of them must be recorded.
TEST(Boundaries, InputFilesAreOpenedInOnePlace) {
  EXPECT_THAT(usersOf("fstream"), testing::ElementsAre("sim/base/files.cpp", "sim/base/files.h"));
  const std::regex construction("\\b(if|f)stream(\\s+\\w+)?\\s*[({]");
  const std::regex others(
      "\\b(fopen|freopen|H5Fopen|parse_file|avformat_open_input|read_from_file|FT_New_Face|mmap)"
      "\\s*\\("
      "|[^\\w]::open\\(|begin_read_from_file");
  std::set<std::string> opening;
  for (const SourceFile& file : sources()) {
    const std::string text = readText(fs::path(KIRIREEL_SOURCE_DIR) / file.path);
    if (std::regex_search(text, construction)) opening.insert(file.path);
    if (std::regex_search(text, others)) opening.insert(file.path);
  }
  EXPECT_THAT(opening, testing::UnorderedElementsAre(
                           "sim/base/files.cpp", "sim/base/files.h",
                           "sim/trajectory/array_file.cpp",    // after it was opened there
                           "render/cli/sweep_command.cpp",     // to write messages
                           "render/output/output_folder.cpp",  // to lock a folder
                           "render/picture/label.cpp",         // the system's font
                           "render/sweep/collect.cpp",         // to lock
                           "render/picture/video.cpp"));       // its own files
}

TEST(Boundaries, TimeIsMeasuredByClocksThatNeverJump) {
  const std::regex wall(
      "system_clock|high_resolution_clock|CLOCK_REALTIME|gettimeofday|"
      "\\bstd::time\\(|\\btime\\((nullptr|NULL|0)\\)");
  for (const SourceFile& file : sources()) {
    const std::string text = readText(fs::path(KIRIREEL_SOURCE_DIR) / file.path);
    EXPECT_FALSE(std::regex_search(text, wall)) << file.path;
  }
}

/// "sim/mechanics" for "sim/mechanics/joint_solver.h"; empty for files outside modules.
std::string moduleOf(const std::string& path) {
  static const std::regex pattern("((sim|render)/[^/]+)/.*");
  std::smatch match;
  return std::regex_match(path, match, pattern) ? match[1].str() : "";
}

/// All modules, in the order in which CMake takes them.
std::vector<std::string> modules() {
  static const std::regex pattern("add_subdirectory\\((\\w+)\\)");
  std::vector<std::string> found;
  for (const std::string floor : {"sim", "render"}) {
    const std::string text = readText(fs::path(KIRIREEL_SOURCE_DIR) / floor / "CMakeLists.txt");
    for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end;
         ++match) {
      found.push_back(floor + "/" + (*match)[1].str());
    }
  }
  return found;
}

/// A library of a module, and its links.
struct Library {
  std::string module;
  std::set<std::string> links;
};

/// All libraries by their names.
std::map<std::string, Library> libraries() {
  static const std::regex declaration("kirireel_module\\((\\w+)([^)]*)\\)");
  static const std::regex link("kirireel_(\\w+)");
  std::map<std::string, Library> found;
  for (const std::string& module : modules()) {
    const std::string text = readText(fs::path(KIRIREEL_SOURCE_DIR) / module / "CMakeLists.txt");
    for (std::sregex_iterator match(text.begin(), text.end(), declaration), end; match != end;
         ++match) {
      Library& library = found[(*match)[1]];
      library.module = module;
      const std::string list = (*match)[2];
      for (std::sregex_iterator name(list.begin(), list.end(), link); name != end; ++name) {
        library.links.insert((*name)[1]);
      }
    }
  }
  return found;
}

TEST(Boundaries, ModulesIncludeAndLinkOnlyModulesAboveThem) {
  const std::vector<std::string> order = modules();
  ASSERT_GT(order.size(), 10U);
  const auto rank = [&order](const std::string& module) {
    return std::ranges::find(order, module) - order.begin();
  };
  for (const SourceFile& file : sources()) {
    for (const std::string& header : file.includes) {
      const std::string module = moduleOf(header);
      if (module.empty()) continue;
      EXPECT_LE(rank(module), rank(moduleOf(file.path))) << file.path << " includes " << header;
    }
  }
  const std::map<std::string, Library> all = libraries();
  for (const auto& [name, library] : all) {
    for (const std::string& link : library.links) {
      const auto linked = all.find(link);
      ASSERT_NE(linked, all.end()) << name << " links " << link;
      EXPECT_LE(rank(linked->second.module), rank(library.module)) << name << " links " << link;
    }
  }
}

/// The modules that a module links, directly or through others.
std::set<std::string> modulesWithinReach(const std::string& module) {
  const std::map<std::string, Library> all = libraries();
  std::vector<std::string> open;
  for (const auto& [name, library] : all) {
    if (library.module == module) open.push_back(name);
  }
  std::set<std::string> seen;
  std::set<std::string> reached;
  while (!open.empty()) {
    const std::string name = open.back();
    open.pop_back();
    if (!seen.insert(name).second) continue;
    reached.insert(all.at(name).module);
    for (const std::string& link : all.at(name).links) open.push_back(link);
  }
  return reached;
}

TEST(Boundaries, ModulesLinkWhatTheyInclude) {
  std::map<std::string, std::set<std::string>> reach;
  for (const std::string& module : modules()) reach[module] = modulesWithinReach(module);
  for (const SourceFile& file : sources()) {
    for (const std::string& header : file.includes) {
      const std::string module = moduleOf(header);
      const bool isForOthers = moduleOf(file.path).empty();  // sim/sim.h, render/render.h
      if (module.empty() || isForOthers || file.path.ends_with("/main.cpp")) continue;
      EXPECT_TRUE(reach[moduleOf(file.path)].contains(module))
          << file.path << " includes " << header;
    }
  }
}

/// The text without comments, literals and preprocessor lines. Line numbers stay.
std::string codeOnly(const std::string& text) {
  std::string code;
  std::size_t at = 0;
  const auto skipPast = [&](const std::string& end, std::size_t from) {
    const std::size_t found = text.find(end, from);
    const std::size_t stop = found == text.npos ? text.size() : found + end.size();
    code.append(static_cast<std::size_t>(std::count(text.begin() + at, text.begin() + stop, '\n')),
                '\n');
    at = stop;
  };
  while (at < text.size()) {
    const char letter = text[at];
    const bool startsLine = at == 0 || text[at - 1] == '\n';
    // A single quote after a digit groups digits.
    const bool isQuote = letter == '"' || (letter == '\'' && !std::isalnum(text[at - 1]));
    if (text.compare(at, 2, "//") == 0 || (startsLine && letter == '#')) {
      skipPast("\n", at);
    } else if (text.compare(at, 2, "/*") == 0) {
      skipPast("*/", at);
    } else if (text.compare(at, 3, "R\"(") == 0) {
      skipPast(")\"", at);
    } else if (isQuote) {
      std::size_t end = at + 1;
      while (end < text.size() && text[end] != letter) end += text[end] == '\\' ? 2 : 1;
      skipPast(std::string(1, letter), end);
    } else {
      code += letter;
      ++at;
    }
  }
  return code;
}

/// A block between braces, or an alias of a type.
struct Block {
  enum Kind { Namespace, Type, Function, Other } kind = Other;
  std::string name = {};  ///< of a namespace or a type; "" for a namespace without one
  int firstLine = 0;
  int lastLine = 0;
  std::string scope = {};  ///< the names of the blocks around it, with :: after each
};

/// The kind of a block, by the words before its brace.
Block blockAfter(const std::string& words, Block::Kind around) {
  static const std::regex space("\\s*(inline )?namespace( ?[\\w:]*)\\s*");
  static const std::regex type(
      "[^=]*?\\b(struct|class|union|enum class|enum) ([\\w:]+)( final)?\\s*(:[^]*)?\\s*");
  std::smatch match;
  Block block;
  const bool isOpen = around == Block::Namespace || around == Block::Type;
  if (std::regex_match(words, match, space)) {
    block.kind = Block::Namespace;
    block.name = std::regex_replace(match[2].str(), std::regex("\\s"), "");
  } else if (std::regex_match(words, match, type)) {
    block.kind = Block::Type;
    block.name = match[2];
  } else if (isOpen && words.find('(') != words.npos) {
    block.kind = Block::Function;
  }
  return block;
}

/// All blocks of a source file but those within functions.
std::vector<Block> blocksOf(const std::string& text) {
  const std::string code = codeOnly(text);
  std::vector<Block> closed;
  std::vector<Block> open = {{Block::Namespace}};
  static const std::regex alias("^\\s*using (\\w+) =");
  std::smatch match;
  std::string words;
  int line = 1;
  for (const char letter : code) {
    if (letter == '\n') ++line;
    if (letter == '{') {
      Block block = blockAfter(words, open.back().kind);
      block.firstLine = line;
      block.scope = open.back().scope + open.back().name + "::";
      open.push_back(block);
    } else if (letter == '}' && open.size() > 1) {
      open.back().lastLine = line;
      closed.push_back(open.back());
      open.pop_back();
    } else if (letter == ';' && std::regex_search(words, match, alias)) {
      closed.push_back(
          {Block::Type, match[1], line, line, open.back().scope + open.back().name + "::"});
    }
    words += letter;
    if (letter == ';' || letter == '{' || letter == '}') words.clear();
  }
  return closed;
}

/// The namespace of a module's folder.
std::string namespaceOf(const std::string& path) {
  const std::string module = *std::next(fs::path(path).begin());
  if (module == "base") return "kirireel";
  // `export` is a word of C++.
  return "kirireel::" + (module == "export" ? "exports" : module);
}

TEST(Boundaries, EachModuleHasItsNamespace) {
  int count = 0;
  for (const SourceFile& file : sources()) {
    if (std::ranges::distance(fs::path(file.path)) < 3) continue;  // sim.h, render.h
    const std::string own = namespaceOf(file.path);
    for (const Block& block : blocksOf(readText(fs::path(KIRIREEL_SOURCE_DIR) / file.path))) {
      const bool isOutermost = block.kind == Block::Namespace && block.scope == "::";
      if (!isOutermost || block.name.empty()) continue;
      ++count;
      // CLI's types are announced in headers.
      const bool isWithin = block.name.starts_with(own + "::");
      EXPECT_TRUE(block.name == own || isWithin || block.name == "CLI")
          << file.path << ": " << block.name;
    }
  }
  EXPECT_GT(count, 200);
}

TEST(Boundaries, TypesAreDefinedOnce) {
  // Two definitions of one name are undefined behaviour. A linker need not report it.
  std::map<std::string, std::vector<std::string>> places;
  for (const SourceFile& file : sources()) {
    for (const Block& block : blocksOf(readText(fs::path(KIRIREEL_SOURCE_DIR) / file.path))) {
      const bool isHidden = block.scope.find("::::", 2) != block.scope.npos;  // has no name
      if (block.kind == Block::Type && !isHidden) {
        places[block.scope + block.name].push_back(file.path);
      }
    }
  }
  EXPECT_GT(places.size(), 200U);
  for (const auto& [name, files] : places) EXPECT_THAT(files, SizeIs(1)) << name;
}

TEST(Boundaries, TypesHaveUniqueNames) {
  std::map<std::string, std::vector<std::string>> places;
  for (const SourceFile& file : sources()) {
    for (const Block& block : blocksOf(readText(fs::path(KIRIREEL_SOURCE_DIR) / file.path))) {
      const bool isMade = block.kind == Block::Type && block.lastLine > block.firstLine;
      // Internals that a header declares have that class's name; a Kind is that of its type.
      const bool isPart = block.name.find("::") != block.name.npos || block.name == "Kind";
      if (isMade && !isPart) places[block.name].push_back(file.path);
    }
  }
  EXPECT_GT(places.size(), 300U);
  for (const auto& [name, files] : places) EXPECT_THAT(files, SizeIs(1)) << name;
}

/// Words of a page between backquotes.
std::vector<std::string> namesIn(const std::string& page) {
  static const std::regex quoted("`([^`\n]+)`");
  const std::string text = readText(fs::path(KIRIREEL_SOURCE_DIR) / page);
  std::vector<std::string> names;
  for (std::sregex_iterator match(text.begin(), text.end(), quoted), end; match != end; ++match) {
    names.push_back((*match)[1]);
  }
  return names;
}

// Those in a folder by their paths, others only by their names.
TEST(Boundaries, FilesInPagesExist) {
  const fs::path root = KIRIREEL_SOURCE_DIR;
  std::set<std::string> fileNames;
  for (const char* folder : {"sim", "render", "tests", "scripts", "docs"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
      fileNames.insert(entry.path().filename().string());
    }
  }
  static const std::regex path("(sim|render|tests|scripts|docs|data)/[a-z0-9_./-]+");
  static const std::regex source("[a-z0-9_]+\\.(h|cpp)");
  int count = 0;
  for (const char* page : {"ARCHITECTURE.md", "CONTRIBUTING.md", "docs/step.md"}) {
    for (const std::string& name : namesIn(page)) {
      if (std::regex_match(name, path)) {
        EXPECT_TRUE(fs::exists(root / name)) << page << ": " << name;
      } else if (std::regex_match(name, source)) {
        EXPECT_TRUE(fileNames.contains(name)) << page << ": " << name;
      } else {
        continue;
      }
      ++count;
    }
  }
  EXPECT_GT(count, 100);
}

}  // namespace
