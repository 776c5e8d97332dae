#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/forces.h"

namespace identify {
namespace {

/// Adds columns, of the rows that have forces.
class Columns {
 public:
  explicit Columns(const Forces& forces) {
    const std::vector<double>& known = forces.wheel[0].fz_n.value;
    for (std::size_t k = 0; k < known.size(); ++k)
      if (std::isfinite(known[k])) rows_.push_back(k);
  }

  void add(std::string name, const std::vector<double>& values) {
    std::vector<double> kept;
    kept.reserve(rows_.size());
    for (const std::size_t k : rows_) kept.push_back(values[k]);
    table.add(std::move(name), std::move(kept));
  }

  /// "fx_fl" and "_n": fx_fl_n, fx_fl_sd_n.
  void add(const std::string& name, const std::string& unit, const Estimated& e) {
    add(name + unit, e.value);
    add(name + "_sd" + unit, e.sd);
  }

  recording::Table table;

 private:
  std::vector<std::size_t> rows_;
};

}  // namespace

recording::Table forces_table(const Forces& forces) {
  Columns out(forces);
  out.add("time_s", forces.time_s);
  out.add("u_m", forces.u_m);
  out.add("v_m", forces.v_m);
  for (std::size_t i = 0; i < vehicle::kWheels; ++i) {
    const WheelForces& w = forces.wheel[i];
    const std::string name = recording::kWheelNames[i];
    for (const auto& c : kWheelColumns) out.add(c.name + name, c.ending, w.*c.of);
    out.add("wheel_vx_" + name + "_mps", w.vx_mps);
    out.add("tyre_" + name + "_k", w.tyre_k);
  }
  for (std::size_t a = 0; a < 2; ++a)
    for (const auto& c : kAxleColumns)
      out.add(std::string(c.name) + recording::kAxleNames[a], c.ending, (forces.*c.of)[a]);
  for (const auto& c : kCarColumns) out.add(c.name, c.ending, forces.*c.of);
  return out.table;
}

std::vector<std::pair<std::string, std::string>> forces_basis(const Forces& forces) {
  const auto has = [&](const std::string& channel) {
    return std::any_of(forces.channels.begin(), forces.channels.end(),
                       [&](const ChannelUse& c) { return c.channel == channel; });
  };
  const auto wheels = [&](const char* before, const char* after) {
    return std::all_of(
        recording::kWheelNames.begin(), recording::kWheelNames.end(),
        [&](const char* wheel) { return has(fmt::format("{}{}{}", before, wheel, after)); });
  };
  std::vector<std::pair<std::string, std::string>> out;
  out.emplace_back("fy_front_n, fy_rear_n",
                   has("ay_mps2") && has("yaw_rate_radps")
                       ? "observed: lateral and yaw acceleration, by mass and inertia of the "
                         "vehicle file"
                   : has("yaw_rate_radps")
                       ? "half observed: no lateral acceleration was recorded; by yaw rate, path "
                         "and tyre file"
                       : "not observed: neither lateral acceleration nor yaw rate was recorded; by "
                         "path and tyre file");
  out.emplace_back("fy of single wheels",
                   "not observed: the axle's force, split by load and reference tyre");
  out.emplace_back("fx of single wheels",
                   wheels("wheel_", "_radps")
                       ? "half observed: sum by speed and ax, wheels by their speeds, pressures, "
                         "engine map and differential of the vehicle file"
                       : "not observed: wheel speeds are missing; by pressures, engine map and "
                         "differential of the vehicle file");
  out.emplace_back("fz of single wheels", wheels("fz_", "_n") ? "observed: recorded loads"
                                          : wheels("suspension_", "_m")
                                              ? "observed: recorded travel, by springs and "
                                                "dampers of the vehicle file"
                                              : "not observed: by masses, springs, downforce "
                                                "and road of the files");
  out.emplace_back("power", "by forces and slips, as well as these are known");
  out.emplace_back("kappa", wheels("wheel_", "_radps")
                                ? "observed: wheel speeds, by rolling radius of the tyre file"
                                : "not observed: wheel speeds are missing; by the tyre file");
  out.emplace_back("alpha, sideslip, vy",
                   has("vy_mps") ? "observed: lateral speed was recorded"
                                 : "estimated: no lateral speed was recorded; by path, yaw rate, "
                                   "accelerations and tyre file");
  out.emplace_back("camber",
                   "not observed: by travel, body and road, as the vehicle file has them");
  return out;
}

}  // namespace identify
