// A name is read into a kind and a number; the number leads to the nearest sample of the
// trajectory. Files are named by what was asked for (state_25pct) and not by the sample's number,
// so that a script finds them whatever the number of samples is.
#include "render/export/state_choice.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/geometry.h"

namespace kirireel {
namespace {

/// `allowed` says what the trajectory has.
InputError unknownState(const std::string& name, const std::string& allowed) {
  return InputError(fmt::format("error: state '{}' is not in the trajectory; {}", name, allowed));
}

/// The number that the text consists of, up to the ending. The whole text but for the ending has to
/// be a finite number.
std::optional<double> numberBefore(const std::string& text, const std::string& ending) {
  if (!text.ends_with(ending)) return std::nullopt;
  double number = 0;
  const char* last = text.data() + text.size() - ending.size();
  const auto [end, error] = std::from_chars(text.data(), last, number);
  const bool isWhole = error == std::errc() && end == last && std::isfinite(number);
  return isWhole ? std::optional(number) : std::nullopt;
}

/// Of two samples that are equally near, the earlier.
std::size_t nearestSample(const std::vector<double>& times, double time) {
  // The first sample that is not before the time.
  const auto later = std::ranges::lower_bound(times, time);
  if (later == times.begin()) return 0;
  if (later == times.end()) return times.size() - 1;
  const std::size_t index = later - times.begin();
  return time - times[index - 1] <= times[index] - time ? index - 1 : index;
}

/// Of time, not of motion: 50% of a run of 4 s is the sample nearest to 2 s.
std::size_t sampleAtShare(const std::vector<double>& times, double percent,
                          const std::string& name) {
  if (percent < 0 || percent > 100) throw unknownState(name, "shares go from 0% to 100%");
  return nearestSample(times, percent / 100 * times.back());
}

/// Sampling may end a fraction of an interval before the time that the run was given.
std::size_t sampleAtTime(const std::vector<double>& times, double time, const std::string& name) {
  // Half a sample beyond the end still means the end.
  const double slack = times.size() > 1 ? 0.5 * (times[1] - times[0]) : 0;
  if (time < 0 || time > times.back() + slack) {
    throw unknownState(name, fmt::format("it goes from 0 to {:.6g} s", times.back()));
  }
  return nearestSample(times, time);
}

/// The angle of the rotation from one orientation to the other, radians, 0 to pi.
double largestTurn(const Poses& start, const Poses& poses) {
  double largest = 0;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    largest = std::max(largest, start[k].rotation.angularDistance(poses[k].rotation));
  }
  return largest;
}

/// Reads sample by sample until one has turned far enough.
std::size_t sampleAtAngle(const TrajectoryReader& trajectory, double degrees,
                          const std::string& name) {
  const Poses start = trajectory.sample(0).poses;
  const double wanted = degrees * kDegree;
  double largest = 0;
  for (std::size_t k = 0; k < trajectory.times().size(); ++k) {
    const double turn = largestTurn(start, trajectory.sample(k).poses);
    if (turn >= wanted) return k;
    largest = std::max(largest, turn);
  }
  throw unknownState(name, fmt::format("its tiles turn by {:.4g} degrees at most",
                                       largest / kDegree));
}

/// Events are told by their text; the first one that contains it counts.
std::size_t sampleAtEvent(const TrajectoryReader& trajectory, const std::string& text,
                          const std::string& name) {
  std::string known;
  for (const Event& event : trajectory.end().events) {
    if (event.text.find(text) != std::string::npos) {
      return nearestSample(trajectory.times(), event.time);
    }
    known += fmt::format("{}'{}'", known.empty() ? "" : ", ", event.text);
  }
  throw unknownState(name, known.empty() ? "it has no events" : "its events are " + known);
}

/// What a name of a state says.
struct StateName {
  enum Kind { Initial, Final, All, Share, Time, Angle, Event } kind = Initial;
  double number = 0;  ///< per cent, seconds or degrees
  std::string text;   ///< of an event
};

/// Whether the trajectory has such a state is not looked at.
StateName readName(const std::string& name) {
  constexpr std::string_view kEvent = "event:";
  if (name == "initial") return {StateName::Initial};
  if (name == "final") return {StateName::Final};
  if (name == "all") return {StateName::All};
  if (name.starts_with(kEvent)) return {StateName::Event, 0, name.substr(kEvent.size())};
  // "deg" before "s", and no ending last, which every number has.
  for (const auto& [ending, kind] : {std::pair{"%", StateName::Share},
                                     {"deg", StateName::Angle},
                                     {"s", StateName::Time},
                                     {"", StateName::Time}}) {
    if (const auto number = numberBefore(name, ending)) return {kind, *number};
  }
  throw InputError(
      fmt::format("error: '{}' names no state; write initial, final, all, a share "
                  "(25%), a time (1.5 or 1.5s), an angle (30deg) or an event "
                  "(event:TEXT)",
                  name));
}

/// The first and the last sample that a name stands for. Equal for all names but `all`.
std::pair<std::size_t, std::size_t> samplesNamed(const TrajectoryReader& trajectory,
                                                 const std::string& name) {
  const std::vector<double>& times = trajectory.times();
  const StateName read = readName(name);
  const auto one = [](std::size_t sample) { return std::pair{sample, sample}; };
  switch (read.kind) {
    case StateName::Final:
      return one(times.size() - 1);
    case StateName::All:
      return {0, times.size() - 1};
    case StateName::Share:
      return one(sampleAtShare(times, read.number, name));
    case StateName::Time:
      return one(sampleAtTime(times, read.number, name));
    case StateName::Angle:
      return one(sampleAtAngle(trajectory, read.number, name));
    case StateName::Event:
      return one(sampleAtEvent(trajectory, read.text, name));
    case StateName::Initial:
      break;
  }
  return one(0);
}

/// "50%" and "50.0%" are one label, and so are two events whose letters were replaced alike.
void requireDifferentLabels(const std::vector<ChosenState>& states) {
  for (std::size_t a = 0; a < states.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      if (states[a].label != states[b].label) continue;
      throw InputError(
          fmt::format("error: samples {} and {} would both be written as {}; name them otherwise",
                      states[b].sample, states[a].sample, states[a].label));
    }
  }
}

}  // namespace

