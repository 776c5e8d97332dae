// What moves a car along its road, window by window, from laws of lib/vehicle.
#pragma once

#include <array>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "window_fit.h"

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

/// Of a rolling tyre: it grows and stiffens with speed.
struct Radii {
  double loaded_m = 0.0, rolling_m = 0.0;
};
Radii radii_under(const vehicle::Car<double>& car, std::size_t axle, double load_n, double v_mps);

/// Arm of the longitudinal force about a rolling wheel, m: as the vehicle file states it, else
/// halfway between loaded and rolling radius.
double force_arm(const vehicle::Car<double>& car, const DriveWindow& w, std::size_t axle,
                 double mass_kg);

/// The gear of a window: recorded; the only one that the car has; none where it is not known.
std::optional<int> gear_of(const vehicle::Car<double>& car, const DriveWindow& w);

/// Change of a window's speed along the road, gravity's part left out.
double slowing_mps2(const vehicle::Car<double>& car, const DriveWindow& w);

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

/// What a fit along the road takes for granted beside the car's numbers.
struct Granted {
  double mass_kg = 0.0;
  double rolling = 1.0, engine = 1.0, drag = 1.0, side = 1.0;  ///< factors on the car's
  double offset_mps2 = 0.0;                                    ///< of the acceleration
};

/// What a fit along the road begins with. `car` and `prior` must outlive it.
struct Along {
  Along(const vehicle::Car<double>& its_car, const Prior& its_prior, const DriveWindows& drive,
        const WeighedOptions& options);

  const vehicle::Car<double>& car;
  const Prior& prior;
  Granted is;
  double mass_sd_kg = 0.0;
  bool weighed = false;   ///< the mass is the wheel loads', not the vehicle file's
  bool by_speed = false;  ///< acceleration by the change of speed, not by ax_mps2

  /// Each of these moved by as much, alone.
  std::vector<Granted> moved(
      std::initializer_list<std::pair<double Granted::*, double>> deviations) const;

  /// Cars that are one standard deviation away from `car`: each of these numbers, and the arm of
  /// longitudinal forces where the vehicle file does not state it.
  void each_other_car(const std::vector<vehicle::Parameter>& numbers,
                      const std::function<void(const vehicle::Car<double>&)>& with) const;

  /// Whose mass it is, and what is as wrong as it.
  std::string mass_words(const char* what) const;
  /// The arms that were used, and whose word they are.
  std::string arm_words(const Windows& windows) const;
};

}  // namespace identify
