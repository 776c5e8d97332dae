// The drift of a trajectory as a smooth function of the distance driven, estimated from sections.
#pragma once

#include "sections.h"

namespace cloud {

struct Drift {
  std::vector<Correction> correction;  ///< one per section; added to its poses
  std::vector<Correction> stddev;
};

/// Each section is fitted robustly to the base and, where an earlier pass saw the same road, to
/// that pass; each fit gives single numbers (height of the road's middle, roll, pitch, along,
/// across, yaw) with a variance. A spline with the stiffness of a trajectory's drift goes through
/// them; numbers that it cannot follow (a missing banking, a wrong kerb) lose their weight, by
/// graduated non-convexity (Yang et al. 2020, "Graduated non-convexity for robust spatial
/// perception") with the loss of Geman and McClure. Fills in the report's drift part.
Drift estimate_drift(const Sections& sections, const RoadFrame& frame, const MapOptions& options,
                     MapReport& report);

/// Map positions of a section's cells after the drift was taken out; within a section it changes
/// linearly.
class Mover {
 public:
  Mover(const Sections& sections, const std::vector<Correction>& corrections, std::size_t index);
  Eigen::Vector3d operator()(const SectionCell& cell) const;

 private:
  const Section& section_;
  Correction here_, slope_ = Correction::Zero();
  Eigen::Matrix3d turn_;
  Eigen::Vector3d turn_slope_ = Eigen::Vector3d::Zero(), pivot_slope_ = Eigen::Vector3d::Zero();
};

}  // namespace cloud
