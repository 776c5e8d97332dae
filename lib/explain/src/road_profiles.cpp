#include "road_profiles.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/parallel.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Of a profile: how large it is, in steps of its unknown, and over how many metres it stays alike.
struct Roughness {
  double size = 1.0, length_m = 240.0;
};
constexpr double kSizes[] = {0.1, 0.3, 1.0, 3.0, 10.0, 30.0};
constexpr double kLengths_m[] = {60.0, 120.0, 240.0, 480.0};
constexpr double kPlace_m = 10.0;  ///< between places, about
constexpr double kShortestWave_m = 40.0;
constexpr std::size_t kMostColumns = 241;
constexpr double kLeastGain =
    30.0;  ///< of squares, in standard deviations squared, on what was left out
constexpr double kOneStretch_m = 640.0;  ///< a stretch this long is looked for by itself
constexpr double kLate_s = 0.01;
constexpr double kCarMayBeOff = 3.0;  ///< usual errors of its numbers
constexpr double kStride =
    3.0;  ///< steps of a sensor's error at once: a filter is not linear in its time

struct Profile {
  std::size_t unknown = 0;  ///< in the inventory
  Index column = 0;         ///< the first in the design matrix
  bool in = true;
  Roughness roughness;
  MatrixXd shapes;
  VectorXd amounts;
};

struct SensorError {
  std::size_t unknown = 0;
  double amount = 0.0;
  UsualError usual;
};

/// The rows at the present amounts as a linear problem, both sides whitened.
struct Linear {
  MatrixXd x;
  VectorXd y;  ///< the residual and what the amounts explain of it already
};

/// Its sums per fold, from which any choice of columns is solved.
struct Folds {
  std::vector<MatrixXd> normal;
  std::vector<VectorXd> right;
};

Folds folds_of(const Linear& l, const Rows& rows) {
  Folds out;
  std::vector<std::vector<Index>> members(static_cast<std::size_t>(rows.folds));
  for (Index i = 0; i < l.x.rows(); ++i)
    if (l.y[i] != 0)
      members[static_cast<std::size_t>(rows.row[static_cast<std::size_t>(i)].fold)].push_back(i);
  for (const std::vector<Index>& in : members) {
    const MatrixXd part = l.x(in, Eigen::all);
    MatrixXd normal = MatrixXd::Zero(l.x.cols(), l.x.cols());
    normal.selfadjointView<Eigen::Lower>().rankUpdate(part.transpose());
    out.normal.push_back(normal.selfadjointView<Eigen::Lower>());
    out.right.emplace_back(part.transpose() * l.y(in));
  }
  return out;
}

std::vector<Index> columns_in(const VectorXd& precision) {
  std::vector<Index> in;
  for (Index k = 0; k < precision.size(); ++k)
    if (precision[k] >= 0) in.push_back(k);
  return in;
}

/// What each fold's squares lose by what the other folds say; columns of negative precision are
/// out.
std::vector<double> saved_left_out(const Folds& f, const VectorXd& precision) {
  const std::vector<Index> in = columns_in(precision);
  MatrixXd sum = MatrixXd::Zero(precision.size(), precision.size());
  VectorXd right = VectorXd::Zero(precision.size());
  for (std::size_t k = 0; k < f.normal.size(); ++k) sum += f.normal[k], right += f.right[k];
  std::vector<double> out;
  for (std::size_t k = 0; k < f.normal.size(); ++k) {
    MatrixXd a = (sum - f.normal[k])(in, in);
    a.diagonal() += precision(in);
    steady(a);
    const VectorXd amount = a.ldlt().solve((right - f.right[k])(in));
    out.push_back(2 * amount.dot(f.right[k](in)) - amount.dot(f.normal[k](in, in) * amount));
  }
  return out;
}

double sum_of(const std::vector<double>& x) {
  double sum = 0;
  for (const double v : x) sum += v;
  return sum;
}

