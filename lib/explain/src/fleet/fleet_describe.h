// What a search found, in numbers: amounts with their 90 % intervals, places, owners.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "explain/fleet.h"
#include "fleet_search.h"

namespace explain {

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

/// What is the road's.
void describe_road(const Gathered& all, const FleetSearch& search, FleetFindings& out);
/// Mechanisms of cars.
void describe_mechanisms(const Gathered& all, const FleetSearch& search, FleetFindings& out);
/// The cars and their parameters.
void describe_cars(const Gathered& all, const FleetSearch& search, FleetFindings& out);
/// The drives' own unknowns, once road and cars are known.
void describe_drives(const Gathered& all, const FleetSearch& search,
                     const std::function<DriveSummary(std::size_t)>& read,
                     const FleetOptions& options, FleetFindings& out);
/// What counts and has no owner.
void describe_undivided(const Gathered& all, const FleetSearch& search, FleetFindings& out);

}  // namespace explain
