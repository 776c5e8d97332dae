// A recorded drive as means over half a second each: what slow laws of the car are fitted to.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "crg/surface.h"
#include "recording/recording.h"
#include "vehicle/car.h"

namespace identify {

/// How far the values of the vehicle file may be off, shares: two standard deviations.
using Prior = std::array<double, vehicle::kParameterCount>;

/// Means over one window. Accelerations are specific force in axes of the road: along the car, to
/// its left, away from the road. NaN: not recorded.
struct DriveWindow {
  static constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  double time_s = 0.0;            ///< its middle
  double x_m = kNaN, y_m = kNaN;  ///< of its middle row
  double vx_mps = 0.0, vy_mps = 0.0;
  double air_mps2 = 0.0;  ///< mean square of the speed, m2/s2
  double along_mps2 = kNaN, left_mps2 = kNaN, normal_mps2 = kNaN;
  double speeding_mps2 = 0.0;  ///< along the road by the change of vx_mps, gravity's part included
  double yaw_rate_radps = kNaN, throttle = kNaN;
  std::array<double, vehicle::kWheels> load_n{kNaN, kNaN, kNaN, kNaN};
  std::array<double, vehicle::kWheels> travel_m{kNaN, kNaN, kNaN, kNaN};
  std::array<double, vehicle::kWheels> wheel_radps{kNaN, kNaN, kNaN, kNaN};
  std::array<double, vehicle::kWheels> spin_up_radps2{kNaN, kNaN, kNaN, kNaN};  ///< end over begin
  std::array<double, vehicle::kWheels> brake_pa{kNaN, kNaN, kNaN, kNaN};
  std::array<double, vehicle::kWheels> disc_k{kNaN, kNaN, kNaN, kNaN};
  std::array<double, vehicle::kWheels> sink_m{};  ///< wheel's place on the body, down from standing
  double slope = 0.0;                             ///< of the road along the car, m/m, up positive
  double gear = kNaN;                             ///< NaN too where it changed
  bool gear_recorded = false;
  double middle_gear = kNaN;               ///< of its middle row
  std::size_t block = 0;                   ///< windows at one place of the road, or near in time
  std::size_t begin_row = 0, end_row = 0;  ///< of the recording, end excluded
};

/// Where the acceleration away from the road comes from.
enum class NormalFrom {
  kRoad,      ///< gravity and the speed over the road's slopes and curves
  kMeasured,  ///< an accelerometer
  kPlane      ///< neither is known: gravity
};

struct DriveWindowsOptions {
  double seconds = 0.5;    ///< springs have settled to their mean: body modes are at 1 to 5 Hz
  double least_mps = 5.0;  ///< slower rows are left out
  bool body_axes = true;   ///< accelerometers tilt with the body; false: their axes are the road's
  double imu_ahead_m = 0.0, imu_yaw_rad = 0.0;
  double block_m = 100.0;  ///< edge of a place; what a lap repeats is one observation
  double block_s = 10.0;   ///< the same in time, where no place was recorded
};

struct DriveWindows {
  std::vector<DriveWindow> windows;
  NormalFrom normal = NormalFrom::kPlane;
  bool loads = false, travels = false, accelerations = false, lateral_speed = false;
  std::vector<std::string> doubts;  ///< why nothing of this drive may be used, by its channels
  std::size_t blocks = 0;
  /// That steering, yaw rate and speed say, and its standard deviation; NaN: they do not tell.
  double wheelbase_m = DriveWindow::kNaN, wheelbase_sd_m = DriveWindow::kNaN;
  double begin_s = 0.0, end_s = 0.0;  ///< of the recording
  std::size_t rows = 0, slow = 0, off_road = 0, on_kerbs = 0,
              short_of_rows = 0;  ///< and why rows are left out
};

/// Cuts a recording into windows that reach over no gap. A row counts where speed, and what there
/// is of loads, travels and accelerations, was measured; a window, where three fifths of its rows
/// do. With `road` the recording needs x_m, y_m and yaw_rad, and windows with a wheel on a kerb
/// are left out. The body's tilt against the road
/// is taken from travels and loads, where there are loads alone by the car's springs; without
/// either, axes are left as they are. Throws
/// base::Error where a channel is missing that is needed.
DriveWindows drive_windows(const vehicle::Car<double>& car, const crg::Surface* road,
                           const recording::Recording& recording,
                           const DriveWindowsOptions& options = {});

/// What the windows' normal acceleration rests on, in words.
std::string normal_words(const DriveWindows& drive, bool body_axes);

}  // namespace identify
