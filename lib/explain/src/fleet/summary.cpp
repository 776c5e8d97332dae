// The rows of one analysis at the stated inputs, summed.
#include "explain/summary.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "analysis.h"
#include "information.h"
#include "plausible.h"
#include "vehicle/error.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kKnot_m = 25.0;  ///< between knots, about: corners are longer
/// Of the road beside which the noise is taken, in steps of its kind.
constexpr double kRoadMayBeOff = 3.0;

std::uint32_t knots_of(double length_m) {
  return static_cast<std::uint32_t>(
      std::clamp(std::round(length_m / kKnot_m), 1.0 * kLeastKnots, 1.0 * kMostKnots));
}

/// Name and constants, but for the engine speed at which a rise time holds, which each drive has
/// its own of.
std::string key_of(const Unknown& u) {
  std::string out = u.id + "|" + u.channel + "|" + u.name;
  for (const auto& [name, value] : u.constants)
    if (name != "turbo.reference_radps") out += "|" + name + "=" + std::to_string(value);
  return out;
}

/// One standard deviation of what a sensor of a drive gets wrong where nobody looked.
double usual(const Unknown& u) {
  if (u.kind == "environment") return 2 * u.step;
  if (u.in_time) return 2 * u.step;
  return u.beside_road.rival > 0 ? u.beside_road.rival : u.step;
}

/// Beside that of the lateral speed it would say where the centre of mass lies, which forces alone
/// tell: they would make one of a banking.
bool is_arm_of_antenna(const Unknown& u, const Signals& s) {
  return u.id == kSensorLeverArm && u.channel.starts_with(s.column[kX] + ",");
}

SummaryColumn column_of(const Unknown& u, double prior_width) {
  SummaryColumn out;
  out.key = key_of(u);
  out.id = u.id;
  out.channel = u.channel;
  out.name = u.name;
  for (const auto& [name, value] : u.constants)
    if (name == "turbo.rise_s") out.name += fmt::format(" ({} {:.3g})", name, value);
  out.unit = u.unit;
  const bool sensor = u.kind == "sensor" || u.kind == "environment" || u.beside_road.rival > 0;
  out.of_car = !sensor;
  out.candidate = u.role == Role::kCandidate && !sensor;
  out.parameter = u.role == Role::kParameter && !u.assumed && !u.stays_held;
  out.one_sided = u.one_sided;
  out.stated = u.stated;
  out.deviation = sensor && u.role == Role::kCandidate ? usual(u)
                  : u.role == Role::kCandidate         ? 1.0
                                                       : prior_width;
  out.width = u.width;
  out.form = u.form;
  out.least = u.least;
  out.most = std::min(u.most, 1e300);
  return out;
}

/// Rows and what moves them, not whitened.
struct Design {
  VectorXd r;
  MatrixXd road;            ///< per row: what one unit of each kind does there
  MatrixXd others;          ///< per row and SummaryColumn
  std::vector<Index> knot;  ///< per row: the one before it
  VectorXd share;           ///< of the next one
};

void place_knots(Design& d, const Rows& rows, const DriveSummary& s) {
  const Index knots = s.knots, spaces = s.closed ? knots : knots - 1;
  d.share.resize(d.r.size());
  for (Index i = 0; i < d.r.size(); ++i) {
    const double place =
        rows.row[static_cast<std::size_t>(i)].u_m / s.length_m * static_cast<double>(spaces);
    const Index at = std::clamp<Index>(static_cast<Index>(place), 0, spaces - 1);
    d.knot.push_back(at);
    d.share[i] = std::clamp(place - static_cast<double>(at), 0.0, 1.0);
  }
}

