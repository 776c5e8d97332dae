#include "identify/drive_windows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/statistics.h"
#include "drive_columns.h"
#include "drive_doubts.h"
#include "longitudinal.h"
#include "vehicle/road.h"

namespace identify {
namespace {

using vehicle::kWheels;
using P = vehicle::Parameter;
constexpr double kNaN = DriveWindow::kNaN;

/// Whether a vertical acceleration says what presses a car on the road: there in half of the rows,
/// with gravity in it.
bool tells_weight(Column az, double gravity_mps2) {
  if (az == nullptr) return false;
  double sum = 0.0;
  std::size_t rows = 0;
  for (const double v : *az) {
    if (!std::isfinite(v)) continue;
    sum += v;
    ++rows;
  }
  return 2 * rows > az->size() && sum > 0.5 * gravity_mps2 * static_cast<double>(rows);
}

/// Slopes of the plane through the road under the four wheels, along the car and to its left.
struct Slopes {
  double along = kNaN, left = kNaN;
  bool kerb = false;  ///< a wheel stands more than a centimetre beside the plane of the others
};

std::vector<Slopes> road_slopes(const vehicle::Car<double>& car, const crg::Surface& surface,
                                const DriveColumns& c, std::size_t rows) {
  const vehicle::Road road(surface);
  vehicle::RoadCursors cursors;
  std::vector<Slopes> out(rows);
  double near_m = kNaN;
  for (std::size_t k = 0; k < rows; ++k) {
    if (c.z != nullptr) near_m = (*c.z)[k];
    const double x = (*c.x)[k], y = (*c.y)[k], cos = std::cos((*c.yaw)[k]),
                 sin = std::sin((*c.yaw)[k]);
    if (!std::isfinite(x + y + cos)) continue;
    std::array<double, kWheels> z{};
    bool there = true;
    for (std::size_t i = 0; i < kWheels; ++i) {
      const auto& wheel = car.wheel_m[i];
      const vehicle::RoadPoint p = road.at(x + cos * wheel.x - sin * wheel.y,
                                           y + sin * wheel.x + cos * wheel.y, near_m, i, cursors);
      z[i] = p.z_m;
      there = there && p.on_road;
    }
    near_m = 0.25 * (z[0] + z[1] + z[2] + z[3]);
    if (!there) continue;
    const double track = car.wheel_m[0].y - car.wheel_m[1].y + car.wheel_m[2].y - car.wheel_m[3].y;
    out[k] = {(z[0] + z[1] - z[2] - z[3]) / (2.0 * (car.wheel_m[0].x - car.wheel_m[2].x)),
              (z[0] - z[1] + z[2] - z[3]) / track, std::abs(z[0] - z[1] - z[2] + z[3]) > 0.01};
  }
  return out;
}

/// Gravity and the speed over a road whose slopes change, away from the road: the acceleration's
/// parts along the road cancel.
double road_normal(const DriveColumns& c, const std::vector<Slopes>& slopes, std::size_t k,
                   const recording::Stretch& stretch, double gravity) {
  const std::size_t a = k > stretch.begin ? k - 1 : k, b = k + 1 < stretch.end ? k + 1 : k;
  const double dt = (*c.time)[b] - (*c.time)[a], vx = (*c.vx)[k],
               vy = c.vy == nullptr ? 0.0 : (*c.vy)[k];
  const double rate = c.rate != nullptr
                          ? (*c.rate)[k]
                          : std::remainder((*c.yaw)[b] - (*c.yaw)[a], 6.283185307179586) / dt;
  const Slopes& s = slopes[k];
  const double along = (slopes[b].along - slopes[a].along) / dt - rate * s.left;
  const double left = (slopes[b].left - slopes[a].left) / dt + rate * s.along;
  return (gravity + vx * along + vy * left) / std::sqrt(1.0 + s.along * s.along + s.left * s.left);
}

/// The mean of what was there.
struct Mean {
  double* of;  ///< where it goes
  double sum = 0.0;
  std::size_t rows = 0;
  void add(double v) {
    if (!std::isfinite(v)) return;
    sum += v;
    ++rows;
  }
  void put() const { *of = rows == 0 ? kNaN : sum / static_cast<double>(rows); }
};

/// How far each wheel's place on the body has come down from where it stands without fuel: travel
/// and what the tyre's radius gives way. Without loads the springs' own say what the tyre carries.
std::array<double, kWheels> sink_of(const vehicle::Car<double>& car, const DriveWindow& w,
                                    bool loads, bool travels) {
  const auto& p = car.parameters;
  std::array<double, kWheels> out{};
  if (!loads && !travels) return out;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::size_t a = vehicle::axle_of(i), other = i ^ 1u;
    const double spring = p.axle(a, P::front_spring_npm),
                 bar = vehicle::value_of(car.terms[vehicle::Term::anti_roll_bar]) *
                       p.axle(a, P::front_anti_roll_npm),
                 stands = car.static_load_n[a];
    double travel = w.travel_m[i], more = w.load_n[i] - stands;
    if (!loads) more = spring * travel + bar * (travel - w.travel_m[other]);
    if (!travels) {
      const double both = 0.5 * (w.load_n[i] + w.load_n[other]) - stands,
                   apart = 0.5 * (w.load_n[i] - w.load_n[other]);
      travel = both / std::max(1e3, spring) + apart / std::max(1e3, spring + 2.0 * bar);
    }
    out[i] = travel + car.static_radius_m[a] -
             radii_under(car, a, std::max(0.0, stands + more), w.vx_mps).loaded_m;
  }
  return out;
}

/// The same where neither was recorded: by the loads that the vehicle file would expect.
std::array<double, kWheels> stated_sink(const vehicle::Car<double>& car, const DriveWindow& w) {
  DriveWindow loaded = w;
  for (std::size_t i = 0; i < kWheels; ++i)
    loaded.load_n[i] = load_of(car, w, i, car.parameters[P::chassis_mass_kg]);
  return sink_of(car, loaded, true, false);
}

/// From axes that tilt with the body to the road's.
void level(const vehicle::Car<double>& car, bool normal_too, DriveWindow& w) {
  const auto& s = w.sink_m;
  const double dive = 0.5 * (s[0] + s[1] - s[2] - s[3]) / (car.wheel_m[0].x - car.wheel_m[2].x);
  const double lean = (s[1] - s[0] + s[3] - s[2]) /
                      (car.wheel_m[0].y - car.wheel_m[1].y + car.wheel_m[2].y - car.wheel_m[3].y);
  const double along = w.along_mps2, left = w.left_mps2;
  const double left_or_none = std::isfinite(left) ? left : 0.0;
  if (normal_too) w.normal_mps2 += lean * left_or_none - dive * along;
  w.along_mps2 = along + dive * w.normal_mps2;
  w.left_mps2 = left - lean * w.normal_mps2;
}

class Cutter {
 public:
  Cutter(const vehicle::Car<double>& car, const crg::Surface* road,
         const recording::Recording& recording, const DriveWindowsOptions& options)
      : car_(car), options_(options), c_(columns_of(recording.table)), recording_(recording) {
    const auto need = [&](bool there, const char* what) {
      if (!there)
        throw base::Error(fmt::format(
            "the recording has no channel {}: wanted for this; name its column in a mapping",
            what));
    };
    need(c_.vx != nullptr, "vx_mps");
    if (road != nullptr) {
      need(c_.x != nullptr && c_.y != nullptr, "x_m and y_m");
      need(c_.yaw != nullptr, "yaw_rad");
      slopes_ = road_slopes(car, *road, c_, recording.table.rows());
    }
    if (!tells_weight(c_.az, car.parameters[P::environment_gravity_mps2])) c_.az = nullptr;
    out_.normal = road != nullptr    ? NormalFrom::kRoad
                  : c_.az != nullptr ? NormalFrom::kMeasured
                                     : NormalFrom::kPlane;
    out_.loads = c_.load[0] != nullptr;
    out_.travels = c_.travel[0] != nullptr;
    out_.accelerations = c_.ax != nullptr;
    out_.lateral_speed = c_.vy != nullptr;
    out_.rows = recording.table.rows();
    out_.begin_s = c_.time->front();
    out_.end_s = c_.time->back();
  }