void requireStateName(const std::string& name) {
  readName(name);
}

std::string stateLabel(const std::string& name, std::size_t sample) {
  const StateName read = readName(name);
  switch (read.kind) {
    case StateName::All:
      return fmt::format("{:04}", sample);
    case StateName::Share:
      return fmt::format("{}pct", read.number);
    case StateName::Time:
      return fmt::format("{}s", read.number);
    case StateName::Angle:
      return fmt::format("{}deg", read.number);
    case StateName::Event:
      break;
    default:
      return name;
  }
  std::string label = "event_" + read.text;
  for (char& letter : label) {
    const bool isPlain =
        std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '.' || letter == '-';
    // One underscore a byte: letters beyond ASCII give several.
    if (!isPlain) letter = '_';
  }
  return label;
}

std::vector<ChosenState> chooseStates(const TrajectoryReader& trajectory,
                                      const std::vector<std::string>& names) {
  // By sample, so that states come out in the order of time whatever the order of the names.
  std::map<std::size_t, std::pair<std::string, std::string>> chosen;  // names and labels
  for (const std::string& name : names) {
    const auto [first, last] = samplesNamed(trajectory, name);
    // `all` names each sample by itself, so it goes with no other name.
    for (std::size_t sample = first; sample <= last; ++sample) {
      const auto [place, isNew] = chosen.try_emplace(sample, name, stateLabel(name, sample));
      if (isNew) continue;
      throw InputError(
          fmt::format("error: states '{}' and '{}' are both sample {}; leave one of them out",
                      place->second.first, name, sample));
    }
  }
  std::vector<ChosenState> states;
  for (const auto& [sample, words] : chosen) states.push_back({sample, words.second});
  requireDifferentLabels(states);
  return states;
}

}  // namespace kirireel
