// One parent, `count` children. Each child is forked once and does jobs until none is left:
//
//     parent                         child
//     next() gives a number
//     send number (8 bytes)   ->     recv
//                                    work(number)
//     poll, recv verdict      <-     send verdict (1 byte)
//     watch(verdict)
//
// The channel is a pair of SOCK_SEQPACKET sockets (unix(7)), which keep the bounds of messages. The
// end of a process closes its socket, and the parent then receives an empty message. A new worker
// replaces one that died. The job is lost, or repeated once after SIGKILL: if memory is short, the
// kernel may have killed a run that did not use much of it.
//
// Processes and not threads: a process cannot recover from a crash, exhausted memory or an endless
// loop of one of its threads. fork without exec keeps libraries loaded and tables warm.
//
// RLIMIT_DATA (setrlimit(2)) limits memory. Allocations beyond it fail with std::bad_alloc, so most
// runs that need too much end with a reason. Time is wall time since the job was sent.
#include "render/sweep/worker_pool.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <deque>
#include <memory>
#include <set>
#include <vector>

#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sim/base/error.h"

namespace kirireel::sweep {
namespace {

using Clock = std::chrono::steady_clock;

/// Longest time between two calls of `watch`. Bounds the delay of Ctrl-C and of the time limit.
constexpr int kWatchMilliseconds = 200;

// The shadow memory of a sanitizer counts too and would exceed any limit.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kLimitsMemory = false;
#else
constexpr bool kLimitsMemory = true;
#endif

void limitMemory(std::int64_t bytes) {
  if (bytes <= 0 || !kLimitsMemory) return;
  const auto most = static_cast<rlim_t>(bytes);
  const rlimit limit = {most, most};
  ::setrlimit(RLIMIT_DATA, &limit);
}

/// The loop of a worker: receives numbers of jobs and sends verdicts. It ends in the same way
/// whether the caller finished or died.
[[noreturn]] void runWorkerLoop(int channel, const WorkerJobs& jobs) {
  std::uint64_t job = 0;
  while (::recv(channel, &job, sizeof job, 0) == sizeof job) {
    Verdict verdict = Verdict::Failed;
    try {
      verdict = jobs.work(job);
    } catch (const std::exception& error) {
      // Not fmt::print, which throws if stderr goes to a full disk.
      std::fputs(fmt::format("kirireel: {}\n", error.what()).c_str(), stderr);
      std::fflush(nullptr);
      ::_exit(1);
    }
    // MSG_NOSIGNAL: an error instead of SIGPIPE if the parent has ended.
    if (::send(channel, &verdict, sizeof verdict, MSG_NOSIGNAL) != sizeof verdict) break;
  }
  std::fflush(nullptr);
  // Not exit(): its handlers belong to the caller.
  ::_exit(0);
}

/// One child process, seen from its parent.
class Worker {
 public:
  /// `siblings`: the channels that the child must close.
  Worker(const WorkerJobs& jobs, const WorkerLimits& limits, const std::vector<int>& siblings) {
    std::array<int, 2> ends = {};
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) fail();
    std::fflush(nullptr);
    const pid_t parent = ::getpid();
    process_ = ::fork();
    if (process_ < 0) fail();
    if (process_ == 0) {
      // The kernel ends the child with its parent (prctl(2)).
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      // The parent may have died before that.
      if (::getppid() != parent) ::_exit(1);
      // Ctrl-C reaches the whole process group; only the parent handles it.
      std::signal(SIGINT, SIG_IGN);
      std::signal(SIGTERM, SIG_IGN);
      // If a sibling kept an end open, its peer would not notice that the parent closed it.
      for (const int sibling : siblings) ::close(sibling);
      ::close(ends[0]);
      limitMemory(limits.memoryBytes);
      runWorkerLoop(ends[1], jobs);
    }
    channel_ = ends[0];
    ::close(ends[1]);
  }

