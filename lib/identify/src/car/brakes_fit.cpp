#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "brakes_rows.h"
#include "identify/drive_fits.h"
#include "window_fit.h"

namespace identify {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;
constexpr std::array<double, 5> kBar{5.0, 20.0, 40.0, 60.0, 200.0};
constexpr std::array<double, 4> kKelvin{250.0, 500.0, 700.0, 1500.0};

/// One factor of each axle, or one of both.
base::Answer<ClusteredFit> solve_brakes(const Along& a, const vehicle::Car<double>& car,
                                        const Windows& windows, bool apart,
                                        const Granted& granted) {
  Equation e;
  std::vector<std::size_t> block;
  for (const DriveWindow* w : windows) {
    const double front = stated_force(car, *w, 0, granted.mass_kg),
                 rear = stated_force(car, *w, 1, granted.mass_kg);
    const double is = braking_force(car, *w, a.by_speed, granted);
    apart ? e.add({front, rear}, is) : e.add({front + rear}, is);
    block.push_back(w->block);
  }
  return clustered_fit({e}, block);
}

/// The drag found beside one factor of the brakes, over the vehicle file's: pressures and speeds
/// tell them apart where they vary.
base::Answer<ClusteredFit> solve_drag_too(const Along& a, const vehicle::Car<double>& car,
                                          const Windows& windows, const Granted& granted) {
  Equation e;
  std::vector<std::size_t> block;
  Granted airless = granted;
  airless.drag = 0.0;
  for (const DriveWindow* w : windows) {
    const double left = braking_force(car, *w, a.by_speed, airless);
    e.add({stated_force(car, *w, 0, granted.mass_kg) + stated_force(car, *w, 1, granted.mass_kg),
           left - braking_force(car, *w, a.by_speed, granted)},
          left);
    block.push_back(w->block);
  }
  return clustered_fit({e}, block);
}

void doubt_drag(const Along& a, const Windows& windows, DriveFit& out) {
  constexpr double kTold = 0.1;
  const double prior = a.prior[static_cast<std::size_t>(P::aero_drag_area_m2)];
  const auto fit = solve_drag_too(a, a.car, windows, a.is);
  if (!fit) return;
  std::vector<Granted> beside = brakes_moved(a);
  std::erase_if(beside, [&](const Granted& g) { return g.drag != a.is.drag; });
  const auto granted =
      a.granted_covariance({}, beside, [&](const vehicle::Car<double>& car, const Granted& g) {
        const auto moved = solve_drag_too(a, car, windows, g);
        return moved ? moved->values() : Eigen::VectorXd::Constant(2, NAN);
      });
  const double found = fit->value[1], sd = std::hypot(fit->sd(1), std::sqrt(granted(1, 1)));
  if (found > 3.0 * sd && std::abs(found - 1.0) > std::max(kTold, prior) + 3.0 * sd)
    out.doubts.push_back(
        fmt::format("braking says {:.2f} times (standard deviation {:.2g}) the vehicle file's drag "
                    "area: torques are as wrong as it; crgidentify aero finds it",
                    found, sd));
}

/// The factor in place `k`, with everything that its interval holds; unseen when it is too wide.
Found factor(const Along& a, const std::string& name, const Windows& windows, bool apart,
             std::size_t k) {
  if (windows.size() < 6 || blocks_of(windows) < 5)
    return found_of(
        name, "1", 1.0,
        fmt::format("{} windows at {} places, wanted 6 at 5", windows.size(), blocks_of(windows)));
  Found f = found_of(name, "1", 1.0, "front and rear pressures go together: only both are seen");
  const auto fit = solve_brakes(a, a.car, windows, apart, a.is);
  if (!fit) return f;
  const Eigen::MatrixXd granted = a.granted_covariance(
      {P::engine_inertia_kgm2, P::front_wheel_inertia_kgm2, P::rear_wheel_inertia_kgm2},
      brakes_moved(a), [&](const vehicle::Car<double>& car, const Granted& g) {
        const auto moved = solve_brakes(a, car, windows, apart, g);
        return moved ? moved->values() : Eigen::VectorXd::Constant(fit->values().size(), NAN);
      });
  const auto at = static_cast<Eigen::Index>(k);
  if (!std::isfinite(granted(at, at))) return f;
  set_found(f, fit->value[k], static_cast<double>(fit->blocks - fit->value.size()), fit->sd(k),
            std::sqrt(granted(at, at)));
  f.unseen.clear();
  hide_wide(f, apart ? ": front and rear pressures go together" : "");
  return f;
}

void find_torques(const Along& a, const Windows& windows, DriveFit& out) {
  const bool warm = std::isfinite(windows.front()->disc_k[0]);
  for (std::size_t b = 0; b + 1 < kBar.size(); ++b)
    for (std::size_t k = 0; k + 1 < (warm ? kKelvin.size() : 2); ++k) {
      Windows cell;
      for (const DriveWindow* w : windows) {
        const double bar = 1e-5 * std::max(w->brake_pa[0], w->brake_pa[1]);
        const double kelvin = 0.5 * (w->disc_k[0] + w->disc_k[1]);
        if (bar >= kBar[b] && bar < kBar[b + 1] &&
            (!warm || (kelvin >= kKelvin[k] && kelvin < kKelvin[k + 1])))
          cell.push_back(w);
      }
      std::string name = fmt::format("torque_{:.0f}_{:.0f}_bar", kBar[b], kBar[b + 1]);
      if (warm) name += fmt::format("_{:.0f}_{:.0f}_k", kKelvin[k], kKelvin[k + 1]);
      out.found.push_back(factor(a, name, cell, false, 0));
    }
}

void say_brakes(const Along& a, const Windows& windows, DriveFit& out) {
  const vehicle::Car<double>& car = a.car;
  out.remarks.push_back(a.mass_words("torques are"));
  out.remarks.push_back(a.arm_words(windows));
  out.remarks.emplace_back(
      "drag, inertias, rolling resistance (15 %) and the engine's drag at closed throttle (20 %) "
      "are the vehicle file's word; standard deviations");
  out.remarks.emplace_back(
      "friction, area and radius of a brake look the same: their product is found");
  if (!car.files->pad_friction.empty() && car.terms[Term::brake_friction_temperature] > 0.0)
    out.remarks.emplace_back(
        std::isfinite(windows.front()->disc_k[0])
            ? "factors are on the pad friction map, at the recorded disc "
              "temperatures of the front"
            : "not all discs have temperatures: factors are on the pad friction map at the "
              "middle of its temperatures, and fade is not observable");
  else if (!std::isfinite(windows.front()->disc_k[0]))
    out.remarks.emplace_back("not observable: fade: not all discs have temperatures");
}

}  // namespace

