#include "fleet_describe.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "selection.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

double knot_m(const Gathered& all, std::size_t k) {
  return static_cast<double>(k) * all.length_m /
         static_cast<double>(all.closed ? all.knots : all.knots - 1);
}

/// Stretches where a profile is more than its interval and than what matters.
std::vector<Place> stretches(const std::vector<ProfilePoint>& profile, double least,
                             double length_m) {
  std::vector<Place> out;
  const double half = profile.size() > 1 ? 0.5 * (profile[1].u_m - profile[0].u_m) : 0.0;
  for (const ProfilePoint& p : profile) {
    if (std::abs(p.value) < std::max(least, p.ci90)) continue;
    const double begin = std::max(0.0, p.u_m - half), end = std::min(length_m, p.u_m + half);
    if (!out.empty() && begin - out.back().u_end_m < half)
      out.back().u_end_m = end;
    else
      out.push_back({begin, end, {}});
  }
  return out;
}

std::vector<ProfilePoint> profile_of(const Gathered& all, const VectorXd& amounts,
                                     const MatrixXd& covariance, std::size_t kind, double form) {
  std::vector<ProfilePoint> out;
  for (std::size_t k = 0; k < all.knots; ++k) {
    const auto at = static_cast<Index>(k * kRoadKinds + kind);
    out.push_back({knot_m(all, k), amounts[at],
                   selection::k90 * std::hypot(selection::kWiderProfile *
                                                   std::sqrt(std::max(0.0, covariance(at, at))),
                                               form)});
  }
  return out;
}

ProfilePoint most_of(const std::vector<ProfilePoint>& profile) {
  return *std::max_element(profile.begin(), profile.end(), [](const auto& a, const auto& b) {
    return std::abs(a.value) - a.ci90 < std::abs(b.value) - b.ci90;
  });
}

}  // namespace

void describe_road(const Gathered& all, const FleetSearch& search, FleetFindings& out) {
  const RoadEstimate road = search.road();
  const MatrixXd covariance =
      road.precision.llt().solve(MatrixXd::Identity(road.precision.rows(), road.precision.rows()));
  for (std::size_t kind = 0; kind < kRoadKinds; ++kind) {
    if (!search.in_road(kind)) continue;
    const RoadGain gain = search.gain_of(kind);
    FleetFinding f;
    f.mechanism = kRoad[kind].id;
    f.name = kRoad[kind].name;
    f.unit = kRoad[kind].unit;
    f.belongs_to = "road";
    f.owner = "all cars";
    f.gain = gain.gain;
    f.threshold = gain.threshold;
    f.agreeing = gain.agreeing;
    f.profile = profile_of(all, road.amounts, covariance, kind, search.form(kind));
    f.where = stretches(f.profile, search.least(kind), all.length_m);
    if (f.where.empty()) continue;
    const ProfilePoint most = most_of(f.profile);
    f.amount = most.value;
    f.low = most.value - most.ci90;
    f.high = most.value + most.ci90;
    for (const std::size_t rival : search.rivals_of(kind)) f.rivals.push_back(kRoad[rival].id);
    out.findings.push_back(std::move(f));
  }
}

namespace {

FleetFinding finding_of(const SummaryColumn& c, const char* belongs_to, const std::string& owner) {
  FleetFinding f;
  f.mechanism = c.id;
  f.name = c.name;
  f.unit = c.unit;
  f.channel = c.channel;
  f.belongs_to = belongs_to;
  f.owner = owner;
  f.stated = c.stated;
  return f;
}

/// Mechanisms that do nearly the same in this car.
std::vector<std::string> rivals_of(const CarSums& car, const FleetSearch& search, std::size_t k,
                                   const NamedColumn& named) {
  // Without the one that is in: all others as they were when it was chosen.
  std::vector<std::string> out;
  FleetSearch without = search;
  without.leave_out(named);
  const CarTests tests = without.tests_of(k);
  double best = 0;
  for (const ColumnTest& t : tests.test)
    if (t.column == named.column) best = t.gain;
  for (const ColumnTest& t : tests.test) {
    const SummaryColumn& c = car.columns[t.column];
    if (c.id == car.columns[named.column].id || std::abs(t.amount) < c.least ||
        std::abs(t.amount) > c.most || (c.one_sided && t.amount < 0))
      continue;
    if (best - t.gain < std::max(selection::kLead, selection::kInexact * best) &&
        std::find(out.begin(), out.end(), c.id) == out.end())
      out.push_back(c.id);
  }
  return out;
}

}  // namespace

