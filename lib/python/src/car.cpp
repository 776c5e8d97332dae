// The simulated car for Python: laps by the built-in driver, and single steps by the caller's.
#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drive.h"
#include "recording/channels.h"
#include "vehicle/error.h"
#include "vehicle/lap.h"

namespace py = pybind11;

namespace kerbstone {

py::dict by_name(const recording::Table& table) {
  py::dict out;
  for (std::size_t k = 0; k < table.names.size(); ++k)
    out[py::str(table.names[k])] = py::array_t<double>(
        static_cast<py::ssize_t>(table.columns[k].size()), table.columns[k].data());
  return out;
}

namespace {

std::unique_ptr<Car> read_car(const std::filesystem::path& path,
                              const std::optional<std::filesystem::path>& setup,
                              const std::vector<std::string>& settings) {
  auto out = std::make_unique<Car>();
  out->files = vehicle::read_vehicle(path.string());
  if (setup) vehicle::read_setup(out->files, setup->string());
  for (const std::string& setting : settings)
    vehicle::apply_setting(out->files, setting, "Car.read");
  const vehicle::Vehicle& v = out->files;
  out->car = vehicle::make_car(v.files, v.parameters, v.terms, v.contact);
  return out;
}

vehicle::LapResult lap(const Car& car, const Road& road, int laps, bool standing, double fuel_kg,
                       std::size_t record_every) {
  if (laps < 1) throw py::value_error("laps: 1 or more wanted");
  vehicle::LapOptions options;
  options.laps = laps;
  options.standing = standing;
  options.fuel_kg = fuel_kg;
  options.record_every = record_every;
  py::gil_scoped_release free;
  return vehicle::drive_laps_tuned(car.car, vehicle::Road(road.surface), std::move(options)).result;
}

/// A car that is driven step by step. Refers to car and road, which Python keeps alive.
class Drive {
 public:
  Drive(const Car& car, const Road& road, const vehicle::StartOptions& start, double step_s)
      : car_(car),
        road_(road.surface),
        tracker_(road.surface),
        row_(recording::telemetry_channels().size(), std::nan("")) {
    options_.step_s = step_s;
    vehicle::check_step(car.files.parameters, options_);
    sim_ = vehicle::start(car.car, road_, start);
  }

  void step(double steer_rad, double throttle, const std::array<double, vehicle::kWheels>& brake_pa,
            int gear, double clutch, int steps) {
    want_steps(steps);
    const vehicle::Controls<double> controls =
        controls_of(car_, {steer_rad, throttle, brake_pa, static_cast<double>(gear), clutch});
    vehicle::StepResult result;
    Before before;
    for (int k = 0; k < steps && result.ok(); ++k) {
      before = {sim_.state, sim_.time_s};
      result = vehicle::step(car_.car, sim_, controls, road_, options_, detail_);
    }
    const std::string problem = tell(sim_, result, before, detail_, controls, tracker_, row_);
    if (!problem.empty()) throw vehicle::Error(problem);
  }

  double time_s() const { return sim_.time_s; }
  double channel(const std::string& name) const { return row_[place_of_channel(name)]; }
  py::dict telemetry() const {
    py::dict out;
    const std::vector<std::string>& names = recording::telemetry_channels();
    for (std::size_t k = 0; k < names.size(); ++k) out[py::str(names[k])] = row_[k];
    return out;
  }

 private:
  const Car& car_;
  vehicle::Road road_;
  vehicle::RoadTracker tracker_;
  vehicle::StepOptions options_;
  vehicle::Simulation<double> sim_;
  vehicle::Detail<double> detail_{};
  std::vector<double> row_;
};

std::unique_ptr<Drive> start_drive(const Car& car, const Road& road, double u_m, double v_m,
                                   double speed_mps, int gear, double fuel_kg, double tyre_k,
                                   double disc_k, double step_s) {
  want_step_s(step_s);
  const vehicle::StartOptions start = start_of(
      car, road, {u_m, v_m, speed_mps, static_cast<double>(gear), fuel_kg, tyre_k, disc_k});
  return std::make_unique<Drive>(car, road, start, step_s);
}

}  // namespace

void add_car(py::module_& m) {
  using namespace pybind11::literals;
  py::class_<vehicle::LapResult>(m, "Laps", "What laps by the built-in driver gave.")
      .def_readonly("complete", &vehicle::LapResult::complete, "every lap was finished")
      .def_readonly("problem", &vehicle::LapResult::problem, "one sentence if not")
      .def_readonly("lap_s", &vehicle::LapResult::lap_s, "one per finished lap")
      .def_readonly("top_mps", &vehicle::LapResult::top_mps)
      .def_property_readonly(
          "telemetry", [](const vehicle::LapResult& r) { return by_name(r.telemetry); },
          "an array per channel, by name; units stand in the names");

  py::class_<Drive>(m, "Drive", "A car that is driven step by step.")
      .def("step", &Drive::step,
           "On by `steps` steps with these commands: angle at the steering wheel (left positive), "
           "throttle 0 to 1, brake\n"
           "pressures fl, fr, rl, rr in Pa, gear 1 to the car's last (0 neutral, -1 reverse), "
           "clutch 0 to 1. Raises Error\n"
           "when the car cannot go on, and says why.",
           py::kw_only(), "steer_rad"_a = 0.0, "throttle"_a = 0.0,
           "brake_pa"_a = std::array<double, 4>{}, "gear"_a = 1, "clutch"_a = 0.0, "steps"_a = 1)
      .def("__getitem__", &Drive::channel,
           "A channel of the last step, by name; NaN before the first.", "channel"_a)
      .def_property_readonly("time_s", &Drive::time_s)
      .def_property_readonly("telemetry", &Drive::telemetry,
                             "all channels of the last step, by name");

  py::class_<Car> cars(m, "Car", "The simulated car that a vehicle file describes.");
  cars.def_static("read", &read_car,
                  "Reads vehicle.yaml and everything it names, then a setup sheet, then settings "
                  "'group.key=value'.",
                  "path"_a, py::kw_only(), "setup"_a = py::none(),
                  "settings"_a = std::vector<std::string>{})
      .def_property_readonly("name", [](const Car& car) { return car.files.name; })
      .def("__repr__", [](const Car& car) { return fmt::format("Car({})", car.files.name); })
      .def("lap", &lap,
           "Laps of a road by the built-in driver; record_every: steps of 1 ms per row of "
           "telemetry, 0 none.",
           "road"_a, py::kw_only(), "laps"_a = 1, "standing"_a = false, "fuel_kg"_a = 30.0,
           "record_every"_a = 10)
      .def("start", &start_drive, "Sets the car on the road, along it, to be driven step by step.",
           "road"_a, py::kw_only(), "u_m"_a = 0.0, "v_m"_a = 0.0, "speed_mps"_a = 0.0, "gear"_a = 1,
           "fuel_kg"_a = 30.0, "tyre_k"_a = 360.0, "disc_k"_a = 500.0, "step_s"_a = 0.001,
           py::keep_alive<0, 1>(), py::keep_alive<0, 2>());
  add_drives(m, cars);
}

}  // namespace kerbstone
