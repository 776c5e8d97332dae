// A road with kerbs and grass from their ends, and a car with a LiDAR on it: made by nothing of the
// library's.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "cloud/map.h"

namespace support {

/// A place on the road: along its middle, and to the left of it.
struct RoadSpot {
  double u_m = 0.0, v_m = 0.0;
};

/// Across: asphalt, 1 m of kerb, a verge. The base has the left kerb's outer edge 25 mm too low.
struct KerbedRoad {
  static constexpr double kRoad_m = 5.0, kKerbEnd_m = 6.0, kKerb_m = 0.055, kVerge_m = 0.03;
  static constexpr double kLowered_m = 0.025, kCrown = 0.01;
  double length_m = 110.0;
  double radius_m = 0.0;  ///< of its bend to the left; 0: it is straight
  double tilt = 0.0;      ///< cross slope that the base lacks in the middle half of the length
  double crown = kCrown;  ///< fall to both sides; the base has kCrown
  double step_m =
      0.0;  ///< by so much the kerbs' edges rise, and fall, every 2 m; the base has none

  double height_m(double x_m, double v_m) const;
  double base_height_m(double x_m, double v_m) const;
  crg::Crg base() const;  ///< every 0.25 m along, 0.125 m across, 10 m to both sides
};

struct KerbedDrive {
  int passes = 2;
  double grass_m = 0.0;  ///< mean height of the blades (gamma distribution of shape 2)
  std::uint64_t seed = 1;
  double rain =
      0.0;  ///< share of the points that lie on their way to the ground, up to 2 m over it
  double wall_m = 0.0;     ///< from the middle to walls of 1 m on both sides; 0: none
  double drift = 1.0;      ///< times 20 mm and 1 mrad; 0: the trajectory is true
  int convoy = 0;          ///< cars that follow, 8 m from one to the next, in every pass
  bool oncoming = false;   ///< a car comes along the right lane every eight seconds
  bool left_only = false;  ///< grass and wall are on the left side alone
  double paint_m = 0.0;    ///< lines 0.2 m wide, 4.7 m to both sides, are seen so much too near
  std::vector<RoadSpot> parked = {};  ///< middles of cars that stand in all passes
  /// What the ground of a pass has in addition.
  std::function<double(int pass, double x_m, double v_m)> new_layer_m;
};

struct KerbedScans {
  cloud::Trajectory trajectory;  ///< that drifts; 100 Hz, 10 m/s
  cloud::Cloud points;           ///< in the sensor's frame
};
KerbedScans scans_of(const KerbedRoad& road, const KerbedDrive& drive);
/// In the map frame, as the trajectory places them: a registered cloud, without times.
cloud::Cloud placed(const KerbedScans& scans);

/// Of some nodes.
struct Tally {
  double nodes = 0.0, square_m2 = 0.0, stated_m2 = 0.0, inside = 0.0;

  void add(double error_m, double stddev_m);
  void add(const Tally& other);
  double rmse_m() const;
  double stated_m() const;  ///< root of the mean stated variance
  double share() const;     ///< of these in their 90 % intervals
};

/// By what they are of; `kerbs` and, beyond them, `verge`: those with points.
struct KerbedTallies {
  Tally road, outer, kerbs, verge, unmeasured;

  void add(const KerbedTallies& other);
};

/// Of the middle of the road; `lost`: share of its nodes that rest on the base; `inside`: of the
/// road's and the kerbs' nodes in their 90 % intervals.
struct KerbedError {
  bool converged = false;
  double road_rmse_m = 0.0, road_max_m = 0.0, banking_rad = 0.0, kerb_p95_m = 0.0, lost = 0.0;
  double measured_kerb_p95_m = 0.0;              ///< the same where points lie; 0: nowhere
  double kerb_rmse_m = 0.0, outer_rmse_m = 0.0;  ///< `outer`: the outermost metre of the road
  double inside = 0.0, outer_inside = 0.0;
  /// Nodes that rest on the base, wherever they lie, and by how much the ramps across them that
  /// are laid over the base are steeper than the correction beside them, at most.
  double unmeasured_rmse_m = 0.0, unmeasured_inside = 1.0, ramp_over_correction = 0.0;
  std::size_t unmeasured_nodes = 0;
  std::size_t road_nodes = 0, kerb_nodes = 0;
  KerbedTallies tallies;
};
/// By points, and not by the base.
bool is_measured(float source);
KerbedError error_of(const KerbedRoad& road, const cloud::MapResult& result);

}  // namespace support