/// 1 / variance of the waves' amounts: `size` in all, long waves first.
VectorXd precision_of(const Profile& p, const Unknown& u, double length_m, bool closed) {
  const Index skipped = p.shapes.cols() % 2 == 0 && closed ? 1 : 0;  // the constant
  VectorXd variance(p.shapes.cols());
  for (Index k = 0; k < variance.size(); ++k) {
    const double turns = wave_turns(static_cast<std::size_t>(k + skipped), closed);
    const double ratio = turns * p.roughness.length_m / length_m;
    variance[k] = 1 / (1 + ratio * ratio * ratio * ratio);
  }
  const double size = p.roughness.size * u.step;
  return (size * size * variance / (0.5 * variance.sum())).cwiseInverse();
}

/// Per row: what the uniform change does there, times each shape at its place.
MatrixXd along_the_lap(const Rows& rows, const VectorXd& per_unit, const MatrixXd& shapes,
                       double length_m, bool closed) {
  const Index places = shapes.rows(), spaces = closed ? places : places - 1;
  MatrixXd out = MatrixXd::Zero(per_unit.size(), shapes.cols());
  for (Index i = 0; i < out.rows(); ++i) {
    if (!std::isfinite(per_unit[i]) || per_unit[i] == 0) continue;
    const double place =
        rows.row[static_cast<std::size_t>(i)].u_m / length_m * static_cast<double>(spaces);
    const Index at = std::clamp<Index>(static_cast<Index>(place), 0, spaces - 1);
    const double share = place - static_cast<double>(at);
    out.row(i) =
        per_unit[i] * ((1 - share) * shapes.row(at) + share * shapes.row((at + 1) % places));
  }
  return out;
}

/// All profiles and all that the sensors may get wrong, fitted together to what needs no car.
class RoadFit {
 public:
  RoadFit(const std::vector<Signals>& logs, const vehicle::Vehicle& car, const Setting& stated,
          const std::vector<KnownDrive>& drives, const Inventory& inventory, const Rows& rows,
          const std::vector<bool>& training, unsigned threads)
      : logs_(logs),
        car_(car),
        stated_(stated),
        drives_(drives),
        inventory_(inventory),
        rows_(rows),
        training_(training),
        threads_(threads),
        length_m_(logs.front().length_m),
        closed_(logs.front().closed) {
    spaces_ = static_cast<Index>(std::max(8.0, std::round(length_m_ / kPlace_m)));
    const auto columns = static_cast<std::size_t>(2 * length_m_ / kShortestWave_m) | 1u;
    const MatrixXd all = waves(
        static_cast<std::size_t>(closed_ ? spaces_ : spaces_ + 1),
        std::min({columns, kMostColumns, static_cast<std::size_t>(spaces_ - 1) | 1u}), closed_);
    for (std::size_t k = 0; k < inventory.unknowns.size(); ++k) {
      const Unknown& u = inventory.unknowns[k];
      if (u.profile != nullptr) {
        Profile p;
        p.unknown = k;
        p.column = width_;
        p.shapes = closed_ && u.sums_to_nothing ? MatrixXd(all.rightCols(all.cols() - 1)) : all;
        p.amounts = VectorXd::Zero(p.shapes.cols());
        width_ += p.shapes.cols();
        profiles.push_back(std::move(p));
      } else if (u.beside_road.rival > 0) {
        sensors_.push_back({k, 0.0, u.beside_road});
      }
    }
    first_sensor_ = width_;
    width_ += static_cast<Index>(sensors_.size());
  }

  /// Gauss and Newton; the folds are those of the last step.
  void settle(int rounds, const std::function<void()>& done) {
    Linear l;
    for (int round = 0; round < rounds; ++round) {
      const VectorXd r = rows_at(setting());
      l = linear(r);
      solve(l);
      done();
    }
    folds_ = folds_of(l, rows_);
  }

