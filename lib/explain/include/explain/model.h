// The relations that are tested: between redundant channels, and between forces and motion.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "explain/signals.h"
#include "vehicle/vehicle_file.h"

namespace explain {

/// One relation per row kind; the residual is what the log says minus what sensors and car should
/// give, in the unit stated.
enum Relation : std::size_t {
  kGyro,         ///< yaw rate against the derivative of heading (or of the course), rad/s
  kCourse,       ///< course of the path against heading plus sideslip, rad
  kSpeed,        ///< speed along the path against vx, vy, m/s
  kFrontWheels,  ///< front wheel speed against vx, not braking, m/s
  kRearWheels,   ///< rear wheel speed against that of the car, m/s
  kAccelX,       ///< ax against dvx/dt - r vy + g grade, m/s2
  kAccelY,       ///< ay against dvy/dt + r vx + g bank, m/s2
  kAccelZ,       ///< az against g + curvature v^2, m/s2
  kForceX,       ///< forward acceleration against the car's forces, m/s2
  kForceY,       ///< lateral acceleration against the tyres' forces, m/s2
  kMomentZ,      ///< yaw acceleration against the tyres' moments, rad/s2
  kLoadsFront,
  kLoadsRear,     ///< logged wheel loads of an axle against the model, N per kg of car
  kDifferential,  ///< rear wheel speed difference against that of the car, m/s
  kSteering,
  kThrottleMoves,
  kBrakeMoves,  ///< what was measured against its command through the actuator: rad, 1, Pa
  kRelationCount
};
struct RelationInfo {
  const char* name;  ///< as in findings.json: the channel in which it is seen
  const char* unit;
  bool sensors_only;  ///< independent of tyres and forces
};
const std::array<RelationInfo, kRelationCount>& relations();

/// What the road has beyond its file along the whole lap: rise to the left, rise ahead, both m/m,
/// and curvature, 1/m. At places that are equally far apart, first and last included; of a closed
/// road the first only, because the last is the same. Between them linear. Empty: nothing.
struct RoadProfiles {
  std::vector<double> bank, grade, vertical;
  bool operator==(const RoadProfiles&) const = default;
};

struct Effect;  ///< src/car/effect.h
/// A mechanism's effect on the led car: how much of it, and the constants that it goes with. What
/// they mean says the effect.
struct Acting {
  const Effect* effect = nullptr;
  std::array<double, 2> amount{}, constant{};
  bool operator==(const Acting&) const = default;
};

/// Everything that may be wrong, flat.
struct Setting {
  // The car that is led.
  vehicle::Parameters<double> p;
  std::array<double, 2> wheel_radius{1, 1};  ///< factors, front and rear
  std::array<double, 4> engine_shape{};      ///< curve of the engine: over throttle, speed, both
  double reaction = 0.0;                     ///< share of the wheels' torques on the body, added
  double rolling = 1.0, slip = 1.0;          ///< factors on rolling resistance and rear slip
  double radius_by_load = 1.0;               ///< factor on what loads take from the rolling radius
  double pressure_by_command = 1.0;          ///< factor on the gain of the brakes between the two
  std::array<double, 2> curve{}, curve2{};   ///< side force of an axle: bend over its use of grip,
                                             ///< and its skew
  std::array<double, 2> load_curve{};        ///< the same over its load
  std::array<double, 2> drop{};              ///< camber-like constant side force of an axle, m/s2
  std::vector<Acting> effects;               ///< of mechanisms, each once
  int substeps = 20;                         ///< in Signals::kStep_s

  // What leads it.
  double throttle_s = 0.0, brake_s = 0.0, steer_s = 0.0, steer_lag_s = 0.0;  ///< more delay
  double burn = 0.0;                                                         ///< kg/s

  // The road, everywhere, and from place to place.
  double bank = 0.0, grade = 0.0, vertical = 0.0;
  double shift_u = 0.0;  ///< m
  RoadProfiles along;

  // Sensors.
  double imu_yaw = 0.0, imu_ahead = 0.0;
  double vy_ahead = 0.0;       ///< of the centre of mass, where the lateral speed is measured, m
  double place_ahead = 0.0;    ///< of the centre of mass, where the place is measured, m
  double level = 0.0;          ///< 1: the accelerometer stays level with the road, 0: with the body
  double filter_lead_s = 0.0;  ///< of filters that a logger reckons from sample to sample
  double derived_ax = 0.0;     ///< 1: ax is the derivative of the speed
  struct Sensor {
    double bias = 0, gain = 0, delay_s = 0, low_pass_s = 0;
    bool operator==(const Sensor&) const = default;
  };
  std::array<Sensor, kChannelCount> sensor;

  Setting() : p(vehicle::default_parameters()) {}
  bool operator==(const Setting&) const = default;

  /// The effect's entry, made with nothing of it where there is none.
  Acting& acting(const Effect& effect);
  /// Adds to its first amount and sets its constants.
  void act(const Effect& effect, double amount, const std::array<double, 2>& constant = {});
};

/// The series behind a first-order filter, exact for what is straight between steps of
/// Signals::kStep_s; starts settled, holds over gaps (NaN).
std::vector<double> lagged(const std::vector<double>& x, double time_s);

/// Residuals of the relations at every step of a recording; NaN where a relation does not apply.
/// Where that is, is decided by the log, not by the setting. Pure.
struct Residuals {
  std::array<std::vector<double>, kRelationCount> r;
};
struct KnownDrive;  ///< led_car.h
/// Drives of the car along the recording, which take nearly all of the time.
struct Drives {
  const KnownDrive* known =
      nullptr;                 ///< of this recording and car: taken where it would be the same
  KnownDrive* keep = nullptr;  ///< gets the drive
  /// No car is led: only the relations that need no forces, and the force along the car that
  /// `known` has. Of `known` they take how the body leans.
  bool none = false;
  std::function<void()> tick = {};  ///< called from time to time on the way
};
Residuals residuals(const Signals& signals, const vehicle::Vehicle& car, const Setting& s,
                    const Drives& drives = {});

/// What the car does at every step, for regimes and pages: use of grip front, rear; braking.
struct Regimes {
  std::vector<double> speed, ax, ay, throttle, brake;
};
Regimes regimes(const Signals& signals);

}  // namespace explain
