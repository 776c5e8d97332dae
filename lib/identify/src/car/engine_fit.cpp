#include "identify/engine_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "base/error.h"
#include "engine_rows.h"
#include "identify/clustered_fit.h"
#include "longitudinal.h"
#include "map_fit.h"
#include "window_fit.h"

namespace identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using P = vehicle::Parameter;
using vehicle::Term;
// Standard deviations of what no file states: of the front side force, by steering and lateral
// acceleration; of a gear against the others (its own losses).
constexpr double kSideShare = 0.1, kGearShare = 0.02;

/// Places of the map: those of the vehicle file, and halves of the widest gaps where these are few.
std::vector<double> axis_of(std::vector<double> places, std::size_t least) {
  while (places.size() < least) {
    std::vector<double> gap(places.size());
    std::adjacent_difference(places.begin(), places.end(), gap.begin());
    const auto widest = std::max_element(gap.begin() + 1, gap.end());
    const auto behind = places.begin() + (widest - gap.begin());
    places.insert(behind, *behind - 0.5 * *widest);
  }
  return places;
}

vehicle::Map2 stated_torque_map(const vehicle::Car<double>& car) {
  const vehicle::Map2& from = car.files->engine_torque_nm;
  if (from.x.size() < 2 || from.y.size() < 2)
    throw base::Error("the vehicle file's engine map has one place along an axis; wanted two");
  vehicle::Map2 out{axis_of(from.x, 8), axis_of(from.y, 5), {}};
  if (out.x.size() * out.y.size() > kMostMapPlaces)
    throw base::Error(fmt::format(
        "the vehicle file's engine map has {} by {} places, at most {} in all wanted; give a "
        "vehicle file with a coarser one",
        out.x.size(), out.y.size(), kMostMapPlaces));
  for (const double speed : out.x)
    for (const double open : out.y)
      out.z.push_back(car.parameters[P::engine_torque] * vehicle::evaluate(from, speed, open));
  return out;
}

/// A fit with everything that its intervals hold.
struct EngineSolved {
  MapFit fit;
  vehicle::Map2 torque_nm;  ///< that the deviations are from
  MatrixXd granted;         ///< covariance by what was taken for granted
  std::vector<std::string> doubts;
};

struct Asked {
  const vehicle::Car<double>& car;
  const Prior& prior;
  const EngineWindows& windows;
  bool by_speed;
  EngineGranted is;
  double mass_sd_kg;
};

/// What each thing that was taken for granted would have changed, one standard deviation of it.
MatrixXd granted_of(const Asked& a, const EngineSolved& s, const MatrixXd& held) {
  const EngineEquations is = engine_equations(a.car, a.windows, s.torque_nm, a.by_speed, a.is);
  const VectorXd value = map_fit_again(is.rows, is.wanted, held, s.fit);
  MatrixXd out = MatrixXd::Zero(value.size(), value.size());
  const auto add = [&](const vehicle::Car<double>& car, const EngineGranted& granted) {
    const EngineEquations e = engine_equations(car, a.windows, s.torque_nm, a.by_speed, granted);
    const VectorXd off = map_fit_again(e.rows, e.wanted, held, s.fit) - value;
    out += off * off.transpose();
  };
  std::vector<P> leaned{P::aero_drag_area_m2, P::engine_inertia_kgm2, P::rear_wheel_inertia_kgm2,
                        P::front_wheel_inertia_kgm2, P::gearbox_efficiency};
  if (a.car.terms[Term::turbo_lag] > 0.0) leaned.push_back(P::turbo_share);
  for (const P parameter : leaned) {
    vehicle::Car<double> other = a.car;
    other.parameters[parameter] *= 1.0 + 0.5 * a.prior[static_cast<std::size_t>(parameter)];
    add(other, a.is);
  }
  if (const auto other = other_arm(a.car)) add(other->car, a.is);
  for (const EngineGranted& moved : {EngineGranted{a.is.mass_kg + a.mass_sd_kg, 1.0, 0.0, 1.0},
                                     EngineGranted{a.is.mass_kg, 1.0 + kRollingShare, 0.0, 1.0},
                                     EngineGranted{a.is.mass_kg, 1.0, kOffset_mps2, 1.0},
                                     EngineGranted{a.is.mass_kg, 1.0, 0.0, 1.0 + kSideShare}})
    add(a.car, moved);
  return out;
}

