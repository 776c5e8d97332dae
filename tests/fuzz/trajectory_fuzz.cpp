// Poses of a sensor.
#include <cmath>

#include "base/error.h"
#include "cloud/trajectory.h"
#include "fuzz/target.h"

void fuzz::run(std::string_view bytes) {
  const std::string path = folder().put("poses.csv", bytes);
  try {
    const cloud::Trajectory trajectory = cloud::read_trajectory(path);
    const std::size_t n = trajectory.size();
    require(n >= 2 && trajectory.position_m.size() == n && trajectory.orientation.size() == n &&
                trajectory.driven_m.size() == n && trajectory.piece.size() == n,
            "two poses, arrays that fit each other");
    double driven_m = 0.0;
    for (std::size_t i = 1; i < n; ++i) {
      require(trajectory.time_s[i] > trajectory.time_s[i - 1], "times that ascend");
      require(trajectory.driven_m[i] >= trajectory.driven_m[i - 1], "a way that is driven on");
      if (trajectory.piece[i] == trajectory.piece[i - 1])
        driven_m += trajectory.driven_m[i] - trajectory.driven_m[i - 1];
    }
    require(driven_m <= 2.001e6, "no more than 2,000 km");
    std::size_t hint = 0;
    cloud::PosedInstant pose;
    for (std::size_t i = 0; i + 1 < n; ++i) {
      const double middle_s = 0.5 * (trajectory.time_s[i] + trajectory.time_s[i + 1]);
      if (!cloud::pose_at(trajectory, middle_s, hint, pose)) continue;
      require(pose.position_m.allFinite() && std::isfinite(pose.driven_m), "places between poses");
      require(std::abs(pose.orientation.norm() - 1.0) < 1e-6, "attitudes between poses");
    }
  } catch (const base::Error& error) {
    require_refusal(error, path);
  }
}
