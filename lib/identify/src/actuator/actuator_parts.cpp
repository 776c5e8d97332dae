#include "actuator_parts.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <unsupported/Eigen/MatrixFunctions>

#include "base/error.h"

namespace identify {
namespace {

constexpr std::size_t kFewest = 50, kMost = 200000;

/// The block of each row: the command moves as much in each, so that each has its say; a tenth of
/// the measure is time. -1: not judged.
void cut_into_blocks(Record& record) {
  const std::size_t rows = record.command.size();
  const auto skipped = std::min(rows / 10, static_cast<std::size_t>(1.0 / record.step_s));
  const double count = std::clamp(static_cast<double>(rows - skipped) / 10.0, 4.0, 60.0);
  double moved = 0.0, whole = 0.0;
  const auto step = [&](std::size_t i) {
    return std::abs(record.command[i] - record.command[i - 1]);
  };
  for (std::size_t i = std::max<std::size_t>(1, skipped); i < rows; ++i) whole += step(i);
  for (std::size_t i = 0; i < rows; ++i) {
    if (i > 0 && i >= skipped && whole > 0.0) moved += step(i) / whole;
    const double time =
        static_cast<double>(i - std::min(i, skipped)) / static_cast<double>(rows - skipped);
    const double share = whole > 0.0 ? 0.9 * moved + 0.1 * time : time;
    record.block.push_back(
        i < skipped ? -1 : static_cast<int>(std::min(count - 1.0, std::floor(count * share))));
  }
  record.blocks = static_cast<int>(count);
}

}  // namespace

Record record_of(const std::vector<double>& time_s, const std::vector<double>& command,
                 const std::vector<double>& movement) {
  if (time_s.size() < kFewest || command.size() != time_s.size() ||
      movement.size() != time_s.size())
    throw base::Error(fmt::format("{} rows, wanted at least {}", time_s.size(), kFewest));
  for (const auto* values : {&time_s, &command, &movement})
    for (const double value : *values)
      if (!std::isfinite(value)) throw base::Error("a value is not finite; fill or leave out gaps");
  const auto range = [](const std::vector<double>& values) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    return *high - *low;
  };
  const double command_range = range(command);
  if (!(command_range > 1e-9))
    throw base::Error(fmt::format("the command stays at {}; it has to move", command.front()));
  if (!(range(movement) > 1e-12))
    throw base::Error(fmt::format("the movement stays at {}; it has to move", movement.front()));
  const std::size_t rows = std::min(kMost, time_s.size());
  Record out;
  out.command_range = command_range;
  out.step_s = (time_s[rows - 1] - time_s[0]) / static_cast<double>(rows - 1);
  if (!(out.step_s > 0.0)) throw base::Error("time does not ascend");
  bool even = true;
  for (std::size_t i = 0; i < rows; ++i)
    if (std::abs(time_s[i] - time_s[0] - static_cast<double>(i) * out.step_s) > 0.1 * out.step_s)
      even = false;
  if (even) {
    out.command.assign(command.begin(), command.begin() + static_cast<std::ptrdiff_t>(rows));
    out.movement.assign(movement.begin(), movement.begin() + static_cast<std::ptrdiff_t>(rows));
  } else {
    std::size_t at = 0;
    for (std::size_t i = 0; i < rows; ++i) {
      const double t = time_s[0] + static_cast<double>(i) * out.step_s;
      while (at + 2 < rows && time_s[at + 1] < t) ++at;
      const double share = std::clamp((t - time_s[at]) / (time_s[at + 1] - time_s[at]), 0.0, 1.0);
      out.command.push_back(command[at] + share * (command[at + 1] - command[at]));
      out.movement.push_back(movement[at] + share * (movement[at + 1] - movement[at]));
    }
  }
  cut_into_blocks(out);
  const auto judged =
      std::find_if(out.block.begin(), out.block.end(), [](int b) { return b >= 0; });
  if (!(range({out.command.begin() + (judged - out.block.begin()), out.command.end()}) > 1e-9))
    throw base::Error(
        "the command moves in the first second or tenth of the record only, which is not judged");
  return out;
}

