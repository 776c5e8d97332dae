#include "drift.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/statistics.h"
#include "joint.h"

namespace cloud {
namespace {

constexpr int kDriftRounds = 32;    // steps shrink by a third each; grass too low to tell needs 20
constexpr int kRoundsRefined = 16;  // at least, after that
constexpr int kRoundsWithoutBase = 40, kLeastWithoutBase = 20;  // long roads bend slowly
// Without a base nothing damps the steps: slopes of the road, which lag behind by one, swing.
constexpr double kStepWithoutBase = 0.5;
/// What all poses have in common may go on moving by so much of what the trajectory may be off.
constexpr double kMovesWithoutBase = 0.01;
/// Where the base lies farther off than this it is not believed, round by round; then three of its
/// own deviations.
constexpr double kBaseScales_m[] = {0.1, 0.05, 0.025, 0.012, 0.006, 0.003};
constexpr int kSchedule = std::size(kBaseScales_m);
/// As long as the points do not say that the base as a whole is tilted, it is by no more than this
/// part of what it may be. (The stated deviations know that it may.)
constexpr double kTilted = 0.03;
/// Poses that move by less in a round are nearly right. Where a part of the base is tilted what is
/// believed of it moves on by metres a round, and the poses by millimetres, until it may be tilted:
/// that is enough once what errors have in common was measured. (At once it leads ten passes
/// astray.)
constexpr double kNearly_m = 0.001, kNearlyMeasured_m = 0.005;
constexpr double kStillAside_m = 0.01;  // along a road without grade nothing holds them
/// Where the first look moves all poses aside by more, another one begins with poses that lie where
/// they are said to: a kerb that the base has too low moved them to where the other kerb was not
/// believed either.
constexpr double kMovedAside_m = 0.05, kHeldAside_m = 0.005;
constexpr double kRoad_m = 10.0;  // over this width a tilt may be all of what the base is off by
constexpr double kLeastBaseStddev_m = 0.0001;
constexpr double kMostAssumed = 2.0;  // of variances: one view in a cell, and a base without errors

/// Slope and bend of the correction at a section, from its neighbours in the piece.
void shape_at(const Sections& sections, const std::vector<Correction>& corrections,
              std::size_t index, Correction& slope, Correction& bend) {
  slope.setZero(), bend.setZero();
  const int piece = sections.list[index].piece;
  const bool before = index > 0 && sections.list[index - 1].piece == piece,
             after = index + 1 < sections.list.size() && sections.list[index + 1].piece == piece;
  const double h = kSectionLength_m;
  const Correction& here = corrections[index];
  const auto same = [&](std::size_t i) {
    return i < sections.list.size() && sections.list[i].piece == piece;
  };
  if (!before && after && same(index + 2)) {
    slope = (-3.0 * here + 4.0 * corrections[index + 1] - corrections[index + 2]) / (2.0 * h);
    bend = (here - 2.0 * corrections[index + 1] + corrections[index + 2]) / (h * h);
  } else if (before && !after && index > 1 && same(index - 2)) {
    slope = (3.0 * here - 4.0 * corrections[index - 1] + corrections[index - 2]) / (2.0 * h);
    bend = (here - 2.0 * corrections[index - 1] + corrections[index - 2]) / (h * h);
  } else if (before && after) {
    slope = (corrections[index + 1] - corrections[index - 1]) / (2.0 * h);
    bend = (corrections[index + 1] - 2.0 * here + corrections[index - 1]) / (h * h);
  } else if (after) {
    slope = (corrections[index + 1] - here) / h;
  } else if (before) {
    slope = (here - corrections[index - 1]) / h;
  }
}

/// Without a base the trajectory is all that says where the road lies, however well its passes and
/// sections fit one another: known at its beginning to what it drifts over 100 m, and from there on
/// it drifts. Pieces err each for itself, passes of one piece together.
void take_word_of_trajectory(const Sections& sections, const RoadFrame& frame,
                             const MapOptions& options, Drift& drift) {
  struct Piece {
    double driven_m = 0.0, count = 0.0;
  };
  std::vector<std::map<int, Piece>> pieces(drift.stretch.size());
  const auto stretch_of = [&](const Section& section) {
    return std::min(static_cast<std::size_t>(section.row * frame.u_step_m() / kStretch_m),
                    pieces.size() - 1);
  };
  double begin = 0.0;
  for (std::size_t s = 0; s < sections.list.size(); ++s) {
    const int piece = sections.list[s].piece;
    if (s == 0 || sections.list[s - 1].piece != piece) begin = sections.centre_m[s];
    Piece& here = pieces[stretch_of(sections.list[s])][piece];
    here.driven_m += sections.centre_m[s] - begin, here.count += 1.0;
  }
  std::vector<double> times(pieces.size(), 0.0);  // the variance over that of 100 m
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    double all = 0.0;
    for (const auto& [piece, here] : pieces[k]) all += here.count;
    for (const auto& [piece, here] : pieces[k])
      times[k] +=
          here.count * here.count / (all * all) * (1.0 + here.driven_m / here.count / 100.0);
  }
  for (std::size_t k = 1; k < times.size(); ++k)  // seen from beside it
    if (times[k] == 0.0) times[k] = times[k - 1];
  for (std::size_t k = times.size() - std::min<std::size_t>(1, times.size()); k-- > 0;)
    if (times[k] == 0.0) times[k] = times[k + 1];
  const double place2 = options.drift_m_per_100m * options.drift_m_per_100m,
               turn2 = options.drift_rad_per_100m * options.drift_rad_per_100m;
  for (std::size_t k = 0; k < times.size(); ++k) {
    StretchDeviation& stretch = drift.stretch[k];
    for (double* variance : {&stretch.var_height, &stretch.var_along, &stretch.var_across})
      *variance = std::max(*variance, times[k] * place2);
    stretch.var_slope = std::max(stretch.var_slope, times[k] * turn2);
  }
  for (std::size_t s = 0; s < sections.list.size(); ++s)
    for (int k = 0; k < 6; ++k)
      drift.stddev[s][k] =
          std::max(drift.stddev[s][k],
                   std::sqrt(times[stretch_of(sections.list[s])] * (k < 3 ? place2 : turn2)));
}

/// Scales for the next step of a round: wide at first, then as what was seen scatters.
JointScales scales_by(const JointFacts& facts, JointScales scales, int round,
                      const MapOptions& options) {
  const double own = std::clamp(facts.base_mad_m, kLeastBaseStddev_m, options.base_stddev_m);
  const double wanted = round < kSchedule ? kBaseScales_m[round] : 0.0;
  scales.base_m = std::max(3.0 * own, wanted);
  scales.base_stddev_m = scales.base_m / 3.0;
  const double own_node = std::clamp(facts.node_mad_m, 2e-4, 0.5 * options.base_stddev_m),
               own_slope = std::clamp(facts.node_slope_mad, 2e-5, 0.002);
  scales.node_m = std::max(3.0 * own_node, round > 0 ? wanted : 1.0);
  scales.node_slope = std::max(3.0 * own_slope, round > 0 ? 0.3 * wanted : 0.3);
  scales.node_stddev_m = scales.node_m / 3.0, scales.node_slope_stddev = scales.node_slope / 3.0;
  scales.view_m = std::max({4.0 * facts.view_mad_m, wanted, 0.001});
  if (round > 0) scales.view_factor = std::clamp(facts.view_mad * facts.view_mad, 0.05, 100.0);
  return scales;
}

/// What the base's cells are seen to be off by holds the views' own noise, which the equations
/// count once more: variances that they assume over those that are seen.
double assumed_over_seen(const JointFacts& facts, const JointScales& scales,
                         const MapOptions& options) {
  if (!options.trust_base) return 1.0;
  const double seen_m2 = scales.base_stddev_m * scales.base_stddev_m * scales.base_together,
               noise_m2 = scales.view_factor * scales.view_together * facts.cell_noise_m *
                          facts.cell_noise_m;
  return std::min(1.0 + noise_m2 / seen_m2, kMostAssumed);
}

/// How much comes together: a part of the way from the old to the new, as factors.
JointScales nearer_together(const JointScales& old, JointScales scales, double part) {
  scales.base_together =
      old.base_together * std::pow(scales.base_together / old.base_together, part);
  scales.view_together =
      old.view_together * std::pow(scales.view_together / old.view_together, part);
  return scales;
}

/// Goes only a part of the way from the last corrections to the new ones.
void step_back(const std::vector<Correction>& last, std::vector<Correction>& now) {
  for (std::size_t i = 0; i < now.size(); ++i)
    now[i] = last[i] + kStepWithoutBase * (now[i] - last[i]);
}

/// How far the poses of a section moved in a round.
struct Move {
  double aside_m = 0.0, height_m = 0.0, turn_rad = 0.0;
};

/// The largest of all sections with data. `apart_from_common`: nothing holds what all poses have in
/// common, it may go on moving.
Move largest_move(const Sections& sections, const std::vector<Correction>& last,
                  const std::vector<Correction>& now, bool apart_from_common) {
  Correction common = Correction::Zero();
  if (apart_from_common) {
    for (std::size_t i = 0; i < now.size(); ++i) common += now[i] - last[i];
    common /= static_cast<double>(now.size());
  }
  Move move;
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (!sections.list[i].has_data()) continue;
    const Correction change = now[i] - last[i] - common;
    move.aside_m = std::max(move.aside_m, change.head<2>().norm());
    move.height_m = std::max(move.height_m, std::abs(change[2]));
    move.turn_rad = std::max({move.turn_rad, std::abs(change[3]), std::abs(change[4])});
  }
  return move;
}

