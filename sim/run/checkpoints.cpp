// Checkpoints on disk. state.h5 holds everything except the samples, as one list of numbers with a
// checksum. Each checkpoint adds one file of samples: the cost of a checkpoint therefore does not
// grow with the length of the run. Samples are written first: a state on disk never refers to
// missing samples. Each file is written atomically.
//
// CheckpointPace bounds the cost. The next checkpoint is due after 2 s or 400 times the duration of
// the last one, whichever is longer. This affects when files are written, but never the results.
#include "sim/run/checkpoints.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/file_kinds.h"
#include "sim/base/files.h"
#include "sim/trajectory/array_file.h"

namespace kirireel::run {
namespace {

namespace fs = std::filesystem;

constexpr const char* kState = "state.h5";
constexpr const char* kFormat = "kirireel checkpoint 12";
constexpr const char* kNumbers = "numbers";
// 4 MB. Samples that wait for a checkpoint need at most this memory, and are still in the
// processor's cache when they are written.
constexpr std::size_t kMaxWaiting = 500'000;

bool isOf(const trajectory::ArrayReader& file, const std::string& order) {
  return file.textAttribute("/", "format") == kFormat && file.textAttribute("/", "order") == order;
}

}  // namespace

Checkpoints::Checkpoints(fs::path folder, std::string order, CheckpointPace pace)
    : folder_(std::move(folder)), order_(std::move(order)), pace_(pace) {
  waitAfter({});
}

// All files are read once before any is used.
std::string Checkpoints::find() {
  const std::string place = fmt::format("the checkpoint in {}", folder_.string());
  // A link may point to any place.
  std::error_code ignored;
  if (fs::is_symlink(folder_, ignored) || !isPresent(folder_ / kState)) {
    remove();
    return "";
  }
  try {
    const trajectory::ArrayReader file(folder_ / kState);
    if (!isOf(file, order_)) {
      remove();
      return place + " is from another order or program version. The run starts from the beginning";
    }
    StateTape tape(file.checkedDoubles(kNumbers));
    transfer(tape);
    // Detects missing or damaged files before the rest is used.
    for (std::size_t k = 0; k < sampleFiles_.size(); ++k) readSamples(k);
  } catch (const InputError&) {
    remove();
    return place + " is damaged or incomplete. The run starts from the beginning";
  }
  if (run_.numbers.empty()) return "continues the search for a path from " + place;
  return fmt::format("continues at {:.4g} s from {}", run_.time, place);
}

void Checkpoints::remove() {
  std::error_code error;
  fs::remove_all(folder_, error);
  if (error) {
    throw OutputError(
        fmt::format("{}: error: the checkpoint of an earlier run cannot be removed ({})",
                    folder_.string(), error.message()));
  }
  straightPull_.reset();
  searchSeconds_ = 0;
  sampleFiles_.clear();
  run_ = {};
}

bool Checkpoints::isDue() const {
  return Clock::now() >= due_ || samples_.numbers().size() > kMaxWaiting;
}

void Checkpoints::save(RunState run) {
  const Clock::time_point begin = Clock::now();
  makeFolder(folder_);
  run_ = std::move(run);
  // The samples must be on disk before the state that refers to them.
  if (!run_.numbers.empty() && !samples_.numbers().empty()) {
    write(samplesFile(sampleFiles_.size()), samples_);
    sampleFiles_.push_back(samples_.numbers().size());
    samples_.clear();
  }
  StateTape tape;
  transfer(tape);
  write(folder_ / kState, tape);
  waitAfter(Clock::now() - begin);
}

void Checkpoints::playSamples(const std::function<bool(StateTape&)>& take) const {
  for (std::size_t k = 0; k < sampleFiles_.size(); ++k) {
    StateTape tape = readSamples(k);
    while (!tape.isOver()) {
      if (!take(tape)) return;
    }
  }
}

fs::path Checkpoints::samplesFile(std::size_t index) const {
  return folder_ / fmt::format("samples_{:05}.h5", index + 1);
}

StateTape Checkpoints::readSamples(std::size_t index) const {
  const trajectory::ArrayReader file(samplesFile(index));
  std::vector<double> numbers = file.checkedDoubles(kNumbers);
  if (!isOf(file, order_) || numbers.size() != sampleFiles_[index]) {
    file.refuse("these samples belong to another checkpoint");
  }
  return StateTape(std::move(numbers));
}

void Checkpoints::write(const fs::path& path, const StateTape& tape) const {
  PendingFile pending(path);
  trajectory::ArrayWriter file(pending.path(), path);
  file.setAttribute("/", "format", std::string(kFormat));
  file.setAttribute("/", "order", order_);
  file.writeChecked(kNumbers, tape.numbers());
  file.close();
  pending.commit();
}

void Checkpoints::waitAfter(Clock::duration taken) {
  const std::chrono::duration<double> least(pace_.minSeconds);
  const std::chrono::duration<double> rest = taken / pace_.largestShare;
  due_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::max(least, rest));
}

}  // namespace kirireel::run
