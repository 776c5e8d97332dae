#include "leaning_road.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "derivatives_along.h"
#include "lap_waves.h"
#include "selection.h"
#include "turns_along.h"
#include "window_fit.h"

namespace explain {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kPlace_m = 10.0;         ///< between places, about
constexpr double kShortestWave_m = 80.0;  ///< of the profile
constexpr std::size_t kMostColumns = 121;
constexpr Index kLeastWindows = 30;
/// Ramps of a turn's lean: how long, and how far outside the turn their middle lies, to begin with;
/// about which line inside the middle.
constexpr std::array<double, 4> kOutside_m{-10, 15, 40, 65};
constexpr std::array<double, 2> kRamps_m{55.0, 120.0}, kInside_m{-6.0, 6.0};
/// Sizes of waves of the lean, m/m, and lengths over which they stay alike.
constexpr std::array<double, 4> kSizes{0.003, 0.006, 0.015, 0.03};
constexpr std::array<double, 3> kLengths_m{80.0, 200.0, 500.0};
/// How far cars drive beside where a reference line has them that was itself driven: one standard
/// deviation; the length over which it stays alike, the shortest wave. Where it is let go to
/// nothing, ramps of 230 m and pivots of 18 m took its place on a real oval.
constexpr double kWander_m = 1.0, kWanderAlike_m = 200.0, kShortestWander_m = 150.0;
/// One standard deviation of errors of a gyro as they are usual: gain, bias, delay, filter; side
/// slip per lateral acceleration, where the path's course stands for the heading.
constexpr std::array<double, kErrors> kUsual{selection::kUsualGyroGain, 0.0007, 0.5, 0.05, 1e-3};
constexpr double kAnyGain = 0.2, kNoSlip = 1e-6;
/// One standard deviation of leans, between turns, in them, of each; of ramps' places; of their
/// length, and of the places of each turn's; of the pivot, for all turns alike and inside of them.
constexpr double kBetween = 0.1, kLean = 0.6, kOfTurn = 0.08, kRamp_m = 25.0, kUsualRamp_m = 85.0,
                 kLongRamp = 0.35, kRampOfTurn_m = 12.0, kPivot_m = 2.5, kInner_m = 6.0;
constexpr double kMostDelay_s = 1.0, kMostFilter_s = 0.5;
/// Noise of a window to begin with, rad: a fit that begins with too much takes the road for noise.
constexpr double kFirst_rad = 0.002, kRough_rad = 0.003;
/// The driven line is taken as smooth: the wiggles of a reference line are none of the car's.
constexpr double kSmoothLine_m = 60.0;

/// Amounts in this order: lean between the turns; of all turns; how far their ramps lie outside, at
/// begin and end; the logarithm of their length; of each turn, what it leans more and how much
/// further out its ramps begin and end; waves; errors of the gyro; the pivot, of all turns alike
/// and to the inside; where there are waves, those of how far beside the line was driven.
enum : Index { kBetweenAt, kLeanAt, kBeginAt, kEndAt, kRampAt, kTurnsAt };
struct Prior {
  VectorXd centre, precision;
};

class Fitting {
 public:
  Fitting(const std::vector<Turning>& logs, double length_m, bool closed)
      : logs_(logs), length_m_(length_m), closed_(closed) {
    const auto spaces = static_cast<Index>(std::max(8.0, std::round(length_m / kPlace_m)));
    places_ = closed ? spaces : spaces + 1;
    out.place_m = length_m / static_cast<double>(spaces);
    out.turned = turned_places(logs, length_m, closed, places_);
    out.side = side_of(out.turned.turned_rad, out.place_m, closed, out.turns);
    const VectorXd curvature =
        smooth(out.turned.turned_rad.cwiseQuotient(out.turned.went_m.cwiseMax(1.0)), out.place_m,
               closed, 2, 1e9);
    turns_ = turns_of(curvature, out.place_m, closed);
    line_v_m_ = smooth(out.turned.v_m, out.place_m, closed,
                       static_cast<Index>(3 * kSmoothLine_m / out.place_m), kSmoothLine_m);
    for (const Turning& log : logs) off_.push_back(off_the_line(log, line_v_m_, length_m, closed));
    const auto columns = std::min({static_cast<std::size_t>(2 * length_m / kShortestWave_m) | 1U,
                                   kMostColumns, static_cast<std::size_t>(places_ - 1) | 1U});
    waves_ = waves(static_cast<std::size_t>(places_), columns, closed)
                 .rightCols(static_cast<Index>(columns) - 1);
    wander_ = std::min(waves_.cols(), static_cast<Index>(2 * length_m / kShortestWander_m));
    usual_ = Eigen::Map<const VectorXd>(kUsual.data(), kErrors);
    for (const Turning& log : logs)
      if (log.by == TurningBy::kHeading || log.by == TurningBy::kCourseAndSlip)
        usual_[kSlip] = kNoSlip;
  }

