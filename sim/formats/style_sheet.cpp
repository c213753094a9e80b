// Style sheets (W3C, Cascading Style Sheets Level 2, chapters 4 to 6). Of the rules that fit an
// element, the one with the highest specificity decides: ids, then classes, then tags. Of equal
// rules, the last decides.
#include "sim/formats/style_sheet.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/formats/drawing.h"

namespace kirireel::formats {
namespace {

constexpr std::string_view kStyleBlank = " \t\r\n\f";

/// The first of some characters outside quotes, parentheses and braces; npos without one.
std::size_t findOutside(std::string_view text, std::size_t at, std::string_view characters) {
  char quote = '\0';
  int depth = 0;
  for (; at < text.size(); ++at) {
    const char here = text[at];
    if (quote != '\0') {
      if (here == quote) quote = '\0';
    } else if (here == '"' || here == '\'') {
      quote = here;
    } else if (depth == 0 && characters.find(here) != characters.npos) {
      return at;
    } else if (here == '(' || here == '{') {
      ++depth;
    } else if (here == ')' || here == '}') {
      depth = std::max(0, depth - 1);
    }
  }
  return text.npos;
}

void eraseAll(std::string& text, std::string_view begin, std::string_view end) {
  for (std::size_t at = text.find(begin); at != text.npos; at = text.find(begin, at)) {
    const std::size_t last = text.find(end, at + begin.size());
    text.replace(at, last == text.npos ? text.npos : last + end.size() - at, " ");
  }
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kStyleBlank);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(kStyleBlank) - begin + 1);
}

std::string localName(const char* name) {
  const char* const colon = std::strrchr(name, ':');
  return lowerCase(colon ? colon + 1 : name);
}

StyleValues declarations(std::string_view text) {
  StyleValues found;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(findOutside(text, at, ";"), text.size());
    const std::string_view one = text.substr(at, end - at);
    if (const std::size_t colon = one.find(':'); colon != one.npos) {
      const std::string_view whole = trimmed(one.substr(colon + 1));
      const std::size_t mark = std::min(whole.find('!'), whole.size());
      found[lowerCase(trimmed(one.substr(0, colon)))] = {
          std::string(trimmed(whole.substr(0, mark))), mark < whole.size()};
    }
    at = end + 1;
  }
  return found;
}

void overrideWith(StyleValues& values, const StyleValues& with) {
  for (const auto& [name, value] : with) {
    StyleValue& known = values[name];
    if (value.isImportant || !known.isImportant) known = value;
  }
}

std::vector<std::string> classesOf(std::string_view all) {
  std::vector<std::string> classes;
  for (std::size_t at = all.find_first_not_of(kStyleBlank); at != all.npos;) {
    const std::size_t end = std::min(all.find_first_of(kStyleBlank, at), all.size());
    classes.emplace_back(all.substr(at, end - at));
    at = all.find_first_not_of(kStyleBlank, end);
  }
  return classes;
}

void StyleSheet::add(std::string text) {
  eraseAll(text, "/*", "*/");
  const std::string_view sheet = text;
  for (std::size_t at = sheet.find_first_not_of(kStyleBlank); at != sheet.npos;
       at = sheet.find_first_not_of(kStyleBlank, at)) {
    const bool isDirective = sheet[at] == '@';
    const std::size_t open = findOutside(sheet, at, isDirective ? "{;" : "{");
    const std::string name(
        sheet.substr(at, std::min(sheet.find_first_of(" \t\r\n\f{;(\"'", at), open) - at));
    // Fonts and encodings do not concern lines.
    if (isDirective && name != "@charset" && name != "@namespace" && name != "@font-face") {
      ++ignored_[fmt::format("style rule {}, which is not applied", shown(name, 24))];
    }
    if (open == sheet.npos) return;
    const bool hasBlock = sheet[open] == '{';
    const std::size_t close = hasBlock ? findOutside(sheet, open + 1, "}") : open;
    if (!isDirective) {
      blocks_.push_back(
          declarations(sheet.substr(open + 1, std::min(close, sheet.size()) - open - 1)));
      const std::string_view selectors = sheet.substr(at, open - at);
      for (std::size_t begin = 0; begin <= selectors.size();) {
        const std::size_t end = std::min(findOutside(selectors, begin, ","), selectors.size());
        addRule(trimmed(selectors.substr(begin, end - begin)));
        begin = end + 1;
      }
    }
    if (close == sheet.npos) return;
    at = close + 1;
  }
}

