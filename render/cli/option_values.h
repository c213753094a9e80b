/// Reads the values of options. Every function throws InputError that names the option, the value
/// found and what is allowed.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "render/grid/grid.h"
#include "render/picture/camera_path.h"
#include "render/picture/frame.h"
#include "render/record/record.h"
#include "sim/base/error.h"
#include "sim/base/geometry.h"

namespace kirireel {

/// An option as typed: its name and its value.
struct OptionValue {
  std::string name;  ///< with its hyphens
  std::string text;
};

/// The numbers that an option accepts.
struct Range {
  double least = -std::numeric_limits<double>::max();
  double most = std::numeric_limits<double>::max();
  bool isMostLeftOut = false;  ///< all below the most; otherwise both ends are accepted

  bool holds(double number) const {
    return number >= least && (isMostLeftOut ? number < most : number <= most);
  }
};

/// A finite number within the range.
double parseNumber(const OptionValue& value, Range range);

/// A whole number within the range (which must lie within the numbers of a long).
long parseInteger(const OptionValue& value, Range range);

/// "1280x720": a valid frame size.
FrameSize parseSize(const OptionValue& value);

/// "3x4": rows x columns, each 1 to 100.
GridShape parseGrid(const OptionValue& value);

/// "0,1.5,50%": seconds from 0, or shares of the way from 0% to 100%.
std::vector<FrameChoice> parseFrameChoices(const OptionValue& value);

/// "-9.81" (along z, as PyKirigami has it) or "0,0,-9.81".
Vector3 parseGravity(const OptionValue& value);

/// "0.1,0.3,2e9" or "0.1,0.3,2e9,0.3": a neck's width, length, Young's modulus, each above 0, and
/// Poisson's ratio.
HingeNeck parseNeck(const OptionValue& value);

/// "80AEDC" or "#80AEDC": red, green and blue in hexadecimal; or a usual name of CSS, "teal".
Colour parseColour(const OptionValue& value);

/// "0:50:-35:1,2.5:90:-20:1.5": keys of a camera as TIME:YAW:PITCH:ZOOM, seconds and degrees.
std::vector<CameraKey> parseCameraKeys(const OptionValue& value);

/// "time,error": parts of a caption, or "none".
CaptionParts parseCaption(const OptionValue& value);

/// "all" or numbers of tiles, e.g. "3,7,8"; empty for all.
std::vector<int> parseTiles(const OptionValue& value);

/// The error of a value that is not allowed: "--NAME: 'TEXT' is not allowed; give WANTED".
InputError valueError(const OptionValue& value, const std::string& wanted);

/// The words that an option accepts, with what each means.
template <typename T>
using Choices = std::vector<std::pair<std::string, T>>;

/// The functions below write what those above read, as values of a scene file.

/// The shortest digits that read back as the same double.
std::string numberText(double number);

/// A text in quotation marks; "" stays "".
std::string quotedText(const std::string& text);

/// Values of an option that may be given several times: nothing, the one, or all in brackets.
std::string quotedList(const std::vector<std::string>& values);

/// The shortest number that `read` turns into `wanted`, which lies near `guess`: the way back where
/// a unit was converted.
double numberReadAs(double wanted, double guess, const std::function<double(double)>& read);

std::string sizeText(FrameSize size);
std::string gridText(GridShape grid);
std::string frameChoicesText(const std::vector<FrameChoice>& choices);
std::string vectorText(const Vector3& vector);
std::string colourText(Colour colour);
std::string cameraKeysText(const std::vector<CameraKey>& keys);
std::string captionText(const CaptionParts& parts);
std::string tilesText(const std::vector<int>& tiles);

/// Degrees that yaw and pitch were typed as.
struct TypedView {
  double yaw = 0;
  double pitch = 0;
};
TypedView typedView(const ViewAngles& view);

/// "all, unjoined or none".
std::string listWords(const std::vector<std::string>& words);

/// The names of the choices, in order.
template <typename T>
std::vector<std::string> choiceNames(const Choices<T>& choices) {
  std::vector<std::string> names;
  for (const auto& choice : choices) names.push_back(choice.first);
  return names;
}

/// The name of a value among the choices; "" when it is none of them.
template <typename T, typename Value>
std::string nameOfChoice(const Choices<T>& choices, const Value& value) {
  for (const auto& [name, meaning] : choices) {
    if (Value(meaning) == value) return name;
  }
  return "";
}

/// What the value stands for among the choices.
template <typename T>
T parseChoice(const OptionValue& value, const Choices<T>& choices) {
  for (const auto& [name, meaning] : choices) {
    if (name == value.text) return meaning;
  }
  throw valueError(value, listWords(choiceNames(choices)));
}

}  // namespace kirireel
