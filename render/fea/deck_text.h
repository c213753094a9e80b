/// The words that decks are made of, within the limits of their readers.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "sim/base/geometry.h"

namespace kirireel {

/// Which program's keywords a deck uses, where the two differ.
enum class Solver { Calculix, Abaqus };

/// Which named sets a deck holds beside those of the whole sheet and its boundary.
enum class SetChoice {
  Usual,  ///< All up to 1,000 tiles, None above: readers look through all names for each name
  None,
  Joints,  ///< the nodes of each joint
  All,     ///< and of each tile its nodes, faces and surfaces
};

/// What tiles are made of; SI units whatever the deck's.
struct Material {
  double youngs = 1e9;    ///< Young's modulus, Pa, positive
  double poisson = 0.3;   ///< Poisson's ratio, above -1, below 0.5
  double density = 1000;  ///< kg/m^3, positive
};

/// The consistent units of a deck.
enum class DeckUnit {
  Model,               ///< metres, kilograms, seconds, newtons
  MillimetresNewtons,  ///< millimetres, tonnes, seconds, newtons: stress in MPa
};

/// What an SI quantity is multiplied by to stand in a deck.
struct UnitScale {
  /// Deck units by metre: 1 or 1e3.
  double length = 1;
  /// Deck units by pascal: 1 or 1e-6. Forces keep their newtons.
  double stress = 1;
  /// Deck units by kg/m^3: 1 or 1e-12.
  double density = 1;
  /// For comments; it lives as long as the program.
  const char* words = "m, N, kg, s, Pa";
};

/// Which tiles a job moves as the trajectory did.
struct DriveChoice {
  enum Kind {
    None,
    All,   ///< every tile
    Edge,  ///< those at the two ends of the sheet's longest axis
    Some,  ///< those listed
  };
  Kind kind = None;
  std::vector<int> tiles;  ///< of Some, as the model's file numbers them
};

/// How decks are written.
struct DeckSettings {
  Solver solver = Solver::Calculix;
  SetChoice sets = SetChoice::Usual;
  Material material;
  DeckUnit unit = DeckUnit::Model;
  DriveChoice drive;      ///< of a second job, which follows the deployment
  bool buckling = false;  ///< a job that finds buckling loads
  bool stateMap = false;  ///< jobs that take the first state that is exported to the others
  bool periodic = false;  ///< a job that strains a sheet whose opposite ends are tied
  std::optional<double> contactFriction;  ///< of contact between flanks, from 0; absent: none
};

/// Where a deck comes from, for its header.
struct DeckOrigin {
  std::string model;     ///< the model's name
  std::string state;     ///< as it was asked for, such as "final"
  double time = 0;       ///< of the state, seconds
  double thickness = 0;  ///< of the bricks, metres
  double overlap = 0;    ///< the deepest of two bricks in this state, metres
  std::string writer;    ///< program and version
  std::string run;       ///< what tells the run from others, one line
};

/// By what SI quantities are multiplied, and the words for a deck's header.
UnitScale unitScale(DeckUnit unit);

/// Whether bricks overlap by more than an analysis with contact can leave unsaid; metres. True
/// above 1e-4 of the thickness.
bool isOverlapToTell(double overlap, double thickness);

/// A number in at most 20 characters, which is all that CalculiX and Abaqus read of it: the
/// shortest text that reads back to the same double where it fits, else 14 digits. Zero for
/// magnitudes below 1e-90. The value must be finite: neither program reads "nan" or "inf".
std::string deckNumber(double value);

/// Appends formatted text.
template <typename... Arguments>
void append(std::string& text, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Arguments>(arguments)...);
}

/// Appends numbers from 0 as numbers from 1, at most 16 a line. A count of 0 appends nothing, not
/// even a line break.
void appendNumbers(std::string& text, const int* numbers, std::size_t count);

/// Appends *NSET with these nodes, numbered from 0; nothing for an empty set.
void appendNodeSet(std::string& text, const std::string& name, const std::vector<int>& nodes);

/// Appends comment lines that say where a deck comes from, and warn of bricks that overlap. Names
/// are made printable and cut to 200 characters.
void appendOrigin(std::string& text, const DeckOrigin& origin, DeckUnit unit);

/// The card *HEADING with its one line of data, at most 80 characters.
std::string heading(const DeckOrigin& origin, const std::string& subject);

}  // namespace kirireel
