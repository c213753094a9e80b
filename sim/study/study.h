/// A study: cases that are run one after the other, each leaving rows of a table.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/study/table.h"

namespace kirireel {

/// How much of a study is run.
enum class Extent {
  Quick,  ///< fewer and smaller cases, all studies in minutes
  Full,
};

/// One case. Its rows follow from nothing but its name.
struct StudyCase {
  std::string name;                       ///< the first cell of its rows
  std::function<std::vector<Row>()> run;  ///< gives the cells after the first, at least one row
};

/// A figure that a table comes down to.
struct Finding {
  std::string name;     ///< short: "exponent_planar"
  double value = 0;     ///< not a number where the table lacks the rows for it
  std::string meaning;  ///< one phrase, with the unit
};

/// One study.
struct Study {
  std::string name;             ///< as typed: "work-precision"
  std::string help;             ///< one phrase
  std::vector<Column> columns;  ///< after the first, which is "case"
  std::function<std::vector<StudyCase>(Extent)> cases;
  /// From the rows alone, so that a table that was read gives the same.
  std::function<std::vector<Finding>(const Table&)> findings;
};

/// All studies, in the order in which `all` runs them.
const std::vector<Study>& studies();

/// The study of that name. Throws InputError that suggests the nearest.
const Study& studyNamed(const std::string& name);

// The studies, one file each.
Study workPrecisionStudy();
Study movingStudy();
Study scalingStudy();
Study tessellationStudy();
Study squareToDiskStudy();
Study sensitivityStudy();
Study hardCasesStudy();

}  // namespace kirireel
