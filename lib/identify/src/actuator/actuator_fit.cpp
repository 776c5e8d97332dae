#include "identify/actuator_fit.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "actuator_parts.h"
#include "base/error.h"
#include "base/interval90.h"
#include "base/parallel.h"
#include "identify/clustered_fit.h"

namespace identify {
namespace {

// What a larger order must leave at most: less is no structure, but noise of the command.
constexpr double kWorth = 0.99;
// How the command ran between two rows is not in the log: what that may move a dead time or a lag
// by, of a step, as measured with commands that were recorded at a twentieth of their rate.
constexpr double kBetweenRows = 0.05;
constexpr double kTold = 1e-10;   // of the slopes' squares, by which they must differ
constexpr double kClearly = 3.0;  // standard errors that a larger order must be better by

/// Standard errors by which b leaves less than a: of the mean over blocks of the logarithm of the
/// ratio, which a few blocks with much cannot rule. What is below a tenth of b's mean is noise.
double clearly_less(const std::vector<double>& a, const std::vector<double>& b) {
  const auto n = static_cast<double>(a.size());
  double floor = 0.0, mean = 0.0, square = 0.0;
  for (const double one : b) floor += 0.1 * one / n;
  std::vector<double> ratio;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ratio.push_back(std::log((a[i] + floor) / (b[i] + floor)));
    mean += ratio.back() / n;
  }
  for (const double one : ratio) square += (one - mean) * (one - mean);
  return square > 0.0 ? mean / std::sqrt(square / (n - 1.0) / n) : 0.0;
}

/// Smaller ones first.
const ActuatorOrder kOrders[] = {{0, false}, {1, false}, {1, true}, {2, false},
                                 {2, true},  {3, false}, {3, true}};

/// What the command looks like, unless the movement clearly says the other.
Hold choose_hold(const Record& record, const ActuatorOrder& order) {
  const auto line = left_out(record, Hold::kLine, fit_order(record, Hold::kLine, order));
  const auto step = left_out(record, Hold::kStep, fit_order(record, Hold::kStep, order));
  if (in_steps(record.command))
    return clearly_less(step, line) > kClearly ? Hold::kLine : Hold::kStep;
  return clearly_less(line, step) > kClearly ? Hold::kStep : Hold::kLine;
}

Fitted choose_order(const Record& record, Hold hold, unsigned threads,
                    std::vector<TriedOrder>& tried) {
  constexpr std::size_t kCount = std::size(kOrders);
  std::vector<Fitted> fits(kCount);
  std::vector<std::vector<double>> left(kCount);
  base::parallel_for(kCount, 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      fits[i] = fit_order(record, hold, kOrders[i]);
      left[i] = left_out(record, hold, fits[i]);
    }
  });
  double judged = 0.0, best_rms = 0.0;
  for (const int block : record.block) judged += block >= 0 ? 1.0 : 0.0;
  Fitted best;
  std::vector<double> best_left;
  const auto consider = [&](const Fitted& fit, const std::vector<double>& now) {
    double sum2 = 0.0;
    for (const double one : now) sum2 += one;
    const bool first = best_left.empty();
    TriedOrder one{fit.order, std::sqrt(sum2 / judged), first ? 0.0 : clearly_less(best_left, now),
                   first};
    if (one.clearly > kClearly && one.rms < kWorth * best_rms) one.taken = true;
    tried.push_back(one);
    if (!one.taken) return false;
    best = fit;
    best_rms = one.rms;
    best_left = now;
    return true;
  };
  for (std::size_t i = 0; i < kCount; ++i) consider(fits[i], left[i]);
  // Friction and backlash, beside what was chosen; with them more poles may be seen.
  ActuatorOrder order = best.order;
  order.play = true;
  for (bool taken = true; taken && order.poles <= 3; ++order.poles) {
    const Fitted loose = fit_order(record, hold, order);
    taken = consider(loose, left_out(record, hold, loose));
  }
  return best;
}

