#include "explain/model.h"

#include <algorithm>
#include <cmath>

#include "not_known.h"

namespace explain {
namespace {

double positive(double x) { return x > 0 ? x : 0.0; }

}  // namespace

std::vector<double> lagged(const std::vector<double>& x, double time_s) {
  if (time_s <= 0) return x;
  std::vector<double> out(x.size(), kNaN);
  const double keep = std::exp(-Signals::kStep_s / time_s);
  double state = kNaN, last = kNaN;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i])) continue;
    const double behind = std::isfinite(last) ? time_s * (x[i] - last) / Signals::kStep_s
                                              : 0.0;  // of a ramp, once settled
    state = std::isfinite(state) ? x[i] - behind + keep * (state - last + behind) : x[i];
    last = x[i];
    out[i] = state;
  }
  return out;
}

Acting& Setting::acting(const Effect& effect) {
  for (Acting& a : effects)
    if (a.effect == &effect) return a;
  effects.push_back({.effect = &effect});
  return effects.back();
}

void Setting::act(const Effect& effect, double amount, const std::array<double, 2>& constant) {
  Acting& a = acting(effect);
  a.amount[0] += amount;
  a.constant = constant;
}

const std::array<RelationInfo, kRelationCount>& relations() {
  static const std::array<RelationInfo, kRelationCount> list{
      {{"yaw_rate", "rad/s", true},
       {"course", "rad", true},
       {"speed", "m/s", true},
       {"front_wheels", "m/s", true},
       {"rear_wheels", "m/s", false},
       {"ax", "m/s2", true},
       {"ay", "m/s2", true},
       {"az", "m/s2", true},
       {"force_x", "m/s2", false},
       {"force_y", "m/s2", false},
       {"yaw_moment", "rad/s2", false},
       {"load_front", "N/kg", false},
       {"load_rear", "N/kg", false},
       {"rear_wheel_difference", "m/s", false},
       {"steering", "rad", true},
       {"throttle", "1", true},
       {"brake", "Pa", true}}};
  return list;
}

Regimes regimes(const Signals& s) {
  Regimes out;
  for (auto* v : {&out.speed, &out.ax, &out.ay, &out.throttle, &out.brake}) v->assign(s.n, kNaN);
  for (std::size_t i = 0; i < s.n; ++i) {
    out.speed[i] = s.x[kVx][i];
    out.ax[i] = s.dx[kVx][i];
    out.ay[i] = s.x[kVx][i] * (s.present[kYawRate] ? s.x[kYawRate][i] : s.dx[kYaw][i]);
    out.throttle[i] = s.x[kThrottle][i];
    out.brake[i] = s.present[kBrakeFront] ? positive(s.x[kBrakeFront][i]) : 0.0;
  }
  return out;
}

}  // namespace explain