  /// Whether the derivative of the speed behind some filter gives ax better than an accelerometer
  /// on the road that was found: then it says nothing about grade. The force along the car takes
  /// its place, beside all that the stated car may get wrong.
  bool leave_out_derived_ax() {
    if (!logs_.front().present[kAx]) return false;
    const double measured = noise_of(rows_, rows_at(setting()), training_).sigma[Relation::kAccelX];
    double derived = HUGE_VAL;
    for (const double time_s : {0.0, 0.05, 0.1, 0.2, 0.3, 0.45, 0.7, 1.0, 1.5, 2.2, 3.2, 4.5}) {
      std::vector<Residuals> r(logs_.size());
      for (std::size_t k = 0; k < logs_.size(); ++k) {
        for (auto& relation : r[k].r) relation.assign(logs_[k].n, std::nan(""));
        const std::vector<double> ax = lagged(logs_[k].dx[kVx], time_s);
        for (std::size_t i = 0; i < logs_[k].n; ++i)
          r[k].r[Relation::kAccelX][i] = logs_[k].x[kAx][i] - ax[i];
      }
      const double sigma = noise_of(rows_, gather(rows_, r), training_).sigma[Relation::kAccelX];
      if (sigma > 0) derived = std::min(derived, sigma);
    }
    if (!(derived < measured)) return false;
    by_force_ = true;
    for (Profile& p : profiles) p.amounts.setZero();
    for (SensorError& e : sensors_) e.amount = 0.0;
    std::vector<const Unknown*> car;
    for (const Unknown& u : inventory_.unknowns)
      if (u.role != Role::kCandidate && u.beside_road.rival == 0) car.push_back(&u);
    car_precision_ = VectorXd(static_cast<Index>(car.size()));
    for (std::size_t k = 0; k < car.size(); ++k) {
      const double sd = kCarMayBeOff * (car[k]->held > 0 ? car[k]->held : std::hypot(0.5 * car[k]->width, car[k]->form));
      car_precision_[static_cast<Index>(k)] = 1 / (sd * sd);
    }
    car_moves_ = derivatives(logs_, car_, stated_, car, rows_, threads_, {});
    for (Index i = 0; i < car_moves_.rows(); ++i)
      if (rows_.row[static_cast<std::size_t>(i)].relation != Relation::kForceX) car_moves_.row(i).setZero();
    width_ += car_moves_.cols();
    return true;
  }

  /// By the evidence: what large and rough profiles can take the place of counts against them.
  void choose_roughness() {
    MatrixXd normal = MatrixXd::Zero(width_, width_);
    VectorXd right = VectorXd::Zero(width_);
    for (std::size_t k = 0; k < folds_.normal.size(); ++k)
      normal += folds_.normal[k], right += folds_.right[k];
    const auto evidence = [&] {
      const VectorXd prior = precision();
      const std::vector<Index> in = columns_in(prior);
      MatrixXd a = normal(in, in);
      a.diagonal() += prior(in);
      const Eigen::LLT<MatrixXd> solver(a);
      const VectorXd b = right(in);
      return 0.5 * b.dot(solver.solve(b)) - solver.matrixLLT().diagonal().array().log().sum() +
             0.5 * prior(in).array().log().sum();
    };
    for (int sweep = 0; sweep < 2; ++sweep)
      for (Profile& p : profiles) {
        double most = -HUGE_VAL;
        Roughness best;
        for (const double size : kSizes)
          for (const double length_m : kLengths_m) {
            p.roughness = {size, length_m};
            if (const double e = evidence(); e > most) most = e, best = p.roughness;
          }
        p.roughness = best;
      }
  }

  /// What the profile saves on what was left out, beside all errors that sensors may have.
  struct Worth {
    double gain = 0.0, threshold = 0.0;
    bool counts = false;
  };
  Worth worth(const Profile& p) const {
    const std::vector<double> with = saved_left_out(folds_, precision(&UsualError::rival));
    const std::vector<double> without = saved_left_out(folds_, precision(&UsualError::rival, &p));
    std::vector<double> gain = with;
    for (std::size_t k = 0; k < gain.size(); ++k) gain[k] -= without[k];
    const double sum = sum_of(gain), each = sum / static_cast<double>(gain.size());
    double square = 0;
    for (const double g : gain) square += (g - each) * (g - each);
    const double threshold = std::max(kLeastGain, 3 * std::sqrt(square));
    const double size =
        (p.shapes * p.amounts).norm() / std::sqrt(static_cast<double>(p.shapes.rows()));
    return {sum, threshold, sum > threshold && size > inventory_.unknowns[p.unknown].least};
  }