  bool run();
  LeaningRoad out;

 private:
  struct State {
    VectorXd amount, bank, base;
    MatrixXd moves, jacobian;  ///< of bank and base
    double loss = std::numeric_limits<double>::infinity();
  };
  struct Refined {
    State state;
    Prior prior;
    VectorXd weight, linear, left_rad;  ///< the problem at the state, about the prior's centre
  };

  Index count() const { return static_cast<Index>(turns_.size()); }
  Index waves_at() const { return kTurnsAt + 3 * count(); }
  Index error_at(Index waves) const { return waves_at() + waves; }
  Index pivot_at(Index waves) const { return error_at(waves) + kErrors; }
  Index wander_at(Index waves) const { return pivot_at(waves) + 2; }
  Index amounts(Index waves) const { return wander_at(waves) + (waves > 0 ? wander_ : 0); }
  /// Of waves of this size that stay alike over this length.
  VectorXd variances(Index waves, double size, double alike_m) const;
  void cut() {
    out.windows = turning_windows(logs_, off_, length_m_, closed_, places_, out.delay_s, filter_s_);
    // The nose that pitches on the stated road.
    const VectorXd pitch = derivative(out.turned.grade), sine = sine_of(out.turned.bank);
    y_ = out.windows.more_rad - out.windows.went_m * pitch.cwiseProduct(sine);
  }
  static VectorXd cosine_of(const VectorXd& bank) {
    return (1 + bank.array().square()).rsqrt().matrix();
  }
  static VectorXd sine_of(const VectorXd& bank) { return bank.cwiseProduct(cosine_of(bank)); }
  MatrixXd derivative(const MatrixXd& x) const {
    return explain::derivative(x, out.place_m, closed_);
  }
  MatrixXd second(const MatrixXd& x) const { return second_derivative(x, out.place_m, closed_); }
  MatrixXd ramps(double ramp_m, const VectorXd& begin_m, const VectorXd& end_m) const {
    return ramps_of(turns_, places_, out.place_m, closed_, {ramp_m, begin_m, end_m});
  }
  State state(const VectorXd& amount, Index waves, bool slopes = true) const;
  Prior prior(Index waves, double size, double alike_m, double outside_m) const;
  State improve(const VectorXd& amount, Index waves, const Prior& p, const VectorXd& weight,
                int rounds) const;
  VectorXd find_delay();
  VectorXd start(const VectorXd& leans, double ramp_m, double inside_m) const;
  Refined refine(const VectorXd& from) const;
  void tell(const Refined& r);
  WithoutLean without_lean(const VectorXd& precision) const;

