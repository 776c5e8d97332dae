// Parts of a car from one drive: what `crgidentify mass`, `aero`, `suspension`, `brakes` and
// `engine` find.
#include <fmt/format.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "identify/measure.h"
#include "reports.h"

namespace py = pybind11;

namespace kerbstone {
namespace {

using identify::Found;

struct Identified {
  std::string part;
  identify::Measured measured;
  double fuel_kg = 0.0;
};

py::dict found_of(const Identified& identified) {
  py::dict out;
  for (const Found& found : identified.measured.fit.found) out[py::str(found.name)] = found;
  return out;
}

/// The places of the engine's map, or of that of the pads' friction.
py::list map_of(const Identified& identified) {
  using namespace pybind11::literals;
  py::list out;
  if (identified.measured.engine)
    for (const identify::MapPlace& c : identified.measured.engine->places)
      out.append(py::dict("engine_radps"_a = c.x, "throttle"_a = c.y, "torque_nm"_a = c.value,
                          "within_nm"_a = c.within, "stated_nm"_a = c.stated,
                          "unseen"_a = c.unseen));
  if (identified.measured.pads)
    for (const identify::MapPlace& c : identified.measured.pads->places)
      out.append(py::dict("pressure_pa"_a = c.x, "surface_k"_a = c.y, "friction"_a = c.value,
                          "within"_a = c.within, "stated"_a = c.stated, "unseen"_a = c.unseen));
  return out;
}

py::object identified(const std::string& part, const Path& recording, const Path& car,
                      const std::optional<Path>& road, const std::optional<Path>& mapping,
                      const std::optional<Path>& setup, const std::vector<std::string>& settings,
                      const std::string& frame, const std::optional<double>& fuel_kg,
                      const std::vector<std::pair<double, double>>& engine_off_s) {
  if (frame != "body" && frame != "road") throw py::value_error("frame: 'body' or 'road' wanted");
  identify::MeasureRequest request;
  request.recording_path = recording.string();
  request.vehicle_path = car.string();
  request.setup_path = path_or_empty(setup);
  request.road_path = path_or_empty(road);
  request.mapping_path = path_or_empty(mapping);
  request.settings = settings;
  request.body_axes = frame == "body";
  request.fuel_kg = fuel_kg;
  request.engine_off_s = engine_off_s;
  auto out = std::make_unique<Identified>();
  {
    const py::gil_scoped_release free;
    const identify::ReadDrive drive(request);
    out->part = part;
    out->measured = identify::measure(part, drive);
    out->fuel_kg = drive.fuel_kg;
  }
  const std::vector<std::string> doubts = out->measured.fit.doubts;
  const py::object result = py::cast(std::move(out));
  if (!doubts.empty()) raise_not_usable(request.recording_path + ": " + doubts.front(), result);
  return result;
}

}  // namespace

void add_identify(py::module_& m) {
  using namespace pybind11::literals;
  py::class_<Found>(m, "Found", "One number of a car, with its 90 % interval.")
      .def_readonly("name", &Found::name)
      .def_readonly("unit", &Found::unit)
      .def_readonly("value", &Found::value)
      .def_readonly("within", &Found::within, "half of the 90 % interval")
      .def_readonly("sd", &Found::sd, "standard deviation, by the drive and the vehicle file")
      .def_readonly("sd_of_drive", &Found::sd_drive, "the drive's share of it")
      .def_property_readonly(
          "stated",
          [](const Found& f) { return std::isfinite(f.stated) ? py::cast(f.stated) : py::none(); },
          "the vehicle file's, or None")
      .def_readonly("unseen", &Found::unseen, "why the drive does not show it; empty: it does")
      .def("__repr__", [](const Found& f) {
        return f.unseen.empty() ? fmt::format("Found({} = {:.6g} +- {:.2g} {})", f.name, f.value,
                                              f.within, f.unit)
                                : fmt::format("Found({} not observable: {})", f.name, f.unseen);
      });
  py::class_<Identified>(m, "Identified", "A part of a car, from one drive.")
      .def_readonly("part", &Identified::part)
      .def_property_readonly("found", &found_of, "a Found for each number, by its name")
      .def_property_readonly("map", &map_of,
                             "engine and brakes: the places of the torque's or the friction's map, "
                             "a dict each")
      .def_property_readonly(
          "remarks", [](const Identified& i) { return i.measured.fit.remarks; },
          "what was taken for granted, a sentence each")
      .def_property_readonly(
          "doubts", [](const Identified& i) { return i.measured.fit.doubts; },
          "why no number may be used; empty: none was found")
      .def_property_readonly(
          "sheet", [](const Identified& i) { return i.measured.sheet + i.measured.discs_sheet; },
          "lines for a setup sheet")
      .def_readonly("fuel_kg", &Identified::fuel_kg, "that was counted")
      .def("__repr__", [](const Identified& i) {
        return fmt::format("Identified({}, {} numbers)", i.part, i.measured.fit.found.size());
      });
  m.def("identify", &identified,
        "Finds a part of a car from one drive, as `crgidentify PART` does: 'mass', 'aero', "
        "'suspension', 'brakes' or\n"
        "'engine'. recording: a log; car: vehicle.yaml; road: a .crg for slopes; mapping: which "
        "column is which channel;\n"
        "setup, settings as for Car.read(). frame: 'body', accelerometers tilt with the body, or "
        "'road'. fuel_kg, where none\n"
        "is logged. engine_off_s: (begin, end) in seconds of the log; aero only. Raises Error, and "
        "NotUsable where channels\n"
        "and car contradict each other.",
        "part"_a, "recording"_a, "car"_a, py::kw_only(), "road"_a = py::none(),
        "mapping"_a = py::none(), "setup"_a = py::none(), "settings"_a = std::vector<std::string>{},
        "frame"_a = "body", "fuel_kg"_a = py::none(),
        "engine_off_s"_a = std::vector<std::pair<double, double>>{});
}

}  // namespace kerbstone