/// Windows in each gear.
std::vector<std::size_t> driven_in(const EngineWindows& windows) {
  std::vector<std::size_t> out(windows.gears);
  for (const EngineWindow& e : windows.windows) ++out[static_cast<std::size_t>(e.gear - 1)];
  return out;
}

/// What of the vehicle file the drive contradicts: found beside the map, with a wide prior of its
/// own, since gears show one place of the map at several speeds and accelerations.
std::vector<std::string> contradicted(const Asked& a, const EngineSolved& s,
                                      const VectorXd& from_stated, const MatrixXd& held,
                                      const std::vector<std::size_t>& block) {
  constexpr double kWide = 0.5;
  constexpr std::ptrdiff_t kLeastGears = 3;
  const auto in_gear = driven_in(a.windows);
  if (std::count_if(in_gear.begin(), in_gear.end(), [](std::size_t w) { return w >= 6; }) <
      kLeastGears)
    return {};
  const auto with_both = [](const EngineEquations& e) {
    MatrixXd rows(e.rows.rows(), e.rows.cols() + 2);
    rows << e.rows, -e.drag_n, -e.inertia_n;
    return rows;
  };
  const Index n = held.rows();
  MatrixXd wide = MatrixXd::Zero(n + 2, n + 2);
  wide.topLeftCorner(n, n) = held;
  wide(n, n) = kWide * kWide;
  wide(n + 1, n + 1) = 1.0;
  const EngineEquations is = engine_equations(a.car, a.windows, s.torque_nm, a.by_speed, a.is);
  const MapFit fit = map_fit(with_both(is), is.wanted + is.rows * from_stated, block, wide);
  VectorXd variance = fit.noise.diagonal() + fit.prior_left.diagonal();
  const VectorXd same = map_fit_again(with_both(is), is.wanted + is.rows * from_stated, wide, fit);
  for (const EngineGranted& moved : {EngineGranted{a.is.mass_kg + a.mass_sd_kg, 1.0, 0.0, 1.0},
                                     EngineGranted{a.is.mass_kg, 1.0 + kRollingShare, 0.0, 1.0},
                                     EngineGranted{a.is.mass_kg, 1.0, kOffset_mps2, 1.0}}) {
    const EngineEquations e = engine_equations(a.car, a.windows, s.torque_nm, a.by_speed, moved);
    variance += (map_fit_again(with_both(e), e.wanted + e.rows * from_stated, wide, fit) - same)
                    .cwiseAbs2();
  }
  std::vector<std::string> out;
  struct Stated {
    P parameter;
    double told;  ///< share that this fit may be off by what it takes for granted
    const char* words;
  };
  const Stated stated[] = {{P::aero_drag_area_m2, 0.1, "drag area (crgidentify aero finds it)"},
                           {P::engine_inertia_kgm2, 0.4, "engine inertia"}};
  for (Index k = 0; k < 2; ++k) {
    const double found = 1.0 + fit.value(n + k), sd = std::sqrt(variance(n + k)),
                 prior = a.prior[static_cast<std::size_t>(stated[k].parameter)];
    if (found > 3.0 * sd && std::abs(found - 1.0) > std::max(stated[k].told, prior) + 3.0 * sd)
      out.push_back(fmt::format(
          "gears at one engine speed say {:.2f} times (standard deviation {:.2g}) the vehicle "
          "file's {}: torques are as wrong as it; state it",
          found, sd, stated[k].words));
  }
  return out;
}

