#include "map_remarks.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

namespace cloud {
namespace {

std::string box(double x0, double x1, double y0, double y1) {
  return fmt::format("x {:.1f} to {:.1f}, y {:.1f} to {:.1f} m", x0, x1, y0, y1);
}

/// Points that cells hold one by one, as those of a height model, tell of no surface.
void check_density(const Sections& sections, double on_road) {
  constexpr double kLeastInCells = 0.05;
  auto in_cells =
      static_cast<double>(sections.on_obstacles + sections.on_grass + sections.far_from_base);
  for (const Section& section : sections.list)
    for (const SectionCell& cell : section.cells) in_cells += static_cast<double>(cell.points);
  if (in_cells > kLeastInCells * on_road) return;
  throw Error(fmt::format(
      "{:.0f} of {:.0f} points on the road that were looked at lie near others: they are too far "
      "apart; four and more to a cell of {} m are wanted (a height model has one: give the points "
      "that it was made of)",
      in_cells, on_road, kSectionCell_m));
}

}  // namespace

void check_fit(const Sections& sections, const RoadFrame& frame, const RoadTrajectory* trajectory,
               const MapOptions& options) {
  const auto all = static_cast<double>(sections.points);
  Eigen::Vector2d low = frame.node_position(0, 0.0), high = low;
  for (std::size_t i = 0; i < frame.rows(); ++i)
    low = low.cwiseMin(frame.node_position(i, 0.0)),
    high = high.cwiseMax(frame.node_position(i, 0.0));
  const double ratio =
      (high - low).norm() / std::max(1e-9, (sections.max_m - sections.min_m).norm());
  std::string hint = "is one of them in another frame or unit?";
  for (const auto& [factor, unit] : {std::pair{100.0, "cm"}, {1000.0, "mm"}, {3.28084, "ft"}})
    if (std::abs(ratio / factor - 1.0) < 0.25)
      hint = fmt::format("the base is {:.4g} times as large, as if it were in {}", ratio, unit);
  if (trajectory != nullptr && static_cast<double>(sections.without_pose) > 0.5 * all) {
    if (!(sections.time_begin_s <= sections.time_end_s))
      throw Error(
          "the times of the points are not numbers; seconds on the trajectory's clock wanted");
    const std::vector<double>& t = trajectory->poses.time_s;
    if (sections.time_begin_s >= t.front() && sections.time_end_s <= t.back())
      if (const std::string rate = about_rate(trajectory->poses); !rate.empty())
        // The causes tell the rate as well, unless the times are in another unit.
        throw Misfit(options.trust_base
                         ? fmt::format("{:.0f} % of the points lie between poses too far apart",
                                       100.0 * static_cast<double>(sections.without_pose) / all)
                         : rate);
    throw Misfit(
        fmt::format("{:.0f} % of the points lie outside the trajectory's time: points {:.3f} to "
                    "{:.3f} s, trajectory {:.3f} to {:.3f} s; both must use one clock",
                    100.0 * static_cast<double>(sections.without_pose) / all, sections.time_begin_s,
                    sections.time_end_s, t.front(), t.back()));
  }
  const double placed = all - static_cast<double>(sections.without_pose);
  const double on_road = placed - static_cast<double>(sections.off_road);
  if (on_road < 0.01 * placed || on_road < 100.0) {
    throw Misfit(fmt::format(
        "the cloud does not overlap the base: points {}, base {}; {}",
        box(sections.min_m.x(), sections.max_m.x(), sections.min_m.y(), sections.max_m.y()),
        box(low.x(), high.x(), low.y(), high.y()), hint));
  }
  if (static_cast<double>(sections.far_from_base) > 0.5 * on_road)
    throw Misfit(fmt::format(
        "{:.0f} % of the points on the road lie more than {} m above or below the base; the {} not "
        "fit (height datum, clock, mounting of the sensor: --extrinsic); {}",
        100.0 * static_cast<double>(sections.far_from_base) / on_road, options.gate_m,
        trajectory != nullptr ? "trajectory's frame or clock does" : "cloud's frame does", hint));
  if (options.trust_base) check_density(sections, on_road);
}

void look_at_changes(const MapOptions& options, MapReport& report) {
  if (report.changed.empty()) return;
  const ChangedPlace& place = report.changed.front();
  double area_m2 = 0.0;
  for (const ChangedPlace& each : report.changed) area_m2 += each.area_m2;
  const std::string text = fmt::format(
      "the ground changed between passes at {} place{} ({:.0f} m2; changes.csv lists them), the "
      "largest at u {:.1f} to {:.1f} m, v {:.1f} to {:.1f} m: {:+.1f} mm after pass {}; the road "
      "has the newer ground there",
      report.changed.size(), report.changed.size() > 1 ? "s" : "", area_m2, place.u_begin_m,
      place.u_end_m, place.v_begin_m, place.v_end_m, 1e3 * place.change_m, place.pass + 1);
  if (options.keep_older)
    report.remarks.push_back(text + ", older.crg the older; changes.png shows the places");
  else
    report.faults.push_back(
        text +
        "; the same 'lidar2mesh map' with --campaigns keeps the older ground beside it, with a "
        "map of the change; if something only lay or stood there, leave that pass out");
}

void look_at_views(const MapOptions& options, MapReport& report) {
  // In trials 1.0 to 1.5, and 30 with a clock that is 50 ms off; without a base 3 to 6, and 20.
  const double together = options.trust_base ? 5.0 : 10.0;
  if (!(report.view_together > together)) return;
  const std::string text = fmt::format(
      "heights of the same ground seen from different places differ evenly over metres (errors of "
      "{:.0f} cells come as one, {:.1f} mm remain): clock, mounting of the sensor (--extrinsic) or "
      "shape of the trajectory is a little off",
      report.view_together, 1e3 * report.rms_after_m);
  (options.trust_base ? report.faults : report.remarks).push_back(text);
}

void look_at_tilt(const MapOptions& options, MapReport& report) {
  constexpr double kUnknown = 1e-3;
  if (!options.trust_base || !options.correct_drift) return;
  if (report.base_crown != 0.0)
    report.remarks.push_back(
        fmt::format("the base has another crown: {:+.2f} mrad are missing in its rise to both "
                    "sides of the line; corrected",
                    1e3 * report.base_crown));
  if (report.base_tilt_stddev > kUnknown)
    report.remarks.push_back(fmt::format(
        "nothing on this stretch tells a base that is tilted as a whole from the sensor's own "
        "roll: the cross slope is the base's, to {:.1f} mrad (as --base-stddev-m says; the stated "
        "deviations hold it); a stretch with a bend would tell",
        1e3 * report.base_tilt_stddev));
  else if (std::abs(report.base_tilt) > std::max(kTiltedMuch, 3.0 * report.base_tilt_stddev))
    report.remarks.push_back(
        fmt::format("the base as a whole is tilted: {:.2f} +- {:.2f} mrad are missing in its cross "
                    "slope (more height to the left); corrected",
                    1e3 * report.base_tilt, 1e3 * report.base_tilt_stddev));
}

void look_at_poses(const Trajectory& poses, MapReport& report) {
  std::size_t leaps = 0, gaps = 0, first_leap = 0, first_gap = 0;
  double missing_s = 0.0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const double step_s = poses.time_s[i] - poses.time_s[i - 1];
    if (begins_drive(poses, i)) continue;
    if (poses.piece[i] != poses.piece[i - 1] && leaps++ == 0) first_leap = i;
    if (step_s > poses.longest_step_s && gaps++ == 0) first_gap = i;
    if (step_s > poses.longest_step_s) missing_s += step_s;
  }
  const auto more = [](std::size_t count, const char* what) {
    return count > 1 ? fmt::format(", and {} more {}", count - 1, what) : std::string();
  };
  if (std::string rate = about_rate(poses); !rate.empty())
    report.remarks.push_back(std::move(rate));
  if (leaps > 0)
    report.remarks.push_back(fmt::format(
        "the trajectory leaps by {:.2f} m within {:.3g} s at {:.3f} s{}: what lies behind a leap "
        "has a drift of its own",
        (poses.position_m[first_leap] - poses.position_m[first_leap - 1]).norm(),
        poses.time_s[first_leap] - poses.time_s[first_leap - 1], poses.time_s[first_leap],
        more(leaps, leaps > 2 ? "times" : "time")));
  if (gaps > 0)
    report.remarks.push_back(fmt::format(
        "the trajectory has no pose between {:.3f} and {:.3f} s{}; the points of {:.2f} s without "
        "poses are left out",
        poses.time_s[first_gap - 1], poses.time_s[first_gap], more(gaps, gaps > 2 ? "gaps" : "gap"),
        missing_s));
}

