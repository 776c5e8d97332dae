// The movement of an actuator on an even grid of time.
#pragma once

#include <array>
#include <vector>

#include "identify/actuator_fit.h"

namespace identify {

/// Free numbers of an actuator. Lags and damping as logarithms, so that they stay above zero.
enum ActuatorUnknown { kDead, kLag, kDamping, kLag2, kLead, kPlay, kActuatorUnknowns };
using ActuatorValues = std::array<double, kActuatorUnknowns>;

/// Those that an order has, in the order of the enumeration.
std::vector<int> unknowns_of(const ActuatorOrder& order);

/// Movement for gain 1 and offset 0, at rest with the first command before it. Exact: between two
/// samples the delayed command has one kink, and linear differential equations are solved over both
/// pieces. kPlay is in the unit of the command.
std::vector<double> simulate(const ActuatorOrder& order, const ActuatorValues& values, Hold hold,
                             double step_s, const std::vector<double>& command);

}  // namespace identify
