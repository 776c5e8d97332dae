// A road is refined from scans: what `lidar2mesh map` does.
#include "cloud/refine.h"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "command/version.h"
#include "reports.h"

namespace py = pybind11;

namespace kerbstone {
namespace {

using cloud::RefineRequest;

/// What Python holds of a refinement.
struct Refined {
  cloud::Refined files;
  py::object summary, report;
};

/// An option of `lidar2mesh map` by its name in Python: how it is set, and what summary.json says
/// of it, as the command says it.
struct Option {
  std::string name;
  std::function<void(RefineRequest&, const py::object&)> set;
  std::function<std::string(const RefineRequest&)> told;
};

std::string told(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}
std::string told(int value) { return std::to_string(value); }
std::string told(bool value) { return value ? "true" : "false"; }
std::string told(const std::string& value) { return value; }
std::string told(const std::optional<double>& value) { return value ? told(*value) : ""; }
std::string told(const std::vector<double>& values) {
  std::string out;
  for (const double value : values) out += (out.empty() ? "[" : ",") + told(value);
  return out.empty() ? "" : out + "]";
}

template <class Value>
Option option(const char* name, Value RefineRequest::*member) {
  return {name,
          [member](RefineRequest& request, const py::object& value) {
            request.*member = value.cast<Value>();
          },
          [member](const RefineRequest& request) { return told(request.*member); }};
}

std::string told(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "[" : ",") + word;
  return out.empty() ? "" : out + "]";
}

/// One word, or several.
Option format_option() {
  return {"format",
          [](RefineRequest& request, const py::object& value) {
            if (py::isinstance<py::str>(value))
              request.format = {value.cast<std::string>()};
            else
              request.format = value.cast<std::vector<std::string>>();
          },
          [](const RefineRequest& request) { return told(request.format); }};
}

/// Arguments as they were called before; whether this was one.
bool set_old(const std::string& name, const py::object& value, RefineRequest& request) {
  if (name != "stl" && name != "pcd") return false;
  if (!py::bool_(value)) return true;
  if (name == "stl")
    std::replace(request.format.begin(), request.format.end(), std::string("ply"), name);
  else
    request.format.push_back(name);
  return true;
}

/// In the order of the command line.
const std::vector<Option>& options() {
  static const std::vector<Option> all = {option("frame", &RefineRequest::frame),
                                          option("extrinsic", &RefineRequest::extrinsic),
                                          option("max_range_m", &RefineRequest::max_range_m),
                                          option("drift_m", &RefineRequest::drift_m),
                                          option("drift_rad", &RefineRequest::drift_rad),
                                          option("outliers", &RefineRequest::outliers),
                                          option("voxel_m", &RefineRequest::voxel_m),
                                          option("v_max_m", &RefineRequest::v_max_m),
                                          option("step_m", &RefineRequest::node_m),
                                          option("min_points", &RefineRequest::min_points),
                                          option("unit", &RefineRequest::base_unit),
                                          option("up", &RefineRequest::base_up),
                                          option("mirror", &RefineRequest::base_mirror),
                                          option("allow_outside", &RefineRequest::allow_outside),
                                          option("cloud_unit", &RefineRequest::unit),
                                          option("base_stddev_m", &RefineRequest::base_stddev_m),
                                          option("gate_m", &RefineRequest::gate_m),
                                          option("edge_m", &RefineRequest::edge_m),
                                          option("no_grass", &RefineRequest::no_grass),
                                          option("campaigns", &RefineRequest::campaigns),
                                          format_option(),
                                          option("doubles", &RefineRequest::doubles)};
  return all;
}

void set_options(const py::kwargs& given, RefineRequest& request) {
  for (const auto& [key, value] : given) {
    auto name = key.cast<std::string>();
    if (name == "node_m") name = "step_m";  // as it was called before
    if (set_old(name, py::reinterpret_borrow<py::object>(value), request)) continue;
    const auto known = std::find_if(options().begin(), options().end(),
                                    [&](const Option& o) { return o.name == name; });
    if (known == options().end()) throw py::type_error("refine() has no argument '" + name + "'");
    if (value.is_none()) continue;
    if ((name == "v_max_m" || name == "step_m") && !request.base.empty())
      throw py::value_error(name + ": is for a road without a base");
    try {
      known->set(request, py::reinterpret_borrow<py::object>(value));
    } catch (const py::cast_error&) {
      throw py::type_error("refine(): " + name + ": " + py::repr(value).cast<std::string>() +
                           " seen, another type wanted; help(kerbstone.refine) lists them");
    }
  }
  for (const Option& o : options()) {
    std::string dashed = o.name;
    std::replace(dashed.begin(), dashed.end(), '_', '-');
    request.options.emplace_back(dashed, o.told(request));
  }
  request.options.emplace_back("no-report", told(!request.report));
}

py::object refine(const py::object& scans, const Path& output,
                  const std::optional<Path>& trajectory, const std::optional<Path>& base,
                  const std::optional<Path>& centreline, bool report, unsigned threads,
                  const py::object& progress, const py::kwargs& given) {
  RefineRequest request;
  request.scans = paths_of(scans);
  request.output_dir = output.string();
  request.trajectory = path_or_empty(trajectory);
  request.base = path_or_empty(base);
  request.centreline = path_or_empty(centreline);
  request.report = report;
  request.threads = threads;
  request.program = std::string("lidar2mesh ") + command::version();
  set_options(given, request);
  Refined out;
  {
    const base::Progress shown = progress_of(progress);
    const py::gil_scoped_release free;
    out.files = cloud::refine(request, shown);
  }
  out.summary = values_of(out.files.summary_json);
  out.report = values_in(out.files.json_path);
  const std::string why = cloud::why_not_usable(out.files);
  py::object refined = py::cast(std::move(out));
  if (!why.empty()) raise_not_usable(why, refined);
  return refined;
}

std::string shown_refined(const Refined& refined) {
  std::ostringstream out;
  out.precision(3);
  out << "Refined(" << 100.0 * refined.files.facts.coverage << " % of the nodes from points, "
      << refined.files.crg_path << ")";
  return out.str();
}

}  // namespace

