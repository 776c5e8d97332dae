// How far a replayed car comes out beside its recording. Private to replay.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "replay_commands.h"
#include "replay_windows.h"
#include "vehicle/replay.h"

namespace vehicle {

/// Errors of the car and of the trivial predictors in one channel, summed over all windows.
struct ErrorSums {
  std::size_t samples = 0;
  std::array<double, 3> max{}, squares{};

  void add(double car, double hold, double trended);
  ChannelError finish(const std::string& channel) const;
};

/// Every telemetry channel that was measured and is no command, and the place.
class ReplayErrors {
 public:
  explicit ReplayErrors(const Source& source);

  void begin(const Window& window);

  /// A simulated row of telemetry against recorded row `row` of the window.
  void add(std::size_t row, const std::vector<double>& values);

  std::vector<ChannelError> finish() const;

 private:
  struct One {
    std::size_t column;
    const std::vector<double>* raw;
    Channel filled;
    ErrorSums sums;
    std::pair<double, double> trend;
  };
  const Source& source_;
  std::vector<One> channels_;
  std::size_t x_ = 0, y_ = 0, yaw_ = 0, first_ = 0;
  std::array<ErrorSums, 2> place_;
};

}  // namespace vehicle
