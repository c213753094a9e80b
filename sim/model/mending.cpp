// Repairs of input that is odd but has one meaning only.
//
// The rule for each repair: it is made only where no other reading of the file makes sense, it is
// noted with its place, and `--strict` refuses it. A repair is a `Mend` of the model and one line
// among the warnings.
#include "sim/model/mending.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "sim/model/rounding.h"

namespace kirireel {
namespace {

// A sheet whose heights differ by less than this part of its size is flat.
constexpr double kLevelStart = 1e-9;

/// "1 joint is", "3 joints are".
std::string countOf(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? " is" : "s are");
}

bool isClockwise(const Tile& tile) {
  return tileNormal(tile).z() < 0;
}

bool isFlat(const std::vector<Tile>& tiles, double size) {
  // Numbers that were rounded may differ by their last digit; the factor leaves room for what a
  // double cannot hold of it.
  return liesFlat(tiles, std::max(kLevelStart * size, 1.01 * roundingOf(tiles)));
}

}  // namespace

std::string toString(const Mend& mend) {
  return fmt::format("{}: mended: {}; {}", mend.place, mend.found, mend.done);
}

void noteMend(Mend mend, Model& model, std::vector<std::string>& warnings) {
  warnings.push_back(toString(mend));
  model.mends.push_back(std::move(mend));
}

void refuseMends(const Model& model) {
  if (model.mends.empty()) return;
  const Mend& mend = model.mends.front();
  throw InputError(fmt::format("{}: error: {}; {}, or leave --strict out to have it mended",
                               mend.place, mend.found, mend.advice));
}

void noteNoJoints(const std::filesystem::path& file, Model& model,
                  std::vector<std::string>& warnings) {
  noteMend({file.string(),
            "the file is empty",
            "the tiles are taken as loose",
            "write the line \"# no joints\" if they are",
            {}},
           model, warnings);
}

RoundedCorners::RoundedCorners(const Model& model)
    : lastPlace_(lastPlace(model.tiles)), least_(0.5 * lastPlace_) {}

// Only the first place is told; the others are counted.
void RoundedCorners::add(const Joint& joint, double gap, const std::string& place) {
  // Gaps below half a last digit cannot come from writing the digits down.
  if (lastPlace_ == 0 || gap < least_) return;
  if (mend_.corners.empty()) mend_.place = place;
  mend_.corners.push_back(joint.a);
  largest_ = std::max(largest_, gap);
}

void RoundedCorners::note(Model& model, std::vector<std::string>& warnings) {
  if (mend_.corners.empty()) return;
  const std::size_t count = mend_.corners.size();
  mend_.found =
      fmt::format("the corners of {} joint{} are {}{:.2g} m apart, by rounding to {:g} m", count,
                  count == 1 ? "" : "s", count == 1 ? "" : "up to ", largest_, lastPlace_);
  mend_.done = count == 1 ? "they are one corner" : "they are one corner each";
  mend_.advice = "write the same numbers for both corners";
  noteMend(std::move(mend_), model, warnings);
}

void dropRepeatedJoints(JointTable& table, Model& model, std::vector<std::string>& warnings) {
  using CornerNumbers = std::pair<int, int>;
  // Line of the first row that holds these two corners on this face (1 or 2).
  std::map<std::tuple<CornerNumbers, CornerNumbers, int>, int> firstLine;
  std::vector<JointRow> kept;
  Mend mend;
  int firstRepeated = 0;
  for (JointRow& row : table.rows) {
    CornerNumbers a{row.values[0], row.values[1]};
    CornerNumbers b{row.values[2], row.values[3]};
    // The order of the two ends does not change what a joint holds.
    if (b < a) std::swap(a, b);
    const bool hasFaces = row.kind == JointKind::Pivot && row.values[4] >= 1 && row.values[4] <= 3;
    int newFaces = 0, line = 0;
    // Faces are bits: 1 bottom, 2 top, 3 both. So rows "bottom" and "top" at one corner add up to
    // "both", and a later "both" repeats them.
    for (const int face : {1, 2}) {
      if (!hasFaces || (row.values[4] & face) == 0) continue;
      const auto [entry, isNew] = firstLine.try_emplace({a, b, face}, row.line);
      if (isNew) newFaces |= face;
      if (!isNew && line == 0) line = entry->second;
    }
    const bool repeats = hasFaces && newFaces != row.values[4];
    if (repeats && mend.place.empty()) {
      mend.place = toString({table.file, row.line});
      firstRepeated = line;
    }
    if (repeats) mend.corners.push_back({row.values[0], row.values[1]});
    // Nothing of the row is new. Where a part of it is new, only that part stays.
    if (repeats && newFaces == 0) continue;
    if (repeats) row.values[4] = newFaces;
    kept.push_back(row);
  }
  if (mend.corners.empty()) return;
  table.rows = std::move(kept);
  const std::string earlier =
      firstRepeated > 0 ? fmt::format(", here that of line {}", firstRepeated) : "";
  mend.found = fmt::format("{} listed again{}", countOf(mend.corners.size(), "joint"), earlier);
  mend.done = "each counts once, whichever end comes first";
  mend.advice = "delete what is repeated";
  noteMend(std::move(mend), model, warnings);
}

