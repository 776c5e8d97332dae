// Many drives of several cars on one road in one estimate: what all cars agree on is the road's,
// what one car has is its own, what one drive has is its sensors'.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "explain/summary.h"

namespace explain {

enum class FleetVerdict {
  kNone,       ///< nothing that counts, and cars enough to say so
  kDivided,    ///< all that counts was found, and whose it is
  kCannotTell  ///< these drives do not say what counts or whose it is
};
const char* name_of(FleetVerdict verdict);

/// Something that counts. An interval holds 90 %.
struct FleetFinding {
  std::string mechanism, name, unit, channel;
  std::string belongs_to;  ///< "road", "car", "drive"
  std::string owner;       ///< the car (and a number where names are alike) or the drive
  double amount = 0.0, low = 0.0, high = 0.0;  ///< of the road: the most along the lap
  double stated = 0.0;                         ///< of a parameter: amount is what to add
  double gain = 0.0, threshold = 0.0;          ///< of loss; of the road: on cars left out
  std::size_t agreeing = 0;  ///< of the road: cars that it predicts better; else of the others with
                             ///< the same, cars whose own is a third or more of it
  std::vector<ProfilePoint> profile;  ///< of the road
  std::vector<Place> where;
  std::vector<std::string> rivals;  ///< that it cannot be told from
};

/// Something that counts and is not divided.
struct Undivided {
  std::string what, between, owner, separating;
  double gain = 0.0;
  std::vector<Place> where;
};

struct FleetCar {
  std::string name, sha256;
  std::size_t drives = 0, laps = 0;
  double driven_s = 0.0;
  std::vector<ParameterValue> parameters;
};

struct FleetFindings {
  FleetVerdict verdict = FleetVerdict::kNone;
  std::vector<FleetFinding> findings;
  std::vector<Undivided> undivided;
  std::vector<FleetCar> cars;
  std::array<double, kRoadKinds> own_size{};  ///< of what each car alone seems to see, RMS
  std::array<bool, kRoadKinds> seen{};        ///< kinds of which the drives say anything
  std::size_t drives = 0, tested = 0;
  std::string road_sha256, program;
  double length_m = 0.0;
  std::vector<std::string> remarks;
};

struct FleetOptions {
  unsigned threads = 0;  ///< 0: as many as the machine has; never changes the result
  base::Progress progress;
};

/// `read` gives the summary of a number below `drives`; each is asked for twice, perhaps from
/// several threads. Throws vehicle::Error: no drives, more cars than kMostFleetCars, or drives that
/// do not go together (another road, another program, the same recording twice).
FleetFindings explain_fleet(std::size_t drives,
                            const std::function<DriveSummary(std::size_t)>& read,
                            const FleetOptions& options = {});

inline constexpr std::size_t kMostFleetCars = 200;

/// Cars from which a road may be said to be common.
inline constexpr std::size_t kLeastFleetCars = 3;

/// One HTML page that opens anywhere.
std::string fleet_page(const FleetFindings& findings, const std::string& title);

}  // namespace explain
