#include "wheel_heights.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "not_known.h"
#include "recording/channels.h"
#include "recording/recording.h"
#include "vehicle/road.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
constexpr double kHalf_s = 0.4;

/// x without its local parabola over +-half samples; empty at the ends.
std::vector<double> without_slow(const std::vector<double>& x, std::size_t half) {
  std::vector<double> out(x.size(), kNaN);
  double m2 = 0, m4 = 0;
  const double n = 2.0 * static_cast<double>(half) + 1;
  const auto scale = static_cast<double>(half);
  for (std::size_t k = 0; k <= 2 * half; ++k) {
    const double d = (static_cast<double>(k) - scale) / scale;
    m2 += d * d;
    m4 += d * d * d * d;
  }
  for (std::size_t i = half; i + half < x.size(); ++i) {
    double s0 = 0, s2 = 0;
    for (std::size_t k = 0; k <= 2 * half; ++k) {
      const double d = (static_cast<double>(k) - scale) / scale, value = x[i - half + k] - x[i];
      s0 += value;
      s2 += value * d * d;
    }
    out[i] = -(m4 * s0 - m2 * s2) / (n * m4 - m2 * m2);
  }
  return out;
}

std::vector<double> integrated(const std::vector<double>& x, double step_s) {
  double mean = 0;
  for (const double v : x) mean += v / static_cast<double>(x.size());
  std::vector<double> sum(x.size(), 0.0);
  for (std::size_t i = 1; i < x.size(); ++i)
    sum[i] = sum[i - 1] + 0.5 * (x[i] + x[i - 1] - 2 * mean) * step_s;
  return sum;
}

/// Why a recording does not say how high its wheels are; empty: it does.
std::string lacking(const recording::Recording& recording) {
  std::vector<std::string> wanted{"ax_mps2",          "ay_mps2", "az_mps2", "roll_rate_radps",
                                  "pitch_rate_radps", "x_m",     "y_m",     "yaw_rad"};
  for (const char* wheel : recording::kWheelNames)
    wanted.push_back(fmt::format("suspension_{}_m", wheel)),
        wanted.push_back(fmt::format("fz_{}_n", wheel));
  for (const std::string& name : wanted)
    if (recording.table.find(name) == nullptr)
      return fmt::format(
          "needs {}: accelerations, roll and pitch rate, suspension travel and wheel loads of all "
          "wheels",
          name);
  if (!(recording.step_s <= 1.0 / 79))
    return fmt::format("needs 80 samples a second or more, the log has {:.0f}",
                       1 / recording.step_s);
  return "";
}

/// What sees the road as the wheels of a car do.
struct Eyes {
  const crg::Surface& surface;
  const vehicle::Vehicle& car;
  bool strip;
  const std::vector<bool>& only_cells;
  vehicle::Road road;
  std::array<vehicle::Cams, 2> cams;
  vehicle::StripShape shape;
};

Eyes eyes_of(const crg::Surface& surface, const vehicle::Vehicle& car, bool strip,
             const std::vector<bool>& only_cells) {
  Eyes eyes{surface, car, strip, only_cells, vehicle::Road(surface), {}, {}};
  for (std::size_t axle = 0; strip && axle < 2; ++axle) {
    const auto made = vehicle::make_car(car.files, car.parameters, car.terms,
                                        vehicle::Contact::kStrip, eyes.shape);
    eyes.cams[axle] = made.cams[axle];
  }
  return eyes;
}

/// One wheel over one stretch without gaps: what it measures, where it is, and the road there in
/// the file and as it is seen through the strip.
struct Wheel {
  std::size_t axle;
  double ahead_m, left_m, stiffness_npm;
  std::vector<double> travel_m, load_n, measured_m, file_m, strip_m, u_m, v_m;
  std::vector<bool> in_air;  ///< or on the face of a kerb

  /// Of the body's corner over the road.
  double above_road_m(std::size_t i) const { return -travel_m[i] - load_n[i] / stiffness_npm; }
};

constexpr double kInAir = 0.05;  ///< share of the mean load
/// On a face that is so much steeper than the road for a metre to either side, a tyre's load points
/// sideways.
constexpr double kFace = 0.3;

Wheel wheel_of(const vehicle::Vehicle& car, std::size_t wheel, std::vector<double> travel_m,
               std::vector<double> load_n) {
  const std::size_t axle = wheel / 2, n = travel_m.size();
  const double a = car.parameters[P::chassis_cog_behind_front_m],
               b = car.parameters[P::chassis_wheelbase_m] - a;
  const std::vector<double> none(n, kNaN);
  double mean_n = 0.0;
  for (const double load : load_n) mean_n += load / static_cast<double>(n);
  Wheel out{axle,
            axle == 0 ? a : -b,
            (wheel % 2 == 0 ? 0.5 : -0.5) * car.parameters.axle(axle, P::front_track_m),
            car.files.tyre[axle].vertical_stiffness_npm,
            std::move(travel_m),
            std::move(load_n),
            none,
            none,
            none,
            none,
            none,
            std::vector<bool>(n)};
  for (std::size_t i = 0; i < n; ++i) out.in_air[i] = out.load_n[i] < kInAir * mean_n;
  return out;
}

