#include "reports.h"

#include <pybind11/eval.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "base/error.h"
#include "base/read_file.h"
#include "crg/error.h"
#include "make/make_reported.h"
#include "make/question.h"

namespace py = pybind11;

namespace kerbstone {
namespace {

/// The exceptions of the module, alive as long as the interpreter.
struct Errors {
  py::object error, not_usable, question;
};
Errors& errors() {
  static Errors* const all = new Errors;
  return *all;
}

/// Bytes that are no UTF-8, as names of files may hold, become U+FFFD.
py::str text_of(const std::string& text) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "replace"));
}

[[noreturn]] void raise(const py::object& type, const py::object& exception) {
  PyErr_SetObject(type.ptr(), exception.ptr());
  throw py::error_already_set();
}

py::object exception_type(py::module_& m, const char* name, const py::object& base,
                          const char* doc) {
  py::object type = py::reinterpret_steal<py::object>(PyErr_NewExceptionWithDoc(
      (std::string("kerbstone.") + name).c_str(), doc, base.ptr(), nullptr));
  m.attr(name) = type;
  return type;
}

[[noreturn]] void raise_question(const std::string& what,
                                 const std::vector<road::Candidate>& candidates) {
  const py::object space = py::module_::import("types").attr("SimpleNamespace");
  py::list answers;
  for (const road::Candidate& road : candidates)
    answers.append(space(py::arg("closed") = road.closed, py::arg("length_m") = road.length_m,
                         py::arg("width_m") = road.width_m, py::arg("flags") = road.flags));
  const py::object exception = errors().question(text_of(what));
  exception.attr("result") = py::none();
  exception.attr("answers") = answers;
  raise(errors().question, exception);
}

std::string escaped(const std::string& html) {
  std::string out;
  out.reserve(html.size() + html.size() / 8);
  for (const char c : html) {
    if (c == '&')
      out += "&amp;";
    else if (c == '"')
      out += "&quot;";
    else if (c == '<')
      out += "&lt;";
    else
      out += c;
  }
  return out;
}

}  // namespace

py::object values_of(const std::string& json) {
  const py::dict names(py::arg("Values") = py::module_::import("types").attr("SimpleNamespace"));
  return py::module_::import("json").attr("loads")(
      py::bytes(json), py::arg("object_hook") = py::eval("lambda values: Values(**values)", names));
}

py::object values_in(const std::string& json_path) {
  if (json_path.empty()) return py::none();
  return values_of(base::read_file(json_path));
}

std::string shown_in_notebook(const std::string& page_path, const std::string& otherwise) {
  std::error_code none;
  if (page_path.empty() || !std::filesystem::is_regular_file(page_path, none))
    return "<pre>" + escaped(otherwise) + "</pre>";
  // Without the right to look at the notebook around it.
  return "<iframe sandbox=\"allow-scripts\" style=\"width:100%;height:45em;border:0\" srcdoc=\"" +
         escaped(base::read_file(page_path)) + "\"></iframe>";
}

py::object path_or_none(const std::string& path) {
  if (path.empty()) return py::none();
  return py::reinterpret_steal<py::object>(
      PyUnicode_DecodeFSDefaultAndSize(path.data(), static_cast<py::ssize_t>(path.size())));
}

std::vector<std::string> paths_of(const py::object& one_or_many) {
  const bool one = py::isinstance<py::str>(one_or_many) || py::isinstance<py::bytes>(one_or_many) ||
                   py::hasattr(one_or_many, "__fspath__");
  if (one) return {one_or_many.cast<Path>().string()};
  std::vector<std::string> out;
  for (const py::handle& each : one_or_many) out.push_back(each.cast<Path>().string());
  return out;
}

base::Progress progress_of(const py::object& callback) {
  using Clock = std::chrono::steady_clock;
  struct Shown {
    std::string stage;
    Clock::time_point at;
  };
  return [callback = &callback, caller = std::this_thread::get_id(),
          shown = std::make_shared<Shown>()](const std::string& stage, double share) {
    if (std::this_thread::get_id() != caller) return;
    const Clock::time_point now = Clock::now();
    if (stage == shown->stage && now - shown->at < std::chrono::milliseconds(50)) return;
    *shown = {stage, now};
    const py::gil_scoped_acquire held;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!callback->is_none()) (*callback)(stage, share);
  };
}

void add_errors(py::module_& m) {
  errors().error = py::register_exception<crg::Error>(m, "Error", PyExc_RuntimeError);
  errors().not_usable = exception_type(
      m, "NotUsable", errors().error,
      "The road must not be used; what the commands end with exit code 3 for. `result`: what was "
      "made and written\nall the same, or None.");
  errors().question = exception_type(
      m, "Question", errors().not_usable,
      "It cannot be told which road of a mesh is meant. `answers`: roads that could be, each with "
      "closed, length_m,\nwidth_m and the flags of crgbuild that choose it.");
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const base::Error& e) {
      PyErr_SetObject(errors().error.ptr(), text_of(e.what()).ptr());
    }
  });
}

void raise_not_usable(const std::string& why, const py::object& result) {
  const py::object exception = errors().not_usable(text_of(why));
  exception.attr("result") = result;
  raise(errors().not_usable, exception);
}

void raise_naming(const std::string& input) {
  try {
    throw;
  } catch (const road::Question& question) {
    raise_question(road::with_input_named(input, question.what()), question.candidates());
  } catch (const road::NotUsable& error) {
    raise_not_usable(road::with_input_named(input, error.what()), py::none());
  } catch (const base::Error& error) {
    throw base::Error(road::with_input_named(input, error.what()));
  }
}

}  // namespace kerbstone
