/// Words in messages: what a mistyped one was meant to be, and how foreign text is shown and read.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kirireel {

/// Letters to insert, delete or replace to turn one word into the other (Levenshtein 1966).
int editDistance(std::string_view a, std::string_view b);

/// ", did you mean WORD?" for the nearest of the known words, or an empty text when none is within
/// a third of the word's letters (at least 2).
std::string suggestion(std::string_view word, const std::vector<std::string>& knownWords);

/// A text with '?' in place of each control character, so that it takes one line and no terminal
/// acts on it.
std::string oneLine(std::string_view text);

/// A text of unknown origin as a message shows it: at most `most` characters, then "...", with '?'
/// in place of each byte that is not printable ASCII.
std::string shown(std::string_view text, std::size_t most = 40);

/// The characters of a text in UTF-8; absent when it is not UTF-8.
std::optional<std::u32string> codePoints(std::string_view text);

}  // namespace kirireel
