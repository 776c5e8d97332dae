#include "explain/fleet.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <set>

#include "base/parallel.h"
#include "fleet_search.h"
#include "selection.h"
#include "vehicle/error.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using vehicle::Error;

namespace {

constexpr double k90 = 1.645;
constexpr std::size_t kAtOnce = 16;      ///< drives in memory
constexpr double kMostCarBytes = 600e6;  ///< of all cars' sums

/// All drives, car by car.
struct Gathered {
  std::vector<CarSums> cars;
  std::vector<std::size_t> car_of;                  ///< per drive
  std::vector<std::vector<std::size_t>> places_of;  ///< per drive: of its columns in its car
  std::uint32_t knots = 0;
  double length_m = 0.0;
  bool closed = false;
  std::string road_sha256, program, first;
  std::array<bool, kRoadKinds> seen{};
  std::vector<std::string> hashes;
};

/// Drives that do not go together are refused.
void want_fit(const Gathered& all, const DriveSummary& drive) {
  if (drive.road_sha256 != all.road_sha256 || drive.length_m != all.length_m ||
      drive.closed != all.closed || drive.knots != all.knots)
    throw Error(fmt::format(
        "{}: was driven on another road file ({:.10}, {:.1f} m) than {} ({:.10}, {:.1f} m); give "
        "summaries of one road, made with the same --track and --friction",
        drive.recording, drive.road_sha256, drive.length_m, all.first, all.road_sha256,
        all.length_m));
  if (drive.program != all.program)
    throw Error(
        fmt::format("{}: the summary was made by {}, that of {} by {}; make all with one program",
                    drive.recording, drive.program, all.first, all.program));
}

std::size_t car_of(Gathered& all, const DriveSummary& drive) {
  for (std::size_t k = 0; k < all.cars.size(); ++k)
    if (all.cars[k].sha256 == drive.car_sha256) return k;
  CarSums car;
  car.name = drive.car.empty() ? "car" : drive.car;
  const auto same = std::count_if(all.cars.begin(), all.cars.end(), [&](const CarSums& c) {
    return c.name == car.name || c.name.starts_with(car.name + " #");
  });
  if (same > 0) car.name += fmt::format(" #{}", same + 1);
  car.sha256 = drive.car_sha256;
  all.cars.push_back(std::move(car));
  const double road = static_cast<double>(drive.road_columns());
  const double bytes = 8 * (2 * road + 100) * (2 * road + 100);
  const auto most = std::min(kMostFleetCars, static_cast<std::size_t>(kMostCarBytes / bytes));
  if (all.cars.size() > most)
    throw Error(fmt::format(
        "{}: the {}th car; {} cars at most are reckoned together on a road of {:.0f} m: give the "
        "summaries in parts",
        drive.recording, all.cars.size(), most, drive.length_m));
  return all.cars.size() - 1;
}

/// Registers a drive; what has to be done in order.
void enter(Gathered& all, const DriveSummary& drive) {
  if (all.car_of.empty()) {
    all.road_sha256 = drive.road_sha256;
    all.program = drive.program;
    all.length_m = drive.length_m;
    all.closed = drive.closed;
    all.knots = drive.knots;
    all.first = drive.recording;
  }
  want_fit(all, drive);
  all.hashes.push_back(drive.recording_sha256);
  const std::size_t k = car_of(all, drive);
  CarSums& car = all.cars[k];
  car.drives.push_back(all.car_of.size());
  car.laps += drive.laps;
  car.driven_s += drive.driven_s;
  all.car_of.push_back(k);
  all.places_of.push_back(join_columns(car, drive));
}

void refuse_the_same_twice(const Gathered& all,
                           const std::function<DriveSummary(std::size_t)>& read) {
  std::map<std::string, std::size_t> first;
  for (std::size_t k = 0; k < all.hashes.size(); ++k)
    if (const auto [known, is_new] = first.emplace(all.hashes[k], k); !is_new)
      throw Error(
          fmt::format("{}: the same recording as {}; laps that come twice would vouch for "
                      "each other: give it once",
                      read(k).recording, read(known->second).recording));
}

Gathered gather(std::size_t drives, const std::function<DriveSummary(std::size_t)>& read,
                const FleetOptions& options) {
  Gathered all;
  for (std::size_t begin = 0; begin < drives; begin += kAtOnce) {
    if (options.progress)
      options.progress("summaries", static_cast<double>(begin) / static_cast<double>(drives));
    const std::size_t count = std::min(kAtOnce, drives - begin);
    std::vector<DriveSummary> here(count);
    base::parallel_for(count, 1, options.threads,
                       [&](std::size_t k, std::size_t) { here[k] = read(begin + k); });
    for (const DriveSummary& drive : here) enter(all, drive);
    std::vector<Reduced> reduced(count);
    base::parallel_for(count, 1, options.threads, [&](std::size_t k, std::size_t) {
      const std::size_t number = begin + k;
      reduced[k] =
          reduce(here[k], all.places_of[number], all.cars[all.car_of[number]].columns.size());
    });
    for (std::size_t k = 0; k < count; ++k)
      add(all.cars[all.car_of[begin + k]], reduced[k], here[k].road_columns());
  }
  for (const CarSums& car : all.cars)
    for (std::size_t k = 0; k < all.knots * kRoadKinds; ++k)
      if (car.normal(static_cast<Index>(k), static_cast<Index>(k)) > 0)
        all.seen[k % kRoadKinds] = true;
  return all;
}

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
    out.push_back(
        {knot_m(all, k), amounts[at],
         k90 * std::hypot(selection::kWiderProfile * std::sqrt(std::max(0.0, covariance(at, at))),
                          form)});
  }
  return out;
}

