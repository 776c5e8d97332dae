#include "explain/signals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "plausible.h"
#include "vehicle/error.h"

namespace explain {
namespace {

using vehicle::Error;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct Samples {
  std::vector<double> t, x;
  std::string column;
};

/// Mapped values with their own clock; repeats and empty cells left out.
Samples samples_of(const vehicle::Table& table, const Mapping& mapping, const std::string& channel,
                   const std::vector<double>& time_s) {
  Samples out;
  for (const ColumnMapping& m : mapping.columns) {
    if (m.channel != channel) continue;
    const std::vector<double>* values = table.find(m.column);
    if (values == nullptr) continue;
    out.column = m.column;
    double last = kNaN, filtered_last = kNaN, t_last = 0;
    for (std::size_t i = 0; i < values->size(); ++i) {
      const double raw = (*values)[i];
      if (!std::isfinite(raw) || !std::isfinite(time_s[i])) continue;
      if (m.held && raw == last) continue;
      last = raw;
      double x = raw * m.scale + m.offset;
      if (m.low_pass_s > 0) {  // x + T dx/dt, taken in the middle of two samples
        const double now = x;
        if (std::isnan(filtered_last)) {
          filtered_last = now;
          t_last = time_s[i];
          continue;
        }
        const double dt = time_s[i] - t_last;
        if (!(dt > 0)) continue;
        x = 0.5 * (now + filtered_last) + m.low_pass_s * (now - filtered_last) / dt;
        out.t.push_back(0.5 * (time_s[i] + t_last) - m.delay_s);
        out.x.push_back(x);
        filtered_last = now;
        t_last = time_s[i];
        continue;
      }
      out.t.push_back(time_s[i] - m.delay_s);
      out.x.push_back(x);
    }
  }
  return out;
}

/// Value of a local quadratic with triangular weights, and its derivative. NaN where samples are few or lie
/// on one side.
void smooth(const Samples& s, double t0, std::size_t n, double half_s, std::vector<double>& x,
            std::vector<double>& dx) {
  x.assign(n, kNaN);
  dx.assign(n, kNaN);
  std::size_t first = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = t0 + Signals::kStep_s * static_cast<double>(i);
    while (first < s.t.size() && s.t[first] < t - half_s) ++first;
    double m[5] = {}, b[3] = {};
    std::size_t count = 0;
    double earliest = 1, latest = -1;
    for (std::size_t k = first; k < s.t.size() && s.t[k] <= t + half_s; ++k) {
      const double d = (s.t[k] - t) / half_s, w = 1.0 - std::abs(d) * 0.9;
      double power = w;
      for (double& sum : m) sum += power, power *= d;
      b[0] += w * s.x[k];
      b[1] += w * d * s.x[k];
      b[2] += w * d * d * s.x[k];
      earliest = std::min(earliest, d);
      latest = std::max(latest, d);
      ++count;
    }
    if (count < 4 || earliest > -0.2 || latest < 0.2) continue;
    // Solve [[m0 m1 m2][m1 m2 m3][m2 m3 m4]] c = b by Cramer's rule.
    const double det = m[0] * (m[2] * m[4] - m[3] * m[3]) - m[1] * (m[1] * m[4] - m[3] * m[2]) +
                       m[2] * (m[1] * m[3] - m[2] * m[2]);
    if (!(std::abs(det) > 1e-9)) continue;
    const double c0 = b[0] * (m[2] * m[4] - m[3] * m[3]) - m[1] * (b[1] * m[4] - m[3] * b[2]) +
                      m[2] * (b[1] * m[3] - m[2] * b[2]);
    x[i] = c0 / det;
  }
  // The derivative of what was smoothed, not the slope of the fit: a rate that is logged itself and
  // is smoothed the same way must agree with it at every frequency.
  for (std::size_t i = 2; i + 2 < n; ++i)
    dx[i] = (8 * (x[i + 1] - x[i - 1]) - (x[i + 2] - x[i - 2])) / (12 * Signals::kStep_s);
}

/// The rotation and shift that bring a driven lap onto the reference line, if one fits.
std::string offer_transform(const std::vector<double>& x, const std::vector<double>& y,
                            const crg::ReferenceLine& line) {
  constexpr std::size_t kPoints = 200;
  using Complex = std::complex<double>;
  const auto resample = [](const std::vector<Complex>& path) {
    std::vector<double> s(path.size(), 0.0);
    for (std::size_t i = 1; i < path.size(); ++i) s[i] = s[i - 1] + std::abs(path[i] - path[i - 1]);
    std::vector<Complex> out;
    std::size_t k = 0;
    for (std::size_t i = 0; i < kPoints; ++i) {
      const double at = s.back() * static_cast<double>(i) / kPoints;
      while (k + 2 < path.size() && s[k + 1] < at) ++k;
      const double span = s[k + 1] - s[k];
      out.push_back(path[k] + (span > 0 ? (at - s[k]) / span : 0.0) * (path[k + 1] - path[k]));
    }
    return out;
  };
  std::vector<Complex> road, driven;
  double length = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    road.emplace_back(line.x_m[i], line.y_m[i]);
    if (i > 0) length += std::abs(road[i] - road[i - 1]);
  }
  double gone = 0;
  for (std::size_t i = 0; i < x.size() && gone < length; ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) continue;
    const Complex p(x[i], y[i]);
    if (!driven.empty()) gone += std::abs(p - driven.back());
    driven.push_back(p);
  }
  if (driven.size() < 50 || gone < 0.9 * length || road.size() < 3) return "";
  const auto a = resample(driven), b = resample(road);
  Complex mean_a = 0, mean_b = 0;
  for (std::size_t i = 0; i < kPoints; ++i) mean_a += a[i] / double(kPoints), mean_b += b[i] / double(kPoints);
  double best = std::numeric_limits<double>::infinity(), turn = 0;
  for (std::size_t shift = 0; shift < kPoints; ++shift) {
    Complex product = 0;
    double size = 0;
    for (std::size_t i = 0; i < kPoints; ++i) {
      const Complex p = a[i] - mean_a, q = b[(i + shift) % kPoints] - mean_b;
      product += std::conj(p) * q;
      size += std::norm(p) + std::norm(q);
    }
    const double rms2 = (size - 2 * std::abs(product)) / kPoints;
    if (rms2 < best) best = rms2, turn = std::arg(product);
  }
  if (!(std::sqrt(std::max(0.0, best)) < 15.0)) return "";
  const Complex move = mean_b - mean_a * std::polar(1.0, turn);
  return fmt::format("; the same shape turned by {:.5f} rad about the origin and then shifted by ({:.2f}, {:.2f}) m "
                     "fits within {:.1f} m: crgbuild transform can move the road (by the opposite)",
                     turn, move.real(), move.imag(), std::sqrt(std::max(0.0, best)));
}

