// A page is a column of rows, and a row has one or more panels. All lengths are pixels at the
// page's resolution; em is the size of the text.
//
//     row width = sum of the panels' widths + gaps; width of a panel = share / sum of shares
//     1.6 em for letter and title, then the panel, then a gap
//
// The height of a row is that of its highest pictures. Plots fill this height, but are never lower
// than minHeight(). A row without pictures is as high as its highest plot. A height in the page
// file has priority. Pictures are in the middle of their panel. A plot without a title has its
// letter next to the title of its first diagram, so it begins higher.
//
// Pictures and plots draw themselves (PanelSheet, PlotSheet), as in the commands `render` and
// `curves`. Outlines belong to a panel, so panels may differ in them.
#include "render/record/figure_page.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include <fmt/format.h>

#include "render/output/output_folder.h"
#include "render/picture/grid.h"
#include "render/picture/label.h"
#include "render/record/run_pictures.h"
#include "render/record/summary.h"
#include "sim/base/files.h"
#include "sim/scene/scene_file.h"

namespace kirireel::record {
namespace {

/// The strip for letter and title is as in grids. The baseline of a diagram's title is 1.4 em below
/// the upper side of its box.
using picture::kHeadBaselineEms;
using picture::kHeadEms;
constexpr double kPlotRiseEms = 0.3;
/// Between panels of a row, and between rows; em.
constexpr double kPanelGapEms = 1;
constexpr double kRowGapEms = 1;
/// The narrowest panel, and the narrowest plot with two diagrams per row; em.
constexpr double kNarrowestEms = 10;
constexpr double kTwoColumnsEms = 50;

/// The content of a panel in a given width.
class PanelContent {
 public:
  virtual ~PanelContent() = default;
  /// Fits it to a width, and to a height if there is one. Returns its height. Pixels.
  virtual double fit(double width, std::optional<double> height) = 0;
  /// Draws the fitted content into a box, which is at least as high.
  virtual void draw(picture::Canvas& canvas, const picture::PageBox& box,
                    const std::string& name) = 0;
  /// Whether it begins with a line of text that may be next to a letter.
  virtual bool hasHead() const = 0;
  /// The models of its runs.
  virtual const std::vector<std::string>& models() const = 0;
};

class PicturePanel : public PanelContent {
 public:
  PicturePanel(const FigurePanel& panel, int em, double pixelsPerInch)
      : settings_(panel.pictures), em_(em), pixelsPerInch_(pixelsPerInch) {
    std::vector<std::unique_ptr<trajectory::TrajectoryReader>> opened;
    std::vector<const trajectory::TrajectoryReader*> runs;
    for (const std::filesystem::path& run : panel.runs) {
      opened.push_back(std::make_unique<trajectory::TrajectoryReader>(run));
      runs.push_back(opened.back().get());
      models_.push_back(runs.back()->subject().model.name);
    }
    if (runs.size() > 1) settings_.grid.rows = static_cast<int>(runs.size());
    rows_ = figureRows(runs, settings_);
    sheet_ = std::make_unique<PanelSheet>(rows_, settings_.grid, settings_, report_);
  }

  double fit(double width, std::optional<double> height) override {
    size_ = sheet_->fit(width, em_, pixelsPerInch_);
    // Text keeps its size, so the height is not proportional to the width.
    for (int k = 0; k < kTrials && height && size_.height > *height; ++k) {
      width *= std::min(0.99, *height / size_.height);
      size_ = sheet_->fit(width, em_, pixelsPerInch_);
    }
    return size_.height;
  }

  void draw(picture::Canvas& canvas, const picture::PageBox& box,
            const std::string& name) override {
    const Eigen::Vector2d corner(box.left + std::floor((box.width - size_.width) / 2),
                                 box.upper + std::floor((box.height - size_.height) / 2));
    sheet_->draw(canvas, corner, name);
  }

  bool hasHead() const override { return false; }
  const std::vector<std::string>& models() const override { return models_; }

 private:
  static constexpr int kTrials = 20;

