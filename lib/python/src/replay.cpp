// Recordings for Python, and the car that repeats them.
#include "vehicle/replay.h"

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "car.h"
#include "recording/recording.h"
#include "road.h"
#include "vehicle/error.h"

namespace py = pybind11;

namespace kerbstone {
namespace {

recording::Recording read_recording(const std::filesystem::path& path,
                                    const std::optional<std::filesystem::path>& mapping) {
  py::gil_scoped_release free;
  return recording::read_recording(
      path.string(), mapping ? recording::read_mapping(mapping->string()) : recording::Mapping{});
}

py::array_t<double> channel(const recording::Recording& recording, const std::string& name) {
  const std::vector<double>* const values = recording.table.find(name);
  if (values == nullptr) throw py::key_error(name);
  return py::array_t<double>(static_cast<py::ssize_t>(values->size()), values->data());
}

using Rows = std::array<std::size_t, 6>;

/// All of a recording, for pickle.
py::tuple state_of_recording(const recording::Recording& r) {
  std::vector<std::pair<std::size_t, std::size_t>> stretches;
  for (const recording::Stretch& s : r.stretches) stretches.emplace_back(s.begin, s.end);
  return py::make_tuple(by_name(r.table), stretches,
                        std::array<double, 3>{r.step_s, r.first_trouble_s, r.longest_gap_s},
                        Rows{r.rows_read, r.rows_repeated, r.rows_backwards, r.clock_resets,
                             r.rows_without_time, r.cells_not_numbers},
                        r.held, r.constant);
}

recording::Recording recording_of_state(const py::tuple& state) {
  if (state.size() != 6) throw py::value_error("not the state of a Recording");
  recording::Recording r;
  for (const auto& [name, values] : state[0].cast<py::dict>())
    r.table.add(name.cast<std::string>(), values.cast<std::vector<double>>());
  for (const auto& [begin, end] : state[1].cast<std::vector<std::pair<std::size_t, std::size_t>>>())
    r.stretches.push_back({begin, end});
  const auto seconds = state[2].cast<std::array<double, 3>>();
  r.step_s = seconds[0];
  r.first_trouble_s = seconds[1];
  r.longest_gap_s = seconds[2];
  const auto rows = state[3].cast<Rows>();
  r.rows_read = rows[0];
  r.rows_repeated = rows[1];
  r.rows_backwards = rows[2];
  r.clock_resets = rows[3];
  r.rows_without_time = rows[4];
  r.cells_not_numbers = rows[5];
  r.held = state[4].cast<std::vector<std::pair<std::string, double>>>();
  r.constant = state[5].cast<std::vector<std::string>>();
  return r;
}

vehicle::ReplayResult replay(const Car& car, const Road& road,
                             const recording::Recording& recording, double window_s,
                             double settle_s, bool closed_path, bool hold_speed, bool driver,
                             double fuel_kg, double tyre_k, double disc_k) {
  if (!(window_s >= 0) || !(settle_s >= 0))
    throw py::value_error("window_s, settle_s: 0 or more wanted");
  if (!(fuel_kg >= 0)) throw py::value_error("fuel_kg: 0 or more wanted");
  if (hold_speed && driver)
    throw py::value_error("hold_speed: the recorded pedals are wanted, not the driver's");
  vehicle::ReplayOptions options;
  options.window_s = window_s;
  options.settle_s = settle_s;
  options.closed_path = closed_path;
  options.hold_speed = hold_speed;
  options.driver = driver;
  options.fuel_kg = fuel_kg;
  options.tyre_k = tyre_k;
  options.disc_k = disc_k;
  py::gil_scoped_release free;
  return vehicle::replay(car.car, vehicle::Road(road.surface), recording, options);
}

py::dict errors_by_channel(const vehicle::ReplayResult& result) {
  py::dict out;
  for (const vehicle::ChannelError& e : result.errors) out[py::str(e.channel)] = e;
  return out;
}

void add_recording(py::module_& m) {
  using namespace pybind11::literals;
  py::class_<recording::Recording> type(m, "Recording",
                                        "A log of a drive: a mapping from channels to arrays.");
  type.def_static("read", &read_recording,
                  "Reads a log of any kind; mapping.yaml says which column is which channel, "
                  "without it the names do.",
                  "path"_a, py::kw_only(), "mapping"_a = py::none())
      .def("__getitem__", &channel, "A channel by name, at time_s; NaN where not measured.",
           "channel"_a)
      .def("__contains__", [](const recording::Recording& r,
                              const std::string& name) { return r.table.find(name) != nullptr; })
      .def(
          "__len__", [](const recording::Recording& r) { return r.table.names.size(); },
          "how many channels")
      .def(
          "__iter__",
          [](const recording::Recording& r) { return py::iter(py::cast(r.table.names)); },
          "their names")
      .def("keys", [](const recording::Recording& r) { return r.table.names; })
      .def("items", [](const recording::Recording& r) { return by_name(r.table).attr("items")(); })
      .def("values",
           [](const recording::Recording& r) { return by_name(r.table).attr("values")(); })
      .def(
          "get",
          [](const recording::Recording& r, const std::string& name, const py::object& otherwise) {
            return r.table.find(name) == nullptr ? otherwise : py::object(channel(r, name));
          },
          "channel"_a, "default"_a = py::none())
      .def("__repr__",
           [](const recording::Recording& r) {
             return fmt::format("Recording({} channels, {} rows)", r.table.names.size(),
                                r.table.rows());
           })
      .def(py::pickle(&state_of_recording, &recording_of_state))
      .def(
          "to_dataframe",
          [](const recording::Recording& r) {
            return py::module_::import("pandas").attr("DataFrame")(by_name(r.table));
          },
          "The channels as the columns of a pandas.DataFrame; wants pandas.")
      .def_property_readonly("channels",
                             [](const recording::Recording& r) { return r.table.names; })
      .def_readonly("step_s", &recording::Recording::step_s, "median distance of two rows");
  py::module_::import("collections.abc").attr("Mapping").attr("register")(type);
}

}  // namespace

void add_replay(py::module_& m) {
  using namespace pybind11::literals;
  add_recording(m);
  py::class_<vehicle::ChannelError>(
      m, "ChannelError",
      "How far a channel was from the recording, and trivial predictors: hold (it stays as it was "
      "at the window's\n"
      "begin), trend (it goes on along its last 0.2 s).")
      .def_readonly("samples", &vehicle::ChannelError::samples)
      .def_readonly("max", &vehicle::ChannelError::max)
      .def_readonly("rmse", &vehicle::ChannelError::rmse)
      .def_readonly("hold_max", &vehicle::ChannelError::hold_max)
      .def_readonly("hold_rmse", &vehicle::ChannelError::hold_rmse)
      .def_readonly("trend_max", &vehicle::ChannelError::trend_max)
      .def_readonly("trend_rmse", &vehicle::ChannelError::trend_rmse);

  py::class_<vehicle::ReplayResult>(m, "Replay", "What a repeated drive gave.")
      .def_readonly("driven_by", &vehicle::ReplayResult::driven_by,
                    "sentences: which channel drives what, what was assumed")
      .def_readonly("windows", &vehicle::ReplayResult::windows)
      .def_readonly("problems", &vehicle::ReplayResult::problems,
                    "windows that ended early, a sentence each")
      .def_property_readonly("errors", &errors_by_channel,
                             "by channel; along_m and lateral_m: the place seen from the recorded "
                             "one")
      .def_property_readonly(
          "telemetry", [](const vehicle::ReplayResult& r) { return by_name(r.telemetry); },
          "an array per channel at the recorded times; window counts from 1");

  m.attr("Car").attr("replay") = py::cpp_function(
      &replay, py::name("replay"), py::is_method(m.attr("Car")),
      "Repeats a recorded drive on a road with the recorded commands, put back on the recording "
      "every window_s\n"
      "(0: never). closed_path: steered along the recorded path. hold_speed: a push holds speed "
      "and place along the\n"
      "path. driver: the built-in driver follows path and speed. fuel_kg, tyre_k, disc_k: where "
      "not recorded.",
      "road"_a, "recording"_a, py::kw_only(), "window_s"_a = 2.0, "settle_s"_a = 0.5,
      "closed_path"_a = false, "hold_speed"_a = false, "driver"_a = false, "fuel_kg"_a = 30.0,
      "tyre_k"_a = 360.0, "disc_k"_a = 500.0);
}

}  // namespace kerbstone
