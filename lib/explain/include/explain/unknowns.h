// What may be wrong or missing: parameters, curves nobody knows exactly, sensors, road, physics.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "explain/model.h"

namespace explain {

enum class Role {
  kParameter,  ///< stated in the vehicle file, refitted with its prior width
  kCurve,      ///< shape of a map or tyre curve, refitted with a weak prior and not reported
  kCandidate   ///< absent from the simulation unless the data ask for it
};

/// Standard deviations of what a sensor may get wrong beside a road that is wrong along the whole
/// lap; 0: not asked.
struct UsualError {
  double beside = 0.0;  ///< where the profile is sized: no more than nobody would call an error
  double rival = 0.0;   ///< where it is judged: errors that could take its place
};

struct Unknown {
  std::string
      id;  ///< as in docs/crgexplain.md: "vehicle.turbo_lag", "sensor.bias", "parameter.mass"
  std::string kind;        ///< road, vehicle, sensor, environment, parameter
  std::string channel;     ///< the sensor's column; empty otherwise
  std::string name, unit;  ///< of the amplitude
  std::string physics, equation;
  Role role = Role::kCandidate;
  bool assumed = false;  ///< the vehicle file says that nobody knows it: refitted, never a finding
  double stated = 0.0;   ///< value in the simulation
  double held = 0.0;     ///< tighter standard deviation in the refit of what these relations hardly
                         ///< determine; 0: none
  bool stays_held = false;  ///< never let go
  double width = 0.0;       ///< prior: two standard deviations, in the unit
  double step = 0.01;       ///< of the derivative; about the size that matters
  double least = 0.0;       ///< smaller amounts are not worth a finding
  double most = 1e300;      ///< larger amounts are no physics but the sign of something else
  double form =
      0.0;  ///< one standard deviation of what the simulated car and stated curves get wrong
  bool by_curve_across =
      false;                ///< only the tyres' lateral forces tell it: their error widens form
  bool along_road = false;  ///< acts where the road is wrong: scanned over u
  /// The same along the whole lap, where sensors tell its sign; else null.
  std::vector<double> RoadProfiles::*profile = nullptr;
  bool sums_to_nothing = false;  ///< along a closed lap
  UsualError beside_road;        ///< of a sensor that feels the road
  bool in_time = false;          ///< a sensor's error: how late it is
  bool of_motion = false;        ///< a sensor's error: its channels are judged by one another first
  bool one_sided = false;        ///< only a positive amount makes sense
  std::vector<std::pair<std::string, double>>
      constants;  ///< that the amount goes with, by the parameter's name
  std::function<void(Setting&, double)> set;  ///< adds an amount to the setting
  std::string separating;  ///< the experiment that would separate it from its usual rivals
};

struct Untestable {
  std::string mechanism, reason;
};

/// What the road may be wrong by along the lap.
struct RoadKind {
  const char *id, *name, *unit;
  double step;           ///< about the size that matters
  double least;          ///< smaller amounts are not worth a finding
  bool sums_to_nothing;  ///< along a closed lap
};
inline constexpr std::size_t kRoadKinds = 4;
inline constexpr std::array<RoadKind, kRoadKinds> kRoad{{
    {"road.banking", "banking added", "m/m", 0.01, 0.006, false},
    {"road.grade", "grade added", "m/m", 0.01, 0.005, true},
    {"road.vertical_curvature", "curvature added", "1/m", 0.0005, 0.0002, false},
    {"road.friction", "grip added", "1", 0.03, 0.05, false},
}};

/// The mechanism of a column that shows too much or too little.
inline constexpr const char* kSensorGain = "sensor.gain";
inline constexpr const char* kSensorDelay = "sensor.delay";
inline constexpr const char* kSensorLowPass = "sensor.low_pass";
inline constexpr const char* kSensorBias = "sensor.bias";
inline constexpr const char* kSensorLeverArm = "sensor.lever_arm";
inline constexpr const char* kCoupledWheels = "vehicle.differential";

/// All unknowns that these logs can speak about, in a fixed order, and the rest with reasons.
struct Inventory {
  std::vector<Unknown> unknowns;
  std::vector<Untestable> untestable;
};
Inventory inventory(const std::vector<Signals>& logs, const vehicle::Vehicle& car);

/// Every id there is.
const std::vector<std::string>& mechanism_ids();

}  // namespace explain