  DriveWindows cut() {
    const auto length =
        static_cast<std::size_t>(std::max(1.0, std::round(options_.seconds / recording_.step_s)));
    for (const recording::Stretch& stretch : recording_.stretches)
      for (std::size_t begin = stretch.begin; begin + length <= stretch.end; begin += length)
        add_window(begin, begin + length, stretch);
    out_.doubts = drive_doubts(car_, out_, !options_.body_axes || out_.loads || out_.travels);
    return std::move(out_);
  }

 private:
  bool counts(std::size_t k, const recording::Stretch& stretch) {
    double all = at(c_.vx, k);
    for (const Column c : {c_.ax, c_.vy})
      if (c != nullptr) all += (*c)[k];
    if (out_.normal == NormalFrom::kMeasured) all += (*c_.az)[k];
    for (std::size_t i = 0; i < kWheels; ++i) {
      if (out_.loads) all += (*c_.load[i])[k];
      if (out_.travels) all += (*c_.travel[i])[k];
    }
    if (!std::isfinite(all)) return false;
    if ((*c_.vx)[k] < options_.least_mps) {
      ++out_.slow;
      return false;
    }
    if (out_.normal != NormalFrom::kRoad) return true;
    const double g = car_.parameters[P::environment_gravity_mps2];
    if (std::isfinite(road_normal(c_, slopes_, k, stretch, g))) return true;
    ++out_.off_road;
    return false;
  }

