// How the stack hears and is heard; it knows nothing else of crgsim.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

namespace stack {

/// Steering, throttle, pressure of the four brakes, gear.
using Command = std::array<double, 7>;

struct Measured {
  double time_s = 0.0, gnss_x_m = 0.0, gnss_y_m = 0.0, gnss_age_s = 0.0, yaw_rate_radps = 0.0,
         vx_mps = 0.0;
};

/// x and y on the map, m, and speed, m/s, of places that will be passed; none: nothing is told.
using Plan = std::vector<std::array<double, 3>>;

/// One command, and the measurement that answers it; none when the run shall end.
using Exchange = std::function<Measured(const Command& command, const Plan& plan, bool ends)>;

Exchange exchange_by_socket(const std::string& path, bool binary);
/// `prefix`: before the names of all topics, "red/" of a car in a race.
Exchange exchange_by_dds(int domain, const std::string& prefix);

}  // namespace stack