bool is_face(const crg::Surface& surface, const crg::UV& at) {
  const auto slope = [&](double reach_m) {
    return (surface.z_at_uv(at.u_m, at.v_m + reach_m) - surface.z_at_uv(at.u_m, at.v_m - reach_m)) /
           (2 * reach_m);
  };
  return std::abs(slope(0.05) - slope(1.0)) > kFace;  // not where there is no road to either side
}

/// The road of the file under one wheel.
void look_at_file(const Eyes& eyes, std::size_t number, const std::vector<double>& x_m,
                  const std::vector<double>& y_m, const std::vector<double>& yaw,
                  vehicle::RoadCursors& cursors, Wheel& wheel) {
  const crg::Surface& surface = eyes.surface;
  vehicle::RoadTracker tracker(surface);
  for (std::size_t i = 0; i < x_m.size(); ++i) {
    const double c = std::cos(yaw[i]), s = std::sin(yaw[i]),
                 wx = x_m[i] + wheel.ahead_m * c - wheel.left_m * s,
                 wy = y_m[i] + wheel.ahead_m * s + wheel.left_m * c;
    const crg::UV at = tracker.at(wx, wy);
    const double file_m = surface.z_at_uv(at.u_m, at.v_m);
    wheel.u_m[i] = at.u_m - surface.grid().u_begin_m;
    wheel.v_m[i] = at.v_m;
    wheel.file_m[i] = std::isfinite(file_m) ? file_m : (i > 0 ? wheel.file_m[i - 1] : 0.0);
    wheel.strip_m[i] = wheel.file_m[i];
    if (is_face(surface, at)) wheel.in_air[i] = true;
    const auto cell = static_cast<std::size_t>(std::max(0.0, wheel.u_m[i]) / kWaveCell_m);
    if (eyes.strip && cell < eyes.only_cells.size() && eyes.only_cells[cell]) {
      const vehicle::RoadPoint point = eyes.road.under_strip(
          wx, wy, wheel.file_m[i], {c, s}, eyes.shape, eyes.cams[wheel.axle], number, cursors);
      if (std::isfinite(point.z_m)) wheel.strip_m[i] = point.z_m;
    }
  }
}

/// While it is in the air its height says nothing of the road: between where it leaves the road and
/// where it comes down the difference to the file goes on evenly.
void stay_on_road(Wheel& wheel) {
  const std::size_t n = wheel.measured_m.size();
  const auto off_m = [&](std::size_t i) { return wheel.measured_m[i] - wheel.file_m[i]; };
  for (std::size_t i = 0; i < n; ++i) {
    if (!wheel.in_air[i]) continue;
    std::size_t end = i;
    while (end < n && wheel.in_air[end]) ++end;
    const double after_m = end < n ? off_m(end) : (i > 0 ? off_m(i - 1) : 0.0),
                 before_m = i > 0 ? off_m(i - 1) : after_m;
    for (std::size_t k = i; k < end; ++k)
      wheel.measured_m[k] =
          wheel.file_m[k] + before_m +
          (after_m - before_m) * static_cast<double>(k + 1 - i) / static_cast<double>(end + 1 - i);
    i = end;
  }
}

/// How the body leans: by the file's road under the wheels and what springs and tyres give way,
/// and by the rates while a wheel is in the air. Its rates are those of the angles (yaw, pitch,
/// roll in turn), free of what a leaning body turns by while it only yaws.
struct Attitude {
  std::vector<double> roll, pitch, roll_rate, pitch_rate;
};

Attitude attitude_of(const std::array<Wheel, 4>& wheels, const std::vector<double>& roll_rate,
                     const std::vector<double>& pitch_rate, const std::vector<double>& yaw,
                     double step_s) {
  const std::size_t n = roll_rate.size();
  Attitude out{std::vector<double>(n), std::vector<double>(n), std::vector<double>(n),
               std::vector<double>(n)};
  for (std::size_t i = 0; i < n; ++i) {
    std::array<double, 4> corner_m{};
    bool in_air = false;
    for (std::size_t k = 0; k < 4; ++k) {
      corner_m[k] = wheels[k].file_m[i] + wheels[k].above_road_m(i);
      in_air = in_air || wheels[k].in_air[i];
    }
    if (in_air && i > 0) {
      out.roll[i] = out.roll[i - 1] + out.roll_rate[i - 1] * step_s;
      out.pitch[i] = out.pitch[i - 1] + out.pitch_rate[i - 1] * step_s;
    } else {
      const auto between = [&](std::size_t from, std::size_t to, double apart_m) {
        return (corner_m[to] - corner_m[from]) / apart_m;
      };
      const double base_m = wheels[0].ahead_m - wheels[2].ahead_m;
      out.roll[i] = 0.5 * (between(1, 0, wheels[0].left_m - wheels[1].left_m) +
                           between(3, 2, wheels[2].left_m - wheels[3].left_m));
      out.pitch[i] = 0.5 * (between(0, 2, base_m) + between(1, 3, base_m));
    }
    const std::size_t before = i > 0 ? i - 1 : 0, next = std::min(i + 1, n - 1);
    const double yaw_rate =
                     (yaw[next] - yaw[before]) / (static_cast<double>(next - before) * step_s),
                 roll = out.roll[i], pitch = out.pitch[i];
    out.roll_rate[i] = roll_rate[i] + yaw_rate * std::sin(pitch);
    out.pitch_rate[i] =
        pitch_rate[i] / std::cos(roll) - yaw_rate * std::cos(pitch) * std::tan(roll);
  }
  return out;
}

