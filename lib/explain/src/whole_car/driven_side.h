// The whole simulated car with one set of inputs: refitted to the laps that train, driven along the
// others.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "explain/simulate.h"
#include "not_known.h"

namespace explain {

/// What is compared at the end of a window, and what an error is worth in the refit.
struct Compared {
  const char* channel;
  const char* unit;
  double worth;
};
inline constexpr std::array<Compared, 3> kCompared{
    {{"vx_mps", "m/s", 0.1}, {"vy_mps", "m/s", 0.1}, {"yaw_rate_radps", "rad/s", 0.01}}};

struct WindowEnd {
  double t_s = 0.0;  ///< since the log's first sample
  /// Of kCompared and of the place across the path: the error at the horizon, the mean square of
  /// all samples in the second half of the way to it, and those of "nothing changes" and of what
  /// goes on along its last 0.2 s.
  std::array<double, 4> error{kNaN, kNaN, kNaN, kNaN}, square{}, hold{}, trend{};
};

/// Every sample of the windows, one after the other; a row of NaN after each window.
struct Driven {
  std::vector<double> t_s;
  std::array<std::vector<double>, kCompared.size()> recorded, simulated;
};

struct Judge {
  const std::vector<RecordedLog>* logs;
  std::set<int> judged;  ///< laps over all logs
  int lap_at(std::size_t log, double t_s) const {
    int lap = 0;
    for (std::size_t k = 0; k < log; ++k)
      lap += (*logs)[k].signals->lap.empty() ? 1 : (*logs)[k].signals->lap.back() + 1;
    const auto& laps = (*logs)[log].signals->lap;
    if (!laps.empty())
      lap += laps[std::min(laps.size() - 1,
                           static_cast<std::size_t>(std::max(0.0, t_s) / Signals::kStep_s))];
    return lap;
  }
  bool is_judged(std::size_t log, double t_s) const { return judged.count(lap_at(log, t_s)) > 0; }
};

inline constexpr std::array<double, 3> kHorizons{0.6, 2.0, 8.0};

struct DrivenSide {
  std::array<std::vector<std::vector<WindowEnd>>, kHorizons.size()> ends;  ///< per horizon and log
  std::vector<Driven> driven;  ///< per log, at the longest horizon
  double lap_s = kNaN;
  std::optional<RefittedCar> car;
  std::string problem;
  bool in_parts = false;  ///< laps that train and laps that judge were driven apart
};

/// Drives one side; `refit` gets what makes its refit. `alike`: a car that was refitted to the same
/// windows, whose slopes will do; or null. `tick`: called from time to time, or none.
DrivenSide drive_side(const SimulationInputs& inputs, const std::vector<RecordedLog>& logs,
                      const Judge& judge, bool in_parts, const RefittedCar* alike,
                      const std::function<RefittedCar(const std::function<RefittedCar()>&)>& refit,
                      const std::function<void()>& tick);

}  // namespace explain