void StyleSheet::addRule(std::string_view selector) {
  StyleRule rule;
  if (!parse(selector, rule)) {
    ++ignored_[fmt::format("style rule for '{}', which is not applied", shown(selector, 24))];
    return;
  }
  rule.block = blocks_.size() - 1;
  const StyleCompound& own = rule.path.back();
  rulesOf_[!own.id.empty()        ? "#" + own.id
           : !own.classes.empty() ? "." + own.classes.front()
                                  : own.tag]
      .push_back(rules_.size());
  rules_.push_back(std::move(rule));
}

bool StyleSheet::parse(std::string_view selector, StyleRule& rule) {
  constexpr int kOfId = 1'000'000, kOfClass = 1'000;
  const auto isNamed = [](char letter) {
    return std::isalnum(static_cast<unsigned char>(letter)) || letter == '-' || letter == '_' ||
           (static_cast<unsigned char>(letter) & 0x80U);
  };
  bool isChild = false, isNew = true;
  for (std::size_t at = 0; at < selector.size();) {
    const char kind = selector[at];
    if (kStyleBlank.find(kind) != kStyleBlank.npos || kind == '>') {
      isChild |= kind == '>';
      isNew = true;
      ++at;
      continue;
    }
    if (isNew) rule.path.emplace_back().isChild = isChild;
    const bool isFirst = std::exchange(isNew, false);
    isChild = false;
    const std::size_t begin = at + (kind == '.' || kind == '#' || kind == '*' ? 1 : 0);
    for (at = begin; kind != '*' && at < selector.size() && isNamed(selector[at]);) ++at;
    const std::string name(selector.substr(begin, at - begin));
    StyleCompound& compound = rule.path.back();
    if (name.empty() != (kind == '*')) return false;
    if (kind == '.') {
      compound.classes.push_back(name);
      rule.specificity += kOfClass;
    } else if (kind == '#') {
      compound.id = name;
      rule.specificity += kOfId;
    } else if (!isFirst) {
      return false;
    } else if (kind != '*') {
      compound.tag = lowerCase(name);
      ++rule.specificity;
    }
  }
  return !rule.path.empty() && !isNew;
}

bool StyleSheet::StyleCompound::fits(const StyledElement& element) const {
  if (!id.empty() && id != element.id) return false;
  if (!tag.empty() && tag != element.tag) return false;
  const std::vector<std::string>& own = element.classes;
  return std::ranges::all_of(
      classes, [&](const std::string& one) { return std::ranges::find(own, one) != own.end(); });
}

bool StyleSheet::StyleRule::fits(const std::vector<StyledElement>& elements) const {
  if (!path.back().fits(elements.front())) return false;
  if (path.size() == 1) return true;
  // Which beginnings of the path fit at the parent, and at any ancestor.
  std::vector<bool> atParent(path.size()), above(path.size());
  for (auto one = elements.rbegin(); one != elements.rend(); ++one) {
    std::vector<bool> here(path.size());
    for (std::size_t k = 0; k < path.size(); ++k) {
      here[k] =
          (k == 0 || (path[k].isChild ? atParent[k - 1] : above[k - 1])) && path[k].fits(*one);
    }
    for (std::size_t k = 0; k < path.size(); ++k) above[k] = above[k] || here[k];
    atParent = std::move(here);
  }
  return atParent.back();
}

StyleValues StyleSheet::valuesOf(const std::vector<StyledElement>& path) const {
  if (rules_.empty()) return {};
  const StyledElement& own = path.front();
  std::vector<std::string> keys = {"", own.tag, "#" + own.id};
  for (const std::string& one : own.classes) keys.push_back("." + one);
  std::vector<std::pair<int, std::size_t>> fitting;
  for (const std::string& key : keys) {
    const auto found = rulesOf_.find(key);
    if (found == rulesOf_.end()) continue;
    for (const std::size_t k : found->second) {
      if (rules_[k].fits(path)) fitting.emplace_back(rules_[k].specificity, k);
    }
  }
  std::ranges::sort(fitting);
  StyleValues values;
  for (const auto& [specificity, k] : fitting) overrideWith(values, blocks_[rules_[k].block]);
  return values;
}

}  // namespace kirireel::formats