  PictureSettings settings_;
  PictureReport report_;
  int em_;
  double pixelsPerInch_;
  std::vector<std::string> models_;
  std::vector<PanelRow> rows_;
  std::unique_ptr<PanelSheet> sheet_;
  picture::FrameSize size_;
};

class PlotPanel : public PanelContent {
 public:
  PlotPanel(const FigurePanel& panel, int em) : em_(em), hasTitle_(!panel.title.empty()) {
    std::vector<NamedRun> runs;
    for (const std::filesystem::path& run : panel.runs) {
      runs.push_back(openRun(run));
      models_.push_back(runs.back().reader->subject().model.name);
    }
    plotted_ = plottedRuns(runs, *panel.curves);
    sheet_ = std::make_unique<PlotSheet>(plotted_, em);
  }

  double fit(double width, std::optional<double> height) override {
    columns_ = width < kTwoColumnsEms * em_ ? 1 : PlotSheet::kColumns;
    return height ? std::max(*height, sheet_->minHeight(columns_))
                  : sheet_->height(width, columns_);
  }

  void draw(picture::Canvas& canvas, const picture::PageBox& box,
            const std::string& name) override {
    canvas.begin(name);
    sheet_->draw(canvas, box, columns_, name + '_');
    canvas.end();
  }

  bool hasHead() const override { return !hasTitle_; }
  const std::vector<std::string>& models() const override { return models_; }

 private:
  int em_;
  bool hasTitle_;
  int columns_ = 1;
  std::vector<std::string> models_;
  std::vector<PlottedRun> plotted_;
  std::unique_ptr<PlotSheet> sheet_;
};

/// A panel with its place on the page.
struct PlacedPanel {
  const FigurePanel& panel;
  std::unique_ptr<PanelContent> content;
  picture::PageBox box = {};  ///< without letter and title
};

/// Adds the position of the panel to errors in it.
template <typename Function>
auto located(const FigurePanel& panel, const Function& function) {
  try {
    return function();
  } catch (const InputError& error) {
    throw scene::locatedAt(panel.where, error);
  }
}

/// Reads the runs of all panels, then lays them out and draws them.
class PageComposer {
 public:
  explicit PageComposer(const FigurePage& page)
      : page_(page), em_(picture::emOf(page.fontPoints, page.dotsPerInch)) {
    size_.width = picture::pixelsOf(page.width, page.dotsPerInch);
    for (const std::vector<FigurePanel>& row : page.rows) {
      rows_.emplace_back();
      for (const FigurePanel& panel : row) rows_.back().push_back({panel, contentOf(panel)});
    }
    double y = 0;
    for (std::vector<PlacedPanel>& row : rows_) y = place(row, y);
    size_.height = static_cast<int>(std::ceil(y - kRowGapEms * em_));
    picture::requireValidSize(size_);
  }

  std::string draw(picture::PageFormat format) const {
    const std::unique_ptr<picture::Canvas> canvas =
        picture::makeCanvas(format, {.size = size_,
                                     .pixelsPerInch = page_.dotsPerInch,
                                     .fontFamily = picture::fontFamily(),
                                     .description = madeBy(models_)});
    int number = 0;
    for (const std::vector<PlacedPanel>& row : rows_) {
      for (const PlacedPanel& placed : row) drawPanel(placed, number++, *canvas);
    }
    return canvas->finish();
  }

 private:
  std::unique_ptr<PanelContent> contentOf(const FigurePanel& panel) {
    std::unique_ptr<PanelContent> content = located(panel, [&]() -> std::unique_ptr<PanelContent> {
      picture::requireDrawable("title", panel.title);
      if (panel.curves) return std::make_unique<PlotPanel>(panel, em_);
      return std::make_unique<PicturePanel>(panel, em_, page_.dotsPerInch);
    });
    for (const std::string& model : content->models()) {
      if (std::ranges::find(models_, model) == models_.end()) models_.push_back(model);
    }
    return content;
  }

  double pixels(double millimetres) const {
    return millimetres / picture::kMillimetresPerInch * page_.dotsPerInch;
  }

