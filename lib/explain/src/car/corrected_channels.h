// Channels without the errors that a setting gives their sensors.
#pragma once

#include <array>
#include <vector>

#include "explain/model.h"

namespace explain {

/// Values and time derivatives, as in Signals.
struct CorrectedChannels {
  std::array<std::vector<double>, kChannelCount> x, dx;
};
CorrectedChannels corrected_channels(const Signals& s, const Setting& set);

/// The series this much later; cubic between steps, its begin held.
std::vector<double> delayed(const std::vector<double>& x, double time_s);

}  // namespace explain
