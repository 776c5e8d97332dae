// Why recordings and a simulation differ: what `crgexplain run` does.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>
#include <string>
#include <vector>

#include "explain/explain_files.h"
#include "reports.h"

namespace py = pybind11;

namespace kerbstone {
namespace {

struct Explanation {
  explain::ExplainedFiles files;
  std::vector<std::string> remarks;
  py::object report;
};

Explanation explained(const py::object& recordings, const Path& car, const Path& road,
                      const Path& output, const std::optional<Path>& mapping,
                      const std::optional<Path>& friction, double fuel_kg,
                      const std::vector<int>& hold_out, unsigned threads, std::size_t nulls,
                      bool skip_simulation, const py::object& progress) {
  explain::ExplainRequest request;
  request.recording_paths = paths_of(recordings);
  request.vehicle_path = car.string();
  request.track_path = road.string();
  request.out_path = output.string();
  request.mapping_path = path_or_empty(mapping);
  request.friction_path = path_or_empty(friction);
  request.fuel_kg = fuel_kg;
  request.hold_out = hold_out;
  request.threads = threads;
  request.nulls = nulls;
  request.skip_simulation = skip_simulation;
  Explanation out;
  {
    const base::Progress told = progress_of(progress);
    const py::gil_scoped_release free;
    out.files = explain::explain_files(
        request, told, [&](const std::string& remark) { out.remarks.push_back(remark); });
  }
  for (const explain::Remark& remark : out.files.findings.remarks)
    out.remarks.push_back(remark.text);
  out.report = values_of(out.files.findings_json);
  return out;
}

std::string shown_explanation(const Explanation& e) {
  std::string out = std::string("Explanation(") + explain::name_of(e.files.findings.verdict);
  for (const explain::Finding& finding : e.files.findings.findings)
    out += "; " + finding.mechanism +
           (finding.channel.empty() ? "" : " (" + finding.channel + ")") +
           (finding.not_used.empty() ? "" : ", seen, not used");
  return out + ")";
}

}  // namespace

void add_explain(py::module_& m) {
  using namespace pybind11::literals;
  using explain::CorrectedFiles;
  py::class_<CorrectedFiles>(
      m, "Corrected",
      "What a simulation is to take from now on, by path: corrected where something was found, as "
      "given elsewhere.")
      .def_property_readonly("road_path",
                             [](const CorrectedFiles& c) { return path_or_none(c.track_path); })
      .def_property_readonly("friction_path",
                             [](const CorrectedFiles& c) { return path_or_none(c.friction_path); })
      .def_property_readonly("car_path",
                             [](const CorrectedFiles& c) { return path_or_none(c.vehicle_path); })
      .def_property_readonly("mapping_path",
                             [](const CorrectedFiles& c) { return path_or_none(c.mapping_path); })
      .def_readonly("fuel_kg", &CorrectedFiles::fuel_kg,
                    "at the begin of the logs, given or found; 0: neither");

  py::class_<Explanation>(m, "Explanation", "Why recordings and a simulation differ.")
      .def_property_readonly(
          "verdict",
          [](const Explanation& e) { return explain::name_of(e.files.findings.verdict); },
          "'none': nothing is missing; 'explained'; 'tie': two explanations cannot be told apart; "
          "'unknown'")
      .def_property_readonly(
          "findings", [](const Explanation& e) { return e.report.attr("findings"); },
          "what was found, the keys of a finding in findings.json as attributes: mechanism, "
          "physics, parameters,\nwhere, not_used ...")
      .def_readonly("report", &Explanation::report,
                    "findings.json: its keys as attributes (docs/formats.md)")
      .def_readonly("remarks", &Explanation::remarks, "a sentence each")
      .def_property_readonly("corrected", [](const Explanation& e) { return e.files.corrected; })
      .def_property_readonly("json_path",
                             [](const Explanation& e) { return path_or_none(e.files.json_path); })
      .def_property_readonly("page_path",
                             [](const Explanation& e) { return path_or_none(e.files.page_path); })
      .def("__repr__", &shown_explanation)
      .def("_repr_html_", [](const Explanation& e) {
        return shown_in_notebook(e.files.page_path, shown_explanation(e));
      });

  m.def("explain", &explained,
        "Locates, names and sizes what a simulation lacks to drive like the recordings, as "
        "`crgexplain run` does; writes\n"
        "report.html, findings.json and corrected inputs into the folder `output`. recordings: a "
        "log or several; car:\n"
        "vehicle.yaml; road: a .crg; mapping: which column is which channel; friction: a .crg of "
        "grip factors. fuel_kg at\n"
        "the begin of each log, where none is logged. hold_out: laps, from 0 over all recordings, "
        "that only judge.\n"
        "nulls: replicates that set the thresholds. threads: 0 all; never changes the result. "
        "skip_simulation: the whole\n"
        "car is not driven. progress(stage, share) as for build(). Raises Error.",
        "recordings"_a, "car"_a, "road"_a, "output"_a, py::kw_only(), "mapping"_a = py::none(),
        "friction"_a = py::none(), "fuel_kg"_a = 0.0, "hold_out"_a = std::vector<int>{},
        "threads"_a = 0U, "nulls"_a = std::size_t{1000}, "skip_simulation"_a = false,
        "progress"_a = py::none());
}

}  // namespace kerbstone
