// From the full car to a reduced one: what the rig shows, fitted; how far it is from the full car.
#pragma once

#include <string>
#include <vector>

#include "base/progress.h"
#include "identify/car_rig.h"
#include "identify/reduced_car.h"
#include "vehicle/road.h"

namespace identify {

struct ReduceOptions {
  double fuel_kg = 30.0;
  double most_mps = 0.0;    ///< highest speed of the rig; 0: the car's top speed
  double least_mps = 15.0;  ///< lowest: below, turns at the limit are not long against the car
  std::size_t speeds = 5;   ///< of the rig, between these
  std::vector<double> gravities{0.6, 1.0, 1.5};  ///< what presses, over gravity
  double most_slip_rad = 0.2;                    ///< slip angles of the rig
  std::size_t slips = 20;                        ///< how many up to there
  unsigned threads = 0;                          ///< 0: all cores; any number gives the same result
  base::Progress progress;
};

/// How far one formula is from the full car on the rig: root mean square and largest, as a share of
/// `of`, the largest value of the full car.
struct PartError {
  std::string name, unit;
  double rms = 0.0, most = 0.0, of = 0.0;
  std::size_t rows = 0;
};

/// One place of the border of what the car can do: g-g over speed and what presses it.
struct GripPoint {
  double vx_mps = 0.0, an_mps2 = 0.0, ax_mps2 = 0.0;
  double full_mps2 = 0.0;                       ///< lateral acceleration of the full car
  double single_mps2 = 0.0, double_mps2 = 0.0;  ///< of the reduced ones
  std::array<double, 2> fx_n{};
  double drive_nm = 0.0;
  bool rolls_free = false;  ///< neither throttle nor brake, no gear
};

/// The border as formula: |(ax - ax0) / (most_ax - ax0)|^n + |ay / most_ay|^n = 1, apart for
/// driving and braking; ax0 is what the free-rolling car has at its largest lateral acceleration.
/// All are specific forces, with drag.
struct GripEllipse {
  double vx_mps = 0.0, an_mps2 = 0.0;
  double ay_mps2 = 0.0, ax_mps2 = 0.0;        ///< of the free-rolling car
  double drive_mps2 = 0.0, brake_mps2 = 0.0;  ///< most_ax, straight on: drive above brake
  double drive_power = 2.0, brake_power = 2.0;
};

struct Reduction {
  ReducedCar car;
  double least_mps = 0.0, most_mps = 0.0, most_slip_rad = 0.0;  ///< where the rig was
  std::vector<double> gravities;
  std::size_t runs = 0, moments = 0;
  std::vector<PartError> parts;
  std::vector<GripPoint> border;
  std::vector<GripEllipse> ellipses;
  PartError ellipse_error;
  PartError limit_single, limit_double;  ///< steady limit without longitudinal force
};

/// Throws base::Error when the car does not settle on the rig.
Reduction reduce_car(const vehicle::Car<double>& car, const ReduceOptions& options = {});

/// The reduced models on a drive of the full car. They are given speed, sideslip, yaw rate,
/// steering, longitudinal acceleration, the axles' longitudinal forces, the engine's torque, the
/// tyres' temperatures and the road's shape along the line; not the loads, and not the wheels'
/// slips.
struct LapError {
  double lap_s = 0.0, largest_ay_mps2 = 0.0;
  double grip_usage = 0.0;  ///< of the driver: 0.75, or less where the car left its line
  std::size_t rows = 0, on_kerbs = 0, other_speeds = 0,
              sliding = 0;  ///< the last three are left out
  struct Model {
    double ay_rms = 0.0, ay_95 = 0.0;  ///< shares of the largest
    double yaw_rms_nm = 0.0;           ///< yaw moment
    double load_rms = 0.0;             ///< of the wheels (axles), over the mean load
  };
  Model single, two;
  /// Wheel loads of the double-track without the shares of bank and of vertical curvature.
  double load_rms_without_bank = 0.0, load_rms_without_vertical = 0.0;
};

/// Drives one lap. Throws base::Error when the driver does not finish.
LapError compare_on_lap(const vehicle::Car<double>& car, const Reduction& reduction,
                        const vehicle::Road& road, const base::Progress& progress = {});

/// What may be left of the full car before a model is refused.
struct ReduceBounds {
  double lap_share = 0.02;     ///< root mean square of ay on the lap, over the largest
  double limit_share = 0.015;  ///< root mean square of the steady-state limit
};

/// In words why a model must not be used; empty: it may.
std::string why_refused(const Reduction& reduction, const LapError& lap, const ReduceBounds& bounds,
                        bool two_tracks);

/// Formulas, parameters, validity and errors. `source` names the vehicle and the road of the lap,
/// one line without quotes. A refused model has its reason in place of its parameters.
std::string control_yaml(const Reduction& reduction, const LapError& lap,
                         const ReduceBounds& bounds, const std::string& source);

/// C99, all functions static inline, no dependencies but math.h. A refused model has no function.
std::string control_header(const Reduction& reduction, const LapError& lap,
                           const ReduceBounds& bounds, const std::string& source);

/// Side force of the effective axles over slip angle, load and longitudinal force.
std::string axles_csv(const Reduction& reduction);

/// The border: full car and reduced cars at the same longitudinal forces.
std::string border_csv(const Reduction& reduction);

}  // namespace identify