  bool near_kerb(std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end && !slopes_.empty(); ++k)
      if (slopes_[k].kerb) {
        out_.on_kerbs += end - begin;
        return true;
      }
    return false;
  }

  /// Puts the means of a row and those before it together; `next` counts a row's channels.
  struct Row {
    std::vector<Mean>& means;
    std::size_t next = 0;
    void add(double& of, double v) {
      if (next == means.size()) means.push_back({&of});
      means[next++].add(v);
    }
  };

  void add_row(std::size_t k, const recording::Stretch& stretch, Row row, DriveWindow& w,
               double& sway) const {
    const double g = car_.parameters[P::environment_gravity_mps2];
    const double c = std::cos(options_.imu_yaw_rad), s = std::sin(options_.imu_yaw_rad);
    const double v = at(c_.vx, k), side = c_.vy == nullptr ? 0.0 : at(c_.vy, k),
                 turning = at(c_.rate, k), turns = std::isfinite(turning) ? turning : 0.0,
                 ax = at(c_.ax, k), ay = at(c_.ay, k);
    row.add(w.vx_mps, v);
    row.add(w.vy_mps, side);
    row.add(w.air_mps2, v * v + side * side);
    row.add(sway, turns * side);
    row.add(w.along_mps2,
            c * ax - s * (std::isfinite(ay) ? ay : 0.0) + options_.imu_ahead_m * turns * turns);
    row.add(w.left_mps2, s * ax + c * ay);
    row.add(w.normal_mps2, out_.normal == NormalFrom::kRoad
                               ? road_normal(c_, slopes_, k, stretch, g)
                           : out_.normal == NormalFrom::kMeasured ? at(c_.az, k)
                                                                  : g);
    row.add(w.slope, slopes_.empty() ? 0.0 : slopes_[k].along);
    row.add(w.yaw_rate_radps, turning);
    row.add(w.throttle, at(c_.throttle, k));
    for (std::size_t i = 0; i < kWheels; ++i) {
      row.add(w.load_n[i], at(c_.load[i], k));
      row.add(w.travel_m[i], at(c_.travel[i], k));
      row.add(w.wheel_radps[i], at(c_.wheel[i], k));
      row.add(w.brake_pa[i], at(c_.brake[i], k));
      row.add(w.disc_k[i], at(c_.disc[i], k));
    }
    if (at(c_.gear, k) != w.gear) w.gear = kNaN;
  }

