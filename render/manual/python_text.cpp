// The Python module takes the program's options as keyword arguments, so their documentation is the
// program's own: docstrings list options by group with unit and help, and the stub (PEP 484, PEP
// 561) types them. A switch is bool, an option with a list of words is Literal[...], everything
// else is what Python's text of the value is to the program (_Value).
//
// The classes' own properties are written out in kStubHead and kStubRun and have to follow
// python/run.cpp and python/model.cpp; a test compares the two.
#include "render/manual/python_text.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace kirireel {
namespace {

/// Lists of names are short.
bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

/// By key, with underscores.
std::vector<OptionDescription> optionsWithout(const CommandDescription& command,
                                              const std::vector<std::string>& leftOut) {
  std::vector<OptionDescription> options = command.options;
  std::erase_if(options, [&](const OptionDescription& option) { return has(leftOut, option.key); });
  return options;
}

/// " thickness (METRES): of the bricks (default ...)".
std::string optionLine(const OptionDescription& option) {
  const std::string unit = option.isSwitch ? "True" : option.unit;
  return fmt::format("    {}{}: {}\n", option.key, unit.empty() ? "" : fmt::format(" ({})", unit),
                     option.help);
}

/// A heading where the group changes; options of a group follow each other.
std::string optionsDoc(const std::vector<OptionDescription>& options) {
  std::string text;
  std::string group;
  for (const OptionDescription& option : options) {
    if (option.group != group) text += fmt::format("\n{}:\n", option.group);
    group = option.group;
    text += optionLine(option);
  }
  return text;
}

/// An underscore for each hyphen, as names of Python have it. "spring-stiffness" is
/// spring_stiffness.
std::string pythonName(std::string name) {
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

/// The stub's own alias _Value stands for what options without a list of words accept.
std::string typeOf(const OptionDescription& option) {
  if (option.isSwitch) return "bool";
  if (option.words.empty()) return "_Value";
  return fmt::format("Literal[\"{}\"]", fmt::join(option.words, "\", \""));
}

/// Every option may be left out, and None means the same.
std::string parameters(const std::vector<OptionDescription>& options) {
  std::string text;
  for (const OptionDescription& option : options) {
    text += fmt::format("    {}: Optional[{}] = ...,\n", option.key, typeOf(option));
  }
  return text;
}

/// One overload a family, because each has its own parameters. Names with hyphens are accepted with
/// underscores, too.
std::string familyStub(const CommandDescription& family) {
  return fmt::format(
      "@overload\ndef generate(\n    family: Literal[{}],\n    *,\n{}) -> Model: ...\n",
      family.name == pythonName(family.name)
          ? fmt::format("\"{}\"", family.name)
          : fmt::format("\"{}\", \"{}\"", family.name, pythonName(family.name)),
      parameters(optionsWithout(family, {"help"})));
}

constexpr const char* kStubHead = R"(# Made from the program's own options.
from os import PathLike
from typing import Any, Callable, Dict, List, Literal, Optional, Sequence, Tuple, Union, overload

import numpy as np
from numpy.typing import NDArray

__version__: str
_Path = Union[str, "PathLike[str]"]
_Value = Union[str, float, "PathLike[str]", Sequence[float], Sequence[str], Sequence[Sequence[float]]]

class Error(Exception): ...
class InputError(Error, ValueError): ...
class OutputError(Error, OSError): ...
class RunError(Error, RuntimeError): ...

class Model:
    @property
    def name(self) -> str: ...
    @property
    def tiles(self) -> List[NDArray[np.float64]]: ...
    @property
    def target(self) -> Optional[List[NDArray[np.float64]]]: ...
    @property
    def joints(self) -> NDArray[np.int32]: ...
    def write(self, path: _Path) -> None: ...

class Sample:
    @property
    def time(self) -> float: ...
    @property
    def joint_gap(self) -> float: ...
    @property
    def target_error(self) -> float: ...
    @property
    def penetration(self) -> float: ...
    @property
    def position(self) -> NDArray[np.float64]: ...
    @property
    def rotation(self) -> NDArray[np.float64]: ...

class Trajectory:
    @property
    def model(self) -> Model: ...
    @property
    def time(self) -> NDArray[np.float64]: ...
    @property
    def position(self) -> NDArray[np.float64]: ...
    @property
    def rotation(self) -> NDArray[np.float64]: ...
    @property
    def velocity(self) -> NDArray[np.float64]: ...
    @property
    def angular_velocity(self) -> NDArray[np.float64]: ...
    @property
    def joint_gap(self) -> NDArray[np.float64]: ...
    @property
    def target_error(self) -> NDArray[np.float64]: ...
    @property
    def penetration(self) -> NDArray[np.float64]: ...
    @property
    def events(self) -> List[Tuple[float, str]]: ...
)";

constexpr const char* kStubRun = R"(
class Run(Trajectory):
    @property
    def outcome(self) -> str: ...
    @property
    def reason(self) -> str: ...
    @property
    def at_target(self) -> Optional[bool]: ...
    @property
    def summary(self) -> Dict[str, Any]: ...
    def save(self, folder: _Path) -> List[str]: ...

def read(path: _Path, *, joints_file: Optional[_Path] = ..., strict: bool = ...) -> Model: ...
def open(path: _Path) -> Trajectory: ...
)";

}  // namespace