void add_refine(py::module_& m) {
  using namespace pybind11::literals;
  py::class_<Refined>(m, "Refined", "A road that was refined from scans.")
      .def_property_readonly(
          "crg_path", [](const Refined& r) { return path_or_none(r.files.crg_path); }, "the road")
      .def_property_readonly("summary_path",
                             [](const Refined& r) { return path_or_none(r.files.summary_path); })
      .def_property_readonly(
          "page_path", [](const Refined& r) { return path_or_none(r.files.page_path); },
          "report.html, or None")
      .def_property_readonly(
          "faults", [](const Refined& r) { return r.files.facts.faults; },
          "why the road must not be used, a sentence each")
      .def_property_readonly(
          "remarks", [](const Refined& r) { return r.files.facts.remarks; }, "a sentence each")
      .def_property_readonly(
          "converged", [](const Refined& r) { return r.files.facts.converged; },
          "the estimate of the trajectory's drift")
      .def_property_readonly(
          "coverage", [](const Refined& r) { return r.files.facts.coverage; },
          "share of the nodes whose height comes from points, 0 to 1")
      .def_readonly("summary", &Refined::summary,
                    "summary.json: its keys as attributes (docs/formats.md)")
      .def_readonly("report", &Refined::report,
                    "report.json: its keys as attributes; None without a report")
      .def("__repr__", &shown_refined)
      .def("_repr_html_",
           [](const Refined& r) { return shown_in_notebook(r.files.page_path, shown_refined(r)); });

  m.def("refine", &refine,
        "Refines a road from LiDAR into the folder `output`, as `lidar2mesh map` does: the same "
        "files. scans: clouds or\n"
        "folders of them; trajectory: poses of the sensor; base: a .crg or a mesh, without one a "
        "road is made along\n"
        "centreline or trajectory.\n"
        "Further arguments, as the options of the command (docs/lidar2mesh.md): frame ('sensor', "
        "'map'), extrinsic (x, y, z\n"
        "in m, roll, pitch, yaw in deg), max_range_m, drift_m (m per 100 m), drift_rad (rad per "
        "100 m), outliers (neighbours,\n"
        "deviations), voxel_m, v_max_m, step_m, min_points, unit, up and mirror (of a base "
        "mesh), allow_outside, cloud_unit,\n"
        "base_stddev_m, gate_m, edge_m, no_grass, campaigns, format ('ply', 'stl' or 'pcd', or "
        "several of them), doubles.\n"
        "report: report.html and report.json too. threads: 0 all; never changes the result. "
        "progress(stage, share) as for\n"
        "build(). Raises Error; NotUsable where the road must not be used.",
        "scans"_a, "output"_a, py::kw_only(), "trajectory"_a = py::none(), "base"_a = py::none(),
        "centreline"_a = py::none(), "report"_a = true, "threads"_a = 0U,
        "progress"_a = py::none());
}

}  // namespace kerbstone