void count_laps(Signals& s) {
  s.lap.assign(s.n, 0);
  int lap = 0;
  double last = kNaN;
  std::vector<double> gone{0.0};
  for (std::size_t i = 0; i < s.n; ++i) {
    if (std::isfinite(s.u_m[i])) {
      if (std::isfinite(last)) {
        double step = s.u_m[i] - last;
        if (s.closed && step < -0.5 * s.length_m) {
          ++lap;
          gone.push_back(0.0);
          step += s.length_m;
        }
        if (std::abs(step) < 50) gone.back() += step;
      }
      last = s.u_m[i];
    }
    s.lap[i] = lap;
  }
  for (const double way : gone) {
    s.whole.push_back(way > 0.97 * s.length_m);
    if (s.closed) s.rounds += way / s.length_m;
  }
}

}  // namespace

Signals make_signals(const vehicle::Table& table, const Mapping& mapping,
                     const crg::Surface& surface, const std::string& name) {
  Signals s;
  s.name = name;
  s.imu_yaw_rad = mapping.imu_yaw_rad;
  s.imu_ahead_m = mapping.imu_ahead_m;
  const ColumnMapping* clock = nullptr;
  for (const ColumnMapping& m : mapping.columns)
    if (m.channel == "time_s" && table.find(m.column) != nullptr) clock = &m;
  if (clock == nullptr && !mapping.path.empty())
    throw Error(fmt::format("{}: {} takes no column for time_s; crgexplain map proposes a mapping", name, mapping.path));
  if (clock == nullptr)
    throw Error(fmt::format("{}: no time_s; columns are '{}', ...: crgexplain map proposes a mapping", name,
                            table.names.empty() ? "" : table.names[0]));
  std::vector<double> time = *table.find(clock->column);
  for (double& t : time) t = t * clock->scale + clock->offset;
  double last = -std::numeric_limits<double>::infinity();
  double first_s = kNaN;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (!std::isfinite(time[i])) continue;
    if (std::isnan(first_s)) first_s = time[i];
    if (time[i] < last - 1e-9)
      throw Error(fmt::format("{}: row {}: the clock goes back from {:.3f} to {:.3f} s; cut the log there", name, i + 1, last, time[i]));
    last = time[i];
  }
  for (double& t : time) t -= first_s;
  const double duration = last - first_s;
  if (!(duration >= 10.0))
    throw Error(fmt::format("{}: {:.1f} s long; at least 10 s are wanted", name, std::isfinite(duration) ? duration : 0.0));
  if (duration > 1e5) throw Error(fmt::format("{}: {:.0f} s long; the clock's unit is not seconds, or the log wants cutting", name, duration));
  s.sample_hz = static_cast<double>(time.size() - 1) / duration;
  if (s.sample_hz < 5)
    throw Error(fmt::format("{}: {:.1f} samples a second; at least 10 are wanted", name, s.sample_hz));
  s.n = static_cast<std::size_t>(duration / Signals::kStep_s) + 1;
  // Wide enough for ten samples, not wider than needed.
  const auto read = [&](const std::string& channel) { return samples_of(table, mapping, channel, time); };
  constexpr double kSlowest_hz = 5.0;
  double slowest = s.sample_hz;
  for (const char* motion : {"vx_mps", "vy_mps", "yaw_rate_radps", "ax_mps2", "ay_mps2", "az_mps2"})
    if (const double hz = static_cast<double>(read(motion).t.size()) / duration; hz > 1.2 * kSlowest_hz) slowest = std::min(slowest, hz);
  const double half_s = std::max({0.15, 4.0 / s.sample_hz, slowest < 0.7 * s.sample_hz ? 2.2 / slowest : 0.0});
  const auto put = [&](Channel c, const Samples& samples) {
    if (samples.t.size() < 20) return false;
    // The kernel is that of all channels: slower ones would widen it too much.
    if (const double hz = static_cast<double>(samples.t.size()) / duration; hz < 1.2 * kSlowest_hz && hz < 0.5 * s.sample_hz) {
      const std::string what = fmt::format("{}: '{}' has {:.1f} measurements a second (repeats not counted) in a log of {:.0f} rows a second; at least {:.0f} are wanted", name,
                                           samples.column, hz, s.sample_hz, 1.2 * kSlowest_hz);
      if (c == kX || c == kY || c == kVx) throw Error(what);
      s.remarks.push_back(what + ": not used");
      return false;
    }
    smooth(samples, 0.0, s.n, half_s, s.x[c], s.dx[c]);
    s.present[c] = true;
    s.column[c] = samples.column;
    return true;
  };
  const auto put_mean = [&](Channel c, const std::vector<std::string>& names, double sign_second = 1.0, double factor = 0.5) {
    Samples a = read(names[0]), b = read(names[1]);
    if (a.t.size() < 20 || b.t.size() < 20) return false;
    put(c, a);
    std::vector<double> x, dx;
    smooth(b, 0.0, s.n, half_s, x, dx);
    for (std::size_t i = 0; i < s.n; ++i) {
      s.x[c][i] = factor * (s.x[c][i] + sign_second * x[i]);
      s.dx[c][i] = factor * (s.dx[c][i] + sign_second * dx[i]);
    }
    s.column[c] = a.column + "," + b.column;
    return true;
  };
  for (const auto& [c, channel] : {std::pair{kX, "x_m"}, {kY, "y_m"}, {kVx, "vx_mps"}, {kVy, "vy_mps"},
                                   {kYawRate, "yaw_rate_radps"}, {kAx, "ax_mps2"}, {kAy, "ay_mps2"},
                                   {kAz, "az_mps2"}, {kEngine, "engine_radps"}, {kFuel, "fuel_kg"}})
    put(c, read(channel));
  for (const Channel c : {kX, kY, kVx})
    if (!s.present[c])
      throw Error(fmt::format("{}: no {}; position and speed are the least the analysis needs", name,
                              c == kX ? "x_m" : c == kY ? "y_m" : "vx_mps"));
  Samples yaw = read("yaw_rad");
  for (std::size_t i = 1; i < yaw.x.size(); ++i)
    yaw.x[i] = yaw.x[i - 1] + std::remainder(yaw.x[i] - yaw.x[i - 1], 2 * std::numbers::pi);
  put(kYaw, yaw);
  const auto measured_or_command = [&](Channel c, const char* measured, const char* command) {
    if (put(c, read(measured))) {
      if (c == kSteer) put(kSteerCommand, read(command));
      if (c == kThrottle) put(kThrottleCommand, read(command));
      if (c == kBrakeFront) put(kBrakeCommand, read(command));
      return;
    }
    if (put(c, read(command))) s.commanded[c] = true;
  };
  measured_or_command(kSteer, "steer_rad", "steer_command_rad");
  measured_or_command(kThrottle, "throttle", "throttle_command");
  if (!put_mean(kBrakeFront, {"brake_fl_pa", "brake_fr_pa"}) || !put_mean(kBrakeRear, {"brake_rl_pa", "brake_rr_pa"})) {
    if (put_mean(kBrakeFront, {"brake_fl_command_pa", "brake_fr_command_pa"}) &&
        put_mean(kBrakeRear, {"brake_rl_command_pa", "brake_rr_command_pa"})) {
      s.commanded[kBrakeFront] = s.commanded[kBrakeRear] = true;
    } else {
      for (const Channel c : {kBrakeFront, kBrakeRear}) {
        s.present[c] = false;
        measured_or_command(c, "brake_pa", "brake_command_pa");
      }
    }
  } else if (!put_mean(kBrakeCommand, {"brake_fl_command_pa", "brake_fr_command_pa"})) {
    put(kBrakeCommand, read("brake_command_pa"));
  }
  if (!(put_mean(kWheelFront, {"wheel_fl_radps", "wheel_fr_radps"}) &&
        put_mean(kWheelRear, {"wheel_rl_radps", "wheel_rr_radps"}) &&
        put_mean(kWheelRearDifference, {"wheel_rl_radps", "wheel_rr_radps"}, -1.0, 1.0))) {
    s.wheels_in_mps = put_mean(kWheelFront, {"wheel_fl_mps", "wheel_fr_mps"});
    put_mean(kWheelRear, {"wheel_rl_mps", "wheel_rr_mps"});
    put_mean(kWheelRearDifference, {"wheel_rl_mps", "wheel_rr_mps"}, -1.0, 1.0);
  }
  put_mean(kLoadFront, {"fz_fl_n", "fz_fr_n"}, 1.0, 1.0);
  put_mean(kLoadRear, {"fz_rl_n", "fz_rr_n"}, 1.0, 1.0);
  // A gear is a whole number: the nearest sample, no smoothing.
  if (const Samples gear = read("gear"); gear.t.size() >= 20) {
    s.present[kGear] = true;
    s.column[kGear] = gear.column;
    s.x[kGear].assign(s.n, kNaN);
    s.dx[kGear].assign(s.n, 0.0);
    std::size_t k = 0;
    for (std::size_t i = 0; i < s.n; ++i) {
      const double t = Signals::kStep_s * static_cast<double>(i);
      while (k + 1 < gear.t.size() && gear.t[k + 1] <= t) ++k;
      s.x[kGear][i] = std::round(gear.x[k]);
    }
  }
  for (std::size_t c = 0; c < kChannelCount; ++c) {
    if (!s.present[c]) {
      s.x[c].assign(s.n, kNaN);
      s.dx[c].assign(s.n, kNaN);
      continue;
    }
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const double x : s.x[c])
      if (std::isfinite(x)) low = std::min(low, x), high = std::max(high, x);
    if (c != kGear && c != kFuel && !(high - low > 1e-9)) {
      s.remarks.push_back(fmt::format("{}: '{}' is constant: not used", name, s.column[c]));
      s.present[c] = false;
    }
  }
  // Swapped or in wrong units: speed against the path.
  double vv = 0, vp = 0;
  for (std::size_t i = 0; i < s.n; ++i) {
    const double path = std::hypot(s.dx[kX][i], s.dx[kY][i]);
    if (std::isfinite(path) && std::isfinite(s.x[kVx][i])) vv += s.x[kVx][i] * s.x[kVx][i], vp += s.x[kVx][i] * path;
  }
  const double ratio = vv > 0 ? vp / vv : 0.0;
  if (ratio < 0.7 || ratio > 1.4)
    throw Error(fmt::format("{}: the path is {:.3f} times as fast as '{}': another unit, or not the forward speed", name, ratio, s.column[kVx]));

  const crg::Crg& file = surface.file();
  const crg::ReferenceLine& line = surface.reference_line();
  s.length_m = line.u_step_m * static_cast<double>(line.size() - 1);
  s.closed = line.closed;
  for (auto* v : {&s.u_m, &s.v_m, &s.grade, &s.bank, &s.curvature_v, &s.heading_rad, &s.line_curvature_1pm}) v->assign(s.n, kNaN);
  s.grip.assign(s.n, 1.0);
  crg::Cursor cursor, other;
  std::size_t moving = 0, beside = 0, backwards = 0;
  for (std::size_t i = 0; i < s.n; ++i) {
    const double x = s.x[kX][i], y = s.x[kY][i];
    const double speed = std::hypot(s.dx[kX][i], s.dx[kY][i]);
    if (!std::isfinite(x) || !std::isfinite(y) || !(speed > 3)) continue;
    ++moving;
    const crg::Sample at = surface.at_xy(x, y, cursor);
    const double margin = 3.0;
    if (!std::isfinite(at.u_m) || at.v_m < file.grid.v_m.front() - margin || at.v_m > file.grid.v_m.back() + margin ||
        at.u_m < line.u_begin_m - 1.0 || at.u_m > line.u_begin_m + s.length_m + 1.0) {
      ++beside;
      continue;
    }
    const double cx = s.dx[kX][i] / speed, cy = s.dx[kY][i] / speed;
    if (cx * std::cos(at.heading_rad) + cy * std::sin(at.heading_rad) < 0) ++backwards;
    s.u_m[i] = at.u_m - line.u_begin_m;
    s.v_m[i] = at.v_m;
    if (std::isfinite(at.friction)) s.grip[i] = at.friction;
    s.heading_rad[i] = at.heading_rad;
    s.line_curvature_1pm[i] = std::isfinite(at.curvature_1pm) ? at.curvature_1pm : 0.0;
    // Slopes over a car's length and track, not of single cells.
    const auto z = [&](double ahead, double left) {
      return surface.z_at_xy(x + ahead * cx - left * cy, y + ahead * cy + left * cx, other);
    };
    const double here = z(0, 0), front = z(2, 0), back = z(-2, 0), left = z(0, 0.8), right = z(0, -0.8);
    s.grade[i] = (front - back) / 4.0;
    s.bank[i] = (left - right) / 1.6;
    s.curvature_v[i] = (front - 2 * here + back) / 4.0;
    for (auto* v : {&s.grade, &s.bank, &s.curvature_v})
      if (!std::isfinite((*v)[i])) (*v)[i] = 0.0;
  }
  if (moving < 100) throw Error(fmt::format("{}: the car hardly moves ({:.1f} s above 3 m/s)", name, static_cast<double>(moving) * Signals::kStep_s));
  if (beside * 5 > moving)
    throw Error(fmt::format("{}: {:.0f} % of the path lies beside this road: another track, or another frame{}", name,
                            100.0 * static_cast<double>(beside) / static_cast<double>(moving),
                            offer_transform(s.x[kX], s.x[kY], line)));
  if (beside > 0)
    s.remarks.push_back(fmt::format("{}: {:.1f} s of the path lie beside the road and are left out", name, static_cast<double>(beside) * Signals::kStep_s));
  if (backwards * 2 > moving)
    throw Error(fmt::format("{}: the car drives against u; crgbuild reverse turns the road round", name));
  count_laps(s);
  leave_out_implausible(s);
  return s;
}

}  // namespace explain
