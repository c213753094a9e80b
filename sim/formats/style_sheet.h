/// Style sheets of SVG files.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace kirireel::formats {

/// Value of a property.
struct StyleValue {
  std::string text;          ///< without "!important"
  bool isImportant = false;  ///< overrides values that are not
};

/// Values by property, in lower case.
using StyleValues = std::map<std::string, StyleValue>;

/// Declarations "name: value; ...".
StyleValues declarations(std::string_view text);

/// Assigns values with precedence over those in `values`, except over important ones.
void overrideWith(StyleValues& values, const StyleValues& with);

/// Properties of an element that selectors test.
struct StyledElement {
  std::string tag;                   ///< local name, lower case
  std::string id;                    ///< empty: none
  std::vector<std::string> classes;  ///< in the file's order
};

/// The classes in a class attribute.
std::vector<std::string> classesOf(std::string_view attribute);

/// The name of an element or attribute without its namespace, in lower case.
std::string localName(const char* name);

/// The text without blanks at both ends.
std::string_view trimmed(std::string_view text);

/// Rules whose selectors consist of tags, classes, ids, '*', descendants and children.
class StyleSheet {
 public:
  /// Adds the text of a style element.
  void add(std::string text);
  /// The values for an element: the first of `path`, followed by its ancestors.
  StyleValues valuesOf(const std::vector<StyledElement>& path) const;
  /// Rules that are not applied, with counts.
  const std::map<std::string, int>& ignored() const { return ignored_; }

 private:
  /// Conditions on one element.
  struct StyleCompound {
    std::string tag, id;  // empty: any
    std::vector<std::string> classes;
    bool isChild = false;  // of the element before, otherwise a descendant

    bool fits(const StyledElement& element) const;
  };
  struct StyleRule {
    std::vector<StyleCompound> path;  // the last is the element itself
    int specificity = 0;
    std::size_t block = 0;  // index into blocks_

    bool fits(const std::vector<StyledElement>& elements) const;
  };

  /// False for a selector of another kind.
  static bool parse(std::string_view selector, StyleRule& rule);
  void addRule(std::string_view selector);

  std::vector<StyleValues> blocks_;
  std::vector<StyleRule> rules_;  // in the order of the file
  // Rules by the id, the first class or the tag of their element.
  std::unordered_map<std::string, std::vector<std::size_t>> rulesOf_;
  std::map<std::string, int> ignored_;
};

}  // namespace kirireel::formats
