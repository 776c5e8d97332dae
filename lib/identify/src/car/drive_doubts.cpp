#include "drive_doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/statistics.h"
#include "longitudinal.h"
#include "recording/channels.h"

namespace identify {
namespace {

using P = vehicle::Parameter;
constexpr double kRadiusOff = 0.05;   ///< no owner states a rolling radius further off
constexpr double kAxOff = 0.15;       ///< of ax_mps2 against the change of vx_mps
constexpr double kStraight_mps2 = 3;  ///< more of it is turning
constexpr double kLeastWindows = 20;
constexpr std::size_t kLeastRatios = 10;  ///< each of them tells the radius within a per cent

bool straight(const DriveWindow& w) {
  return !(std::abs(w.yaw_rate_radps * w.vx_mps) > kStraight_mps2);
}

void doubt_radius(const vehicle::Car<double>& car, const DriveWindows& drive,
                  std::vector<std::string>& out) {
  vehicle::CarFiles files = *car.files;
  files.fx_arm = vehicle::FxArm::kRollingRadius;
  vehicle::Car<double> rolling = car;
  rolling.files = &files;
  std::vector<double> shares;
  for (const DriveWindow& w : drive.windows) {
    const double turns = 0.5 * (w.wheel_radps[0] + w.wheel_radps[1]);
    if (braked(w, kUnbraked_pa) || !straight(w) || !(turns > 0.0)) continue;
    const double radius = force_arm(rolling, w, 0, car.parameters[P::chassis_mass_kg]);
    shares.push_back(w.vx_mps / (turns * radius) - 1.0);
  }
  if (shares.size() < kLeastRatios) return;
  const double off = base::median(shares);
  if (std::abs(off) > kRadiusOff)
    out.push_back(
        fmt::format("speed and front wheel speeds say a rolling radius {:+.1f} % off the vehicle "
                    "file's: vx_mps "
                    "or wheel speeds in another unit, or another car's tyres",
                    100.0 * off));
}

void doubt_ax(const DriveWindows& drive, std::vector<std::string>& out) {
  Pairs pairs;
  for (const DriveWindow& w : drive.windows)
    if (straight(w)) pairs.add(w.speeding_mps2, w.along_mps2);
  if (pairs.n < kLeastWindows || pairs.variance() < 0.25) return;
  const double low = pairs.slope(), high = pairs.steepest();
  if (std::max(low, high) < 1.0 - kAxOff || std::min(low, high) > 1.0 + kAxOff)
    out.push_back(fmt::format(
        "ax_mps2 is {:.3g} times the change of vx_mps: a sign, a filter, or another unit of one of "
        "them",
        pairs.slope()));
}

void doubt_travels(const DriveWindows& drive, std::vector<std::string>& out) {
  for (std::size_t i = 0; i < vehicle::kWheels; ++i) {
    Pairs pairs;
    for (const DriveWindow& w : drive.windows) pairs.add(w.travel_m[i], w.load_n[i]);
    if (pairs.n >= kLeastWindows && pairs.correlation() < -0.3 - 3.0 / std::sqrt(pairs.n))
      out.push_back(
          fmt::format("suspension_{0}_m falls as fz_{0}_n rises: compressed is positive; scale: -1 "
                      "in a mapping turns it",
                      recording::kWheelNames[i]));
  }
}

}  // namespace

std::vector<std::string> drive_doubts(const vehicle::Car<double>& car, const DriveWindows& drive,
                                      bool by_ax) {
  std::vector<std::string> out;
  doubt_radius(car, drive, out);
  if (by_ax) doubt_ax(drive, out);
  doubt_travels(drive, out);
  return out;
}

DriveWindows with_wheelbase(DriveWindows drive, const recording::Recording& recording) {
  constexpr double kMostLeft_mps2 = 6.0;
  const std::vector<double>* const steer = recording.table.find("steer_rad");
  if (steer == nullptr) return drive;
  Equation e;
  std::vector<std::size_t> block;
  for (const DriveWindow& w : drive.windows) {
    const double left = w.yaw_rate_radps * w.vx_mps;
    double sum = 0.0;
    for (std::size_t k = w.begin_row; k < w.end_row; ++k) sum += (*steer)[k];
    if (!std::isfinite(sum) || !(std::abs(left) < kMostLeft_mps2)) continue;
    e.add({w.yaw_rate_radps / w.vx_mps, left, 1.0},
          sum / static_cast<double>(w.end_row - w.begin_row));
    block.push_back(w.block);
  }
  if (static_cast<double>(block.size()) < kLeastWindows) return drive;
  if (const auto fit = clustered_fit({e}, block)) {
    drive.wheelbase_m = fit->value[0];
    drive.wheelbase_sd_m = fit->sd(0);
  }
  return drive;
}

double wheelbase_off(const vehicle::Car<double>& car, const DriveWindows& drive) {
  constexpr double kTold = 0.06;  // what differentials and toe may add to the steering
  const double stated_m = car.parameters[P::chassis_wheelbase_m],
               off_m = drive.wheelbase_m - stated_m;
  const bool clear = std::abs(off_m) > kTold * stated_m + 2.5 * drive.wheelbase_sd_m;
  return clear ? off_m / stated_m : 0.0;
}

}  // namespace identify