  VectorXd precision(double UsualError::*usual = &UsualError::beside,
                     const Profile* left_out = nullptr) const {
    VectorXd out = VectorXd::Constant(width_, -1.0);
    for (const Profile& p : profiles)
      if (p.in && &p != left_out) out.segment(p.column, p.shapes.cols()) = own_precision(p);
    for (std::size_t k = 0; k < sensors_.size(); ++k)
      if (const double sd = sensors_[k].usual.*usual; sd > 0)
        out[first_sensor_ + static_cast<Index>(k)] = 1 / (sd * sd);
    if (by_force_) out.tail(car_precision_.size()) = car_precision_;
    return out;
  }
  VectorXd own_precision(const Profile& p) const {
    return precision_of(p, inventory_.unknowns[p.unknown], length_m_, closed_);
  }

  /// The larger of its two errors in time, if it is one; else null.
  const SensorError* late_yaw_rate() const {
    const SensorError* out = nullptr;
    for (const SensorError& e : sensors_) {
      if (!inventory_.unknowns[e.unknown].in_time) continue;
      if (e.usual.beside > 0 && e.amount > kLate_s && (out == nullptr || e.amount > out->amount))
        out = &e;
    }
    return out;
  }

  std::vector<Profile> profiles;

 private:
  Setting setting() const {
    Setting s = stated_;
    for (const SensorError& e : sensors_) inventory_.unknowns[e.unknown].set(s, e.amount);
    for (const Profile& p : profiles) {
      if (!p.in) continue;
      const VectorXd values = p.shapes * p.amounts;
      (s.along.*inventory_.unknowns[p.unknown].profile)
          .assign(values.data(), values.data() + values.size());
    }
    return s;
  }

  VectorXd rows_at(const Setting& s) const {
    std::vector<Residuals> r;
    for (std::size_t k = 0; k < logs_.size(); ++k)
      r.push_back(residuals(logs_[k], car_, s, {.known = &drives_[k], .none = true}));
    VectorXd out = gather(rows_, r);
    for (Index i = 0; i < out.size(); ++i)
      if (const std::size_t k = rows_.row[static_cast<std::size_t>(i)].relation;
          by_force_ ? k == Relation::kAccelX || !(relations()[k].sensors_only || k == Relation::kForceX)
                    : !relations()[k].sensors_only)
        out[i] = std::nan("");
    return out;
  }

  /// Weights without outliers: where a road leans most a log tells most.
  VectorXd weights(const VectorXd& r) const {
    const Noise noise = noise_of(rows_, r, training_);
    VectorXd out = VectorXd::Zero(r.size());
    for (Index i = 0; i < r.size(); ++i) {
      const std::size_t k = rows_.row[static_cast<std::size_t>(i)].relation;
      if (noise.weight[i] > 0) out[i] = 1 / (noise.sigma[k] * std::sqrt(noise.spread[k]));
    }
    return out;
  }

  Linear linear(const VectorXd& r) const {
    const VectorXd w = weights(r);
    const Setting here = setting();
    std::vector<std::size_t> moved;
    for (const Profile& p : profiles) moved.push_back(p.unknown);
    for (const SensorError& e : sensors_) moved.push_back(e.unknown);
    MatrixXd per_unit(r.size(), static_cast<Index>(moved.size()));
    base::parallel_for(moved.size(), 1, threads_, [&](std::size_t j, std::size_t) {
      const Unknown& u = inventory_.unknowns[moved[j]];
      // To both sides: the noise of what is read later would speak for reading it later.
      Setting more = here, less = here;
      u.set(more, 0.5 * u.step);
      u.set(less, -0.5 * u.step);
      per_unit.col(static_cast<Index>(j)) = (rows_at(less) - rows_at(more)) / u.step;
    });
    for (Index i = 0; i < r.size(); ++i)
      for (Index k = 0; k < per_unit.cols(); ++k)
        per_unit(i, k) = std::isfinite(r[i] * per_unit(i, k)) ? w[i] * per_unit(i, k) : 0.0;
    Linear l{MatrixXd::Zero(r.size(), width_), VectorXd::Zero(r.size())};
    for (Index i = 0; i < r.size(); ++i)
      if (std::isfinite(r[i])) l.y[i] = w[i] * r[i];
    for (std::size_t k = 0; k < profiles.size(); ++k) {
      const Profile& p = profiles[k];
      const MatrixXd columns =
          along_the_lap(rows_, per_unit.col(static_cast<Index>(k)), p.shapes, length_m_, closed_);
      l.x.middleCols(p.column, columns.cols()) = columns;
      if (p.in) l.y += columns * p.amounts;
    }
    for (std::size_t k = 0; k < sensors_.size(); ++k) {
      const VectorXd column = per_unit.col(static_cast<Index>(profiles.size() + k));
      l.x.col(first_sensor_ + static_cast<Index>(k)) = column;
      l.y += column * sensors_[k].amount;
    }
    if (by_force_) {
      l.x.rightCols(car_moves_.cols()) = w.asDiagonal() * car_moves_;
      for (Index i = 0; i < r.size(); ++i)
        if (!std::isfinite(r[i])) l.x.row(i).tail(car_moves_.cols()).setZero();
    }
    return l;
  }

