/// Reads the values of options about pictures and exports; those of a scene are read by
/// sim/scene/setting_values.h. Every function throws InputError that names the option, the value
/// found and what is allowed.
#pragma once

#include <string>
#include <vector>

#include "render/grid/grid.h"
#include "render/picture/camera_path.h"
#include "render/picture/frame.h"
#include "render/record/record.h"
#include "sim/base/geometry.h"
#include "sim/scene/setting_values.h"

namespace kirireel {

/// "1280x720": a valid frame size. Width before height, in pixels, each from 1 to kMaxFrameSide.
FrameSize parseSize(const TypedValue& value);

/// "3x4": rows x columns, each 1 to 100.
GridShape parseGrid(const TypedValue& value);

/// "0,1.5,50%": seconds from 0, or shares of the way from 0% to 100%.
std::vector<FrameChoice> parseFrameChoices(const TypedValue& value);

/// "80AEDC" or "#80AEDC": red, green and blue in hexadecimal; or a usual name of CSS, "teal".
Colour parseColour(const TypedValue& value);

/// "0:50:-35:1,2.5:90:-20:1.5": keys of a camera as TIME:YAW:PITCH:ZOOM, seconds and degrees. Yaw
/// and pitch are PyKirigami's; zoom is a factor. That times rise is checked by CameraPath.
std::vector<CameraKey> parseCameraKeys(const TypedValue& value);

/// "time,error": parts of a caption, or "none". Parts are progress, time, angle, error and gap;
/// "none" stands alone.
CaptionParts parseCaption(const TypedValue& value);

/// "all" or numbers of tiles, e.g. "3,7,8"; empty for all.
std::vector<int> parseTiles(const TypedValue& value);

/// "3,7,10-15=teal": numbers of tiles, or ranges of them, and a colour.
TileColour parseTileColour(const TypedValue& value);

/// The functions below write what those above read, as values of a scene file.

/// "1280x720" in quotation marks.
std::string sizeText(FrameSize size);
/// Rows by columns, "3x4".
std::string gridText(GridShape grid);
/// Shares with a per cent sign, seconds without.
std::string frameChoicesText(const std::vector<FrameChoice>& choices);
/// Six hexadecimal digits in capitals.
std::string colourText(Colour colour);
/// Each as TILES=COLOUR.
std::string tileColoursText(const std::vector<TileColour>& colours);
/// TIME:YAW:PITCH:ZOOM with commas; degrees.
std::string cameraKeysText(const std::vector<CameraKey>& keys);
/// Words with commas, "none" where no part is wanted.
std::string captionText(const CaptionParts& parts);
/// Numbers with commas, "all" for none.
std::string tilesText(const std::vector<int>& tiles);

/// Degrees that yaw and pitch were typed as.
struct TypedView {
  double yaw = 0;
  double pitch = 0;
};
/// The shortest degrees that read back to this view, to the last bit.
TypedView typedView(const ViewAngles& view);

}  // namespace kirireel