DriveFit fit_brakes(const vehicle::Car<double>& car, const Prior& prior, const DriveWindows& drive,
                    const WeighedOptions& options) {
  Windows windows;
  for (const DriveWindow& w : drive.windows)
    if (brakes_count(car, w)) windows.push_back(&w);
  DriveFit out;
  out.windows = windows.size();
  out.blocks = blocks_of(windows);
  if (windows.size() < 6) {
    const std::string why = fmt::format(
        "{} windows of 0.5 s with all brakes' pressures above {:.0f} bar, wheels that turn, closed "
        "throttle, a known gear and hardly a turn; wanted 6",
        windows.size(), 1e-5 * kBraking_pa);
    for (const char* const name : {"torque", "front_torque", "rear_torque"})
      out.found.push_back(found_of(name, "1", 1.0, why));
    return out;
  }
  const Along along(car, prior, drive, options);
  const auto find = [&](const char* name, bool apart, std::size_t k) {
    out.found.push_back(factor(along, name, windows, apart, k));
  };
  find("torque", false, 0);
  find("front_torque", true, 0);
  find("rear_torque", true, 1);
  find_torques(along, windows, out);
  say_brakes(along, windows, out);
  doubt_drag(along, windows, out);
  const Found& both = out.found[0];
  if (both.unseen.empty() && !(both.value > 0.0))
    out.doubts.emplace_back(
        "pressure speeds the car up: sign of ax_mps2, or pressures in another "
        "unit?");
  return out;
}

std::string brakes_sheet(const vehicle::Car<double>& car, const DriveFit& fit) {
  const bool by_map =
      !car.files->pad_friction.empty() && car.terms[Term::brake_friction_temperature] > 0.0;
  const Found &both = fit.at("torque"), &front = fit.at("front_torque"),
              &rear = fit.at("rear_torque");
  const bool apart = front.unseen.empty() && rear.unseen.empty();
  std::string out;
  if (!apart && both.unseen.empty())
    out = "# one factor for front and rear: apart they are not observable\n";
  for (std::size_t a = 0; a < 2; ++a) {
    const Found& f = apart ? (a == 0 ? front : rear) : both;
    const char* const axle = a == 0 ? "front" : "rear";
    const std::string key = fmt::format("{}.{}", axle, by_map ? "brake_area_m2" : "brake_friction");
    const double stated =
        car.parameters.axle(a, by_map ? P::front_brake_area_m2 : P::front_brake_friction);
    out += sheet_line(f, key, f.value * stated);
  }
  return out;
}

}  // namespace identify
