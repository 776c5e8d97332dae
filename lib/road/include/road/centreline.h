// The raw middle of the road, traced on the road surface.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "base/answer.h"
#include "mesh/ray_surface.h"
#include "road/road_mesh.h"

namespace road {

/// Ordered stations along the middle of the road in map coordinates, not evenly spaced.
/// When closed, the last station is not a repetition of the first.
struct Centreline {
  std::vector<Eigen::Vector3d> points_m;  ///< midpoint of the two edges, on the surface
  std::vector<double> half_width_m;       ///< same length
  bool closed = false;
  double length_m = 0.0;  ///< along the smooth curve through the points
};

/// A road that is narrower is that of a model; lengths that suit a road of the usual width shrink
/// with it.
constexpr double kModelWidth_m = 3.0, kUsualWidth_m = 8.0;

struct CentrelineOptions {
  bool reverse = false;  ///< drive the other way round
  std::optional<Eigen::Vector2d>
      start_near_m;                     ///< u = 0 where the line passes nearest to this map point
  std::optional<double> guide_width_m;  ///< where a guide leads over ground that does not tell
};

/// Finds the road by itself: a closed loop if there is one, else the longest open road. Along the
/// guide of the surface where it has one: open or closed as that is, in its direction, u = 0 at its
/// beginning; the guide's own errors do not enter the line, but where the surface does not tell how
/// wide the road is. A refusal when the road surface is no strip of 3-60 m width, or when two
/// disjoint roads exist.
base::Answer<Centreline> try_trace_centreline(const RoadMesh& road,
                                              const CentrelineOptions& options = {});

/// The same for those who have no other road to take: throws the refusal as Error.
Centreline trace_centreline(const RoadMesh& road, const CentrelineOptions& options = {});

/// Whether every place of a line lies on the road along another one (nearer than both half widths,
/// in plan).
bool goes_along(const Centreline& line, const Centreline& other);

/// centreline.csv: x_m,y_m,z_m,half_width_m with a header line.
void write_centreline_csv(const Centreline& centreline, const std::string& path);
Centreline read_centreline_csv(const std::string& path);

}  // namespace road
