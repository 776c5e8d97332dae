// Units stepped for programs that drive them over sockets or by topics, in real time or in
// lockstep.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/progress.h"
#include "crg/surface.h"
#include "sim/opponents.h"
#include "sim/run_unit.h"
#include "vehicle/signal_sensors.h"

namespace sim {

struct ServeOptions {
  /// Path of a Unix datagram socket, or a UDP port of this machine alone, or topics of ROS 2.
  std::string socket_path;
  std::uint16_t udp_port = 0;          ///< where there is no path
  std::optional<unsigned> dds_domain;  ///< instead: topics, those of `devices`, in this domain
  std::string topic_prefix;            ///< before the name of each topic: "red/"
  /// Names of numbers of the unit, or of `devices`; topics add theirs. A measurement may also be
  /// SENSOR.age_s: how long ago what it tells was true; POSITION.latitude_deg and
  /// POSITION.longitude_deg.
  std::vector<std::string> commands, measurements;
  std::vector<std::string> recorded;  ///< of the unit; not sent
  UnitInputs inputs;                  ///< what follows the unit's clock alone: the weather
  vehicle::SignalSensorFile devices;  ///< none: everything is measured and commanded as it is
  std::vector<std::pair<std::string, std::string>> starts;  ///< as in UnitRunOptions
  std::vector<OpponentDrive> opponents;                     ///< [0] is the unit's first
  std::vector<std::pair<std::string, double>> safe;  ///< taken by commands when they stay out
  double safe_after_s = 0.2;                         ///< of the unit's time
  double step_s = 0.001, stop_s = 60.0;
  unsigned every = 10;  ///< steps from one measurement to the next
  /// Latitude and longitude in degrees of a place on the map of the unit; for positions of the
  /// devices.
  std::function<std::array<double, 2>(double x_m, double y_m)> to_latitude_longitude_deg;
  /// The unit's own road, for sensors of the devices that look at it.
  std::shared_ptr<const crg::Surface> road;
  /// Gets what was seen or planned, one line of JSON each, without the newline.
  std::function<void(std::string_view line)> keep_sight;
  /// Gets the rows of the record as they come, which are not kept then.
  KeepRow keep_row;
  /// Gets what is said besides measurements, as it is said, at most kMostRemarks lines of JSON, as
  /// write_remark() makes them.
  std::function<void(std::string_view line)> keep_remark;
  bool lockstep = false;
  double speed_up = 1.0;     ///< of real time
  double patience_s = 30.0;  ///< in lockstep: so long without a command, and the run ends
  UnitLimits limits;         ///< as in UnitRunOptions
};

constexpr std::uint64_t kMostRemarks = 100'000;

/// Upper ends of the bins in which durations of steps are counted, in s; the last bin has none.
constexpr std::array kStepBins_s{10e-6, 20e-6, 50e-6, 100e-6, 200e-6, 500e-6, 1e-3, 2e-3};

struct ServeCounts {
  std::uint64_t steps = 0, late = 0;  ///< late: begun more than 2 ms after their time
  std::uint64_t commands = 0, broken = 0, old = 0, flooded = 0;
  std::uint64_t safe_steps = 0, resets = 0;
  std::uint64_t clipped = 0;  ///< commands of which something was taken at its bound
  std::uint64_t parked = 0;   ///< errors of the unit, after which it stood still
  /// What sensors saw of the road, told after its time, and not looked at: never in lockstep.
  std::uint64_t late_sights = 0, left_out_sights = 0;
  double latest_s = 0.0, step_sum_s = 0.0, longest_step_s = 0.0;
  std::array<std::uint64_t, kStepBins_s.size() + 1> bins{};
  bool real_time_scheduled = false;
  bool asked_to_end = false, silent = false, ended_by_unit = false;
  bool is_parked = false;  ///< at the end
  /// With others on one road: those it is told of, and whether it tells them where it is.
  std::uint64_t others_seen = 0;
  bool tells_its_place = false;
};

struct ServeRun {
  /// time_s, the measurements, what is recorded only, the commands as they acted, safe,
  /// resets
  std::vector<std::string> columns;
  std::vector<double> values;  ///< row after row, one per measurement; empty with keep_row
  std::size_t row_count = 0;
  double reached_s = 0.0;    ///< time of the last row
  std::string first_broken;  ///< why the first broken command was refused
  std::string first_parked;  ///< the first error of the unit after which it stood still
  ServeCounts counts;
  std::vector<std::string> log;  ///< what the unit said at ends and resets, at most kMostLogLines
  std::string refused;           ///< calls that its sandbox refused the unit; empty: none
  std::string not_finite;        ///< the first recorded value that is no finite number; empty: none
  std::string failed;            ///< of several units: the error or crash that ended this one

  std::size_t rows() const { return row_count; }
};

/// In lockstep every new command is followed by `every` steps and answered by the measurement then;
/// the same sequence number again is answered by the same measurement, without a step: the same
/// bytes for the same commands, whatever the load. In real time the unit steps from the begin, at
/// absolute times, and the newest command counts; at most 64 datagrams are read per step.
/// Measurements go to whoever commanded last. A command that cannot be taken as a whole is refused,
/// answered with the reason, and changes nothing. An error of the unit ends no run: the unit stands
/// still, is measured as it was before that step and not recorded, until a reset. Throws Error as
/// run_unit() does, and when the socket cannot be made or the topics cannot be joined.
ServeRun serve_unit(const std::string& path, const ServeOptions& options,
                    const base::Progress& progress = {});

struct ServedUnit {
  std::string name;  ///< for messages
  std::string path;
  ServeOptions options;
};

/// Several units in one run, each in a process of its own with a connection of its own, at most
/// Together::kMost. They have one clock: steps, stop, speed-up and lockstep have to be the same for
/// all. Those with car.x and car.y are opponents of those with input.opponent, at the begin of each
/// step. In lockstep a step of one is taken when all others have come there, so commands in any
/// order give the same bytes. Who stays out longer than its `patience_s` is not waited for again:
/// its safe input acts until the run ends, which it does when nobody drives. Who ended, by a
/// command, by its unit or by a crash, is no longer on the road. In real time nobody waits for
/// anybody; a pause stops all.
std::vector<ServeRun> serve_units(const std::vector<ServedUnit>& units,
                                  const base::Progress& progress = {});

}  // namespace sim
