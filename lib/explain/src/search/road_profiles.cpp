#include "road_profiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "base/statistics.h"
#include "road_fit.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<double> values_along(const Accepted& profile) {
  const VectorXd values = profile.shapes * profile.amounts;
  return {values.data(), values.data() + values.size()};
}

void describe_profile(Finding& f, const Unknown& u, const Accepted& a, const VectorXd& amounts,
                      const MatrixXd& covariance, double length_m, bool closed) {
  constexpr double kJoin_m = 40.0, kShortest_m = 20.0;
  // What is shorter than the waves and what the relations get wrong is not in the covariance: on
  // eight drives with known roads errors were 1.6 times as large.
  const VectorXd values = a.shapes * amounts;
  const Index places = values.size();
  const double space_m = length_m / static_cast<double>(closed ? places : places - 1);
  f.profile.clear();
  f.where.clear();
  ProfilePoint most;
  for (Index i = 0; i < places; ++i) {
    const auto shape = a.shapes.row(i);
    const double half = selection::kWiderProfile * selection::k90 *
                        std::sqrt(std::max(0.0, shape.dot(covariance * shape.transpose())));
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

double Analysis::spread_of_speeds() const {
  std::map<int, std::vector<double>> in_cells;
  for (const Row& row : rows_.row) {
    const Signals& log = logs_[row.log];
    const auto step = static_cast<std::size_t>(std::lround(row.t_s / Signals::kStep_s));
    const double vx_mps = log.x[kVx][std::min(step, log.n - 1)];
    if (std::isfinite(vx_mps)) in_cells[static_cast<int>(row.u_m / kCell_m)].push_back(vx_mps);
  }
  std::vector<double> spreads;
  for (const auto& [cell, vx_mps] : in_cells) {
    const Eigen::Map<const VectorXd> v(vx_mps.data(), static_cast<Index>(vx_mps.size()));
    spreads.push_back(std::sqrt((v.array() - v.mean()).square().mean()) / v.mean());
  }
  return base::median(std::move(spreads));
}

void Analysis::tie_with_the_car(Finding& f, const Fitted& model, const Accepted& a,
                                Index column) const {
  // What kind of measurement a relation is.
  constexpr std::array<int, kRelationCount> kKind{0, 0, 0, 1, 2, 3, 4, 5, 6,
                                                  7, 7, 8, 8, 2, 9, 9, 9};
  const Index size = a.columns.cols();
  const VectorXd does =
      model.x.middleCols(column, size) * (a.amounts + model.amount.segment(column, size));
  std::array<double, 10> saved{};
  for (Index i = 0; i < does.size(); ++i)
    saved[static_cast<std::size_t>(kKind[rows_.row[static_cast<std::size_t>(i)].relation])] +=
        does[i] * (2 * model.e[i] + does[i]);
  const auto most =
      static_cast<std::size_t>(std::max_element(saved.begin(), saved.end()) - saved.begin());
  std::sort(saved.begin(), saved.end(), std::greater<>());
  if (saved[1] > selection::kSecondKind * saved[0] || spread_of_speeds() > selection::kOtherSpeeds)
    return;
  constexpr const char* kSeparating =
      "drive laps a tenth faster and slower: what the road does stays the same";
  for (const auto& [relation, channel] :
       {std::pair{kGyro, kYawRate}, {kAccelX, kAx}, {kAccelY, kAy}, {kAccelZ, kAz}}) {
    if (most != static_cast<std::size_t>(kKind[relation])) continue;
    const std::string& shows = logs_.front().column[channel];
    f.rivals.push_back({kSensorGain, shows, kSeparating, 0.0, false});
    f.not_used = fmt::format(
        "'{}' alone shows it, in laps of one speed: its gain or a body that leans may do the same",
        shows);
    return;
  }
  f.not_used = fmt::format(
      "the stated car's forces alone show it, in laps of one speed: another number of the car may "
      "do the same; {}",
      kSeparating);
}

void Analysis::find_road_profiles(Findings& out) {
  // The height that was driven is not known beside a banking that only turning shows.
  if (by_turning_) return;
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
    if (f.where.empty() || (f.where.size() == 1 && length_m < selection::kOneStretch_m)) continue;
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
  const MatrixXd per_unit = columns_of(found, "the road along the lap");
  for (std::size_t k = 0; k < found.size(); ++k) {
    Accepted& a = accepted_[k];
    a.columns = along_the_lap(rows_, per_unit.col(static_cast<Index>(k)), a.shapes,
                              logs_.front().length_m, logs_.front().closed);
  }
}

}  // namespace explain
