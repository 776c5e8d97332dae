// An actuator: dead time and a transfer function of the second order.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "vehicle/parameters.h"

namespace vehicle::laws {

/// A command on its way through dead time and a second-order transfer function.
template <class T>
struct Actuator {
  static constexpr std::size_t kCapacity = 512;  ///< longest dead time, in steps, plus two
  std::array<T, kCapacity> history{};            ///< ring of commands
  T place = T(0), rate = T(0);                   ///< of the second-order system, rate per second
};

/// What one step of length h makes of (deviation from the command, rate) of an actuator: exact for
/// a command held over the step.
template <class T>
struct Transition {
  T m00, m01, m10, m11;
};

/// Of lag^2 y'' + 2 damping lag y' + y = command. Its trace and determinant are the coefficients of
/// the ARX model that the actuator is at this step.
template <class T>
Transition<T> actuator_transition(const T& lag_s, const T& damping, double step_s) {
  using std::cos;
  using std::exp;
  using std::sin;
  using std::sqrt;
  const T x = step_s / lag_s;
  const T q = (1.0 - damping * damping) * x * x;  // square of the angle turned in a step
  const T fade = damping * x;
  T c, s;  // exp(-fade) cos(sqrt q), exp(-fade) sin(sqrt q) / sqrt q
  if (q < T(0.01) && q > T(-0.01)) {
    const T e = exp(-fade);
    c = e * (1.0 - q / 2.0 * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0))));
    s = e * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0))));
  } else if (q > T(0)) {
    const T e = exp(-fade), angle = sqrt(q);
    c = e * cos(angle);
    s = e * sin(angle) / angle;
  } else {  // two real poles; both exponents are negative, so nothing overflows
    const T angle = sqrt(-q), slow = exp(angle - fade), fast = exp(-angle - fade);
    c = 0.5 * (slow + fast);
    s = 0.5 * (slow - fast) / angle;
  }
  return {c + fade * s, s * step_s, -s * x / lag_s, c - fade * s};
}

/// How an actuator answers, for steps of one length: made once for many of them.
template <class T>
struct Response {
  std::int64_t late = 0;  ///< whole steps of dead time
  T later;                ///< the rest of it, in steps
  T lead_s;
  bool lags;             ///< else nothing but the dead time
  Transition<T> of_lag;  ///< where it lags
};
template <class T>
Response<T> actuator_response(const T& dead_time_s, const T& lag_s, const T& damping,
                              const T& lead_s, double step_s) {
  const T delay = dead_time_s / step_s;
  const auto late = std::min(static_cast<std::int64_t>(value_of(delay)),
                             static_cast<std::int64_t>(Actuator<T>::kCapacity) - 2);
  const bool lags = !(value_of(lag_s) <= 0.0);
  return {late, delay - static_cast<double>(late), lead_s, lags,
          lags ? actuator_transition(lag_s, damping, step_s) : Transition<T>{}};
}

/// What has decayed beyond any meaning is zero: processors are slow with numbers below 2e-308, and
/// not every program reads them.
template <class T>
void flush_to_zero(T& x) {
  if (value_of(x) < 1e-290 && value_of(x) > -1e-290) x = T(0);
}

/// Command to output. `amplitude` 0 is not called: the caller passes the command on.
template <class T>
T move(Actuator<T>& actuator, std::int64_t step, const T& command, const Response<T>& response) {
  constexpr auto kCapacity = static_cast<std::int64_t>(Actuator<T>::kCapacity);
  static_assert((kCapacity & (kCapacity - 1)) == 0);
  const auto ring = [&](std::int64_t back) -> T& {
    return actuator.history[static_cast<std::size_t>((step - back) & (kCapacity - 1))];
  };
  ring(0) = command;
  // A dead time between two steps mixes the two, so that its derivative exists.
  const T& near = ring(response.late);
  const T delayed = near + response.later * (ring(response.late + 1) - near);
  if (!response.lags) {
    actuator.place = delayed;
    actuator.rate = T(0);
  } else {
    const Transition<T>& m = response.of_lag;
    const T away = actuator.place - delayed, rate = actuator.rate;
    actuator.place = delayed + m.m00 * away + m.m01 * rate;
    actuator.rate = m.m10 * away + m.m11 * rate;
    flush_to_zero(actuator.place);
    flush_to_zero(actuator.rate);
  }
  return actuator.place + response.lead_s * actuator.rate;
}

}  // namespace vehicle::laws
