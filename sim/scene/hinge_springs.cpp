// Springs at hinges: those of a file, one hinge a line, and those that all hinges have.
//
// 1. Hinges are found from the pivots that two bricks share (brick/hinge.h). In space, two tiles
//    may share an edge whose corners are joined only by way of other tiles, as where four panels of
//    an origami meet and the joints form a chain. For these folds all corners at one place are
//    joined pair by pair first, face by face, and folds that this adds are hinges too.
// 2. Each hinge gets a stiffness (N m/rad), a rest angle (rad) and a damping (N m s/rad): those of
//    its line in the file where the line has them, else those of all hinges. The stiffness of all
//    hinges may be that of a neck of material (neck_stiffness.h) where tiles turn about a corner. A
//    neck without length beside a slit that is shut at the start has the stiffness of the end of a
//    crack, which is its own table.
// 3. A rest angle at which bricks would lie in each other is refused, since contacts or joints
//    could never let the spring come to rest.
#include "sim/scene/hinge_springs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/model/neck_stiffness.h"
#include "sim/model/text_table.h"
#include "sim/scene/tile_numbers.h"

namespace kirireel {
namespace {

constexpr std::size_t kMostColumns = 5;
constexpr double kMostStiffness = 1e12;  // N m/rad, and N m s/rad
constexpr double kMostRest = 360;        // degrees
// Rest angles may be so far beyond what bricks can reach, radians: edges are flush but to rounding.
constexpr double kAngleRounding = 1e-6;

using TilePair = std::pair<int, int>;

int readTile(const TextTable& table, const TextLine& line, std::size_t column, const Model& model) {
  const FileLocation where = table.at(line, line.fields[column]);
  const int tile = parseWholeNumber(line.fields[column], where, "a tile number");
  return tileOfModel(tile, model, where);
}

/// A number of a line that need not be there.
std::optional<double> readOptional(const TextTable& table, const TextLine& line, std::size_t column,
                                   double least, double most, const char* meaning) {
  // A hyphen holds the place of a column that is left out, so that later columns can be given.
  if (column >= line.fields.size() || line.fields[column].text == "-") return std::nullopt;
  const TextField& field = line.fields[column];
  return parseNumberWithin(field, table.at(line, field), least, most, meaning);
}

OwnHingeSpring readSpring(const TextTable& table, const TextLine& line, const Model& model) {
  const FileLocation where = table.at(line, line.fields.front());
  if (line.fields.size() < 2 || line.fields.size() > kMostColumns) {
    throw inputErrorAt(where, fmt::format("there are {} columns; a hinge is tile, tile, stiffness, "
                                          "rest angle, damping, of which the last may be left out",
                                          line.fields.size()));
  }
  OwnHingeSpring spring;
  spring.tileA = readTile(table, line, 0, model);
  spring.tileB = readTile(table, line, 1, model);
  spring.stiffness =
      readOptional(table, line, 2, 0, kMostStiffness,
                   "a stiffness from 0 to 1e12 N m/rad, or - for that of all hinges");
  spring.rest = readOptional(table, line, 3, -kMostRest, kMostRest,
                             "a rest angle from -360 to 360 degrees, or - for that of all hinges");
  if (spring.rest) *spring.rest *= kDegree;
  spring.damping = readOptional(table, line, 4, 0, kMostStiffness,
                                "a damping from 0 to 1e12 N m s/rad, or - for that of all hinges");
  spring.where = where;
  return spring;
}

/// Bricks must not lie in each other where a spring is at rest. `line` says so, or null: the
/// option.
void requireRoomAtRest(const HingeSpring& spring, const OwnHingeSpring* line, const Model& model) {
  const Hinge& hinge = spring.hinge;
  if (spring.rest >= hinge.least - kAngleRounding && spring.rest <= hinge.most + kAngleRounding) {
    return;
  }
  const int first = model.fileOrder.countsFrom;
  const std::string message = fmt::format(
      "a rest angle of {:.6g} degrees closes tiles {} and {} into each other; give one from {:.6g} "
      "to {:.6g}",
      spring.rest / kDegree, first + hinge.brickA, first + hinge.brickB, hinge.least / kDegree,
      hinge.most / kDegree);
  throw line ? inputErrorAt(line->where, message) : InputError("--hinge-rest: error: " + message);
}

/// Joins every two corners that joints hold together on a face, also by way of others.
std::vector<Joint> joinedCorners(const std::vector<Joint>& joints, JointFace face) {
  using CornerKey = std::pair<int, int>;
  std::map<CornerKey, int> groupOf;
  std::vector<std::vector<Corner>> groups;
  const auto groupAt = [&](const Corner& corner) {
    const auto [place, isNew] =
        groupOf.try_emplace({corner.tile, corner.vertex}, static_cast<int>(groups.size()));
    if (isNew) groups.push_back({corner});
    return place->second;
  };
  for (const Joint& joint : joints) {
    if (joint.kind != JointKind::Pivot || (joint.face != face && joint.face != JointFace::Both)) {
      continue;
    }
    const int kept = groupAt(joint.a), emptied = groupAt(joint.b);
    if (kept == emptied) continue;
    // Corners of the emptied group move to the kept one. Groups have a few corners each.
    for (const Corner& corner : groups[static_cast<std::size_t>(emptied)]) {
      groupOf[{corner.tile, corner.vertex}] = kept;
      groups[static_cast<std::size_t>(kept)].push_back(corner);
    }
    groups[static_cast<std::size_t>(emptied)].clear();
  }
  std::vector<Joint> all;
  for (const std::vector<Corner>& group : groups) {
    for (std::size_t b = 1; b < group.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        if (group[a].tile != group[b].tile) all.push_back({group[a], group[b], face});
      }
    }
  }
  return all;
}

bool isFold(const Hinge& hinge) {
  // Angles at corners begin at 0, where tiles lie flush; folds go to both sides of flat.
  return hinge.least < 0;
}

/// Adds the folds between tiles whose common corners are joined by way of other tiles, as where
/// four tiles of an origami meet.
void addIndirectFolds(const Scene& scene, const std::vector<Brick>& bricks, FoundHinges& found) {
  // A pair that is joined directly has its hinge already.
  std::set<TilePair> known;
  for (const Hinge& hinge : found.hinges) known.insert(std::minmax(hinge.brickA, hinge.brickB));
  for (const JointFace face : {JointFace::Bottom, JointFace::Top}) {
    const FoundHinges joined =
        findHinges(bricks, makePivots(joinedCorners(scene.model.joints, face), bricks), false);
    for (const Hinge& hinge : joined.hinges) {
      const bool isNew = known.insert(std::minmax(hinge.brickA, hinge.brickB)).second;
      if (isFold(hinge) && isNew) found.hinges.push_back(hinge);
    }
  }
}

/// The hinges of a scene, of which there must be one at least.
FoundHinges requireHinges(const Scene& scene, const std::vector<Brick>& bricks) {
  // In the plane one shared point is a hinge about the vertical; in space it is a ball.
  const bool isPlanar = sceneNeeds(scene).planar.on;
  FoundHinges found = findHinges(bricks, makePivots(scene.model.joints, bricks), isPlanar);
  if (!isPlanar) addIndirectFolds(scene, bricks, found);
  if (!found.hinges.empty()) return found;
  if (found.ballJoints.empty()) {
    throw InputError(
        "error: springs need hinges, but no two tiles turn about a corner or an edge that they "
        "share; leave --hinge-stiffness away");
  }
  throw InputError(fmt::format(
      "error: springs need hinges, but in space joints at one corner of one face are balls, which "
      "turn about no axis ({} of them); join both faces (column 5 of constraints.txt: 3), or keep "
      "the sheet in its plane (--planar on)",
      found.ballJoints.size()));
}

/// What a hinge has of which no line of the file says more.
double stiffnessOf(const HingeSettings& all, const Hinge& hinge, const std::vector<Brick>& bricks,
                   const BrickRule& rule) {
  // Necks stand at corners. A fold has the stiffness of all hinges.
  const bool isCorner = hinge.least == 0;
  if (!all.neck || !isCorner) return all.stiffness;
  const bool isShut = hinge.start <= kAngleRounding;
  if (isShut && all.neck->length == 0) {
    const double side = neckSide(bricks, hinge.brickA, hinge.brickB);
    return cornerNeck(all.neck->youngs, rule.thickness, all.neck->width, side).bending;
  }
  return neckStiffness(all.neck->youngs, rule.thickness, all.neck->width, all.neck->length);
}

/// The lines of the file by their tiles, the lower first.
std::map<TilePair, const OwnHingeSpring*> byTiles(const std::vector<OwnHingeSpring>& own) {
  std::map<TilePair, const OwnHingeSpring*> lines;
  for (const OwnHingeSpring& line : own) lines[std::minmax(line.tileA, line.tileB)] = &line;
  return lines;
}

[[noreturn]] void refuseLine(const OwnHingeSpring& line, const FoundHinges& found, int first) {
  const TilePair tiles = std::minmax(line.tileA, line.tileB);
  const bool isBall = std::ranges::any_of(found.ballJoints, [&](const TilePair& ball) {
    return TilePair(std::minmax(ball.first, ball.second)) == tiles;
  });
  throw inputErrorAt(
      line.where,
      fmt::format("tiles {} and {} {}; remove this line", first + line.tileA, first + line.tileB,
                  isBall ? "share one corner of one face, which in space is a ball joint without "
                           "an axis"
                         : "turn about no corner or edge that they share"));
}

}  // namespace