/// Covariance of the stated map's errors and of the gears': the map is that of the mean of the
/// gears that were driven.
MatrixXd engine_held_by(const vehicle::Map2& stated, const EngineWindows& windows) {
  const double most = *std::max_element(stated.z.begin(), stated.z.end());
  VectorXd size(static_cast<Index>(stated.z.size()));
  for (Index k = 0; k < size.size(); ++k)
    size(k) = std::abs(stated.z[static_cast<std::size_t>(k)]) + 0.1 * most;
  const auto gears = static_cast<Index>(windows.gears);
  MatrixXd out = MatrixXd::Zero(size.size() + gears, size.size() + gears);
  out.topLeftCorner(size.size(), size.size()) = map_covariance(stated.x, stated.y, size, {});
  const auto in_gear = driven_in(windows);
  const auto driven = static_cast<double>(
      std::count_if(in_gear.begin(), in_gear.end(), [](std::size_t n) { return n > 0; }));
  for (Index g = 0; g < gears; ++g)
    for (Index h = 0; h < gears; ++h) {
      const bool both = in_gear[static_cast<std::size_t>(g)] > 0 &&
                        in_gear[static_cast<std::size_t>(h)] > 0 && driven > 1.0;
      out(size.size() + g, size.size() + h) =
          kGearShare * kGearShare * ((g == h ? 1.0 : 0.0) - (both ? 1.0 / driven : 0.0));
    }
  return out;
}

/// Deviations of a map from the stated one are found twice: gears' factors act on what is found.
EngineSolved solve_engine(const Asked& a, const vehicle::Map2& stated) {
  std::vector<std::size_t> block;
  for (const EngineWindow& e : a.windows.windows) block.push_back(e.window->block);
  const MatrixXd held = engine_held_by(stated, a.windows);
  EngineSolved s{{}, stated, {}, {}};
  VectorXd before = VectorXd::Zero(held.rows());
  const Index places = static_cast<Index>(stated.z.size());
  for (int round = 0; round < 3; ++round) {
    EngineEquations e = engine_equations(a.car, a.windows, s.torque_nm, a.by_speed, a.is);
    // The prior is about the stated map: what the last round added counts as wanted again.
    for (Index k = 0; k < places; ++k)
      before(k) =
          s.torque_nm.z[static_cast<std::size_t>(k)] - stated.z[static_cast<std::size_t>(k)];
    s.fit = map_fit(e.rows, e.wanted + e.rows * before, block, held);
    if (round == 2) break;
    for (Index k = 0; k < places; ++k)
      s.torque_nm.z[static_cast<std::size_t>(k)] =
          stated.z[static_cast<std::size_t>(k)] + s.fit.value(k);
  }
  s.granted = granted_of(a, s, held);
  s.doubts = contradicted(a, s, before, held, block);
  return s;
}

/// Seconds near each place in each gear, and how many places of the road they are from.
void count_time(const EngineWindows& windows, double step_s, EngineFit& out,
                std::vector<std::set<std::size_t>>& from) {
  from.resize(out.cells.size());
  for (const EngineWindow& e : windows.windows)
    for (const EngineRow& row : e.rows)
      for (const auto& [place, weight] :
           map_weights(out.engine_radps, out.throttle, row.engine_radps, row.throttle)) {
        out.cells[place].gear_s[static_cast<std::size_t>(e.gear - 1)] += weight * step_s;
        if (weight > 0.2) from[place].insert(e.window->block);
      }
}

