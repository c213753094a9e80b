// The opening d of a sheet under 1 N at both ends (calculix_program.h) is its compliance in m/N,
// one figure for the whole mesh. It is computed with the chosen elements, d1, and with elements
// half as long, d2, and the change 100 (d2 / d1 - 1) per cent is told. A mesh that is fine enough
// changes little; with a joint of a single node the figure grows without limit, which shows here.
//
// Halving lengths in the plane makes four times as many elements; the number through the thickness
// stays, because bending is what is looked at.
#include "render/export/sensitivity.h"

#include <algorithm>

#include <fmt/format.h>

#include "render/export/state_choice.h"
#include "render/fea/boundary_sets.h"
#include "render/fea/calculix_program.h"
#include "render/fea/deck.h"
#include "render/fea/job.h"
#include "render/fea/neck_sheet.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

/// The rule with elements half as long; `usual` lie along edges where the rule does not say. Necks
/// and patches keep their sizes: they are part of what is asked about.
ElementRule halved(ElementRule rule, int usual) {
  if (rule.size > 0) {
    rule.size /= 2;
  } else {
    rule.perEdge = 2 * (rule.perEdge > 0 ? rule.perEdge : usual);
  }
  return rule;
}

/// The job is written in CalculiX's keywords and metres whatever the settings say, without sets
/// that nobody reads.
double openingOf(const ElementMesh& mesh, DeckSettings settings, const DeckOrigin& origin) {
  settings.solver = Solver::Calculix;
  settings.sets = SetChoice::None;
  settings.unit = DeckUnit::Model;
  settings.periodic = false;
  const DeckJob job = staticJob(mesh, settings, origin, "mesh.inp");
  return openingByCalculix(meshDeck(mesh, settings, origin) + job.sets, job.text,
                           longestAxis(mesh));
}

/// Metres by newton, with four digits, and the change in per cent.
std::string lineOf(const std::string& name, double own, double finer) {
  return fmt::format(
      "check: {}: 1 N at both ends moves them apart by {:.4g} m, {:.4g} m with elements half as "
      "long ({:+.2f}%)",
      name, own, finer, 100 * (finer / own - 1));
}

}  // namespace

std::vector<std::string> meshSensitivity(const TrajectoryReader& trajectory,
                                         const ExportSettings& settings) {
  if (std::ranges::find(settings.formats, ExportFormat::Inp) == settings.formats.end()) {
    throw InputError("error: --check runs the jobs of decks; add inp to --format");
  }
  const Subject& subject = trajectory.subject();
  DeckOrigin origin;
  origin.thickness = subject.brickRule.thickness;
  std::vector<std::string> lines;
  // `meshBy` makes the mesh of a rule; it is called twice.
  const auto check = [&](const std::string& name, const auto& meshBy, int usual) {
    const double own = openingOf(meshBy(settings.elements), settings.decks, origin);
    const double finer =
        openingOf(meshBy(halved(settings.elements, usual)), settings.decks, origin);
    lines.push_back(lineOf(name, own, finer));
  };
  if (settings.elements.joints == JointStyle::Neck) {
    const auto meshBy = [&](const ElementRule& rule) {
      return makeNeckMesh(subject.model, origin.thickness, rule);
    };
    check("flat sheet", meshBy, kUsualPerEdge);
    return lines;
  }
  for (const ChosenState& state : chooseStates(trajectory, settings.states)) {
    const Poses poses = trajectory.sample(state.sample).poses;
    const auto meshBy = [&](const ElementRule& rule) {
      return makeElementMesh(subject.bricks, subject.model.joints, poses, rule);
    };
    check(state.label, meshBy, usualPerEdge(subject.bricks, settings.elements));
  }
  return lines;
}

}  // namespace kirireel
