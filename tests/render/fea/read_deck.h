/// Reads decks back, independently of their writer.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "sim/base/geometry.h"

namespace kirireel::test {

/// An element of a deck.
struct DeckElement {
  std::string type;
  std::vector<int> nodes;
};

/// The content of a deck, by its numbers.
struct Deck {
  std::map<int, Vector3> nodes;
  std::map<int, DeckElement> elements;
  std::map<std::string, std::vector<int>> elementSets;
  std::map<std::string, std::vector<int>> nodeSets;
  std::map<std::string, std::vector<std::pair<int, std::string>>> surfaces;
  std::vector<std::vector<double>> equations;  ///< the rows of numbers below each *EQUATION
  std::map<std::string, int> rigidBodies;      ///< reference nodes by node set
  std::size_t longestLine = 0;
  std::size_t longestNumber = 0;
  std::size_t maxNumbers = 0;  ///< in one line
};

Deck readDeck(const std::string& text);

/// The largest distance of a quadratic element's middle nodes from the middles of its edges, in
/// Abaqus's order of nodes.
double largestMiddleMiss(const Deck& deck, const DeckElement& element);

/// The volume of an element by the corners of its flat faces.
double volumeOf(const Deck& deck, const DeckElement& element);

/// The volume of an element set.
double volumeOf(const Deck& deck, const std::string& elementSet);

}  // namespace kirireel::test
