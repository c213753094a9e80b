/// Pages as PDF and as PNG, by Cairo. No Cairo header is needed to make them.
#pragma once

#include <memory>

#include "render/vector/canvas.h"

namespace kirireel {

/// Writes a PDF of one page, as large as the settings' pixels are at their resolution: shapes are
/// shapes, text is text, and its font is embedded. The same page gives the same bytes. finish()
/// throws OutputError.
std::unique_ptr<Canvas> makePdfCanvas(const PageSettings& settings);

/// Writes a PNG with as many pixels as the settings say, and notes their resolution. The same page
/// gives the same bytes. Throws OutputError when there is too little memory.
std::unique_ptr<Canvas> makePngCanvas(const PageSettings& settings);

/// A page of any format. The settings' size must be valid, see requireValidSize().
std::unique_ptr<Canvas> makeCanvas(PageFormat format, const PageSettings& settings);

}  // namespace kirireel
