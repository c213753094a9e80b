/// Pages as SVG, for print and for editing.
#pragma once

#include <iterator>
#include <string>

#include <fmt/format.h>

#include "render/vector/canvas.h"

namespace kirireel {

/// Writes SVG 1.1 that every program reads: filled paths, lines and text, named groups that editors
/// show as layers, and one style sheet that says how faces, outlines and text look. The same page
/// gives the same bytes.
class SvgCanvas : public Canvas {
 public:
  explicit SvgCanvas(const PageSettings& settings);

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

  std::string finish() override;

 private:
  template <typename... Arguments>
  void append(fmt::format_string<Arguments...> form, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(file_), form, std::forward<Arguments>(arguments)...);
  }

  std::string file_;
  int depth_ = 0;  ///< of groups
  int clips_ = 0;
};

}  // namespace kirireel
