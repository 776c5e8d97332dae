#include "vehicle/poles.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "vehicle/driver.h"
#include "vehicle/error.h"
#include "vehicle/step_swing.h"

namespace vehicle {
namespace {

using Matrix = Eigen::MatrixXd;

/// Between these the largest stable step is looked for, s.
constexpr double kShortestStep = 2e-4, kLongestStep = 0.01;
constexpr double kWatched_s = 0.5;

template <class F>
Matrix jacobian(const State<double>& at, F&& f) {
  Matrix out(kStateSize, kStateSize);
  for (std::size_t j = 0; j < kStateSize; ++j) {
    State<double> up = at, down = at;
    up[j] += kStates[j].small;
    down[j] -= kStates[j].small;
    const State<double> a = f(up), b = f(down);
    for (std::size_t i = 0; i < kStateSize; ++i)
      out(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          (a[i] - b[i]) / (up[j] - down[j]);
  }
  return out;
}

/// Eigenvalues of the rates, the fastest first.
std::vector<Pole> poles_of(const Matrix& rates) {
  std::vector<Pole> out;
  const Eigen::VectorXcd poles = Eigen::EigenSolver<Matrix>(rates, false).eigenvalues();
  for (Eigen::Index i = 0; i < poles.size(); ++i) {
    const double re = poles(i).real(), im = poles(i).imag(), size2 = std::norm(poles(i));
    Pole pole{re, im, 0.0};
    pole.euler_step_s =
        size2 < 1e-12 ? std::numeric_limits<double>::infinity() : std::max(0.0, -2.0 * re / size2);
    out.push_back(pole);
  }
  std::sort(out.begin(), out.end(), [](const Pole& a, const Pole& b) {
    return std::hypot(a.real_1ps, a.imaginary_radps) > std::hypot(b.real_1ps, b.imaginary_radps);
  });
  return out;
}

}  // namespace

Linearisation linearise(const Car<double>& car, double speed_mps,
                        const std::vector<double>& steps_s) {
  const Road road;
  StartOptions begin;
  begin.speed_mps = speed_mps;
  begin.gear = speed_mps < 3.0 ? 0 : choose_gear(car, speed_mps, kMostGears);
  Simulation<double> sim = start(car, road, begin);
  Detail<double> detail;
  Controls<double> controls;
  controls.gear_command = begin.gear;
  for (int i = 0; i < 2000; ++i) {
    controls.throttle_command =
        begin.gear == 0 ? 0.0 : std::clamp(0.3 + 0.5 * (speed_mps - sim.state[kVx]), 0.0, 1.0);
    const StepResult result = step(car, sim, controls, road, {}, detail);
    if (!result.ok()) throw Error(describe(result, sim.time_s, sim.state[kX], sim.state[kY]));
  }
  const Inputs<double> in = detail.inputs;
  RoadCursors cursors;
  const auto rates = [&](const State<double>& s) {
    State<double> out;
    Detail<double> scratch;
    derivative(car, s, in, road, cursors, out, scratch);
    return out;
  };
  Linearisation out;
  out.speed_mps = sim.state[kVx];
  out.poles = poles_of(jacobian(sim.state, rates));
  const auto largest_eigenvalue = [&](double h, Integrator integrator) {
    const auto one_step = [&](const State<double>& s) {
      State<double> next = s, rate;
      Detail<double> scratch;
      derivative(car, s, in, road, cursors, rate, scratch);
      settle_frictions(car, h, rate, scratch);
      if (car.files->turbo == Turbo::kFull) settle_air(h, rate, scratch);
      integrate(car, next, rate, scratch, {h, integrator});
      return next;
    };
    const Eigen::VectorXcd values =
        Eigen::EigenSolver<Matrix>(jacobian(sim.state, one_step), false).eigenvalues();
    double largest = 0.0;
    for (Eigen::Index i = 0; i < values.size(); ++i)
      if (std::abs(values(i) - 1.0) > 1e-3) largest = std::max(largest, std::abs(values(i)));
    return largest;
  };
  const auto step_swing = [&](double h, Integrator integrator) {
    Simulation<double> own = sim;
    Detail<double> scratch = detail;
    Controls<double> held = controls;
    StepSwing swing;
    const StepOptions options{h, integrator};
    for (int i = 0; i < static_cast<int>(kWatched_s / h); ++i) {
      const State<double> before = own.state;
      if (begin.gear != 0)
        held.throttle_command = std::clamp(0.3 + 0.5 * (speed_mps - before[kVx]), 0.0, 1.0);
      if (!step(car, own, held, road, options, scratch).ok())
        return std::numeric_limits<double>::infinity();
      swing.look(car, before, scratch);
    }
    return swing.largest();
  };
  for (const double h : steps_s)
    out.radii.push_back({h, largest_eigenvalue(h, Integrator::kExplicitEuler),
                         largest_eigenvalue(h, Integrator::kSemiImplicit),
                         step_swing(h, Integrator::kExplicitEuler),
                         step_swing(h, Integrator::kSemiImplicit)});
  out.euler_step_s = kLongestStep;
  for (double h = kShortestStep; h < kLongestStep; h *= 1.05)
    if (largest_eigenvalue(h, Integrator::kExplicitEuler) > 1.0) {
      out.euler_step_s = h / 1.05;
      break;
    }
  return out;
}

}  // namespace vehicle
