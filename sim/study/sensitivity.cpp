// Decrease of the error over time for different stiffnesses, dampings and thicknesses. Two models
// are difficult for different reasons: a square to a disk locks on its path if the pull is stiff,
// and the bricks of a cap collide. There are twelve rows per second. Curves that exceed their
// budget of CPU time end early.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/study/stepped_scene.h"
#include "sim/study/study.h"

namespace kirireel::study {
namespace {

constexpr int kRowsASecond = 12;
// As in the square2disk study: a stiffness that reaches the target.
constexpr double kSpringStiffness = 25;

/// One curve of a panel.
struct SensitivityCurve {
  std::string family;
  std::string parameter;
  double value = 0;
  Method method;
  double seconds = 0;
  double budget = 0;  // CPU seconds
};

// The scene of a curve: the family's model with one value changed from the default.
scene::Scene sceneOf(const SensitivityCurve& curve) {
  scene::Scene scene = familyScene(curve.family);
  if (curve.family == "square-to-disk") scene.springs.springStiffness = kSpringStiffness;
  if (curve.parameter == "k_f") scene.springs.springStiffness = curve.value;
  if (curve.parameter == "mu_v") scene.springs.forceDamping = curve.value;
  if (curve.parameter == "thickness") {
    scene.brick.thickness = curve.value;
    // Without contacts the thickness has hardly any effect.
    scene.environment.contacts = scene::ContactFilter::All;
  }
  return scene;
}

// One row for each twelfth of a second.
std::vector<Row> follow(const SensitivityCurve& curve) {
  const scene::Scene scene = sceneOf(curve);
  SteppedScene run(scene, curve.method);
  const int steps = static_cast<int>(curve.seconds * curve.method.rate);
  const int perRow = curve.method.rate / kRowsASecond;
  std::vector<Row> rows;
  double gap = 0;
  for (int step = 1; step <= steps && run.isFinite(); ++step) {
    run.advance();
    gap = std::max(gap, run.gap());
    const bool last = step == steps || run.seconds() > curve.budget || !run.isFinite();
    if (step % perRow != 0 && !last) continue;
    const double error =
        trajectory::targetError(*scene.model.target, run.bricks(), run.motion().poses);
    rows.push_back({curve.family, curve.parameter, cell(curve.value), curve.method.engine.name,
                    cell(step / double(curve.method.rate)), cell(error), cell(gap),
                    cell(1e3 * run.seconds() * curve.method.rate / step)});
    if (last) break;
  }
  return rows;
}

// The values of a panel: N/m, N s/m, or metres.
std::vector<double> valuesOf(const std::string& parameter, bool quick) {
  if (parameter == "k_f")
    return quick ? std::vector{25.0, 200.0} : std::vector{10.0, 25.0, 50.0, 100.0, 200.0};
  if (parameter == "mu_v")
    return quick ? std::vector{10.0, 100.0} : std::vector{2.0, 10.0, 50.0, 100.0};
  return quick ? std::vector{0.005, 0.05} : std::vector{0.001, 0.005, 0.02, 0.05, 0.1};
}

// Every curve once with the direct solver and once with Bullet; a quick study has two values per
// panel.
std::vector<StudyCase> sensitivityCases(Extent extent) {
  const bool quick = extent == Extent::Quick;
  std::vector<StudyCase> made;
  for (const std::string family : {"square-to-disk", "cap"}) {
    for (const std::string parameter : {"k_f", "mu_v", "thickness"}) {
      for (const double value : valuesOf(parameter, quick)) {
        for (const Method& method : {Method{kDirect}, bulletBaseline()}) {
          const SensitivityCurve curve{family, parameter,         value,
                                       method, quick ? 1.0 : 4.0, quick ? 3.0 : 15.0};
          made.push_back({fmt::format("{} {} {} {}", family, parameter, value, toString(method)),
                          [curve] { return follow(curve); }});
        }
      }
    }
  }
  return made;
}

// Only panels of thickness have contacts. They are counted separately, because contacts change the
// gaps.
double largestGap(const Table& table, const std::string& engine, bool contacts) {
  return table.largest("gap_m", engine, [&](const Row& row) {
    return (table.text(row, "parameter") == "thickness") == contacts;
  });
}

std::vector<Finding> sensitivityFindings(const Table& table) {
  const std::string bullet = "sequential impulse";
  return {{"direct_gap", largestGap(table, "direct", false),
           "largest joint gap of the direct solver in the panels without contacts, metres"},
          {"bullet_gap", largestGap(table, bullet, false), "the same, Bullet, metres"},
          {"direct_gap_contacts", largestGap(table, "direct", true),
           "largest joint gap of the direct solver in the panels of thickness, metres"},
          {"bullet_gap_contacts", largestGap(table, bullet, true), "the same, Bullet, metres"}};
}

}  // namespace

Study sensitivityStudy() {
  return {"sensitivity",
          "k_f, mu_v and thickness on a square to a disk and on a cap: error by time",
          {{"model", "family of the model"},
           {"parameter", "k_f in N/m, mu_v in N s/m, or thickness in metres, with contacts"},
           {"value", "value of the parameter"},
           {"engine", "solver of the joints"},
           {"time_s", "simulated seconds"},
           {"error_m", "largest distance of a vertex from its target, metres"},
           {"gap_m", "largest joint gap up to then, metres"},
           {"cpu_ms_per_s", "CPU time per simulated second until then, milliseconds"}},
          sensitivityCases,
          sensitivityFindings};
}

}  // namespace kirireel::study
