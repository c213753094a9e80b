/// Finds what a mistyped word was meant to be.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace kirireel {

/// Letters to insert, delete or replace to turn one word into the other (Levenshtein 1966).
int editDistance(std::string_view a, std::string_view b);

/// ", did you mean WORD?" for the nearest of the known words, or an empty text when none is within
/// a third of the word's letters (at least 2).
std::string suggestion(std::string_view word, const std::vector<std::string>& knownWords);

}  // namespace kirireel
