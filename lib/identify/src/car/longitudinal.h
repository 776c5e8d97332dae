// What moves a car along its road, window by window, from laws of lib/vehicle.
#pragma once

#include <Eigen/Dense>
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

/// How fast a wheel's speed changes, rad/s2: recorded, else by the car's.
double spin_up_radps2(const vehicle::Car<double>& car, const DriveWindow& w, std::size_t wheel,
                      double mass_kg);

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

  /// The car with the loaded radius as arm of longitudinal forces; calls nothing where the vehicle
  /// file states the arm.
  void with_loaded_arm(const std::function<void(const vehicle::Car<double>&)>& with) const;

  /// Covariance that what `solve` finds has by what is taken for granted: these numbers of the car,
  /// its arm of longitudinal forces, and each of `moved`, a standard deviation of it.
  Eigen::MatrixXd granted_covariance(
      const std::vector<vehicle::Parameter>& numbers, const std::vector<Granted>& moved,
      const std::function<Eigen::VectorXd(const vehicle::Car<double>&, const Granted&)>& solve)
      const;

  /// Whose mass it is, and what is as wrong as it.
  std::string mass_words(const char* what) const;
  /// The arms that were used, and whose word they are.
  std::string arm_words(const Windows& windows) const;
};

}  // namespace identify
