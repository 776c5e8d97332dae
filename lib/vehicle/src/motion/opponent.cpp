#include "vehicle/opponent.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vehicle/error.h"

namespace vehicle {

Opponent make_opponent(const recording::Table& log, double ahead_s, const std::string& name) {
  const auto need = [&](const char* channel) -> const std::vector<double>& {
    const std::vector<double>* const values = log.find(channel);
    if (values == nullptr)
      throw Error(
          fmt::format("{}: no column {}; an opponent needs time_s, x_m and y_m", name, channel));
    return *values;
  };
  const std::vector<double>&time_s = need("time_s"), &x_m = need("x_m"), &y_m = need("y_m");
  Opponent out;
  double first_s = 0.0;
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    if (!std::isfinite(time_s[i]) || !std::isfinite(x_m[i]) || !std::isfinite(y_m[i])) continue;
    if (out.time_s.empty()) first_s = time_s[i];
    const double t = time_s[i] - first_s - ahead_s;
    if (!out.time_s.empty() && !(t > out.time_s.back()))
      throw Error(
          fmt::format("{}: time_s = {} in row {} is not later than in the row before; sort "
                      "the log",
                      name, time_s[i], i + 1));
    out.time_s.push_back(t);
    out.x_m.push_back(x_m[i]);
    out.y_m.push_back(y_m[i]);
  }
  if (out.time_s.size() < 2)
    throw Error(fmt::format("{}: {} rows with time_s, x_m and y_m, wanted at least 2", name,
                            out.time_s.size()));
  return out;
}

namespace {

/// The nearer of two, one ahead before one behind.
void take_nearer(std::optional<Wake>& nearest, const OpponentPlace& other,
                 const State<double>& state) {
  const double cy = std::cos(state[kYaw]), sy = std::sin(state[kYaw]);
  const double dx = other.x_m - state[kX], dy = other.y_m - state[kY];
  const Wake here{cy * dx + sy * dy, -sy * dx + cy * dy};
  const bool better = !nearest ? true
                      : (here.x_m > 0.0) != (nearest->x_m > 0.0)
                          ? here.x_m > 0.0
                          : std::hypot(here.x_m, here.y_m) < std::hypot(nearest->x_m, nearest->y_m);
  if (better) nearest = here;
}

}  // namespace

std::optional<Wake> nearest_wake(std::span<const OpponentPlace> places,
                                 const State<double>& state) {
  return nearest_wake({}, 0.0, places, state);
}

std::optional<Wake> nearest_wake(std::span<const Opponent> opponents, double time_s,
                                 const State<double>& state) {
  return nearest_wake(opponents, time_s, {}, state);
}

std::optional<Wake> nearest_wake(std::span<const Opponent> opponents, double time_s,
                                 std::span<const OpponentPlace> places,
                                 const State<double>& state) {
  std::optional<Wake> nearest;
  for (const OpponentPlace& place : places) take_nearer(nearest, place, state);
  for (const Opponent& other : opponents) {
    const std::vector<double>& t = other.time_s;
    if (t.size() < 2 || time_s < t.front() || time_s > t.back()) continue;
    const auto upper = std::upper_bound(t.begin() + 1, t.end() - 1, time_s);
    const auto i = static_cast<std::size_t>(upper - t.begin());
    const double share = (time_s - t[i - 1]) / (t[i] - t[i - 1]);
    take_nearer(nearest,
                {other.x_m[i - 1] + share * (other.x_m[i] - other.x_m[i - 1]),
                 other.y_m[i - 1] + share * (other.y_m[i] - other.y_m[i - 1])},
                state);
  }
  return nearest;
}

}  // namespace vehicle
