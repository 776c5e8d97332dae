#include "refit_car.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "engine_and_brakes.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
using Eigen::Index;

/// One amount that is refitted, 0 at the stated car.
struct Free {
  std::vector<P> factor{};  ///< parameters that grow by this share
  int shape = -1;           ///< of the engine map
  P plus = P::kCount;       ///< a parameter that grows by this much
  double width = 0.1;       ///< one standard deviation of the prior
  double move = 0.03;       ///< of the derivative
};

std::vector<Free> free_amounts(const vehicle::Vehicle& car) {
  std::vector<Free> out;
  for (const std::vector<P>& together :
       std::vector<std::vector<P>>{{P::engine_torque},
                                   {P::aero_drag_area_m2},
                                   brake_strength(car),
                                   {P::front_tyre_cornering_stiffness},
                                   {P::rear_tyre_cornering_stiffness},
                                   {P::front_tyre_grip},
                                   {P::rear_tyre_grip}})
    out.push_back(
        {.factor = together,
         .width = std::max(0.01, 0.5 * car.prior[static_cast<std::size_t>(together.front())])});
  for (int k = 0; k < 4; ++k) out.push_back({.shape = k, .width = 0.08});
  // What happens between two gears is stated by hardly anyone: both are as good as unknown.
  out.push_back({.factor = {P::gearbox_shift_s}, .width = 0.3, .move = 0.2});
  out.push_back({.plus = P::gearbox_rev_match, .width = 1.0, .move = 0.3});
  return out;
}

RefittedCar with(const vehicle::Vehicle& car, const std::vector<Free>& free,
                 const Eigen::VectorXd& amount) {
  RefittedCar out{car.parameters, car.files.engine_torque_nm, {}, {}};
  std::array<double, 4> shape{};
  for (std::size_t j = 0; j < free.size(); ++j) {
    const double x = amount[static_cast<Index>(j)];
    for (const P p : free[j].factor) out.parameters[p] *= 1 + x;
    if (free[j].plus != P::kCount) out.parameters[free[j].plus] += x;
    if (free[j].shape >= 0) shape[static_cast<std::size_t>(free[j].shape)] = x;
  }
  for (const vehicle::ParameterInfo& info : vehicle::parameter_list()) {
    double& value = out.parameters[*vehicle::find_parameter(info.name)];
    if (value != car.parameters[*vehicle::find_parameter(info.name)])
      value = std::clamp(value, info.low, info.high);
  }
  out.engine_torque_nm =
      shaped_engine_map(car.files.engine_torque_nm, shape, out.parameters[P::engine_limit_radps]);
  return out;
}

/// One over the variance of each error: of its channel's worth, or of the spread that is left where
/// that is larger; less for what lies far outside.
Eigen::VectorXd weights(const Eigen::VectorXd& r, const std::vector<double>& worth) {
  const auto channels = static_cast<Index>(worth.size());
  Eigen::VectorXd out = Eigen::VectorXd::Zero(r.size());
  for (Index c = 0; c < channels; ++c) {
    std::vector<double> size;
    for (Index i = c; i < r.size(); i += channels)
      if (std::isfinite(r[i])) size.push_back(std::abs(r[i]));
    if (size.empty()) continue;
    const auto middle = size.begin() + static_cast<std::ptrdiff_t>(size.size() / 2);
    std::nth_element(size.begin(), middle, size.end());
    const double unit = std::max(worth[static_cast<std::size_t>(c)], 1.5 * *middle);
    for (Index i = c; i < r.size(); i += channels)
      if (std::isfinite(r[i]))
        out[i] = 1 / (unit * unit) * std::min(1.0, 3 * unit / std::max(1e-12, std::abs(r[i])));
  }
  return out;
}

/// Column after column; 0 where an error is none. Empty: another number of windows was driven.
std::vector<double> slopes_of(
    const std::vector<Free>& free,
    const std::function<std::vector<double>(const Eigen::VectorXd&)>& errors,
    const std::vector<double>& base) {
  std::vector<std::vector<double>> there(free.size());
  base::parallel_for(free.size(), 1, 2, [&](std::size_t j, std::size_t) {
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(static_cast<Index>(free.size()));
    moved[static_cast<Index>(j)] = free[j].move;
    there[j] = errors(moved);
  });
  std::vector<double> out;
  for (std::size_t j = 0; j < free.size(); ++j) {
    if (there[j].size() != base.size()) return {};
    for (std::size_t i = 0; i < base.size(); ++i) {
      const double slope = (there[j][i] - base[i]) / free[j].move;
      out.push_back(std::isfinite(slope) ? slope : 0.0);
    }
  }
  return out;
}

}  // namespace

RefittedCar refitted(const vehicle::Vehicle& car, const TrainingErrors& errors,
                     const std::vector<double>& worth, const RefittedCar* alike) {
  const std::vector<Free> free = free_amounts(car);
  const auto columns = static_cast<Index>(free.size());
  const auto raw = [&](const Eigen::VectorXd& amount) {
    vehicle::CarFiles files = car.files;
    const RefittedCar made = with(car, free, amount);
    files.engine_torque_nm = made.engine_torque_nm;
    return errors(files, made.parameters);
  };
  const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(columns);
  const std::vector<double> base = raw(nothing);
  const auto n = static_cast<Index>(base.size());
  if (n < 30) return with(car, free, nothing);
  Eigen::VectorXd r = Eigen::Map<const Eigen::VectorXd>(base.data(), n), precision(columns),
                  amount = nothing;
  for (Index j = 0; j < columns; ++j) {
    const double width = free[static_cast<std::size_t>(j)].width;
    precision[j] = 1 / (width * width);
  }
  const bool known = alike != nullptr && alike->slopes.size() == base.size() * free.size();
  const std::vector<double> slopes = known ? alike->slopes : slopes_of(free, raw, base);
  if (slopes.empty()) return with(car, free, nothing);
  const Eigen::Map<const Eigen::MatrixXd> jacobian(slopes.data(), n, columns);
  // The derivatives of the first step serve the others as well; the weights are those of what is
  // left.
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::VectorXd w = weights(r, worth);
    const Eigen::VectorXd e = r.array().isFinite().select(r, 0.0);
    Eigen::MatrixXd normal = jacobian.transpose() * w.asDiagonal() * jacobian;
    normal.diagonal() += precision;
    amount -= normal.ldlt().solve(jacobian.transpose() * w.cwiseProduct(e) +
                                  precision.cwiseProduct(amount));
    for (Index j = 0; j < columns; ++j) {
      const Free& f = free[static_cast<std::size_t>(j)];
      if (f.plus == P::kCount) {
        amount[j] = std::clamp(amount[j], -0.3, 0.3);
      } else {
        const vehicle::ParameterInfo& info =
            vehicle::parameter_list()[static_cast<std::size_t>(f.plus)];
        amount[j] = std::clamp(amount[j], info.low - car.parameters[f.plus],
                               info.high - car.parameters[f.plus]);
      }
    }
    if (round + 1 == kRounds) break;
    const std::vector<double> now = raw(amount);
    if (now.size() != base.size()) break;
    r = Eigen::Map<const Eigen::VectorXd>(now.data(), n);
  }
  RefittedCar out = with(car, free, amount);
  out.slopes = slopes;
  for (std::size_t j = 0; j < free.size(); ++j) {
    for (const P p : free[j].factor) out.changed.push_back(p);
    if (free[j].plus != P::kCount) out.changed.push_back(free[j].plus);
  }
  return out;
}

}  // namespace explain
