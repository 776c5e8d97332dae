#include "explain/wheels_say.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "selection.h"

namespace explain {
namespace {

/// Share of the driven wheels' speed difference that turning asks for which is not there, beside a
/// part that goes with the speed; none where the car hardly turns.
std::optional<FoundParameter> coupled_share(const Signals& log, double track_m) {
  if (!log.present[kWheelRearDifference] || !log.present[kYawRate]) return std::nullopt;
  const double radius_m = log.wheels_in_mps ? 1.0 : speed_over_wheels(log, kWheelRear);
  Eigen::Matrix4d sums = Eigen::Matrix4d::Zero();
  for (std::size_t i = 0; i < log.n; ++i) {
    const Eigen::Vector4d at(-track_m * log.x[kYawRate][i], log.x[kVx][i], 1.0,
                             radius_m * log.x[kWheelRearDifference][i]);
    if (log.x[kVx][i] > Signals::kRolls_mps && at.allFinite()) sums += at * at.transpose();
  }
  const double count = sums(2, 2);
  const Eigen::Matrix3d asked = sums.topLeftCorner<3, 3>();
  const auto solver = asked.ldlt();
  constexpr double kTurns_mps = 0.02, kAlike = 10.0;  // smoothed, steps say the same for half a s
  const double own = 1 / solver.solve(Eigen::Vector3d::Unit(0))[0];
  if (!(count > 600) || !(own > kTurns_mps * kTurns_mps * count)) return std::nullopt;
  const Eigen::Vector3d fitted = solver.solve(sums.topRightCorner<3, 1>());
  const double left = sums(3, 3) - fitted.dot(sums.topRightCorner<3, 1>());
  const double half = selection::k90 * std::sqrt(kAlike * std::max(0.0, left) / count / own);
  const double share = 1 - fitted[0];
  return FoundParameter{"locked share", "1", share, share - half, share + half};
}

}  // namespace

void say_that_wheels_are_coupled(const Signals& log, const vehicle::Vehicle& car,
                                 Findings& findings) {
  using vehicle::Term;
  constexpr double kLocked = 0.8, kMost = 1.2;
  const auto share = coupled_share(log, car.parameters[vehicle::Parameter::rear_track_m]);
  if (!share || share->low < kLocked || share->high > kMost) return;
  constexpr const char* kEquation = "omega_l - omega_r = -(1 - k) track r / R";
  if (findings.doubtful_car && car.terms[Term::locked_differential] == 0) {
    Finding& f = findings.findings.emplace_back();
    f.mechanism = kCoupledWheels;
    f.kind = "vehicle";
    f.physics = "the driven wheels turn alike, by their speeds and the yaw rate alone";
    f.equation = kEquation;
    f.parameters = {*share};
    f.not_used = "the vehicle file may be that of another car";
    return;
  }
  if (!log.present[kSteer] || log.commanded[kSteer]) return;
  for (Finding& f : findings.findings) {
    if (!is_about(f, kSensorBias) || f.channel != log.column[kSteer] || f.parameters.empty())
      continue;
    const FoundParameter offset = f.parameters.front();
    f.rivals.insert(
        f.rivals.begin(),
        {f.mechanism, f.channel,
         "measure the driven wheels' radii, or roll straight with one of them lifted off "
         "the drive: an offset of the sensor stays",
         f.cv_gain, false});
    f.not_used = fmt::format("an offset of '{}' of {:.2g} {} shows the same", f.channel,
                             offset.value, offset.unit);
    f.mechanism = kCoupledWheels;
    f.kind = "vehicle";
    f.channel = "";
    f.physics =
        "the driven wheels turn alike; of different radius they turn the car all along, as an "
        "offset of its steering does";
    f.equation = kEquation;
    f.parameters = {*share};
  }
}

void take_speeds_of_wheels_as_usual(const Signals& log, Findings& findings) {
  constexpr double kMostGain = 0.03, kMostLate_s = 0.15;
  const std::optional<Channel> wheels = wheels_of_speed(log);
  if (!wheels) return;
  std::string said;
  std::erase_if(findings.findings, [&](const Finding& f) {
    if (f.kind != "sensor" || f.channel != log.column[kVx] || f.parameters.empty()) return false;
    const FoundParameter& p = f.parameters.front();
    const bool of_gain = is_about(f, kSensorGain);
    const bool late = is_about(f, kSensorDelay) || is_about(f, kSensorLowPass);
    if (!(of_gain || late) || std::abs(p.value) > (of_gain ? kMostGain : kMostLate_s)) return false;
    said += fmt::format("{}{} {:.2g} {}", said.empty() ? "" : ", ", p.name, p.value, p.unit);
    return true;
  });
  if (said.empty()) return;
  findings.remarks.push_back(
      fmt::format("'{}' is the speed of '{}': their radius and filter are in it, as is usual "
                  "({}); it is corrected for the analysis and not written back",
                  log.column[kVx], log.column[*wheels], said));
}

}  // namespace explain