void describe_mechanisms(const Gathered& all, const FleetSearch& search, FleetFindings& out) {
  for (const NamedColumn& named : search.named()) {
    const CarSums& car = all.cars[named.car];
    const CarTests& tests = search.tests(named.car);
    const auto& in = search.in(named.car);
    const auto at =
        static_cast<std::size_t>(std::find(in.begin(), in.end(), named.column) - in.begin());
    const SummaryColumn& c = car.columns[named.column];
    FleetFinding f = finding_of(c, "car", car.name);
    f.amount = tests.mean[at];
    const double half =
        selection::k90 * std::hypot(std::sqrt(tests.variance[at] *
                                              std::max(1.0, named.threshold / selection::kNamed)),
                                    0.25 * c.least);
    f.low = f.amount - half;
    f.high = f.amount + half;
    f.gain = named.gain;
    f.threshold = named.threshold;
    if (std::abs(f.amount) < c.least) continue;  // what came later took its place
    for (std::size_t o = 0; o < all.cars.size(); ++o) {
      if (o == named.car) continue;
      for (const ColumnTest& t : search.tests(o).test)
        if (all.cars[o].columns[t.column].key == c.key && t.gain > selection::kNamed &&
            t.amount * f.amount > 0 && std::abs(t.amount) > std::abs(f.amount) / 3)
          ++f.agreeing;
    }
    f.rivals = rivals_of(car, search, named.car, named);
    out.findings.push_back(std::move(f));
  }
}

void describe_cars(const Gathered& all, const FleetSearch& search, FleetFindings& out) {
  for (std::size_t k = 0; k < all.cars.size(); ++k) {
    const CarSums& car = all.cars[k];
    FleetCar described{car.name, car.sha256, car.drives.size(), car.laps, car.driven_s, {}};
    const CarTests& tests = search.tests(k);
    const auto& in = search.in(k);
    for (std::size_t j = 0; j < in.size(); ++j) {
      const SummaryColumn& c = car.columns[in[j]];
      if (!c.parameter) continue;
      const NamedColumn* const go = search.let_go(k, in[j]);
      const double value = tests.mean[j],
                   deviation = std::hypot(std::sqrt(tests.variance[j]), c.form),
                   half = selection::k90 * deviation;
      const bool beyond =
          go != nullptr && std::abs(value) - selection::kBeyond * deviation > c.width;
      described.parameters.push_back({c.id, c.name, c.unit, c.stated, c.stated + value,
                                      c.stated + value - half, c.stated + value + half, beyond,
                                      false});
      if (!beyond) continue;
      FleetFinding f = finding_of(c, "car", car.name);
      f.amount = value;
      f.low = value - half;
      f.high = value + half;
      f.gain = go->gain;
      f.threshold = go->threshold;
      f.rivals = go->rivals;
      out.findings.push_back(std::move(f));
    }
    out.cars.push_back(std::move(described));
  }
}

