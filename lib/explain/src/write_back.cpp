#include "explain/write_back.h"

#include <algorithm>
#include <cmath>

#include "crg/edit.h"
#include "crg/surface.h"
#include "late_actuator.h"

namespace explain {
namespace {

/// A profile at every row: a quadratic B-spline over its cells, to nothing outside. Kinks of banking would
/// be bumps under the wheels beside the middle of the road.
std::vector<double> profile_along(const std::vector<ProfilePoint>& profile, std::size_t rows, double u_step_m, bool closed) {
  std::vector<double> out(rows, 0.0);
  const double cell = profile[1].u_m - profile[0].u_m;
  const auto size = static_cast<std::ptrdiff_t>(profile.size());
  // One of the whole lap begins with the road and goes on behind its end.
  const double ends_m = static_cast<double>(size - (closed ? 0 : 1)) * cell, length_m = static_cast<double>(rows - 1) * u_step_m;
  const bool whole = profile.front().u_m == 0.0 && std::abs(ends_m - length_m) < 0.5 * cell;
  const auto value = [&](std::ptrdiff_t j) {
    if (whole) j = closed ? ((j % size) + size) % size : std::clamp<std::ptrdiff_t>(j, 0, size - 1);
    return j < 0 || j >= size ? 0.0 : profile[static_cast<std::size_t>(j)].value;
  };
  for (std::size_t i = 0; i < rows; ++i) {
    const double place = (static_cast<double>(i) * u_step_m - profile.front().u_m) / cell;
    const auto j = static_cast<std::ptrdiff_t>(std::floor(place + 0.5));
    const double t = place - static_cast<double>(j);
    out[i] = 0.5 * (0.5 - t) * (0.5 - t) * value(j - 1) + (0.75 - t * t) * value(j) + 0.5 * (0.5 + t) * (0.5 + t) * value(j + 1);
  }
  return out;
}

/// The profile of grip that a simulated car is given. A cell where the tyres are hardly used says nothing
/// by itself and one that says too little grip spins the wheels: each counts by its interval, beside
/// the tenth that stated tyre curves get wrong about grip, and neighbours of 10 m differ by 0.05 (one
/// standard deviation). Nothing is added at either end.
std::vector<ProfilePoint> steadied(std::vector<ProfilePoint> profile) {
  constexpr double kCurves = 0.1, kStep_per10m = 0.05;
  const std::size_t n = profile.size();
  const double step = kStep_per10m * std::sqrt((profile[1].u_m - profile[0].u_m) / 10), tie = 1 / (step * step);
  std::vector<double> diagonal(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double deviation = std::hypot(profile[i].ci90 / 1.645, kCurves), weight = 1 / (deviation * deviation);
    diagonal[i] = weight + 2 * tie;
    profile[i].value *= weight;
    if (i == 0) continue;
    profile[i].value += tie / diagonal[i - 1] * profile[i - 1].value;
    diagonal[i] -= tie * tie / diagonal[i - 1];
  }
  for (std::size_t i = n; i-- > 0;) profile[i].value = (profile[i].value + (i + 1 < n ? tie * profile[i + 1].value : 0.0)) / diagonal[i];
  return profile;
}

/// Between the middles of the bins linearly.
void add_patch(const HeightPatch& patch, crg::Grid& grid) {
  const auto rows = static_cast<std::ptrdiff_t>(patch.dz_m.size() / patch.columns), columns = static_cast<std::ptrdiff_t>(patch.columns);
  const auto value = [&](std::ptrdiff_t i, std::ptrdiff_t j) {
    return i < 0 || j < 0 || i >= rows || j >= columns ? 0.0 : patch.dz_m[static_cast<std::size_t>(i * columns + j)];
  };
  for (std::size_t r = 0; r < grid.rows(); ++r)
    for (std::size_t c = 0; c < grid.columns(); ++c) {
      const double u = static_cast<double>(r) * grid.u_step_m / patch.u_step_m - 0.5, v = (grid.v_m[c] - patch.right_m) / patch.v_step_m - 0.5;
      const auto i = static_cast<std::ptrdiff_t>(std::floor(u)), j = static_cast<std::ptrdiff_t>(std::floor(v));
      const double fu = u - static_cast<double>(i), fv = v - static_cast<double>(j);
      grid.at(r, c) += static_cast<float>((1 - fu) * ((1 - fv) * value(i, j) + fv * value(i, j + 1)) + fu * ((1 - fv) * value(i + 1, j) + fv * value(i + 1, j + 1)));
    }
}

/// Heights from further along by `shift_m`; the reference line stays. Beyond the ends of an open road those
/// of its ends.
void shift_heights(crg::Crg& road, double shift_m, bool closed) {
  const crg::Surface old(road);
  crg::Grid& grid = road.grid;
  const double length = static_cast<double>(grid.rows() - 1) * grid.u_step_m;
  for (std::size_t i = 0; i < grid.rows(); ++i) {
    const double u = static_cast<double>(i) * grid.u_step_m;
    double from = u + shift_m;
    from = closed ? from - length * std::floor(from / length) : std::clamp(from, 0.0, length);
    for (std::size_t j = 0; j < grid.columns(); ++j)
      grid.at(i, j) += static_cast<float>(old.z_at_uv(from + grid.u_begin_m, grid.v_m[j]) - old.z_at_uv(u + grid.u_begin_m, grid.v_m[j]));
  }
}

/// Measured behind the actuator of this channel.
bool is_outcome(const std::string& channel, Channel c) {
  if (c == kSteer) return channel == "steer_rad";
  if (c == kThrottle) return channel == "throttle";
  return channel.starts_with("brake_") && channel.ends_with("_pa") && channel.find("command") == std::string::npos;
}

/// steer_rad: steer_command_rad; throttle: throttle_command; brake_fl_pa: brake_fl_command_pa.
std::string command_of(const std::string& channel) {
  const std::size_t unit = channel.ends_with("_rad") || channel.ends_with("_pa") ? channel.rfind('_') : channel.size();
  return channel.substr(0, unit) + "_command" + channel.substr(unit);
}

}  // namespace

std::optional<crg::Crg> friction_map(const crg::Crg& road, const crg::Crg* known, const Findings& findings) {
  std::optional<crg::Crg> out;
  for (const Finding& f : findings.findings) {
    if (f.mechanism != "road.friction" || f.profile.size() < 2) continue;
    if (!out) {
      out = crg::crop(road, {});
      out->z_double_m.clear();
      std::fill(out->grid.z_m.begin(), out->grid.z_m.end(), 1.0f);
      if (known != nullptr)
        for (std::size_t i = 0; i < std::min(out->grid.z_m.size(), known->grid.z_m.size()); ++i)
          if (std::isfinite(known->grid.z_m[i])) out->grid.z_m[i] = known->grid.z_m[i];
      out->comment.push_back("factors on the grip, found by crgexplain from recordings");
    }
    const std::size_t rows = out->grid.rows();
    const std::vector<double> along = profile_along(steadied(f.profile), rows, out->grid.u_step_m, crg::Surface(road).reference_line().closed);
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t j = 0; j < out->grid.columns(); ++j) out->grid.at(i, j) *= static_cast<float>(std::clamp(1 + along[i], 0.1, 2.0));
  }
  return out;
}