/// Sections of a registered cloud share no ground: a roll of theirs and a cross slope that the base
/// lacks look alike, and by a twentieth a round the one goes on taking from the other.
bool is_still(const Move& move, bool registered, const MapOptions& options) {
  if (options.trust_base)
    return move.aside_m < kStillAside_m && move.height_m < 2e-4 &&
           move.turn_rad < (registered ? 1e-4 : 2e-5);
  return move.height_m < std::max(2e-4, kMovesWithoutBase * options.drift_m_per_100m) &&
         move.turn_rad < std::max(2e-5, kMovesWithoutBase * options.drift_rad_per_100m);
}

/// What is left between points, base and passes.
void report_fit(const JointProblem& problem, const JointFacts& facts, const JointScales& scales,
                MapReport& report) {
  report.rms_after_m = facts.residual_m, report.pass_rms_after_m = facts.between_passes_m;
  report.inlier_share = facts.believed;
  report.base_tilt = problem.common_slope(),
  report.base_tilt_stddev = problem.common_slope_stddev(), report.base_crown = problem.crown();
  report.base_stddev_m = scales.base_stddev_m, report.base_together = scales.base_together;
  report.view_stddev_factor = std::sqrt(scales.view_factor),
  report.view_together = scales.view_together;
}

/// The drift along the way: all that was taken out of the poses, `before` too.
void report_stations(const Sections& sections, const RoadFrame& frame,
                     const std::vector<Correction>& before, const Drift& drift,
                     const JointProblem& problem, MapReport& report) {
  report.drift.clear(), report.sections = 0;
  for (std::size_t i = 0; i < sections.list.size(); ++i) {
    const Section& section = sections.list[i];
    if (!section.has_data()) continue;
    ++report.sections;
    report.passes = std::max(report.passes, static_cast<std::size_t>(section.pass) + 1);
    DriftStation station;
    station.piece = section.piece, station.pass = section.pass;
    station.driven_m = sections.centre_m[i],
    station.u_m = frame.u_begin_m() + section.row * frame.u_step_m();
    for (std::size_t k = 0; k < 6; ++k) {
      const auto e = static_cast<Eigen::Index>(k);
      station.correction[k] = before[i][e] + drift.correction[i][e],
      station.stddev[k] = drift.stddev[i][e];
    }
    station.base_believed = problem.believed_share(i);
    report.drift.push_back(station);
  }
}

