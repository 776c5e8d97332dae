// Sensors that look at the road itself: what they are, as a file of devices says it.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace vehicle {

/// Place and axes of a sensor in the car: x ahead, y left, z up, from the point whose place the
/// simulation tells. Axes turn by yaw, then pitch (nose down positive), then roll (left side up
/// positive).
struct Mounting {
  std::array<double, 3> at_m{};
  std::array<double, 3> turned_rad{};  ///< roll, pitch, yaw
};

/// When a sensor looks, and when what it saw arrives.
struct SensorClock {
  double rate_hz = 10.0;
  double delay_s = 0.0;
};

/// A scanner that measures distances along beams: one fan of beams per azimuth, all at one time.
struct ScanSensor {
  std::string name;
  SensorClock clock;
  Mounting mounting;
  std::vector<double> beams_rad;  ///< elevations, up positive
  double field_rad = 0.0;         ///< horizontal, in the middle of which is ahead
  double step_rad = 0.0;          ///< from one azimuth to the next
  double nearest_m = 0.5, reach_m = 80.0;
  double noise_m = 0.0;  ///< standard deviation of a distance
  double lost = 0.0;     ///< share of the beams that tell nothing

  std::size_t columns() const;  ///< azimuths: as many steps as the field holds, at least one
};

/// A camera's idea of where the drivable area ends on the left and on the right.
struct EdgeSensor {
  std::string name;
  SensorClock clock;
  Mounting mounting;
  double field_rad = 0.0;  ///< horizontal, in the middle of which is ahead
  double reach_m = 60.0;
  double spacing_m = 1.0;  ///< along the road
  double noise_rad = 0.0;  ///< standard deviation of azimuth and of elevation
  double lost = 0.0;       ///< share of the points that are not seen
};

struct RoadSensorFile {
  std::vector<ScanSensor> scans;
  std::vector<EdgeSensor> edges;
  /// Numbers of the simulation: x, y, z on the map, roll, pitch, yaw.
  std::array<std::string, 6> pose{"car.x", "car.y", "car.z", "car.roll", "car.pitch", "car.yaw"};
  /// The same of how it moves, in the car's axes: vx, vy, vz, roll, pitch and yaw rate, ax, ay, az.
  /// Empty: taken as 0.
  std::array<std::string, 9> motion{"car.vx",        "car.vy",         "",
                                    "car.roll_rate", "car.pitch_rate", "car.yaw_rate",
                                    "car.ax",        "car.ay",         "car.az"};

  bool empty() const { return scans.empty() && edges.empty(); }
};

}  // namespace vehicle
