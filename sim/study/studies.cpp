// The list of all studies, and finding one by its name.
#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/error.h"
#include "sim/base/spelling.h"
#include "sim/study/study.h"

namespace kirireel {

// In the order in which "all" runs them. Made at the first call.
const std::vector<Study>& studies() {
  static const std::vector<Study> all{workPrecisionStudy(), movingStudy(), scalingStudy(),     tessellationStudy(),
                                      squareToDiskStudy(),  sensitivityStudy(), hardCasesStudy()};
  return all;
}

// Throws InputError for a name that no study has, with the nearest one as a suggestion.
const Study& studyNamed(const std::string& name) {
  std::vector<std::string> names;
  for (const Study& study : studies()) {
    if (study.name == name) return study;
    names.push_back(study.name);
  }
  names.emplace_back("all");
  throw InputError(fmt::format("error: no study {}{}; there are {}", name, suggestion(name, names),
                               fmt::join(names, ", ")));
}

}  // namespace kirireel