ProfilePoint most_of(const std::vector<ProfilePoint>& profile) {
  return *std::max_element(profile.begin(), profile.end(), [](const auto& a, const auto& b) {
    return std::abs(a.value) - a.ci90 < std::abs(b.value) - b.ci90;
  });
}

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

void describe_mechanisms(const Gathered& all, const FleetSearch& search, FleetFindings& out) {
  for (const NamedColumn& named : search.named()) {
    const CarSums& car = all.cars[named.car];
    const CarTests tests = search.tests_of(named.car);
    const auto& in = search.in(named.car);
    const auto at =
        static_cast<std::size_t>(std::find(in.begin(), in.end(), named.column) - in.begin());
    const SummaryColumn& c = car.columns[named.column];
    FleetFinding f = finding_of(c, "car", car.name);
    f.amount = tests.mean[at];
    const double half =
        k90 * std::hypot(std::sqrt(tests.variance[at] *
                                   std::max(1.0, named.threshold / selection::kNamed)),
                         0.25 * c.least);
    f.low = f.amount - half;
    f.high = f.amount + half;
    f.gain = named.gain;
    f.threshold = named.threshold;
    if (std::abs(f.amount) < c.least) continue;  // what came later took its place
    for (std::size_t o = 0; o < all.cars.size(); ++o) {
      if (o == named.car) continue;
      for (const ColumnTest& t : search.tests_of(o).test)
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
    const CarTests tests = search.tests_of(k);
    const auto& in = search.in(k);
    for (std::size_t j = 0; j < in.size(); ++j) {
      const SummaryColumn& c = car.columns[in[j]];
      if (!c.parameter) continue;
      const ColumnTest& freed = tests.refitted[j];
      const double deviation = std::hypot(std::sqrt(tests.variance[j]), c.form),
                   free_deviation = std::hypot(freed.deviation, c.form);
      const bool beyond = freed.gain > selection::kLetGo &&
                          std::abs(freed.amount) - selection::kBeyond * free_deviation > c.width;
      const double value = beyond ? freed.amount : tests.mean[j],
                   half = k90 * (beyond ? free_deviation : deviation);
      described.parameters.push_back({c.id, c.name, c.unit, c.stated, c.stated + value,
                                      c.stated + value - half, c.stated + value + half, beyond,
                                      false});
      if (!beyond) continue;
      FleetFinding f = finding_of(c, "car", car.name);
      f.amount = value;
      f.low = value - half;
      f.high = value + half;
      f.gain = freed.gain;
      f.threshold = selection::kLetGo;
      out.findings.push_back(std::move(f));
    }
    out.cars.push_back(std::move(described));
  }
}

/// The drives' own unknowns, once road and cars are known.
void describe_drives(const Gathered& all, const FleetSearch& search,
                     const std::function<DriveSummary(std::size_t)>& read,
                     const FleetOptions& options, FleetFindings& out) {
  const auto road = static_cast<Index>(all.knots * kRoadKinds);
  std::vector<VectorXd> amounts;
  for (std::size_t k = 0; k < all.cars.size(); ++k) {
    const VectorXd known = search.tests_of(k).amounts;
    VectorXd whole = VectorXd::Zero(2 * road + static_cast<Index>(all.cars[k].columns.size()));
    whole.head(2 * road) = known.head(2 * road);
    for (std::size_t j = 0; j < search.in(k).size(); ++j)
      whole[2 * road + static_cast<Index>(search.in(k)[j])] =
          known[2 * road + static_cast<Index>(j)];
    amounts.push_back(std::move(whole));
  }
  std::vector<std::vector<FleetFinding>> found(all.car_of.size());
  base::parallel_for(
      all.car_of.size(), 8, options.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          const DriveSummary drive = read(k);
          const std::size_t width = all.cars[all.car_of[k]].columns.size();
          const OwnOfDrive own = own_of(drive, all.places_of[k], width);
          if (own.column.empty()) continue;
          const Eigen::LLT<MatrixXd> solver(own.normal);
          const VectorXd mean =
              solver.solve(own.right - own.with.transpose() * amounts[all.car_of[k]]);
          const MatrixXd covariance =
              solver.solve(MatrixXd::Identity(own.normal.rows(), own.normal.rows()));
          for (std::size_t j = 0; j < own.column.size(); ++j) {
            const SummaryColumn& c = drive.columns[own.column[j]];
            const auto at = static_cast<Index>(j);
            const double variance = covariance(at, at), prior = 1 / (c.deviation * c.deviation),
                         left = 1 / variance - prior;
            if (!(left > 0.1 * prior) || c.id == "curve") continue;
            const double push = mean[at] / variance, amount = push / left,
                         gain = push * push / left;
            if (!(gain > selection::kNamed) || std::abs(amount) < c.least ||
                std::abs(amount) > c.most || (c.one_sided && amount < 0))
              continue;
            FleetFinding f = finding_of(c, "drive", drive.recording);
            const double half = k90 * std::hypot(1 / std::sqrt(left), 0.25 * c.least);
            f.amount = amount;
            f.low = amount - half;
            f.high = amount + half;
            f.gain = gain;
            f.threshold = selection::kNamed;
            found[k].push_back(std::move(f));
          }
        }
      });
  for (auto& of_drive : found)
    for (FleetFinding& f : of_drive) out.findings.push_back(std::move(f));
}

