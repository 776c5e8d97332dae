// What a drive says about its road, its car and its sensors, as sums of a few hundred kilobytes:
// all that the joint estimate of many drives (fleet.h) needs of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "explain/explain.h"

namespace explain {

/// What may be wrong beside the road, one amount each.
struct SummaryColumn {
  std::string key;  ///< the same for the same thing in another drive of this car
  std::string id, channel, name, unit;
  bool of_car = false;     ///< shared by all drives of this car; else this drive's own
  bool candidate = false;  ///< absent unless the data ask for it; else refitted with its prior
  bool parameter = false;  ///< a number that the vehicle file states
  bool one_sided = false;  ///< only a positive amount makes sense
  double stated = 0.0;     ///< of a parameter
  double deviation = 1.0;  ///< of the prior, one standard deviation
  double width = 0.0;      ///< of a parameter: what its file allows it to be off by
  double form = 0.0;       ///< share of the interval that no data make smaller, one deviation
  double least = 0.0;      ///< smaller amounts are not worth a finding
  double most = 1e300;     ///< larger amounts are no physics
  bool operator==(const SummaryColumn&) const = default;
};

/// Sums over whitened rows r = X a: X'X and X'r. Road columns come first, knot by knot, linear
/// between knots, of each knot one per kind; then SummaryColumns. Neighbouring knots alone have
/// products.
struct Information {
  double rows = 0.0, square = 0.0;  ///< of r
  std::vector<double> right;        ///< X'r
  std::vector<double> knot;         ///< per knot: products of its kinds, row by row
  std::vector<double> next;  ///< per knot: its kinds (rows) with those of the next; the last's next
                             ///< is the first
  std::vector<double> across;  ///< per column: products with all road columns
  std::vector<double> among;   ///< per column: products with those up to itself
  bool operator==(const Information&) const = default;
};

/// Amounts are zero at what road file, vehicle file and mapping state.
struct DriveSummary {
  std::string program;  ///< that made it, with its version
  std::string road_sha256, car_sha256, recording_sha256, settings_sha256;
  std::string car, recording;  ///< names for people
  double length_m = 0.0;       ///< of the road
  bool closed = false;
  std::uint32_t knots = 0;  ///< equally far apart; of an open road one at either end
  std::uint32_t laps = 0;   ///< begun ones too
  double driven_s = 0.0;
  std::vector<SummaryColumn> columns;
  Information by_sensors, by_forces;  ///< of relations without and with forces
  bool operator==(const DriveSummary&) const = default;

  std::size_t road_columns() const { return knots * kRoadKinds; }
};

inline constexpr std::uint32_t kLeastKnots = 4, kMostKnots = 120, kMostSummaryColumns = 400;

/// One pass over recordings of one car by one logger: their sensors count as the same. Names and
/// hashes are the caller's. Throws vehicle::Error where explain() would, and for less than two laps
/// of a closed road.
DriveSummary summarise(const std::vector<Signals>& logs, const vehicle::Vehicle& car,
                       const ExplainOptions& options = {});

/// The file: docs/formats.md.
std::string to_bytes(const DriveSummary& summary);

/// Reads one back. Throws vehicle::Error naming `path`: no summary, another version, damaged. Takes
/// no more memory than the bytes pay for.
DriveSummary summary_from_bytes(std::string_view bytes, const std::string& path);

}  // namespace explain
