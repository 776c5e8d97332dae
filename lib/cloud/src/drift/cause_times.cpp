// Times that no clock of all points has, and poses too far apart: told without a trial.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/statistics.h"
#include "cause_bench.h"
#include "road_trajectory.h"

namespace cloud {
namespace {

/// Times in another unit than seconds: no car drives as slowly, no scanner turns as slowly.
std::string about_unit(const Samples& samples, const Trajectory& trajectory) {
  constexpr double kLeastSpan_s = 2.0, kLeastSpeed_mps = 0.3, kLeastStamps_1ps = 1000.0;
  const double points_s = samples.end_s - samples.begin_s,
               poses_s = trajectory.time_s.back() - trajectory.time_s.front();
  if (std::min(points_s, poses_s) < kLeastSpan_s) return {};
  double way_m = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    way_m += (trajectory.position_m[i] - trajectory.position_m[i - 1]).norm();
  const bool too_slow[] = {way_m < kLeastSpeed_mps * poses_s,
                           static_cast<double>(samples.stamps) < kLeastStamps_1ps * points_s};
  for (const auto& [factor, unit] : {std::pair{1e3, "ms"}, {1e6, "us"}, {1e9, "ns"}})
    for (const bool of_points : {false, true}) {
      const double ratio = (of_points ? points_s / poses_s : poses_s / points_s) / factor;
      if (too_slow[of_points ? 1 : 0] && ratio > 0.3 && ratio < 3.0)
        return fmt::format("the times of the {} look like {}: seconds are wanted",
                           of_points ? "points" : "trajectory", unit);
    }
  return {};
}

}  // namespace

std::string about_sweeps(const Samples& samples) {
  constexpr std::size_t kLeastSweeps = 5;
  if (samples.end_s - samples.begin_s > kSweep_s || samples.falls < kLeastSweeps ||
      samples.by_rings)
    return {};
  return fmt::format(
      "the times of the points begin again {} times and never pass {:.3f} s: they count within "
      "each sweep; add to each the time at which its sweep begins",
      samples.falls, samples.end_s);
}

std::string about_times(const Samples& samples, const Trajectory& trajectory) {
  constexpr double kLeastStamp_s = 0.02, kPointsPerStamp = 500.0, kBent_m = 0.1;
  const double points_s = samples.end_s - samples.begin_s;
  if (std::string text = about_sweeps(samples); !text.empty()) return text;
  if (std::string text = about_unit(samples, trajectory); !text.empty()) return text;
  if (std::string text = about_rate(trajectory);
      !text.empty() && !(unknown_between_m(trajectory) < kBent_m))
    return text;
  const auto stamps = static_cast<double>(samples.stamps);
  if (points_s > kLeastStamp_s * stamps &&
      static_cast<double>(samples.points) > kPointsPerStamp * stamps)
    return fmt::format(
        "all points of a sweep have one time, one in {:.3f} s: each needs its own, or the sweeps "
        "must be made free of the car's motion first",
        points_s / std::max(1.0, stamps - 1.0));
  return {};
}

std::string about_distance(const Trajectory& trajectory) {
  constexpr double kFew_m = 0.5;
  std::vector<double> steps_m;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    steps_m.push_back((trajectory.position_m[i] - trajectory.position_m[i - 1]).norm());
  const double step_m = base::median_or(0.0, std::move(steps_m));
  if (step_m < kFew_m) return {};
  return fmt::format(
      "; none of these: the trajectory has a pose every {:.1f} m, which does not follow the bumps "
      "between; one every 0.4 m is wanted (fifty a second at 20 m/s)",
      step_m);
}

}  // namespace cloud
