#include "explain/banking_by_turning.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "explain/unknowns.h"
#include "lap_waves.h"
#include "selection.h"
#include "turning_windows.h"

namespace explain {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kPlace_m = 10.0;         ///< between places, about
constexpr double kShortestWave_m = 80.0;  ///< of the profile
constexpr Index kMostColumns = 121;
constexpr Index kLeastWindows = 30;
/// Sizes of what the lean takes from the cosine, and lengths over which it stays alike.
constexpr std::array<double, 5> kSizes{0.005, 0.01, 0.02, 0.04, 0.08};
constexpr std::array<double, 5> kLengths_m{80.0, 140.0, 240.0, 400.0, 700.0};
/// One standard deviation of errors of a gyro as they are usual: gain, bias, delay, filter. Where
/// the stated road is the rival the gain may be anything.
constexpr std::array<double, kErrors> kUsual{0.0035, 0.0007, 0.5, 0.05};
constexpr double kAnyGain = 0.2, kAnyMean = 0.1;
constexpr double kMostDelay_s = 1.0;
/// Noise of a window to begin with, rad: a fit that begins with too much takes the road for noise.
constexpr double kFirst_rad = 0.002;
/// A road turns where it does so by more than this.
constexpr double kTurns_1pm = 1.0 / 2500.0;

struct Fit {
  VectorXd amount;  ///< of waves, then of what is beside them
  MatrixXd covariance;
  double evidence = 0.0;
};

/// Rows times amounts make what the gyro has more.
struct Problem {
  MatrixXd x;
  VectorXd y, weight;

  /// By residuals `e`: spread by the median; outliers count as three standard deviations; errors
  /// that go on over windows count as few.
  void weigh(const VectorXd& e) {
    std::vector<double> size(static_cast<std::size_t>(e.size()));
    for (Index i = 0; i < e.size(); ++i) size[static_cast<std::size_t>(i)] = std::abs(e[i]);
    const auto middle = size.begin() + static_cast<std::ptrdiff_t>(size.size() / 2);
    std::nth_element(size.begin(), middle, size.end());
    const double sigma = std::max(1e-5, 1.4826 * *middle);
    const VectorXd c = e.cwiseMax(-3 * sigma).cwiseMin(3 * sigma);
    const double variance = c.squaredNorm() / static_cast<double>(c.size());
    double spread = 1.0;
    constexpr Index kLags = 6;
    for (Index lag = 1; lag <= std::min(kLags, c.size() - 1); ++lag)
      spread += 2 * (1 - static_cast<double>(lag) / static_cast<double>(kLags + 1)) *
                c.tail(c.size() - lag).dot(c.head(c.size() - lag)) / c.squaredNorm();
    const double sd = std::sqrt(variance * std::clamp(spread, 1.0, 10.0));
    for (Index i = 0; i < e.size(); ++i)
      weight[i] = std::min(1.0, 3 * sigma / std::max(1e-300, std::abs(e[i]))) / sd;
  }

  /// `prior`: 1 / variance of each column; `without`: the fold whose rows do not count.
  Fit solve(const VectorXd& prior, const std::vector<int>* fold = nullptr, int without = -1) const {
    VectorXd w = weight;
    for (Index i = 0; fold != nullptr && i < w.size(); ++i)
      if ((*fold)[static_cast<std::size_t>(i)] == without) w[i] = 0.0;
    const MatrixXd a = w.asDiagonal() * x;
    MatrixXd normal = a.transpose() * a;
    const VectorXd right = a.transpose() * w.cwiseProduct(y);
    normal.diagonal() += prior;
    const Eigen::LLT<MatrixXd> solver(normal);
    Fit out;
    out.amount = solver.solve(right);
    out.covariance = solver.solve(MatrixXd::Identity(x.cols(), x.cols()));
    out.evidence = 0.5 * right.dot(out.amount) - solver.matrixLLT().diagonal().array().log().sum() +
                   0.5 * prior.array().log().sum();
    return out;
  }

