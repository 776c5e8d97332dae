#include "cloud/map.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <numbers>

#include "causes.h"
#include "cloud/error.h"
#include "drift.h"
#include "fuse.h"
#include "height_cells.h"
#include "sections.h"

namespace cloud {
namespace {

// The second look turns poses by a third of this, or by about half of what the base is tilted.
constexpr double kTurnedMuch_rad = 0.001;
constexpr double kTiltedMuch = 5e-4;  // of a base, as a slope across

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The source, with its own time kept apart from that of its reader.
CloudSource timed(const CloudSource& source, double& seconds) {
  return [&source, &seconds](const ChunkSink& sink) {
    double inside = 0.0;
    const Clock::time_point start = Clock::now();
    source([&](Cloud&& chunk) {
      const Clock::time_point here = Clock::now();
      sink(std::move(chunk));
      inside += seconds_since(here);
    });
    seconds += seconds_since(start) - inside;
  };
}

std::string box(double x0, double x1, double y0, double y1) {
  return fmt::format("x {:.1f} to {:.1f}, y {:.1f} to {:.1f} m", x0, x1, y0, y1);
}

/// Says what the counts of the first reading tell about clock, frame and units.
void check(const Sections& sections, const RoadFrame& frame, const RoadTrajectory* trajectory,
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
}

/// The trajectory with the drift taken out.
Trajectory corrected_trajectory(const RoadTrajectory& trajectory, const Sections& sections,
                                const Drift& drift) {
  Trajectory out = trajectory.poses;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Correction c = correction_at(sections, drift.correction, out.driven_m[i], out.piece[i]);
    out.position_m[i] += c.head<3>();
    out.orientation[i] =
        (Eigen::Quaterniond(rotation_of(c, out.orientation[i].toRotationMatrix())) *
         out.orientation[i])
            .normalized();
  }
  return out;
}

/// Roll and pitch of the section that was turned most.
double largest_turn_rad(const Drift& drift) {
  double largest = 0.0;
  for (const Correction& c : drift.correction)
    largest = std::max({largest, std::abs(c[3]), std::abs(c[4])});
  return largest;
}

/// Places that see the same ground should agree whatever the drift is.
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

/// A base that is tilted as a whole, and one that may be.
void look_at_tilt(const MapOptions& options, MapReport& report) {
  constexpr double kUnknown = 1e-3;
  if (!options.trust_base || !options.correct_drift) return;
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

/// What all corrections have in common is no drift: words for what was corrected.
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

/// The drift that is left in `sections`, which are gathered again as often as that is wanted, and
/// in `straightened`, which all but that is taken out of. Null: no trajectory.
Drift take_out_drift(const CloudSource& source, const RoadFrame& frame, const MapOptions& options,
                     RoadTrajectory* straightened, Sections& sections, MapReport& report) {
  Drift drift = estimate_drift(sections, frame, options, {}, report);
  std::vector<Correction> taken_out = drift.correction;
  if (straightened == nullptr) {
    std::fill(taken_out.begin(), taken_out.end(), Correction::Zero());
    return estimate_drift(sections, frame, options, taken_out, report);
  }
  const auto look_again = [&](const char* what, double share) {
    if (options.progress) options.progress(what, share);
    straightened->poses = corrected_trajectory(*straightened, sections, drift);
    sections = collect_sections(source, frame, straightened, options, false);
  };
  // Once more, for what a section's means do not show.
  look_again("look at the straightened points", 0.4);
  drift = estimate_drift(sections, frame, options, taken_out, report);
  if (!options.trust_base || largest_turn_rad(drift) <= kTurnedMuch_rad) return drift;
  // The poses had followed a tilted base, or drifted much at an end: cells were gathered with
  // another attitude than they have.
  for (std::size_t i = 0; i < taken_out.size(); ++i) taken_out[i] += drift.correction[i];
  look_again("look at the points turned back", 0.5);
  std::optional<double> base_tilt;
  if (std::abs(report.base_tilt) > kTiltedMuch) base_tilt = report.base_tilt;
  return estimate_drift(sections, frame, options, taken_out, report, base_tilt);
}

MapResult map_fitting(const CloudSource& scans, const crg::Crg& base, const RoadFrame& frame,
                      const Trajectory* trajectory, const MapOptions& options) {
  MapResult result;
  MapReport& report = result.report;
  const auto stage = [&](const char* name, double share) {
    if (options.progress) options.progress(name, share);
  };
  RoadTrajectory placed;
  if (trajectory != nullptr) placed = place_on_road(*trajectory, frame);
  const RoadTrajectory* const poses = trajectory != nullptr ? &placed : nullptr;
  const CloudSource source = timed(scans, report.seconds_read);

  stage("look at the points", 0.0);
  Clock::time_point start = Clock::now();
  Sections sections = collect_sections(source, frame, poses, options, options.correct_drift);
  report.looked_at = sections.points, report.without_pose = sections.without_pose,
  report.off_road = sections.off_road;
  report.far_from_base = sections.far_from_base, report.on_obstacles = sections.on_obstacles;
  check(sections, frame, poses, options);
  report.seconds_estimate = seconds_since(start);

  start = Clock::now();
  Drift drift;
  drift.correction.assign(sections.list.size(), Correction::Zero());
  drift.stddev = drift.correction;
  RoadTrajectory straightened = placed;
  if (options.correct_drift) {
    stage("drift", 0.25);
    drift = take_out_drift(source, frame, options, trajectory != nullptr ? &straightened : nullptr,
                           sections, report);
  }
  report.on_grass = sections.on_grass;
  if (trajectory != nullptr) {
    straightened.poses = corrected_trajectory(straightened, sections, drift);
    result.corrected.push_back(straightened.poses);
    if (options.trust_base) look_at_common(sections, placed.poses, options, report);
    look_at_views(options, report);
    look_at_tilt(options, report);
  }
  if (options.correct_drift && options.trust_base && report.rms_after_m > 0.05)
    throw Misfit(fmt::format(
        "after the correction the points still scatter by {:.0f} mm about the base; the "
        "trajectory's clock or frame does not fit, or base and cloud show different places",
        1e3 * report.rms_after_m));
  report.seconds_drift = seconds_since(start);

  stage("heights of the nodes", 0.6);
  start = Clock::now();
  const HeightCells surface = cells_of(sections, drift.correction, frame, -1, options.threads);
  const RoadSums sums = accumulate(source, frame, trajectory != nullptr ? &straightened : nullptr,
                                   sections, drift, surface, options, report);
  report.seconds_grid = seconds_since(start);
  stage("base and points", 0.9);
  start = Clock::now();
  fuse(sums, frame, base.grid, sections, drift, options, result);
  report.seconds_fuse = seconds_since(start);
  if (200 * report.nodes_lidar < report.nodes - report.nodes_hole || report.nodes_lidar < 100)
    if (!options.trust_base || report.nodes_lidar == 0)
      throw Error(fmt::format(
          "{} of {} nodes of the road got a height from the {} points: the line, or the road, lies "
          "beside the cloud",
          report.nodes_lidar, report.nodes - report.nodes_hole, report.points));
  return result;
}

}  // namespace

MapResult map_clouds(const CloudSource& scans, const crg::Crg& base, const Trajectory* trajectory,
                     const MapOptions& options) {
  const RoadFrame frame(base);
  const auto causes = [&] {
    if (trajectory == nullptr || !options.trust_base) return std::string();
    if (options.progress) options.progress("look for what does not fit", 0.95);
    return likely_causes(scans, frame, *trajectory, options);
  };
  try {
    MapResult result = map_fitting(scans, base, frame, trajectory, options);
    MapReport& report = result.report;
    // Without a base nothing holds the height of all poses together: it goes on moving, and the
    // road between the poses is right all the same.
    if (options.correct_drift && options.trust_base && !report.converged)
      report.faults.insert(
          report.faults.begin(),
          fmt::format("the drift had not converged after {} rounds (more or less noisy points, "
                      "or --drift-m and --drift-rad that fit the trajectory)",
                      report.iterations));
    if (!report.faults.empty())
      if (std::string text = causes(); !text.empty()) report.faults.push_back(std::move(text));
    return result;
  } catch (const Misfit& misfit) {
    const std::string text = causes();
    if (text.empty()) throw;
    throw Error(std::string(misfit.what()) + "; " + text);
  }
}

}  // namespace cloud