  void solve(const Linear& l) {
    VectorXd prior = precision();
    VectorXd amounts;
    // What cannot be negative and would be is nothing: delay and filter are alike enough to run
    // apart.
    for (bool again = true; again;) {
      const std::vector<Index> in = columns_in(prior);
      const Fitted f =
          fit(l.x(Eigen::all, in), l.y, prior(in), VectorXd::Zero(static_cast<Index>(in.size())));
      amounts = VectorXd::Zero(width_);
      amounts(in) = f.amount;
      again = false;
      for (std::size_t k = 0; k < sensors_.size(); ++k) {
        const Index at = first_sensor_ + static_cast<Index>(k);
        if (!inventory_.unknowns[sensors_[k].unknown].one_sided || !(amounts[at] < 0)) continue;
        prior[at] = -1.0;
        again = true;
      }
    }
    for (Profile& p : profiles) p.amounts = amounts.segment(p.column, p.shapes.cols());
    for (std::size_t k = 0; k < sensors_.size(); ++k) {
      SensorError& e = sensors_[k];
      const double move = amounts[first_sensor_ + static_cast<Index>(k)] - e.amount;
      const double most = kStride * inventory_.unknowns[e.unknown].step;
      e.amount += std::clamp(move, -most, most);
    }
  }

  const std::vector<Signals>& logs_;
  const vehicle::Vehicle& car_;
  const Setting& stated_;
  const std::vector<KnownDrive>& drives_;
  const Inventory& inventory_;
  const Rows& rows_;
  const std::vector<bool>& training_;
  unsigned threads_;
  double length_m_;
  bool closed_;
  Index spaces_ = 0, width_ = 0, first_sensor_ = 0;
  bool by_force_ = false;    ///< along the car, not by ax
  MatrixXd car_moves_;       ///< of the force along it, per unit of what the stated car may get wrong
  VectorXd car_precision_;
  std::vector<SensorError> sensors_;
  Folds folds_;
};

}  // namespace

double wave_turns(std::size_t column, bool closed) {
  return closed ? static_cast<double>((column + 1) / 2) : 0.5 * static_cast<double>(column);
}

MatrixXd waves(std::size_t places, std::size_t columns, bool closed) {
  MatrixXd out(static_cast<Index>(places), static_cast<Index>(columns));
  for (Index i = 0; i < out.rows(); ++i) {
    const double lap = static_cast<double>(i) / static_cast<double>(closed ? places : places - 1);
    for (Index k = 0; k < out.cols(); ++k) {
      const double angle =
          2 * std::numbers::pi * wave_turns(static_cast<std::size_t>(k), closed) * lap;
      out(i, k) = closed && k % 2 == 0 && k > 0 ? std::sin(angle) : std::cos(angle);
    }
  }
  return out;
}

std::vector<double> values_along(const Accepted& profile) {
  const VectorXd values = profile.shapes * profile.amounts;
  return {values.data(), values.data() + values.size()};
}