std::optional<crg::Crg> corrected_road(const crg::Crg& road, const Findings& findings) {
  const auto misplaced = [](const Finding& f) { return f.mechanism == "road.misplaced" && !f.parameters.empty(); };
  const auto height = [&](const Finding& f) { return misplaced(f) || !f.patch.dz_m.empty() || f.mechanism == "road.banking" || f.mechanism == "road.grade" || f.mechanism == "road.vertical_curvature"; };
  if (std::none_of(findings.findings.begin(), findings.findings.end(), height)) return std::nullopt;
  crg::Crg out = crg::crop(road, {});  // works the modifiers in
  out.z_double_m.clear();
  const std::size_t rows = out.grid.rows(), columns = out.grid.columns();
  const bool closed = crg::Surface(road).reference_line().closed;
  // What else was found has its place on the true road.
  for (const Finding& f : findings.findings)
    if (misplaced(f)) shift_heights(out, f.parameters[0].value, closed);
  for (const Finding& f : findings.findings) {
    if (!f.patch.dz_m.empty()) add_patch(f.patch, out.grid);
    if (!height(f) || !f.patch.dz_m.empty() || f.profile.size() < 2) continue;
    const std::vector<double> along = profile_along(f.profile, rows, out.grid.u_step_m, closed);
    std::vector<double> rise(rows, 0.0);
    const bool curvature = f.mechanism == "road.vertical_curvature";
    if (f.mechanism != "road.banking") {
      // Grade is the derivative of the height, curvature the second; what does not come back to
      // zero at the end is spread over the lap.
      const auto integrate = [&](std::vector<double>& v) {
        double sum = 0;
        for (double& x : v) sum += x * out.grid.u_step_m, x = sum;
        const double left = v.back();
        for (std::size_t i = 0; i < rows; ++i) v[i] -= left * static_cast<double>(i) / static_cast<double>(rows - 1);
      };
      rise = along;
      integrate(rise);
      if (curvature) {
        double mean = 0;
        for (const double x : rise) mean += x / static_cast<double>(rows);
        for (double& x : rise) x -= mean;
        integrate(rise);
      }
    }
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t j = 0; j < columns; ++j)
        out.grid.at(i, j) += static_cast<float>(f.mechanism == "road.banking" ? along[i] * out.grid.v_m[j] : rise[i]);
  }
  out.comment.push_back("heights corrected by crgexplain from recordings");
  return out;
}

