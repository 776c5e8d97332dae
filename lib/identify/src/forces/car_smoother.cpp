#include "car_smoother.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace identify {
namespace {

using Index = Eigen::Index;
constexpr double kJudgedWithin_s = 0.25,
                 kEnough = 50.0;  // measurements that tell whether noises hold
constexpr double kWild = 4.0;     // standard deviations from which a measurement counts less

/// One number that was measured, as the filter took it.
struct Update {
  std::size_t sensor = 0;
  PlaceVector gain, by;     ///< by: derivative of what is measured
  double innovation = 0.0;  ///< against what the numbers before it left
  double variance = 1.0;    ///< of the innovation
  double first = 0.0;       ///< measured minus predicted, at the prediction
  bool wild = false;
};

/// A row as the filter left it behind.
struct Passed {
  CarPoint predicted;
  PlaceMatrix covariance;  ///< of the prediction
  StepMatrix by;           ///< d this row / d the row before
  std::vector<Update> updates;
  double squares = 0.0;  ///< of the innovations over their variances, before wild ones were tamed
};

/// What a sensor should show at the point, and its derivative.
double expected(const Sensor& sensor, const CarPoint& point, const Seen& seen, PlaceVector& by) {
  by.setZero();
  double value = 0.0;
  if (sensor.seen) {
    by.head<kMovingPlaces>() = seen.by.row(static_cast<Index>(sensor.place)).transpose();
    value = seen.value[sensor.place];
  } else {
    by[static_cast<Index>(sensor.place)] = 1.0;
    value = point.at(sensor.place);
  }
  if (sensor.share < kPlaces) {
    const double share = point.at(sensor.share);
    by *= 1.0 + share;
    by[static_cast<Index>(sensor.share)] += value;
    value *= 1.0 + share;
  }
  if (sensor.offset < kPlaces) {
    by[static_cast<Index>(sensor.offset)] += 1.0;
    value += point.at(sensor.offset);
  }
  return value;
}

/// Takes the row's measurements one after the other; `covariance` becomes that after them, the
/// return value is how far the point moves.
PlaceVector take(const std::vector<Sensor>& sensors, const SmootherRow& row, const Seen& seen,
                 Passed& passed, PlaceMatrix& covariance) {
  PlaceVector moved = PlaceVector::Zero();
  for (const Reading& m : row.measured) {
    const Sensor& sensor = sensors[m.sensor];
    Update u;
    u.sensor = m.sensor;
    u.first = m.value - expected(sensor, passed.predicted, seen, u.by);
    u.innovation = u.first - u.by.dot(moved);
    const PlaceVector spread = covariance * u.by;
    u.variance = u.by.dot(spread) + sensor.deviation * sensor.deviation;
    passed.squares += std::min(u.innovation * u.innovation / u.variance, kWild * kWild);
    u.wild = std::abs(u.innovation) > kWild * std::sqrt(u.variance);
    if (u.wild) u.variance = u.innovation * u.innovation / (kWild * kWild);
    u.gain = spread / u.variance;
    moved += u.innovation * u.gain;
    // Joseph's form: what rounding does to the gain counts in the second order only.
    const PlaceVector half = spread - 0.5 * u.variance * u.gain;
    covariance.noalias() -= u.gain * half.transpose();
    covariance.noalias() -= half * u.gain.transpose();
    passed.updates.push_back(u);
  }
  covariance = 0.5 * (covariance + covariance.transpose()).eval();
  return moved;
}

void move_by(CarPoint& point, const PlaceVector& by) {
  for (std::size_t i = 0; i < kPlaces; ++i) point.at(i) += by[static_cast<Index>(i)];
  for (std::size_t i = kPlaceParts; i < kChangingPlaces; ++i)
    point.at(i) = std::clamp(point.at(i), -kMostOff, kMostOff);
  for (std::size_t i = kPlaceStated; i < kMovingPlaces; ++i)
    point.at(i) = std::clamp(point.at(i), -kMostStatedOff, kMostStatedOff);
}

bool any_seen(const std::vector<Sensor>& sensors, const SmootherRow& row) {
  return std::any_of(row.measured.begin(), row.measured.end(),
                     [&](const Reading& m) { return sensors[m.sensor].seen; });
}

double deviation(double variance) { return std::sqrt(std::max(0.0, variance)); }

/// Everything that is told of a row at its smoothed point.
void describe(SmoothedRow& out, const PlaceMatrix& covariance) {
  for (std::size_t i = 0; i < kPlaces; ++i)
    out.point_sd[i] = deviation(covariance(static_cast<Index>(i), static_cast<Index>(i)));
  const auto moving = covariance.topLeftCorner<kMovingPlaces, kMovingPlaces>();
  const Eigen::Matrix<double, kSeen, kMovingPlaces> spread = out.seen.by * moving;
  for (std::size_t i = 0; i < kSeen; ++i)
    out.seen_sd[i] =
        deviation(spread.row(static_cast<Index>(i)).dot(out.seen.by.row(static_cast<Index>(i))));
  for (std::size_t a = 0; a < 2; ++a)
    for (const SeenOfWheel what : {kSeenFx, kSeenFy, kSeenFz}) {
      const std::size_t left = seen_of(2 * a, what), right = seen_of(2 * a + 1, what);
      out.axle[a][what] = out.seen.value[left] + out.seen.value[right];
      const auto both =
          (out.seen.by.row(static_cast<Index>(left)) + out.seen.by.row(static_cast<Index>(right)))
              .eval();
      out.axle_sd[a][what] = deviation((both * moving).dot(both));
    }
}

constexpr auto kChange = static_cast<Index>(kChangingPlaces),
               kStay = static_cast<Index>(kPlaces - kChangingPlaces);

/// From a row to the next one; a change of gear lies between them.
bool pass(const CarMotion& motion, const SmootherRow& last, const SmootherRow& next,
          CarPoint& point, vehicle::RoadCursors& cursors, StepMatrix& by) {
  const double dt = next.time_s - last.time_s;
  if (last.driven.gear == next.driven.gear) return motion.move(point, dt, last.driven, cursors, by);
  Driven shifted = next.driven;
  shifted.feet_per_s = last.driven.feet_per_s;
  StepMatrix second;
  if (!motion.move(point, 0.5 * dt, last.driven, cursors, by) ||
      !motion.move(point, 0.5 * dt, shifted, cursors, second))
    return false;
  by = (second.leftCols<kChange>() * by).eval();
  by.rightCols<kStay>() += second.rightCols<kStay>();
  return true;
}

/// The covariance behind a step: what stays keeps its own.
void carry(const StepMatrix& by, PlaceMatrix& covariance) {
  const StepMatrix half = by * covariance;
  covariance.topLeftCorner<kChange, kChange>().noalias() = half * by.transpose();
  covariance.topRightCorner<kChange, kStay>() = half.rightCols<kStay>();
  covariance.bottomLeftCorner<kStay, kChange>() = half.rightCols<kStay>().transpose();
}

/// What later rows say, and how firmly, as seen from before a step.
void carry_back(const StepMatrix& by, PlaceVector& pull, PlaceMatrix& firm) {
  const Eigen::Matrix<double, kStay, 1> stay = pull.tail<kStay>();
  pull = (by.transpose() * pull.head<kChange>()).eval();
  pull.tail<kStay>() += stay;
  PlaceMatrix half;
  half.noalias() = firm.leftCols<kChange>() * by;
  half.rightCols<kStay>() += firm.rightCols<kStay>();
  firm.noalias() = by.transpose() * half.topRows<kChange>();
  firm.bottomRows<kStay>() += half.bottomRows<kStay>();
}

/// Factors on the deviations of all rows: above 1 where, a quarter of a second around, measurements
/// are further from the filtered car than their noises say (R. T. Birge, The calculation of errors
/// by the method of least squares, 1932): on kerbs, and where the car is another.
std::vector<double> doubts(const std::vector<SmootherRow>& rows,
                           const std::vector<Passed>& passed) {
  std::vector<double> out(rows.size(), 1.0);
  std::size_t from = 0, to = 0;
  double squares = 0.0, count = 0.0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    for (; to < rows.size() && rows[to].time_s <= rows[k].time_s + kJudgedWithin_s; ++to) {
      squares += passed[to].squares;
      count += static_cast<double>(passed[to].updates.size());
    }
    for (; rows[from].time_s < rows[k].time_s - kJudgedWithin_s; ++from) {
      squares -= passed[from].squares;
      count -= static_cast<double>(passed[from].updates.size());
    }
    if (count >= kEnough) out[k] = std::sqrt(std::max(1.0, squares / count));
  }
  return out;
}

