#include "drive_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/statistics.h"
#include "recording/channels.h"

namespace identify {

double at(Column column, std::size_t row) {
  return column == nullptr ? std::numeric_limits<double>::quiet_NaN() : (*column)[row];
}

DriveColumns columns_of(const recording::Table& table) {
  const auto one = [&](const char* name) { return table.find(name); };
  const auto four = [&](const char* before, const char* after) {
    std::array<Column, vehicle::kWheels> out{};
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] = table.find(fmt::format("{}{}{}", before, recording::kWheelNames[i], after));
    if (std::count(out.begin(), out.end(), nullptr) > 0) out.fill(nullptr);
    return out;
  };
  DriveColumns c{one("time_s"),
                 one("x_m"),
                 one("y_m"),
                 one("z_m"),
                 one("yaw_rad"),
                 one("vx_mps"),
                 one("vy_mps"),
                 one("yaw_rate_radps"),
                 one("ax_mps2"),
                 one("ay_mps2"),
                 one("az_mps2"),
                 one("throttle"),
                 one("gear"),
                 four("fz_", "_n"),
                 four("suspension_", "_m"),
                 four("wheel_", "_radps"),
                 four("brake_", "_pa"),
                 four("brake_disc_", "_k")};
  if (c.brake[0] == nullptr) c.brake.fill(one("brake_pa"));
  return c;
}

double noise_of(const std::vector<double>& values) {
  std::vector<double> known, third;
  for (const double v : values)
    if (std::isfinite(v)) known.push_back(v);
  if (known.size() < 20) return 0.0;
  for (std::size_t k = 3; k < known.size(); ++k)
    third.push_back(std::abs(known[k] - 3.0 * known[k - 1] + 3.0 * known[k - 2] - known[k - 3]));
  return 1.4826 * base::median(third) / std::sqrt(20.0);
}

std::size_t Blocks::of(double x_m, double y_m, double since_begin_s) {
  const std::pair<long, long> cell =
      std::isfinite(x_m + y_m) ? std::pair{std::lround(x_m / edge_m), std::lround(y_m / edge_m)}
                               : std::pair{std::lround(since_begin_s / edge_s), -1L};
  return known.emplace(cell, known.size()).first->second;
}

}  // namespace identify