namespace {

/// What a drive's own unknowns are, with all that is uncertain about its car and the road.
std::vector<FleetFinding> own_findings(const DriveSummary& drive, const OwnOfDrive& own,
                                       const CarEstimate& car) {
  std::vector<FleetFinding> out;
  if (own.column.empty()) return out;
  const Eigen::LLT<MatrixXd> solver(own.normal);
  const MatrixXd with = own.with(car.places, Eigen::all);
  const VectorXd mean = solver.solve(own.right - with.transpose() * car.amounts);
  const MatrixXd inverse = solver.solve(MatrixXd::Identity(own.normal.rows(), own.normal.rows()));
  for (std::size_t j = 0; j < own.column.size(); ++j) {
    const SummaryColumn& c = drive.columns[own.column[j]];
    const auto at = static_cast<Index>(j);
    if (c.id == "curve" || !(std::abs(mean[at]) > 3 * std::sqrt(inverse(at, at)))) continue;
    const VectorXd moved = with * inverse.col(at);
    const double variance =
        inverse(at, at) + VectorXd(car.solver.matrixL().solve(moved)).squaredNorm();
    const double prior = 1 / (c.deviation * c.deviation), left = 1 / variance - prior;
    if (!(left > 0.1 * prior)) continue;
    const double push = mean[at] / variance, amount = push / left, gain = push * push / left;
    if (!(gain > selection::kNamed) || std::abs(amount) < c.least || std::abs(amount) > c.most ||
        (c.one_sided && amount < 0))
      continue;
    FleetFinding f = finding_of(c, "drive", drive.recording);
    const double half = selection::k90 * std::hypot(1 / std::sqrt(left), 0.25 * c.least);
    f.amount = amount;
    f.low = amount - half;
    f.high = amount + half;
    f.gain = gain;
    f.threshold = selection::kNamed;
    out.push_back(std::move(f));
  }
  return out;
}

}  // namespace

void describe_drives(const Gathered& all, const FleetSearch& search,
                     const std::function<DriveSummary(std::size_t)>& read,
                     const FleetOptions& options, FleetFindings& out) {
  std::vector<std::vector<FleetFinding>> found(all.car_of.size());
  for (std::size_t c = 0; c < all.cars.size(); ++c) {
    const CarEstimate car = search.estimate_of(c);
    const std::vector<std::size_t>& drives = all.cars[c].drives;
    base::parallel_for(drives.size(), 1, options.threads, [&](std::size_t k, std::size_t) {
      const DriveSummary drive = read(drives[k]);
      found[drives[k]] = own_findings(
          drive, own_of(drive, all.places_of[drives[k]], all.cars[c].columns.size()), car);
    });
  }
  for (auto& of_drive : found)
    for (FleetFinding& f : of_drive) out.findings.push_back(std::move(f));
}

void describe_undivided(const Gathered& all, const FleetSearch& search, FleetFindings& out) {
  if (all.cars.size() < kLeastFleetCars) {
    const std::string more = fmt::format("record the laps of {} or more other cars on this road",
                                         kLeastFleetCars - all.cars.size());
    for (const FleetFinding& f : out.findings)
      out.undivided.push_back(
          {fmt::format("{}: {} {:.4g} {}", f.mechanism, f.name, f.amount, f.unit),
           "this car, its sensors, or what the simulation gets wrong in it",
           f.owner,
           more,
           f.gain,
           {}});
    out.findings.clear();
    for (std::size_t kind = 0; kind < kRoadKinds; ++kind) {
      if (!all.seen[kind]) continue;
      const double gain = search.undivided_gain(kind);
      if (!(gain > selection::kProfileGain)) continue;
      out.undivided.push_back({kRoad[kind].name,
                               "the road, or what the stated cars get wrong at the same places",
                               all.cars.size() == 1 ? all.cars.front().name : "both cars",
                               fmt::format("record the laps of {} or more other cars on this road",
                                           kLeastFleetCars - all.cars.size()),
                               gain,
                               {}});
    }
    return;
  }
  for (std::size_t k = 0; k < all.cars.size(); ++k)
    for (std::size_t kind = 0; kind < kRoadKinds; ++kind) {
      if (!all.seen[kind]) continue;
      const double gain = search.stands_apart(k, kind);
      if (!(gain > selection::kProfileGain)) continue;
      out.undivided.push_back(
          {fmt::format("along the lap this car alone seems to see: {}", kRoad[kind].name),
           "this car and its sensors; no mechanism that was tried explains it",
           all.cars[k].name,
           "crgexplain run over its recordings",
           gain,
           {}});
    }
}

}  // namespace explain
