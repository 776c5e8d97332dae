// The drift of a trajectory as a smooth function of the distance driven, estimated from sections.
#pragma once

#include <optional>

#include "sections.h"

namespace cloud {

/// What is left of the drift over a stretch of the road, for the heights made from all passes:
/// height at v = h + (v - v_m) * slope, all standard deviations and covariances of the estimate.
struct StretchDeviation {
  double v_m = 0.0;  ///< middle of what was seen
  double var_height = 0.0, cov_height_slope = 0.0, var_slope = 0.0;
  double var_along = 0.0, var_across = 0.0;  ///< of the place, m^2
  bool seen = false;
};
inline constexpr double kStretch_m = 10.0;

/// One pass of a stretch against all others: what is left of the drift between them.
struct PassApart {
  int pass = -1;  ///< none: fewer than two passes
  StretchDeviation deviation;
};

struct Drift {
  std::vector<Correction> correction;  ///< one per section; added to its poses
  std::vector<Correction> stddev;
  std::vector<StretchDeviation> stretch;  ///< every kStretch_m of the road
  std::vector<PassApart> apart;           ///< the same stretches
};

/// All sections of all passes and the heights of the road's cells over the base are estimated
/// together, by least squares (joint.h): a cell that several sections see ties them to each other,
/// whatever the base says; where the base is believed it ties them to the map; a trajectory's
/// stiffness bridges the rest. Which cells of the base are believed is decided by graduated
/// non-convexity (Yang et al. 2020, "Graduated non-convexity for robust spatial perception") with
/// the loss of Geman and McClure: a missing banking, bump or kerb loses its weight. Fills in the
/// report's drift part. `before`: corrections that the sections' poses already have, from an
/// estimate with the same sections; then the answer is what is left of the drift. `base_tilt`: what
/// that estimate found; then poses and tilt are nearly right from the beginning.
Drift estimate_drift(const Sections& sections, const RoadFrame& frame, const MapOptions& options,
                     const std::vector<Correction>& before, MapReport& report,
                     std::optional<double> base_tilt = {});

/// The correction between the middles of sections of one piece: cubic through them.
Correction correction_at(const Sections& sections, const std::vector<Correction>& corrections,
                         double driven_m, int piece);

/// Map positions of a section's cells after the drift was taken out; within a section it changes
/// as the neighbours say.
class Mover {
 public:
  Mover(const Sections& sections, const std::vector<Correction>& corrections, std::size_t index);
  Eigen::Vector3d operator()(const SectionCell& cell) const;

 private:
  const Section& section_;
  Correction here_, slope_ = Correction::Zero(), bend_ = Correction::Zero();
  Eigen::Matrix3d turn_;
  Eigen::Vector3d turn_slope_ = Eigen::Vector3d::Zero(), turn_bend_ = Eigen::Vector3d::Zero(),
                  pivot_slope_ = Eigen::Vector3d::Zero(), pivot_bend_ = Eigen::Vector3d::Zero(),
                  path_bend_ = Eigen::Vector3d::Zero();
};

}  // namespace cloud
