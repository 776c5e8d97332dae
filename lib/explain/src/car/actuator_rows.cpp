#include "actuator_rows.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "explain/signals.h"
#include "vehicle/laws/actuator.h"

namespace explain {

using P = vehicle::Parameter;

void actuator_rows(std::vector<double>& out, const std::vector<double>& measured,
                   const std::vector<double>& command, double gain, double most, double amplitude,
                   const vehicle::Parameters<double>& p, P dead_time) {
  constexpr int kSubsteps = 20;
  constexpr double kSubstep_s = Signals::kStep_s / kSubsteps;
  const double* const own = &p[dead_time];  // dead time, lag, damping, lead follow one another
  const auto response =
      vehicle::laws::actuator_response(own[0], own[1], own[2], own[3], kSubstep_s);
  vehicle::laws::Actuator<double> actuator;
  std::int64_t step = 0;
  for (std::size_t i = 0; i + 1 < measured.size(); ++i) {
    if (!std::isfinite(command[i]) || !std::isfinite(command[i + 1])) {
      step = 0;
      continue;
    }
    const double from = std::min(most, gain * command[i]),
                 to = std::min(most, gain * command[i + 1]);
    if (step == 0) {
      actuator.history.fill(from);
      actuator.place = from;
      actuator.rate = 0;
    }
    const double moved =
        amplitude == 0 || step == 0 ? from : actuator.place + own[3] * actuator.rate;
    if (step >= std::int64_t{kSubsteps} * 20)
      out[i] = measured[i] - (from + amplitude * (moved - from));
    // The command's mean over the substep that follows.
    for (int k = 0; k < kSubsteps; ++k)
      vehicle::laws::move(actuator, step++, from + (k + 0.5) / kSubsteps * (to - from), response);
  }
}

}  // namespace explain
