// A small autonomous-driving stack: it knows the messages of `crgsim serve` (docs/crgsim.md) and a
// line on the map, nothing else of Kerbstone. Where it is it makes out of a receiver, the turning
// rate and the wheels' speed, as sensors tell them (devices.yaml). It drives one lap.
//   stack SOCKET LINE.csv [json|binary]
//   stack DOMAIN LINE.csv dds [PREFIX of the topics]
// LINE.csv: x_m,y_m and what else `crgbuild export ROAD -o LINE.csv` writes; or x_m,y_m,speed_mps,
// with the speed that is wanted. Prints the lap's time and the largest distance from the line; exit
// code 0 when the lap was driven within 5 m of it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "connection.h"

namespace {

using stack::Command;
using stack::Measured;

constexpr double kSpacing_m = 1.0, kWheelbase_m = 3.0;
constexpr double kPlanned_m = 2.0;  // from one point of what is told of the way to the next
constexpr double kLateral_mps2 = 6.0, kBraking_mps2 = 5.0, kSpeeding_mps2 = 3.0,
                 kFastest_mps = 45.0;
constexpr std::array kGearUp_mps{12.0, 19.0, 27.0, 35.0, 44.0};

struct Line {
  std::vector<double> x_m, y_m, speed_mps;
  std::size_t size() const { return x_m.size(); }
};

/// About a metre apart, closed, with the speed that curvature and brakes allow.
Line read_line(const std::string& path) {
  std::ifstream file(path);
  std::string row;
  std::getline(file, row);
  const bool has_speed = row.starts_with("x_m,y_m,speed_mps");
  Line line;
  while (std::getline(file, row)) {
    std::istringstream cells(row);
    double x_m = 0.0, y_m = 0.0, speed_mps = kFastest_mps;
    char comma = 0;
    if (!(cells >> x_m >> comma >> y_m) || (has_speed && !(cells >> comma >> speed_mps)))
      throw std::runtime_error(path + ": x_m,y_m wanted");
    if (!line.x_m.empty() && std::hypot(x_m - line.x_m.back(), y_m - line.y_m.back()) < kSpacing_m)
      continue;
    line.x_m.push_back(x_m);
    line.y_m.push_back(y_m);
    line.speed_mps.push_back(speed_mps);
  }
  const std::size_t n = line.size();
  if (n < 50) throw std::runtime_error(path + ": too short for a lap");
  if (has_speed) return line;
  constexpr std::size_t kAround = 6;
  for (std::size_t i = 0; i < n; ++i) {  // circle through three points
    const std::size_t a = (i + n - kAround) % n, b = (i + kAround) % n;
    const double ux = line.x_m[i] - line.x_m[a], uy = line.y_m[i] - line.y_m[a];
    const double wx = line.x_m[b] - line.x_m[i], wy = line.y_m[b] - line.y_m[i];
    const double curvature_1pm =
        2.0 * std::abs(ux * wy - uy * wx) /
        (std::hypot(ux, uy) * std::hypot(wx, wy) * std::hypot(ux + wx, uy + wy));
    line.speed_mps[i] = std::min(kFastest_mps, std::sqrt(kLateral_mps2 / (curvature_1pm + 1e-6)));
  }
  for (std::size_t k = 2 * n; k-- > 0;)  // brakes, over the seam
    line.speed_mps[k % n] = std::min(
        line.speed_mps[k % n],
        std::sqrt(std::pow(line.speed_mps[(k + 1) % n], 2) + 2.0 * kBraking_mps2 * kSpacing_m));
  for (std::size_t k = 0; k < 2 * n; ++k)
    line.speed_mps[(k + 1) % n] =
        std::min(line.speed_mps[(k + 1) % n],
                 std::sqrt(std::pow(line.speed_mps[k % n], 2) + 2.0 * kSpeeding_mps2 * kSpacing_m));
  return line;
}

struct Pose {
  double x_m = 0.0, y_m = 0.0, yaw_rad = 0.0, vx_mps = 0.0;
};

/// Goes on by turning rate and speed, and is drawn to where the receiver says that it was.
class Localisation {
 public:
  Localisation(const Pose& begin, double time_s) : pose_(begin), time_s_(time_s) {}

  const Pose& follow(const Measured& now) {
    const double dt_s = now.time_s - time_s_;
    time_s_ = now.time_s;
    pose_.vx_mps = now.vx_mps;
    pose_.yaw_rad += now.yaw_rate_radps * dt_s;
    pose_.x_m += std::cos(pose_.yaw_rad) * now.vx_mps * dt_s;
    pose_.y_m += std::sin(pose_.yaw_rad) * now.vx_mps * dt_s;
    past_.push_back({time_s_, pose_});
    if (past_.size() > 1000) past_.erase(past_.begin());
    if (now.gnss_age_s < age_s_ + dt_s - 1e-6) correct(now);
    age_s_ = now.gnss_age_s;
    return pose_;
  }

 private:
  static constexpr double kToPlace = 0.15, kToHeading = 0.04;

  void correct(const Measured& now) {
    std::size_t then = past_.size() - 1;
    while (then > 0 && past_[then].time_s > now.time_s - now.gnss_age_s + 1e-6) --then;
    const double ex_m = now.gnss_x_m - past_[then].pose.x_m,
                 ey_m = now.gnss_y_m - past_[then].pose.y_m;
    const double left_m = -std::sin(pose_.yaw_rad) * ex_m + std::cos(pose_.yaw_rad) * ey_m;
    const double turn_rad = now.vx_mps > 3.0 ? kToHeading * left_m / now.vx_mps : 0.0;
    pose_.yaw_rad += turn_rad;
    pose_.x_m += kToPlace * ex_m;
    pose_.y_m += kToPlace * ey_m;
    for (auto& [time_s, pose] : past_) pose.x_m += kToPlace * ex_m, pose.y_m += kToPlace * ey_m;
  }

