#include "replay_path.h"

#include <algorithm>
#include <cmath>

namespace vehicle {

RacingLine recorded_line(const std::vector<double>& x, const std::vector<double>& y,
                         const std::vector<double>& speed, const recording::Stretch& stretch) {
  RacingLine line;
  for (std::size_t i = stretch.begin; i < stretch.end; ++i) {
    if (!line.x_m.empty()) {
      const double gone = std::hypot(x[i] - line.x_m.back(), y[i] - line.y_m.back());
      if (gone < 1.0) continue;
      line.length_m += gone;
    }
    line.x_m.push_back(x[i]);
    line.y_m.push_back(y[i]);
    line.s_m.push_back(line.length_m);
    line.speed_mps.push_back(speed[i]);
    line.grade.push_back(0.0);
  }
  return line;
}

double PathKeeper::steer(const Car<double>& car, const State<double>& s,
                         const DriverOptions& options) {
  const auto away = [&](std::size_t i) { return std::hypot(x_m[i] - s[kX], y_m[i] - s[kY]); };
  while (row + 1 < end && away(row + 1) <= away(row)) ++row;
  const double cy = std::cos(yaw_rad[row]), sy = std::sin(yaw_rad[row]);
  const double offset_m = -sy * (s[kX] - x_m[row]) + cy * (s[kY] - y_m[row]);
  const double ahead_m = options.preview_m + options.preview_s * std::max(0.0, s[kVx]);
  const double arc_1pm =
      -2.0 * (offset_m + ahead_m * (s[kYaw] - yaw_rad[row])) / (ahead_m * ahead_m);
  const double ratio = car.parameters[Parameter::steering_ratio];
  const double wheelbase_m = car.parameters[Parameter::chassis_wheelbase_m];
  const Map1& rack = car.files->steering;
  if (rack.empty()) return steer_rad[row] + ratio * arc_1pm * wheelbase_m;
  return laws::steering_command(
      rack, ratio, laws::road_wheel_angle(rack, ratio, steer_rad[row]) + arc_1pm * wheelbase_m);
}

Driver driver_at(const RacingLine& line, double x_m, double y_m, int gear,
                 const DriverOptions& options) {
  Driver driver;
  driver.options = options;
  driver.gear = std::max(1, gear);
  double best = 1e300;
  for (std::size_t i = 0; i < line.x_m.size(); ++i) {
    const double away = std::hypot(line.x_m[i] - x_m, line.y_m[i] - y_m);
    if (away >= best) continue;
    best = away;
    driver.station = i;
    driver.s_m = line.s_m[i];
  }
  return driver;
}

}  // namespace vehicle
