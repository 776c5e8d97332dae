#include <Eigen/Dense>
#include <algorithm>

#include "actuator_parts.h"
#include "identify/least_squares.h"

namespace identify {
namespace {

constexpr int kFolds = 4;

const ActuatorValues kLow{0.0, std::log(1e-3), std::log(0.05), std::log(1e-3), -1.0, 0.0},
    kHigh{0.4, std::log(2.0), std::log(20.0), std::log(2.0), 1.0, 1e9};

/// Which rows a fit looks at: those of all blocks but every kFolds-th from `fold`.
bool looked_at(int block, int fold) { return block >= 0 && (fold < 0 || block % kFolds != fold); }

/// For slopes, to either side.
double difference_of(const Record& record, std::size_t unknown) {
  return unknown == kDead   ? 0.01 * record.step_s
         : unknown == kPlay ? 1e-4 * record.command_range
                            : 1e-4 * (unknown == kLead ? 0.1 : 1.0);
}

}  // namespace

Eigen::VectorXd project(const Record& record, int fold, const std::vector<double>& model,
                        Fitted& fit) {
  double n = 0.0, m = 0.0, y = 0.0;
  const auto each = [&](const auto& body) {
    for (std::size_t i = 0; i < model.size(); ++i)
      if (looked_at(record.block[i], fold)) body(model[i], record.movement[i], i);
  };
  each([&](double a, double b, std::size_t) {
    n += 1.0;
    m += a;
    y += b;
  });
  m /= n;
  y /= n;
  double mm = 0.0, my = 0.0;
  each([&](double a, double b, std::size_t) {
    mm += (a - m) * (a - m);
    my += (a - m) * (b - y);
  });
  fit.gain = mm > 0.0 ? my / mm : 0.0;
  fit.offset = y - fit.gain * m;
  Eigen::VectorXd left = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(model.size()));
  each([&](double a, double b, std::size_t i) {
    left(static_cast<Eigen::Index>(i)) = b - fit.gain * a - fit.offset;
  });
  fit.sum2 = left.squaredNorm();
  return left;
}

Eigen::VectorXd evaluate(const Record& record, Hold hold, int fold, Fitted& fit) {
  return project(record, fold, simulate(fit.order, fit.values, hold, record.step_s, record.command),
                 fit);
}

Eigen::MatrixXd slopes_of(const Record& record, Hold hold, int fold, const Fitted& at) {
  const std::vector<int> unknowns = unknowns_of(at.order);
  Eigen::MatrixXd out(static_cast<Eigen::Index>(record.command.size()),
                      static_cast<Eigen::Index>(unknowns.size()));
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto u = static_cast<std::size_t>(unknowns[i]);
    const double difference = difference_of(record, u);
    Fitted up = at, down = at;
    up.values[u] = std::min(kHigh[u], at.values[u] + difference);
    down.values[u] = std::max(kLow[u], at.values[u] - difference);
    out.col(static_cast<Eigen::Index>(i)) =
        (evaluate(record, hold, fold, up) - evaluate(record, hold, fold, down)) /
        (up.values[u] - down.values[u]);
  }
  return out;
}

namespace {

/// From the numbers of the fit down to the least sum of squares near them.
void descend(const Record& record, Hold hold, int fold, Fitted& fit, int rounds) {
  std::vector<Unknown> unknowns;
  const std::vector<int> places = unknowns_of(fit.order);
  for (const int place : places) {
    const auto u = static_cast<std::size_t>(place);
    unknowns.push_back({"", fit.values[u], kLow[u], kHigh[u], 1.0, difference_of(record, u)});
  }
  const auto at = [&](const auto& value_of) {
    Fitted out = fit;
    for (std::size_t i = 0; i < places.size(); ++i)
      out.values[static_cast<std::size_t>(places[i])] = value_of(i);
    return out;
  };
  const auto residuals = [&](const std::vector<double>& values, std::vector<double>& left) {
    Fitted one = at([&](std::size_t i) { return values[i]; });
    const Eigen::VectorXd rows = evaluate(record, hold, fold, one);
    left.assign(rows.begin(), rows.end());
  };
  least_squares(unknowns, residuals, rounds, 1e-7);
  fit = at([&](std::size_t i) { return unknowns[i].value; });
  evaluate(record, hold, fold, fit);
}

/// The best of a grid of beginnings, and from there down.
Fitted from_grid(const Record& record, Hold hold, const ActuatorOrder& order) {
  Fitted best;
  for (const double dead : {0.0, 0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.2})
    for (const double lag : {0.005, 0.015, 0.04, 0.1, 0.3})
      for (const double damping : {0.4, 1.0}) {
        Fitted one{order, {dead, std::log(lag), std::log(damping), std::log(lag), 0.0, 0.0}};
        evaluate(record, hold, -1, one);
        if (one.sum2 < best.sum2) best = one;
        if (order.poles < 2) break;
      }
  descend(record, hold, -1, best, 40);
  return best;
}

}  // namespace

Fitted fit_order(const Record& record, Hold hold, const ActuatorOrder& order) {
  if (order.poles < 3 && !order.zero && !order.play) return from_grid(record, hold, order);
  Fitted best;
  const auto better = [&](Fitted one) {
    one.order = order;
    descend(record, hold, -1, one, 40);
    if (one.sum2 < best.sum2) best = one;
  };
  ActuatorOrder less = order;
  if (order.play) {
    less.play = false;
    const Fitted from = fit_order(record, hold, less);
    for (const double share : {0.002, 0.02, 0.1}) {
      Fitted one = from;
      one.values[kPlay] = share * record.command_range;
      better(one);
    }
  } else if (order.zero) {
    less.zero = false;
    const Fitted from = fit_order(record, hold, less);
    for (const double lead : {0.0, 0.02, -0.02, 0.1}) {
      Fitted one = from;
      one.values[kLead] = lead;
      better(one);
    }
  } else {
    less.poles = 2;
    const Fitted from = fit_order(record, hold, less);
    for (const double share : {0.1, 0.5, 1.0}) {
      Fitted one = from;
      one.values[kLag2] = std::max(kLow[kLag2], one.values[kLag] + std::log(share));
      one.values[kDead] = std::max(0.0, one.values[kDead] - std::exp(one.values[kLag2]));
      better(one);
    }
  }
  return best;
}

std::vector<double> left_out(const Record& record, Hold hold, const Fitted& whole) {
  std::vector<double> out(static_cast<std::size_t>(record.blocks), 0.0);
  for (int fold = 0; fold < kFolds; ++fold) {
    Fitted fit = whole;
    descend(record, hold, fold, fit, 12);
    const auto model = simulate(fit.order, fit.values, hold, record.step_s, record.command);
    for (std::size_t i = 0; i < model.size(); ++i)
      if (record.block[i] >= 0 && record.block[i] % kFolds == fold)
        out[static_cast<std::size_t>(record.block[i])] +=
            std::pow(record.movement[i] - fit.gain * model[i] - fit.offset, 2);
  }
  return out;
}

}  // namespace identify
