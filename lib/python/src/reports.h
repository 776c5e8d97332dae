// What long work gives Python: values out of JSON, pages for notebooks, progress, refusals.
#pragma once

#include <pybind11/pybind11.h>

#include <exception>
#include <filesystem>
#include <optional>
#include <string>

#include "base/progress.h"

namespace kerbstone {

inline std::string path_or_empty(const std::optional<std::filesystem::path>& path) {
  return path ? path->string() : "";
}

using Path = std::filesystem::path;

/// Objects of JSON become types.SimpleNamespace, with its keys as attributes.
pybind11::object values_of(const std::string& json);

/// The whole of a file as such values; None for an empty path.
pybind11::object values_in(const std::string& json_path);

/// A page as HTML of a notebook's cell: the page itself in a frame, or `otherwise` as text where it
/// is not there any more.
std::string shown_in_notebook(const std::string& page_path, const std::string& otherwise);

/// A path, or None where it is empty.
pybind11::object path_or_none(const std::string& path);

/// A path, or several.
std::vector<std::string> paths_of(const pybind11::object& one_or_many);

/// Calls `callback(stage, share)` in the thread that called, at most 20 times a second and at every
/// new stage, and lets Ctrl-C end the work there. The callback may be None; it must outlive what is
/// returned.
base::Progress progress_of(const pybind11::object& callback);

/// Makes the exceptions Error, NotUsable, Question and what raises them.
void add_errors(pybind11::module_& m);

/// Raises kerbstone.NotUsable, whose `result` is what was made all the same.
[[noreturn]] void raise_not_usable(const std::string& why, const pybind11::object& result);

/// Raises the exception that is being handled, with the name of the input in front where it names
/// no file; a question with its answers. Not for what Python raised.
[[noreturn]] void raise_naming(const std::string& input);

void add_build(pybind11::module_& m);
void add_refine(pybind11::module_& m);
void add_explain(pybind11::module_& m);
void add_identify(pybind11::module_& m);

}  // namespace kerbstone