/// Typical deviations of the poses, and which directions the data hardly fixes.
void report_deviations(const Sections& sections, const Drift& drift, const MapOptions& options,
                       MapReport& report) {
  const char* const names[] = {"x", "y", "z", "roll", "pitch", "yaw"};
  for (std::size_t k = 0; k < 6; ++k) {
    std::vector<double> deviations;
    for (std::size_t i = 0; i < sections.list.size(); ++i)
      if (sections.list[i].has_data())
        deviations.push_back(drift.stddev[i][static_cast<Eigen::Index>(k)]);
    report.typical_stddev[k] = base::median_or(0.0, deviations);
    if (k < 3 && !options.trust_base) continue;  // the trajectory's word, and stated as such
    if (report.typical_stddev[k] > (k < 2 ? 0.05 : k == 2 ? 0.02 : 0.005))
      report.unfixed.push_back(names[k]);
  }
}

/// An estimate, and of a first one the share of the cells whose base is then believed.
struct Estimate {
  Drift drift;
  double believed = 0.0;
};

/// `hold_aside`: until most of the schedule is through poses lie beside the road where they are
/// said to.
Estimate estimate(const Sections& sections, const RoadFrame& frame, const MapOptions& options,
                  const std::vector<Correction>& before, MapReport& report,
                  std::optional<double> base_tilt, bool hold_aside) {
  const bool again = !before.empty();
  const bool registered = !sections.list.empty() && sections.list.front().ahead.isZero();
  Estimate out;
  Drift& drift = out.drift;
  drift.correction.assign(sections.list.size(), Correction::Zero());
  JointProblem problem(sections, frame, options, before);
  if (base_tilt) problem.refine_at(*base_tilt);
  JointScales scales;
  const double tilt = options.base_stddev_m / (kRoad_m / std::sqrt(12.0));
  double measured = 1.0;
  report.converged = false;
  // The first estimate need not be settled: a correction that bends within a section is only nearly
  // taken out of its cells.
  const int begin = again ? kSchedule - 2 : 0;
  int end = !again ? kSchedule + 1 : options.trust_base ? kDriftRounds : kRoundsWithoutBase;
  double done = 0.0;  // rounds, and parts of them
  problem.on_progress([&](double of_step) {
    const double rounds = end - begin;
    if (options.progress) options.progress("drift", std::min(1.0, (done + 0.5 * of_step) / rounds));
  });
  for (int round = begin; round < end && !report.converged; ++round) {
    problem.hold_aside(hold_aside && round + 1 < kSchedule ? kHeldAside_m : kAnywhere_m);
    problem.linearise(drift.correction);
    const std::vector<Correction> last = drift.correction;
    for (int step = 0; step < 2; ++step) {
      const bool before_all = !again && round == 0 && step == 0;
      const JointFacts facts = problem.facts(drift.correction, scales, before_all);
      if (before_all)
        report.rms_before_m = facts.residual_m, report.pass_rms_before_m = facts.between_passes_m;
      scales = scales_by(facts, scales, round, options);
      scales.common_slope = problem.is_fine() ? 3.0 * kTilted * tilt : 1.0;
      scales.common_slope_stddev = problem.is_fine() ? scales.common_slope / 3.0 : 1e-6;
      if (round >= kSchedule) {
        const JointScales old = scales;
        problem.measure_together(drift.correction, scales);
        // Without a base they follow every small move of the whole: a mean of what was measured.
        if (!options.trust_base)
          scales = nearer_together(old, scales, std::max(0.15, 1.0 / ++measured));
      }
      drift.correction = problem.solve(drift.correction, scales);
      done += 0.5;
      if (!options.trust_base) problem.hold_as_a_whole(drift.correction);
    }
    if (!options.trust_base && round > kSchedule) step_back(last, drift.correction);
    const Move move = largest_move(sections, last, drift.correction, !options.trust_base);
    ++report.iterations;
    report.last_move_m = move.height_m;
    const bool fine = problem.is_fine() || !options.trust_base || !again;
    const double nearly_m = round > kSchedule ? kNearlyMeasured_m : kNearly_m;
    if (again && !fine && round >= kSchedule && move.height_m < nearly_m)
      problem.refine(), end = std::max(end, round + kRoundsRefined);
    report.converged = fine && round > (options.trust_base ? kSchedule : kLeastWithoutBase) &&
                       is_still(move, registered, options);
  }
  if (!again) {
    scales.base_m = kBaseScales_m[kSchedule - 1];
    out.believed = problem.facts(drift.correction, scales, false).believed;
    return out;
  }
  const JointFacts facts = problem.facts(drift.correction, scales, true);
  problem.deviations(tilt, assumed_over_seen(facts, scales, options), scales, drift);
  if (!options.trust_base && before.size() == sections.list.size() &&
      !sections.list.front().ahead.isZero())
    take_word_of_trajectory(sections, frame, options, drift);
  report_fit(problem, facts, scales, report);
  report_stations(sections, frame, before, drift, problem, report);
  report_deviations(sections, drift, options, report);
  return out;
}