void widen(SmoothedRow& row, double factor) {
  for (double& sd : row.point_sd) sd *= factor;
  for (double& sd : row.seen_sd) sd *= factor;
  for (auto& axle : row.axle_sd)
    for (double& sd : axle) sd *= factor;
}

/// Of the begin: a part is as far off as its rest, and differs from it; stated numbers hardly move.
PlaceMatrix begin_covariance(PlaceVector sd) {
  sd.segment<kMovingPlaces - kPlaceStated>(kPlaceStated) *= kHeld;
  PlaceMatrix out = sd.cwiseAbs2().asDiagonal();
  for (std::size_t i = kPlaceParts; i < kChangingPlaces; ++i) {
    const auto part = static_cast<Index>(i), rest = static_cast<Index>(rest_of(i));
    out(part, part) += out(rest, rest);
    out(part, rest) = out(rest, part) = out(rest, rest);
  }
  return out;
}

/// The estimate for stated numbers as they are stated, and what they may be off by: considered, not
/// estimated (S. F. Schmidt, Application of state-space methods to navigation problems, 1966). A
/// car of other equations than the recorded one's would turn them into whatever mends these.
class Considered {
 public:
  explicit Considered(const SmootherBegin& begin) : begin_(begin) {
    for (std::size_t i = kPlaceStated; i < kMovingPlaces; ++i)
      if (begin.sd[static_cast<Index>(i)] > 0.0) places_.push_back(static_cast<Index>(i));
    if (begin.steer_offset_known) places_.push_back(static_cast<Index>(kPlaceSteerOffset));
  }