/// Standard deviations, and the numbers in their own units. Whether the rows tell them apart.
bool write_values(const Record& record, const Fitted& fitted, ActuatorFit& fit) {
  Fitted at = fitted;
  const Eigen::VectorXd left = evaluate(record, fit.hold, -1, at);
  const auto model = simulate(at.order, at.values, fit.hold, record.step_s, record.command);
  const std::vector<int> unknowns = unknowns_of(at.order);
  const auto count = static_cast<Eigen::Index>(unknowns.size());
  // Gain and offset beside the unknowns. Slopes of what is left after their projection are the
  // same for all but these two.
  Eigen::MatrixXd slopes(left.size(), count + 2);
  slopes.leftCols(count) = slopes_of(record, fit.hold, -1, at);
  double n = 0.0, near2 = 0.0, product = 0.0;
  for (Eigen::Index i = 0; i < left.size(); ++i) {
    const bool judged = record.block[static_cast<std::size_t>(i)] >= 0;
    slopes(i, count) = judged ? -model[static_cast<std::size_t>(i)] : 0.0;
    slopes(i, count + 1) = judged ? -1.0 : 0.0;
    if (!judged) continue;
    n += 1.0;
    near2 += left(i) * left(i);
    if (i > 0) product += left(i) * left(i - 1);
  }
  fit.repeats = rows_as_one(product, near2);
  fit.rms = std::sqrt(near2 / n);
  const double variance = fit.repeats * near2 / std::max(1.0, n - static_cast<double>(count) - 2.0);
  Eigen::MatrixXd normal = slopes.transpose() * slopes;
  normal.diagonal().array() += 1e-300;
  const Eigen::MatrixXd covariance =
      variance * normal.ldlt().solve(Eigen::MatrixXd::Identity(count + 2, count + 2));
  const auto sd = [&](Eigen::Index i) { return std::sqrt(std::max(0.0, covariance(i, i))); };
  fit.gain = {at.gain, sd(count)};
  fit.offset = {at.offset, sd(count + 1)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const int u = unknowns[static_cast<std::size_t>(i)];
    const double value = at.values[static_cast<std::size_t>(u)];
    const double between = kBetweenRows * record.step_s;
    const double unit = u == kDead ? 1.0 : u == kLag || u == kLag2 ? std::exp(value) : INFINITY;
    const double spread = std::hypot(sd(i), between / unit);
    const bool logarithm = u == kLag || u == kDamping || u == kLag2;
    const double scale = u == kPlay ? std::abs(at.gain) : 1.0;
    const Uncertain one = logarithm ? Uncertain{std::exp(value), std::exp(value) * spread}
                                    : Uncertain{scale * value, scale * spread};
    (u == kDead      ? fit.dead_time_s
     : u == kLag     ? fit.lag_s
     : u == kDamping ? fit.damping
     : u == kLag2    ? fit.lag2_s
     : u == kLead    ? fit.lead_s
                     : fit.play) = one;
  }
  const Eigen::VectorXd size = normal.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> scaled(
      size.asDiagonal() * normal * size.asDiagonal(), Eigen::EigenvaluesOnly);
  return scaled.eigenvalues()(0) > kTold;
}

/// Throws where the gain is not told from 0, because the movement is another's, and where the
/// numbers of the order are not told apart.
void require_told(const Record& record, const ActuatorFit& fit, bool told) {
  if (told && std::abs(fit.gain.value) > 3.0 * fit.gain.sd) return;
  double n = 0.0, mean = 0.0, square = 0.0;
  for (std::size_t i = 0; i < record.movement.size(); ++i) {
    if (record.block[i] < 0) continue;
    n += 1.0;
    mean += record.movement[i];
    square += record.movement[i] * record.movement[i];
  }
  const double variance = square / n - mean * mean / (n * n);
  const std::string gain =
      fmt::format("the gain is {:.3g} +- {:.2g}", fit.gain.value, base::kNormal90 * fit.gain.sd);
  if (fit.rms * fit.rms > 0.5 * variance)
    throw base::Error(
        fmt::format("the movement does not follow the command: {}; other channels?", gain));
  throw base::Error(fmt::format(
      "the movement follows the command, but the record cannot tell the numbers of {} pole{}{}{} "
      "apart: {}; state a smaller order (--order 1, or 0), or record a command that moves often, "
      "slowly and fast",
      fit.order.poles, fit.order.poles == 1 ? "" : "s", fit.order.zero ? " with a zero" : "",
      fit.order.play ? " and play" : "", gain));
}