// The shift applies to all four numbers of every row alike.
void mendBase(JointTable& table, const TileTable& tiles, Model& model,
              std::vector<std::string>& warnings) {
  // The rows hold numbers that count from 0, made with the base that the format has by default.
  // Counted from the other base they are one lower, or one higher.
  const int other = 1 - table.countsFrom;
  const int shift = table.countsFrom - other;
  // A file that fits the usual base is never changed, even where it would fit the other one too.
  if (namesWhatIsThere(table, tiles.tiles, 0) || !namesWhatIsThere(table, tiles.tiles, shift)) {
    return;
  }
  for (JointRow& row : table.rows) {
    for (std::size_t entry = 0; entry < 4; ++entry) row.values[entry] += shift;
  }
  const int usual = std::exchange(table.countsFrom, other);
  model.fileOrder.countsFrom = other;
  Mend mend;
  mend.place = table.file.string();
  mend.found = fmt::format("tiles and vertices of all {} joints count from {}, not from {}",
                           table.rows.size(), other, usual);
  mend.done = fmt::format("they are taken as counted from {}", other);
  mend.advice =
      fmt::format("{} all tile and vertex numbers", usual > other ? "add 1 to" : "subtract 1 from");
  noteMend(std::move(mend), model, warnings);
}

// Decided for the start alone: a tile keeps its vertices' order in every state.
void turnClockwiseTiles(const TileTable& table, Model& model, std::vector<std::string>& warnings) {
  const double size = modelSize(model);
  if (!isFlat(model.tiles, size)) return;
  std::vector<bool> clockwise(model.tiles.size());
  std::transform(model.tiles.begin(), model.tiles.end(), clockwise.begin(), isClockwise);
  const auto count = std::count(clockwise.begin(), clockwise.end(), true);
  if (count == 0) return;
  // In a sheet that leaves the plane, the side on which bricks grow decides which face a joint lies
  // on. To turn all tiles round would swap top and bottom.
  const bool isFolded = model.target && !isFlat(*model.target, size);
  if (isFolded && count == std::ssize(model.tiles)) {
    warnings.push_back(
        fmt::format("{}: warning: all tiles run clockwise seen from above, so that bricks grow "
                    "downwards; list their vertices anticlockwise to have them grow upwards",
                    table.file.string()));
    return;
  }
  const int first =
      static_cast<int>(std::find(clockwise.begin(), clockwise.end(), true) - clockwise.begin());
  Mend mend;
  mend.place = toString(table.at(first));
  mend.found = fmt::format("{} of {} tiles run{} clockwise seen from above", count,
                           model.tiles.size(), count == 1 ? "s" : "");
  mend.done = "turned round, and written in the file's own order again";
  mend.advice = "list their vertices anticlockwise";
  for (int tile = 0; tile < std::ssize(clockwise); ++tile) {
    if (clockwise[tile]) mend.corners.push_back({tile, 0});
  }
  noteMend(std::move(mend), model, warnings);
  // To reverse the vertices is its own inverse.
  const int countsFrom = model.fileOrder.countsFrom;
  model.fileOrder.isReversed = clockwise;
  model = inFileOrder(std::move(model));
  model.fileOrder = {countsFrom, std::move(clockwise)};
}

}  // namespace kirireel