  /// Moves the estimate; `covariance` becomes that of the stated numbers being right, the return
  /// value is what their uncertainty adds to it.
  PlaceMatrix hold(const CarPoint& predicted, PlaceVector& moved, PlaceMatrix& covariance) const {
    if (places_.empty()) return PlaceMatrix::Zero();
    const auto n = static_cast<Index>(places_.size());
    Eigen::MatrixXd across(kPlaces, n), own(n, n);
    Eigen::VectorXd back(n), sd(n);
    for (Index j = 0; j < n; ++j) {
      const Index at = places_[static_cast<std::size_t>(j)];
      const auto place = static_cast<std::size_t>(at);
      across.col(j) = covariance.col(at);
      back[j] = begin_.point.at(place) - predicted.at(place) - moved[at];
      sd[j] = begin_.sd[at];
    }
    for (Index j = 0; j < n; ++j) own.row(j) = across.row(places_[static_cast<std::size_t>(j)]);
    const Eigen::MatrixXd slope = own.ldlt().solve(across.transpose()).transpose();
    moved += slope * back;
    covariance -= slope * across.transpose();
    const Eigen::MatrixXd spread = slope * sd.asDiagonal();
    return spread * spread.transpose();
  }

 private:
  const SmootherBegin& begin_;
  std::vector<Index> places_;
};

/// Whether too many of the last quarter of a second's measurements are wild.
class Watch {
 public:
  explicit Watch(double most_wild) : most_wild_(most_wild) {}

  bool lost(const std::vector<SmootherRow>& rows, const std::vector<Passed>& passed,
            std::size_t k) {
    count(passed[k], 1.0);
    for (; rows[from_].time_s < rows[k].time_s - kJudgedWithin_s; ++from_)
      count(passed[from_], -1.0);
    return all_ >= kEnough && wild_ > most_wild_ * all_;
  }

 private:
  void count(const Passed& row, double times) {
    all_ += times * static_cast<double>(row.updates.size());
    for (const Update& u : row.updates) wild_ += u.wild ? times : 0.0;
  }
  double most_wild_, all_ = 0.0, wild_ = 0.0;
  std::size_t from_ = 0;
};