void find_places(const EngineSolved& s, const vehicle::Map2& stated, const EngineWindows& windows,
                 double step_s, const EngineFitOptions& options, EngineFit& out) {
  const double most = *std::max_element(stated.z.begin(), stated.z.end());
  for (std::size_t k = 0; k < stated.z.size(); ++k) {
    const auto i = static_cast<Index>(k);
    EngineCell cell;
    cell.engine_radps = stated.x[k / stated.y.size()];
    cell.throttle = stated.y[k % stated.y.size()];
    cell.stated_nm = stated.z[k];
    cell.gear_s.resize(windows.gears);
    cell.torque_nm = stated.z[k] + s.fit.value(i);
    const double drive = s.fit.noise(i, i), file = s.fit.prior_left(i, i) + s.granted(i, i);
    cell.sd_nm = std::sqrt(drive + file);
    cell.within_nm =
        half_width_90(static_cast<double>(s.fit.blocks) - 2.0, std::sqrt(drive), std::sqrt(file));
    out.cells.push_back(cell);
  }
  std::vector<std::set<std::size_t>> from;
  count_time(windows, step_s, out, from);
  for (std::size_t k = 0; k < out.cells.size(); ++k) {
    EngineCell& cell = out.cells[k];
    double seconds = 0.0;
    for (const double in_gear : cell.gear_s) seconds += in_gear;
    const double wide = cell.within_nm / std::max(std::abs(cell.torque_nm), 0.25 * most);
    if (seconds < options.least_seconds || from[k].size() < 2)
      cell.unseen =
          fmt::format("{:.1f} s near it, at {} places of the road", seconds, from[k].size());
    else if (wide > options.most_share)
      cell.unseen = fmt::format("its 90 % interval would be {:.2g} N m either way", cell.within_nm);
  }
}

/// The found over the stated map, and each gear over the map of all.
void find_factors(const EngineSolved& s, const EngineWindows& windows, EngineFit& out) {
  const auto places = static_cast<Index>(out.cells.size());
  VectorXd slope = VectorXd::Zero(places + static_cast<Index>(windows.gears));
  double square = 0.0;
  for (Index k = 0; k < places; ++k) {
    const EngineCell& cell = out.cells[static_cast<std::size_t>(k)];
    if (!cell.unseen.empty()) continue;
    slope(k) = cell.stated_nm;
    square += cell.stated_nm * cell.stated_nm;
  }
  const double freedom = static_cast<double>(s.fit.blocks) - 2.0;
  const auto found = [&](std::string name, const VectorXd& by) {
    Found f{std::move(name), "1", 1.0 + by.dot(s.fit.value), 0, 0, 0, 1.0, {}};
    const double drive = by.dot(s.fit.noise * by),
                 file = by.dot((s.fit.prior_left + s.granted) * by);
    f.sd_drive = std::sqrt(drive);
    f.sd = std::sqrt(drive + file);
    f.within = half_width_90(freedom, f.sd_drive, std::sqrt(file));
    return f;
  };
  Found all = found("torque", square > 0.0 ? VectorXd(slope / square) : slope);
  if (!(square > 0.0)) all.unseen = "no place of the map is seen";
  out.fit.found.push_back(all);
  const auto in_gear = driven_in(windows);
  for (std::size_t g = 0; g < in_gear.size(); ++g) {
    Found f = found(fmt::format("torque_gear_{}", g + 1),
                    VectorXd::Unit(slope.size(), places + static_cast<Index>(g)));
    if (in_gear[g] < 6)
      f.unseen = fmt::format("{} windows in this gear, wanted 6", in_gear[g]);
    else if (f.within > 0.8 * kNormal90 * kGearShare)
      f.unseen = "gears and places of the map go together: no more is known of it than before";
    out.fit.found.push_back(std::move(f));
  }
}

