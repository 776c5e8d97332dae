#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.h"
#include "base/statistics.h"
#include "identify/drive_fits.h"
#include "recording/channels.h"
#include "vehicle/laws/suspension.h"
#include "window_fit.h"

namespace identify {
namespace {

using vehicle::kWheels;
using P = vehicle::Parameter;
using vehicle::Term;

/// How far a contact moves outward per travel: roll centre and change of camber.
double outward_slope(const vehicle::Car<double>& car, std::size_t axle) {
  const auto& p = car.parameters;
  return car.terms[Term::suspension_kinematics] *
         (2.0 * p.axle(axle, P::front_roll_centre_m) / p.axle(axle, P::front_track_m) -
          p.axle(axle, P::front_camber_gain_radpm) * car.static_radius_m[axle]);
}

/// Side force of an axle per lateral acceleration in steady cornering, kg.
double side_kg(const vehicle::Car<double>& car, std::size_t axle, double mass_kg) {
  const double to_rear =
      car.parameters[P::chassis_cog_behind_front_m] / car.parameters[P::chassis_wheelbase_m];
  return mass_kg * (axle == 0 ? 1.0 - to_rear : to_rear);
}

/// What the wheels push the car with along the road, N: the rest of its acceleration is the air's.
double on_road_n(const vehicle::Car<double>& car, const DriveWindow& w, double mass_kg) {
  const auto& p = car.parameters;
  return mass_kg * w.along_mps2 + car.terms[Term::aero_drag] * 0.5 * p[P::aero_density_kgpm3] *
                                      p[P::aero_drag_area_m2] * w.air_mps2;
}

/// A window whose wheels are clear of the stops.
bool clear_of_stops(const vehicle::Car<double>& car, const DriveWindow& w) {
  if (!(car.terms[Term::bump_stop] > 0.0)) return true;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const auto into =
        vehicle::laws::stop_compression(car.parameters, vehicle::axle_of(i), w.travel_m[i]);
    if (into.bump_m > -0.002 || into.droop_m > -0.002) return false;
  }
  return true;
}

/// What the fit takes for granted, moved to see what it does.
struct SuspensionGranted {
  double mass_kg = 0.0;
  double roll_centre_m = 0.0;  ///< added to the vehicle file's
  double links = 1.0;          ///< factor on what the links carry of the side force
};

/// Standard deviations: how well the vehicle file is believed to know the roll centre, what links
/// carry of the side force, and what the model leaves out of a spring rate (measured on the
/// simulated car and on another simulator's).
constexpr double kRollCentreSd_m = 0.01, kLinksShare = 0.15, kSpringShare = 0.015;
constexpr std::size_t kHeave = 5, kRoll = 2;  ///< columns of an axle's two equations

ClusteredFit solve_springs(const vehicle::Car<double>& car, const Windows& windows,
                           const SuspensionGranted& granted) {
  std::vector<Equation> all;
  std::vector<std::size_t> block;
  for (const DriveWindow* w : windows) block.push_back(w->block);
  for (std::size_t a = 0; a < 2; ++a) {
    const auto& p = car.parameters;
    Equation heave, roll;
    const double slope = outward_slope(car, a) + car.terms[Term::suspension_kinematics] * 2.0 *
                                                     granted.roll_centre_m /
                                                     p.axle(a, P::front_track_m);
    for (const DriveWindow* w : windows) {
      const std::size_t l = 2 * a, r = l + 1;
      const double push = on_road_n(car, *w, granted.mass_kg), both_n = w->load_n[l] + w->load_n[r],
                   apart_n = w->load_n[l] - w->load_n[r];
      // The wheel that carries more has more of the side force, which the links turn upwards.
      heave.add({0.5 * (w->travel_m[l] + w->travel_m[r]), 1.0, std::max(0.0, push),
                 std::min(0.0, push), w->left_mps2 * apart_n / std::max(1.0, both_n)},
                0.5 * both_n - p.axle(a, P::front_unsprung_mass_kg) * w->normal_mps2);
      roll.add({0.5 * (w->travel_m[l] - w->travel_m[r]), 1.0},
               0.5 * apart_n +
                   0.5 * granted.links * slope * side_kg(car, a, granted.mass_kg) * w->left_mps2);
    }
    all.push_back(std::move(heave));
    all.push_back(std::move(roll));
  }
  return clustered_fit(all, block).or_throw();
}

/// Place of an axle's spring rate and of its rate in roll among the weights.
std::size_t spring_at(std::size_t axle) { return axle * (kHeave + kRoll); }
std::size_t roll_at(std::size_t axle) { return spring_at(axle) + kHeave; }

struct Spread {
  double heave_m = 0.0, roll_m = 0.0;
};

Spread spread_of(const Windows& windows, std::size_t axle) {
  std::vector<double> heave, roll;
  for (const DriveWindow* w : windows) {
    heave.push_back(0.5 * (w->travel_m[2 * axle] + w->travel_m[2 * axle + 1]));
    roll.push_back(0.5 * (w->travel_m[2 * axle] - w->travel_m[2 * axle + 1]));
  }
  const auto range = [](const std::vector<double>& v) {
    return base::quantile(v, 0.95) - base::quantile(v, 0.05);
  };
  return {range(heave), range(roll)};
}

void find_springs(const vehicle::Car<double>& car, const Windows& windows, const ClusteredFit& fit,
                  const std::vector<ClusteredFit>& moved, std::size_t axle, DriveFit& out) {
  const auto& p = car.parameters;
  const std::string name = recording::kAxleNames[axle];
  const double freedom = static_cast<double>(fit.blocks) - static_cast<double>(kHeave);
  const Spread spread = spread_of(windows, axle);
  const double k = fit.value[spring_at(axle)], in_roll = fit.value[roll_at(axle)];
  Found spring = found_of(name + "_spring_npm", "N/m", p.axle(axle, P::front_spring_npm));
  const double model = kSpringShare * std::abs(k);
  set_found(spring, k, freedom, fit.sd(spring_at(axle)), model);
  const std::string heaves = fmt::format("both travels together vary by {:.1f} mm",
                                         1e3 * spread.heave_m),
                    rolls = fmt::format("left against right by {:.1f} mm", 1e3 * spread.roll_m);
  hide_wide(spring, "; " + heaves);
  if (spread.heave_m < 0.002) spring.unseen = heaves + ", wanted 2";
  std::vector<double> slope(fit.value.size(), 0.0);
  slope[roll_at(axle)] = 0.5;
  slope[spring_at(axle)] = -0.5;
  Found bar = found_of(name + "_anti_roll_npm", "N/m",
                       car.terms[Term::anti_roll_bar] * p.axle(axle, P::front_anti_roll_npm));
  double square = 0.25 * model * model;
  for (const ClusteredFit& m : moved)
    square += std::pow(0.5 * (m.value[roll_at(axle)] - in_roll), 2.0);
  set_found(bar, 0.5 * (in_roll - k), freedom, fit.sd_of(slope), std::sqrt(square));
  if (!spring.unseen.empty()) bar.unseen = "the spring beside it is not";
  if (spread.roll_m < 0.002) bar.unseen = rolls + ", wanted 2";
  // A bar may be weak: what counts is how well it is known beside the whole rate in roll.
  if (bar.unseen.empty() && 2.0 * bar.within > kMostShare * std::abs(in_roll))
    bar.unseen = too_wide(bar.within) + ", by what the links may carry; " + rolls;
  out.found.push_back(std::move(spring));
  out.found.push_back(std::move(bar));
}

}  // namespace

