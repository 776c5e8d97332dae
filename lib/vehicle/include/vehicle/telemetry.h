// What a run leaves behind: the canonical telemetry channels. Units and signs: docs/crgdrive.md.
#pragma once

#include <cstddef>
#include <span>

#include "vehicle/step.h"

namespace vehicle {

/// One row of telemetry, as ideal sensors in the design centre of mass measure it; accelerations
/// are specific force in body axes: `state` at the beginning of a step, `detail` of that step,
/// `values` as long as recording::telemetry_channels(). Allocates nothing.
void fill_telemetry(double time_s, const State<double>& state, const Detail<double>& detail,
                    const Controls<double>& controls, double u_m, double v_m,
                    std::span<double> values);

}  // namespace vehicle