bool filter(const CarMotion& motion, const std::vector<Sensor>& sensors,
            const std::vector<SmootherRow>& rows, const SmootherBegin& begin,
            vehicle::RoadCursors& cursors, std::vector<Passed>& passed) {
  CarPoint point = begin.point;
  PlaceMatrix covariance = begin_covariance(begin.sd);
  passed.resize(rows.size());
  Watch watch(begin.most_wild);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    Passed& now = passed[k];
    if (k > 0) {
      if (!pass(motion, rows[k - 1], rows[k], point, cursors, now.by)) return false;
      carry(now.by, covariance);
      covariance.diagonal() += rows[k].noise;
    }
    now.predicted = point;
    now.covariance = covariance;
    Seen seen;
    if (any_seen(sensors, rows[k])) seen = motion.look(point, rows[k].driven.gear, cursors);
    move_by(point, take(sensors, rows[k], seen, now, covariance));
    if (!covariance.allFinite() || watch.lost(rows, passed, k)) return false;
  }
  return true;
}

}  // namespace

Smoothed smooth(const CarMotion& motion, const std::vector<Sensor>& sensors,
                const std::vector<SmootherRow>& rows, const SmootherBegin& begin,
                vehicle::RoadCursors cursors) {
  Smoothed out;
  std::vector<Passed> passed;
  if (!filter(motion, sensors, rows, begin, cursors, passed)) return out;
  out.row.resize(rows.size());
  out.sums.measured.assign(sensors.size(), 0.0);
  out.sums.count.assign(sensors.size(), 0);
  const std::vector<double> doubt = doubts(rows, passed);
  const Considered considered(begin);
  PlaceVector pull = PlaceVector::Zero();  // what the rows from here on say, and how firmly
  PlaceMatrix firm = PlaceMatrix::Zero();
  for (std::size_t k = rows.size(); k-- > 0;) {
    const Passed& now = passed[k];
    for (auto u = now.updates.rbegin(); u != now.updates.rend(); ++u) {
      const PlaceVector across = firm * u->gain;
      const double along = u->gain.dot(across) + 1.0 / u->variance;
      const PlaceVector half = across - 0.5 * along * u->by;
      firm.noalias() -= half * u->by.transpose();
      firm.noalias() -= u->by * half.transpose();
      pull -= (u->gain.dot(pull) + u->innovation / u->variance) * u->by;
    }
    firm = 0.5 * (firm + firm.transpose()).eval();
    PlaceVector moved = -(now.covariance * pull);
    const PlaceMatrix half = now.covariance * firm;
    PlaceMatrix covariance = now.covariance;
    covariance.noalias() -= half * now.covariance;
    if (k == 0) add_stated(moved, covariance, begin, out.sums);
    const PlaceMatrix more = considered.hold(now.predicted, moved, covariance);
    SmoothedRow& row = out.row[k];
    row.point = now.predicted;
    move_by(row.point, moved);
    row.seen = motion.look(row.point, rows[k].driven.gear, cursors);
    describe(row, covariance + more);
    for (const Update& u : now.updates) {
      if (u.wild) {
        ++out.sums.wild;
        continue;
      }
      const double left = u.first - u.by.dot(moved);
      out.sums.measured[u.sensor] += left * left + std::max(0.0, u.by.dot(covariance * u.by));
      ++out.sums.count[u.sensor];
    }
    const PlaceVector variance = covariance.diagonal();
    add_parts(row.point, variance, begin, out.sums);
    if (k == 0) add_constants(row.point, variance, begin, out.sums);
    widen(row, doubt[k]);
    if (k == 0) break;
    for (std::size_t i = 0; i < kPlaces; ++i) {
      const auto at = static_cast<Index>(i);
      const double q = rows[k].noise[at];
      out.sums.came_in[i] += q * q * (pull[at] * pull[at] - firm(at, at)) + q;
      out.sums.assumed[i] += q;
    }
    carry_back(now.by, pull, firm);
  }
  return out;
}

}  // namespace identify
