/// Prints the cost of recording by stage, its lower bound, and the cost of other programs. Run by
/// hand on a machine with two free cores: tests/bench/record [FRAMES]
#include "render/record/record.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <thread>

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "render/picture/gl_context.h"
#include "render/picture/painter.h"
#include "render/picture/video.h"
#include "render/record/pipeline.h"
#include "sim/generate/lattice.h"
#include "tests/bench/bare_loop.h"
#include "tests/support/program.h"

namespace kirireel::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kSide = 10;  // 100 bricks
constexpr int kRate = 60;  // frames per second

/// To BT.709, as precisely as libswscale can.
constexpr const char* kPeerColours =
    "scale=in_range=pc:out_range=tv:out_color_matrix=bt709:"
    "flags=bicubic+accurate_rnd+full_chroma_inp,format=yuv420p";

double cpuSeconds(int who) {
  rusage usage{};
  ::getrusage(who, &usage);
  const auto seconds = [](timeval time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// CPU milliseconds of the fastest of several rounds. Disturbances only add to a round.
double minCost(int frames, const std::function<void()>& frame) {
  constexpr int kRounds = 12;
  double least = 1e9;
  for (int round = 0; round < kRounds; ++round) {
    const double start = cpuSeconds(RUSAGE_SELF);
    for (int k = 0; k < frames; ++k) frame();
    least = std::min(least, 1e3 * (cpuSeconds(RUSAGE_SELF) - start) / frames);
  }
  return least;
}

/// Opens so slowly that the motion lasts longer than `frames` frames.
scene::Scene slowScene(int frames) {
  scene::Scene scene;
  scene.model = generate::makeTessellation({.columns = kSide, .rows = kSide});
  scene.brick.thickness = 0.1;
  scene.springs.forceDamping = 1e4;
  scene.path.kind = scene::PathKind::Straight;
  scene.stop.settleTime = 1e6;
  scene.stop.duration = (frames - 1.0) / kRate;
  return scene;
}

/// A video's elapsed time, that of only its slowest stage, and its CPU time on the available cores
/// (see taskset).
void printVideo(int frames, const fs::path& folder) {
  const record::ProgressObserver proceed = [](const record::Progress&) {
    return record::Interruption{};
  };
  record::RecordSettings settings;
  settings.folder = folder / "run";
  settings.size = kSize;
  settings.video = settings.snapshots = settings.meshes = false;
  settings.length = static_cast<double>(frames) / kRate;
  settings.hold = 0;
  settings.appearance.camera.view = picture::kIsometricView;
  record::record(slowScene(frames), settings, proceed);
  settings.video = true;
  settings.folder = folder / "video";
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  double best = 1e9;
  std::string line;
  for (int round = 0; round < 3; ++round) {
    const double start = cpuSeconds(RUSAGE_SELF);
    const record::PictureReport report =
        record::render(folder / "run" / "trajectory.h5", settings, proceed);
    const double total = cpuSeconds(RUSAGE_SELF) - start;
    const record::RecordCost& cost = report.recordCost;
    const double slowest =
        std::max(cost.cpuSecondsRender / settings.painters(), cost.cpuSecondsEncode);
    const double ratio = cost.wallSeconds / std::max(slowest, total / cores);
    if (ratio > best) continue;
    best = ratio;
    line = fmt::format(
        "video, {} frames, {} cores, {} painters: {:.2f} s on the wall; CPU s: paint {:.2f}, "
        "encode {:.2f}, all {:.2f}; wall / max(slowest, all / cores) {:.2f}",
        report.videoFrames, cores, settings.painters(), cost.wallSeconds, cost.cpuSecondsRender,
        cost.cpuSecondsEncode, total, ratio);
  }
  fmt::print("{}\n", line);
}

/// Returns the painter's CPU milliseconds per frame without ambient occlusion.
double printPainting(const PaintedSheet& sheet) {
  constexpr int kFrames = 10;
  picture::Style plain;
  plain.occlusion = 0;
  const auto costIn = [&](const picture::Style& style) {
    picture::Painter painter(kSize, sheet.bricks, style, picture::Smoothness::Film);
    return minCost(kFrames, [&] { painter.paint(sheet.poses, sheet.camera); });
  };
  const double painted = costIn(plain), occluded = costIn({});
  BareLoop loop(sheet);
  const double bare = minCost(kFrames, [&] { loop.frame(); });
  fmt::print(
      "painting, CPU ms a frame: {:.2f}, with ambient occlusion {:.2f}; bare loop {:.2f}; ratios "
      "{:.2f} and {:.2f}\n",
      painted, occluded, bare, painted / bare, occluded / bare);
  return painted;
}

/// The same pictures encoded by us and, from raw frames, by FFmpeg's program with the same
/// settings.
void printEncoding(int frames, const PaintedSheet& sheet, picture::Painter& painter,
                   const fs::path& folder) {
  const std::string command = fmt::format(
      "ffmpeg -v error -y -f rawvideo -pix_fmt rgba -s {}x{} -r {} -i - -vf '{}' -c:v libx264 "
      "-preset "
      "veryfast -crf 18 -threads 1 '{}'",
      kSize.width, kSize.height, kRate, kPeerColours, (folder / "peer.mp4").string());
  const double childrenBefore = cpuSeconds(RUSAGE_CHILDREN);
  std::FILE* pipe = ::popen(command.c_str(), "w");
  picture::VideoWriter writer(folder / "ours.mp4", {.size = kSize, .framesPerSecond = kRate});
  double ours = 0;
  Poses poses = sheet.poses;
  for (int k = 0; k < frames; ++k) {
    for (Pose& pose : poses) pose.position *= 1.0005;
    const picture::Frame frame = painter.paint(poses, sheet.camera);
    std::fwrite(frame.pixels.data(), 1, frame.pixels.size(), pipe);
    const record::CpuTimer timer(ours);
    writer.write(frame);
  }
  {
    const record::CpuTimer timer(ours);
    writer.finish();
  }
  ::pclose(pipe);
  const double peer = cpuSeconds(RUSAGE_CHILDREN) - childrenBefore;
  fmt::print("encoding, CPU ms a frame: {:.2f}; ffmpeg's program {:.2f}; ratio {:.2f}\n",
             1e3 * ours / frames, 1e3 * peer / frames, ours / peer);
}

void printPeer(double painted) {
  const std::string text = test::outputOf(
      fmt::format("xvfb-run -a /usr/bin/python3 {}/tests/bench/vtk_frames.py {} 60 {} {}",
                  KIRIREEL_SOURCE_DIR, kSide, kSize.width, kSize.height));
  if (text.empty()) {
    fmt::print("VTK: did not run; install python3-vtk9 and xvfb\n");
    return;
  }
  const double peer = std::stod(text);
  fmt::print("VTK's off-screen window, CPU ms a frame: {:.2f}; {:.1f} times the painter's\n", peer,
             peer / painted);
}

/// In its own process, because the graphics library chooses its number of threads once per process.
/// A recording uses threads, a measurement of painting none.
void printVideoAside(int frames, const fs::path& folder) {
  const pid_t child = ::fork();
  if (child == 0) {
    printVideo(frames, folder);
    std::exit(0);
  }
  ::waitpid(child, nullptr, 0);
}

void run(int frames) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  std::string pattern = (fs::temp_directory_path() / "kirireel_bench_XXXXXX").string();
  const fs::path folder = ::mkdtemp(pattern.data());
  fmt::print("{} bricks, {} x {}, 4 samples a pixel, the bare loop 6\n", kSide * kSide, kSize.width,
             kSize.height);
  printVideoAside(frames, folder);
  picture::setRasterThreads(0);
  const PaintedSheet sheet(kSide);
  picture::Painter painter(kSize, sheet.bricks, {}, picture::Smoothness::Film);
  const double painted = printPainting(sheet);
  printEncoding(frames, sheet, painter, folder);
  printPeer(painted);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace kirireel::bench

int main(int count, char** arguments) {
  const int frames = count > 1 ? std::atoi(arguments[1]) : 600;
  if (frames < 2) {
    fmt::print(stderr, "Usage: {} [FRAMES], at least 2; 600 by default\n", arguments[0]);
    return 2;
  }
  kirireel::bench::run(frames);
  return 0;
}
