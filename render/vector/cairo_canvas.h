/// Pages as PDF and as PNG, by Cairo. No Cairo header is needed to make them.
#pragma once

#include <memory>
#include <string>

#include "render/vector/canvas.h"

namespace kirireel {

/// What both have in common: how Cairo draws.
class CairoCanvas : public Canvas {
 public:
  ~CairoCanvas() override;
  CairoCanvas(const CairoCanvas&) = delete;
  CairoCanvas& operator=(const CairoCanvas&) = delete;

  void begin(const std::string& name, double opacity = 1) override;
  void beginWithin(const std::string& name, double left, double upper, double width,
                   double height) override;
  void end() override;
  void polygon(const Points& corners, Colour colour) override;
  void seams(const std::vector<Points>& lines, Colour colour) override;
  void outlines(const std::vector<Points>& lines) override;
  void lines(const std::vector<Points>& lines, double width, Colour colour) override;
  void box(double left, double upper, double width, double height, Colour colour) override;
  void text(const std::string& line, double left, double baseline, int em, Colour colour) override;

 protected:
  struct Internals;
  CairoCanvas();

  std::unique_ptr<Internals> internals_;  ///< made by the constructors below
};

/// Writes a PDF of one page, as large as the settings' pixels are at their resolution: shapes are
/// shapes, text is text, and its font is embedded. The same page gives the same bytes.
class PdfCanvas : public CairoCanvas {
 public:
  explicit PdfCanvas(const PageSettings& settings);
  ~PdfCanvas() override;

  std::string finish() override;

 private:
  std::unique_ptr<std::string> file_;  ///< that Cairo writes into
};

/// Writes a PNG with as many pixels as the settings say, and notes their resolution. The same page
/// gives the same bytes. Throws OutputError when there is too little memory.
class PngCanvas : public CairoCanvas {
 public:
  explicit PngCanvas(const PageSettings& settings);

  std::string finish() override;

 private:
  PageSettings settings_;
};

/// A page of any format.
std::unique_ptr<Canvas> makeCanvas(PageFormat format, const PageSettings& settings);

}  // namespace kirireel