Information sums_of(const Design& d, const VectorXd& weight, const DriveSummary& s,
                    const std::vector<bool>& counts) {
  const Index knots = s.knots, road = knots * static_cast<Index>(kRoadKinds), q = d.others.cols();
  const auto kinds = static_cast<Index>(kRoadKinds);
  Information out;
  VectorXd right = VectorXd::Zero(road + q);
  MatrixXd knot = MatrixXd::Zero(kinds, kinds * knots), next = knot,
           across = MatrixXd::Zero(q, road), among = MatrixXd::Zero(q, q);
  std::vector<Index> in;
  for (Index i = 0; i < d.r.size(); ++i)
    if (counts[static_cast<std::size_t>(i)] && weight[i] > 0) in.push_back(i);
  const VectorXd w = weight(in), r = w.cwiseProduct(d.r(in));
  const MatrixXd x = w.asDiagonal() * d.others(in, Eigen::all);
  among.selfadjointView<Eigen::Lower>().rankUpdate(x.transpose());
  right.tail(q) = x.transpose() * r;
  for (std::size_t k = 0; k < in.size(); ++k) {
    const auto row = static_cast<Index>(k);
    const Index i = in[k], a = d.knot[static_cast<std::size_t>(i)], b = (a + 1) % knots;
    const VectorXd unit = w[row] * d.road.row(i).transpose();
    const double far = d.share[i], near = 1 - far;
    const MatrixXd square = unit * unit.transpose();
    knot.middleCols(a * kinds, kinds) += near * near * square;
    knot.middleCols(b * kinds, kinds) += far * far * square;
    next.middleCols(a * kinds, kinds) += near * far * square;
    right.segment(a * kinds, kinds) += near * r[row] * unit;
    right.segment(b * kinds, kinds) += far * r[row] * unit;
    const MatrixXd with = x.row(row).transpose() * unit.transpose();
    across.middleCols(a * kinds, kinds) += near * with;
    across.middleCols(b * kinds, kinds) += far * with;
  }
  out.rows = static_cast<double>(in.size());
  out.square = r.squaredNorm();
  out.right.assign(right.data(), right.data() + right.size());
  // Products of a knot's kinds are symmetric; those with the next knot's too, as both are of one
  // row's units.
  out.knot.assign(knot.data(), knot.data() + knot.size());
  out.next.assign(next.data(), next.data() + next.size());
  const MatrixXd by_column = across.transpose();
  out.across.assign(by_column.data(), by_column.data() + by_column.size());
  for (Index k = 0; k < q; ++k)
    for (Index l = 0; l <= k; ++l) out.among.push_back(among(k, l));
  return out;
}

/// What is left where road and all that is no candidate are fitted with their priors.
VectorXd left_over(const Design& d, const VectorXd& weight, const DriveSummary& s) {
  const std::vector<bool> all(static_cast<std::size_t>(d.r.size()), true);
  const Information sums = sums_of(d, weight, s, all);
  MatrixXd normal = whole_matrix(sums, s);
  VectorXd right =
      Eigen::Map<const VectorXd>(sums.right.data(), static_cast<Index>(sums.right.size()));
  const auto road = static_cast<Index>(s.road_columns());
  for (Index k = 0; k < normal.rows(); ++k) {
    const double deviation =
        k < road ? kRoadMayBeOff * kRoad[static_cast<std::size_t>(k) % kRoadKinds].step
                 : s.columns[static_cast<std::size_t>(k - road)].deviation;
    normal(k, k) += 1 / (deviation * deviation);
    if (k < road || !s.columns[static_cast<std::size_t>(k - road)].candidate) continue;
    normal.row(k).setZero(), normal.col(k).setZero();
    normal(k, k) = 1.0, right[k] = 0.0;
  }
  const VectorXd amount = normal.ldlt().solve(right);
  VectorXd e = d.r - d.others * amount.tail(d.others.cols());
  for (Index i = 0; i < e.size(); ++i) {
    const Index a = d.knot[static_cast<std::size_t>(i)], b = (a + 1) % static_cast<Index>(s.knots);
    const auto kinds = static_cast<Index>(kRoadKinds);
    e[i] -= d.road.row(i).dot((1 - d.share[i]) * amount.segment(a * kinds, kinds) +
                              d.share[i] * amount.segment(b * kinds, kinds));
  }
  return e;
}

}  // namespace