/// What the accelerometers say of the vertical, body axes to the road's.
std::vector<double> vertical_mps2(const Attitude& body, const std::vector<double>& ax,
                                  const std::vector<double>& ay, const std::vector<double>& az) {
  std::vector<double> out(ax.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double roll = body.roll[i], pitch = body.pitch[i];
    out[i] = (az[i] * std::cos(roll) + ay[i] * std::sin(roll)) * std::cos(pitch) -
             ax[i] * std::sin(pitch);
  }
  return out;
}

}  // namespace

std::string wheel_heights(const RecordedLog& log, const Mapping& mapping,
                          const crg::Surface& surface, const vehicle::Vehicle& car, int first_lap,
                          bool strip, const std::vector<bool>& only_cells,
                          std::vector<WheelHeight>& out) {
  const recording::Recording recording =
      recording::make_recording(*log.table, log.signals->name, mapping);
  if (const std::string reason = lacking(recording); !reason.empty()) return reason;
  const std::vector<double>& time = *recording.table.find("time_s");
  const auto half = static_cast<std::size_t>(std::lround(kHalf_s / recording.step_s));
  const Eyes eyes = eyes_of(surface, car, strip, only_cells);
  vehicle::RoadCursors cursors{};
  for (const recording::Stretch& stretch : recording.stretches) {
    const std::size_t n = stretch.end - stretch.begin;
    if (n < 4 * half) continue;
    const auto part = [&](const std::string& name) {
      const std::vector<double> filled = recording::fill_gaps(time, *recording.table.find(name));
      return std::vector<double>(filled.begin() + static_cast<std::ptrdiff_t>(stretch.begin),
                                 filled.begin() + static_cast<std::ptrdiff_t>(stretch.end));
    };
    const double step_s = recording.step_s;
    const std::vector<double> x = part("x_m"), y = part("y_m"), yaw = part("yaw_rad");
    const auto wheel_at = [&](std::size_t k) {
      Wheel wheel =
          wheel_of(car, k, part(fmt::format("suspension_{}_m", recording::kWheelNames[k])),
                   part(fmt::format("fz_{}_n", recording::kWheelNames[k])));
      look_at_file(eyes, k, x, y, yaw, cursors, wheel);
      return wheel;
    };
    std::array<Wheel, 4> wheels{wheel_at(0), wheel_at(1), wheel_at(2), wheel_at(3)};
    const Attitude body =
        attitude_of(wheels, part("roll_rate_radps"), part("pitch_rate_radps"), yaw, step_s);
    const std::vector<double> up =
        vertical_mps2(body, part("ax_mps2"), part("ay_mps2"), part("az_mps2"));
    const std::vector<double> rise = integrated(integrated(up, step_s), step_s),
                              roll = integrated(body.roll_rate, step_s),
                              pitch = integrated(body.pitch_rate, step_s);
    for (std::size_t k = 0; k < 4; ++k) {
      Wheel& wheel = wheels[k];
      for (std::size_t i = 0; i < n; ++i)
        wheel.measured_m[i] =
            rise[i] - wheel.ahead_m * pitch[i] + wheel.left_m * roll[i] - wheel.above_road_m(i);
      stay_on_road(wheel);
      const std::vector<double> m = without_slow(wheel.measured_m, half),
                                f = without_slow(wheel.file_m, half),
                                p = strip ? without_slow(wheel.strip_m, half) : f;
      for (std::size_t i = half; i + half < n; ++i) {
        const auto at =
            static_cast<std::size_t>((time[stretch.begin + i] - time.front()) / Signals::kStep_s);
        if (at >= log.signals->n || !std::isfinite(log.signals->u_m[at]) ||
            !std::isfinite(wheel.u_m[i]) || wheel.in_air[i])
          continue;
        const int lap = first_lap + log.signals->lap[at];
        out.push_back({wheel.u_m[i], wheel.v_m[i], m[i], f[i], p[i],
                       wheel.measured_m[i] - wheel.file_m[i], static_cast<std::size_t>(lap) * 4 + k,
                       lap % 2});
      }
    }
  }
  return "";
}

}  // namespace explain
