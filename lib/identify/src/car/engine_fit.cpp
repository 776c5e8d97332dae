#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>

#include "base/error.h"
#include "engine_rows.h"
#include "identify/drive_fits.h"

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

Eigen::Map<const VectorXd> torques_of(const vehicle::Map2& map) {
  return {map.z.data(), static_cast<Index>(map.z.size())};
}

struct EngineSolved : MapSolved {
  vehicle::Map2 torque_nm;  ///< that the deviations are from
  std::vector<std::string> doubts;
};

struct Asked : Along {
  const EngineWindows& windows;

  EngineEquations equations(const vehicle::Map2& torque_nm, const vehicle::Car<double>& of,
                            const Granted& granted) const {
    return engine_equations(of, windows, torque_nm, by_speed, granted);
  }
};

/// What was taken for granted in all fits of the engine.
constexpr std::pair<double Granted::*, double> kRolling{&Granted::rolling, kRollingShare},
    kOffset{&Granted::offset_mps2, kOffset_mps2}, kSide{&Granted::side, kSideShare};

MatrixXd granted_of(const Asked& a, const EngineSolved& s, const MatrixXd& held) {
  std::vector<P> leaned{P::aero_drag_area_m2, P::engine_inertia_kgm2, P::rear_wheel_inertia_kgm2,
                        P::front_wheel_inertia_kgm2, P::gearbox_efficiency};
  if (a.car.terms[Term::turbo_lag] > 0.0) leaned.push_back(P::turbo_share);
  return a.granted_covariance(
      leaned, a.moved({{&Granted::mass_kg, a.mass_sd_kg}, kRolling, kOffset, kSide}),
      [&](const vehicle::Car<double>& car, const Granted& granted) {
        const MapEquations e = a.equations(s.torque_nm, car, granted);
        return map_fit_again(e.rows, e.wanted, held, s.fit);
      });
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
  const EngineEquations is = a.equations(s.torque_nm, a.car, a.is);
  const MapFit fit = map_fit(with_both(is), is.wanted + is.rows * from_stated, block, wide);
  VectorXd variance = fit.noise.diagonal() + fit.prior_left.diagonal();
  const VectorXd same = map_fit_again(with_both(is), is.wanted + is.rows * from_stated, wide, fit);
  for (const Granted& moved : a.moved({{&Granted::mass_kg, a.mass_sd_kg}, kRolling, kOffset})) {
    const EngineEquations e = a.equations(s.torque_nm, a.car, moved);
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
  const VectorXd size = torques_of(stated).cwiseAbs().array() + 0.1 * most;
  const auto gears = static_cast<Index>(windows.gears);
  MatrixXd out = MatrixXd::Zero(size.size() + gears, size.size() + gears);
  out.topLeftCorner(size.size(), size.size()) = map_covariance(stated.x, stated.y, size);
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
  EngineSolved s;
  s.torque_nm = stated;
  VectorXd before = VectorXd::Zero(held.rows());
  const Index places = static_cast<Index>(stated.z.size());
  for (int round = 0; round < 3; ++round) {
    const EngineEquations e = a.equations(s.torque_nm, a.car, a.is);
    // The prior is about the stated map: what the last round added counts as wanted again.
    before.head(places) = torques_of(s.torque_nm) - torques_of(stated);
    s.fit = map_fit(e.rows, e.wanted + e.rows * before, block, held);
    if (round == 2) break;
    const VectorXd now = torques_of(stated) + s.fit.value.head(places);
    s.torque_nm.z.assign(now.begin(), now.end());
  }
  s.granted = granted_of(a, s, held);
  s.doubts = contradicted(a, s, before, held, block);
  return s;
}

void find_places(const EngineSolved& s, const vehicle::Map2& stated, const EngineWindows& windows,
                 double step_s, EngineFit& out) {
  PlaceFinder finder(stated, s, windows.gears, out);
  for (const EngineWindow& e : windows.windows)
    for (const EngineRow& row : e.rows)
      finder.near(row.engine_radps, row.throttle, static_cast<std::size_t>(e.gear - 1), step_s,
                  e.window->block);
  finder.hide(0.25 * *std::max_element(stated.z.begin(), stated.z.end()), "", " N m");
}

/// The found over the stated map, and each gear over the map of all.
void find_factors(const EngineSolved& s, const EngineWindows& windows, EngineFit& out) {
  const auto places = static_cast<Index>(out.places.size());
  VectorXd slope = VectorXd::Zero(places + static_cast<Index>(windows.gears));
  for (Index k = 0; k < places; ++k) {
    const MapPlace& place = out.places[static_cast<std::size_t>(k)];
    if (place.seen()) slope(k) = place.stated;
  }
  const double square = slope.squaredNorm();
  out.fit.found.push_back(map_factor("torque", square > 0.0 ? VectorXd(slope / square) : slope, s));
  if (!(square > 0.0)) out.fit.found.back().unseen = "no place of the map is seen";
  const auto in_gear = driven_in(windows);
  for (std::size_t g = 0; g < in_gear.size(); ++g) {
    Found f = map_factor(fmt::format("torque_gear_{}", g + 1),
                         VectorXd::Unit(slope.size(), places + static_cast<Index>(g)), s);
    if (in_gear[g] < 6)
      f.unseen = fmt::format("{} windows in this gear, wanted 6", in_gear[g]);
    else if (f.within > 0.8 * base::kNormal90 * kGearShare)
      f.unseen = "gears and places of the map go together: no more is known of it than before";
    out.fit.found.push_back(std::move(f));
  }
}

void say_engine(const Asked& a, EngineFit& out) {
  auto& remarks = out.fit.remarks;
  remarks.push_back(a.mass_words("torques are"));
  Windows driven;
  for (const EngineWindow& window : a.windows.windows) driven.push_back(window.window);
  remarks.push_back(a.arm_words(driven));
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
  remarks.push_back(
      fmt::format("not observable: {} of {} places of the map",
                  std::count_if(out.places.begin(), out.places.end(), std::not_fn(&MapPlace::seen)),
                  out.places.size()));
  remarks.emplace_back(
      "not observable: fuel, idle control, limiter, torque while shifting, boost by itself");
}

}  // namespace