/// How far all poses are moved aside on average.
double moved_aside_m(const Sections& sections, const Drift& drift) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double count = 0.0;
  for (std::size_t s = 0; s < drift.correction.size(); ++s)
    if (sections.list[s].has_data()) sum += drift.correction[s].head<2>(), count += 1.0;
  return count > 0.0 ? sum.norm() / count : 0.0;
}

}  // namespace

Correction correction_at(const Sections& sections, const std::vector<Correction>& corrections,
                         double driven_m, int piece) {
  const auto k = static_cast<std::size_t>(
      std::upper_bound(sections.centre_m.begin(), sections.centre_m.end(), driven_m) -
      sections.centre_m.begin());
  std::size_t a = k == 0 ? 0 : k - 1, b = std::min(k, sections.list.size() - 1);
  if (sections.list[a].piece != piece) a = b;
  if (sections.list[b].piece != piece) b = a;
  Correction slope_a, slope_b, bend;
  shape_at(sections, corrections, a, slope_a, bend);
  const double h = sections.centre_m[b] - sections.centre_m[a],
               on = driven_m - sections.centre_m[a];
  if (!(h > 0.0)) return corrections[a] + on * slope_a + 0.5 * on * on * bend;
  shape_at(sections, corrections, b, slope_b, bend);
  const double t = on / h;
  return corrections[a] * (1.0 - t) * (1.0 - t) * (1.0 + 2.0 * t) +
         corrections[b] * t * t * (3.0 - 2.0 * t) +
         h * (slope_a * t * (1.0 - t) * (1.0 - t) - slope_b * t * t * (1.0 - t));
}

