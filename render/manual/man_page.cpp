// Writes man(7): a line that begins with a point is a request to troff, a backslash begins an
// escape, and a plain hyphen may become a dash on paper. Everything else is text.
//
// A page has the sections NAME, SYNOPSIS, ARGUMENTS, COMMANDS, OPTIONS (with a subsection for each
// group of the help), NOTES or EXAMPLES from the footer, and SEE ALSO (man-pages(7)). Requests in
// use:
//
//     .TH TITLE SECTION DATE SOURCE MANUAL    .SH heading    .SS heading within    .TP tagged entry
//     .nf / .fi  lines as they are / filled   .sp  an empty line    \fB bold  \fI italic  \fR roman
//
// No date stands on a page, so that the same source gives the same bytes on any day.
#include "render/manual/man_page.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <utility>

#include <fmt/format.h>

namespace kirireel {
namespace {

/// "\-" is a minus that can be copied from a terminal; "\e" prints a backslash.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char letter : text) {
    if (letter == '\\') {
      result += "\\e";
    } else if (letter == '-') {
      result += "\\-";
    } else {
      result += letter;
    }
  }
  // A zero-width space keeps a line from being a request.
  const bool isRequest = result.starts_with('.') || result.starts_with('\'');
  return isRequest ? "\\&" + result : result;
}

/// ASCII letters alone: names of commands have no others.
std::string upperCase(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

/// "kirireel-record".
std::string pageName(const CommandDescription& program, const CommandDescription& command) {
  return fmt::format("{}-{}", program.name, command.name);
}

/// The NAME line is what whatis(1) and apropos(1) index.
std::string header(const std::string& page, const std::string& purpose,
                   const std::string& version) {
  return fmt::format(".TH {} 1 \"\" \"kirireel {}\" \"Kirireel\"\n.SH NAME\n{} \\- {}\n",
                     escaped(upperCase(page)), escaped(version), escaped(page), escaped(purpose));
}

/// .TP takes the next line as a tag and the one after it as the text.
std::string optionText(const OptionDescription& option) {
  std::string names;
  for (const std::string& name : option.names) {
    if (!names.empty()) names += ", ";
    names += fmt::format("\\fB{}\\fR", escaped(name));
  }
  if (!option.unit.empty()) names += fmt::format(" \\fI{}\\fR", escaped(option.unit));
  return fmt::format(".TP\n{}\n{}\n", names, escaped(option.help));
}

/// The options under the headings of their groups, in the order of the help. `headingMacro` is
/// ".SH" or ".SS".
std::string optionsText(const CommandDescription& command, const char* headingMacro) {
  std::vector<std::string> groups;
  for (const OptionDescription& option : command.options) {
    if (std::ranges::find(groups, option.group) == groups.end()) groups.push_back(option.group);
  }
  std::string text;
  for (const std::string& group : groups) {
    text += fmt::format("{} \"{}\"\n", headingMacro, escaped(group));
    for (const OptionDescription& option : command.options) {
      if (option.group == group) text += optionText(option);
    }
  }
  return text;
}

/// Arguments without a name of an option, such as MODEL.
std::string placesText(const CommandDescription& command) {
  std::string text;
  for (const PlaceDescription& place : command.places) {
    text += fmt::format(".TP\n\\fI{}\\fR\n{}\n", escaped(place.name), escaped(place.help));
  }
  return text;
}

/// "kirireel record [OPTIONS] MODEL".
std::string synopsis(const std::string& name, const CommandDescription& command) {
  std::string text = fmt::format("\\fB{}\\fR", escaped(name));
  if (!command.commands.empty()) text += " \\fICOMMAND\\fR";
  text += " [\\fIOPTIONS\\fR]";
  for (const PlaceDescription& place : command.places) {
    text += fmt::format(" \\fI{}\\fR", escaped(place.name));
  }
  return text + "\n";
}

/// The commands below this one, with one phrase each.
std::string commandsText(const std::vector<CommandDescription>& commands) {
  std::string text;
  for (const CommandDescription& command : commands) {
    text += fmt::format(".TP\n\\fB{}\\fR\n{}\n", escaped(command.name), escaped(command.help));
  }
  return text;
}

/// Paragraphs that begin "Examples:" become sections of that name, others notes; lines stay. Lines
/// are kept (.nf), since examples are commands to be copied.
std::string footerText(const std::string& footer) {
  std::string text;
  // What to write before the next line of text: nothing, an empty line, or a heading.
  std::string gap;
  std::string heading = "NOTES";
  std::string written;
  std::istringstream lines(footer);
  for (std::string line; std::getline(lines, line);) {
    const bool isHeading = line.ends_with(':') && !line.starts_with(' ');
    if (isHeading) heading = upperCase(line.substr(0, line.size() - 1));
    if (line.empty()) heading = "NOTES";
    if (line.empty()) gap = ".sp\n";
    if (isHeading || line.empty()) continue;
    if (heading != written) {
      gap = fmt::format("{}.SH {}\n.nf\n", written.empty() ? "" : ".fi\n", heading);
    }
    text += std::exchange(gap, "");
    written = heading;
    text += escaped(line) + "\n";
  }
  return written.empty() ? text : text + ".fi\n";
}

/// Pages stand on lines of their own with commas between them.
std::string seeAlso(const std::vector<std::string>& pages) {
  std::string text = ".SH SEE ALSO\n";
  for (const std::string& page : pages) {
    text += fmt::format("{}\\fB{}\\fR(1)", &page == &pages.front() ? "" : ",\n", escaped(page));
  }
  return text + "\n";
}

/// A command below a command, as a section: its own options alone.
std::string sectionText(const CommandDescription& command) {
  return fmt::format(".SH {}\n{}\n{}{}", escaped(upperCase(command.name)), escaped(command.help),
                     placesText(command), optionsText(command, ".SS"));
}

/// Commands below it have no page of their own, since they are many and short.
std::string commandPage(const CommandDescription& program, const CommandDescription& command,
                        const std::string& version) {
  const std::string fullName = fmt::format("{} {}", program.name, command.name);
  std::string text = header(pageName(program, command), command.help, version);
  text += ".SH SYNOPSIS\n" + synopsis(fullName, command);
  if (!command.places.empty()) text += ".SH ARGUMENTS\n" + placesText(command);
  if (!command.commands.empty()) text += ".SH COMMANDS\n" + commandsText(command.commands);
  text += ".SH OPTIONS\n" + optionsText(command, ".SS");
  for (const CommandDescription& below : command.commands) text += sectionText(below);
  return text + footerText(command.footer) + seeAlso({program.name});
}

/// Commands are named with their purpose; each has a page of its own.
std::string programPage(const CommandDescription& program, const std::string& version) {
  std::vector<std::string> others;
  for (const CommandDescription& command : program.commands) {
    others.push_back(pageName(program, command));
  }
  std::string text = header(program.name, program.help, version);
  text += ".SH SYNOPSIS\n" + synopsis(program.name, program);
  text += ".SH COMMANDS\n" + commandsText(program.commands);
  text += ".SH OPTIONS\n" + optionsText(program, ".SS");
  return text + footerText(program.footer) + seeAlso(others);
}

}  // namespace

std::vector<NamedText> manPages(const CommandDescription& program, const std::string& version) {
  std::vector<NamedText> pages = {{program.name + ".1", programPage(program, version)}};
  for (const CommandDescription& command : program.commands) {
    pages.emplace_back(pageName(program, command) + ".1", commandPage(program, command, version));
  }
  return pages;
}

}  // namespace kirireel
