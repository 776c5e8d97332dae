// What a run leaves behind: the canonical telemetry channels, ideal sensors.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "vehicle/step.h"
#include "vehicle/table.h"

namespace vehicle {

/// Names of the channels of a row of telemetry, units included, in order.
const std::vector<std::string>& telemetry_channels();

/// One row of telemetry: `state` at the beginning of a step, `detail` of that step, `values` as
/// long as telemetry_channels(). Allocates nothing.
void fill_telemetry(double time_s, const State<double>& state, const Detail<double>& detail,
                    const Controls<double>& controls, double u_m, double v_m,
                    std::span<double> values);

/// Collects one row every `every` steps. Channels, units and signs: docs/crgdrive.md. Values belong
/// to the beginning of the step that is recorded; positions and accelerations to the design centre
/// of mass; accelerations are specific force in body axes.
class Recorder {
 public:
  /// Keeps room for `rows` rows, so that recording them allocates nothing.
  explicit Recorder(std::size_t every = 10, std::size_t rows = 0);

  /// Looks at a step about to be integrated: `state` before it, `detail` of it.
  void record(double time_s, const State<double>& state, const Detail<double>& detail,
              const Controls<double>& controls, double u_m, double v_m);

  const Table& table() const { return table_; }

 private:
  std::size_t every_, steps_ = 0;
  std::vector<double> row_;
  Table table_;
};

}  // namespace vehicle