void Analysis::summarise(DriveSummary& out) {
  const Signals& first = logs_.front();
  out.length_m = first.length_m;
  out.closed = first.closed;
  out.knots = knots_of(out.length_m);
  out.laps = static_cast<std::uint32_t>(rows_.laps);
  for (const Signals& s : logs_) out.driven_s += static_cast<double>(s.n) * Signals::kStep_s;
  look();
  Design d;
  d.r = r_;
  place_knots(d, rows_, out);
  d.road = MatrixXd::Zero(d.r.size(), kRoadKinds);
  std::vector<const Unknown*> moved;
  std::vector<Index> column;  // of `moved`: in the road's (negative, less one) or in the others'
  std::size_t alike = 0;
  for (std::size_t k = 0; k < inventory_.unknowns.size(); ++k) {
    const Unknown& u = inventory_.unknowns[k];
    // Of those that differ in a constant alone, every second: between them nothing is lost.
    const Unknown* const before = k > 0 ? &inventory_.unknowns[k - 1] : nullptr;
    alike = before != nullptr && before->id == u.id && !u.constants.empty() ? alike + 1 : 0;
    if (alike % 2 == 1 || is_arm_of_antenna(u, first)) continue;
    const auto kind =
        std::find_if(kRoad.begin(), kRoad.end(), [&](const RoadKind& r) { return u.id == r.id; });
    if (kind != kRoad.end()) {
      moved.push_back(&u);
      column.push_back(-1 - (kind - kRoad.begin()));
    } else if (u.kind != "road") {
      const auto place = std::find(refit_.begin(), refit_.end(), k);
      const double prior =
          place == refit_.end() ? 1.0 : width(static_cast<std::size_t>(place - refit_.begin()));
      moved.push_back(&u);
      column.push_back(static_cast<Index>(out.columns.size()));
      out.columns.push_back(column_of(u, prior));
      // The same name twice (shapes of a curve) is not the same thing.
      auto& key = out.columns.back().key;
      const auto same = std::count_if(
          out.columns.begin(), out.columns.end() - 1,
          [&](const auto& c) { return c.key == key || c.key.starts_with(key + "#"); });
      if (same > 0) key += "#" + std::to_string(same);
    }
  }
  MatrixXd moves =
      derivatives(logs_, car_, setting_with(amounts_), moved, drives_, rows_, options_.threads,
                  [&](double share) { progress("one derivative per mechanism", share); });
  // To both sides where time moves: the noise of what is read later would speak for reading it
  // later.
  std::vector<Unknown> back;
  std::vector<Index> in_time;
  for (std::size_t k = 0; k < moved.size(); ++k) {
    if (!moved[k]->in_time) continue;
    back.push_back(*moved[k]);
    back.back().step *= -1;
    in_time.push_back(static_cast<Index>(k));
  }
  std::vector<const Unknown*> backwards;
  backwards.reserve(back.size());
  for (const Unknown& u : back) backwards.push_back(&u);
  const MatrixXd other_side = derivatives(logs_, car_, setting_with(amounts_), backwards, drives_,
                                          rows_, options_.threads, {});
  for (std::size_t k = 0; k < in_time.size(); ++k)
    moves.col(in_time[k]) = 0.5 * (moves.col(in_time[k]) + other_side.col(static_cast<Index>(k)));
  d.others.resize(d.r.size(), static_cast<Index>(out.columns.size()));
  for (std::size_t k = 0; k < moved.size(); ++k)
    (column[k] < 0 ? d.road.col(-1 - column[k]) : d.others.col(column[k])) =
        moves.col(static_cast<Index>(k));
  Noise noise = noise_of(rows_, d.r, training_);
  for (int round = 0; round < 2; ++round)
    noise = noise_of(rows_, left_over(d, noise.weight, out), training_);
  weight_ = noise.weight, sigma_ = noise.sigma, spread_ = noise.spread;
  const VectorXd careful = careful_weights();
  std::vector<bool> sensors, forces;
  for (const Row& row : rows_.row) {
    sensors.push_back(relations()[row.relation].sensors_only);
    forces.push_back(!sensors.back());
  }
  out.by_sensors = sums_of(d, careful, out, sensors);
  out.by_forces = sums_of(d, careful, out, forces);
}

DriveSummary summarise(const std::vector<Signals>& logs, const vehicle::Vehicle& car,
                       const ExplainOptions& options) {
  if (logs.empty()) throw vehicle::Error("no recordings");
  double rounds = 0.0;
  for (const Signals& s : logs) rounds += s.rounds;
  if (logs.front().closed && rounds < kTwoRounds)
    throw vehicle::Error(logs.front().name +
                         ": less than two laps; a place that was passed once does not tell the "
                         "road from chance: give two laps or more");
  DriveSummary out;
  Analysis analysis(logs, car, options);
  analysis.summarise(out);
  return out;
}

}  // namespace explain