double neckSide(const std::vector<Brick>& bricks, int brickA, int brickB) {
  const auto areaOf = [&](int brick) {
    const Brick& found = bricks[static_cast<std::size_t>(brick)];
    return found.volume / found.thickness;
  };
  return std::sqrt(0.5 * (areaOf(brickA) + areaOf(brickB)));
}

std::vector<OwnHingeSpring> readHingeSprings(const std::filesystem::path& file,
                                             const Model& model) {
  TextTable table(file, "a list of hinges, tile tile stiffness rest damping");
  std::vector<OwnHingeSpring> springs;
  std::map<TilePair, int> lines;
  for (TextLine line; table.next(line);) {
    springs.push_back(readSpring(table, line, model));
    const OwnHingeSpring& spring = springs.back();
    const auto [known, isNew] =
        lines.try_emplace(std::minmax(spring.tileA, spring.tileB), line.number);
    if (isNew) continue;
    throw inputErrorAt(spring.where, fmt::format("this hinge stands on line {} already; remove one "
                                                 "of the two",
                                                 known->second));
  }
  return springs;
}

std::vector<HingeSpring> hingeSprings(const Scene& scene, const std::vector<Brick>& bricks) {
  const HingeSettings& all = scene.hinges;
  if (!all.areOn()) return {};
  const FoundHinges found = requireHinges(scene, bricks);
  std::map<TilePair, const OwnHingeSpring*> lines = byTiles(all.own);
  std::vector<HingeSpring> springs;
  for (const Hinge& hinge : found.hinges) {
    OwnHingeSpring own;
    if (const auto line = lines.find(std::minmax(hinge.brickA, hinge.brickB));
        line != lines.end()) {
      own = *line->second;
      // What is left of the file in the end names no hinge, and is refused.
      lines.erase(line);
    }
    const std::optional<double> rest = own.rest ? own.rest : all.rest;
    const HingeSpring spring{hinge,
                             own.stiffness.value_or(stiffnessOf(all, hinge, bricks, scene.brick)),
                             rest.value_or(hinge.start), own.damping.value_or(all.damping)};
    if (spring.stiffness == 0 && spring.damping == 0) continue;
    if (rest) requireRoomAtRest(spring, own.rest ? &own : nullptr, scene.model);
    springs.push_back(spring);
  }
  if (!lines.empty()) {
    refuseLine(*lines.begin()->second, found, scene.model.fileOrder.countsFrom);
  }
  return springs;
}

}  // namespace kirireel
