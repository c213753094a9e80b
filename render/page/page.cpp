// A page is a template (render/page/web/page.html) with its places filled in:
//
//     <!--title-->, <!--program-->, <!--count-->   words
//     <!--style-->, <!--scripts-->                 page.css; three.js and our scripts
//     <!--stages-->                                a canvas and a still picture for each run
//     <!--words-->                                 facts, warnings and embedded files of each run
//     <!--data-->                                  JSON: styles for both themes, colour map, runs
//
// Everything is within the file, since it is to be sent by mail and opened from a disk, where
// browsers refuse to load neighbours of a file. The still picture shows where WebGL is missing.
//
// Text from a model (names, warnings) is escaped; the JSON stands in a script element, which ends
// at "</", so every "<" is written as \u003c.
#include "render/page/page.h"

#include <memory>
#include <string_view>

#include <fmt/format.h>

#include "render/folder/file_set.h"
#include "render/page/embedded_files.h"
#include "render/page/page_words.h"
#include "render/record/versions.h"
#include "sim/base/compression.h"
#include "sim/base/error.h"
#include "sim/base/input_file.h"
#include "sim/base/pending_file.h"

namespace kirireel {
namespace {

/// In the order in which they need each other.
constexpr const char* kScripts[] = {"three.min.js", "OrbitControls.js", "packed.js",    "bricks.js",
                                    "drawing.js",   "stage.js",         "colouring.js", "curves.js",
                                    "player.js",    "page.js"};

/// Of one file that goes into a page, bytes.
constexpr std::uintmax_t kMostEmbedded = 1u << 30;

using Words = std::vector<std::pair<std::string, std::string>>;

/// A template with each "<!--name-->" replaced. Names without a word vanish. What is filled in is
/// not looked through again.
std::string filled(std::string_view form, const Words& words) {
  std::string text;
  while (true) {
    const std::size_t begin = form.find("<!--");
    text += form.substr(0, begin);
    if (begin == std::string_view::npos) return text;
    const std::size_t end = form.find("-->", begin);
    const std::string_view name = form.substr(begin + 4, end - begin - 4);
    for (const auto& [known, word] : words) {
      if (known == name) text += word;
    }
    form.remove_prefix(end + 3);
  }
}

/// Its notice travels with every copy; the minified file has none.
constexpr const char* kThreeNotice =
    "<script>\n/*! three.js r111, copyright 2010-2020 three.js authors, MIT licence: "
    "https://threejs.org/license */\n</script>\n";

std::string scripts() {
  std::string text = kThreeNotice;
  for (const char* name : kScripts) {
    text += fmt::format("<script>\n{}\n</script>\n", embeddedFile(name));
  }
  return text;
}

/// JSON that no HTML parser takes for the end of its element. Bytes that are no UTF-8 become
/// U+FFFD, for names of models may hold any.
std::string safeJson(const Json& json) {
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) {
    text.replace(at, 1, "\\u003c");
  }
  return text;
}

/// Pairs of a definition list.
std::string factsHtml(const Facts& facts) {
  std::string html;
  for (const auto& [what, value] : facts) {
    html += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", htmlText(what), htmlText(value));
  }
  return html;
}

std::string warningsHtml(const std::vector<std::string>& warnings) {
  std::string html;
  for (const std::string& warning : warnings) {
    html += fmt::format("<p class=\"warning\">{}</p>\n", htmlText(warning));
  }
  return html;
}

/// Paints three small pictures.
std::string stageHtml(const TrajectoryReader& run, const Look& look) {
  const std::string still = stillPicture(run, look);
  const std::string picture = base64(std::as_bytes(std::span(still)));
  return filled(embeddedFile("stage.html"),
                {{"name", htmlText(run.subject().model.name)}, {"picture", picture}});
}

/// The type of a file by its ending, as browsers know it. Other endings are saved and not shown.
std::string mediaType(const std::filesystem::path& file) {
  const std::pair<const char*, const char*> types[] = {
      {".mp4", "video/mp4"},   {".webm", "video/webm"}, {".png", "image/png"},
      {".apng", "image/apng"}, {".gif", "image/gif"},   {".svg", "image/svg+xml"}};
  for (const auto& [ending, type] : types) {
    if (file.extension() == ending) return type;
  }
  return "application/octet-stream";
}

/// A file within the page: a video, a picture, or a link that saves it. Bytes become a data: URL
/// (RFC 2397), a third longer than the file.
std::string embeddedHtml(const std::filesystem::path& file) {
  const std::string bytes = readTextFile(file, "name files of the run with --embed", kMostEmbedded);
  const std::string type = mediaType(file), name = htmlText(file.filename().string());
  const std::string source =
      fmt::format("data:{};base64,{}", type, base64(std::as_bytes(std::span(bytes))));
  if (type.starts_with("video/")) {
    return fmt::format("<video controls loop src=\"{}\" aria-label=\"{}\"></video>\n", source,
                       name);
  }
  if (type.starts_with("image/")) {
    return fmt::format("<img src=\"{}\" alt=\"{}\">\n", source, name);
  }
  return fmt::format("<a download=\"{0}\" href=\"{1}\">{0}</a>\n", name, source);
}

/// Embedded files are looked for in the run's folder.
std::string wordsHtml(const TrajectoryReader& run, const std::filesystem::path& folder,
                      const std::vector<std::string>& names) {
  std::string files;
  for (const std::string& name : names) files += embeddedHtml(folder / name);
  return filled(embeddedFile("words.html"), {{"name", htmlText(run.subject().model.name)},
                                             {"facts", factsHtml(factsOf(run))},
                                             {"warnings", warningsHtml(warningsOf(run))},
                                             {"files", files}});
}

/// `dataBytes`: what of the page grows with its states, of which it has so many. The message offers
/// as many states as would fit.
void requireSize(const std::string& page, std::size_t dataBytes, std::size_t states,
                 const WebPageSettings& settings) {
  const double most = 1e6 * settings.mostMegabytes, size = static_cast<double>(page.size());
  if (size <= most) return;
  // Fewer states are farther apart, so that each takes a little more.
  // What is too much has to come off the data; `share` is what of them may stay.
  const double share = 0.8 * ((most - size) / static_cast<double>(dataBytes) + 1);
  const auto fewer = static_cast<int>(share * static_cast<double>(states));
  const std::string thinner =
      fewer < 2 ? "" : fmt::format("--samples {} or fewer in place of {}, ", fewer, states);
  throw InputError(
      fmt::format("error: the page would have {:.1f} MB and may have {:g}; give {}{}a larger "
                  "--most-size",
                  size / 1e6, settings.mostMegabytes, thinner,
                  settings.states.exact ? "no --exact, or "
                  : thinner.empty()     ? ""
                                        : "or "));
}

}  // namespace

