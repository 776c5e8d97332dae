// Standard manoeuvres: a car, a road made for the purpose, and what is commanded when.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "base/progress.h"
#include "vehicle/sensors.h"

namespace vehicle {

enum class ManoeuvreKind {
  kStepSteer,      ///< steering jumps to the amplitude after one second, speed held
  kSine,           ///< one frequency of steering, speed held
  kChirp,          ///< frequency rises from 0.2 to 4 Hz over the duration, speed held
  kRamp,           ///< steering grows steadily to the amplitude: cornering to the limit, speed held
  kBraking,        ///< straight on, pressure jumps to the amplitude after one second
  kCoastDown,      ///< neutral, hands off
  kKerb,           ///< left wheels over a saw-tooth kerb
  kBump,           ///< all wheels over one bump
  kSplitFriction,  ///< braking with less grip under the left wheels
  kReverse  ///< from standstill backward in reverse gear to the speed, steering from half time on
};

/// By name: step-steer, sine, chirp, ramp, braking, coast-down, kerb, bump, split-friction,
/// reverse. Throws
/// Error on another.
ManoeuvreKind manoeuvre_named(std::string_view name);

struct Manoeuvre {
  ManoeuvreKind kind = ManoeuvreKind::kStepSteer;
  double speed_mps = 30.0;
  double duration_s = 6.0;
  double steer_rad = 0.03;    ///< amplitude of step, sine, chirp, ramp: road wheels
  double frequency_hz = 0.5;  ///< sine
  double pressure_pa = 3e6;   ///< braking, split friction: front; the rear gets 0.6 of it
  double height_m = 0.03;     ///< kerb and bump
  double low_grip = 0.4;      ///< split friction: grip under the left wheels
  double fuel_kg = 30.0;
  std::size_t record_every = 1;  ///< steps per row of telemetry
  StepOptions step;
  const DeviceFile* devices = nullptr;  ///< telemetry as these measure it; nullptr: ideal
  std::function<void(const recording::Table&)> on_row;  ///< called after each row of telemetry
  base::Progress progress;
};

struct ManoeuvreResult {
  bool complete = false;
  std::string problem;
  double peak_fz_n = 0.0;            ///< of any wheel
  double peak_ay_mps2 = 0.0;         ///< absolute
  double peak_yaw_rate_radps = 0.0;  ///< absolute
  double stop_m = 0.0;  ///< distance from the first brake command to standstill; 0: did not stop
  double end_mps = 0.0;
  double step_swing = 0.0;    ///< StepSwing::largest()
  std::string swing_warning;  ///< StepSwing::warning()
  std::string ledge_warning;  ///< of ledges.h
  recording::Table telemetry;
};

/// Throws Error when the car lacks the reverse gear that the manoeuvre asks for.
ManoeuvreResult run_manoeuvre(const Car<double>& car, const Manoeuvre& manoeuvre);

}  // namespace vehicle