  const std::vector<Turning>& logs_;
  std::vector<OffTheLine> off_;
  double length_m_;
  bool closed_;
  Index places_ = 0, wander_ = 0;
  double filter_s_ = 0.0;
  std::vector<Turn> turns_;
  VectorXd line_v_m_, usual_, y_;
  MatrixXd waves_;
};

Fitting::State Fitting::state(const VectorXd& amount, Index waves, bool slopes) const {
  const Index n = count();
  const VectorXd leans = amount.segment(kTurnsAt, n).array() + amount[kLeanAt],
                 begin_m = amount.segment(kTurnsAt + n, n).array() + amount[kBeginAt],
                 end_m = amount.segment(kTurnsAt + 2 * n, n).array() + amount[kEndAt];
  const double ramp_m = std::exp(amount[kRampAt]);
  const MatrixXd r = ramps(ramp_m, begin_m, end_m);
  constexpr double kStep_m = 4.0, kLonger = 1.05;
  const VectorXd step_m = VectorXd::Constant(n, kStep_m);
  const MatrixXd by_begin =
      (ramps(ramp_m, begin_m + step_m, end_m) - ramps(ramp_m, begin_m - step_m, end_m)) *
      leans.asDiagonal() / (2 * kStep_m);
  const MatrixXd by_end =
      (ramps(ramp_m, begin_m, end_m + step_m) - ramps(ramp_m, begin_m, end_m - step_m)) *
      leans.asDiagonal() / (2 * kStep_m);
  State s;
  s.amount = amount;
  s.moves.resize(places_, waves_at() + waves);
  s.moves << out.side, r.rowwise().sum(), by_begin.rowwise().sum(), by_end.rowwise().sum(),
      (ramps(ramp_m * kLonger, begin_m, end_m) - ramps(ramp_m / kLonger, begin_m, end_m)) * leans /
          (2 * std::log(kLonger)),
      r, by_begin, by_end, out.side.asDiagonal() * waves_.leftCols(waves);
  VectorXd added = amount[kBetweenAt] * out.side + r * leans;
  if (waves > 0) added += s.moves.rightCols(waves) * amount.segment(waves_at(), waves);
  s.bank = out.turned.bank + added;
  // The car turned on the map by what the gyro felt, less the nose's pitching, over the cosine.
  const VectorXd cosine = cosine_of(s.bank), stated = cosine_of(out.turned.bank),
                 ratio = stated.cwiseQuotient(cosine), leaning = stated.cwiseProduct(s.bank);
  const auto wander = waves_.leftCols(amount.size() - wander_at(waves));
  const VectorXd beside =
      wander * amount.tail(wander.cols()) +
      (line_v_m_.array() - amount[pivot_at(waves)] + amount[pivot_at(waves) + 1] * out.side.array())
          .matrix();
  const VectorXd stated_pitch = derivative(out.turned.grade),
                 pitch = stated_pitch + second(added.cwiseProduct(beside)),
                 slope = derivative(added), bend = second(added);
  const MatrixXd &turned = out.windows.turned_rad, &went = out.windows.went_m,
                 &off = out.windows.beside_m2, &off_slope = out.windows.slope_m,
                 &off_bend = out.windows.bend;
  s.base =
      turned * (1 - ratio.array()).matrix() +
      went * (pitch.cwiseProduct(leaning) - stated_pitch.cwiseProduct(sine_of(out.turned.bank))) +
      off * bend.cwiseProduct(leaning) + 2 * off_slope * slope.cwiseProduct(leaning) +
      off_bend * added.cwiseProduct(leaning) +
      out.windows.errors * amount.segment(error_at(waves), kErrors);
  if (!slopes) return s;
  const MatrixXd felt = went * leaning.asDiagonal();
  const MatrixXd by_leaning = went * pitch.asDiagonal() + off * bend.asDiagonal() +
                              2 * off_slope * slope.asDiagonal() + off_bend * added.asDiagonal();
  s.jacobian.resize(y_.size(), amount.size());
  s.jacobian << by_leaning * stated.asDiagonal() * s.moves +
                    (off_bend - turned * cosine.asDiagonal()) * leaning.asDiagonal() * s.moves +
                    2 * off_slope * leaning.asDiagonal() * derivative(s.moves) +
                    off * leaning.asDiagonal() * second(s.moves) +
                    felt * second(beside.asDiagonal() * s.moves),
      out.windows.errors, felt * second(-added), felt * second(added.cwiseProduct(out.side)),
      felt * second(added.asDiagonal() * wander);
  return s;
}

VectorXd Fitting::variances(Index waves, double size, double alike_m) const {
  VectorXd out(waves);
  for (Index k = 0; k < waves; ++k) {
    const double ratio = wave_turns(static_cast<std::size_t>(k + 1), closed_) * alike_m / length_m_;
    out[k] = 1 / (1 + ratio * ratio * ratio * ratio);
  }
  return waves > 0 ? VectorXd(out * (size * size / (0.5 * out.sum()))) : out;
}

Prior Fitting::prior(Index waves, double size, double alike_m, double outside_m) const {
  Prior p{VectorXd::Zero(amounts(waves)), VectorXd(amounts(waves))};
  const auto precision = [](double sd) { return 1 / (sd * sd); };
  p.centre.segment(kBeginAt, 2).setConstant(outside_m);
  p.centre[kRampAt] = std::log(kUsualRamp_m);
  p.precision << precision(kBetween), precision(kLean),
      VectorXd::Constant(2, precision(waves > 0 ? kRamp_m : 0.2 * kRamp_m)), precision(kLongRamp),
      VectorXd::Constant(count(), precision(kOfTurn)),
      VectorXd::Constant(2 * count(), precision(kRampOfTurn_m)),
      variances(waves, size, alike_m).cwiseInverse(), usual_.cwiseAbs2().cwiseInverse(),
      precision(kPivot_m), precision(kInner_m),
      variances(amounts(waves) - wander_at(waves), kWander_m, kWanderAlike_m).cwiseInverse();
  return p;
}

Fitting::State Fitting::improve(const VectorXd& amount, Index waves, const Prior& p,
                                const VectorXd& weight, int rounds) const {
  const Settled found = settle(y_, weight, amount, p.centre, p.precision, rounds,
                               [&](const VectorXd& at, VectorXd& made, MatrixXd* slopes) {
                                 State s = state(at, waves, slopes != nullptr);
                                 made = s.base;
                                 if (slopes != nullptr) *slopes = std::move(s.jacobian);
                               });
  State s = state(found.amount, waves);
  s.loss = found.loss;
  return s;
}

/// By turns that each take a share of their own from the turning: no road is linear in its delay.
VectorXd Fitting::find_delay() {
  VectorXd leans = VectorXd::Zero(count());
  for (int round = 0; round < 5; ++round) {
    cut();
    if (y_.size() < kLeastWindows) return leans;
    const VectorXd none = VectorXd::Zero(count());
    const MatrixXd r = ramps(80.0, none, none).cwiseAbs();
    MatrixXd x(y_.size(), count() + kErrors);
    x << -(out.windows.turned_rad * r), out.windows.errors;
    VectorXd precision(x.cols());
    constexpr double kShare = 0.05;
    precision << VectorXd::Constant(count(), 1 / (kShare * kShare)),
        usual_.cwiseAbs2().cwiseInverse();
    if (out.weight.size() != y_.size()) out.weight = VectorXd::Constant(y_.size(), 1 / kFirst_rad);
    out.weight = weights_of(y_ - x * solve(x, y_, out.weight, precision).amount);
    const VectorXd amount = solve(x, y_, out.weight, precision).amount;
    for (Index t = 0; t < count(); ++t) {
      const double stated = r.col(t).dot(out.turned.bank) / std::max(1e-9, r.col(t).sum());
      const double cosine = std::clamp(1 / std::hypot(1, stated) / (1 + amount[t]), 0.7, 0.9995);
      leans[t] = std::sqrt(1 - cosine * cosine) / cosine -
                 stated * turns_[static_cast<std::size_t>(t)].side;
    }
    if (round < 4) {
      out.delay_s = std::clamp(out.delay_s + amount[count() + kDelay], -kMostDelay_s, kMostDelay_s);
      // What a filter of the first order is beyond its delay.
      const double square = 0.5 * filter_s_ * filter_s_ + amount[count() + kFilter];
      filter_s_ = std::min(
          {std::sqrt(2 * std::max(0.0, square)), std::max(0.0, out.delay_s), kMostFilter_s});
    }
  }
  return leans;
}

/// The best of several starts, without waves: a cosine has no slope at nothing.
VectorXd Fitting::start(const VectorXd& leans, double ramp_m, double inside_m) const {
  const VectorXd weight = VectorXd::Constant(y_.size(), 1 / kRough_rad);
  State best;
  for (const double outside_m : kOutside_m) {
    const Prior p = prior(0, 0.0, 1.0, outside_m);
    VectorXd amount = p.centre;
    amount[kLeanAt] = leans.mean();
    amount.segment(kTurnsAt, count()) = leans.array() - leans.mean();
    amount[pivot_at(0) + 1] = inside_m;
    amount[kRampAt] = std::log(ramp_m);
    State s = improve(amount, 0, p, weight, 8);
    if (s.loss < best.loss) best = std::move(s);
  }
  VectorXd amount = VectorXd::Zero(amounts(waves_.cols()));
  amount.head(waves_at()) = best.amount.head(waves_at());
  amount.segment(error_at(waves_.cols()), kErrors + 2) = best.amount.tail(kErrors + 2);
  return amount;
}

/// With waves as rough as makes the recordings most likely.
Fitting::Refined Fitting::refine(const VectorXd& from) const {
  constexpr double kUsuallyOutside_m = 20.0;
  const Index waves = waves_.cols();
  Refined r;
  r.prior = prior(waves, kSizes[2], kLengths_m[1], kUsuallyOutside_m);
  r.weight = VectorXd::Constant(y_.size(), 1 / kFirst_rad);
  r.state.amount = from;
  for (int round = 0; round < 5; ++round) {
    r.state = improve(r.state.amount, waves, r.prior, r.weight, 12);
    const State& s = r.state;
    r.linear = y_ - s.base + s.jacobian * (s.amount - r.prior.centre);
    if (round == 4) break;
    double most = -std::numeric_limits<double>::infinity();
    for (const double size : kSizes)
      for (const double alike_m : kLengths_m) {
        const Prior other = prior(waves, size, alike_m, kUsuallyOutside_m);
        const double e = solve(s.jacobian, r.linear, r.weight, other.precision).evidence;
        if (e > most) most = e, r.prior = other;
      }
    r.weight = weights_of(left_out(s.jacobian, r.linear, r.weight, r.prior.precision, out.windows));
  }
  r.left_rad = left_out(r.state.jacobian, r.linear, r.weight, r.prior.precision, out.windows);
  return r;
}

void Fitting::tell(const Refined& r) {
  const State& s = r.state;
  const Index waves = waves_.cols(), shapes = waves_at() + waves;
  // The cosine says nothing about the sign.
  const VectorXd sign = (s.bank.array() * out.side.array() < 0)
                            .select(VectorXd::Constant(places_, -1), VectorXd::Ones(places_));
  out.added = s.bank.cwiseProduct(sign) - out.turned.bank;
  out.moves = sign.asDiagonal() * s.moves;
  out.covariance = solve(s.jacobian, r.linear, r.weight, r.prior.precision)
                       .covariance.topLeftCorner(shapes, shapes);
  out.pivot_v_m = s.amount[pivot_at(waves)] - s.amount[pivot_at(waves) + 1] * out.side.array();
  out.gain = s.amount[error_at(waves) + kGain];
  out.bias_radps = s.amount[error_at(waves) + kBias];
  out.weight = r.weight;
  out.left_rad = r.left_rad;
  const VectorXd usual = usual_.cwiseAbs2().cwiseInverse();
  VectorXd any_gain = usual;
  any_gain[kGain] = 1 / (kAnyGain * kAnyGain);
  out.unusual = usual.dot(s.amount.segment(error_at(waves), kErrors).cwiseAbs2());
  out.stated = without_lean(usual);
  out.with_any_gain = without_lean(any_gain);
}

WithoutLean Fitting::without_lean(const VectorXd& precision) const {
  const VectorXd amount = solve(out.windows.errors, y_, out.weight, precision).amount;
  return {left_out(out.windows.errors, y_, out.weight, precision, out.windows), amount[kGain],
          precision.dot(amount.cwiseAbs2())};
}

bool Fitting::run() {
  if (turns_.empty()) return false;
  const VectorXd leans = find_delay();
  if (y_.size() < kLeastWindows) return false;
  // No road leans more between its turns than in them: such a fit makes do with the wrong pivot.
  std::optional<Refined> best;
  std::pair<bool, double> least{true, std::numeric_limits<double>::infinity()};
  for (const double ramp_m : kRamps_m)
    for (const double inside_m : kInside_m) {
      Refined r = refine(start(leans, ramp_m, inside_m));
      double left = 0.0;
      for (const double e : r.left_rad) left += std::min(std::abs(e), 3 * kFirst_rad) * std::abs(e);
      const std::pair<bool, double> now{r.state.amount[kLeanAt] < 0, left};
      if (!best || now < least) least = now, best = std::move(r);
    }
  tell(*best);
  return true;
}

}  // namespace

std::optional<LeaningRoad> fit_leaning_road(const std::vector<Turning>& logs, double length_m,
                                            bool closed) {
  Fitting f(logs, length_m, closed);
  if (!f.run()) return std::nullopt;
  return std::move(f.out);
}

}  // namespace explain
