// What is told of a run beside its numbers: what sensors see of the road, and what whoever drives
// plans. docs/crgsim.md describes the messages.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace sim {

/// In the sensor's frame: x ahead, y left, z up.
struct ScanPoint {
  float x_m = 0.0f, y_m = 0.0f, z_m = 0.0f;
  float intensity = 0.0f;  ///< cosine of the angle between beam and normal of the road
};

struct Scan {
  std::size_t sensor = 0;  ///< of the file's scans
  std::string name;
  double time_s = 0.0;  ///< when it was true
  std::vector<ScanPoint> points;
  std::array<double, 3> at_m{}, turned_rad{};  ///< of the sensor in the car; in JSON alone
};

/// Points on both ends of the drivable area, as seen in the direction of driving, from behind to
/// ahead; in the car's frame.
struct Edges {
  std::size_t sensor = 0;  ///< of the file's edges
  std::string name;
  double time_s = 0.0;
  std::vector<std::array<float, 3>> left_m, right_m;
};

struct PlanPoint {
  double x_m = 0.0, y_m = 0.0;  ///< on the map
  double speed_mps = 0.0;
};

constexpr std::size_t kMostPlanPoints = 500;

/// The way that whoever drives is going to take.
struct Plan {
  std::uint32_t sequence = 0;  ///< of the command that told it
  double time_s = 0.0;         ///< of the unit, when it was taken
  std::vector<PlanPoint> points;
};

using Sight = std::variant<Scan, Edges, Plan>;

/// With its texts, which take longer to write than a step of a loop in real time.
struct ToldSight {
  Sight sight;
  std::vector<std::string> json;  ///< datagrams
  std::string line;               ///< the whole as JSON, for a record
};

/// As datagrams of at most `longest` bytes: a scan may need several, the others have one.
std::vector<std::string> write_sight(const Sight& sight, bool as_binary, std::size_t longest);

ToldSight tell_sight(Sight sight);

}  // namespace sim
