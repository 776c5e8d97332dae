#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/statistics.h"
#include "identify/drive_fits.h"
#include "longitudinal.h"
#include "vehicle/laws/engine.h"
#include "window_fit.h"

namespace identify {
namespace {

using P = vehicle::Parameter;

constexpr double kGrade = 0.002;  // a standard deviation as those of window_fit.h

/// Where tyres turn, they drag.
bool hardly_turns(const DriveWindow& w) { return std::abs(left_mps2(w)) < 2.0; }

/// Windows in which nothing drives or drags the wheels.
Windows coasting(const DriveWindows& drive, const AeroFitOptions& options) {
  Windows out;
  for (const DriveWindow& w : drive.windows) {
    const bool stated = std::any_of(
        options.engine_off_s.begin(), options.engine_off_s.end(),
        [&](const auto& s) { return w.time_s > s.first + 0.25 && w.time_s < s.second - 0.25; });
    if ((stated || w.gear == 0.0) && hardly_turns(w) && !braked(w, kUnbraked_pa)) out.push_back(&w);
  }
  return out;
}

/// Windows at open throttle behind another one in the same gear: boost and shift are over.
Windows pulling(const vehicle::Car<double>& car, const DriveWindows& drive) {
  Windows out;
  const auto open = [&](const DriveWindow& w) {
    return w.throttle > 0.95 && !braked(w, kUnbraked_pa) && gear_of(car, w).value_or(0) > 0 &&
           std::isfinite(w.wheel_radps[2] + w.wheel_radps[3]);
  };
  for (std::size_t k = 1; k < drive.windows.size(); ++k) {
    const DriveWindow &before = drive.windows[k - 1], &w = drive.windows[k];
    if (w.time_s - before.time_s < 1.0 && open(before) && open(w) && hardly_turns(w) &&
        gear_of(car, before) == gear_of(car, w))
      out.push_back(&w);
  }
  return out;
}

/// Drag area and rest, or the engine's factor and drag area.
ClusteredFit solve_drag(const Along& a, const vehicle::Car<double>& car, const Windows& windows,
                        bool coasts, const Granted& granted) {
  Equation e;
  std::vector<std::size_t> block;
  for (const DriveWindow* w : windows) {
    const int gear = coasts ? 0 : gear_of(car, *w).value_or(0);
    const AlongForces f = along_forces(car, *w, granted.mass_kg, gear, a.by_speed);
    const double is =
        f.inertia_n + granted.mass_kg * granted.offset_mps2 + granted.rolling * f.rolling_n;
    if (coasts) {
      e.add({-f.drag_m2_n, -1.0}, is);
    } else {
      const Gearing g = gearing(car, *w, gear, granted.mass_kg, true);
      const double torque =
          vehicle::laws::map_torque(car.parameters[P::engine_torque], car.files->engine_torque_nm,
                                    g.engine_radps, std::clamp(w->throttle, 0.0, 1.0));
      e.add({g.per_torque_1pm * torque, -f.drag_m2_n}, is);
    }
    block.push_back(w->block);
  }
  return clustered_fit({e}, block).or_throw();
}

double speed_spread(const Windows& windows) {
  std::vector<double> v;
  for (const DriveWindow* w : windows) v.push_back(w->vx_mps);
  return windows.empty() ? 0.0 : base::quantile(v, 0.95) - base::quantile(v, 0.05);
}

/// Why these windows cannot tell; empty: they can.
std::string too_little(const Windows& windows) {
  if (windows.size() < 10) return fmt::format("{} windows of 0.5 s, wanted 10", windows.size());
  if (blocks_of(windows) < 6)
    return fmt::format("at {} places of the road, wanted 6", blocks_of(windows));
  if (speed_spread(windows) < 8.0)
    return fmt::format("the speed varies by {:.1f} m/s, wanted 8", speed_spread(windows));
  return {};
}

std::string how_said(bool coasts, std::size_t windows) {
  return coasts ? fmt::format(
                      "by {} windows in which nothing drives the wheels (gear 0, or as "
                      "stated by --engine-off)",
                      windows)
                : fmt::format(
                      "by {} windows at open throttle, by the shape of the engine map of "
                      "the vehicle file (its factor is found beside the drag, an error of "
                      "its shape is not seen); a coast-down in neutral would not need it",
                      windows);
}

void say_aero(const Along& a, const DriveWindows& drive, DriveFit& out) {
  const vehicle::Car<double>& car = a.car;
  out.remarks.push_back(a.mass_words("the drag area is"));
  out.remarks.push_back(fmt::format(
      "for air of {:.4g} kg/m3 that stands still: a wind of 2 m/s along a straight is 8 % of the "
      "drag at 50 m/s, and cancels only where both directions were driven",
      car.parameters[P::aero_density_kgpm3]));
  out.remarks.push_back(
      a.by_speed
          ? "acceleration by the change of vx_mps: neither axes nor tilt of an "
            "accelerometer matter, an error of the speed's scale does"
          : "acceleration by ax_mps2; an offset of it goes to rest_n in a coast-down, and is taken "
            "as 0 with a standard deviation of 0.05 m/s2 at open throttle");
  out.remarks.emplace_back(
      "rolling resistance as the tyre files have it, 15 % of it taken as its standard deviation: "
      "what grows with downforce looks like drag");
  if (!drive.loads && !drive.travels && car.terms[vehicle::Term::aero_ride_height] > 0.0 &&
      !car.files->drag_factor.empty())
    out.remarks.emplace_back(
        "no travels, no loads: ride heights for the drag's map are by the vehicle file's springs");
  if (drive.normal != NormalFrom::kRoad)
    out.remarks.emplace_back("grades of the road stand in the result: no --road");
}

}  // namespace

DriveFit fit_aero(const vehicle::Car<double>& car, const Prior& prior, const DriveWindows& drive,
                  const AeroFitOptions& options) {
  const Along along(car, prior, drive, options);
  const auto free = coasting(drive, options), pulled = pulling(car, drive);
  const std::string no_coast = too_little(free);
  std::string no_pull = too_little(pulled);
  if (!no_pull.empty() && pulled.empty() && !drive.windows.empty() &&
      !std::isfinite(drive.windows.front().wheel_radps[2]))
    no_pull = "no speeds of the driven wheels";
  if (no_pull.empty() && car.files->turbo == vehicle::Turbo::kFull)
    no_pull = "the vehicle's engine has no torque map (full turbo)";
  DriveFit out;
  out.found = {found_of("drag_area_m2", "m2", car.parameters[P::aero_drag_area_m2]),
               found_of("rest_n", "N", DriveWindow::kNaN)};
  Found &drag = out.found[0], &rest = out.found[1];
  const bool coasts = no_coast.empty();
  if (!coasts && !no_pull.empty()) {
    drag.unseen = rest.unseen = fmt::format(
        "no coast-down (gear 0 or --engine-off: {}), no open throttle ({})", no_coast, no_pull);
    return out;
  }
  const Windows& windows = coasts ? free : pulled;
  const ClusteredFit fit = solve_drag(along, car, windows, coasts, along.is);
  const double offset = coasts ? 0.0 : along.by_speed ? kGrade * 9.8 : kOffset_mps2;
  const auto granted = along.granted_covariance(
      {P::front_wheel_inertia_kgm2, P::rear_wheel_inertia_kgm2, P::front_ride_height_m,
       P::rear_ride_height_m, P::engine_inertia_kgm2},
      along.moved({{&Granted::mass_kg, along.mass_sd_kg},
                   {&Granted::rolling, kRollingShare},
                   {&Granted::offset_mps2, offset}}),
      [&](const vehicle::Car<double>& other, const Granted& g) {
        return solve_drag(along, other, windows, coasts, g).values();
      });
  out.windows = windows.size();
  out.blocks = fit.blocks;
  const auto set = [&](Found& f, std::size_t k) {
    const auto at = static_cast<Eigen::Index>(k);
    set_found(f, fit.value[k], static_cast<double>(fit.blocks - 2), fit.sd(k),
              std::sqrt(granted(at, at)));
  };
  set(drag, coasts ? 0 : 1);
  if (coasts) set(rest, 1);
  hide_wide(drag, "; " + how_said(coasts, windows.size()));
  if (!coasts) rest.unseen = "at open throttle it looks like the engine's torque";
  out.remarks = {how_said(coasts, windows.size()), along.arm_words(windows)};
  say_aero(along, drive, out);
  if (drag.unseen.empty() && !(drag.value > 0.0))
    out.doubts.emplace_back("the drag area is below 0: sign of ax_mps2, wind, or a grade?");
  return out;
}

std::string aero_sheet(const DriveFit& fit) {
  const Found& f = fit.at("drag_area_m2");
  return sheet_line(f, "aero.drag_area_m2", f.value);
}

}  // namespace identify
