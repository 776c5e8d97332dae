#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "base/statistics.h"
#include "drive_doubts.h"
#include "identify/drive_fits.h"
#include "longitudinal.h"
#include "window_fit.h"

namespace identify {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;

/// What the equations of both axles have found, and what follows from it.
struct Loads {
  ClusteredFit fit;
  std::size_t columns = 3;  ///< of each axle: mass, lift, transfer, and the mass' rate
  double mass_kg = 0.0, cog_m = 0.0, height_m = 0.0, rate_kgps = 0.0;
  std::array<double, 2> lift_m2{};

  double axle(std::size_t a, std::size_t column) const { return fit.value[a * columns + column]; }
  /// Transfer of the axles, and what does not pass from one to the other.
  double transfer() const { return 0.5 * (axle(1, 2) - axle(0, 2)); }
  double leak() const { return axle(0, 2) + axle(1, 2); }
};

double wheels_kg_m(const vehicle::Car<double>& car) {
  double out = 0.0;
  for (std::size_t a = 0; a < 2; ++a)
    out += 2.0 * car.parameters.axle(a, P::front_wheel_inertia_kgm2) / car.static_radius_m[a];
  return car.terms[Term::wheel_reaction] * out;
}

base::Answer<Loads> solve_loads(const vehicle::Car<double>& car, const DriveWindows& drive,
                                bool with_rate) {
  const auto& p = car.parameters;
  const double length = p[P::chassis_wheelbase_m], half = 0.5 * p[P::aero_density_kgpm3];
  const double middle_s = 0.5 * (drive.begin_s + drive.end_s);
  const double drag_m2 = car.terms[Term::aero_drag] * p[P::aero_drag_area_m2];
  Loads out;
  out.columns = with_rate ? 4 : 3;
  std::vector<std::size_t> block;
  for (const DriveWindow& w : drive.windows) block.push_back(w.block);
  out.mass_kg = p[P::chassis_mass_kg];
  out.cog_m = p[P::chassis_cog_behind_front_m];
  for (int round = 0; round < 4; ++round) {  // the mass and its place are in the sinking alone
    std::vector<Equation> both(2);
    for (const DriveWindow& w : drive.windows) {
      const AirFactors air = air_factors(car, w);
      const double q = half * w.air_mps2, to_rear = out.cog_m / length;
      const auto& s = w.sink_m;
      const double sunk = 0.5 * ((1.0 - to_rear) * (s[0] + s[1]) + to_rear * (s[2] + s[3]));
      const double drag_nm = q * drag_m2 * air.drag * (p[P::aero_drag_height_m] - sunk);
      const double known =
          (drag_nm + rolling_torque(car, w, out.mass_kg) - out.mass_kg * sunk * w.along_mps2) /
          length;
      for (std::size_t a = 0; a < 2; ++a) {
        const double is = w.load_n[2 * a] + w.load_n[2 * a + 1] + (a == 0 ? known : -known),
                     lift = q * air.lift[a];
        with_rate
            ? both[a].add(
                  {w.normal_mps2, lift, w.along_mps2, w.normal_mps2 * (w.time_s - middle_s)}, is)
            : both[a].add({w.normal_mps2, lift, w.along_mps2}, is);
      }
    }
    auto fit = clustered_fit(both, block);
    if (!fit) return fit.refusal();
    out.fit = *std::move(fit);
    out.mass_kg = out.axle(0, 0) + out.axle(1, 0);
    out.cog_m = length * out.axle(1, 0) / out.mass_kg;
  }
  out.height_m = (out.transfer() * length - wheels_kg_m(car)) / out.mass_kg;
  out.lift_m2 = {out.axle(0, 1), out.axle(1, 1)};
  if (with_rate) out.rate_kgps = out.axle(0, 3) + out.axle(1, 3);
  return out;
}

/// In the order of the results: mass, its rate, place, height, front and rear lift.
std::array<double, 6> values_of(const Loads& l) {
  return {l.mass_kg, l.rate_kgps, l.cog_m, l.height_m, l.lift_m2[0], l.lift_m2[1]};
}

/// Standard deviations that the drive leaves, in the same order.
std::array<double, 6> drive_sd(const vehicle::Car<double>& car, const Loads& l) {
  const double length = car.parameters[P::chassis_wheelbase_m];
  const std::size_t n = l.columns;
  const auto sd = [&](std::initializer_list<std::pair<std::size_t, double>> slopes) {
    std::vector<double> all(2 * n, 0.0);
    for (const auto& [at, slope] : slopes) all[at] += slope;
    return l.fit.sd_of(all);
  };
  const double m = l.mass_kg, x = l.cog_m, h = l.height_m;
  return {sd({{0, 1.0}, {n, 1.0}}),
          n == 4 ? sd({{3, 1.0}, {n + 3, 1.0}}) : 0.0,
          sd({{0, -x / m}, {n, (length - x) / m}}),
          sd({{0, -h / m}, {n, -h / m}, {2, -0.5 * length / m}, {n + 2, 0.5 * length / m}}),
          sd({{1, 1.0}}),
          sd({{n + 1, 1.0}})};
}

constexpr double kFuelUnsure_kg = 30.0;  // as much is assumed where nobody states it
constexpr double kLeastRate_s = 120.0;   // a shorter drive says nothing of a mass that changes
constexpr double kMostMassShare = 0.05;  // as kMostShare

/// Parameters of the vehicle file that the results lean on.
constexpr std::array<P, 9> kMassLeansOn{
    P::chassis_wheelbase_m,      P::aero_drag_area_m2,       P::aero_drag_height_m,
    P::front_wheel_inertia_kgm2, P::rear_wheel_inertia_kgm2, P::front_spring_npm,
    P::rear_spring_npm,          P::front_ride_height_m,     P::rear_ride_height_m};

double off_by(const vehicle::Car<double>& car, P parameter, const Prior& prior) {
  const double value = car.parameters[parameter];
  return share_sd(prior, parameter) * (value == 0.0 ? 1.0 : std::abs(value));
}

/// Cars and windows, each with one thing that was taken for granted moved by a standard deviation.
/// Loads of strain gauges in struts, or of a simpler simulator, hold neither the wheels' moments
/// nor the sinking of the body.
std::vector<std::pair<vehicle::Car<double>, DriveWindows>> loads_granted(
    const vehicle::Car<double>& car, const Prior& prior, const DriveWindows& drive) {
  std::vector<std::pair<vehicle::Car<double>, DriveWindows>> out;
  for (const P parameter : kMassLeansOn) {
    out.emplace_back(car, drive);
    out.back().first.parameters[parameter] += off_by(car, parameter, prior);
  }
  out.emplace_back(car, drive);
  for (const Term moment : {Term::wheel_reaction, Term::rolling_resistance})
    out.back().first.terms[moment] *= 1.0 - kBetween;
  out.emplace_back(car, drive);
  for (DriveWindow& w : out.back().second.windows)
    for (double& sink : w.sink_m) sink *= 1.0 - kBetween;
  return out;
}

void say_what_is_assumed(const vehicle::Car<double>& car, const DriveWindows& drive,
                         const WeighedOptions& options, const Loads& l, DriveFit& out) {
  const auto& p = car.parameters;
  out.remarks.push_back(normal_words(drive, options.body_axes));
  out.remarks.push_back(fmt::format(
      "lift areas are for air of {:.4g} kg/m3 that stands still: loads show density times area",
      p[P::aero_density_kgpm3]));
  out.remarks.push_back(fmt::format(
      "drag presses the rear axle and lifts the front as downforce does: a drag area of {:.4g} m2 "
      "at a height of {:.4g} m is the vehicle file's word, with its prior",
      p[P::aero_drag_area_m2], p[P::aero_drag_height_m]));
  out.remarks.emplace_back(
      "loads of strain gauges or of simpler simulators lack the wheels' moments or the sinking of "
      "the body: centre of mass and height may be off by what these are, and intervals hold it");
  if (car.terms[Term::wheel_reaction] > 0.0)
    out.remarks.push_back(fmt::format(
        "the height holds what the wheels' spinning up adds to the transfer ({:.3g} m of it taken "
        "off, by their inertia in the vehicle file)",
        wheels_kg_m(car) / l.mass_kg));
  const vehicle::CarFiles& files = *car.files;
  if (car.terms[Term::aero_ride_height] > 0.0 &&
      !(files.front_lift_factor.empty() && files.rear_lift_factor.empty()))
    out.remarks.emplace_back(
        "lift areas are those at standing ride heights by the maps of the vehicle file; where the "
        "maps are wrong, areas and masses are");
  out.remarks.push_back(
      wheelbase_off(car, drive) == 0.0
          ? fmt::format("place and height of the centre of mass are in proportion to the wheelbase "
                        "of {:.4g} m, which is the vehicle file's word, with its prior",
                        p[P::chassis_wheelbase_m])
          : fmt::format("steering, yaw rate and speed say a wheelbase of {:.2f} m (standard "
                        "deviation {:.2g}) where {:.4g} are stated, or the steering's ratio is "
                        "off: place and height of the centre of mass go with it, and their "
                        "intervals hold the difference",
                        drive.wheelbase_m, drive.wheelbase_sd_m, p[P::chassis_wheelbase_m]));
  if (!drive.travels)
    out.remarks.emplace_back(
        "no travels: how far the body sinks and tilts is by the vehicle file's springs");
  out.remarks.emplace_back(
      "a gain of the load cells is a gain of mass and lift; an offset of ax_mps2 of 0.1 m/s2 moves "
      "the centre of mass by a hundredth of its height");
}

/// Transfer that does not pass from one axle to the other has no cause on the car.
void doubt(const Loads& l, const DriveWindows& drive, DriveFit& out) {
  std::vector<double> slope(2 * l.columns, 0.0);
  slope[2] = slope[l.columns + 2] = 1.0;
  const double tilt = -l.leak() / l.mass_kg, sd = l.fit.sd_of(slope) / l.mass_kg;
  if (std::abs(tilt) < 0.01 || std::abs(tilt) < 3.0 * sd) return;
  const std::string words = fmt::format(
      "all loads together change by {:.3f} kg per kg of mass with ax_mps2 (standard deviation "
      "{:.3f})",
      -tilt, sd);
  if (drive.normal == NormalFrom::kMeasured)
    out.remarks.push_back(
        fmt::format("{}: the accelerometer seems to be tilted by {:.2f} degrees, or the load cells "
                    "feel braking",
                    words, 57.29577951308232 * tilt));
  else
    out.remarks.push_back(words + ": the load cells feel braking, or their gains differ");
  if (std::abs(tilt) > 0.1)
    out.doubts.push_back(words +
                         ": more than a tenth; loads and accelerations do not belong "
                         "together (signs, clocks, scales?)");
}

double spread(const DriveWindows& drive, double DriveWindow::*what, double low, double high) {
  std::vector<double> values;
  for (const DriveWindow& w : drive.windows) values.push_back(w.*what);
  return base::quantile(values, high) - base::quantile(values, low);
}

/// Why, where the windows cannot tell the mass.
std::optional<base::Refusal> cannot_tell(const DriveWindows& drive) {
  if (!drive.loads)
    return base::Refusal(
        "not observable: mass, centre of mass and lift: the recording has no wheel loads (fz_fl_n, "
        "fz_fr_n, fz_rl_n, fz_rr_n)");
  if (!drive.accelerations)
    return base::Refusal(
        "the recording has no channel ax_mps2: wanted to tell transfer from weight");
  if (drive.windows.size() < 20)
    return base::Refusal(fmt::format(
        "{} stretches of half a second with loads remain above the least speed: wanted 20",
        drive.windows.size()));
  return std::nullopt;
}

/// The results' names and what the vehicle file has in their place, with its fuel.
std::array<Found, 6> named(const vehicle::Car<double>& car, double fuel_kg) {
  const auto& p = car.parameters;
  const double dry = p[P::chassis_mass_kg], all = dry + fuel_kg;
  const auto with_fuel = [&](P of_car, P of_fuel) {
    return (dry * p[of_car] + fuel_kg * p[of_fuel]) / all;
  };
  return {found_of("mass_kg", "kg", all),
          found_of("mass_rate_kgps", "kg/s", DriveWindow::kNaN),
          found_of("cog_behind_front_m", "m",
                   with_fuel(P::chassis_cog_behind_front_m, P::fuel_tank_behind_front_m)),
          found_of("cog_height_m", "m", with_fuel(P::chassis_cog_height_m, P::fuel_tank_height_m)),
          found_of("front_lift_area_m2", "m2", p[P::front_lift_area_m2]),
          found_of("rear_lift_area_m2", "m2", p[P::rear_lift_area_m2])};
}

/// Says of each number that the drive does not show why.
void hide_unseen(const DriveWindows& drive, double length_m, std::array<Found, 6>& found) {
  const double lift = std::max(std::abs(found[4].value + found[5].value), 0.4);
  const double faster = spread(drive, &DriveWindow::vx_mps, 0.05, 0.95),
               braked = spread(drive, &DriveWindow::along_mps2, 0.05, 0.95);
  const std::array<double, 6> most{kMostMassShare * found[0].value,
                                   1e9,
                                   0.02 * length_m,
                                   kMostShare * std::abs(found[3].value),
                                   kMostShare * lift,
                                   kMostShare * lift};
  const std::string of_speed = fmt::format("the speed varies by {:.1f} m/s only", faster),
                    of_ax = fmt::format("ax_mps2 varies by {:.2f} m/s2 only", braked);
  const double lasts_s = drive.end_s - drive.begin_s;
  for (std::size_t k = 0; k < 6; ++k) {
    Found& f = found[k];
    if (k == 1 && !(lasts_s > kLeastRate_s))
      f.unseen = fmt::format("the drive lasts {:.0f} s; wanted {:.0f}", lasts_s, kLeastRate_s);
    else if (k != 3 && k != 1 && faster < 5.0)
      f.unseen = of_speed + ": weight and downforce look the same";
    else if (k == 3 && braked < 3.0)
      f.unseen = of_ax;
    else if (f.within > most[k])
      f.unseen = fmt::format("{}; {}, {}", too_wide(f.within), of_speed, of_ax);
  }
}

/// Results that no car has, and loads that stay unexplained.
void doubt_results(const Loads& l, const DriveWindows& drive, double length_m, double most_off,
                   DriveFit& out) {
  if (!(l.height_m > 0.0) && out.at("cog_height_m").unseen.empty())
    out.doubts.emplace_back(
        "the loads say a height below the road: braking would press the rear axle (sign of "
        "ax_mps2, front and rear loads exchanged?)");
  for (std::size_t a = 0; a < 2; ++a) {
    double load = 0.0;
    for (const DriveWindow& w : drive.windows) load += w.load_n[2 * a] + w.load_n[2 * a + 1];
    load /= static_cast<double>(drive.windows.size());
    if (l.fit.rms[a] > 0.1 * load)
      out.doubts.push_back(fmt::format(
          "{:.0f} N (root mean square) of the {} axle's load of {:.0f} N are not explained: wheels "
          "exchanged, or clocks apart?",
          l.fit.rms[a], a == 0 ? "front" : "rear", load));
  }
  const double stated = out.at("mass_kg").stated;
  if (out.at("mass_kg").unseen.empty() &&
      std::abs(l.mass_kg - stated) >
          std::hypot(most_off * stated, 6.0 * out.at("mass_kg").sd, kFuelUnsure_kg))
    out.doubts.push_back(
        fmt::format("the loads weigh {:.1f} kg where {:.1f} are stated with fuel, further than the "
                    "vehicle file's prior, the drive and {:.0f} kg of fuel leave open: loads in "
                    "another unit, gains of the cells, or another car",
                    l.mass_kg, stated, kFuelUnsure_kg));
  if (!(l.mass_kg > 0.0) || !(l.cog_m > 0.0 && l.cog_m < length_m))
    out.doubts.emplace_back("the loads say a mass below 0 or a centre of mass outside the axles");
}

}  // namespace