Mover::Mover(const Sections& sections, const std::vector<Correction>& corrections,
             std::size_t index)
    : section_(sections.list[index]), here_(corrections[index]) {
  shape_at(sections, corrections, index, slope_, bend_);
  turn_ = rotation_of(here_, section_.axes);
  // Each point turns about where it was seen from, and the axes of roll and pitch turn with the
  // car.
  const Eigen::Vector3d& round = section_.turning_1pm;
  path_bend_ = round.cross(section_.ahead);
  pivot_slope_ = section_.ahead - turn_ * section_.ahead;
  pivot_bend_ = path_bend_ - turn_ * path_bend_;
  const Eigen::Vector3d turn = section_.axes * here_.tail<3>(),
                        slope = section_.axes * slope_.tail<3>();
  turn_slope_ = slope + round.cross(turn);
  turn_bend_ =
      section_.axes * bend_.tail<3>() + 2.0 * round.cross(slope) + round.cross(round.cross(turn));
}

Eigen::Vector3d Mover::operator()(const SectionCell& cell) const {
  const Eigen::Vector3d local(static_cast<double>(cell.x_m), static_cast<double>(cell.y_m),
                              static_cast<double>(cell.z_m));
  const Eigen::Vector3d turned = turn_ * local;
  const auto on = static_cast<double>(cell.driven_m);
  const double half = 0.5 * static_cast<double>(cell.driven2_m2);
  return section_.position_m + here_.head<3>() + turned + on * pivot_slope_ + half * pivot_bend_ +
         on * slope_.head<3>() + half * bend_.head<3>() +
         (on * turn_slope_ + half * turn_bend_)
             .cross(turned - on * section_.ahead - half * path_bend_);
}

Drift estimate_drift(const Sections& sections, const RoadFrame& frame, const MapOptions& options,
                     const std::vector<Correction>& before, MapReport& report,
                     std::optional<double> base_tilt) {
  Estimate free = estimate(sections, frame, options, before, report, base_tilt, false);
  if (!before.empty() || !options.trust_base || moved_aside_m(sections, free.drift) < kMovedAside_m)
    return std::move(free.drift);
  MapOptions quiet = options;
  quiet.progress = {};
  Estimate held = estimate(sections, frame, quiet, before, report, base_tilt, true);
  return std::move((held.believed > free.believed ? held : free).drift);
}

}  // namespace cloud
