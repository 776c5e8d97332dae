#include "identify/brakes_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "brakes_rows.h"
#include "identify/clustered_fit.h"
#include "longitudinal.h"
#include "sheet_line.h"
#include "window_fit.h"

namespace identify {
namespace {

using vehicle::kWheels;
using P = vehicle::Parameter;
using vehicle::Term;
constexpr std::array<double, 5> kBar{5.0, 20.0, 40.0, 60.0, 200.0};
constexpr std::array<double, 4> kKelvin{250.0, 500.0, 700.0, 1500.0};

/// One factor of each axle, or one of both.
base::Answer<ClusteredFit> solve_brakes(const vehicle::Car<double>& car, const Windows& windows,
                                        bool apart, bool by_speed, const BrakesGranted& granted) {
  Equation e;
  e.columns.resize(apart ? 2 : 1);
  std::vector<std::size_t> block;
  for (const DriveWindow* w : windows) {
    const double front = stated_force(car, *w, 0, granted.mass_kg),
                 rear = stated_force(car, *w, 1, granted.mass_kg);
    e.columns[0].push_back(apart ? front : front + rear);
    if (apart) e.columns[1].push_back(rear);
    e.wanted.push_back(braking_force(car, *w, by_speed, granted));
    block.push_back(w->block);
  }
  return try_clustered_fit({e}, block);
}

struct BrakesBase {
  const vehicle::Car<double>& car;
  bool by_speed;
  BrakesGranted is;
  std::vector<BrakesGranted> moved;
  std::vector<vehicle::Car<double>> cars;  ///< with another inertia of engine or wheels
};

/// The drag found beside one factor of the brakes, over the vehicle file's: pressures and speeds
/// tell them apart where they vary.
base::Answer<ClusteredFit> solve_drag_too(const BrakesBase& base, const Windows& windows,
                                          const BrakesGranted& granted) {
  Equation e;
  e.columns.resize(2);
  std::vector<std::size_t> block;
  BrakesGranted airless = granted;
  airless.drag = 0.0;
  for (const DriveWindow* w : windows) {
    const double left = braking_force(base.car, *w, base.by_speed, airless);
    e.columns[0].push_back(stated_force(base.car, *w, 0, granted.mass_kg) +
                           stated_force(base.car, *w, 1, granted.mass_kg));
    e.columns[1].push_back(left - braking_force(base.car, *w, base.by_speed, granted));
    e.wanted.push_back(left);
    block.push_back(w->block);
  }
  return try_clustered_fit({e}, block);
}

void doubt_drag(const BrakesBase& base, const Windows& windows, double prior, DriveFit& out) {
  constexpr double kTold = 0.1;
  const auto fit = solve_drag_too(base, windows, base.is);
  if (!fit) return;
  double square = std::pow(fit->sd(1), 2.0);
  for (const BrakesGranted& g : base.moved) {
    if (g.drag != base.is.drag) continue;
    const auto moved = solve_drag_too(base, windows, g);
    if (!moved) return;
    square += std::pow(moved->value[1] - fit->value[1], 2.0);
  }
  const double found = fit->value[1], sd = std::sqrt(square);
  if (found > 3.0 * sd && std::abs(found - 1.0) > std::max(kTold, prior) + 3.0 * sd)
    out.doubts.push_back(
        fmt::format("braking says {:.2f} times (standard deviation {:.2g}) the vehicle file's drag "
                    "area: torques are as wrong as it; crgidentify aero finds it",
                    found, sd));
}

/// The factor in place `k`, with everything that its interval holds; unseen when it is too wide.
Found factor(const BrakesBase& base, const std::string& name, const Windows& windows, bool apart,
             std::size_t k, double most_share) {
  Found f{name, "1", 0, 0, 0, 0, 1.0, {}};
  if (windows.size() < 6 || blocks_of(windows) < 5) {
    f.unseen =
        fmt::format("{} windows at {} places, wanted 6 at 5", windows.size(), blocks_of(windows));
    return f;
  }
  f.unseen = "front and rear pressures go together: only both are seen";
  const auto fit = solve_brakes(base.car, windows, apart, base.by_speed, base.is);
  if (!fit) return f;
  f.value = fit->value[k];
  f.sd_drive = fit->sd(k);
  double square = 0.0;
  for (const BrakesGranted& g : base.moved) {
    const auto moved = solve_brakes(base.car, windows, apart, base.by_speed, g);
    if (!moved) return f;
    square += std::pow(moved->value[k] - f.value, 2.0);
  }
  const auto other = other_arm(base.car);
  std::vector<const vehicle::Car<double>*> cars;
  for (const vehicle::Car<double>& car : base.cars) cars.push_back(&car);
  if (other) cars.push_back(&other->car);
  for (const vehicle::Car<double>* car : cars) {
    const auto moved = solve_brakes(*car, windows, apart, base.by_speed, base.is);
    if (!moved) return f;
    square += std::pow(moved->value[k] - f.value, 2.0);
  }
  f.unseen.clear();
  f.sd = std::hypot(f.sd_drive, std::sqrt(square));
  f.within = half_width_90(static_cast<double>(fit->blocks - fit->value.size()), f.sd_drive,
                           std::sqrt(square));
  if (f.within > most_share * std::abs(f.value))
    f.unseen = fmt::format("its 90 % interval would be {:.2g} either way{}", f.within,
                           apart ? ": front and rear pressures go together" : "");
  return f;
}

void find_torques(const BrakesBase& base, const Windows& windows, double most_share,
                  DriveFit& out) {
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
      out.found.push_back(factor(base, name, cell, false, 0, most_share));
    }
}

void say_brakes(const vehicle::Car<double>& car, const BrakesFitOptions& options,
                const BrakesBase& base, const Windows& windows, double mass_sd_kg, DriveFit& out) {
  out.remarks.push_back(fmt::format(
      "a mass of {:.1f} kg with fuel (standard deviation {:.2g}, by {}); torques are as wrong as "
      "it",
      base.is.mass_kg, mass_sd_kg, options.mass_kg > 0.0 ? "the wheel loads" : "the vehicle file"));
  out.remarks.push_back(arm_words(car, windows, base.is.mass_kg));
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
                    const BrakesFitOptions& options) {
  const auto& p = car.parameters;
  const auto sd_share = [&](P parameter) {
    return 0.5 * prior[static_cast<std::size_t>(parameter)];
  };
  const bool weighed = options.mass_kg > 0.0;
  const double mass_kg = weighed ? options.mass_kg : p[P::chassis_mass_kg] + options.fuel_kg;
  const double mass_sd_kg =
      weighed ? options.mass_sd_kg : sd_share(P::chassis_mass_kg) * p[P::chassis_mass_kg];
  Windows windows;
  for (const DriveWindow& w : drive.windows)
    if (brakes_count(car, w, options)) windows.push_back(&w);
  DriveFit out;
  out.windows = windows.size();
  out.blocks = blocks_of(windows);
  if (windows.size() < 6) {
    const std::string why = fmt::format(
        "{} windows of 0.5 s with all brakes' pressures above {:.0f} bar, wheels that turn, closed "
        "throttle, a known gear and hardly a turn; wanted 6",
        windows.size(), 1e-5 * options.least_pa);
    for (const char* const name : {"torque", "front_torque", "rear_torque"})
      out.found.push_back({name, "1", 0, 0, 0, 0, 1.0, why});
    return out;
  }
  BrakesBase base{car,
                  !drive.accelerations || (options.body_axes && !drive.loads && !drive.travels),
                  BrakesGranted{mass_kg, 1.0, 1.0, 1.0, 0.0},
                  brakes_granted(mass_kg, mass_sd_kg, sd_share(P::aero_drag_area_m2)),
                  {}};
  for (const P inertia :
       {P::engine_inertia_kgm2, P::front_wheel_inertia_kgm2, P::rear_wheel_inertia_kgm2}) {
    base.cars.push_back(car);
    base.cars.back().parameters[inertia] *= 1.0 + sd_share(inertia);
  }
  out.found = {factor(base, "torque", windows, false, 0, options.most_share),
               factor(base, "front_torque", windows, true, 0, options.most_share),
               factor(base, "rear_torque", windows, true, 1, options.most_share)};
  find_torques(base, windows, options.most_share, out);
  say_brakes(car, options, base, windows, mass_sd_kg, out);
  doubt_drag(base, windows, prior[static_cast<std::size_t>(P::aero_drag_area_m2)], out);
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