  /// What is left of each fold where the others say what is there.
  VectorXd left_out(const VectorXd& prior, const std::vector<int>& fold, int folds) const {
    VectorXd out(y.size());
    for (int k = 0; k < folds; ++k) {
      const VectorXd e = y - x * solve(prior, &fold, k).amount;
      for (Index i = 0; i < e.size(); ++i)
        if (fold[static_cast<std::size_t>(i)] == k) out[i] = e[i];
    }
    return out;
  }
};

/// 1 / variance of waves of this size and roughness (size 0: none) and of what is beside them.
VectorXd prior_of(Index waves, double size, double alike_m, double length_m, bool closed,
                  double gain) {
  VectorXd out(waves + kErrors), variance(waves);
  for (Index k = 0; k < waves; ++k) {
    const double turns = wave_turns(static_cast<std::size_t>(k), closed);
    const double ratio = turns * alike_m / length_m;
    variance[k] = 1 / (1 + ratio * ratio * ratio * ratio);
  }
  constexpr double kNone = 1e12;
  // Its mean may be any: held near nothing it would be taken for a gain.
  variance *= size * size / (0.5 * variance.tail(waves - 1).sum());
  variance[0] = kAnyMean * kAnyMean;
  if (size > 0)
    out.head(waves) = variance.cwiseInverse();
  else
    out.head(waves).setConstant(kNone);
  for (Index k = 0; k < kErrors; ++k) {
    const double sd = k == kGain ? gain : kUsual[static_cast<std::size_t>(k)];
    out[waves + k] = 1 / (sd * sd);
  }
  return out;
}

/// The roughness that makes the recordings most likely.
VectorXd best_prior(const Problem& p, double length_m, bool closed) {
  double most = -std::numeric_limits<double>::infinity();
  VectorXd out;
  for (const double size : kSizes)
    for (const double alike_m : kLengths_m) {
      const VectorXd prior = prior_of(p.x.cols() - kErrors, size, alike_m, length_m, closed,
                                      kUsual[std::size_t{kGain}]);
      if (const double e = p.solve(prior).evidence; e > most || out.size() == 0)
        most = e, out = prior;
    }
  return out;
}

/// To which side each place leans if roads lean into their turns: rise to the left. Between turns
/// that differ, from the one to the other. `turns`: where it does.
VectorXd side_of(const VectorXd& turned_rad, double place_m, bool closed,
                 std::vector<bool>& turns) {
  const Index n = turned_rad.size();
  constexpr Index kErrorss = 3;
  VectorXd side = VectorXd::Zero(n);
  std::vector<Index> known;
  turns.assign(static_cast<std::size_t>(n), false);
  const double laps = std::max(1.0, turned_rad.cwiseAbs().sum() / (2 * 3.14159265358979323846));
  for (Index k = 0; k < n; ++k) {
    double sum = 0.0;
    for (Index d = -kErrorss; d <= kErrorss; ++d)
      if (closed || (k + d >= 0 && k + d < n)) sum += turned_rad[((k + d) % n + n) % n];
    if (std::abs(sum) < kTurns_1pm * (2 * kErrorss + 1) * place_m * laps) continue;
    side[k] = sum > 0 ? -1.0 : 1.0;
    known.push_back(k);
    turns[static_cast<std::size_t>(k)] = true;
  }
  if (known.empty()) return side;
  for (std::size_t j = 0; j < known.size(); ++j) {
    const Index from = known[j], to = j + 1 < known.size() ? known[j + 1] : known[0] + n;
    if (to >= n && !closed) break;
    for (Index k = from + 1; k < to; ++k) {
      const double share = static_cast<double>(k - from) / static_cast<double>(to - from);
      side[k % n] = (1 - share) * side[from] + share * side[to % n];
    }
  }
  for (Index k = 0; !closed && k < n; ++k) {
    if (k < known.front()) side[k] = side[known.front()];
    if (k > known.back()) side[k] = side[known.back()];
  }
  return side;
}

/// Of the angle whose cosine is 1 less this.
double tangent_of(double deficit) {
  const double cosine = std::clamp(1 - deficit, 0.1, 1.0);
  return std::sqrt(1 - cosine * cosine) / cosine;
}

/// All that is fitted to some recordings: what the lean takes from the cosine beyond the file is
/// waves times amounts. In the cosine all is linear: there is no start to get stuck at.
class Fitting {
 public:
  Fitting(const std::vector<Turning>& logs, double length_m, bool closed)
      : logs_(logs), length_m_(length_m), closed_(closed) {
    const auto spaces = static_cast<Index>(std::max(8.0, std::round(length_m / kPlace_m)));
    const Index places = closed ? spaces : spaces + 1;
    place_m = length_m / static_cast<double>(spaces);
    turned = turned_places(logs, length_m, closed, places);
    side = side_of(turned.turned_rad, place_m, closed, turns);
    const auto columns = static_cast<Index>(2 * length_m / kShortestWave_m) | 1;
    const auto most =
        static_cast<std::size_t>(std::min({columns, kMostColumns, (places - 1) | Index{1}}));
    waves = explain::waves(static_cast<std::size_t>(places), most, closed);
    n = waves.cols();
  }

