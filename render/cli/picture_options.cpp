// Options that `record` and `render` share. Sizes are pixels; --width and --font-size are of the
// printed page (mm, points of 1/72 inch), from which grid/ computes pixels at --dpi.
#include "render/cli/picture_options.h"

#include <algorithm>
#include <sstream>

#include <CLI/CLI.hpp>
#include <fmt/ranges.h>

#include "render/cli/look_options.h"
#include "render/cli/option_group.h"

namespace kirireel {

namespace {

/// "180mm" or "7pt": a positive number with its unit, or without. In the unit that is named, as a
/// plain number.
double parseLength(const TypedValue& value, const std::string& unit, Range range) {
  // The unit may be left out, since only one is allowed.
  std::string digits = value.text;
  if (digits.ends_with(unit)) digits.resize(digits.size() - unit.size());
  return parseNumber({value.name, digits}, range);
}

/// Between commas; a comma at the very end adds no empty word.
std::vector<std::string> parseWords(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream list(text);
  for (std::string word; std::getline(list, word, ',');) words.push_back(word);
  return words;
}

/// Each format once.
std::vector<PageFormat> parsePages(const TypedValue& value) {
  std::vector<PageFormat> pages;
  for (const std::string& word : parseWords(value.text)) {
    const auto format = parseChoice<PageFormat>(
        {value.name, word}, {{"svg", PageFormat::Svg}, {"pdf", PageFormat::Pdf}});
    if (std::ranges::find(pages, format) == pages.end()) pages.push_back(format);
  }
  return pages;
}

/// As a scene file has it: "svg,pdf" in quotation marks.
std::string pagesText(const std::vector<PageFormat>& pages) {
  std::string text;
  for (const PageFormat page : pages) {
    text += (text.empty() ? "" : ",") + std::string(page == PageFormat::Svg ? "svg" : "pdf");
  }
  return quotedText(text);
}

/// What a figure for a paper needs beside the pictures.
void addPrintOptions(OptionGroup& group, PictureSettings& settings) {
  group
      .value("--width", "MM", "as it comes", "of the grid in print, 180mm; at --dpi, else 300 dpi",
             [&](const TypedValue& typed) {
               settings.gridWidth = parseLength(typed, "mm", {1, 10000});
             })
      .saidAs([&] { return settings.gridWidth ? numberText(*settings.gridWidth) : ""; });
  group
      .value("--font-size", "PT", "by the pictures' size", "of the grid's text in print, 7pt",
             [&](const TypedValue& typed) {
               settings.fontPoints = parseLength(typed, "pt", {1, 200});
             })
      .saidAs([&] { return settings.fontPoints ? numberText(*settings.fontPoints) : ""; });
  group
      .value("--font", "NAME", "DejaVu Sans", "family of all text, as fc-list names it",
             [&](const TypedValue& typed) { settings.font = typed.text; })
      .saidAs([&] { return quotedText(settings.font); });
  group.flag("--letters", settings.letters, "(a), (b), ... over the grid's pictures");
  group.flag("--arrows", settings.arrows,
             "from each of the grid's pictures to the next in its row");
  group
      .value("--column-heads", "LIST", "none",
             "over the grid's columns, in place of captions, commas between them: flat,half,open",
             [&](const TypedValue& typed) { settings.columnHeads = parseWords(typed.text); })
      .saidAs([&] { return quotedText(fmt::format("{}", fmt::join(settings.columnHeads, ","))); });
  group
      .value("--figure", "LIST", "none",
             "the whole grid as vector graphics too: svg, pdf, as snapshots.svg, snapshots.pdf",
             [&](const TypedValue& typed) { settings.pages = parsePages(typed); })
      .saidAs([&] { return pagesText(settings.pages); });
}

}  // namespace

void addPictureOptions(CLI::App& command, PictureSettings& settings) {
  OptionGroup group(command, "Pictures", "recording");
  group
      .value("--size", "WxH", "1280x720", "of each picture, pixels",
             [&](const TypedValue& typed) { settings.size = parseSize(typed); })
      .saidAs([&] { return sizeText(settings.size); });
  group
      .value("--grid", "RxC", "3x3", "rows and columns of the snapshot grid",
             [&](const TypedValue& typed) { settings.grid = parseGrid(typed); })
      .saidAs([&] { return gridText(settings.grid); });
  group
      .value("--captions", "PARTS", "progress, at real pace time",
             "under the grid's pictures, and where given under the video's frames: progress, time, "
             "angle, error, gap; or none",
             [&](const TypedValue& typed) { settings.captions = parseCaption(typed); })
      .saidAs([&] { return settings.captions ? captionText(*settings.captions) : ""; });
  group.flag("--scale-bar", settings.scaleBar,
             "a length under the grid and the video; needs a parallel projection");
  group
      .value("--dpi", "COUNT", "not noted", "dots per inch noted in PNG files, for print",
             [&](const TypedValue& typed) {
               settings.dotsPerInch = parseNumber(typed, {1, 100000});
             })
      .saidAs([&] { return settings.dotsPerInch ? numberText(*settings.dotsPerInch) : ""; });
  addPrintOptions(group, settings);
  group.choice<SnapshotSpacing>(
      "--snapshots", settings.spacing,
      {{"progress", SnapshotSpacing::Progress}, {"time", SnapshotSpacing::Time}},
      "spacing of the grid's pictures, in equal shares of motion or of time");
  group.flag("--frames", settings.frames, "write every frame of the video as a PNG into frames/");
  group
      .value("--frames-at", "LIST", "none",
             "the same of these moments: seconds, or shares of the motion, such as 0,1.5,50%,100%",
             [&](const TypedValue& typed) { settings.chosenFrames = parseFrameChoices(typed); })
      .saidAs([&] { return frameChoicesText(settings.chosenFrames); });
  group.flag("--no-snapshots", settings.snapshots, "no snapshots.png", false);
  group.flag("--svg", settings.svg,
             "the grid's pictures as snapshot_01.svg ..., hidden surfaces removed");
  group
      // More painters make the same bytes sooner, so the number is no part of an order.
      .value("--painters", "COUNT", "one for each core", "that paint frames at the same time",
             [&](const TypedValue& typed) {
               settings.painterCount = static_cast<int>(parseInteger(typed, {1, 64}));
             })
      .decidesNothing();
  // Either library draws the same.
  group
      .choice<std::optional<GraphicsLibrary>>("--gl", settings.graphics,
                                              {{"auto", std::nullopt},
                                               {"osmesa", GraphicsLibrary::Osmesa},
                                               {"egl", GraphicsLibrary::Egl}},
                                              "library that draws off screen")
      .decidesNothing();
  addLookOptions(command, settings.look);
}

}  // namespace kirireel