DriveFit fit_suspension(const vehicle::Car<double>& car, const Prior& prior,
                        const DriveWindows& drive, double mass_kg) {
  if (!drive.loads || !drive.travels)
    throw base::Error(fmt::format(
        "not observable: springs, bars and dampers: the recording has no {} of all four wheels",
        drive.loads ? "travels (suspension_fl_m ...)" : "loads (fz_fl_n ...)"));
  Windows windows;
  for (const DriveWindow& w : drive.windows)
    if (clear_of_stops(car, w) && std::isfinite(w.along_mps2 + w.left_mps2)) windows.push_back(&w);
  if (windows.size() < 20)
    throw base::Error(fmt::format(
        "{} stretches of half a second remain with accelerations and with wheels clear of the "
        "stops: wanted 20",
        windows.size()));
  const ClusteredFit fit = solve_springs(car, windows, {mass_kg, 0.0, 1.0});
  std::vector<ClusteredFit> moved{solve_springs(car, windows, {mass_kg, kRollCentreSd_m, 1.0}),
                                  solve_springs(car, windows, {1.025 * mass_kg, 0.0, 1.0}),
                                  solve_springs(car, windows, {mass_kg, 0.0, 1.0 + kLinksShare})};
  for (const P gain : {P::front_camber_gain_radpm, P::rear_camber_gain_radpm}) {
    vehicle::Car<double> other = car;
    other.parameters[gain] *= 1.0 + share_sd(prior, gain);
    moved.push_back(solve_springs(other, windows, {mass_kg, 0.0, 1.0}));
  }
  DriveFit out;
  out.windows = windows.size();
  out.blocks = fit.blocks;
  for (std::size_t a = 0; a < 2; ++a) {
    find_springs(car, windows, fit, moved, a, out);
    if (out.found[2 * a].unseen.empty() && !(out.found[2 * a].value > 0.0))
      out.doubts.push_back(fmt::format(
          "the {} springs push less the more they are pressed: sign of the travels (compressed is "
          "positive), or wheels exchanged?",
          recording::kAxleNames[a]));
  }
  out.remarks.push_back(fmt::format("{} of {} windows, clear of the bump and droop stops",
                                    windows.size(), drive.windows.size()));
  out.remarks.push_back(
      fmt::format("bars and links look the same (both go with lateral acceleration): roll centre "
                  "(within {:.0f} "
                  "mm), change of camber and with them what the links carry of the side force "
                  "(within {:.0f} %) "
                  "are the vehicle file's word; standard deviations",
                  1e3 * kRollCentreSd_m, 100.0 * kLinksShare));
  out.remarks.push_back(
      fmt::format("{:.1f} % of a spring rate are counted as standard deviation for what half "
                  "seconds and straight "
                  "links leave out",
                  100.0 * kSpringShare));
  out.remarks.emplace_back(
      "what braking, driving and cornering press through the links is found beside the springs, "
      "from the same loads");
  out.remarks.emplace_back("rates are at the wheel; gains of load cells and travels are in them");
  return out;
}

std::string suspension_sheet(const DriveFit& fit) {
  std::string out;
  for (std::size_t a = 0; a < 2; ++a) {
    const std::string axle = recording::kAxleNames[a];
    const Found &spring = fit.at(axle + "_spring_npm"), &bar = fit.at(axle + "_anti_roll_npm");
    out += sheet_line(spring, axle + ".spring_npm", spring.value) +
           sheet_line(bar, axle + ".anti_roll_npm", std::max(0.0, bar.value));
  }
  return out;
}

}  // namespace identify
