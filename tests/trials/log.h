// What a logger writes of a drive: its channels, their noise, what sensors do to them, the CSV.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "random.h"
#include "truth_car.h"

namespace trials {

inline constexpr int kTyreNumbers = 5;

/// Channels before sensors; from kRollRate on those that ride.h fills. kFzF and kFzR are the loads
/// of axles.
enum {
  kT,
  kX,
  kY,
  kYaw,
  kVx,
  kVy,
  kR,
  kAx,
  kAy,
  kAz,
  kSteer,
  kThrottle,
  kBrake,
  kGear,
  kEngine,
  kWfl,
  kWfr,
  kWrl,
  kWrr,
  kFzF,
  kFzR,
  kS,
  kV,
  kRollRate,
  kPitchRate,
  kTravel,
  kLoad = kTravel + 4,
  kDisc = kLoad + 4,
  kSteerReached = kDisc + 4,  ///< behind the third car's actuators
  kThrottleReached,
  kBrakeReached,
  kTyre,  ///< what no logger writes: of each tyre kTyreNumbers, as Tyre has them
  kChannels = kTyre + 4 * kTyreNumbers
};
inline constexpr std::array<double, kChannels> kNoise{
    0,    0.02, 0.02, 0.002, 0.04, 0.03, 0.004, 0.15, 0.15, 0.3,    0.0004, 0.002, 1.5e4, 0,
    1.5,  0.15, 0.15, 0.15,  0.15, 60,   60,    0,    0,    0.004,  0.004,  2e-4,  2e-4,  2e-4,
    2e-4, 60,   60,   60,    60,   1.5,  1.5,   1.5,  1.5,  0.0004, 0.002,  1.5e4};

using Row = std::array<double, kChannels>;
inline constexpr double kRow_s = 0.005;  ///< between rows of a drive

/// The row of a car in `state` at time_s, with what its driver does and the gear that is in (0:
/// none).
Row row_of(const TruthCar& car, double time_s, const State& state, const Output& o,
           const Commands& driver, int gear);

/// What the sensor `name` of a channel says in row k, before noise.
double sensed(const std::vector<Row>& rows, std::size_t k, int channel,
              const std::vector<Effect>& effects, const std::string& name);

struct Column {
  std::string name;
  int channel;
};
/// Which columns a log has beside time, place, heading, speed and yaw rate.
struct Logged {
  bool vy = true, ax = true, ay = true, az = true, gear = true, engine = true;
  bool commands = false;    ///< of the driver, instead of what reaches wheels, engine and brakes
  bool reached = false;     ///< what the third car's actuators have reached, beside or instead
  bool axle_loads = false;  ///< halved, per wheel
  bool body = false;        ///< roll and pitch rate, suspension and load of every wheel
  bool discs = false;
};
std::vector<Column> columns(const Logged& logged);

/// The recording of a logger that has a clock per channel: each at a rate about `hz` and a phase of
/// its own, in rows that are empty but for what was sampled then.
std::string csv_by_channel(const std::vector<Row>& rows, const std::vector<Column>& columns,
                           double hz, const std::vector<Effect>& effects, Random& dice);

/// The recording: `hz` times a second through sensors with these effects and noise. Commands have
/// neither noise nor a sensor.
std::string csv(const std::vector<Row>& rows, const std::vector<Column>& columns, double hz,
                const std::vector<Effect>& effects, Random& dice);

}  // namespace trials
