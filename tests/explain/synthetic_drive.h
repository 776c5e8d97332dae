// Summaries of drives that nobody drove: sums of random rows of a linear world whose road, cars and
// sensors are known.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/random.h"
#include "explain/summary.h"

namespace explain_test {

struct World {
  std::uint32_t knots = 24;
  double length_m = 600.0;
  std::size_t car_parameters = 6, car_mechanisms = 8, sensors = 6;
  double rows_per_knot = 40.0;  ///< with forces
  double banking = 0.0;         ///< at knots 5 to 9, m/m
};

/// What one car has.
struct SyntheticCar {
  std::string name;
  double mechanism = 0.0;  ///< of the first mechanism
  double own = 0.0;  ///< one deviation of what it gets wrong from knot to knot, m/m of banking
  std::uint64_t seed = 1;  ///< of its parameters, up to one deviation off, and of its own errors
};

using explain::kRoadKinds;

/// One row: the knot before it, the share of the next one, what one unit of each kind of road and
/// of each column does.
struct Row {
  std::uint32_t knot = 0;
  double share = 0.0, r = 0.0;
  std::vector<double> road, column;
};

inline void add(explain::Information& sums, const Row& row, std::uint32_t knots) {
  const std::size_t q = row.column.size(), road = knots * kRoadKinds;
  const std::size_t at[] = {row.knot * kRoadKinds, (row.knot + 1) % knots * kRoadKinds};
  const double part[] = {1 - row.share, row.share};
  sums.rows += 1;
  sums.square += row.r * row.r;
  for (int k = 0; k < 2; ++k)
    for (std::size_t a = 0; a < kRoadKinds; ++a) {
      const double x = part[k] * row.road[a];
      sums.right[at[k] + a] += x * row.r;
      for (std::size_t b = 0; b < kRoadKinds; ++b) {
        sums.knot[(at[k] + b) * kRoadKinds + a] += x * part[k] * row.road[b];
        if (k == 0) sums.next[(at[0] + b) * kRoadKinds + a] += x * part[1] * row.road[b];
      }
      for (std::size_t c = 0; c < q; ++c) sums.across[c * road + at[k] + a] += x * row.column[c];
    }
  std::size_t place = 0;
  for (std::size_t c = 0; c < q; ++c) {
    sums.right[road + c] += row.column[c] * row.r;
    for (std::size_t d = 0; d <= c; ++d) sums.among[place++] += row.column[c] * row.column[d];
  }
}

inline explain::SummaryColumn column(const std::string& id, std::size_t number, bool of_car,
                                     bool candidate) {
  explain::SummaryColumn out;
  out.id = id;
  out.name = id + " " + std::to_string(number);
  out.key = out.name;
  out.unit = "1";
  out.of_car = of_car;
  out.candidate = candidate;
  out.parameter = of_car && !candidate;
  out.stated = 1.0;
  out.deviation = candidate ? 1.0 : 0.02;
  out.width = 0.04;
  out.form = of_car && !candidate ? 0.01 : 0.0;
  out.least = candidate ? 0.1 : 0.03;
  if (!of_car) out.channel = "column";
  return out;
}

/// One drive of it; `seed` draws its noise and its sensors' errors.
inline explain::DriveSummary synthetic_drive(const World& world, const SyntheticCar& car,
                                             std::uint64_t seed) {
  explain::DriveSummary s;
  s.program = "synthetic 1";
  s.road_sha256 = std::string(64, 'a');
  s.car_sha256 = "car " + car.name;
  s.recording_sha256 = car.name + " drive " + std::to_string(seed);
  s.settings_sha256 = "none";
  s.car = car.name;
  s.recording = s.recording_sha256;
  s.length_m = world.length_m;
  s.closed = true;
  s.knots = world.knots;
  s.laps = 5;
  s.driven_s = 100;
  for (std::size_t k = 0; k < world.car_parameters; ++k)
    s.columns.push_back(column("parameter." + std::to_string(k), k, true, false));
  for (std::size_t k = 0; k < world.car_mechanisms; ++k)
    s.columns.push_back(column("vehicle." + std::to_string(k), k, true, true));
  for (std::size_t k = 0; k < world.sensors; ++k)
    s.columns.push_back(column("sensor." + std::to_string(k), k, false, false));

  base::Random of_car(car.seed), of_drive(seed);
  std::vector<double> truth(s.columns.size(), 0.0), own(world.knots);
  for (std::size_t k = 0; k < world.car_parameters; ++k) truth[k] = 0.01 * of_car.normal();
  truth[world.car_parameters] = car.mechanism;
  for (double& value : own) value = car.own * of_car.normal();
  for (std::size_t k = truth.size() - world.sensors; k < truth.size(); ++k)
    truth[k] = 0.005 * of_drive.normal();
  const auto bank = [&](std::uint32_t knot) {
    return own[knot] + (knot >= 5 && knot <= 9 ? world.banking : 0.0);
  };

  const std::size_t q = s.columns.size(), road = s.road_columns();
  for (explain::Information* sums : {&s.by_sensors, &s.by_forces}) {
    sums->right.assign(road + q, 0.0);
    sums->knot.assign(road * kRoadKinds, 0.0);
    sums->next = sums->knot;
    sums->across.assign(road * q, 0.0);
    sums->among.assign(q * (q + 1) / 2, 0.0);
  }
  // Where a car is on the road decides what it does, as it does on laps that are alike.
  base::Random of_place(7);
  std::vector<std::vector<double>> habit(world.knots, std::vector<double>(q));
  for (auto& at : habit)
    for (double& value : at) value = of_place.normal();
  const auto rows = static_cast<int>(world.rows_per_knot * world.knots);
  for (int k = 0; k < rows; ++k) {
    Row row;
    row.knot = static_cast<std::uint32_t>(k) % world.knots;
    row.share = of_drive.uniform();
    row.road = {60.0, 60.0 * of_drive.normal(), 0.0, 0.0};
    for (std::size_t c = 0; c < q; ++c)
      row.column.push_back(20.0 * (habit[row.knot][c] + 0.5 * of_drive.normal()));
    row.r = of_drive.normal() + row.road[0] * ((1 - row.share) * bank(row.knot) +
                                               row.share * bank((row.knot + 1) % world.knots));
    for (std::size_t c = 0; c < q; ++c) row.r += truth[c] * row.column[c];
    add(s.by_forces, row, world.knots);
  }
  return s;
}

}  // namespace explain_test
