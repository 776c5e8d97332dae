#include "map_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bow.h"
#include "causes.h"
#include "map_remarks.h"

namespace cloud {
namespace {

// Of the base, with the drift taken out: 0.2 mm in trials; 5 to 9 where poses have settled 0.5 m
// beside the road that they drove on.
constexpr double kRough_m = 0.002;

// The second look turns poses by a third of this, or by about half of what the base is tilted.
constexpr double kTurnedMuch_rad = 0.001;

/// Adds the time of its life.
class Watch {
 public:
  explicit Watch(double& seconds) : seconds_(seconds) {}
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;
  ~Watch() { seconds_ += std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  double& seconds_;
  Clock::time_point start_ = Clock::now();
};

void tell(const MapInputs& inputs, const char* stage, double share) {
  if (inputs.options.progress) inputs.options.progress(stage, share);
}

/// What the drift is estimated with: it tells its share of the whole way, from one to another.
MapOptions between(const MapInputs& inputs, double begin, double end) {
  MapOptions options = inputs.options;
  if (options.progress)
    options.progress = [&inputs, begin, end](const std::string& stage, double share) {
      inputs.options.progress(stage, begin + share * (end - begin));
    };
  return options;
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

void straighten(MapState& state) {
  state.poses.poses = corrected_trajectory(state.poses, state.sections, state.drift);
}

/// The drift is known: what the heights want of it, and what is to be said of it.
void settle(MapState& state, const MapInputs& inputs) {
  MapReport& report = state.report;
  const MapOptions& options = inputs.options;
  state.step = MapStep::heights, state.due = true;
  report.on_grass = state.sections.on_grass;
  if (inputs.placed != nullptr) {
    straighten(state);
    look_at_poses(inputs.placed->poses, report);
    if (options.trust_base) look_at_common(state.sections, inputs.placed->poses, options, report);
    look_at_views(options, report);
    look_at_tilt(options, report);
  }
  if (options.correct_drift && options.trust_base && report.rms_after_m > 0.05)
    throw Misfit(fmt::format(
        "after the correction the points still scatter by {:.0f} mm about the base; the "
        "trajectory's clock or frame does not fit, or base and cloud show different places",
        1e3 * report.rms_after_m));
  report.changed = state.changed.places;
  if (options.keep_older && !report.changed.empty()) {
    state.older = cells_of(state.sections, state.drift.correction, inputs.frame, -1,
                           options.threads, state.changed.first_pass, true);
    state.older->agrees_m = state.changed.agrees_m;
  }
  state.surface = cells_of(state.sections, state.drift.correction, inputs.frame, -1,
                           options.threads, std::move(state.changed.first_pass));
  state.surface.agrees_m = std::move(state.changed.agrees_m);
}

void after_first_look(MapState& state, Look&& look, const MapInputs& inputs) {
  MapReport& report = state.report;
  const MapOptions& options = inputs.options;
  state.sections = judged(std::move(look), inputs.frame, options.correct_drift, options.edge_m);
  const Sections& sections = state.sections;
  report.looked_at = sections.points, report.without_pose = sections.without_pose,
  report.off_road = sections.off_road;
  report.far_from_base = sections.far_from_base, report.on_obstacles = sections.on_obstacles;
  check_fit(sections, inputs.frame, inputs.placed, options);
  if (inputs.placed == nullptr && options.trust_base) {
    const std::vector<Correction> none(sections.list.size(), Correction::Zero());
    look_at_bow(bow_of(cells_of(sections, none, inputs.frame, -1, options.threads), inputs.frame),
                options, report);
  }
  if (!options.correct_drift) {
    state.drift.correction.assign(sections.list.size(), Correction::Zero());
    state.drift.stddev = state.drift.correction;
    return settle(state, inputs);
  }
  tell(inputs, "drift", 0.25);
  state.drift = estimate_drift(sections, inputs.frame, between(inputs, 0.25, 0.4), {}, report);
  if (inputs.placed == nullptr) {
    const std::vector<Correction> none(sections.list.size(), Correction::Zero());
    state.drift = estimate_drift(sections, inputs.frame, between(inputs, 0.4, 0.6), none, report);
    return settle(state, inputs);
  }
  state.taken_out = state.drift.correction;
  straighten(state);
  state.step = MapStep::look_again;
}

/// Once more, for what a section's means do not show.
void after_second_look(MapState& state, Look&& look, const MapInputs& inputs) {
  state.sections = judged(std::move(look), inputs.frame, false, inputs.options.edge_m);
  state.drift = estimate_drift_apart(state.sections, inputs.frame, between(inputs, 0.5, 0.55),
                                     state.taken_out, state.report, {}, state.changed);
  const bool turned_much =
      inputs.options.trust_base && largest_turn_rad(state.drift) > kTurnedMuch_rad;
  if (!turned_much) settle(state, inputs);
  state.step = MapStep::look_turned_back, state.due = turned_much;
  if (!turned_much) return;
  // The poses had followed a tilted base, or drifted much at an end: cells were gathered with
  // another attitude than they have.
  for (std::size_t i = 0; i < state.taken_out.size(); ++i)
    state.taken_out[i] += state.drift.correction[i];
  straighten(state);
  if (std::abs(state.report.base_tilt) > kTiltedMuch) state.base_tilt = state.report.base_tilt;
}

void after_third_look(MapState& state, Look&& look, const MapInputs& inputs) {
  state.sections = judged(std::move(look), inputs.frame, false, inputs.options.edge_m);
  state.drift = estimate_drift_apart(state.sections, inputs.frame, between(inputs, 0.6, 0.65),
                                     state.taken_out, state.report, state.base_tilt, state.changed);
  settle(state, inputs);
}

/// The road as it was where its ground changed. What it says of its nodes stays out of the report.
OlderRoad fuse_older(const RoadSums& sums, const MapState& state, const MapInputs& inputs) {
  MapResult result;
  fuse(sums, inputs.frame, inputs.base, state.sections, state.drift, inputs.options, result);
  return {std::move(result.grid), std::move(result.stddev), std::move(result.source)};
}

void after_heights(MapState& state, const Reading& reading, const MapInputs& inputs,
                   MapResult& result) {
  const MapOptions& options = inputs.options;
  const RoadSums& sums = *reading.sums;
  state.report.points = sums.read, state.report.used = sums.used;
  tell(inputs, "base and points", 0.9);
  result.report = std::move(state.report);
  MapReport& report = result.report;
  {
    const Watch watch(report.seconds_fuse);
    fuse(sums, inputs.frame, inputs.base, state.sections, state.drift, options, result);
    if (reading.older) result.older = fuse_older(*reading.older, state, inputs);
  }
  if (inputs.placed != nullptr) result.corrected.push_back(std::move(state.poses.poses));
  state.step = MapStep::done;
  if (200 * report.nodes_lidar < report.nodes - report.nodes_hole || report.nodes_lidar < 100)
    if (!options.trust_base || report.nodes_lidar == 0)
      throw Error(fmt::format(
          "{} of {} nodes of the road got a height from the {} points: the line, or the road, lies "
          "beside the cloud, or the points are too far apart (four and more to a cell of {} m are "
          "wanted)",
          report.nodes_lidar, report.nodes - report.nodes_hole, report.points, kSectionCell_m));
}

}  // namespace

MapState first_state(const MapInputs& inputs) {
  MapState state;
  if (inputs.placed != nullptr) state.poses = *inputs.placed;
  return state;
}

Reading read_for(const MapState& state, const CloudSource& scans, const MapInputs& inputs,
                 MapReport& times) {
  Reading reading;
  const RoadTrajectory* const poses = inputs.placed != nullptr ? &state.poses : nullptr;
  if (!state.due) return reading;
  if (state.step == MapStep::heights) {
    const Watch watch(times.seconds_grid);
    tell(inputs, "heights of the nodes", 0.65);
    reading.sums = accumulate(scans, inputs.frame, poses, state.sections, state.drift,
                              state.surface, inputs.options);
    if (!state.older) return reading;
    tell(inputs, "heights of the older ground", 0.8);
    reading.older = accumulate(scans, inputs.frame, poses, state.sections, state.drift,
                               *state.older, inputs.options);
    return reading;
  }
  const Watch watch(state.step == MapStep::look ? times.seconds_estimate : times.seconds_drift);
  if (state.step == MapStep::look) tell(inputs, "look at the points", 0.0);
  if (state.step == MapStep::look_again) tell(inputs, "look at the straightened points", 0.4);
  if (state.step == MapStep::look_turned_back) tell(inputs, "look at the points turned back", 0.55);
  reading.look = look_at(scans, inputs.frame, poses, inputs.options, inputs.visits_known);
  if (state.step == MapStep::look && poses != nullptr)
    want_one_clock(scans, reading.look->sections, poses->poses);
  return reading;
}

void join(Reading& all, Reading&& part) {
  if (part.look) {
    if (all.look)
      join(*all.look, std::move(*part.look));
    else
      all.look = std::move(part.look);
  }
  if (part.sums) {
    if (all.sums)
      all.sums->add(*part.sums);
    else
      all.sums = std::move(part.sums);
  }
}

void advance(MapState& state, Reading&& reading, const MapInputs& inputs, MapResult& result) {
  if (state.step == MapStep::look_turned_back && !state.due) {
    state.step = MapStep::heights, state.due = true;
    return;
  }
  if (state.step == MapStep::heights) return after_heights(state, reading, inputs, result);
  const Watch watch(state.report.seconds_drift);
  if (state.step == MapStep::look)
    after_first_look(state, std::move(*reading.look), inputs);
  else if (state.step == MapStep::look_again)
    after_second_look(state, std::move(*reading.look), inputs);
  else
    after_third_look(state, std::move(*reading.look), inputs);
}

MapResult with_causes(const CloudSource& scans, const RoadFrame& frame,
                      const Trajectory* trajectory, const MapOptions& options,
                      const std::function<MapResult()>& work) {
  const auto causes = [&](const Trajectory* found = nullptr) {
    if (trajectory == nullptr || !options.trust_base) return std::string();
    if (options.progress) options.progress("look for what does not fit", 0.95);
    return likely_causes(scans, frame, *trajectory, options, found);
  };
  try {
    MapResult result = work();
    MapReport& report = result.report;
    // Without a base nothing holds the height of all poses together: it goes on moving, and the
    // road between the poses is right all the same.
    if (report.nodes > 0 && options.correct_drift && options.trust_base && !report.converged)
      report.faults.insert(
          report.faults.begin(),
          fmt::format("the drift had not converged after {} rounds (more or less noisy points, "
                      "or --drift-m and --drift-rad that fit the trajectory)",
                      report.iterations));
    if (!report.faults.empty()) {
      if (std::string text = causes(); !text.empty()) report.faults.push_back(std::move(text));
    } else if (report.base_stddev_m > kRough_m && !result.corrected.empty()) {
      if (const std::string text = causes(&result.corrected.front()); !text.empty())
        report.faults.push_back(
            fmt::format("with the drift taken out the points still scatter by {:.0f} mm about the "
                        "base, and the trajectory as it was fits better in another way; {}",
                        1e3 * report.base_stddev_m, text));
    }
    look_at_changes(options, report);
    return result;
  } catch (const Misfit& misfit) {
    const std::string text = causes();
    if (text.empty()) throw;
    throw Error(std::string(misfit.what()) + "; " + text);
  }
}

}  // namespace cloud
