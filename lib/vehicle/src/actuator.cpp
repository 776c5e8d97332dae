#include "vehicle/actuator.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "vehicle/error.h"
#include "vehicle/step.h"

namespace vehicle {
namespace {

constexpr double kStep_s = 0.001;
constexpr std::size_t kUnknowns = 4;  // dead time, lag, damping, lead; the gain follows from them
using Unknowns = std::array<double, kUnknowns>;
constexpr double kLeadWorth = 0.99;  // of the sum of squares
constexpr Unknowns kLow{0.0, 0.001, 0.05, -1.0}, kHigh{0.4, 2.0, 20.0, 1.0};

/// The samples on the model's own grid of time.
struct Samples {
  std::vector<double> command;        ///< every kStep_s
  std::vector<std::size_t> step;      ///< of each sample
  const std::vector<double>& output;  ///< measured
};

/// The model's output at the samples, for gain 1.
std::vector<double> simulate(const Samples& samples, const Unknowns& x) {
  laws::Actuator<double> actuator;
  actuator.history.fill(samples.command.front());
  actuator.place = samples.command.front();
  std::vector<double> out;
  out.reserve(samples.step.size());
  std::size_t next = 0;
  for (std::size_t k = 0; k < samples.command.size() && next < samples.step.size(); ++k) {
    const double y = laws::move(actuator, static_cast<std::int64_t>(k), samples.command[k], x[0],
                                x[1], x[2], x[3], kStep_s);
    while (next < samples.step.size() && samples.step[next] == k) {
      out.push_back(y);
      ++next;
    }
  }
  return out;
}

struct Fit {
  double gain = 1.0, sum2 = 0.0;
  Eigen::VectorXd error;
};

/// The gain that fits best, and what is left.
Fit fit(const std::vector<double>& model, const std::vector<double>& output) {
  const Eigen::Map<const Eigen::VectorXd> m(model.data(), static_cast<Eigen::Index>(model.size()));
  const Eigen::Map<const Eigen::VectorXd> y(output.data(),
                                            static_cast<Eigen::Index>(output.size()));
  Fit out;
  const double power = m.squaredNorm();
  out.gain = power > 0.0 ? m.dot(y) / power : 0.0;
  out.error = y - out.gain * m;
  out.sum2 = out.error.squaredNorm();
  return out;
}

Fit fit(const Samples& samples, const Unknowns& x) {
  return fit(simulate(samples, x), samples.output);
}

Unknowns best_of_grid(const Samples& samples) {
  Unknowns best{};
  double least = INFINITY;
  for (const double dead : {0.0, 0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.2})
    for (const double lag : {0.005, 0.015, 0.04, 0.1, 0.3})
      for (const double damping : {0.5, 1.0}) {
        const Unknowns x{dead, lag, damping, 0.0};
        const double sum2 = fit(samples, x).sum2;
        if (sum2 < least) {
          least = sum2;
          best = x;
        }
      }
  return best;
}

/// Levenberg and Marquardt over the first `count` unknowns, differences for the slopes.
Fit descend(const Samples& samples, Unknowns& x, std::size_t count) {
  Fit now = fit(samples, x);
  constexpr Unknowns kDifference{1e-5, 1e-5, 1e-4, 1e-5};
  double caution = 1e-3;
  for (int round = 0; round < 60 && caution < 1e8; ++round) {
    Eigen::MatrixXd slopes(now.error.size(), static_cast<Eigen::Index>(count));
    for (std::size_t i = 0; i < count; ++i) {
      Unknowns near = x;
      const bool up = x[i] + kDifference[i] < kHigh[i];
      near[i] += up ? kDifference[i] : -kDifference[i];
      slopes.col(static_cast<Eigen::Index>(i)) =
          (fit(samples, near).error - now.error) / (near[i] - x[i]);
    }
    const Eigen::MatrixXd normal = slopes.transpose() * slopes;
    Eigen::MatrixXd damped = normal;
    damped.diagonal() += caution * normal.diagonal();
    damped.diagonal().array() += 1e-300;
    const Eigen::VectorXd step = damped.ldlt().solve(-slopes.transpose() * now.error);
    Unknowns next = x;
    for (std::size_t i = 0; i < count; ++i)
      next[i] = std::clamp(x[i] + step(static_cast<Eigen::Index>(i)), kLow[i], kHigh[i]);
    const Fit then = fit(samples, next);
    if (then.sum2 < now.sum2) {
      const bool settled = now.sum2 - then.sum2 < 1e-12 * now.sum2;
      x = next;
      now = then;
      caution = std::max(1e-9, 0.3 * caution);
      if (settled) break;
    } else {
      caution *= 10.0;
    }
  }
  return now;
}

}  // namespace

ArxCoefficients arx_of(const ActuatorModel& model, double step_s) {
  if (model.lag_s <= 0.0) return {0.0, 0.0, 1.0, 0.0};
  const auto m = laws::actuator_transition(model.lag_s, model.damping, step_s);
  const double trace = m.m00 + m.m11, determinant = m.m00 * m.m11 - m.m01 * m.m10;
  // (place, rate) after a step from (0, 0) with command 1, and what is left of it in the next.
  const double place = 1.0 - m.m00, rate = -m.m10;
  const double next_place = (m.m00 - trace) * place + m.m01 * rate;
  const double next_rate = m.m10 * place + (m.m11 - trace) * rate;
  return {trace, -determinant, place + model.lead_s * rate, next_place + model.lead_s * next_rate};
}

ActuatorModel identify_actuator(const std::vector<double>& time_s,
                                const std::vector<double>& command,
                                const std::vector<double>& output) {
  if (time_s.size() < 50 || command.size() != time_s.size() || output.size() != time_s.size())
    throw Error(fmt::format("{} samples, wanted at least 50", time_s.size()));
  for (const auto* values : {&time_s, &command, &output})
    for (const double value : *values)
      if (!std::isfinite(value)) throw Error("a sample is not finite; fill or leave out gaps");
  const auto [low, high] = std::minmax_element(command.begin(), command.end());
  if (!(*high - *low > 1e-9))
    throw Error(fmt::format("the command stays at {}; it has to move", *low));

  Samples samples{{}, {}, output};
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    const auto at = static_cast<std::size_t>(std::lround((time_s[i] - time_s[0]) / kStep_s));
    while (samples.command.size() <= at) {
      const double t = time_s[0] + static_cast<double>(samples.command.size()) * kStep_s;
      const double from = i == 0 ? t : time_s[i - 1], span = i == 0 ? 1.0 : time_s[i] - from;
      const double share = std::clamp((t - from) / span, 0.0, 1.0);
      const double before = i == 0 ? command[0] : command[i - 1];
      samples.command.push_back(before + share * (command[i] - before));
    }
    samples.step.push_back(at);
  }

  // A lead is believed only where it explains what nothing else does: over a narrow band of
  // frequencies it does the same as a dead time.
  const Unknowns begin = best_of_grid(samples);
  Unknowns x = begin;
  Fit now = descend(samples, x, kUnknowns - 1);
  const double bare = now.sum2;
  for (const Unknowns& from : {begin, Unknowns(x)}) {
    Unknowns with_lead = from;
    const Fit better = descend(samples, with_lead, kUnknowns);
    if (better.sum2 < std::min(kLeadWorth * bare, now.sum2)) {
      x = with_lead;
      now = better;
    }
  }
  const auto count = static_cast<double>(output.size());
  return {now.gain,
          x[0],
          x[1],
          x[2],
          x[3],
          std::sqrt(now.sum2 / count),
          std::sqrt(fit(command, output).sum2 / count)};
}

}  // namespace vehicle