EngineFit fit_engine(const vehicle::Car<double>& car, const Prior& prior, const DriveWindows& drive,
                     const recording::Recording& recording, const WeighedOptions& options) {
  if (car.files->turbo == vehicle::Turbo::kFull)
    throw base::Error(
        "the vehicle's engine is the full turbocharged one, whose torque is no map: wanted "
        "turbo: first_order");
  const EngineWindows windows = engine_windows(car, drive, recording);
  std::set<std::size_t> blocks;
  for (const EngineWindow& e : windows.windows) blocks.insert(e.window->block);
  const vehicle::Map2 stated = stated_torque_map(car);
  if (windows.windows.size() < 20 || blocks.size() < 6)
    throw base::Error(fmt::format(
        "not observable: the engine: {} windows of 0.5 s at {} places of the road in one known "
        "gear, unbraked and hardly turning; wanted 20 at 6 ({} braked, {} turning, {} of unknown "
        "gear, {} out of step, {} at the limiter or near idle)",
        windows.windows.size(), blocks.size(), windows.braked, windows.turning,
        windows.gear_unknown, windows.out_of_step, windows.limited));
  const Asked asked{{car, prior, drive, options}, windows};
  const EngineSolved s = solve_engine(asked, stated);
  EngineFit out;
  out.fit.windows = windows.windows.size();
  out.fit.blocks = s.fit.blocks;
  find_places(s, stated, windows, recording.step_s, out);
  find_factors(s, windows, out);
  say_engine(asked, out);
  out.fit.doubts = s.doubts;
  const Found& factor = out.fit.at("torque");
  if (factor.unseen.empty() && !(factor.value > 0.1))
    out.fit.doubts.push_back(fmt::format(
        "the engine gives {:.2g} of the vehicle file's torque: another car, throttle in another "
        "unit, or the sign of ax_mps2?",
        factor.value));
  return out;
}

}  // namespace identify
