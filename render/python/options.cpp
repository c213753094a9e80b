// Keyword arguments become the words of a command line and are parsed by the program's own parser.
// So every option of the program works in Python with the same checks and messages, and none has to
// be written twice; the price is that numbers pass through text, which is exact, for str() of a
// float reads back to the same double.
#include "render/python/options.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/base/error.h"

namespace py = pybind11;

namespace kirireel::python {
namespace {

/// NumPy arrays are no lists here; their text would be refused by the option.
bool isList(const py::handle& value) {
  return py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value);
}

/// As Python writes it, which for a float is the shortest text that reads back as the same.
std::string textOf(const py::handle& value) {
  return py::str(value);
}

bool holdsNumbers(const py::handle& list) {
  const auto entries = py::reinterpret_borrow<py::sequence>(list);
  return std::all_of(entries.begin(), entries.end(), [](const auto& entry) {
    return !isList(entry) && !py::isinstance<py::str>(entry);
  });
}

/// "3,0,7". No spaces, as the command line wants it.
std::string joinedText(const py::handle& list) {
  std::string text;
  for (const auto& entry : py::reinterpret_borrow<py::sequence>(list)) {
    if (!text.empty()) text += ',';
    text += textOf(entry);
  }
  return text;
}

/// Name and value are one word, joined by "=", so that a value may begin with a hyphen.
void appendWords(const std::string& name, const py::handle& value,
                 std::vector<std::string>& words) {
  if (value.is_none()) return;
  // True and False before numbers: in Python bool is a kind of int.
  if (py::isinstance<py::bool_>(value)) {
    if (value.cast<bool>()) words.push_back(name);
  } else if (!isList(value)) {
    words.push_back(fmt::format("{}={}", name, textOf(value)));
  } else if (holdsNumbers(value)) {
    words.push_back(fmt::format("{}={}", name, joinedText(value)));
  } else {
    for (const auto& entry : py::reinterpret_borrow<py::sequence>(value)) {
      appendWords(name, entry, words);
    }
  }
}

}  // namespace

std::vector<std::string> optionWords(const py::kwargs& options,
                                     const std::vector<std::string>& notHere) {
  std::vector<std::string> words;
  for (const auto& [key, value] : options) {
    std::string name = textOf(key);
    if (std::ranges::find(notHere, name) != notHere.end()) {
      throw InputError(fmt::format("error: {} is no option of this call; leave it away", name));
    }
    std::replace(name.begin(), name.end(), '_', '-');
    appendWords("--" + name, value, words);
  }
  return words;
}

void warn(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) {
    if (PyErr_WarnEx(PyExc_UserWarning, warning.c_str(), 1) != 0) throw py::error_already_set();
  }
}

}  // namespace kirireel::python