void say_engine(const Asked& a, const EngineFitOptions& options, EngineFit& out) {
  auto& remarks = out.fit.remarks;
  remarks.push_back(fmt::format(
      "a mass of {:.1f} kg with fuel (standard deviation {:.2g}, by {}); torques are as wrong as "
      "it",
      a.is.mass_kg, a.mass_sd_kg, options.mass_kg > 0.0 ? "the wheel loads" : "the vehicle file"));
  std::vector<const DriveWindow*> driven;
  for (const EngineWindow& window : a.windows.windows) driven.push_back(window.window);
  remarks.push_back(arm_words(a.car, driven, a.is.mass_kg));
  remarks.emplace_back(
      "drag, rolling resistance (15 %), inertias, losses of the gears and 0.05 m/s2 of offset are "
      "the vehicle file's word; standard deviations of them are in the intervals");
  remarks.emplace_back(
      "torque and losses of the gears look the same; torque_gear_N is a gear against all, with its "
      "losses and an error of its ratio");
  const EngineWindows& w = a.windows;
  remarks.push_back(fmt::format(
      "engine speed {}", w.engine_speed  ? "as recorded"
                         : w.wheel_speed ? "by the driven wheels and the gears"
                                         : "by the car's speed: slip of the tyres is in it"));
  remarks.push_back(fmt::format(
      "left out: {} windows {}, {} turning, {} shifting or of unknown gear, {} with engine and "
      "wheels out of step, {} below idle, in the clutch or at the limiter",
      w.braked,
      w.pressures ? "braked" : "with less than a tenth of throttle (no pressures of the brakes)",
      w.turning, w.gear_unknown, w.out_of_step, w.limited));
  if (a.car.terms[Term::turbo_lag] > 0.0)
    remarks.emplace_back(
        "torques are those of full boost; how boost grows is the vehicle file's word (turbo.share "
        "by its prior)");
  std::size_t unseen = 0;
  for (const EngineCell& cell : out.cells) unseen += cell.unseen.empty() ? 0 : 1;
  remarks.push_back(
      fmt::format("not observable: {} of {} places of the map", unseen, out.cells.size()));
  remarks.emplace_back(
      "not observable: fuel, idle control, limiter, torque while shifting, boost by itself");
}

}  // namespace

EngineFit fit_engine(const vehicle::Car<double>& car, const Prior& prior, const DriveWindows& drive,
                     const recording::Recording& recording, const EngineFitOptions& options) {
  if (car.files->turbo == vehicle::Turbo::kFull)
    throw base::Error(
        "the vehicle's engine is the full turbocharged one, whose torque is no map: wanted "
        "turbo: first_order");
  const auto& p = car.parameters;
  const bool weighed = options.mass_kg > 0.0;
  EngineGranted is;
  is.mass_kg = weighed ? options.mass_kg : p[P::chassis_mass_kg] + options.fuel_kg;
  const double mass_sd_kg =
      weighed ? options.mass_sd_kg
              : 0.5 * prior[static_cast<std::size_t>(P::chassis_mass_kg)] * p[P::chassis_mass_kg];
  const bool by_speed =
      !drive.accelerations || (options.body_axes && !drive.loads && !drive.travels);
  const EngineWindows windows = engine_windows(car, drive, recording, options);
  std::set<std::size_t> blocks;
  for (const EngineWindow& e : windows.windows) blocks.insert(e.window->block);
  const vehicle::Map2 stated = stated_torque_map(car);
  EngineFit out;
  out.engine_radps = stated.x;
  out.throttle = stated.y;
  if (windows.windows.size() < 20 || blocks.size() < 6)
    throw base::Error(fmt::format(
        "not observable: the engine: {} windows of 0.5 s at {} places of the road in one known "
        "gear, unbraked and hardly turning; wanted 20 at 6 ({} braked, {} turning, {} of unknown "
        "gear, {} out of step, {} at the limiter or near idle)",
        windows.windows.size(), blocks.size(), windows.braked, windows.turning,
        windows.gear_unknown, windows.out_of_step, windows.limited));
  const Asked asked{car, prior, windows, by_speed, is, mass_sd_kg};
  const EngineSolved s = solve_engine(asked, stated);
  out.fit.windows = windows.windows.size();
  out.fit.blocks = s.fit.blocks;
  find_places(s, stated, windows, recording.step_s, options, out);
  find_factors(s, windows, out);
  say_engine(asked, options, out);
  out.fit.doubts = s.doubts;
  const Found& factor = out.fit.at("torque");
  if (factor.unseen.empty() && !(factor.value > 0.1))
    out.fit.doubts.push_back(fmt::format(
        "the engine gives {:.2g} of the vehicle file's torque: another car, throttle in another "
        "unit, or the sign of ax_mps2?",
        factor.value));
  return out;
}

vehicle::Map2 engine_map_of(const EngineFit& fit) {
  vehicle::Map2 out{fit.engine_radps, fit.throttle, {}};
  for (const EngineCell& cell : fit.cells) out.z.push_back(cell.torque_nm);
  return out;
}

}  // namespace identify