void describe_profile(Finding& f, const Unknown& u, const Accepted& a, const VectorXd& amounts,
                      const MatrixXd& covariance, double length_m, bool closed) {
  constexpr double k90 = 1.645, kJoin_m = 40.0, kShortest_m = 20.0;
  // What is shorter than the waves and what the relations get wrong is not in the covariance: on
  // eight drives with known roads errors were 1.6 times as large (docs/proof.md).
  constexpr double kWider = 1.6;
  const VectorXd values = a.shapes * amounts;
  const Index places = values.size();
  const double space_m = length_m / static_cast<double>(closed ? places : places - 1);
  f.profile.clear();
  f.where.clear();
  ProfilePoint most;
  for (Index i = 0; i < places; ++i) {
    const auto shape = a.shapes.row(i);
    const double half =
        kWider * k90 * std::sqrt(std::max(0.0, shape.dot(covariance * shape.transpose())));
    const double u_m = static_cast<double>(i) * space_m;
    f.profile.push_back({u_m, values[i], half});
    if (std::abs(values[i]) - half > std::abs(most.value) - most.ci90) most = f.profile.back();
    if (std::abs(values[i]) < std::max(u.least, half)) continue;
    const double begin = std::max(0.0, u_m - 0.5 * space_m),
                 end = std::min(length_m, u_m + 0.5 * space_m);
    if (!f.where.empty() && begin - f.where.back().u_end_m < kJoin_m)
      f.where.back().u_end_m = end;
    else
      f.where.push_back({begin, end, {}});
  }
  std::erase_if(f.where, [&](const Place& p) { return p.u_end_m - p.u_begin_m < kShortest_m; });
  f.parameters = {{u.name + ", most along the lap", u.unit, most.value, most.value - most.ci90,
                   most.value + most.ci90}};
}

void Analysis::find_road_profiles(Findings& out) {
  RoadFit road(logs_, car_, stated_, drives_, inventory_, rows_, training_, options_.threads);
  if (road.profiles.empty()) return;
  int rounds = 0;
  const auto done = [&] { progress("the road along the lap", std::min(1.0, ++rounds / 32.0)); };
  const auto find = [&] {
    for (int k = 0; k < 8; ++k) {
      road.settle(3, done);
      road.choose_roughness();
    }
    road.settle(2, done);
  };
  find();
  if (road.leave_out_derived_ax()) find();
  // Without what says nothing the others settle again.
  for (bool again = true; again;) {
    again = false;
    for (Profile& p : road.profiles) {
      if (!p.in || road.worth(p).counts) continue;
      p.in = false;
      road.settle(3, done);
      again = true;
      break;
    }
  }
  std::vector<const Unknown*> found;
  for (const Profile& p : road.profiles) {
    if (!p.in) continue;
    const Unknown& u = inventory_.unknowns[p.unknown];
    Finding f = finding_of(p.unknown);
    const RoadFit::Worth worth = road.worth(p);
    f.cv_gain = worth.gain;
    f.threshold = worth.threshold;
    f.statistic = std::sqrt(worth.gain);
    Accepted a;
    a.unknown = p.unknown;
    a.precision = road.own_precision(p);
    a.shapes = p.shapes;
    a.amounts = p.amounts;
    a.columns = MatrixXd::Zero(static_cast<Index>(rows_.row.size()), p.shapes.cols());  // below
    describe_profile(f, u, a, a.amounts, MatrixXd::Zero(a.shapes.cols(), a.shapes.cols()),
                     logs_.front().length_m, logs_.front().closed);
    // What one stretch says is found as one, by the search that tries every stretch.
    double length_m = 0;
    for (const Place& w : f.where) length_m += w.u_end_m - w.u_begin_m;
    if (f.where.empty() || (f.where.size() == 1 && length_m < kOneStretch_m)) continue;
    found.push_back(&u);
    accepted_.push_back(std::move(a));
    out.findings.push_back(std::move(f));
  }
  if (found.empty()) return;
  // A yaw rate that comes late was told beside them.
  if (const SensorError* late = road.late_yaw_rate()) {
    Accepted a;
    a.unknown = late->unknown;
    a.amount = late->amount;
    a.kinematic = true;
    Finding f = finding_of(late->unknown);
    accepted_.push_back(std::move(a));
    out.findings.push_back(std::move(f));
    amounts_.conservativeResize(amounts_.size() + 1);
    amounts_[amounts_.size() - 1] = late->amount;
  }
  // With forces, which lean on the road as well.
  const MatrixXd per_unit =
      derivatives(logs_, car_, setting_with(amounts_), found, rows_, options_.threads, {});
  for (std::size_t k = 0; k < found.size(); ++k) {
    Accepted& a = accepted_[k];
    a.columns = along_the_lap(rows_, per_unit.col(static_cast<Index>(k)), a.shapes,
                              logs_.front().length_m, logs_.front().closed);
  }
}

}  // namespace explain