base::Answer<DriveFit> fit_mass(const vehicle::Car<double>& car, const Prior& prior,
                                const DriveWindows& drive, const WeighedOptions& options) {
  if (auto refused = cannot_tell(drive)) return *std::move(refused);
  const double length = car.parameters[P::chassis_wheelbase_m];
  const bool with_rate = drive.end_s - drive.begin_s > kLeastRate_s;
  const auto loads = solve_loads(car, drive, with_rate);
  if (!loads) return loads.refusal();
  const Loads& l = *loads;
  const std::array<double, 6> value = values_of(l), sd_drive = drive_sd(car, l);
  std::array<double, 6> of_file{};  // variance that the vehicle file brings in
  for (const auto& [other, windows] : loads_granted(car, prior, drive)) {
    const auto with_other = solve_loads(other, windows, with_rate);
    if (!with_other) return with_other.refusal();
    const std::array<double, 6> moved = values_of(*with_other);
    for (std::size_t k = 0; k < 6; ++k) of_file[k] += (moved[k] - value[k]) * (moved[k] - value[k]);
  }
  if (drive.normal != NormalFrom::kMeasured)
    of_file[0] += std::pow(value[0] * share_sd(prior, P::environment_gravity_mps2), 2.0);
  const double off = wheelbase_off(car, drive);
  for (const std::size_t k : {2u, 3u}) of_file[k] += std::pow(value[k] * off, 2.0);
  const double freedom = static_cast<double>(l.fit.blocks - l.columns);
  std::array<Found, 6> found = named(car, options.fuel_kg);
  for (std::size_t k = 0; k < 6; ++k)
    set_found(found[k], value[k], freedom, sd_drive[k], std::sqrt(of_file[k]));
  hide_unseen(drive, length, found);
  DriveFit out;
  out.windows = drive.windows.size();
  out.blocks = l.fit.blocks;
  out.found.assign(found.begin(), found.end());
  say_what_is_assumed(car, drive, options, l, out);
  doubt(l, drive, out);
  doubt_results(l, drive, length, 3.0 * prior[static_cast<std::size_t>(P::chassis_mass_kg)], out);
  return out;
}