bool in_steps(const std::vector<double>& command) {
  double first = 0.0, second = 0.0;
  for (std::size_t i = 2; i < command.size(); ++i) {
    first += std::pow(command[i] - command[i - 1], 2);
    second += std::pow(command[i] - 2.0 * command[i - 1] + command[i - 2], 2);
  }
  return second > 1.2 * first;
}

namespace {

using Matrix = Eigen::Matrix<double, 5, 5>;
using State = Eigen::Vector3d;

/// x' = A x + B u, movement = C x + D u, with gain 1.
struct System {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  State b = State::Zero(), c = State::Zero();
  double d = 0.0;
};

System system_of(const ActuatorOrder& order, const ActuatorValues& values) {
  System out;
  if (order.poles == 0) {
    out.d = 1.0;
    return out;
  }
  const double lag = std::exp(values[kLag]), damping = std::exp(values[kDamping]),
               lag2 = std::exp(values[kLag2]), lead = order.zero ? values[kLead] : 0.0;
  if (order.poles == 1) {
    out.a(0, 0) = -1.0 / lag2;
    out.b(0) = 1.0 / lag2;
  } else {  // the rate is kept times the lag, which keeps the matrix balanced
    out.a(0, 1) = 1.0 / lag;
    out.a(1, 0) = -1.0 / lag;
    out.a(1, 1) = -2.0 * damping / lag;
    if (order.poles == 2) {
      out.b(1) = 1.0 / lag;
    } else {
      out.a(1, 2) = 1.0 / lag;
      out.a(2, 2) = -1.0 / lag2;
      out.b(2) = 1.0 / lag2;
    }
  }
  out.c = lead * out.a.row(0).transpose();
  out.c(0) += 1.0;
  out.d = lead * out.b(0);
  return out;
}

/// What `span_s` makes of the state with a command of value u at its begin and a slope.
struct Piece {
  Eigen::Matrix3d state;
  State value, slope;
};

Piece piece_of(const System& system, double span_s) {
  Matrix m = Matrix::Zero();
  m.topLeftCorner<3, 3>() = system.a;
  m.block<3, 1>(0, 3) = system.b;
  m(3, 4) = 1.0;
  const Matrix e = (m * span_s).exp();
  return {e.topLeftCorner<3, 3>(), e.block<3, 1>(0, 3), e.block<3, 1>(0, 4)};
}

}  // namespace

std::vector<int> unknowns_of(const ActuatorOrder& order) {
  std::vector<int> out{kDead};
  if (order.poles >= 2) out.insert(out.end(), {kLag, kDamping});
  if (order.poles == 1 || order.poles == 3) out.push_back(kLag2);
  if (order.zero && order.poles > 0) out.push_back(kLead);
  if (order.play) out.push_back(kPlay);
  return out;
}

std::vector<double> simulate(const ActuatorOrder& order, const ActuatorValues& values, Hold hold,
                             double step_s, const std::vector<double>& command) {
  const System system = system_of(order, values);
  const auto count = static_cast<std::ptrdiff_t>(command.size());
  const double delay = values[kDead] / step_s;
  const auto whole = static_cast<std::ptrdiff_t>(std::floor(delay));
  const double part = delay - static_cast<double>(whole);
  const auto at = [&](std::ptrdiff_t k) {
    return command[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(k, 0, count - 1))];
  };
  const Piece before = piece_of(system, part * step_s),
              after = piece_of(system, (1.0 - part) * step_s);
  const double first = command.front();
  // At rest: places at the command, rates zero.
  State x(first, 0.0, order.poles == 3 ? first : 0.0);
  if (order.poles == 0) x.setZero();
  const bool line = hold == Hold::kLine;
  const double half_play = order.play ? 0.5 * values[kPlay] : 0.0;
  double held = first;
  std::vector<double> out;
  out.reserve(command.size());
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    const double old = at(k - whole - 1), now = at(k - whole), next = at(k - whole + 1);
    const double input = line ? now - part * (now - old) : (part > 0.0 ? old : now);
    const double moved = system.c.dot(x) + system.d * input;
    held = std::clamp(held, moved - half_play, moved + half_play);
    out.push_back(held);
    x = before.state * x + before.value * input;
    if (line) x += before.slope * ((now - old) / step_s);
    x = after.state * x + after.value * now;
    if (line) x += after.slope * ((next - now) / step_s);
  }
  return out;
}

}  // namespace identify
