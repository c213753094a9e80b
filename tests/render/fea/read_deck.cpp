#include "tests/render/fea/read_deck.h"

#include <algorithm>
#include <cctype>
#include <sstream>

#include <gtest/gtest.h>

namespace kirireel::test {
namespace {

std::vector<std::string> fieldsOf(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) {
    const std::size_t first = field.find_first_not_of(' ');
    if (first != std::string::npos) fields.push_back(field.substr(first));
  }
  return fields;
}

/// "*NODE, NSET=NALL" as a keyword and its parameters.
struct Card {
  std::string keyword;
  std::map<std::string, std::string> parameters;
};

Card cardOf(const std::string& line) {
  const std::vector<std::string> fields = fieldsOf(line);
  Card card{fields[0], {}};
  for (std::size_t k = 1; k < fields.size(); ++k) {
    const std::size_t equals = fields[k].find('=');
    const std::string value = equals == std::string::npos ? "" : fields[k].substr(equals + 1);
    std::string name = fields[k].substr(0, equals);
    std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::toupper(c); });
    card.parameters[name] = value;
  }
  return card;
}

/// One row of data, continued rows joined.
void readRow(const Card& card, const std::vector<std::string>& fields, Deck& deck) {
  const auto whole = [&](std::size_t k) { return std::stoi(fields[k]); };
  const auto number = [&](std::size_t k) { return std::strtod(fields[k].c_str(), nullptr); };
  const auto parameter = [&](const char* name) { return card.parameters.at(name); };
  if (card.keyword == "*NODE") {
    EXPECT_TRUE(deck.nodes.emplace(whole(0), Vector3(number(1), number(2), number(3))).second);
  } else if (card.keyword == "*ELEMENT") {
    DeckElement& element = deck.elements[whole(0)];
    element.type = parameter("TYPE");
    for (std::size_t k = 1; k < fields.size(); ++k) element.nodes.push_back(whole(k));
    if (card.parameters.contains("ELSET")) deck.elementSets[parameter("ELSET")].push_back(whole(0));
  } else if (card.keyword == "*ELSET") {
    std::vector<int>& set = deck.elementSets[parameter("ELSET")];
    if (card.parameters.contains("GENERATE")) {
      for (int k = whole(0); k <= whole(1); ++k) set.push_back(k);
    } else {
      for (std::size_t k = 0; k < fields.size(); ++k) set.push_back(whole(k));
    }
  } else if (card.keyword == "*NSET") {
    for (std::size_t k = 0; k < fields.size(); ++k) {
      deck.nodeSets[parameter("NSET")].push_back(whole(k));
    }
  } else if (card.keyword == "*SURFACE") {
    deck.surfaces[parameter("NAME")].emplace_back(whole(0), fields[1]);
  } else if (card.keyword == "*EQUATION") {
    if (fields.size() == 1) return;
    std::vector<double>& row = deck.equations.emplace_back();
    for (std::size_t k = 0; k < fields.size(); ++k) row.push_back(number(k));
  }
}

void measure(const std::string& line, Deck& deck) {
  deck.longestLine = std::max(deck.longestLine, line.size());
  if (line[0] == '*') return;
  const std::vector<std::string> fields = fieldsOf(line);
  deck.maxNumbers = std::max(deck.maxNumbers, fields.size());
  for (const std::string& field : fields) {
    deck.longestNumber = std::max(deck.longestNumber, field.size());
  }
}

}  // namespace

Deck readDeck(const std::string& text) {
  Deck deck;
  Card card;
  std::string row;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    measure(line, deck);
    if (line.starts_with("**")) continue;
    if (line[0] == '*') {
      card = cardOf(line);
      if (card.keyword == "*RIGID BODY") {
        const bool isPinned = card.parameters.contains("PIN NSET");
        deck.rigidBodies[card.parameters.at(isPinned ? "PIN NSET" : "NSET")] =
            std::stoi(card.parameters.at("REF NODE"));
      }
      continue;
    }
    row += line.substr(0, line.find_last_not_of(' ') + 1);
    if (row.back() == ',' && card.keyword == "*ELEMENT") continue;
    readRow(card, fieldsOf(row), deck);
    row.clear();
  }
  return deck;
}

double largestMiddleMiss(const Deck& deck, const DeckElement& element) {
  const int n = 4;
  const auto at = [&](int k) { return deck.nodes.at(element.nodes.at(k)); };
  const auto miss = [&](int middle, int a, int b) {
    return (at(middle) - 0.5 * (at(a) + at(b))).norm();
  };
  double largest = 0;
  for (int k = 0; k < n; ++k) {
    const int next = (k + 1) % n;
    largest = std::max({largest, miss(2 * n + k, k, next), miss(3 * n + k, n + k, n + next),
                        miss(4 * n + k, k, n + k)});
  }
  return largest;
}

double volumeOf(const Deck& deck, const DeckElement& element) {
  const int n = 4;
  const Vector3 origin = deck.nodes.at(element.nodes[0]);
  double sixfold = 0;
  const auto addTriangle = [&](int a, int b, int c) {
    const auto at = [&](int k) -> Vector3 { return deck.nodes.at(element.nodes[k]) - origin; };
    sixfold += at(a).dot(at(b).cross(at(c)));
  };
  for (int k = 2; k < n; ++k) {
    addTriangle(0, k, k - 1);
    addTriangle(n, n + k - 1, n + k);
  }
  for (int k = 0; k < n; ++k) {
    const int next = (k + 1) % n;
    addTriangle(k, next, n + next);
    addTriangle(k, n + next, n + k);
  }
  return sixfold / 6;
}

double volumeOf(const Deck& deck, const std::string& elementSet) {
  double sum = 0;
  for (const int element : deck.elementSets.at(elementSet)) {
    sum += volumeOf(deck, deck.elements.at(element));
  }
  return sum;
}

}  // namespace kirireel::test