std::optional<Mapping> corrected_mapping(const Mapping& mapping, const vehicle::Vehicle& car, const Findings& findings, const std::vector<Signals>& logs) {
  Mapping out = mapping;
  bool changed = false;
  for (const Finding& f : findings.findings) {
    if (f.parameters.empty()) continue;
    const double value = f.parameters[0].value;
    if (f.mechanism == "sensor.misalignment") out.imu_yaw_rad += value, changed = true;
    if (f.mechanism == "sensor.lever_arm" && f.channel != logs.front().column[kVy]) out.imu_ahead_m += value, changed = true;
    const bool logger_radius = f.mechanism == "parameter.wheel_radius" && logs.front().wheels_in_mps;
    const LateActuator* const late = late_actuator(f.mechanism);
    const bool measured = late != nullptr && car.terms[late->term] == 0 && !commanded(logs, late->channel);
    for (ColumnMapping& m : out.columns) {
      if (logger_radius && m.channel.starts_with(f.parameters[0].name.starts_with("front") ? "wheel_f" : "wheel_r") && m.channel.ends_with("_mps")) {
        m.scale *= value, m.offset *= value, changed = true;
      } else if (measured && is_outcome(m.channel, late->channel)) {
        const double gain = late->channel == kSteer ? car.parameters[late->gain] : 1 / car.parameters[late->gain];
        m.channel = command_of(m.channel);
        m.scale *= gain, m.offset *= gain, changed = true;
      }
      // A finding about the mean of two columns names both.
      if (f.kind != "sensor" || ("," + f.channel + ",").find("," + m.column + ",") == std::string::npos) continue;
      if (f.mechanism == "sensor.bias") m.offset -= value;
      else if (f.mechanism == "sensor.gain") m.scale /= 1 + value, m.offset /= 1 + value;
      else if (f.mechanism == "sensor.delay") m.delay_s += value;
      else if (f.mechanism == "sensor.low_pass") m.low_pass_s = std::max(0.0, m.low_pass_s + value);
      else continue;
      changed = true;
    }
  }
  if (!changed) return std::nullopt;
  return out;
}

}  // namespace explain