std::vector<std::complex<double>> poles_of(const ActuatorFit& fit) {
  std::vector<std::complex<double>> out;
  if (fit.order.poles >= 2) {
    const std::complex<double> root =
        std::sqrt(std::complex<double>(fit.damping.value * fit.damping.value - 1.0));
    out.push_back((-fit.damping.value + root) / fit.lag_s.value);
    out.push_back((-fit.damping.value - root) / fit.lag_s.value);
  }
  if (fit.order.poles % 2 == 1) out.emplace_back(-1.0 / fit.lag2_s.value, 0.0);
  return out;
}

ActuatorValues values_of(const ActuatorFit& fit) {
  const auto logarithm = [](double value) { return value > 0.0 ? std::log(value) : 0.0; };
  const double gain = std::abs(fit.gain.value);
  return {fit.dead_time_s.value,
          logarithm(fit.lag_s.value),
          logarithm(fit.damping.value),
          logarithm(fit.lag2_s.value),
          fit.lead_s.value,
          gain > 0.0 ? fit.play.value / gain : 0.0};
}

}  // namespace

ActuatorFit fit_actuator(const std::vector<double>& time_s, const std::vector<double>& command,
                         const std::vector<double>& movement, const ActuatorFitOptions& options) {
  const Record record = record_of(time_s, command, movement);
  ActuatorFit fit;
  fit.rows = record.command.size();
  fit.step_s = record.step_s;
  const ActuatorOrder widest{2, true, false};
  fit.hold = options.hold ? *options.hold : choose_hold(record, options.order.value_or(widest));
  const Fitted fitted = options.order ? fit_order(record, fit.hold, *options.order)
                                      : choose_order(record, fit.hold, options.threads, fit.tried);
  fit.order = fitted.order;
  require_told(record, fit, write_values(record, fitted, fit));
  fit.poles_radps = poles_of(fit);
  Fitted plain;
  project(record, -1, record.command, plain);
  double judged = 0.0;
  for (const int block : record.block) judged += block >= 0 ? 1.0 : 0.0;
  fit.rms_plain = std::sqrt(plain.sum2 / judged);
  return fit;
}

std::vector<double> simulate_actuator(const ActuatorFit& fit, const std::vector<double>& command) {
  std::vector<double> out;
  if (command.empty()) return out;
  out = simulate(fit.order, values_of(fit), fit.hold, fit.step_s, command);
  for (double& value : out) value = fit.gain.value * value + fit.offset.value;
  return out;
}

Arx arx_of(const ActuatorFit& fit) {
  // The poles give a; b is what a leaves of the response to one sample.
  Arx out;
  std::vector<std::complex<double>> a{1.0};
  for (const auto& pole : fit.poles_radps) {
    std::vector<std::complex<double>> next(a.size() + 1, 0.0);
    for (std::size_t i = 0; i < a.size(); ++i) {
      next[i] += a[i];
      next[i + 1] -= std::exp(pole * fit.step_s) * a[i];
    }
    a = std::move(next);
  }
  for (std::size_t i = 1; i < a.size(); ++i) out.a.push_back(a[i].real());
  ActuatorOrder linear = fit.order;
  linear.play = false;
  const auto whole = static_cast<int>(std::floor(fit.dead_time_s.value / fit.step_s));
  const std::size_t first = 4, length = static_cast<std::size_t>(whole) + first + a.size() + 4;
  std::vector<double> pulse(length, 0.0);
  pulse[first] = 1.0;
  const auto response = simulate(linear, values_of(fit), fit.hold, fit.step_s, pulse);
  std::vector<double> b(length, 0.0);
  double most = 0.0;
  for (std::size_t k = 0; k < length; ++k) {
    for (std::size_t i = 0; i < a.size() && i <= k; ++i) b[k] += a[i].real() * response[k - i];
    b[k] *= fit.gain.value;
    most = std::max(most, std::abs(b[k]));
  }
  std::size_t begin = 0, end = length;
  while (begin < end && std::abs(b[begin]) < 1e-9 * most) ++begin;
  while (end > begin && std::abs(b[end - 1]) < 1e-9 * most) --end;
  out.dead_steps = static_cast<int>(begin) - static_cast<int>(first);
  out.b.assign(b.begin() + static_cast<std::ptrdiff_t>(begin),
               b.begin() + static_cast<std::ptrdiff_t>(end));
  return out;
}

}  // namespace identify
