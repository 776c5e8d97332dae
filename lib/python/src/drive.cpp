#include "drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "recording/channels.h"
#include "vehicle/error.h"
#include "vehicle/telemetry.h"

namespace py = pybind11;

namespace kerbstone {
namespace {

void want_gear(const Car& car, double gear) {
  const int top = vehicle::top_gear(car.car.parameters);
  if (!(gear >= -1 && gear <= top) || gear != std::floor(gear))
    throw py::value_error(fmt::format("gear: -1 to {} wanted", top));
}

}  // namespace

void want_step_s(double step_s) {
  if (!(step_s > 0) || !(step_s <= 0.01))
    throw py::value_error("step_s: more than 0, at most 0.01 wanted");
}

void want_steps(int steps) {
  if (steps < 1) throw py::value_error("steps: 1 or more wanted");
}

vehicle::StartOptions start_of(const Car& car, const Road& road, const Begin& begin) {
  if (!(begin.speed_mps >= 0) || !(begin.speed_mps < 150))
    throw py::value_error("speed_mps: 0 to 150 wanted");
  want_gear(car, begin.gear);
  for (const auto& [name, x, low, high] : {std::tuple("fuel_kg", begin.fuel_kg, 0, 500),
                                           {"tyre_k", begin.tyre_k, 200, 500},
                                           {"disc_k", begin.disc_k, 200, 1500}})
    if (!(x >= low && x <= high))
      throw py::value_error(fmt::format("{}: {} to {} wanted", name, low, high));
  const crg::Sample at = road.surface.at_uv(begin.u_m, begin.v_m);
  if (!at.valid || !at.inside)
    throw vehicle::Error("no road at u " + std::to_string(begin.u_m) + " m, v " +
                         std::to_string(begin.v_m) + " m");
  vehicle::StartOptions start;
  start.x_m = at.x_m;
  start.y_m = at.y_m;
  start.z_near_m = at.z_m;
  start.yaw_rad = at.heading_rad;
  start.speed_mps = begin.speed_mps;
  start.fuel_kg = begin.fuel_kg;
  start.tyre_k = begin.tyre_k;
  start.disc_k = begin.disc_k;
  start.gear = static_cast<int>(begin.gear);
  return start;
}

vehicle::Controls<double> controls_of(const Car& car, const Asked& asked) {
  const std::array<double, vehicle::kWheels>& brake_pa = asked.brake_pa;
  for (const double x : {asked.steer_rad, asked.throttle, brake_pa[0], brake_pa[1], brake_pa[2],
                         brake_pa[3], asked.clutch})
    if (!std::isfinite(x)) throw py::value_error("a control that is no number");
  const auto share = [](double x) {  // what rounding leaves beyond is meant as the end
    if (!(x >= -1e-6 && x <= 1.0 + 1e-6)) throw py::value_error("throttle, clutch: 0 to 1 wanted");
    return std::clamp(x, 0.0, 1.0);
  };
  vehicle::Controls<double> controls;
  controls.steer_command_rad = asked.steer_rad;
  controls.throttle_command = share(asked.throttle);
  controls.clutch_command = share(asked.clutch);
  want_gear(car, asked.gear);
  controls.gear_command = static_cast<int>(asked.gear);
  if (*std::min_element(brake_pa.begin(), brake_pa.end()) < 0)
    throw py::value_error("brake_pa: 0 or more wanted");
  controls.brake_command_pa = brake_pa;
  return controls;
}

std::string tell(const vehicle::Simulation<double>& sim, const vehicle::StepResult& result,
                 const Before& before, const vehicle::Detail<double>& detail,
                 const vehicle::Controls<double>& controls, vehicle::RoadTracker& tracker,
                 std::span<double> row) {
  const vehicle::State<double>& s = before.state;
  const crg::UV at = tracker.at(s[vehicle::kX], s[vehicle::kY], s[vehicle::kZ]);
  vehicle::fill_telemetry(before.time_s, s, detail, controls, at.u_m, at.v_m, row);
  return result.ok() ? "" : vehicle::describe(result, sim.time_s, at.u_m, at.v_m);
}

std::size_t place_of_channel(const std::string& name) {
  const std::vector<std::string>& names = recording::telemetry_channels();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw py::key_error(name);
  return static_cast<std::size_t>(found - names.begin());
}

}  // namespace kerbstone
