// The windows of a drive in which an engine shows its torque, and what they say of it.
#pragma once

#include <cstddef>
#include <vector>

#include "identify/drive_fits.h"
#include "map_fit.h"

namespace identify {

/// One row of a recording as the engine saw it.
struct EngineRow {
  double engine_radps = 0.0, throttle = 0.0, boost = 0.0;
};

/// A window that counts.
struct EngineWindow {
  const DriveWindow* window = nullptr;
  int gear = 0;
  double steer_rad = 0.0;       ///< mean angle of the road wheels
  std::vector<EngineRow> rows;  ///< by the boost that the vehicle file's law gives
};

/// What the drive offers, and why windows do not count.
struct EngineWindows {
  std::vector<EngineWindow> windows;
  bool engine_speed = false;  ///< recorded; else by the driven wheels, or by the car's speed
  bool wheel_speed = false;
  bool pressures = false;  ///< of the brakes were recorded
  std::size_t gears = 0;   ///< that the car has
  std::size_t braked = 0, turning = 0, gear_unknown = 0, out_of_step = 0, limited = 0;
};

/// Throws base::Error without throttle.
EngineWindows engine_windows(const vehicle::Car<double>& car, const DriveWindows& drive,
                             const recording::Recording& recording);

/// In N: the first unknowns are the torques of the map's places less `torque_nm`, the last the
/// factors of the gears less 1.
struct EngineEquations : MapEquations {
  Eigen::VectorXd drag_n, inertia_n;  ///< parts of it: the stated drag; the engine's own spinning
};
EngineEquations engine_equations(const vehicle::Car<double>& car, const EngineWindows& windows,
                                 const vehicle::Map2& torque_nm, bool by_speed,
                                 const Granted& granted);

}  // namespace identify