std::string mass_sheet(const vehicle::Car<double>& car, const DriveFit& fit, double fuel_kg) {
  const auto& p = car.parameters;
  const Found &mass = fit.at("mass_kg"), &cog = fit.at("cog_behind_front_m"),
              &height = fit.at("cog_height_m");
  std::string out;
  const auto line = [&](const Found& f, const char* key, double value) {
    if (f.unseen.empty() && !mass.unseen.empty() && (&f == &cog || &f == &height))
      out += fmt::format("# {} without the fuel not observable: the mass is not\n", key);
    else
      out += sheet_line(f, key, value);
  };
  const double empty = mass.value - fuel_kg;
  if (mass.unseen.empty() && !(empty > 0.0))
    throw base::Error(fmt::format(
        "{:.1f} kg of fuel leave nothing of a mass of {:.1f} kg: wanted the fuel that was on board "
        "(--fuel-kg)",
        fuel_kg, mass.value));
  line(mass, "chassis.mass_kg", empty);
  line(cog, "chassis.cog_behind_front_m",
       (mass.value * cog.value - fuel_kg * p[P::fuel_tank_behind_front_m]) / empty);
  line(height, "chassis.cog_height_m",
       (mass.value * height.value - fuel_kg * p[P::fuel_tank_height_m]) / empty);
  const Found &front = fit.at("front_lift_area_m2"), &rear = fit.at("rear_lift_area_m2");
  line(front, "front.lift_area_m2", front.value);
  line(rear, "rear.lift_area_m2", rear.value);
  return out;
}

}  // namespace identify