bool canMakePages() {
  return !embeddedFile("three.min.js").empty();
}

void requirePages() {
  if (canMakePages()) return;
  throw OutputError(
      "error: this program was built without three.js, which pages need; install Debian's "
      "libjs-three, then configure and build again");
}

std::string pageText(const std::vector<std::filesystem::path>& trajectories,
                     const WebPageSettings& settings) {
  requirePages();
  Json data = {{"light", styleJson(Theme::Light, settings.look)},
               {"dark", styleJson(Theme::Dark, settings.look)},
               {"map", mapJson(settings.look.map)},
               {"theme", settings.look.theme == Theme::Dark ? Json("dark") : Json(nullptr)},
               {"runs", Json::array()}};
  std::string title, stages, words;
  for (const std::filesystem::path& file : trajectories) {
    const TrajectoryReader run(file);
    data["runs"].push_back(runJson(run, settings.look, settings.states));
    title += (title.empty() ? "" : " and ") + run.subject().model.name;
    stages += stageHtml(run, settings.look);
    words += wordsHtml(run, file.parent_path(), settings.embedded);
  }
  const std::string text = safeJson(data);
  const std::string page =
      filled(embeddedFile("page.html"), {{"title", htmlText(title)},
                                         {"program", "Kirireel " + programVersion()},
                                         {"count", std::to_string(trajectories.size())},
                                         {"style", std::string(embeddedFile("page.css"))},
                                         {"stages", stages},
                                         {"words", words},
                                         {"data", text},
                                         {"scripts", scripts()}});
  requireSize(page, text.size(), data["runs"][0]["states"]["times"].size(), settings);
  return page;
}

void writePage(const std::vector<std::filesystem::path>& trajectories,
               const WebPageSettings& settings) {
  requirePages();
  FileSet files(settings.folder, output::kContents);
  files.requireFree(
      [](const std::string& name) { return name == output::kContents || name == kPageFile; });
  writeTextFile(files.stage() / kPageFile, pageText(trajectories, settings));
  files.commit(std::vector<std::string>{kPageFile});
}

}  // namespace kirireel