void look_at_common(const Sections& sections, const Trajectory& poses, const MapOptions& options,
                    MapReport& report) {
  double time = 0.0, length = 0.0, pieces = 1.0;
  for (std::size_t i = 1; i < poses.size(); ++i)
    if (poses.piece[i] == poses.piece[i - 1])
      time += poses.time_s[i] - poses.time_s[i - 1],
          length += poses.driven_m[i] - poses.driven_m[i - 1];
    else
      pieces += 1.0;
  Eigen::Vector3d frame = Eigen::Vector3d::Zero(), mounting = frame, turn = frame;
  double clock = 0.0, count = 0.0;
  std::size_t station = 0;  // one per section with data
  const auto each = [&](const auto& what) {
    station = 0;
    for (const Section& section : sections.list) {
      if (!section.has_data() || station == report.drift.size()) continue;
      const std::array<double, 6>& c = report.drift[station++].correction;
      what(section, Eigen::Vector3d(c[0], c[1], c[2]), Eigen::Vector3d(c[3], c[4], c[5]));
    }
  };
  const auto ahead = [](const Section& s) {
    return Eigen::Vector3d(std::cos(s.heading_rad), std::sin(s.heading_rad), 0.0);
  };
  each([&](const Section& s, const Eigen::Vector3d& move, const Eigen::Vector3d& rotation) {
    frame += move, mounting += s.axes.transpose() * move, turn += rotation;
    clock += move.dot(ahead(s)), count += 1.0;
  });
  if (count == 0.0 || time == 0.0) return;
  frame /= count, mounting /= count, turn /= count, clock /= count;
  // Three deviations of a drift that began before the first pose.
  const double as_drift = 3.0 * std::sqrt(1.0 + length / pieces / 100.0);
  const char* const about[] = {"roll", "pitch", "yaw"};
  for (int k = 0; k < 3; ++k)
    if (std::abs(turn[k]) > as_drift * options.drift_rad_per_100m)
      report.remarks.push_back(fmt::format(
          "all poses were turned by {:.2f} deg in {} on average, more than a drift explains: the "
          "mounting of the sensor (--extrinsic) or the attitude of the poses is off; corrected",
          turn[k] * 180.0 / std::numbers::pi, about[k]));
  double off_frame = 0.0, off_mounting = 0.0, off_clock = 0.0;
  each([&](const Section& s, const Eigen::Vector3d& move, const Eigen::Vector3d&) {
    off_frame += (move - frame).squaredNorm();
    off_mounting += (s.axes.transpose() * move - mounting).squaredNorm();
    off_clock += (move - clock * ahead(s)).squaredNorm();
  });
  const double limit_m = as_drift * options.drift_m_per_100m;
  if (std::max({frame.norm(), mounting.norm(), std::abs(clock)}) < limit_m) return;
  const double speed = length / time;
  std::string text;
  if (off_clock < off_frame && off_clock < off_mounting)
    text = fmt::format(
        "{:.2f} m {} along the road, which at {:.1f} m/s is a clock that is {:.0f} ms {}",
        std::abs(clock), clock > 0.0 ? "ahead" : "back", speed, 1e3 * std::abs(clock) / speed,
        clock > 0.0 ? "late" : "early");
  else if (off_frame < off_mounting)
    text = fmt::format(
        "{:.2f} {:.2f} {:.2f} m in x y z: the frame or height datum of the poses is off", frame.x(),
        frame.y(), frame.z());
  else
    text = fmt::format(
        "{:.2f} m ahead, {:.2f} m to the left, {:.2f} m up: the mounting of the sensor "
        "(--extrinsic) is off",
        mounting.x(), mounting.y(), mounting.z());
  report.remarks.push_back("all poses were moved on average by " + text + "; corrected");
}

}  // namespace cloud