  struct Past {
    double time_s;
    Pose pose;
  };
  std::vector<Past> past_;
  Pose pose_;
  double time_s_ = 0.0, age_s_ = 0.0;
};

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

/// What is remembered from one command to the next.
struct Driving {
  double gear = 1.0, held_throttle = 0.0;
};

/// Towards a point ahead on the line, at the line's speed.
Command control(const Line& line, std::size_t at, const Pose& car, Driving& driving) {
  const double ahead_m = 4.0 + 0.35 * car.vx_mps;
  const std::size_t aim = (at + static_cast<std::size_t>(ahead_m / kSpacing_m)) % line.size();
  const double dx_m = line.x_m[aim] - car.x_m, dy_m = line.y_m[aim] - car.y_m;
  const double bearing_rad = wrapped(std::atan2(dy_m, dx_m) - car.yaw_rad);
  const double steer_rad =
      std::atan2(2.0 * kWheelbase_m * std::sin(bearing_rad), std::hypot(dx_m, dy_m));
  const std::size_t soon = (at + static_cast<std::size_t>(0.3 * car.vx_mps)) % line.size();
  const double slow_mps = line.speed_mps[soon] - car.vx_mps;
  driving.held_throttle =
      slow_mps < -1.0 ? 0.0 : std::clamp(driving.held_throttle + 0.002 * slow_mps, 0.0, 0.8);
  const double throttle = std::clamp(0.25 * slow_mps + driving.held_throttle, 0.0, 1.0);
  const double brake_pa = 6e5 * std::clamp(-slow_mps - 0.3, 0.0, 5.0);
  double& gear = driving.gear;
  const auto next = static_cast<std::size_t>(gear) - 1;
  if (next < kGearUp_mps.size() && car.vx_mps > kGearUp_mps[next]) ++gear;
  if (next > 0 && car.vx_mps < kGearUp_mps[next - 1] - 2.0) --gear;
  return {std::clamp(steer_rad, -0.4, 0.4),
          throttle,
          brake_pa,
          brake_pa,
          0.6 * brake_pa,
          0.6 * brake_pa,
          gear};
}

/// The line ahead, as far as three seconds take, at its speed.
stack::Plan plan_of(const Line& line, std::size_t at, const Pose& car) {
  stack::Plan plan;
  const std::size_t points = 10 + static_cast<std::size_t>(3.0 * car.vx_mps / kPlanned_m);
  for (std::size_t k = 0; k < points; ++k) {
    const std::size_t i =
        (at + k * static_cast<std::size_t>(kPlanned_m / kSpacing_m)) % line.size();
    plan.push_back({line.x_m[i], line.y_m[i], line.speed_mps[i]});
  }
  return plan;
}

int drive(const std::string& where, const std::string& line_path, const std::string& form,
          const std::string& prefix) {
  const Line line = read_line(line_path);
  const stack::Exchange exchange = form == "dds"
                                       ? stack::exchange_by_dds(std::stoi(where), prefix)
                                       : stack::exchange_by_socket(where, form == "binary");
  Driving driving;
  double largest_off_m = 0.0;
  // A second on the brakes, for a mean place; it stands along the line.
  const Command stand{0, 0, 2e6, 2e6, 2e6, 2e6, 1};
  Measured now;
  Pose car;
  constexpr int kFirst = 100;
  for (int k = 0; k < kFirst; ++k) {
    now = exchange(stand, {}, false);
    car.x_m += now.gnss_x_m / kFirst;
    car.y_m += now.gnss_y_m / kFirst;
  }
  std::size_t at = 0, gone = 0, commands = 0;
  for (std::size_t i = 0; i < line.size(); ++i)
    if (std::hypot(line.x_m[i] - car.x_m, line.y_m[i] - car.y_m) <
        std::hypot(line.x_m[at] - car.x_m, line.y_m[at] - car.y_m))
      at = i;
  const std::size_t next = (at + 3) % line.size();
  car.yaw_rad = std::atan2(line.y_m[next] - line.y_m[at], line.x_m[next] - line.x_m[at]);
  Localisation localisation(car, now.time_s);
  while (gone < line.size()) {
    const auto off_m = [&](std::size_t i) {
      return std::hypot(line.x_m[i % line.size()] - car.x_m, line.y_m[i % line.size()] - car.y_m);
    };
    while (off_m(at + 1) < off_m(at)) at = (at + 1) % line.size(), ++gone;
    largest_off_m = std::max(largest_off_m, off_m(at));
    if (largest_off_m > 5.0) {
      std::printf("off the line by %.1f m after %.1f s\n", largest_off_m, now.time_s);
      exchange(stand, {}, true);
      return 1;
    }
    // Others who watch see what it is going to do, ten times a second.
    const bool tells = commands++ % 10 == 0;
    now = exchange(control(line, at, car, driving), tells ? plan_of(line, at, car) : stack::Plan{},
                   false);
    car = localisation.follow(now);
  }
  std::printf("lap in %.2f s, as it believes at most %.2f m from the line\n", now.time_s,
              largest_off_m);
  exchange(stand, {}, true);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3 || argc > 5) {
    std::fputs(
        "usage: stack SOCKET LINE.csv [json|binary], or stack DOMAIN LINE.csv dds [PREFIX]\n",
        stderr);
    return 2;
  }
  try {
    return drive(argv[1], argv[2], argc >= 4 ? argv[3] : "json", argc == 5 ? argv[4] : "");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "stack: %s\n", error.what());
    return 1;
  }
}
