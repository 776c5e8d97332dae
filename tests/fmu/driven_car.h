// The shipped car on the test's road by the calls of lib/vehicle alone, and a driver for it who
// keeps it on the road while everything happens that a control can ask for.
#pragma once

#include <cmath>
#include <vector>

#include "crg/surface.h"
#include "recording/channels.h"
#include "unit_under_test.h"
#include "vehicle/step.h"
#include "vehicle/telemetry.h"
#include "vehicle/vehicle_file.h"

namespace fmu_tests {

/// What is asked of a car at a time, from where it is.
inline vehicle::Controls<double> asked_of(double time_s, double u_m, double v_m, double yaw_rad,
                                          double vx_mps) {
  vehicle::Controls<double> c;
  const double off = std::remainder(yaw_rad - u_m / 60.0, 2.0 * std::numbers::pi);
  c.steer_command_rad = 3.0 / 60.0 - 0.02 * v_m - 0.4 * off + 0.01 * std::sin(3.0 * time_s);
  const double wanted = 12.0 + 4.0 * std::sin(0.3 * time_s) - vx_mps;
  c.throttle_command = std::fmin(1.0, std::fmax(0.0, 0.3 * wanted));
  for (std::size_t i = 0; i < 4; ++i)
    c.brake_command_pa[i] = wanted < -0.5 ? (3e5 + 1e5 * static_cast<double>(i)) * -wanted : 0.0;
  c.gear_command = std::fmod(time_s, 8.0) < 4.0 ? 1 : 2;
  c.clutch_command = std::fmod(time_s, 10.0) > 9.5 ? 0.7 : 0.0;
  c.opponent = std::fmod(time_s, 20.0) > 10.0;
  if (c.opponent) {
    c.wake_x_m = 12.0;
    c.wake_y_m = 0.5;
  }
  return c;
}

class DrivenCar {
 public:
  explicit DrivenCar(const std::string& road_path)
      : vehicle_(vehicle::read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml")),
        car_(vehicle::make_car(vehicle_.files, vehicle_.parameters, vehicle_.terms,
                               vehicle_.contact)),
        surface_(crg::read(road_path)),
        road_(surface_),
        tracker_(surface_) {
    const crg::Sample at = surface_.at_uv(0.0, 0.0);
    vehicle::StartOptions begin;
    begin.x_m = at.x_m;
    begin.y_m = at.y_m;
    begin.yaw_rad = at.heading_rad;
    begin.z_near_m = at.z_m;
    begin.speed_mps = 10.0;
    sim_ = vehicle::start(car_, road_, begin);
    row_.resize(recording::telemetry_channels().size());
    show({});
  }

  /// Telemetry of the place reached.
  const std::vector<double>& row() const { return row_; }
  const vehicle::State<double>& state() const { return sim_.state; }
  const vehicle::Detail<double>& detail() const { return detail_; }

  void step(const vehicle::Controls<double>& asked) {
    ASSERT_TRUE(step_alone(asked));
    show(asked);
  }
  /// Without telemetry.
  bool step_alone(const vehicle::Controls<double>& asked) {
    return vehicle::step(car_, sim_, asked, road_, vehicle::StepOptions{}, detail_).ok();
  }
  void show(const vehicle::Controls<double>& asked) {
    const vehicle::State<double>& s = sim_.state;
    const crg::UV at = tracker_.at(s[vehicle::kX], s[vehicle::kY]);
    vehicle::fill_telemetry(static_cast<double>(sim_.discrete.step) * 0.001, s, detail_, asked,
                            at.u_m, at.v_m, row_);
  }

 private:
  vehicle::Vehicle vehicle_;
  vehicle::Car<double> car_;
  crg::Surface surface_;
  vehicle::Road road_;
  vehicle::RoadTracker tracker_;
  vehicle::Simulation<double> sim_;
  vehicle::Detail<double> detail_;
  std::vector<double> row_;
};

}  // namespace fmu_tests
