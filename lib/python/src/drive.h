// What cars driven step by step share, one alone (Drive) or many (Drives): what they refuse, and
// what they tell of a step.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>

#include "car.h"
#include "road.h"
#include "vehicle/road.h"
#include "vehicle/step.h"

namespace kerbstone {

/// Where and how a car begins.
struct Begin {
  double u_m = 0.0, v_m = 0.0, speed_mps = 0.0;
  double gear = 1.0;  ///< a whole number
  double fuel_kg = 30.0, tyre_k = 360.0, disc_k = 500.0;
};

/// Throws ValueError unless cars can be stepped so.
void want_step_s(double step_s);
void want_steps(int steps);

/// The car on the road, along it. Throws ValueError where `begin` is odd, Error where there is no
/// road.
vehicle::StartOptions start_of(const Car& car, const Road& road, const Begin& begin);

/// What the caller asks of a car, as given.
struct Asked {
  double steer_rad = 0.0, throttle = 0.0;
  std::array<double, vehicle::kWheels> brake_pa{};
  double gear = 1.0;  ///< a whole number
  double clutch = 0.0;
};
/// Throws ValueError for odd ones.
vehicle::Controls<double> controls_of(const Car& car, const Asked& asked);

/// The beginning of a step.
struct Before {
  vehicle::State<double> state{};
  double time_s = 0.0;
};

/// Writes the row of telemetry of a step that began at `before`; gives the sentence about a step
/// that failed, else nothing.
std::string tell(const vehicle::Simulation<double>& sim, const vehicle::StepResult& result,
                 const Before& before, const vehicle::Detail<double>& detail,
                 const vehicle::Controls<double>& controls, vehicle::RoadTracker& tracker,
                 std::span<double> row);

/// Where a channel stands in a row of telemetry. Throws KeyError.
std::size_t place_of_channel(const std::string& name);

/// Drives, and Car.start_many.
void add_drives(pybind11::module_& m, pybind11::class_<Car>& cars);

}  // namespace kerbstone