  /// Kills the process if it still runs, and waits for its end to leave no zombie.
  ~Worker() {
    ::kill(process_, SIGKILL);
    waitForEnd();
    ::close(channel_);
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  void sendJob(std::uint64_t job) {
    job_ = job;
    since_ = Clock::now();
    // An ended worker is detected by poll().
    ::send(channel_, &job, sizeof job, MSG_NOSIGNAL);
  }

  /// The verdict on its job; null if the process has ended.
  std::optional<Verdict> receiveVerdict() {
    Verdict verdict = Verdict::Failed;
    // recv() returns 0 bytes if the process has ended.
    return ::recv(channel_, &verdict, sizeof verdict, 0) == sizeof verdict ? std::optional(verdict)
                                                                           : std::nullopt;
  }

  /// Waits for the end of the process. Returns the status of waitpid(2); further calls return the
  /// same.
  int waitForEnd() {
    while (!ended_ && ::waitpid(process_, &status_, 0) < 0 && errno == EINTR) {
    }
    ended_ = true;
    return status_;
  }

  void kill() const { ::kill(process_, SIGKILL); }

  int channel() const { return channel_; }
  std::uint64_t job() const { return job_; }
  double seconds() const { return std::chrono::duration<double>(Clock::now() - since_).count(); }

 private:
  [[noreturn]] static void fail() {
    throw RunError(fmt::format("error: no process can be started ({}); use fewer --jobs",
                               std::strerror(errno)));
  }

  pid_t process_ = -1;
  int channel_ = -1;
  std::uint64_t job_ = 0;
  Clock::time_point since_;
  int status_ = 0;
  bool ended_ = false;
};

std::string describeEnd(int status) {
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    return fmt::format("ended by signal {} ({})", signal, strsignal(signal));
  }
  return fmt::format("ended with exit code {}", WEXITSTATUS(status));
}

/// All workers, each with one job.
class Pool {
 public:
  Pool(const WorkerJobs& jobs, const WorkerLimits& limits) : jobs_(jobs), limits_(limits) {}

  bool run() {
    // No more workers than jobs.
    for (int i = 0; i < limits_.count; ++i) {
      const std::optional<std::uint64_t> job = next();
      if (!job) break;
      startWorker(*job);
    }
    while (!workers_.empty()) {
      if (!jobs_.watch(std::nullopt)) return false;
      // Backwards, because workers are removed and appended.
      const std::vector<bool> hasMessage = waitForMessages();
      for (std::size_t i = hasMessage.size(); i-- > 0;) {
        if (hasMessage[i] && !handleMessage(i)) return false;
        if (!hasMessage[i] && workers_[i]->seconds() > limits_.seconds && !stopHung(i))
          return false;
      }
    }
    return true;
  }

 private:
  std::optional<std::uint64_t> next() {
    if (retries_.empty()) return jobs_.next();
    const std::uint64_t job = retries_.front();
    retries_.pop_front();
    return job;
  }

  void startWorker(std::uint64_t job) {
    std::vector<int> channels;
    for (const auto& worker : workers_) channels.push_back(worker->channel());
    workers_.push_back(std::make_unique<Worker>(jobs_, limits_, channels));
    workers_.back()->sendJob(job);
  }

  /// Which workers have sent something. Waits at most kWatchMilliseconds.
  std::vector<bool> waitForMessages() const {
    std::vector<pollfd> channels;
    for (const auto& worker : workers_) channels.push_back({worker->channel(), POLLIN, 0});
    // A signal interrupted poll(): read nothing in this round; watch() checks for the signal in the
    // next.
    if (::poll(channels.data(), channels.size(), kWatchMilliseconds) < 0) channels.clear();
    std::vector<bool> hasMessage;
    for (const pollfd& channel : channels) hasMessage.push_back(channel.revents != 0);
    return hasMessage;
  }

  /// Takes the verdict of worker i and sends it the next job; false if `watch` stops all.
  bool handleMessage(std::size_t i) {
    const std::optional<Verdict> verdict = workers_[i]->receiveVerdict();
    if (!verdict) return replaceEnded(i);
    if (!jobs_.watch(verdict)) return false;
    if (const auto job = next()) {
      workers_[i]->sendJob(*job);
    } else {
      workers_.erase(workers_.begin() + static_cast<std::ptrdiff_t>(i));
    }
    return true;
  }

  /// Replaces a worker that has ended by itself.
  bool replaceEnded(std::size_t i) {
    const std::uint64_t job = workers_[i]->job();
    const int status = workers_[i]->waitForEnd();
    // insert() returns whether the job is tried again for the first time.
    if ((WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) && retried_.insert(job).second) {
      retries_.push_back(job);
      return removeWorker(i);
    }
    return reportLoss(i, describeEnd(status));
  }

  bool stopHung(std::size_t i) {
    workers_[i]->kill();
    workers_[i]->waitForEnd();
    return reportLoss(i, fmt::format("took longer than {:g} s", limits_.seconds));
  }

  bool reportLoss(std::size_t i, const std::string& reason) {
    return jobs_.watch(jobs_.lost(workers_[i]->job(), reason)) && removeWorker(i);
  }

  /// Removes a worker that has ended, and starts a new one if there is a job.
  bool removeWorker(std::size_t i) {
    workers_.erase(workers_.begin() + static_cast<std::ptrdiff_t>(i));
    if (const auto job = next()) startWorker(*job);
    return true;
  }

  const WorkerJobs& jobs_;
  const WorkerLimits& limits_;
  std::vector<std::unique_ptr<Worker>> workers_;
  std::deque<std::uint64_t> retries_;
  std::set<std::uint64_t> retried_;
};

}  // namespace

bool runInWorkers(const WorkerJobs& jobs, const WorkerLimits& limits) {
  return Pool(jobs, limits).run();
}

}  // namespace kirireel::sweep
