#include "wheel_heights.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "not_known.h"
#include "recording/recording.h"
#include "vehicle/road.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
constexpr double kHalf_s = 0.4;
constexpr std::array<const char*, 4> kWheel{"fl", "fr", "rl", "rr"};

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
  std::vector<std::string> wanted{"az_mps2", "roll_rate_radps", "pitch_rate_radps", "x_m",
                                  "y_m",     "yaw_rad"};
  for (const char* wheel : kWheel)
    wanted.push_back(fmt::format("suspension_{}_m", wheel)),
        wanted.push_back(fmt::format("fz_{}_n", wheel));
  for (const std::string& name : wanted)
    if (recording.table.find(name) == nullptr)
      return fmt::format(
          "needs {}: az, roll and pitch rate, suspension travel and wheel loads of all wheels",
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

/// The car's motion over one stretch without gaps.
struct Motion {
  std::vector<double> z, roll, pitch, x, y, yaw;
};

/// Heights under one wheel: measured, in the file, and as it is seen through the strip.
struct Seen {
  std::vector<double> measured, file, strip, u, v;
};

Seen seen_by(const Eyes& eyes, const Motion& motion, std::size_t wheel,
             const std::vector<double>& travel, const std::vector<double>& load,
             vehicle::RoadCursors& cursors) {
  const vehicle::Vehicle& car = eyes.car;
  const crg::Surface& surface = eyes.surface;
  const auto& [z, roll, pitch, x, y, yaw] = motion;
  const std::size_t n = z.size();
  const double a = car.parameters[P::chassis_cog_behind_front_m],
               b = car.parameters[P::chassis_wheelbase_m] - a;
  Seen out{std::vector<double>(n), std::vector<double>(n), std::vector<double>(n),
           std::vector<double>(n, kNaN), std::vector<double>(n, kNaN)};
  auto& [measured, file, seen, u, v] = out;
  const std::size_t axle = wheel / 2;
  const double lx = axle == 0 ? a : -b,
               ly = (wheel % 2 == 0 ? 0.5 : -0.5) * car.parameters.axle(axle, P::front_track_m);
  const double stiffness = car.files.tyre[axle].vertical_stiffness_npm;
  vehicle::RoadTracker tracker(surface);
  for (std::size_t i = 0; i < n; ++i) {
    const double c = std::cos(yaw[i]), s = std::sin(yaw[i]), wx = x[i] + lx * c - ly * s,
                 wy = y[i] + lx * s + ly * c;
    const crg::UV at = tracker.at(wx, wy);
    const double file_m = surface.z_at_uv(at.u_m, at.v_m);
    u[i] = at.u_m - surface.grid().u_begin_m;
    v[i] = at.v_m;
    measured[i] = z[i] - lx * pitch[i] + ly * roll[i] + travel[i] + load[i] / stiffness;
    file[i] = std::isfinite(file_m) ? file_m : (i > 0 ? file[i - 1] : 0.0);
    seen[i] = file[i];
    const auto cell = static_cast<std::size_t>(std::max(0.0, u[i]) / kWaveCell_m);
    if (eyes.strip && cell < eyes.only_cells.size() && eyes.only_cells[cell]) {
      const vehicle::RoadPoint point = eyes.road.under_strip(wx, wy, file[i], yaw[i], eyes.shape,
                                                             eyes.cams[axle], wheel, cursors);
      if (std::isfinite(point.z_m)) seen[i] = point.z_m;
    }
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
    const auto once = [&](const char* name) { return integrated(part(name), recording.step_s); };
    const Motion motion{integrated(once("az_mps2"), recording.step_s),
                        once("roll_rate_radps"),
                        once("pitch_rate_radps"),
                        part("x_m"),
                        part("y_m"),
                        part("yaw_rad")};
    for (std::size_t wheel = 0; wheel < 4; ++wheel) {
      const auto [measured, file, seen, u, v] =
          seen_by(eyes, motion, wheel, part(fmt::format("suspension_{}_m", kWheel[wheel])),
                  part(fmt::format("fz_{}_n", kWheel[wheel])), cursors);
      const std::vector<double> m = without_slow(measured, half), f = without_slow(file, half),
                                p = strip ? without_slow(seen, half) : f;
      for (std::size_t i = half; i + half < n; ++i) {
        const auto k =
            static_cast<std::size_t>((time[stretch.begin + i] - time.front()) / Signals::kStep_s);
        if (k >= log.signals->n || !std::isfinite(log.signals->u_m[k]) || !std::isfinite(u[i]))
          continue;
        const int lap = first_lap + log.signals->lap[k];
        out.push_back({u[i], v[i], m[i], f[i], p[i], measured[i] - file[i],
                       static_cast<std::size_t>(lap) * 4 + wheel, lap % 2});
      }
    }
  }
  return "";
}

}  // namespace explain
