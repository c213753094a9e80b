/// Pages as PDF, for print. No Cairo header is needed to make them.
#pragma once

#include <memory>
#include <string>

#include "render/vector/canvas.h"

namespace kirireel {

/// Writes a PDF of one page, as large as the settings' pixels are at their resolution: shapes are
/// shapes, text is text, and its font is embedded. The same page gives the same bytes.
class PdfCanvas : public Canvas {
 public:
  explicit PdfCanvas(const PageSettings& settings);
  ~PdfCanvas() override;
  PdfCanvas(const PdfCanvas&) = delete;
  PdfCanvas& operator=(const PdfCanvas&) = delete;

  void begin(const std::string& name, double opacity = 1) override;
  void beginWithin(const std::string& name, double left, double upper, double width,
                   double height) override;
  void end() override;
  void polygon(const Points& corners, Colour colour) override;
  void seams(const std::vector<Points>& lines, Colour colour) override;
  void outlines(const std::vector<Points>& lines) override;
  void box(double left, double upper, double width, double height, Colour colour) override;
  void text(const std::string& line, double left, double baseline, int em, Colour colour) override;

  std::string finish() override;

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

}  // namespace kirireel
