#include "drive.h"

#include <algorithm>
#include <cstdio>

#include "truth_car_electric.h"

namespace trials {
namespace {

constexpr double kStep_s = 0.001;
constexpr long kStepsPerRow = 5;

/// Rolling at 25 m/s over the start line.
State at_start(const TruthCar& car, const Track& track) {
  State x{};
  const Track::Point start = track.at(0);
  x[0] = start.x;
  x[1] = start.y;
  x[2] = start.heading;
  x[3] = 25;
  x[6] = 25 / car.radius_f;
  x[7] = x[8] = 25 / car.radius_r;
  if (car.electric) x[kWheelFr] = x[kWheelFl];
  return x;
}

/// What reaches the wheels, the engine and the brakes of a variant: late, through a lag, scaled.
/// `steer` is that of the millisecond before, and moved on.
Commands arriving(const Variant& v, const std::vector<Commands>& history, double& steer) {
  const auto late = [&](double dead_s) -> const Commands& {
    const auto back = static_cast<std::size_t>(dead_s * 1000 + 0.5);
    return history[history.size() > back ? history.size() - 1 - back : 0];
  };
  Commands used = history.back();
  used.throttle = std::min(1.0, late(v.throttle_dead_s).throttle * v.throttle_gain);
  used.brake_pa = late(v.brake_dead_s).brake_pa;
  const double wanted = late(v.steer_dead_s).steer * v.steer_gain;
  const double pulled = v.steer_lag_s > 0
                            ? steer + (wanted - steer) * (1 - std::exp(-kStep_s / v.steer_lag_s))
                            : wanted;
  steer = std::clamp(steer, pulled - 0.5 * v.steer_play_rad, pulled + 0.5 * v.steer_play_rad);
  used.steer = steer;
  return used;
}

/// A variant under way.
struct Moving {
  const Variant& variant;
  const Track& track;
  State x{};
  double s_m = 0, steer = 0;
  Output o{};
};
Moving start(const Variant& v, const Track& track, const State& x) {
  return {v, v.track != nullptr ? *v.track : track, x};
}

/// Sums of squares over the moments at which two variants are compared.
struct Difference {
  Row sum{};
  double count = 0;
};
void compare(const Moving& one, const Moving& other, Difference& d) {
  const auto add = [&](int channel, double change) {
    d.sum[static_cast<std::size_t>(channel)] += change * change;
  };
  add(kVx, one.x[3] - other.x[3]);
  add(kVy, one.x[4] - other.x[4]);
  add(kR, one.x[5] - other.x[5]);
  add(kYaw, one.x[2] - other.x[2]);
  add(kX, std::hypot(one.x[0] - other.x[0], one.x[1] - other.x[1]));
  add(kWrl, one.x[7] - other.x[7]);
  add(kWrr, one.x[8] - other.x[8]);
  add(kAz, one.o.az - other.o.az);
  d.count += 1;
}

}  // namespace

Drive drive(const Variant& truth, const Track& track, const Style& style, const Variant* other) {
  constexpr long kCompareEvery = 900, kCompareAfter = 450, kLongestLap = 400'000;
  const TruthCar& car = truth.car;
  Drive out;
  Driver driver{Random{style.seed}};
  Moving real = start(truth, track, at_start(car, track));
  Moving twin = start(other != nullptr ? *other : truth, track, real.x);
  long twin_end = -1;
  Difference difference;
  std::vector<Commands> history;
  for (long step = 0;
       step < kLongestLap * style.laps && std::floor(real.s_m / track.length_m) < style.laps;
       ++step) {
    const Commands held = driver.now;
    act(driver, style, car, track, real.x, real.s_m, step);
    history.push_back(driver.now);
    Commands used = arriving(truth, history, real.steer);
    if (driver.between_gears_s > 0) used.gear = 0;
    if (other != nullptr) {
      Commands plain = arriving(*other, history, twin.steer);
      plain.gear = used.gear;
      if (step % kCompareEvery == 0)
        twin.x = real.x, twin.s_m = real.s_m, twin_end = step + kCompareAfter;
      if (twin_end > step)
        advance(other->car, twin.track, twin.x, plain, twin.s_m,
                twin_end == step + 1 ? &twin.o : nullptr);
    }
    const State before = real.x;
    advance(car, real.track, real.x, used, real.s_m, &real.o);
    if (other != nullptr && twin_end == step + 1) compare(real, twin, difference);
    if (step % kStepsPerRow == 0) {
      // A logger takes the mean about its time of what is held from one act to the next.
      Commands mean = driver.now;
      mean.steer = 0.5 * (held.steer + mean.steer);
      mean.throttle = 0.5 * (held.throttle + mean.throttle);
      mean.brake_pa = 0.5 * (held.brake_pa + mean.brake_pa);
      out.row.push_back(
          row_of(car, static_cast<double>(step) * kStep_s, before, real.o, mean, used.gear));
    }
    if (!std::isfinite(real.x[3]) || std::abs(real.o.v) > 7) {
      std::fprintf(stderr, "the truth car left the road at s = %.0f m\n", real.s_m);
      out.row.clear();
      break;
    }
  }
  for (std::size_t k = 0; k < kChannels; ++k)
    if (difference.count > 0 && kNoise[k] > 0) {
      out.channel_size[k] = std::sqrt(difference.sum[k] / difference.count) / kNoise[k];
      out.size = std::max(out.size, out.channel_size[k]);
    }
  out.lap_s = static_cast<double>(out.row.size()) * kRow_s / style.laps;
  return out;
}

}  // namespace trials