  /// Space above the panels of a row for their letters and titles.
  double headHeight(const std::vector<PlacedPanel>& row) const {
    const bool hasTitles = std::ranges::any_of(
        row, [](const PlacedPanel& placed) { return !placed.panel.title.empty(); });
    return hasTitles || page_.letters != picture::PanelLetters::None ? kHeadEms * em_ : 0;
  }

  /// Fits the panels of a row to its width.
  double fitRow(std::vector<PlacedPanel>& row) const {
    double height = 0;
    const auto fit = [&](PlacedPanel& placed, std::optional<double> room) {
      const double needed =
          located(placed.panel, [&] { return placed.content->fit(placed.box.width, room); });
      height = std::max(height, needed);
    };
    std::vector<PlacedPanel*> flexible;  // plots that fill the row
    for (PlacedPanel& placed : row) {
      if (placed.panel.curves && !placed.panel.height) {
        flexible.push_back(&placed);
      } else {
        std::optional<double> most;
        if (placed.panel.height) most = pixels(*placed.panel.height);
        fit(placed, most);
      }
    }
    const std::optional<double> given = height > 0 ? std::optional(height) : std::nullopt;
    for (PlacedPanel* placed : flexible) fit(*placed, given);
    return height;
  }

  /// Returns the upper side of the next row.
  double place(std::vector<PlacedPanel>& row, double upper) const {
    const double shares = std::accumulate(
        row.begin(), row.end(), 0.0,
        [](double sum, const PlacedPanel& placed) { return sum + placed.panel.share; });
    const double gaps = static_cast<double>(row.size() - 1) * kPanelGapEms * em_;
    double left = 0;
    for (PlacedPanel& placed : row) {
      placed.box.left = left;
      placed.box.width = std::floor(placed.panel.share / shares * (size_.width - gaps));
      left += placed.box.width + kPanelGapEms * em_;
      if (placed.box.width >= kNarrowestEms * em_) continue;
      throw inputErrorAt(
          placed.panel.where,
          fmt::format("this panel is {:.3g} mm wide, at least {:.3g} mm are needed; "
                      "give it a larger share, or its row fewer panels",
                      placed.box.width / pixels(1), kNarrowestEms * em_ / pixels(1)));
    }
    const double head = headHeight(row);
    const double height = fitRow(row);
    for (PlacedPanel& placed : row) {
      placed.box.upper = upper + head;
      placed.box.height = height;
      if (head == 0 || !placed.content->hasHead()) continue;
      const double raised = head + kPlotRiseEms * em_;
      placed.box.upper -= raised;
      placed.box.height += raised;
    }
    return upper + head + height + kRowGapEms * em_;
  }

  void drawPanel(const PlacedPanel& placed, int number, picture::Canvas& canvas) const {
    const std::string name = fmt::format("panel_{}", number + 1);
    located(placed.panel, [&] { placed.content->draw(canvas, placed.box, name); });
    if (page_.letters == picture::PanelLetters::None && placed.panel.title.empty()) return;
    canvas.begin(name + "_head");
    const double raised = placed.content->hasHead() ? kPlotRiseEms : -kHeadEms;
    picture::drawHead(canvas, page_.letters, number, placed.panel.title, placed.box.left,
                      placed.box.upper + (raised + kHeadBaselineEms) * em_, em_,
                      picture::Style().text);
    canvas.end();
  }

  const FigurePage& page_;
  int em_;
  picture::FrameSize size_;
  std::vector<std::string> models_;
  std::vector<std::vector<PlacedPanel>> rows_;
};

}  // namespace

picture::PageFormat pageFormatOf(const std::string& file) {
  for (const auto& [word, format] : picture::kPageFormats) {
    if (endingOf(file) == std::string(".") + word) return format;
  }
  throw InputError(fmt::format(
      "error: {} has no format of a page; give a name that ends in .pdf, .svg or .png", file));
}

void writeFigure(const FigurePage& page) {
  picture::setFont(page.font);
  output::FileSet files(page.folder, output::kContents);
  files.requireFree(page.files);
  const PageComposer composer(page);
  for (const std::string& file : page.files) {
    writeTextFile(files.stage() / file, composer.draw(pageFormatOf(file)));
  }
  files.commit(page.files);
}

}  // namespace kirireel::record
