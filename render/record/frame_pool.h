/// Frames of a video whose memory is used again.
#pragma once

#include <mutex>
#include <utility>
#include <vector>

#include "render/picture/frame.h"

namespace kirireel {

/// Spare frames, for any thread. Painters would else ask the heap for some tens of megabytes a
/// frame, which the encoder's thread returns: the heap then grows as a video goes on.
class FramePool {
 public:
  /// A spare frame, whatever it shows; an empty one when there is none.
  Frame take() {
    const std::lock_guard lock(mutex_);
    if (spare_.empty()) return {};
    Frame frame = std::move(spare_.back());
    spare_.pop_back();
    return frame;
  }

  /// Its memory stays in the pool until a painter takes it.
  void giveBack(Frame frame) {
    const std::lock_guard lock(mutex_);
    spare_.push_back(std::move(frame));
  }

 private:
  std::mutex mutex_;
  std::vector<Frame> spare_;
};

}  // namespace kirireel