  /// False: too few windows.
  bool run() {
    for (int round = 0; round < 5; ++round) {
      windows = turning_windows(logs_, length_m_, closed_, waves.rows(), delay_s);
      if (windows.more_rad.size() < kLeastWindows) return false;
      p_.y = windows.more_rad;
      p_.x.resize(p_.y.size(), n + Index{kErrors});
      p_.x << -(windows.turned_rad * waves), windows.errors;
      if (p_.weight.size() != p_.y.size())
        p_.weight = VectorXd::Constant(p_.y.size(), 1 / kFirst_rad);
      for (int again = 0; again < 2; ++again) {
        prior = best_prior(p_, length_m_, closed_);
        p_.weigh(p_.left_out(prior, windows.fold, windows.folds));
      }
      prior = best_prior(p_, length_m_, closed_);
      fit = p_.solve(prior);
      if (round < 4)
        delay_s = std::clamp(delay_s + fit.amount[n + kDelay], -kMostDelay_s, kMostDelay_s);
    }
    return true;
  }

  /// Loss that the lean saves on each half lap left out.
  std::vector<double> saved() const {
    const VectorXd with = p_.left_out(prior, windows.fold, windows.folds);
    const VectorXd flat = prior_of(n, 0.0, 1.0, length_m_, closed_, kAnyGain);
    const VectorXd without = p_.left_out(flat, windows.fold, windows.folds);
    std::vector<double> out(static_cast<std::size_t>(windows.folds), 0.0);
    for (Index i = 0; i < with.size(); ++i)
      out[static_cast<std::size_t>(windows.fold[static_cast<std::size_t>(i)])] +=
          p_.weight[i] * p_.weight[i] * (without[i] * without[i] - with[i] * with[i]);
    return out;
  }

  double place_m = 0.0, delay_s = 0.0;
  TurnedPlaces turned;
  VectorXd side, prior;
  std::vector<bool> turns;  ///< per place
  MatrixXd waves;
  TurningWindows windows;
  Fit fit;
  Index n = 0;

 private:
  const std::vector<Turning>& logs_;
  double length_m_;
  bool closed_;
  Problem p_;
};

/// The nose pitches where banking changes along the road and the car is beside the line about which
/// it leans, which a gyro feels too: up to this share of the lean, by made-up drives.
constexpr double kPitch = 0.04;

/// What the lean takes from the cosine in all, averaged over places by how much the road turns
/// there: the lean into the turn, and half of its 90 % interval.
struct Mean {
  double lean = 0.0, ci90 = 0.0;
};
Mean mean_over(const Fitting& f, const std::vector<Index>& places) {
  VectorXd share = VectorXd::Zero(f.waves.rows());
  for (const Index k : places) share[k] = std::abs(f.turned.turned_rad[k]);
  share /= std::max(1e-300, share.sum());
  const VectorXd w = f.waves.transpose() * share;
  const double deficit = share.dot(f.turned.deficit) + w.dot(f.fit.amount.head(f.n));
  const double half =
      selection::k90 * std::sqrt(w.dot(f.fit.covariance.topLeftCorner(f.n, f.n) * w));
  const double lean = tangent_of(deficit);
  return {lean, std::hypot(kPitch * lean, std::max(tangent_of(deficit + half) - lean,
                                                   lean - tangent_of(deficit - half)))};
}

/// Half of the way that is turned there leans more, half less: the ends of a turn count little.
double median_over(const Fitting& f, const std::vector<BankingPlace>& places,
                   const std::vector<Index>& in) {
  std::vector<std::pair<double, double>> lean;
  double all = 0.0;
  for (const Index k : in) {
    const double turned = std::abs(f.turned.turned_rad[k]);
    lean.emplace_back(f.side[k] * places[static_cast<std::size_t>(k)].added, turned);
    all += turned;
  }
  std::sort(lean.begin(), lean.end());
  double sum = 0.0;
  for (const auto& [value, turned] : lean)
    if ((sum += turned) >= 0.5 * all) return value;
  return 0.0;
}

/// Where the road leans for sure at least half of the most that it does, beyond the file.
std::vector<Index> leaning(const std::vector<BankingPlace>& places,
                           const std::vector<bool>& turns) {
  double most = 0.0;
  for (std::size_t k = 0; k < places.size(); ++k)
    if (turns[k] && std::abs(places[k].added) > places[k].ci90)
      most = std::max(most, std::abs(places[k].added));
  std::vector<Index> out;
  for (std::size_t k = 0; k < places.size(); ++k)
    if (const BankingPlace& p = places[k];
        turns[k] && std::abs(p.added) - p.ci90 > std::max(0.5 * most, kRoad[0].least))
      out.push_back(static_cast<Index>(k));
  return out;
}

}  // namespace