/// What counts and has no owner.
void describe_undivided(const Gathered& all, const FleetSearch& search, FleetFindings& out) {
  if (all.cars.size() < kLeastFleetCars) {
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

}  // namespace

const char* name_of(FleetVerdict verdict) {
  switch (verdict) {
    case FleetVerdict::kNone:
      return "none";
    case FleetVerdict::kDivided:
      return "divided";
    case FleetVerdict::kCannotTell:
      break;
  }
  return "cannot tell";
}

FleetFindings explain_fleet(std::size_t drives,
                            const std::function<DriveSummary(std::size_t)>& read,
                            const FleetOptions& options) {
  if (drives == 0) throw Error("no summaries; give those that crgexplain summary wrote");
  const Gathered all = gather(drives, read, options);
  refuse_the_same_twice(all, read);
  const RoadShape shape = road_shape(all.knots, all.length_m, all.closed);
  FleetSearch search(all.cars, shape, all.seen, options);
  search.run();
  FleetFindings out;
  out.drives = drives;
  out.tested = search.tested();
  out.road_sha256 = all.road_sha256;
  out.program = all.program;
  out.length_m = all.length_m;
  out.own_size = search.own_sizes();
  out.seen = all.seen;
  describe_road(all, search, out);
  describe_mechanisms(all, search, out);
  describe_cars(all, search, out);
  describe_drives(all, search, read, options, out);
  describe_undivided(all, search, out);
  const bool tie = std::any_of(out.findings.begin(), out.findings.end(),
                               [](const FleetFinding& f) { return !f.rivals.empty(); });
  if (tie || !out.undivided.empty())
    out.verdict = FleetVerdict::kCannotTell;
  else if (!out.findings.empty())
    out.verdict = FleetVerdict::kDivided;
  if (all.cars.size() < kLeastFleetCars)
    out.remarks.push_back(fmt::format(
        "{}; with fewer than {} cars nothing says whether the road or the cars are wrong",
        all.cars.size() == 1 ? "one car" : "two cars", kLeastFleetCars));
  if (options.progress) options.progress("done", 1.0);
  return out;
}

}  // namespace explain
