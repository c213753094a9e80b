// Model in Python is a LoadedModel, with the options that it was read with, so that deploy() knows
// what `kirireel record` would. Tiles, targets and joints are copied into arrays when they are
// asked for; a model does not change.
#include "render/python/model.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "render/cli/command_line.h"
#include "render/manual/python_text.h"
#include "render/python/interruption.h"
#include "render/python/options.h"
#include "sim/model/read_model.h"

namespace py = pybind11;
using namespace py::literals;

namespace kirireel::python {
namespace {

/// points x 3, C order.
py::array_t<double> pointArray(const std::vector<Vector3>& points) {
  py::array_t<double> array({points.size(), std::size_t{3}});
  auto entries = array.mutable_unchecked<2>();
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int k = 0; k < 3; ++k) entries(static_cast<py::ssize_t>(i), k) = points[i][k];
  }
  return array;
}

/// One array a tile, since tiles have different numbers of corners.
py::list tileList(const std::vector<Tile>& tiles) {
  py::list list;
  for (const Tile& tile : tiles) list.append(pointArray(tile.vertices));
  return list;
}

/// The columns of constraints.txt, counted from 0.
py::array_t<int> jointArray(const Model& model) {
  py::array_t<int> array({model.joints.size(), std::size_t{5}});
  auto entries = array.mutable_unchecked<2>();
  py::ssize_t row = 0;
  for (const Joint& joint : model.joints) {
    const int columns[] = {joint.a.tile, joint.a.vertex, joint.b.tile, joint.b.vertex,
                           static_cast<int>(joint.face)};
    for (int k = 0; k < 5; ++k) entries(row, k) = columns[k];
    ++row;
  }
  return array;
}

/// Options are `record`'s own, joints_file and strict. Warnings are told once the interpreter is
/// held again.
LoadedModel read(const std::filesystem::path& path, const py::kwargs& options) {
  const std::vector<std::string> words = optionWords(options, {});
  LoadedModel loaded = withoutInterpreter([&] { return loadModel(path, words); });
  warn(loaded.warnings);
  return loaded;
}

/// The words of `kirireel generate FAMILY FOLDER`; the folder is not used, but the command line
/// asks for one.
LoadedModel generate(std::string family, const py::kwargs& parameters) {
  std::replace(family.begin(), family.end(), '_', '-');
  std::vector<std::string> words = {"generate", family, "nowhere"};
  for (const std::string& word : optionWords(parameters, {"help"})) words.push_back(word);
  LoadedModel loaded;
  const auto order = std::get<GenerateOrder>(parseCommandLine(words));
  loaded.model = withoutInterpreter([&] { return makeModel(order); });
  return loaded;
}

/// What the interpreter shows of a model.
std::string describe(const LoadedModel& loaded) {
  return fmt::format("<kirireel.Model {}: {} tiles, {} joints{}>", loaded.model.name,
                     loaded.model.tiles.size(), loaded.model.joints.size(),
                     loaded.model.target ? ", a target" : "");
}

}  // namespace

void addModels(py::module_& module) {
  py::class_<LoadedModel>(module, "Model", "A sheet of rigid tiles joined at their corners.")
      .def_property_readonly("name", [](const LoadedModel& loaded) { return loaded.model.name; })
      .def_property_readonly(
          "tiles", [](const LoadedModel& loaded) { return tileList(loaded.model.tiles); },
          "The start: of each tile an array corners x 3, metres, anticlockwise.")
      .def_property_readonly(
          "target",
          [](const LoadedModel& loaded) -> py::object {
            if (!loaded.model.target) return py::none();
            return tileList(*loaded.model.target);
          },
          "Where the corners should go, as tiles; None where the model has no target.")
      .def_property_readonly(
          "joints", [](const LoadedModel& loaded) { return jointArray(loaded.model); },
          "joints x 5: tile, vertex, tile, vertex, from 0; face 1 bottom, 2 top, 3 both.")
      .def(
          "write",
          [](const LoadedModel& loaded, const std::filesystem::path& path) {
            withoutInterpreter([&] { writeModel(loaded.model, path); });
          },
          "path"_a, "Writes the model, in the format of the path's ending: none for a folder.")
      .def("__repr__", &describe);
  module.def("read", &read, "path"_a,
             "Reads a model: a folder, a .fold file, or whatever `kirireel record` takes.\n\n"
             "joints_file and strict are its options. What was mended is told as a UserWarning.");
  module.def("generate", &generate, "family"_a, generateDoc(describeProgram()).c_str());
}

}  // namespace kirireel::python