const std::vector<std::string>& optionsNotForRuns() {
  static const std::vector<std::string> names = {"help",   "out",         "json",
                                                 "resume", "joints_file", "strict", "page"};
  return names;
}

std::vector<std::string> optionsNotForPictures(const CommandDescription& program) {
  static const std::vector<std::string> groups = {"Style", "Look", "Camera"};
  static const std::vector<std::string> keys = {"size", "gl"};
  std::vector<std::string> names;
  for (const OptionDescription& option : commandNamed(program, "render").options) {
    if (!has(groups, option.group) && !has(keys, option.key)) names.push_back(option.key);
  }
  return names;
}

std::string deployDoc(const CommandDescription& program) {
  return "Deploys a model as `kirireel record` would, in memory. Returns a Run.\n\n"
         "on_sample is called with each Sample; where it returns False the run ends. Ctrl-C "
         "raises\n"
         "KeyboardInterrupt. A scene.toml in the model's folder holds, as for the program. "
         "Lengths\n"
         "are metres, times simulated seconds, masses kilograms.\n" +
         optionsDoc(optionsWithout(commandNamed(program, "record"), optionsNotForRuns()));
}

std::string generateDoc(const CommandDescription& program) {
  std::string text =
      "Makes a model of a family, as `kirireel generate` does. Returns a Model.\n\n"
      "Parameters by family; lengths in metres, angles in degrees.\n";
  for (const CommandDescription& family : commandNamed(program, "generate").commands) {
    text += fmt::format("\n{}: {}\n", pythonName(family.name), family.help);
    for (const OptionDescription& option : optionsWithout(family, {"help"})) {
      text += optionLine(option);
    }
  }
  return text;
}

std::string renderDoc(const CommandDescription& program) {
  return "Paints the sample nearest to a time (simulated seconds; None: the last one). Returns an\n"
         "array height x width x 4 of bytes, RGBA, rows from the top.\n" +
         optionsDoc(
             optionsWithout(commandNamed(program, "render"), optionsNotForPictures(program)));
}

std::string pythonStub(const CommandDescription& program) {
  std::string text = kStubHead;
  text += fmt::format(
      "    def render(\n    self,\n    time: Optional[float] = ...,\n    *,\n{}    ) -> "
      "NDArray[np.uint8]: ...\n{}",
      parameters(optionsWithout(commandNamed(program, "render"), optionsNotForPictures(program))),
      kStubRun);
  for (const CommandDescription& family : commandNamed(program, "generate").commands) {
    text += familyStub(family);
  }
  return text +
         fmt::format(
             "def deploy(\n    model: Model,\n    *,\n    on_sample: "
             "Optional[Callable[[Sample], Optional[bool]]] = ...,\n{}) -> Run: ...\n",
             parameters(optionsWithout(commandNamed(program, "record"), optionsNotForRuns())));
}

}  // namespace kirireel