  void add_window(std::size_t begin, std::size_t end, const recording::Stretch& stretch) {
    if (near_kerb(begin, end)) return;
    const std::size_t middle = (begin + end) / 2;
    DriveWindow w;
    w.gear = at(c_.gear, begin);
    w.gear_recorded = c_.gear != nullptr;
    w.middle_gear = at(c_.gear, middle);
    std::vector<Mean> means;
    Pairs speeds;
    double sway = 0.0;
    std::size_t rows = 0;
    for (std::size_t k = begin; k < end; ++k) {
      if (!counts(k, stretch)) continue;
      ++rows;
      add_row(k, stretch, {means}, w, sway);
      speeds.add(at(c_.time, k) - at(c_.time, begin), at(c_.vx, k));
    }
    if (5 * rows < 3 * (end - begin)) {
      out_.short_of_rows += rows;
      return;
    }
    for (const Mean& mean : means) mean.put();
    // Medians of a few rows at each end: wheel speeds have spikes.
    const std::size_t few = std::max<std::size_t>(1, (end - begin) / 8);
    const auto middle_of = [&](Column column, std::size_t from) {
      std::vector<double> values;
      for (std::size_t k = from; k < from + few; ++k)
        if (std::isfinite(at(column, k))) values.push_back(at(column, k));
      return base::median_or(kNaN, values);
    };
    const double span_s = middle_of(c_.time, end - few) - middle_of(c_.time, begin);
    for (std::size_t i = 0; i < kWheels; ++i)
      w.spin_up_radps2[i] =
          (middle_of(c_.wheel[i], end - few) - middle_of(c_.wheel[i], begin)) / span_s;
    w.begin_row = begin;
    w.end_row = end;
    w.time_s = 0.5 * (at(c_.time, begin) + at(c_.time, end - 1));
    w.x_m = at(c_.x, middle);
    w.y_m = at(c_.y, middle);
    const double speeding = speeds.slope();
    w.speeding_mps2 =
        (std::isfinite(speeding) ? speeding : 0.0) - sway +
        car_.parameters[P::environment_gravity_mps2] * w.slope / std::sqrt(1.0 + w.slope * w.slope);
    w.sink_m = sink_of(car_, w, out_.loads, out_.travels);
    if (!out_.loads && !out_.travels) {
      w.sink_m = stated_sink(car_, w);  // for ride heights; too vague to turn axes by
    } else if (options_.body_axes) {
      level(car_, out_.normal == NormalFrom::kMeasured, w);
    }
    w.block = blocks_.of(w.x_m, w.y_m, w.time_s - out_.begin_s);
    out_.blocks = blocks_.known.size();
    out_.windows.push_back(w);
  }

  const vehicle::Car<double>& car_;
  const DriveWindowsOptions& options_;
  DriveColumns c_;
  const recording::Recording& recording_;
  std::vector<Slopes> slopes_;
  Blocks blocks_{options_.block_m, options_.block_s};
  DriveWindows out_;
};

}  // namespace

DriveWindows drive_windows(const vehicle::Car<double>& car, const crg::Surface* road,
                           const recording::Recording& recording,
                           const DriveWindowsOptions& options) {
  return with_wheelbase(Cutter(car, road, recording, options).cut(), recording);
}

std::string normal_words(const DriveWindows& drive, bool body_axes) {
  switch (drive.normal) {
    case NormalFrom::kRoad:
      return "what presses the car on the road is gravity and the speed over the road's slopes and "
             "curves, by the CRG file";
    case NormalFrom::kMeasured:
      return fmt::format("what presses the car on the road is az_mps2{}",
                         body_axes ? ", put upright by the body's tilt" : "");
    case NormalFrom::kPlane:
      break;
  }
  return "the road is taken as a level plane: no --road, no az_mps2 with gravity in it; banks, "
         "grades, dips and crests stand in the results";
}

}  // namespace identify
