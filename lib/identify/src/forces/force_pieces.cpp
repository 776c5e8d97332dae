#include "force_pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "vehicle/replay.h"

namespace identify {
namespace {

using Index = Eigen::Index;
using vehicle::kWheels;
constexpr double kPiece_s = 8.0;   // rows that are smoothed at once
constexpr double kLead_s = 1.0;    // before them, to settle
constexpr double kTail_s = 0.3;    // behind them
constexpr double kSettle_s = 0.5;  // of a stretch that has nothing before it
// Steps of the replay, at most: with 2 ms it ran away on a kerb of the demo circuit.
constexpr double kReplayStep_s = 0.001;
// A replayed car this much faster or slower than the recorded one tells no temperatures.
constexpr double kAstray_mps = 5.0;
constexpr double kLeastRolling = 5e-4;  // deviation of rolling radii from stretch to stretch, share

std::vector<double> filled(const recording::Recording& recording, const std::string& channel) {
  const std::vector<double>* const values = recording.table.find(channel);
  if (values == nullptr) return {};
  std::vector<double> out = recording::fill_gaps(*recording.table.find("time_s"), *values);
  if (!out.empty() && std::isnan(out.front())) out.clear();
  return out;
}

/// Rows between gaps in which the car drives.
std::vector<recording::Stretch> driven(const Work& work, std::size_t& slow) {
  std::vector<recording::Stretch> out;
  for (const recording::Stretch& s : work.recording.stretches) {
    std::size_t begin = s.begin;
    for (std::size_t k = s.begin; k <= s.end; ++k) {
      if (k < s.end && work.vx_mps[k] > work.options.least_mps) continue;
      if (k > begin) out.push_back({begin, k});
      if (k < s.end) ++slow;
      begin = k + 1;
    }
  }
  return out;
}

CarPoint begin_of(const Work& work, std::size_t row, vehicle::RoadCursors& cursors) {
  vehicle::StartOptions start;
  start.x_m = work.x_m[row];
  start.y_m = work.y_m[row];
  start.yaw_rad = work.yaw_rad[row];
  start.speed_mps = work.vx_mps[row];
  start.gear = std::max(1, work.channels.rows[row].driven.next_gear);
  start.fuel_kg = work.options.fuel_kg;
  start.tyre_k = work.options.tyre_k;
  start.disc_k = work.options.disc_k;
  CarPoint out = work.motion.begin(start, cursors);
  if (!work.vy_mps.empty()) out.state[vehicle::kVy] = work.vy_mps[row];
  if (!work.yaw_rate_radps.empty()) out.state[vehicle::kYawRate] = work.yaw_rate_radps[row];
  for (const auto& [state, values] : work.kept)
    if (std::isfinite(values[row])) out.state[state] = values[row];
  for (const Reading& m : work.channels.rows[row].measured) {
    const Sensor& s = work.channels.sensors[m.sensor];
    if (!s.seen && s.place >= kPlaceSteer) out.at(s.place) = m.value;
  }
  for (std::size_t i = kPlaceSteerOffset; i < kPlaces; ++i)
    out.at(i) = work.mean[static_cast<Index>(i)];
  for (std::size_t i = kPlaceParts; i < kChangingPlaces; ++i) out.at(i) = out.at(rest_of(i));
  return out;
}

/// The states that no sensor corrects, by a replay of what was recorded.
void replay_kept(const vehicle::Car<double>& car, const vehicle::Road& road, Work& work) {
  vehicle::ReplayOptions options;
  options.fuel_kg = work.options.fuel_kg;
  options.tyre_k = work.options.tyre_k;
  options.disc_k = work.options.disc_k;
  options.step.step_s = std::min(kReplayStep_s, work.options.step_s);
  options.progress = work.options.progress;
  const vehicle::ReplayResult r = vehicle::replay(car, road, work.recording, options);
  const std::vector<double>& time = *work.recording.table.find("time_s");
  const std::vector<double>& sim_time = *r.telemetry.find("time_s");
  const std::vector<double>& sim_vx = *r.telemetry.find("vx_mps");
  for (std::size_t i = 0; i < vehicle::kStateSize; ++i) {
    if (!vehicle::kStates[i].kept) continue;
    const std::vector<double>* const values = r.telemetry.find(vehicle::kStates[i].channel);
    if (values == nullptr) continue;
    std::vector<double> rows(time.size(), kNaN);
    for (std::size_t k = 0, s = 0; k < time.size(); ++k) {
      while (s < sim_time.size() && sim_time[s] < time[k] - 1e-9) ++s;
      if (s < sim_time.size() && std::abs(sim_time[s] - time[k]) < 1e-9 &&
          std::abs(sim_vx[s] - work.vx_mps[k]) < kAstray_mps)
        rows[k] = (*values)[s];
    }
    rows = recording::fill_gaps(time, rows);
    if (std::isfinite(rows.front())) work.kept.emplace_back(i, std::move(rows));
    // The core of a disc is no channel: it begins as its surface is.
  }
}

/// A noise, or several that are one, and how boldly its estimate moves.
struct LearntNoise {
  std::size_t place = 0, count = 1;
  double power = 2.0, last = 0.0;
};

/// By how much more than their deviations say the pieces differ in what they tell of a place, as a
/// factor on the variance of their mean (R. T. Birge, 1932). What the car's laws do not have counts
/// as noise from row to row, yet goes on through a turn, or all of a piece.
double scatter(const NoiseSums& sums, std::size_t place) {
  if (sums.stretches < 2) return 1.0;
  const double about =
      sums.part_squares[place] - sums.part[place] * sums.part[place] / sums.part_weight[place];
  return std::max(1.0, about / static_cast<double>(sums.stretches - 1));
}

/// Moves what stays as it is to what all pieces and, once, the vehicle file say.
void move_constants(Work& work, const NoiseSums& sums) {
  for (std::size_t i = kPlaceSteerOffset; i < kPlaces; ++i) {
    if (!(sums.part_weight[i] > 0.0)) continue;
    const auto at = static_cast<Index>(i);
    const double stated =
        work.stated_sd[at] > 0.0 ? 1.0 / (work.stated_sd[at] * work.stated_sd[at]) : 0.0;
    const double differ = scatter(sums, i), told = sums.part_weight[i] / differ;
    work.mean[at] = (work.mean[at] * told + sums.part[i] / differ) / (told + stated);
    if (i >= kPlaceRest) work.mean[at] = std::clamp(work.mean[at], -kMostOff, kMostOff);
    const double mean_sd = 1.0 / std::sqrt(told + stated);
    if (i == kPlaceSteerOffset) work.begin_sd[at] = mean_sd;
    if (i == kPlaceRolling || i == kPlaceRolling + 1)  // that of a piece
      work.begin_sd[at] =
          std::max(kLeastRolling, mean_sd * std::sqrt(static_cast<double>(sums.stretches)));
  }
}

/// Moves noises as the smoothed pieces say. Expectation maximisation is slow where a log says
/// little: while it keeps its direction, its steps grow.
void move_noises(Work& work, const NoiseSums& sums, std::vector<LearntNoise>& learnt) {
  for (LearntNoise& l : learnt) {
    double came_in = 0.0, assumed = 0.0;
    for (std::size_t i = l.place; i < l.place + l.count; ++i) {
      came_in += sums.came_in[i];
      assumed += sums.assumed[i];
    }
    if (!(assumed > 0.0) || !(came_in > 0.0)) continue;
    const double way = std::log(came_in / assumed);
    if (l.last != 0.0) l.power = std::clamp(l.power * (way * l.last > 0.0 ? 1.7 : 0.5), 1.0, 10.0);
    l.last = way;
    double factor = std::exp(std::clamp(l.power * way, -2.0, 2.0));
    const auto at = static_cast<Index>(l.place);
    if (l.place >= kPlaceParts) {
      const double variance = work.begin_sd[at] * work.begin_sd[at];
      factor = std::clamp(factor * variance, 1e-5, 0.25) / variance;
      work.begin_sd[at] *= std::sqrt(factor);
    }
    for (SmootherRow& row : work.channels.rows)
      row.noise.segment(at, static_cast<Index>(l.count)) *= factor;
  }
  move_constants(work, sums);
  for (std::size_t i = 0; i < work.channels.sensors.size() && i < sums.count.size(); ++i) {
    Sensor& s = work.channels.sensors[i];
    const bool feet = !s.seen && s.place >= kPlaceThrottle && s.place < kPlaceParts;
    if (feet || sums.count[i] < 50) continue;
    const double left = std::sqrt(sums.measured[i] / static_cast<double>(sums.count[i]));
    s.deviation = std::max(0.5 * s.own_deviation, left);
  }
}

/// Throws base::Error where the log is of another road or in another frame.
void require_on_road(const vehicle::Road& road, const Work& work) {
  const std::size_t rows = work.x_m.size(), every = std::max<std::size_t>(1, rows / 1000);
  std::size_t seen = 0, beside = 0;
  vehicle::RoadCursors cursors;
  for (std::size_t k = 0; k < rows; k += every) {
    ++seen;
    if (!road.at(work.x_m[k], work.y_m[k], kNaN, 0, cursors).on_road) ++beside;
  }
  if (2 * beside > seen)
    throw base::Error(fmt::format(
        "{} of {} places of the recording lie beside the road, the first row at x = {:.1f} m, y = "
        "{:.1f} m: is it the road of this log, and are x_m and y_m in its frame? A mapping turns "
        "and shifts them",
        beside, seen, work.x_m.front(), work.y_m.front()));
}

}  // namespace

Work make_work(const CarMotion& motion, const vehicle::Car<double>& car, const vehicle::Road& road,
               const recording::Recording& recording, const ForcesOptions& options) {
  Work work{motion,
            recording,
            options,
            read_force_channels(recording, car),
            begin_deviations(options.prior),
            begin_deviations(options.prior),
            PlaceVector::Zero(),
            false,
            filled(recording, "x_m"),
            filled(recording, "y_m"),
            filled(recording, "yaw_rad"),
            filled(recording, "vx_mps"),
            filled(recording, "vy_mps"),
            filled(recording, "yaw_rate_radps"),
            {}};
  require_on_road(road, work);
  replay_kept(car, road, work);
  return work;
}

std::vector<Piece> pieces_of(const Work& work, Forces& out) {
  const auto rows_in = [&](double s) {
    return static_cast<std::size_t>(std::ceil(s / work.recording.step_s));
  };
  std::vector<Piece> pieces;
  for (const recording::Stretch& s : driven(work, out.slow)) {
    const std::size_t settle = rows_in(kSettle_s);
    out.unsettled += std::min(settle, s.end - s.begin);
    if (s.end - s.begin < 2 * settle) {
      out.unsettled += s.end - s.begin - std::min(settle, s.end - s.begin);
      continue;
    }
    for (std::size_t begin = s.begin + settle; begin < s.end;) {
      std::size_t end = std::min(s.end, begin + rows_in(kPiece_s));
      if (s.end - end < rows_in(0.5 * kPiece_s)) end = s.end;
      const std::size_t lead = rows_in(kLead_s);
      pieces.push_back({begin > s.begin + lead ? begin - lead : s.begin, begin, end,
                        std::min(s.end, end + rows_in(kTail_s))});
      begin = end;
    }
  }
  return pieces;
}

Smoothed smooth_piece(const Work& work, const Piece& piece, double most_wild) {
  const std::vector<SmootherRow>& all = work.channels.rows;
  const auto at = [&](std::size_t row) { return all.begin() + static_cast<std::ptrdiff_t>(row); };
  const std::vector<SmootherRow> rows(at(piece.from), at(piece.to));
  vehicle::RoadCursors cursors;
  const SmootherBegin begin{begin_of(work, piece.from, cursors), work.begin_sd, most_wild,
                            work.steer_offset_known};
  return smooth(work.motion, work.channels.sensors, rows, begin, cursors);
}

void learn_noises(Work& work, const std::vector<Piece>& pieces) {
  const auto wanted =
      static_cast<std::size_t>(std::max(1.0, std::round(work.options.noise_sample_s / kPiece_s)));
  std::vector<Piece> some;
  const std::size_t count = std::min(wanted, pieces.size());
  for (std::size_t i = 0; i < count; ++i)
    some.push_back(pieces[(2 * i + 1) * pieces.size() / (2 * count)]);
  std::vector<LearntNoise> learnt{{kPlaceSteerRate},
                                  {place_of(vehicle::kZ)},
                                  {place_of(vehicle::kVx), 2},
                                  {place_of(vehicle::kVz)},
                                  {place_of(vehicle::kRollRate), 3},
                                  {place_of(vehicle::kTravelRate), kWheels},
                                  {place_of(vehicle::kSpin), 2}};
  for (std::size_t i = kPlaceParts; i < kChangingPlaces; ++i) learnt.push_back({i});
  for (int round = 0; round < work.options.noise_rounds; ++round) {
    if (work.options.progress)
      work.options.progress("noises", static_cast<double>(round) / work.options.noise_rounds);
    std::vector<NoiseSums> done(some.size());
    base::parallel_for(some.size(), 1, work.options.threads, [&](std::size_t b, std::size_t e) {
      for (std::size_t i = b; i < e; ++i) done[i] = smooth_piece(work, some[i], 1.0).sums;
    });
    NoiseSums sums;
    for (const NoiseSums& s : done) sums.add(s);
    move_noises(work, sums, learnt);
  }
  // From here on the pieces are not asked again for what they told together.
  work.steer_offset_known = work.options.noise_rounds > 0;
}

}  // namespace identify
