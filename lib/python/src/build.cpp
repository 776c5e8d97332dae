// A mesh or a recipe becomes a checked road: what `crgbuild build` does.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <string>

#include "base/error.h"
#include "inspect/findings.h"
#include "make/make_reported.h"
#include "reports.h"

namespace py = pybind11;

namespace kerbstone {
namespace {

/// What Python holds of a build.
struct Built {
  road::ReportedBuild build;
  py::object summary, report;
};

/// A value of a recipe key as track.yaml and the command line have it.
std::string text_of(const std::string& name, const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
  if (py::isinstance<py::str>(value) || py::hasattr(value, "__fspath__"))
    return value.cast<Path>().string();
  if (py::isinstance<py::sequence>(value) || py::hasattr(value, "tolist")) {
    const py::object list = py::hasattr(value, "tolist")
                                ? value.attr("tolist")()
                                : py::reinterpret_borrow<py::object>(value);
    if (!py::isinstance<py::sequence>(list)) return text_of(name, list);
    std::string out;
    for (const py::handle& each : list) out += (out.empty() ? "" : " ") + text_of(name, each);
    return out;
  }
  if (PyNumber_Check(value.ptr()) != 0) return py::str(value);
  throw py::type_error(name + ": a number, a word, True, False or a list of these is wanted");
}

road::RecipeValues values_from(const py::kwargs& keys) {
  road::RecipeValues out;
  for (const auto& [key, value] : keys) {
    const auto name = key.cast<std::string>();
    if (value.is_none()) continue;
    const std::string text = text_of(name, value);
    for (const road::RecipeKey& known : road::recipe_keys())
      if (known.name == name && road::is_switch(known) && text != "true")
        throw py::value_error(name +
                              ": only True can be said here; to have it False, leave it out here "
                              "and in the recipe");
    out.emplace_back(name, text);
  }
  return out;
}

py::object build(const Path& recipe, const Path& output, bool report, bool force,
                 const py::object& progress, const py::kwargs& keys) {
  const road::BuildRequest request{.input = recipe.string(),
                                   .output_dir = output.string(),
                                   .report = report,
                                   .force = force,
                                   .values = values_from(keys)};
  Built out;
  try {
    const base::Progress told = progress_of(progress);
    const py::gil_scoped_release free;
    out.build = road::make_reported(request, told);
  } catch (const base::Error&) {
    raise_naming(request.input);
  }
  out.summary = values_of(out.build.result.summary_json);
  out.report = values_in(out.build.report ? out.build.report->json_path : "");
  const std::string why = road::why_not_usable(out.build);
  py::object built = py::cast(std::move(out));
  if (!why.empty()) raise_not_usable(why, built);
  return built;
}

std::string verdict_of(const Built& built) {
  if (built.build.report) return road::to_string(built.build.report->verdict);
  return built.build.result.validation_failures.empty() ? "usable" : "not_usable";
}

std::string page_of(const Built& built) {
  return built.build.report ? built.build.report->page_path : "";
}

std::string shown_road(const Built& built) {
  return "Built(" + built.build.recipe.name + ", " + verdict_of(built) + ", " +
         built.build.result.crg_path + ")";
}

/// A path of the set that was written.
template <std::string road::BuildResult::*member>
py::object path(const Built& built) {
  return path_or_none(built.build.result.*member);
}

}  // namespace

void add_build(py::module_& m) {
  using namespace pybind11::literals;
  using road::BuildResult;
  py::class_<Built>(m, "Built", "A road that was built, and everything that was said about it.")
      .def_property_readonly("crg_path", &path<&BuildResult::crg_path>, "the road")
      .def_property_readonly("stl_path", &path<&BuildResult::stl_path>, "the surface that was kept")
      .def_property_readonly("centreline_path", &path<&BuildResult::centreline_path>)
      .def_property_readonly("summary_path", &path<&BuildResult::summary_path>)
      .def_property_readonly("picture_path", &path<&BuildResult::picture_path>,
                             "the road from above")
      .def_property_readonly("friction_path", &path<&BuildResult::friction_path>,
                             "grip over the same nodes, or None")
      .def_property_readonly("patches_path", &path<&BuildResult::patches_path>,
                             "index of finer roads over kerbs, or None")
      .def_property_readonly(
          "page_path", [](const Built& built) { return path_or_none(page_of(built)); },
          "report.html, or None")
      .def_property_readonly("verdict", &verdict_of,
                             "'usable', 'usable_with_remarks' or 'not_usable'")
      .def_property_readonly(
          "remarks", [](const Built& b) { return road::remarks_of(b.build.result.summary_json); },
          "a sentence each")
      .def_property_readonly(
          "reused", [](const Built& built) { return built.build.result.reused; },
          "nothing had changed since the files in the folder were built")
      .def_readonly("summary", &Built::summary,
                    "summary.json: its keys as attributes (docs/formats.md)")
      .def_readonly("report", &Built::report,
                    "report.json: its keys as attributes, `findings` among them; None without a "
                    "report")
      .def("__repr__", &shown_road)
      .def("_repr_html_",
           [](const Built& built) { return shown_in_notebook(page_of(built), shown_road(built)); });

  m.def("build", &build,
        "Builds the road of a mesh or a track.yaml into the folder `output`, as `crgbuild build` "
        "does: the same files.\n"
        "Further arguments are recipe keys (docs/formats.md), e.g. u_step_m=0.05, on top of the "
        "recipe; lengths in m.\n"
        "report: report.html and report.json too. force: build even when nothing has changed. "
        "progress(stage, share) is\n"
        "called now and then, share 0 to 1; what it raises ends the build, and so does Ctrl-C. "
        "Raises Error, Question\n"
        "where it cannot be told which road is meant, NotUsable where the road must not be used.",
        "recipe"_a, "output"_a, py::kw_only(), "report"_a = true, "force"_a = false,
        "progress"_a = py::none());
}

}  // namespace kerbstone
