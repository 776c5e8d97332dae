// The full car held at a speed, slip angles and brake or throttle: what it does there, settled.
#pragma once

#include <array>
#include <vector>

#include "vehicle/step.h"

namespace identify {

/// One moment of a full car. Road axes: x forward along the road, y left, normal up. Slip angles
/// are positive where they make a force to the left.
struct WheelMoment {
  double fx_n = 0.0, fy_n = 0.0, fz_n = 0.0;  ///< on the wheel: heading, left, normal
  double kappa = 0.0, camber_rad = 0.0;       ///< inclination against the road, as in tyre files
  double spin_radps = 0.0,
         ground_mps = 0.0;  ///< of the wheel; of the road under it, ahead positive
  double lag = 0.0;         ///< tangent of the slip angle that the tyre does not have yet
};
struct CarMoment {
  double time_s = 0.0;
  double vx_mps = 0.0, vy_mps = 0.0, yaw_rate_radps = 0.0;  ///< of the design centre of mass
  double steer_rad = 0.0;                                   ///< mean of the front wheels
  double ax_mps2 = 0.0, ay_mps2 = 0.0, an_mps2 = 0.0;       ///< specific force, road axes
  double yaw_moment_nm = 0.0;        ///< yaw acceleration times the yaw inertia of the car
  double drive_nm = 0.0;             ///< torque of the engine on both rear wheels, braking below 0
  double differential_nm = 0.0;      ///< moved from the left to the right wheel
  std::array<WheelMoment, 4> wheel;  ///< front left, front right, rear left, rear right
  std::array<double, 2> tyre_k{};    ///< mean tread temperature by axle
};

/// What the car's state and the evaluation of its equations show.
CarMoment moment_of(const vehicle::Car<double>& car, const vehicle::State<double>& state,
                    const vehicle::State<double>& rate, const vehicle::Detail<double>& detail,
                    double time_s);

enum class RigPath {
  kBoth,       ///< both slip angles grow to their ends, whatever yaw moment that makes
  kTrimFront,  ///< the front one grows; the rear one follows until no yaw moment is left
  kTrimRear    ///< the other way round
};

struct RigRun {
  double speed_mps = 30.0;
  double gravity = 1.0;  ///< what presses the car on the road, over its own gravity
  RigPath path = RigPath::kBoth;
  double trim_nm =
      0.0;  ///< on trimmed paths: a stair lasts until less yaw moment is left; 0: no longer
  double front_rad = 0.2, rear_rad = 0.2;      ///< ends of the slip angles
  double throttle = 0.0, throttle_end = -1.0;  ///< as braking_end
  bool neutral = false;                        ///< no gear: the engine neither drives nor brakes
  /// Brake force that is asked for, over the loads; shared by the wheels as their loads are, times
  /// a factor for each axle.
  double braking = 0.0;
  std::array<double, 2> brake_axle{1.0, 1.0};
  double braking_end = -1.0;  ///< grows to this while the slip angles do; below 0: stays
  double settle_s = 1.0, stair_s = 0.25;  ///< before the first stair; each
  std::size_t stairs = 20;                ///< of slip angle or braking, each with one moment
  double fuel_kg = 30.0;
  double step_s = 0.001;
};

/// Drives the rig: plane road, still air, constant temperatures, fuel and speed. Speed, sideslip
/// and yaw rate are prescribed, in stairs whose ends are looked at (yaw rate: lateral acceleration
/// over speed, through a lag of 0.08 s), springs, wheels, tyres and engine are those of the full
/// car: W. F. and D. L. Milliken, Race Car Vehicle Dynamics, chapter 8, "force-moment analysis".
/// Ends where the equations do.
std::vector<CarMoment> run_rig(const vehicle::Car<double>& car, const RigRun& run);

/// The free car, wheels at its own: held at a speed by a push at the centre of mass, steering a
/// sine whose frequency grows from 0.2 to 4 Hz over `seconds`. Same conditions as the rig.
std::vector<CarMoment> run_swept_sine(const vehicle::Car<double>& car, double speed_mps,
                                      double steer_rad, double seconds, double fuel_kg);

/// Highest speed on the level, m/s: engine map against drag; at most 110.
double top_speed(const vehicle::Car<double>& car);

/// The terms of a car on the rig: nothing warms up, burns or blows.
vehicle::Car<double> as_on_rig(const vehicle::Car<double>& car, double gravity);

}  // namespace identify
