// Runs the cases of a study one after the other and keeps what is finished. The rows of a case
// follow from its name alone, so that a resumed study takes the rows of an earlier file for every
// case that has some. The caption says on which machine and with which versions a table was made,
// since times mean nothing without them.
#include "sim/study/run_study.h"

#include <cmath>
#include <set>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/utsname.h>

#include "sim/base/error.h"
#include "sim/base/input_file.h"
#include "sim/base/pending_file.h"
#include "sim/world/bullet_world.h"
#include "sim/world/baseline_worlds.h"

namespace kirireel {
namespace {

using Json = nlohmann::ordered_json;

// Linux tells it; other systems leave it unknown.
std::string processorName() {
  std::ifstream file = openInputFile("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line)) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown processor";
}

// An engine that this build lacks is called absent, so that a gap in a table explains itself.
std::string engineVersions() {
  const auto named = [](const char* name, const std::string& version) {
    return fmt::format(", {} {}", name, version.empty() ? "absent" : version);
  };
  return fmt::format("bullet {}{}{}{}", bulletVersion(), named("chipmunk", chipmunkVersion()),
                     named("box2d", box2dVersion()), named("mujoco", mujocoVersion()));
}

// What has to be the same for two tables to be comparable, and how to make the table again.
Caption makeCaption(const Study& study, const StudySettings& settings) {
  Caption caption;
  caption.study = study.name;
  caption.extent = settings.extent == Extent::Quick ? "quick" : "full";
  caption.command = settings.command;
  caption.machine = machineText();
  caption.versions = fmt::format("{}, {}", settings.versions, engineVersions());
  return caption;
}

std::filesystem::path csvPath(const Study& study, const StudySettings& settings) {
  return settings.folder / (study.name + ".csv");
}

/// The rows of an earlier run, which must be one of the same kind.
std::vector<Row> finishedRows(const Table& table, const StudySettings& settings,
                              const Study& study) {
  const std::filesystem::path file = csvPath(study, settings);
  if (!settings.resume || !exists(file)) return {};
  const Table earlier = readCsv(file);
  if (earlier.caption.extent != table.caption.extent) {
    throw InputError(fmt::format(
        "{}: error: this is a {} study, which a {} one cannot resume; use the same options or "
        "another --out",
        file.string(), earlier.caption.extent, table.caption.extent));
  }
  if (earlier.columns.size() == table.columns.size()) return earlier.rows;
  throw InputError(
      fmt::format("{}: error: {} columns, but this version's study has {}; leave --resume out",
                  file.string(), earlier.columns.size(), table.columns.size()));
}

// Runs a case and puts its name in front of each row: the first column of every table.
std::vector<Row> rowsOf(const StudyCase& studyCase) {
  std::vector<Row> rows = studyCase.run();
  for (Row& row : rows) row.insert(row.begin(), studyCase.name);
  return rows;
}

}  // namespace

// Times are of this machine: processor, cores that the system offers, system and architecture.
std::string machineText() {
  utsname system{};
  uname(&system);
  return fmt::format("{}, {} cores, {} {}", processorName(), std::thread::hardware_concurrency(),
                     system.sysname, system.machine);
}

// The file is written after each case, so that nothing is lost when the study is ended.
Table runStudy(const Study& study, const StudySettings& settings, const StudyObserver& observer) {
  makeFolder(settings.folder);
  Table table;
  table.caption = makeCaption(study, settings);
  table.columns.push_back({"case", "what the row is a result of"});
  table.columns.insert(table.columns.end(), study.columns.begin(), study.columns.end());
  const std::vector<Row> earlier = finishedRows(table, settings, study);
  const std::vector<StudyCase> cases = study.cases(settings.extent);
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const std::size_t before = table.rows.size();
    for (const Row& row : earlier) {
      if (row.front() == cases[k].name) table.rows.push_back(row);
    }
    // The earlier run had finished this case.
    if (table.rows.size() > before) continue;
    if (!observer(cases[k].name, k, cases.size())) return table;
    const std::vector<Row> rows = rowsOf(cases[k]);
    table.rows.insert(table.rows.end(), rows.begin(), rows.end());
    writeTextFile(csvPath(study, settings), csvText(table));
  }
  writeTextFile(csvPath(study, settings), csvText(table));
  writeTextFile(settings.folder / (study.name + ".json"), studyJson(study, table));
  return table;
}

// The table with its findings, one space of indentation. Cells stay text, as they are in the CSV.
std::string studyJson(const Study& study, const Table& table) {
  const Caption& caption = table.caption;
  Json json;
  json["study"] = study.name;
  json["about"] = study.help;
  json["caption"] = {{"extent", caption.extent},
                     {"command", caption.command},
                     {"machine", caption.machine},
                     {"versions", caption.versions}};
  json["columns"] = Json::array();
  for (const Column& column : table.columns) {
    json["columns"].push_back({{"name", column.name}, {"meaning", column.meaning}});
  }
  json["rows"] = table.rows;
  json["findings"] = Json::array();
  for (const Finding& finding : study.findings(table)) {
    Json entry{{"name", finding.name}, {"value", nullptr}, {"meaning", finding.meaning}};
    // JSON has no number for "not a number": null stands for it.
    if (std::isfinite(finding.value)) entry["value"] = finding.value;
    json["findings"].push_back(std::move(entry));
  }
  return json.dump(1) + "\n";
}

}  // namespace kirireel
