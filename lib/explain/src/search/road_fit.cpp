#include "road_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "lap_waves.h"
#include "search.h"
#include "selection.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kSizes[] = {0.1, 0.3, 1.0, 3.0, 10.0, 30.0};
constexpr double kLengths_m[] = {60.0, 120.0, 240.0, 480.0};
constexpr double kPlace_m = 10.0;  ///< between places, about
constexpr double kShortestWave_m = 40.0;
constexpr std::size_t kMostColumns = 241;
constexpr double kCarMayBeOff = 3.0;  ///< usual errors of its numbers
constexpr double kStride =
    3.0;  ///< steps of a sensor's error at once: a filter is not linear in its time

Folds folds_of(const Linear& l, const Rows& rows) {
  Folds out;
  std::vector<std::vector<Index>> members(static_cast<std::size_t>(rows.folds));
  for (Index i = 0; i < l.x.rows(); ++i)
    if (l.y[i] != 0)
      members[static_cast<std::size_t>(rows.row[static_cast<std::size_t>(i)].fold)].push_back(i);
  for (const std::vector<Index>& in : members) {
    if (in.empty()) continue;  // of laps that are held out
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

}  // namespace

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

RoadFit::RoadFit(const std::vector<Signals>& logs, const vehicle::Vehicle& car,
                 const Setting& stated, const std::vector<KnownDrive>& drives,
                 const Inventory& inventory, const Rows& rows, const std::vector<bool>& training,
                 unsigned threads)
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
  const MatrixXd all =
      waves(static_cast<std::size_t>(closed_ ? spaces_ : spaces_ + 1),
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

void RoadFit::settle(int rounds, const std::function<void()>& done) {
  Linear l;
  for (int round = 0; round < rounds; ++round) {
    const VectorXd r = rows_at(setting());
    l = linear(r);
    solve(l);
    done();
  }
  folds_ = folds_of(l, rows_);
}

double RoadFit::derived_ax_deviation() const {
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
  return derived;
}

void RoadFit::go_by_force() {
  by_force_ = true;
  for (Profile& p : profiles) p.amounts.setZero();
  for (SensorError& e : sensors_) e.amount = 0.0;
  std::vector<const Unknown*> car;
  for (const Unknown& u : inventory_.unknowns)
    if (u.role != Role::kCandidate && u.beside_road.rival == 0) car.push_back(&u);
  car_precision_ = VectorXd(static_cast<Index>(car.size()));
  for (std::size_t k = 0; k < car.size(); ++k) {
    const Unknown& u = *car[k];
    const double sd = kCarMayBeOff * (u.held > 0 ? u.held : std::hypot(0.5 * u.width, u.form));
    car_precision_[static_cast<Index>(k)] = 1 / (sd * sd);
  }
  car_moves_ = derivatives(logs_, car_, stated_, car, drives_, rows_, threads_, {});
  for (Index i = 0; i < car_moves_.rows(); ++i)
    if (rows_.row[static_cast<std::size_t>(i)].relation != Relation::kForceX)
      car_moves_.row(i).setZero();
  width_ += car_moves_.cols();
}

bool RoadFit::leave_out_derived_ax() {
  if (!logs_.front().present[kAx]) return false;
  const double measured = noise_of(rows_, rows_at(setting()), training_).sigma[Relation::kAccelX];
  if (!(derived_ax_deviation() < measured)) return false;
  go_by_force();
  return true;
}

double RoadFit::evidence(const MatrixXd& normal, const VectorXd& right) const {
  const VectorXd prior = precision();
  const std::vector<Index> in = columns_in(prior);
  MatrixXd a = normal(in, in);
  a.diagonal() += prior(in);
  const Eigen::LLT<MatrixXd> solver(a);
  const VectorXd b = right(in);
  return 0.5 * b.dot(solver.solve(b)) - solver.matrixLLT().diagonal().array().log().sum() +
         0.5 * prior(in).array().log().sum();
}

void RoadFit::choose_roughness() {
  MatrixXd normal = MatrixXd::Zero(width_, width_);
  VectorXd right = VectorXd::Zero(width_);
  for (std::size_t k = 0; k < folds_.normal.size(); ++k)
    normal += folds_.normal[k], right += folds_.right[k];
  for (int sweep = 0; sweep < 2; ++sweep)
    for (Profile& p : profiles) {
      double most = -HUGE_VAL;
      Roughness best;
      for (const double size : kSizes)
        for (const double length_m : kLengths_m) {
          p.roughness = {size, length_m};
          if (const double e = evidence(normal, right); e > most) most = e, best = p.roughness;
        }
      p.roughness = best;
    }
}

RoadFit::Worth RoadFit::worth(const Profile& p) const {
  const std::vector<double> with = saved_left_out(folds_, precision(&UsualError::rival));
  const std::vector<double> without = saved_left_out(folds_, precision(&UsualError::rival, &p));
  std::vector<double> gain = with;
  for (std::size_t k = 0; k < gain.size(); ++k) gain[k] -= without[k];
  const double sum = sum_of(gain), each = sum / static_cast<double>(gain.size());
  double square = 0;
  for (const double g : gain) square += (g - each) * (g - each);
  const double threshold =
      std::max(selection::kProfileGain, selection::kProfileSure * std::sqrt(square));
  const double size =
      (p.shapes * p.amounts).norm() / std::sqrt(static_cast<double>(p.shapes.rows()));
  return {sum, threshold, sum > threshold && size > inventory_.unknowns[p.unknown].least};
}

VectorXd RoadFit::precision(double UsualError::*usual, const Profile* left_out) const {
  VectorXd out = VectorXd::Constant(width_, -1.0);
  for (const Profile& p : profiles)
    if (p.in && &p != left_out) out.segment(p.column, p.shapes.cols()) = own_precision(p);
  for (std::size_t k = 0; k < sensors_.size(); ++k)
    if (const double sd = sensors_[k].usual.*usual; sd > 0)
      out[first_sensor_ + static_cast<Index>(k)] = 1 / (sd * sd);
  if (by_force_) out.tail(car_precision_.size()) = car_precision_;
  return out;
}

VectorXd RoadFit::own_precision(const Profile& p) const {
  return precision_of(p, inventory_.unknowns[p.unknown], length_m_, closed_);
}

const SensorError* RoadFit::late_yaw_rate() const {
  const SensorError* out = nullptr;
  for (const SensorError& e : sensors_) {
    if (!inventory_.unknowns[e.unknown].in_time) continue;
    if (e.usual.beside > 0 && e.amount > selection::kLate_s &&
        (out == nullptr || e.amount > out->amount))
      out = &e;
  }
  return out;
}

Setting RoadFit::setting() const {
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

VectorXd RoadFit::rows_at(const Setting& s) const {
  std::vector<Residuals> r;
  for (std::size_t k = 0; k < logs_.size(); ++k)
    r.push_back(residuals(logs_[k], car_, s, {.known = &drives_[k], .none = true}));
  VectorXd out = gather(rows_, r);
  for (Index i = 0; i < out.size(); ++i)
    if (const std::size_t k = rows_.row[static_cast<std::size_t>(i)].relation;
        by_force_
            ? k == Relation::kAccelX || !(relations()[k].sensors_only || k == Relation::kForceX)
            : !relations()[k].sensors_only)
      out[i] = std::nan("");
  return out;
}

/// Weights without outliers: where a road leans most a log tells most.
VectorXd RoadFit::weights(const VectorXd& r) const {
  const Noise noise = noise_of(rows_, r, training_);
  VectorXd out = VectorXd::Zero(r.size());
  for (Index i = 0; i < r.size(); ++i) {
    const std::size_t k = rows_.row[static_cast<std::size_t>(i)].relation;
    if (noise.weight[i] > 0) out[i] = 1 / (noise.sigma[k] * std::sqrt(noise.spread[k]));
  }
  return out;
}

MatrixXd RoadFit::per_unit(const VectorXd& r, const VectorXd& w) const {
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
  return per_unit;
}

Linear RoadFit::linear(const VectorXd& r) const {
  const VectorXd w = weights(r);
  const MatrixXd per_unit = this->per_unit(r, w);
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

void RoadFit::solve(const Linear& l) {
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

}  // namespace explain
