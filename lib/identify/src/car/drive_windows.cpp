#include "identify/drive_windows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/error.h"
#include "drive_doubts.h"
#include "longitudinal.h"
#include "vehicle/road.h"
#include "wheel_names.h"
#include "window_fit.h"

namespace identify {
namespace {

using vehicle::kWheels;
using P = vehicle::Parameter;
constexpr double kNaN = DriveWindow::kNaN;

/// The columns that windows are made of; nullptr: not recorded.
struct Columns {
  Column time, x, y, z, yaw, vx, vy, rate, ax, ay, az, throttle, gear;
  std::array<Column, kWheels> load, travel, wheel, brake, disc;
};

/// All four, or none.
std::array<Column, kWheels> four(const recording::Table& table, const char* before,
                                 const char* after) {
  std::array<Column, kWheels> out{};
  for (std::size_t i = 0; i < kWheels; ++i)
    out[i] = table.find(fmt::format("{}{}{}", before, kWheelNames[i], after));
  if (std::count(out.begin(), out.end(), nullptr) > 0) out.fill(nullptr);
  return out;
}

Columns columns_of(const recording::Table& table) {
  Columns c{};
  const std::pair<Column Columns::*, const char*> names[] = {
      {&Columns::time, "time_s"}, {&Columns::x, "x_m"},       {&Columns::y, "y_m"},
      {&Columns::z, "z_m"},       {&Columns::yaw, "yaw_rad"}, {&Columns::vx, "vx_mps"},
      {&Columns::vy, "vy_mps"},   {&Columns::ax, "ax_mps2"},  {&Columns::rate, "yaw_rate_radps"},
      {&Columns::ay, "ay_mps2"},  {&Columns::az, "az_mps2"},  {&Columns::throttle, "throttle"},
      {&Columns::gear, "gear"}};
  for (const auto& [column, name] : names) c.*column = table.find(name);
  c.load = four(table, "fz_", "_n");
  c.travel = four(table, "suspension_", "_m");
  c.wheel = four(table, "wheel_", "_radps");
  c.brake = four(table, "brake_", "_pa");
  c.disc = four(table, "brake_disc_", "_k");
  if (c.brake[0] == nullptr) c.brake.fill(table.find("brake_pa"));
  return c;
}

double at(Column column, std::size_t row) { return column == nullptr ? kNaN : (*column)[row]; }

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
                                const Columns& c, std::size_t rows) {
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
double road_normal(const Columns& c, const std::vector<Slopes>& slopes, std::size_t k,
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

/// Sums of one window's rows.
struct Sum {
  double value = 0.0;
  std::size_t rows = 0;
  void add(double v) {
    if (!std::isfinite(v)) return;
    value += v;
    ++rows;
  }
  double mean() const { return rows == 0 ? kNaN : value / static_cast<double>(rows); }
};

/// Loaded radius of a rolling tyre: it grows and stiffens with speed.
double radius_under(const vehicle::TyreCoefficients& tyre, double load_n, double pressure_pa,
                    double v_mps) {
  const double r0 = tyre.unloaded_radius_m, speed = std::abs(v_mps) / tyre.nominal_speed_mps;
  return r0 * (tyre.qre0 + tyre.qv1 * speed * speed) -
         vehicle::static_deflection(tyre, load_n / (1.0 + tyre.qv2 * speed), pressure_pa);
}

/// Slope of the straight line through points (time, value).
double rise_of(const std::vector<std::pair<double, double>>& points) {
  double t = 0.0, v = 0.0, tt = 0.0, tv = 0.0;
  for (const auto& [at_s, value] : points) {
    t += at_s / static_cast<double>(points.size());
    v += value / static_cast<double>(points.size());
  }
  for (const auto& [at_s, value] : points) {
    tt += (at_s - t) * (at_s - t);
    tv += (at_s - t) * (value - v);
  }
  return tt > 0.0 ? tv / tt : 0.0;
}

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
             radius_under(car.files->tyre[a], std::max(0.0, stands + more),
                          p.axle(a, P::front_tyre_pressure_pa), w.vx_mps);
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

  void add_window(std::size_t begin, std::size_t end, const recording::Stretch& stretch) {
    DriveWindow w;
    Sum vx, vy, air, along, left, normal, rate, throttle, slope, sway;
    std::array<Sum, kWheels> load, travel, wheel, brake, disc;
    std::vector<std::pair<double, double>> speeds;
    std::size_t rows = 0;
    const double g = car_.parameters[P::environment_gravity_mps2];
    const double c = std::cos(options_.imu_yaw_rad), s = std::sin(options_.imu_yaw_rad);
    w.gear = at(c_.gear, begin);
    w.gear_recorded = c_.gear != nullptr;
    w.middle_gear = at(c_.gear, (begin + end) / 2);
    if (near_kerb(begin, end)) return;
    for (std::size_t k = begin; k < end; ++k) {
      if (!counts(k, stretch)) continue;
      ++rows;
      const double v = at(c_.vx, k), side = c_.vy == nullptr ? 0.0 : at(c_.vy, k);
      vx.add(v);
      vy.add(side);
      air.add(v * v + side * side);
      speeds.emplace_back(at(c_.time, k), v);
      const double turning = at(c_.rate, k),
                   centre =
                       options_.imu_ahead_m * (std::isfinite(turning) ? turning * turning : 0.0);
      const double ax = at(c_.ax, k), ay = at(c_.ay, k), ay_or_none = std::isfinite(ay) ? ay : 0.0;
      sway.add(std::isfinite(turning) ? turning * side : 0.0);
      along.add(c * ax - s * ay_or_none + centre);
      left.add(s * ax + c * ay);
      normal.add(out_.normal == NormalFrom::kRoad       ? road_normal(c_, slopes_, k, stretch, g)
                 : out_.normal == NormalFrom::kMeasured ? at(c_.az, k)
                                                        : g);
      slope.add(slopes_.empty() ? 0.0 : slopes_[k].along);
      rate.add(turning);
      throttle.add(at(c_.throttle, k));
      if (at(c_.gear, k) != w.gear) w.gear = kNaN;
      for (std::size_t i = 0; i < kWheels; ++i) {
        load[i].add(at(c_.load[i], k));
        travel[i].add(at(c_.travel[i], k));
        wheel[i].add(at(c_.wheel[i], k));
        brake[i].add(at(c_.brake[i], k));
        disc[i].add(at(c_.disc[i], k));
      }
    }
    if (5 * rows < 3 * (end - begin)) {
      out_.short_of_rows += rows;
      return;
    }
    w.begin_row = begin;
    w.end_row = end;
    w.time_s = 0.5 * (at(c_.time, begin) + at(c_.time, end - 1));
    w.x_m = at(c_.x, (begin + end) / 2);
    w.y_m = at(c_.y, (begin + end) / 2);
    w.vx_mps = vx.mean();
    w.vy_mps = vy.mean();
    w.air_mps2 = air.mean();
    w.slope = slope.mean();
    w.along_mps2 = along.mean();
    w.speeding_mps2 =
        rise_of(speeds) - sway.mean() + g * w.slope / std::sqrt(1.0 + w.slope * w.slope);
    w.left_mps2 = left.mean();
    w.normal_mps2 = normal.mean();
    w.yaw_rate_radps = rate.mean();
    w.throttle = throttle.mean();
    for (std::size_t i = 0; i < kWheels; ++i) {
      w.load_n[i] = load[i].mean();
      w.travel_m[i] = travel[i].mean();
      w.wheel_radps[i] = wheel[i].mean();
      w.brake_pa[i] = brake[i].mean();
      w.disc_k[i] = disc[i].mean();
    }
    w.sink_m = sink_of(car_, w, out_.loads, out_.travels);
    if (!out_.loads && !out_.travels) {
      w.sink_m = stated_sink(car_, w);  // for ride heights; too vague to turn axes by
    } else if (options_.body_axes) {
      level(car_, out_.normal == NormalFrom::kMeasured, w);
    }
    w.block = block_of(w);
    out_.windows.push_back(w);
  }

  std::size_t block_of(const DriveWindow& w) {
    const std::pair<long, long> cell =
        std::isfinite(w.x_m + w.y_m)
            ? std::pair{std::lround(w.x_m / options_.block_m),
                        std::lround(w.y_m / options_.block_m)}
            : std::pair{std::lround((w.time_s - out_.begin_s) / options_.block_s), -1L};
    const auto [found, fresh] = blocks_.emplace(cell, blocks_.size());
    out_.blocks = blocks_.size();
    return found->second;
  }

  const vehicle::Car<double>& car_;
  const DriveWindowsOptions& options_;
  Columns c_;
  const recording::Recording& recording_;
  std::vector<Slopes> slopes_;
  std::map<std::pair<long, long>, std::size_t> blocks_;
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
