// The rows of Chipmunk, Box2D and MuJoCo in the studies of Kirireel, as tables next to its own:
// FOLDER/engines/NAME.csv and NAME.json for FOLDER/NAME.csv, which `kirireel study NAME --out
// FOLDER` makes first. scripts/plot-study and scripts/accuracy take both.
#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <fmt/format.h>

#include "sim/base/error.h"
#include "tests/bench/engines/other_rows.h"
#include "tests/bench/engines/other_worlds.h"

namespace kirireel::bench {
namespace {

struct Order {
  std::string name;
  std::filesystem::path folder = "out/study";
  bool quick = false;
  bool resume = false;
};

std::string versions() {
  return fmt::format("compiler {}, eigen {}.{}.{}, chipmunk {}, box2d {}, mujoco {}", __VERSION__,
                     EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION,
                     chipmunkVersion(), box2dVersion(), mujocoVersion());
}

void runOne(const study::Study& study, const Order& order) {
  study::StudySettings settings;
  settings.folder = order.folder / "engines";
  settings.extent = order.quick ? study::Extent::Quick : study::Extent::Full;
  settings.resume = order.resume;
  settings.command = fmt::format("engines {}{}", order.name, order.quick ? " --quick" : "");
  settings.versions = versions();
  const study::Table own = study::readCsv(order.folder / (study.name + ".csv"));
  requireComparable(own, settings.extent);
  const study::Study compared = comparedWith(study, own);
  const study::Table table =
      study::runStudy(compared, settings, [](const std::string& name, std::size_t, std::size_t) {
        fmt::print(stderr, "{}\n", name);
        return true;
      });
  fmt::print("{}: {} rows in {}\n", study.name, table.rows.size(),
             (settings.folder / (study.name + ".csv")).string());
  for (const study::Finding& finding : compared.findings(table)) {
    fmt::print("  {:<40} {:<12.4g} {}\n", finding.name, finding.value, finding.meaning);
  }
}

int run(int argc, char** argv) {
  CLI::App program("Prints what Chipmunk, Box2D and MuJoCo cost in the studies of Kirireel");
  Order order;
  std::vector<std::string> names = {"all"};
  for (const study::Study& study : otherStudies()) names.push_back(study.name);
  program.add_option("NAME", order.name, "a study, or all")
      ->required()
      ->check(CLI::IsMember(names));
  program
      .add_option("--out", order.folder,
                  "has NAME.csv of kirireel study; gets engines/NAME.csv and NAME.json")
      ->capture_default_str();
  program.add_flag("--quick", order.quick, "the studies' quick form");
  program.add_flag("--resume", order.resume, "keep the finished rows of an interrupted run");
  CLI11_PARSE(program, argc, argv);
  for (const study::Study& study : otherStudies()) {
    if (order.name == "all" || order.name == study.name) runOne(study, order);
  }
  return 0;
}

}  // namespace
}  // namespace kirireel::bench

int main(int argc, char** argv) {
  try {
    return kirireel::bench::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
