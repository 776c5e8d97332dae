#include "new_engine.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "vehicle/error.h"

namespace vehicle {
namespace {

using P = Parameter;

constexpr double kPi = std::numbers::pi;
constexpr double kRolling = 0.013;  // resistance of rolling over load, about that of the tyres

double largest_nm(const DataSheet& sheet) {
  double most = 0.0;
  for (const auto& [rpm, nm] : sheet.torque) most = std::max(most, nm);
  return most;
}

double largest_w(const DataSheet& sheet) {
  double most = 0.0;
  for (const auto& [rpm, nm] : sheet.torque) most = std::max(most, rpm * nm * kPi / 30.0);
  return most;
}

double limit_radps(const DataSheet& sheet) {
  const double points = 1.02 * sheet.torque.back().first;  // the limiter cuts fully 2 % above
  const double rpm = sheet.limit_rpm.value_or(std::min(1.07 * sheet.power_rpm, points));
  return rpm * kPi / 30.0;
}

/// Speed at which the engine's power is what drag and rolling take.
double power_speed_mps(const Basis& b) {
  const double power_w = largest_w(b.sheet) * guessed_value(Guess::kEfficiency, b.sheet.kind);
  const double rolling_n = kRolling * b.sheet.mass_kg * kSheetGravity;
  double slow = 1.0, fast = 200.0;
  for (int i = 0; i < 60; ++i) {
    const double v = 0.5 * (slow + fast);
    ((air_force_n(b.drag_m2, v) + rolling_n) * v < power_w ? slow : fast) = v;
  }
  return slow;
}

/// The last gear reaches the speed that the power allows, the first brings the driven wheels to
/// their grip; the others in equal steps.
std::vector<double> worked_out_ratios(const Basis& b, std::size_t count) {
  const DataSheet& s = b.sheet;
  const double radius_m = s.tyre[1].radius_m;
  const double last = 0.98 * limit_radps(s) * radius_m / power_speed_mps(b);
  // Accelerating loads the driven axle, at most with the whole car.
  const double weight_n = s.mass_kg * kSheetGravity;
  const double driven_n =
      weight_n *
      std::min(1.0, (1.0 - s.front_weight) / std::max(0.1, 1.0 - b.grip * b.cog_m / s.wheelbase_m));
  const double first = 1.1 * b.grip * driven_n * radius_m /
                       (largest_nm(s) * guessed_value(Guess::kEfficiency, s.kind));
  const double last_step = std::max(1.0, static_cast<double>(count - 1));
  const double spread =
      count > 1 ? std::clamp(first / last, std::pow(1.2, last_step), std::pow(1.6, last_step))
                : 1.0;
  std::vector<double> out;
  for (std::size_t i = 0; i < count; ++i)
    out.push_back(last * std::pow(spread, 1.0 - static_cast<double>(i) / last_step));
  return out;
}

}  // namespace

void add_gears(const Basis& b) {
  const DataSheet& s = b.sheet;
  std::vector<double> ratios = s.gear_ratios;
  const double final_drive = s.final_drive.value_or(3.5);
  if (ratios.empty()) {
    const double count = value_for(s.gear_count, Guess::kGears, s.kind);
    ratios = worked_out_ratios(b, static_cast<std::size_t>(count));
    for (double& ratio : ratios) ratio /= final_drive;
    const double most = parameter_list()[static_cast<std::size_t>(P::gearbox_ratio_1)].high;
    if (ratios.front() > most)
      throw Error(
          fmt::format("{}: {:g} kg want a first gear of {:.0f} behind so weak an engine, "
                      "{:g} is the most; check power_kw, torque_nm and mass_kg",
                      s.path, s.mass_kg, ratios.front(), most));
  }
  for (std::size_t i = 0; i < kMostGears; ++i) {
    const auto gear = static_cast<P>(static_cast<std::size_t>(P::gearbox_ratio_1) + i);
    const bool is_there = i < ratios.size();
    if (!is_there && parameter_list()[static_cast<std::size_t>(gear)].value == 0.0) break;
    if (!is_there)
      b.lines.stated(gear, 0.0);
    else if (!s.gear_ratios.empty())
      b.lines.stated(gear, ratios[i]);
    else
      b.lines.guessed(gear, ratios[i], 0.15,
                      "from the wheels' grip in the first to the power's speed in the last gear");
  }
  if (s.final_drive)
    b.lines.stated(P::gearbox_final, final_drive);
  else
    b.lines.follows(P::gearbox_final, final_drive, "any: the gears' ratios go with it");
  b.lines.guessed(P::gearbox_ratio_reverse, ratios.front(), 0.2, "as the first gear");
  add_guess(b, P::gearbox_efficiency, guessed_value(Guess::kEfficiency, s.kind),
            Guess::kEfficiency);
  add_guess(b, P::gearbox_shift_s, guessed_value(Guess::kShift_s, s.kind), Guess::kShift_s);
}

void add_engine(const Basis& b) {
  const DataSheet& s = b.sheet;
  const double most_nm = largest_nm(s), power_radps = s.power_rpm * kPi / 30.0;
  if (s.limit_rpm)
    b.lines.stated(P::engine_limit_radps, limit_radps(s));
  else
    b.lines.guessed(P::engine_limit_radps, limit_radps(s), 0.05,
                    "7 % above the speed of the greatest power");
  add_guess(b, P::engine_inertia_kgm2,
            std::max(0.001, most_nm * guessed_value(Guess::kEngineInertia, s.kind)),
            Guess::kEngineInertia);
  b.lines.guessed(P::engine_idle_radps, 0.15 * power_radps, 0.2,
                  "0.15 of the speed of the greatest power");
  b.lines.guessed(P::engine_idle_gain_nms, most_nm / 200.0, 0.5, "so that it does not stall");
  b.lines.guessed(P::clutch_torque_nm, 1.8 * most_nm, 0.2, "1.8 of the greatest torque");
  b.lines.guessed(P::clutch_begin_radps, 0.25 * power_radps, 0.3,
                  "0.25 of the speed of the greatest power: stands for the driver's foot");
  b.lines.guessed(P::clutch_full_radps, 0.45 * power_radps, 0.3,
                  "0.45 of the speed of the greatest power");
  b.lines.guessed(P::differential_preload_nm, 0.1 * most_nm, 0.5, "a tenth of the torque");
  if (s.turbo)
    b.lines.guessed(P::turbo_share, 0.5, 0.4, "half of the torque comes with the boost");
  else
    b.lines.follows(P::turbo_share, 0.0, "turbo: false");
}

std::string engine_map_text(const DataSheet& sheet) {
  constexpr std::array<std::pair<double, double>, 6> kShape = {
      {{0.0, 0.0}, {0.1, 0.138}, {0.25, 0.336}, {0.5, 0.638}, {0.75, 0.906}, {1.0, 1.0}}};
  std::string out = "engine_radps:throttle";
  for (const auto& [throttle, share] : kShape) out += fmt::format(",{:g}", throttle);
  const double most_nm = largest_nm(sheet), limit = limit_radps(sheet);
  const auto add_row = [&](double radps, double full_nm) {
    const double closed_nm = -most_nm * (0.02 + 0.1 * radps / limit);
    out += fmt::format("\n{:.5g}", radps);
    for (const auto& [throttle, share] : kShape)
      out += fmt::format(",{:.4g}", closed_nm + share * (full_nm - closed_nm));
  };
  if (sheet.torque.front().first > 0.0) add_row(0.0, 0.5 * sheet.torque.front().second);
  for (const auto& [rpm, nm] : sheet.torque) add_row(rpm * kPi / 30.0, nm);
  return out + "\n";
}

}  // namespace vehicle
