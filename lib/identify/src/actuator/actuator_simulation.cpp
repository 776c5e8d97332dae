#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "actuator_parts.h"

namespace identify {
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
