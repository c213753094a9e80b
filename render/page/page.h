/// Pages to send: runs in 3-D as one HTML file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "render/picture/state_painter.h"
#include "sim/base/files.h"
#include "sim/base/geometry.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel::page {

// ------------------------------------------------------------------------------------------------
// The text of a page about a run.

/// Facts in reading order: a name and a value.
using Facts = std::vector<std::pair<std::string, std::string>>;

/// Settings, outcome and accuracy of a run, only from its trajectory. Texts are plain, not yet
/// escaped. Reads every sample once.
Facts factsOf(const trajectory::TrajectoryReader& run);

/// The warnings of a run, one line each.
std::vector<std::string> warningsOf(const trajectory::TrajectoryReader& run);

// ------------------------------------------------------------------------------------------------
// Arrays of numbers as text within a page.
//
// An array is stored little-endian in planes (the first bytes of all entries, then the second
// bytes, ...), compressed by zlib, in base 64. Similar numbers give long runs of equal bytes in
// planes, which compress better.

/// {"type": "f32" | "f64" | "i32" | "u16" | "u8", "count": entries, "data": text}, which packed.js
/// unpacks.
Json packedArray(std::span<const float> entries);
/// Numbers as an array that a page unpacks: 64 bits each.
Json packedArray(std::span<const double> entries);
/// The same for whole numbers of 32 bits.
Json packedArray(std::span<const std::int32_t> entries);
/// The same for unsigned integers of 16 bits.
Json packedArray(std::span<const std::uint16_t> entries);
/// The same for unsigned integers of 8 bits.
Json packedArray(std::span<const std::uint8_t> entries);

/// The resolution of poses.
struct PoseSteps {
  Vector3 origin = Vector3::Zero();  ///< origin of positions, metres
  double position = 1;               ///< step of positions, metres; > 0
  double rotation = 1;               ///< step of the quaternions' components; > 0
};

/// Steps that move no corner of a brick by more than 1/17,500 of the visible region: a ninth of a
/// pixel at 2000 pixels. `size`: diagonal of the region; `radius`: largest distance of a corner
/// from its brick's centre of mass; both metres, > 0.
PoseSteps finePoseSteps(const Vector3& origin, double size, double radius);

/// Packs the poses of one run's samples in sequence: x, y, z, then the quaternion's w, x, y, z,
/// each for all bricks.
///
/// Rounded entries vary so smoothly that only their second differences d = e(k) - 2 e(k-1) + e(k-2)
/// are stored (entries before the first are zero), as 2 d or, for negative d, -2 d - 1. The upper
/// bytes of small differences are zero.
class PosePacker {
 public:
  /// Rounded to these steps; exact doubles without them.
  explicit PosePacker(std::optional<PoseSteps> steps) : steps_(std::move(steps)) {}

  /// The number of bricks must be the same in every call.
  void add(const Poses& poses);

  /// {"exact": bool, "origin": [x, y, z], "position_step", "rotation_step", "entries": array}. Call
  /// it after adding all samples.
  Json packed() const;

 private:
  void addRounded(const std::vector<double>& entries);
  Json packedDifferences() const;

  std::optional<PoseSteps> steps_;
  Poses before_;  ///< of the last sample, with quaternion signs continuous between samples
  std::vector<double> exact_;
  std::vector<std::int32_t> differences_;
  std::vector<std::int64_t> last_, lastButOne_;  ///< rounded entries
};

/// Values >= 0 in 255 steps of equal ratios between the smallest value > 0 and the largest, since
/// the order of magnitude of gaps and errors matters. Code 0 is 0. {"least", "most", "codes":
/// array} NaN counts as 0.
Json packedMagnitudes(std::span<const double> values);

// ------------------------------------------------------------------------------------------------
// Data of a run in a page, as JSON.

/// Selection of a run's states for a page.
struct PageStates {
  int samples = 201;   ///< at equal steps of motion, >= 2; 0: all samples of the run
  bool exact = false;  ///< poses as doubles; else accurate to a fraction of a pixel
};

/// The colours, lights, lines and lengths of our pictures for a theme, from render/picture. The
/// given theme replaces that of the appearance.
Json styleJson(picture::Theme theme, const picture::Appearance& appearance);

/// One run for stage.js: bricks, poses, joints, measures, target, surroundings and cameras. Throws
/// InputError if the style needs data that the run lacks. Reads the trajectory once for the states
/// and once for the curves. Each state of a thousand bricks takes 14 kB before compression.
Json runJson(const trajectory::TrajectoryReader& run, const picture::Appearance& appearance,
             const PageStates& states);

/// Three pictures of the run side by side, at the start, half way and at the end, as a PNG file.
/// Throws OutputError if painting is impossible.
std::string stillPicture(const trajectory::TrajectoryReader& run,
                         const picture::Appearance& appearance);

// ------------------------------------------------------------------------------------------------
// Interactive pages: one HTML file that shows runs in 3-D in any browser, without a network.
//
// A page is page.html with its style sheet, its scripts, three.js (r111, MIT licence) and the runs'
// data within. It has the style of our pictures: colours, lights, widths and cameras come from
// render/picture as data.

/// File name of a page in its folder.
inline constexpr const char* kPageFile = "page.html";

/// The largest number of runs on a page.
inline constexpr std::size_t kMaxPageRuns = 2;

/// Settings of a page. All runs have one style, for comparison.
struct WebPageSettings {
  std::filesystem::path folder;  ///< created if needed
  PageStates states;             ///< states on the page, in time order
  /// Files in the folder of each trajectory to embed in the page. Videos can be played, pictures
  /// are shown, others can be saved.
  std::vector<std::string> embedded;
  double maxMegabytes = 25;        ///< limit; a larger page is refused; 1e6 bytes each
  picture::Appearance appearance;  ///< of all runs
};

/// The contents of a file of render/page/web or of three.js by name, such as "page.css", as
/// embedded in the program; empty in a build without it.
std::string_view embeddedFile(std::string_view name);

/// Whether this program can make pages: three.js was available at build time and is embedded.
bool canMakePages();
/// Throws OutputError with advice if the program cannot make pages.
void requirePages();

/// The text of a page of one or two runs. Throws InputError if a run lacks data for the style or
/// the page would be too large, OutputError if the program cannot make pages. Reads runs from their
/// trajectories. The text has some megabytes for 201 states of a thousand bricks.
std::string pageText(const std::vector<std::filesystem::path>& trajectories,
                     const WebPageSettings& settings);

/// Writes the text as page.html to the folder and lists it in contents.json. Throws like
/// pageText(), and OutputError if writing fails.
void writePage(const std::vector<std::filesystem::path>& trajectories,
               const WebPageSettings& settings);

// ------------------------------------------------------------------------------------------------
// The cameras of a page, with the same fit as in our pictures.

/// A list of {"name", "key", "fits": [{"aspect", "eye", "centre", "up", "orthographic",
/// "field_of_view", "view_height"}, ...]}. The view of the style comes first. Fits are ordered from
/// narrow to wide, and the page uses the widest one that fits in its canvas. Aspect is the width
/// over the height. Costs five fits per view, each O(n) in the points of the content.
Json camerasJson(const picture::Appearance& appearance, const picture::PictureContent& content);

}  // namespace kirireel::page
