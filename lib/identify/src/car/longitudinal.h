// What moves a car along its road, window by window, from laws of lib/vehicle.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "identify/drive_windows.h"

namespace identify {

/// Factors of ride height and yaw on drag and lift, as in the car's equations.
struct AirFactors {
  double drag = 1.0;
  std::array<double, 2> lift{1.0, 1.0};
};
AirFactors air_factors(const vehicle::Car<double>& car, const DriveWindow& w);

/// Load of a wheel, N: recorded, else by weight, downforce and transfer of the vehicle file.
double load_of(const vehicle::Car<double>& car, const DriveWindow& w, std::size_t wheel,
               double mass_kg);

/// Torque of all wheels' rolling resistance, N m, positive.
double rolling_torque(const vehicle::Car<double>& car, const DriveWindow& w, double mass_kg);

/// Arm of the longitudinal force about a rolling wheel, m: as the vehicle file states it, else
/// halfway between loaded and rolling radius.
double force_arm(const vehicle::Car<double>& car, const DriveWindow& w, std::size_t axle,
                 double mass_kg);

/// The car at one end of what an arm that is not stated may be: one standard deviation away.
struct OtherArm {
  vehicle::CarFiles files;
  vehicle::Car<double> car;
};

/// Nothing where the arm is stated.
std::unique_ptr<const OtherArm> other_arm(const vehicle::Car<double>& car);

/// The arms that were used, and whose word they are.
std::string arm_words(const vehicle::Car<double>& car,
                      const std::vector<const DriveWindow*>& windows, double mass_kg);

/// The gear of a window: recorded; the only one that the car has; none where it is not known.
std::optional<int> gear_of(const vehicle::Car<double>& car, const DriveWindow& w);

/// Forces on the road, N, of one window.
struct AlongForces {
  double inertia_n = 0.0;  ///< of the car's mass, its wheels and what is geared to them
  double rolling_n = 0.0;  ///< rolling resistance, positive
  double drag_m2_n = 0.0;  ///< drag per square metre of drag area, positive
};

/// `gear` 0: the engine does not turn with the wheels. By the accelerometer, or by the change of
/// speed.
AlongForces along_forces(const vehicle::Car<double>& car, const DriveWindow& w, double mass_kg,
                         int gear, bool by_speed);

/// Force on the road per torque of the engine, 1/m, and the engine's speed by the wheels, rad/s.
struct Gearing {
  double per_torque_1pm = 0.0, engine_radps = 0.0;
};
Gearing gearing(const vehicle::Car<double>& car, const DriveWindow& w, int gear, double mass_kg,
                bool pulls);

}  // namespace identify
