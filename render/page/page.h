/// Pages to hand over: runs in 3-D as one HTML file.
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

/// Facts in the order of reading: what, and how much.
using Facts = std::vector<std::pair<std::string, std::string>>;

/// What a run was, how it ended and how accurate it is, only from its trajectory. Texts are plain,
/// not yet escaped. Reads every sample once.
Facts factsOf(const trajectory::TrajectoryReader& run);

/// What a run warns of, one line each.
std::vector<std::string> warningsOf(const trajectory::TrajectoryReader& run);

/// Text as HTML shows it literally, within elements and attributes.
std::string htmlText(const std::string& text);

// ------------------------------------------------------------------------------------------------
// Arrays of numbers as text within a page.
//
// An array is stored little-endian in planes (the first bytes of all entries, then the second
// bytes, ...), compressed by zlib, in base 64. In planes, numbers that are alike give long runs of
// equal bytes, so they shrink further.

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
  Vector3 origin = Vector3::Zero();  ///< that positions are counted from, metres
  double position = 1;               ///< step of positions, metres; above 0
  double rotation = 1;               ///< step of the quaternions' parts; above 0
};

/// Steps that move no corner of bricks by more than 1/17,500 of what is in sight: a ninth of a
/// pixel where that fills 2000 pixels. `size`: its diagonal; `radius`: the largest distance of a
/// corner from its brick's centre of mass; both metres, > 0.
PoseSteps finePoseSteps(const Vector3& origin, double size, double radius);

/// Packs the poses of one run's samples, one after the other: x, y, z, then the quaternion's w, x,
/// y, z, each for all bricks.
///
/// Rounded to the steps, entries follow their samples so smoothly that of an entry only the
/// difference d = e(k) - 2 e(k-1) + e(k-2) from the straight continuation is stored (entries before
/// the first are zero), as 2 d or, below zero, -2 d - 1: the upper bytes of small ones are zero.
class PosePacker {
 public:
  /// Rounded to these steps; exact doubles without them.
  explicit PosePacker(std::optional<PoseSteps> steps) : steps_(std::move(steps)) {}

  /// As many bricks each time.
  void add(const Poses& poses);

  /// {"exact": bool, "origin": [x, y, z], "position_step", "rotation_step", "entries": array} May
  /// be called once all samples are added.
  Json packed() const;

 private:
  void addRounded(const std::vector<double>& entries);
  Json packedDifferences() const;

  std::optional<PoseSteps> steps_;
  Poses before_;  ///< of the last sample, its quaternions' signs chosen to follow each other
  std::vector<double> exact_;
  std::vector<std::int32_t> differences_;
  std::vector<std::int64_t> last_, lastButOne_;  ///< rounded entries
};

/// Values from 0 on, in 255 steps of equal ratios between the least above 0 and the largest: what
/// matters of gaps and errors is how large they are. Code 0 is 0.
/// {"least", "most", "codes": array} Values must not be negative; NaN counts as 0.
Json packedMagnitudes(std::span<const double> values);

// ------------------------------------------------------------------------------------------------
// What a page knows of a run, as JSON.

/// How much of a run a page gets.
struct PageStates {
  int samples = 201;   ///< at equal steps of motion, at least 2; 0 for all that the run has
  bool exact = false;  ///< poses as doubles; else to a fraction of a pixel
};

/// The colours, lights, lines and lengths of our pictures for a theme, from render/picture. For the
/// given theme, not for the look's own.
Json styleJson(picture::Theme theme, const picture::Look& look);

/// One run: bricks, poses, joints, measures, target, surroundings and cameras. See stage.js, which
/// reads it. Throws InputError if the style needs data that the run lacks. Reads the trajectory
/// once for the states, once for the curves. `states.samples` of a thousand bricks take 14 kB each
/// before they are compressed.
Json runJson(const trajectory::TrajectoryReader& run, const picture::Look& look,
             const PageStates& states);

/// Three pictures of the run side by side, at the start, half way and at the end: a PNG file.
/// Throws OutputError where nothing can be painted.
std::string stillPicture(const trajectory::TrajectoryReader& run, const picture::Look& look);

// ------------------------------------------------------------------------------------------------
// Pages to hand over: one HTML file that shows runs in 3-D in any browser, without a network.
//
// A page is page.html with its style sheet, its scripts, three.js (r111, MIT licence) and the
// runs' data within. It has the style of our pictures: colours, lights, widths and cameras come
// from render/picture as data.

/// The file that a page is, in its folder.
inline constexpr const char* kPageFile = "page.html";

/// The largest number of runs on a page.
inline constexpr std::size_t kMostPageRuns = 2;

/// Settings of a page. All runs have one style, for comparison.
struct WebPageSettings {
  std::filesystem::path folder;  ///< made if need be
  PageStates states;             ///< that are shown, in rising time
  /// Files in the folder of each trajectory that go into the page: videos play, pictures show,
  /// others can be saved from it.
  std::vector<std::string> embedded;
  double mostMegabytes = 25;  ///< a larger page is refused; 1e6 bytes each
  picture::Look look;         ///< of all runs
};

/// All bytes of a file of render/page/web or of three.js by its name, for example "page.css", as
/// embedded in the program; empty in a build without it.
std::string_view embeddedFile(std::string_view name);

/// Whether this program can make pages: three.js was there when it was built. three.js is taken in
/// at build time.
bool canMakePages();
/// Throws OutputError where it cannot, with what to do about it.
void requirePages();

/// The text of a page of one run or two. Throws InputError if a run lacks data that the style needs
/// and where the page would be too large, OutputError where the program cannot make pages. A run is
/// read from its trajectory; with 201 states of a thousand bricks the text has some megabytes.
std::string pageText(const std::vector<std::filesystem::path>& trajectories,
                     const WebPageSettings& settings);

/// Writes it as page.html into the folder, and lists it in the folder's contents.json. Throws as
/// pageText(), and OutputError when it cannot be written.
void writePage(const std::vector<std::filesystem::path>& trajectories,
               const WebPageSettings& settings);

// ------------------------------------------------------------------------------------------------
// The cameras of a page, by the same fit as our pictures.

/// A list of {"name", "key", "fits": [{"aspect", "eye", "centre", "up", "orthographic",
/// "field_of_view", "view_height"}, ...]}: first the view of the style, as in pictures, then
/// others. Of a view's fits, narrowest first, the page takes the widest that its canvas holds.
/// Aspect is width by height. Cost: five fits per view, each O(n) in the points of the content.
Json camerasJson(const picture::Look& look, const picture::PictureContent& content);

}  // namespace kirireel::page
