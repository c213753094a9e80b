/// Runs a study and keeps its results in files.
#pragma once

#include <filesystem>
#include <functional>

#include "sim/study/study.h"

namespace kirireel {

/// How a study is run.
struct StudySettings {
  std::filesystem::path folder;  ///< gets NAME.csv and NAME.json; made when absent
  Extent extent = Extent::Full;
  bool resume = false;  ///< keep the rows that an earlier run of the same extent has finished
  std::string command;  ///< that was typed, for the caption
  /// Of the program and what it is made with; engines add their own.
  std::string versions;
};

/// Called before each case; `done` of `total` are finished. Return false to stop.
using StudyObserver =
    std::function<bool(const std::string& caseName, std::size_t done, std::size_t total)>;

/// Runs the cases in order. The CSV file is written anew whenever a case is finished, so that an
/// interrupted study keeps what it has; the JSON file, with the findings, comes at the end.
/// Returns the table, which lacks the cases after a stop. Throws InputError when `resume` meets a
/// file of another extent, OutputError when a file cannot be written.
Table runStudy(const Study& study, const StudySettings& settings, const StudyObserver& observer);

/// The table with its findings and the meaning of its columns as JSON.
std::string studyJson(const Study& study, const Table& table);

/// "NAME, CORES cores, SYSTEM" of this machine.
std::string machineText();

}  // namespace kirireel
