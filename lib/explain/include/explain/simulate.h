// Before and after in the whole simulated car: replays of the recordings, and laps.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "explain/findings.h"
#include "explain/mapping.h"
#include "vehicle/vehicle_file.h"

namespace explain {

/// What a simulation is made from.
struct SimulationInputs {
  const vehicle::Vehicle* car = nullptr;
  const crg::Surface* surface = nullptr;  ///< with its friction map, if there is one
  Mapping mapping;
};

struct RecordedLog {
  const recording::Table* table = nullptr;
  const Signals* signals = nullptr;  ///< of the same table: places and laps
};

/// A car whose parameters and engine map were refitted to recordings.
struct RefittedCar {
  vehicle::Parameters<double> parameters;
  vehicle::Map2 engine_torque_nm;
  std::vector<vehicle::Parameter>
      changed;  ///< what was free, beside the map; empty: too few windows
  /// Of every error over everything that was free, at the stated car: column after column.
  std::vector<double> slopes;
};

struct SimulationCheck {
  std::vector<HeldOut> held_out;                 ///< vx, yaw rate and place over 0.6, 2 and 8 s
  std::vector<DrivenTrace> driven;               ///< the first lap that judges
  double lap_before_s = 0.0, lap_after_s = 0.0;  ///< of the built-in driver; NaN: did not finish
  std::vector<double> recorded_lap_s;            ///< whole laps of the recordings
  std::optional<RefittedCar> before, after;      ///< what was driven
  std::vector<Remark> remarks;  ///< what was refitted, and why something could not be driven
};

/// Drives the recorded commands with lib/vehicle from recorded states, in windows of 2 and 8 s,
/// once with each inputs. In both, engine torque and the shape of its map, drag, brakes, cornering
/// stiffness, grip and the gear shift are refitted with their prior widths to the training laps'
/// windows of 2 s, so that a retuned parameter cannot pose as a finding; errors are those in the
/// second half of the way to 0.6, 2 and 8 s after the begin of the windows of the other laps
/// (`hold_out`, or every second lap). Boost, which no log has, begins as the recorded throttle
/// drives it. Without a logged fuel mass none is added. Trivial: nothing changes within the window.
/// The same inputs give the same result.
///
/// The slopes of the refit are those of the stated inputs on both sides, where both have as many
/// windows. `refit`, if given, is called for each side with what makes its refit: it may give one
/// that was kept. `before_side` is that of the same stated inputs; null: it is driven and given.
using Refit = std::function<RefittedCar(bool after, const std::function<RefittedCar()>& make)>;
struct DrivenSide;
using KnownSide = std::shared_ptr<const DrivenSide>;
struct CheckOptions {
  std::set<int> hold_out;
  Refit refit;
  std::function<void()> tick;  ///< called from time to time, from two threads
};
SimulationCheck check_simulation(const std::vector<RecordedLog>& logs,
                                 const SimulationInputs& before, const SimulationInputs& after,
                                 const CheckOptions& options, KnownSide& before_side);

/// Why corrected inputs that were driven so are not to be handed out, in words with figures: an
/// error is worse for sure by more than 2 %, or the driver no longer finishes a lap, or, with
/// `must_help`, none is better for sure. "For sure": 90 % for all rows together. Empty: hand them
/// out; nothing that was driven speaks against it.
std::string why_not_used(const SimulationCheck& check, bool must_help);

}  // namespace explain
