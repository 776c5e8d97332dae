#include "identify/forces.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>

#include "base/error.h"
#include "base/parallel.h"
#include "drive_doubts.h"
#include "force_pieces.h"
#include "rolling_doubt.h"

namespace identify {
namespace {

using Index = Eigen::Index;
using vehicle::kWheels;
// A quarter of a second of which a quarter is further than four deviations from what was expected:
// the simulated car bounces over a kerb otherwise than the true one.
constexpr double kMostWild = 0.25;
constexpr double kFarFromNoise = 4.0;  // times its own noise, of which a channel is spoken
void make_room(Forces& out, const std::vector<double>& time) {
  const std::size_t n = time.size();
  out.time_s = time;
  const auto room = [&](Estimated& e) {
    e.value.assign(n, kNaN);
    e.sd.assign(n, kNaN);
  };
  out.u_m.assign(n, kNaN);
  out.v_m.assign(n, kNaN);
  for (WheelForces& w : out.wheel) {
    for (const auto& column : kWheelColumns) room(w.*column.of);
    w.vx_mps.assign(n, kNaN);
    w.tyre_k.assign(n, kNaN);
  }
  for (const auto& column : kAxleColumns)
    for (Estimated& e : out.*column.of) room(e);
  for (const auto& column : kCarColumns) room(out.*column.of);
}

/// `off`: how far the side force of each axle is from the tyre file's, as a share.
void write_row(Forces& out, std::size_t k, const SmoothedRow& row,
               const std::array<double, 2>& off) {
  const auto put = [&](Estimated& e, double value, double sd) {
    e.value[k] = value;
    e.sd[k] = sd;
  };
  for (std::size_t i = 0; i < kWheels; ++i) {
    WheelForces& w = out.wheel[i];
    for (std::size_t what = 0; what < std::size(kWheelColumns); ++what) {  // as SeenOfWheel
      const std::size_t place = seen_of(i, static_cast<SeenOfWheel>(what));
      put(w.*kWheelColumns[what].of, row.seen.value[place], row.seen_sd[place]);
    }
    w.vx_mps[k] = row.seen.wheel_vx_mps[i];
    w.tyre_k[k] = row.point.state[vehicle::kTyre + i];
  }
  for (std::size_t what = 0; what < std::size(kAxleColumns); ++what)
    for (std::size_t a = 0; a < 2; ++a)
      put((out.*kAxleColumns[what].of)[a], row.axle[a][what], row.axle_sd[a][what]);
  const auto state = [&](Estimated& e, std::size_t place) {
    put(e, row.point.at(place), row.point_sd[place]);
  };
  state(out.vx_mps, place_of(vehicle::kVx));
  state(out.vy_mps, place_of(vehicle::kVy));
  state(out.yaw_rate_radps, place_of(vehicle::kYawRate));
  state(out.steer_rad, kPlaceSteer);
  const double vx = row.point.state[vehicle::kVx], vy = row.point.state[vehicle::kVy];
  put(out.sideslip_rad, std::atan2(vy, vx),
      row.point_sd[place_of(vehicle::kVy)] / std::max(1.0, vx));
  // Which wheel of an axle holds how much of the side force is the tyre file's word: as far as that
  // is off for the axle, a quarter as far it may be off between the wheels.
  for (std::size_t a = 0; a < 2; ++a) {
    const double left = out.wheel[2 * a].fy_n.value[k], right = out.wheel[2 * a + 1].fy_n.value[k];
    const double both = std::abs(left) + std::abs(right);
    const double about = both > 0.0 ? 0.25 * off[a] * std::abs(left * right) / both : 0.0;
    for (std::size_t i = 2 * a; i < 2 * a + 2; ++i)
      out.wheel[i].fy_n.sd[k] = std::hypot(out.wheel[i].fy_n.sd[k], about);
  }
  if (!row.seen.on_road) ++out.off_road;
  ++out.rows;
}

constexpr double kRollingOff = 0.08;  // no tyre's rolling radius is stated this far off

/// The rows that a piece keeps. Where the car cannot follow, each half is tried by itself, down to
/// a second; rows without a value stay.
std::vector<std::optional<SmoothedRow>> keep(const Work& work, const Piece& piece,
                                             NoiseSums& sums) {
  const std::size_t count = piece.end - piece.begin;
  const Smoothed s = smooth_piece(work, piece, kMostWild);
  sums.add(s.sums);
  std::vector<std::optional<SmoothedRow>> out;
  if (!s.row.empty()) {
    const auto at = [&](std::size_t k) {
      return s.row.begin() + static_cast<std::ptrdiff_t>(k - piece.from);
    };
    out.assign(at(piece.begin), at(piece.end));
    return out;
  }
  if (static_cast<double>(count) * work.recording.step_s < 2.0) {
    out.resize(count);
    return out;
  }
  const std::size_t middle = piece.begin + count / 2, lead = piece.begin - piece.from,
                    tail = piece.to - piece.end;
  out = keep(work, {piece.from, piece.begin, middle, std::min(middle + tail, piece.to)}, sums);
  const std::size_t from = std::max(piece.from, middle - lead);
  const auto second = keep(work, {from, middle, piece.end, piece.to}, sums);
  out.insert(out.end(), second.begin(), second.end());
  return out;
}

/// Rolling radii by the tyre file, by wheel and row.
using Radii = std::array<std::vector<double>, kWheels>;

/// The rows that a piece kept.
void write_piece(Forces& out, const Piece& piece,
                 const std::vector<std::optional<SmoothedRow>>& kept,
                 const std::array<double, 2>& off, Radii& radius_m) {
  for (std::size_t k = 0; k < kept.size(); ++k) {
    if (!kept[k]) {
      ++out.lost;
      continue;
    }
    write_row(out, piece.begin + k, *kept[k], off);
    for (std::size_t w = 0; w < kWheels; ++w)
      radius_m[w][piece.begin + k] = kept[k]->seen.rolling_radius_m[w];
  }
}

/// Smooths every piece and writes its rows. A smoothed row is large: none is kept longer. Returns
/// what all pieces told together.
NoiseSums smooth_all(const Work& work, const std::vector<Piece>& pieces,
                     const std::array<double, 2>& off, Radii& radius_m, Forces& out) {
  std::mutex mutex;
  std::size_t finished = 0;
  std::vector<NoiseSums> told(pieces.size());
  base::parallel_for(pieces.size(), 1, work.options.threads, [&](std::size_t b, std::size_t e) {
    for (std::size_t i = b; i < e; ++i) {
      const auto kept = keep(work, pieces[i], told[i]);
      const std::lock_guard lock(mutex);
      write_piece(out, pieces[i], kept, off, radius_m);
      ++finished;
      if (work.options.progress)
        work.options.progress("forces",
                              static_cast<double>(finished) / static_cast<double>(pieces.size()));
    }
  });
  NoiseSums sums;
  for (const NoiseSums& one : told) sums.add(one);
  out.wild = sums.wild;
  return sums;
}

/// Steering, yaw rate and speed against the stated wheelbase.
void doubt_wheelbase(const vehicle::Car<double>& car, const vehicle::Road& road,
                     const recording::Recording& recording, const ForcesOptions& options,
                     Forces& out) {
  DriveWindowsOptions cut;
  cut.imu_ahead_m = options.imu_ahead_m;
  cut.imu_yaw_rad = options.imu_yaw_rad;
  const DriveWindows drive = drive_windows(car, road.surface(), recording, cut);
  if (wheelbase_off(car, drive) != 0.0)
    out.doubts.push_back(
        fmt::format("steering, yaw rate and speed say a wheelbase of {:.2f} m (standard deviation "
                    "{:.2g}) where {:.4g} are stated, or the steering has another ratio",
                    drive.wheelbase_m, drive.wheelbase_sd_m,
                    car.parameters[vehicle::Parameter::chassis_wheelbase_m]));
}

/// Yaw that follows the forces otherwise than the stated inertia lets it.
void doubt_yaw_inertia(const Work& work, const NoiseSums& sums, Forces& out) {
  constexpr double kInertiaOff = 0.3;  // what other equations of a car may make of it
  constexpr auto kYaw = Index{3};
  static_assert(kStated[kYaw].parameter == vehicle::Parameter::chassis_yaw_inertia_kgm2);
  Eigen::MatrixXd weight = sums.stated_weight;
  for (Index i = 0; i < weight.rows(); ++i) {
    const double sd = work.stated_sd[static_cast<Index>(kPlaceStated) + i];
    if (!(sd > 0.0)) {
      if (i == kYaw) return;  // certain
      weight(i, i) = 1.0;
    } else if (i != kYaw) {  // what the log says of it is asked, whatever the file says
      weight(i, i) += 1.0 / (sd * sd);
    }
  }
  const Eigen::MatrixXd covariance =
      weight.ldlt().solve(Eigen::MatrixXd::Identity(weight.rows(), weight.cols()));
  const double off = covariance.row(kYaw).dot(sums.stated),
               sd = std::sqrt(std::max(0.0, covariance(kYaw, kYaw)));
  if (std::abs(off) > kInertiaOff + 3.0 * sd)
    out.doubts.push_back(
        fmt::format("turning follows the forces as with {:.2f} times the stated yaw inertia "
                    "(standard deviation {:.2g}): another car, or yaw_rate_radps in another unit, "
                    "filtered or late",
                    1.0 + off, sd));
}

/// How far each axle's side force is from that of the tyre file with mean grip and stiffness.
std::array<double, 2> side_off(const Work& work) {
  std::array<double, 2> off{};
  for (std::size_t a = 0; a < 2; ++a)
    for (const std::size_t part : {kPlaceGrip + a, kPlaceCornering + a}) {
      off[a] = std::max(off[a], work.begin_sd[static_cast<Index>(part)]);
    }
  return off;
}

/// By how much the rolling radius of an axle differs, and whether that can be.
void describe_rolling(const Work& work, std::size_t axle, Forces& out) {
  const auto place = static_cast<Index>(kPlaceRolling + axle);
  const double faster = work.mean[place], radius = -faster / (1.0 + faster),
               sd = work.begin_sd[place];
  const std::string name =
      fmt::format("rolling radius of the {} tyres", axle == 0 ? "front" : "rear");
  out.parts.push_back({name, radius, sd});
  if (std::abs(radius) > kRollingOff)
    out.doubts.push_back(fmt::format(
        "{} would have to differ from the vehicle file by {:.1f} %: another car, or wheel speeds "
        "or vx_mps in other units",
        name, 100.0 * radius));
  else if (std::abs(radius) > 0.003)
    out.remarks.push_back(fmt::format(
        "{}: {:+.2f} % off the vehicle file's, by the wheels' speeds where they hardly slip; slip "
        "ratios are by the radius that was found",
        name, 100.0 * radius));
}

void describe_use(const Work& work, Forces& out) {
  out.remarks = work.channels.said;
  for (std::size_t i = kPlaceParts; i < kChangingPlaces; ++i)
    out.parts.push_back({kParts[i - kPlaceParts].name, work.mean[static_cast<Index>(rest_of(i))],
                         work.begin_sd[static_cast<Index>(i)]});
  for (std::size_t a = 0; a < 2; ++a) describe_rolling(work, a, out);
  for (std::size_t i = 0; i < kStated.size(); ++i)
    out.stated.push_back({kStated[i].name, work.begin_sd[static_cast<Index>(kPlaceStated + i)]});
  for (const Sensor& s : work.channels.sensors) {
    std::size_t rows = 0;
    for (const double v : *work.recording.table.find(s.channel)) rows += std::isfinite(v) ? 1 : 0;
    out.channels.push_back({s.channel, rows, s.deviation});
    out.measurements += rows;
  }
  for (const Sensor& s : work.channels.sensors)
    if (s.deviation > kFarFromNoise * s.own_deviation)
      out.doubts.push_back(fmt::format(
          "{} is off by {:.3g} from what the car of the vehicle file would have shown, where its "
          "own noise is {:.3g}: its scale, sign, delay or place, or that part of the car",
          s.channel, s.deviation, s.own_deviation));
  for (const PartUse& part : out.parts)
    if (std::abs(part.mean) >= kMostOff)
      out.doubts.push_back(
          fmt::format("{} would have to differ from the vehicle file by {:.0f} % or more: another "
                      "car, or a channel in other units",
                      part.part, 100.0 * part.mean));
  if (50 * out.wild > out.measurements)
    out.doubts.push_back(fmt::format(
        "{:.1f} % of the measurements are far from what the car does: car, road or mapping are not "
        "those of this log everywhere, and the intervals are too narrow",
        100.0 * static_cast<double>(out.wild) / static_cast<double>(out.measurements)));
  if (10 * out.lost > out.rows + out.lost)
    out.doubts.push_back(
        fmt::format("the simulated car could not follow {} of {} rows: see whether car, road and "
                    "the mapping's signs are those of this log (crgdrive replay shows it)",
                    out.lost, out.rows + out.lost));
}

void place_rows(const Work& work, const vehicle::Road& road, Forces& out) {
  std::optional<vehicle::RoadTracker> tracker;
  if (road.surface() != nullptr) tracker.emplace(*road.surface());
  for (std::size_t k = 0; k < out.time_s.size(); ++k) {
    const crg::UV place =
        tracker ? tracker->at(work.x_m[k], work.y_m[k]) : crg::UV{work.x_m[k], work.y_m[k]};
    out.u_m[k] = place.u_m;
    out.v_m[k] = place.v_m;
  }
}

/// The first that was recorded.
std::optional<double> recorded_fuel(const recording::Recording& recording) {
  if (const auto* const fuel = recording.table.find("fuel_kg"); fuel != nullptr)
    for (const double kg : *fuel)
      if (std::isfinite(kg)) return std::max(0.0, kg);
  return std::nullopt;
}

}  // namespace

Forces estimate_forces(const vehicle::Car<double>& car, const vehicle::Road& road,
                       const recording::Recording& recording, const ForcesOptions& asked) {
  ForcesOptions options = asked;
  const std::optional<double> fuel_kg = recorded_fuel(recording);
  options.fuel_kg = fuel_kg.value_or(asked.fuel_kg);
  const CarMotion motion(car, road, options.step_s, {options.imu_ahead_m, options.imu_yaw_rad});
  Work work = make_work(motion, car, road, recording, options);
  Forces out;
  out.dry_kg = car.parameters[vehicle::Parameter::chassis_mass_kg];
  out.fuel_kg = options.fuel_kg;
  out.fuel_recorded = fuel_kg.has_value();
  const std::vector<Piece> pieces = pieces_of(work, out);
  if (pieces.empty())
    throw base::Error(fmt::format(
        "no second of the recording without a gap in which the car is faster than {:g} m/s",
        options.least_mps));
  learn_noises(work, pieces);
  make_room(out, *recording.table.find("time_s"));
  Radii radius_m;
  for (auto& wheel : radius_m) wheel.assign(out.time_s.size(), kNaN);
  const NoiseSums sums = smooth_all(work, pieces, side_off(work), radius_m, out);
  if (out.rows == 0)
    throw base::Error(
        "the simulated car could not follow any piece of the recording: see whether car, road and "
        "the mapping's signs are those of this log (crgdrive replay shows it)");
  add_rolling_doubt(car, options.rolling_sd, radius_m, out);
  describe_use(work, out);
  doubt_wheelbase(car, road, recording, options, out);
  doubt_yaw_inertia(work, sums, out);
  place_rows(work, road, out);
  return out;
}

}  // namespace identify
