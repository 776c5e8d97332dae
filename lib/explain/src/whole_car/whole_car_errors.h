// How sure the errors of the whole simulated car are, before and after what was found.
#pragma once

#include <array>
#include <vector>

#include "explain/simulate.h"

namespace explain {

/// Squared errors of one window at its horizon: before, after, of what stays as it was, of what
/// goes on as it went last.
using SquaredErrors = std::array<double, 4>;

/// Their roots of means, and how sure the drop is: windows drawn again and again. `drop_low` and
/// `drop_high` hold 90 % for this row alone, `sure_low` and `sure_high` for all kWholeCarRows
/// together (Bonferroni). At least one window. The same seed gives the same values.
void set_errors(const std::vector<SquaredErrors>& windows, unsigned long long seed, HeldOut& row);

/// Channels (speeds, yaw rate and place) times horizons.
inline constexpr std::size_t kWholeCarRows = 12;

}  // namespace explain
