#include "road_trajectory.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "base/statistics.h"

namespace cloud {

RoadTrajectory place_on_road(Trajectory trajectory, const RoadFrame& frame) {
  RoadTrajectory placed;
  const std::size_t n = trajectory.size();
  placed.row.assign(n, 0.0), placed.v_m.assign(n, 0.0), placed.pass.assign(n, 0);
  double row = 0.0, turns_begin = 0.0, unwrapped = 0.0;
  std::size_t beside = 0;
  int pass = 0;
  bool lost = true;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d& p = trajectory.position_m[i];
    const bool new_piece = i == 0 || trajectory.piece[i] != trajectory.piece[i - 1];
    std::optional<GridPlace> place;
    if (!begins_drive(trajectory, i) && !lost) place = frame.project(p.x(), p.y(), row);
    if (!place) place = frame.project(p.x(), p.y(), frame.nearest_row(p.x(), p.y()));
    const bool on =
        place && place->v_m > frame.v_m().front() - 3.0 && place->v_m < frame.v_m().back() + 3.0;
    lost = !on;
    beside += on ? 0 : 1;
    const double here = place ? place->row : row;
    double step = here - row;
    const auto period = static_cast<double>(frame.rows() - 1);
    if (frame.closed()) step -= period * std::round(step / period);
    if (new_piece) {
      pass += i == 0 ? 0 : 1;
      turns_begin = unwrapped = here;
    } else {
      unwrapped += step;
      if (std::abs(unwrapped - turns_begin) >= period) ++pass, turns_begin = unwrapped;
    }
    row = here;
    placed.row[i] = here, placed.v_m[i] = place ? place->v_m : 0.0, placed.pass[i] = pass;
  }
  if (2 * beside > n) {
    Eigen::Vector3d low = trajectory.position_m.front(), high = low;
    for (const Eigen::Vector3d& p : trajectory.position_m)
      low = low.cwiseMin(p), high = high.cwiseMax(p);
    Eigen::Vector2d road_low = frame.node_position(0, 0.0), road_high = road_low;
    for (std::size_t i = 0; i < frame.rows(); ++i)
      road_low = road_low.cwiseMin(frame.node_position(i, 0.0)),
      road_high = road_high.cwiseMax(frame.node_position(i, 0.0));
    const double ratio =
        (road_high - road_low).norm() / std::max(1e-9, (high - low).head<2>().norm());
    std::string hint = "another frame?";
    for (const auto& [factor, unit] : {std::pair{100.0, "cm"}, {1000.0, "mm"}, {3.28084, "ft"}})
      if (std::abs(ratio / factor - 1.0) < 0.1)
        hint = fmt::format("the base is {:.4g} times as large, as if it were in {}; give --unit {}",
                           ratio, unit, unit);
    throw Misfit(
        fmt::format("{} of {} poses lie beside the base: poses x {:.1f} to {:.1f}, y {:.1f} to "
                    "{:.1f} m, base x {:.1f} to {:.1f}, y {:.1f} to {:.1f} m; {}",
                    beside, n, low.x(), high.x(), low.y(), high.y(), road_low.x(), road_high.x(),
                    road_low.y(), road_high.y(), hint));
  }
  placed.poses = std::move(trajectory);
  return placed;
}

std::string about_rate(const Trajectory& poses) {
  constexpr double kTold_m = 0.02;
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < poses.size(); ++i)
    steps_s.push_back(poses.time_s[i] - poses.time_s[i - 1]);
  const double off_m = unknown_between_m(poses), step_s = base::median_or(0.0, std::move(steps_s));
  if (step_s > 1.0 && poses.piece.back() + 2 > static_cast<int>(poses.size()))
    return fmt::format(
        "the trajectory has a pose every {:.3g} s: nothing is known of the way between them; "
        "fifty a second are wanted",
        step_s);
  if (off_m < kTold_m) return {};
  return fmt::format(
      "the trajectory has a pose every {:.3g} s: the way between them is known to {:.0f} mm only; "
      "fifty a second are wanted",
      step_s, 1e3 * off_m);
}

Placed Placer::operator()(const Cloud& chunk, std::size_t i, RoadPoint& point) {
  if (trajectory_ != nullptr) {
    // The beams of one shot have their time in common.
    if (const double time_s = chunk.time_s[i]; time_s != time_s_)
      time_s_ = time_s, posed_ = pose_at(trajectory_->poses, time_s, pose_, instant_);
    if (!posed_) return Placed::no_pose;
    const Eigen::Vector3d ray_m = instant_.turned(chunk.point(i) + chunk.origin_m),
                          &at_m = instant_.position_m;
    point.ray_m = ray_m;
    // By numbers: a pair read from what was just written one by one waits for the memory.
    point.map_m = {at_m.x() + ray_m.x(), at_m.y() + ray_m.y(), at_m.z() + ray_m.z()};
    point.driven_m = instant_.driven_m;
    point.pose = pose_;
    row_ = trajectory_->row[pose_];
  } else {
    point.map_m = chunk.origin_m + chunk.point(i);
  }
  std::optional<GridPlace> place;
  if (row_ >= 0.0) place = frame_.project(point.map_m.x(), point.map_m.y(), row_);
  const auto beside = [&] {
    return !place || place->v_m < frame_.v_m().front() || place->v_m > frame_.v_m().back();
  };
  if (trajectory_ == nullptr && beside())
    place = frame_.project(point.map_m.x(), point.map_m.y(),
                           frame_.nearest_row(point.map_m.x(), point.map_m.y()));
  if (beside()) return Placed::off_road;
  point.place = *place;
  if (trajectory_ == nullptr) row_ = place->row, point.driven_m = place->row * frame_.u_step_m();
  point.above_base_m = point.map_m.z() - frame_.z_origin_m() - frame_.height(*place);
  return std::isfinite(point.above_base_m) ? Placed::on_road : Placed::off_road;
}

}  // namespace cloud