BankingByTurning banking_by_turning(const std::vector<Turning>& logs, double length_m,
                                    bool closed) {
  BankingByTurning out;
  for (const Turning& log : logs) out.by = std::max(out.by, log.by);
  if (out.by == TurningBy::kNone) return out;
  Fitting f(logs, length_m, closed);
  if (f.side.cwiseAbs().maxCoeff() == 0 || !f.run()) return out;
  out.windows = static_cast<std::size_t>(f.windows.more_rad.size());
  out.delay_s = f.delay_s;
  out.gain = f.fit.amount[f.n + kGain];
  out.bias_radps = f.fit.amount[f.n + kBias];
  const std::vector<double> saved = f.saved();
  out.saved = std::accumulate(saved.begin(), saved.end(), 0.0);
  double square = 0.0;
  for (std::size_t k = 0; k < saved.size(); ++k) {
    const auto count =
        std::count(f.windows.fold.begin(), f.windows.fold.end(), static_cast<int>(k));
    const double usual = static_cast<double>(count) / static_cast<double>(out.windows) * out.saved;
    square += (saved[k] - usual) * (saved[k] - usual);
  }
  out.threshold = std::max(selection::kProfileGain, selection::kProfileSure * std::sqrt(square));

  const VectorXd more = f.waves * f.fit.amount.head(f.n);
  const MatrixXd covariance = f.fit.covariance.topLeftCorner(f.n, f.n);
  for (Index k = 0; k < more.size(); ++k) {
    const auto wave = f.waves.row(k);
    const double half = selection::kWiderProfile * selection::k90 *
                        std::sqrt(wave.dot(covariance * wave.transpose()));
    const double deficit = f.turned.deficit[k] + more[k], lean = tangent_of(deficit);
    double ci90 = std::max(tangent_of(deficit + half) - lean, lean - tangent_of(deficit - half));
    if (!f.turns[static_cast<std::size_t>(k)]) ci90 = std::max(ci90, lean);  // nothing is seen
    out.places.push_back({static_cast<double>(k) * f.place_m, f.side[k] * lean - f.turned.bank[k],
                          ci90, f.turned.v_m[k]});
  }
  const std::vector<Index> in = leaning(out.places, f.turns);
  for (const Index k : in) {
    const double u_m = out.places[static_cast<std::size_t>(k)].u_m;
    const double begin = std::max(0.0, u_m - 0.5 * f.place_m),
                 end = std::min(length_m, u_m + 0.5 * f.place_m);
    if (!out.where_m.empty() && begin - out.where_m.back().second < 4 * f.place_m)
      out.where_m.back().second = end;
    else
      out.where_m.emplace_back(begin, end);
  }
  if (!in.empty()) {
    out.lean = median_over(f, out.places, in);
    out.lean_ci90 = mean_over(f, in).ci90;
    out.counts = out.saved > out.threshold && out.lean > out.lean_ci90;
  }
  std::vector<Index> turning;
  for (Index k = 0; k < f.side.size(); ++k)
    if (f.turns[static_cast<std::size_t>(k)]) turning.push_back(k);
  const Mean m = mean_over(f, turning);
  out.limit = m.lean + m.ci90;
  return out;
}

}  // namespace explain
