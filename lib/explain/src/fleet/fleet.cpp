#include "explain/fleet.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <set>

#include "base/parallel.h"
#include "fleet_describe.h"
#include "selection.h"
#include "vehicle/error.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using vehicle::Error;

namespace {

constexpr std::size_t kAtOnce = 16;      ///< drives in memory
constexpr double kMostCarBytes = 600e6;  ///< of all cars' sums

/// Drives that do not go together are refused.
void want_fit(const Gathered& all, const DriveSummary& drive) {
  if (drive.road_sha256 != all.road_sha256 || drive.length_m != all.length_m ||
      drive.closed != all.closed || drive.knots != all.knots)
    throw Error(fmt::format(
        "{}: was driven on another road file ({:.10}, {:.1f} m) than {} ({:.10}, {:.1f} m); give "
        "summaries of one road, made with the same --road and --grip",
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
  Gathered all = gather(drives, read, options);
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
  // Nothing found by a few cars is not nothing there.
  if (tie || !out.undivided.empty() || all.cars.size() < kLeastFleetCars)
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
