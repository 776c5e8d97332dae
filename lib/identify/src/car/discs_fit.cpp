#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/statistics.h"
#include "drive_columns.h"
#include "identify/drive_fits.h"
#include "identify/least_squares.h"
#include "recording/channels.h"
#include "vehicle/laws/brake_pads.h"
#include "vehicle/laws/disc_heat.h"
#include "window_fit.h"

namespace identify {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;
constexpr std::array<P, 4> kOf{P::front_disc_surface_capacity_jpk, P::front_disc_core_capacity_jpk,
                               P::front_disc_conductance_wpk, P::front_disc_area_m2};
constexpr std::array<const char*, 4> kKeys{"disc_surface_capacity_jpk", "disc_core_capacity_jpk",
                                           "disc_conductance_wpk", "disc_area_m2"};
constexpr std::array<const char*, 4> kUnits{"J/K", "J/K", "W/K", "m2"};
constexpr double kStep_s = 0.02;       ///< surfaces settle within seconds
constexpr double kTogether_s = 15.0;   ///< errors this near go together
constexpr double kEvery_s = 0.2;       ///< temperatures are compared so often
constexpr double kLeast_s = 150.0;     ///< of one stretch without a gap
constexpr double kLeastRise_k = 60.0;  ///< temperatures must vary by so much

/// Channels of one wheel.
struct Wheel {
  Column pressure = nullptr, disc = nullptr, spin = nullptr;
};

/// One row, as the disc feels it until the next.
struct Fed {
  double time_s = 0.0, vx_mps = 0.0, spin_radps = 0.0, brake_nm = 0.0, seen_k = 0.0;
};

Wheel wheel_of(const recording::Table& table, std::size_t wheel) {
  const std::string name = recording::kWheelNames[wheel];
  Wheel out{table.find("brake_" + name + "_pa"), table.find("brake_disc_" + name + "_k"),
            table.find("wheel_" + name + "_radps")};
  if (out.pressure == nullptr) out.pressure = table.find("brake_pa");
  return out;
}

recording::Stretch longest_of(const recording::Recording& recording,
                              const std::vector<double>& time) {
  recording::Stretch out;
  double longest = -1.0;
  for (const recording::Stretch& s : recording.stretches) {
    if (s.begin >= s.end || time[s.end - 1] - time[s.begin] <= longest) continue;
    longest = time[s.end - 1] - time[s.begin];
    out = s;
  }
  return out;
}

/// The rows of a wheel that have everything; a missing temperature is NaN.
std::vector<Fed> fed_of(const vehicle::Car<double>& car, const recording::Table& table,
                        const recording::Stretch& stretch, std::size_t wheel, double torque) {
  const Wheel w = wheel_of(table, wheel);
  const std::vector<double>&time = *table.find("time_s"), &vx = *table.find("vx_mps");
  const std::size_t a = vehicle::axle_of(wheel);
  const auto& p = car.parameters;
  std::vector<Fed> out;
  constexpr double kNone = -1.0;
  double last_k = kNone;
  for (std::size_t k = stretch.begin; k < stretch.end; ++k) {
    const double spin = w.spin != nullptr ? (*w.spin)[k] : vx[k] / car.static_radius_m[a];
    const double pressure = std::max(0.0, (*w.pressure)[k]);
    if (!std::isfinite(spin + (*w.pressure)[k] + vx[k])) continue;
    const double seen = (*w.disc)[k];
    if (std::isfinite(seen)) last_k = seen;
    if (last_k == kNone) continue;  // no temperature yet
    const double friction = vehicle::laws::pad_friction(p.axle(a, P::front_brake_friction),
                                                        car.terms[Term::brake_friction_temperature],
                                                        car.files->pad_friction, pressure, last_k);
    out.push_back({time[k], vx[k], spin,
                   -torque * vehicle::laws::brake_torque(friction, pressure,
                                                         p.axle(a, P::front_brake_area_m2),
                                                         p.axle(a, P::front_brake_radius_m)),
                   seen});
  }
  return out;
}

/// Simulated less recorded temperatures of both wheels of an axle. Values: factors of the four
/// parameters, then surface and core at the begin, left and right.
struct Model {
  const vehicle::Car<double>& car;
  std::size_t axle;
  std::vector<std::vector<Fed>> fed;  ///< of the wheels whose disc was measured

  void left_over(const std::vector<double>& value, std::vector<double>& left,
                 std::vector<std::size_t>* block = nullptr) const {
    auto disc = vehicle::laws::disc_parameters(car.parameters, axle);
    disc.surface_capacity_jpk *= value[0];
    disc.core_capacity_jpk *= value[1];
    disc.conductance_wpk *= value[2];
    disc.area_m2 *= value[3];
    const auto on = [&](Term term) { return car.terms[term]; };
    const vehicle::laws::DiscAmounts<double> amount{
        on(Term::brake_heating), on(Term::brake_conduction), on(Term::brake_convection),
        on(Term::brake_vanes),   on(Term::brake_radiation),  on(Term::brake_heat_capacity)};
    left.clear();
    for (std::size_t side = 0; side < fed.size(); ++side) {
      double surface = value[4 + 2 * side], core = value[5 + 2 * side];
      const std::vector<Fed>& rows = fed[side];
      double next_s = rows.front().time_s;
      for (std::size_t k = 0; k < rows.size(); ++k) {
        if (rows[k].time_s >= next_s && std::isfinite(rows[k].seen_k)) {
          left.push_back(surface - rows[k].seen_k);
          next_s = rows[k].time_s + kEvery_s;
          if (block != nullptr)
            block->push_back(
                static_cast<std::size_t>((rows[k].time_s - rows.front().time_s) / kTogether_s));
        }
        if (k + 1 == rows.size()) break;
        const Fed &a = rows[k], &b = rows[k + 1];
        const double span = b.time_s - a.time_s;
        const int steps = std::max(1, static_cast<int>(std::ceil(span / kStep_s - 1e-6)));
        for (int i = 0; i < steps; ++i) {
          const double way = (i + 0.5) / steps;
          const auto mix = [&](double Fed::*of) { return a.*of + way * (b.*of - a.*of); };
          const auto air = vehicle::laws::disc_air(disc, amount, std::abs(mix(&Fed::vx_mps)));
          const auto rate = vehicle::laws::disc_heat(
              disc, amount, surface, core, mix(&Fed::brake_nm), mix(&Fed::spin_radps), air);
          surface += rate.surface_kps * span / steps;
          core += rate.core_kps * span / steps;
        }
      }
    }
  }
};

std::string disc_channel_missing(const recording::Recording& recording, std::size_t axle) {
  const recording::Table& table = recording.table;
  if (table.find("vx_mps") == nullptr) return "no vx_mps";
  const Wheel left = wheel_of(table, 2 * axle), right = wheel_of(table, 2 * axle + 1);
  if (left.disc == nullptr && right.disc == nullptr)
    return fmt::format("no temperatures of these discs (brake_disc_{}_k ...)",
                       recording::kWheelNames[2 * axle]);
  if (left.pressure == nullptr || right.pressure == nullptr) return "no pressures of the brakes";
  return {};
}

void empty_axle(std::size_t axle, const vehicle::Car<double>& car, const std::string& why,
                DriveFit& out) {
  for (std::size_t k = 0; k < kOf.size(); ++k)
    out.found.push_back(found_of(fmt::format("{}_{}", recording::kAxleNames[axle], kKeys[k]),
                                 kUnits[k], car.parameters.axle(axle, kOf[k]), why));
}

/// The unknowns where the search begins.
std::vector<Unknown> unknowns_of(const Model& model) {
  std::vector<Unknown> out;
  out.reserve(kKeys.size() + 2 * model.fed.size());
  for (const char* const key : kKeys) out.push_back({key, 1.0, 0.1, 10.0, 1.0});
  for (const auto& rows : model.fed) {
    double first = rows.front().seen_k;
    for (const Fed& f : rows)
      if (std::isfinite(f.seen_k)) {
        first = f.seen_k;
        break;
      }
    out.push_back({"surface", first, 200.0, 2000.0, 100.0});
    out.push_back({"core", first, 200.0, 2000.0, 100.0});
  }
  return out;
}

/// Covariance of the unknowns at the least sum of squares, by leaving out stretches of time.
base::Answer<ClusteredFit> around(const Model& model, const std::vector<Unknown>& unknowns) {
  std::vector<double> at, left, moved;
  for (const Unknown& u : unknowns) at.push_back(u.value);
  std::vector<std::size_t> block;
  model.left_over(at, left, &block);
  Equation e;
  for (std::size_t k = 0; k < at.size(); ++k) {
    std::vector<double> other = at;
    const double by = 1e-4 * unknowns[k].typical;
    other[k] += by;
    model.left_over(other, moved);
    for (std::size_t r = 0; r < moved.size(); ++r) moved[r] = (moved[r] - left[r]) / by;
    e.columns.push_back(moved);
  }
  for (double& v : left) v = -v;
  e.wanted = left;
  return clustered_fit({e}, block);
}

void find_discs(const vehicle::Car<double>& car, double heat_sd, const Model& model,
                const DiscsFitOptions& options, DriveFit& out) {
  std::vector<Unknown> unknowns = unknowns_of(model);
  const LeastSquares fitted = least_squares(
      unknowns,
      [&](const std::vector<double>& v, std::vector<double>& left) { model.left_over(v, left); });
  std::string why = fitted.converged ? std::string() : "the search did not end";
  const auto spread = around(model, unknowns);
  if (!spread) why = spread.refusal().message;
  empty_axle(model.axle, car, why, out);
  if (!why.empty()) return;
  const ClusteredFit& fit = *spread;
  const double freedom = static_cast<double>(fit.blocks) - static_cast<double>(unknowns.size());
  for (std::size_t k = 0; k < kOf.size(); ++k) {
    Found& f = out.found[out.found.size() - kOf.size() + k];
    const double value = unknowns[k].value * f.stated;
    set_found(f, value, freedom, fit.sd(k) * f.stated,
              value * std::hypot(options.torque_sd, heat_sd));
    hide_wide(f);
    if (f.unseen.empty() && (unknowns[k].value < 0.11 || unknowns[k].value > 9.9))
      f.unseen = "more than ten times, or less than a tenth, of the vehicle file's";
  }
  out.remarks.push_back(
      fmt::format("{} discs: simulated and recorded temperatures differ by {:.1f} K "
                  "(root mean square)",
                  recording::kAxleNames[model.axle], fitted.rms));
  if (fitted.rms > 40.0)
    out.doubts.push_back(fmt::format(
        "the {} discs' temperatures are missed by {:.0f} K: another place on the disc, another "
        "unit, or a clock of their own?",
        recording::kAxleNames[model.axle], fitted.rms));
}

}  // namespace

DriveFit fit_discs(const vehicle::Car<double>& car, const Prior& prior,
                   const recording::Recording& recording, const DiscsFitOptions& options) {
  DriveFit out;
  for (std::size_t a = 0; a < 2; ++a) {
    if (const std::string why = disc_channel_missing(recording, a); !why.empty()) {
      empty_axle(a, car, why, out);
      continue;
    }
    const std::vector<double>& time = *recording.table.find("time_s");
    const recording::Stretch stretch = longest_of(recording, time);
    Model model{car, a, {}};
    std::vector<double> seen;
    double seconds = 1e9;
    for (std::size_t i = 2 * a; i < 2 * a + 2; ++i) {
      if (wheel_of(recording.table, i).disc == nullptr) continue;
      model.fed.push_back(fed_of(car, recording.table, stretch, i, options.torque[a]));
      const std::vector<Fed>& rows = model.fed.back();
      seconds = std::min(seconds, rows.empty() ? 0.0 : rows.back().time_s - rows.front().time_s);
      for (const Fed& f : rows)
        if (std::isfinite(f.seen_k)) seen.push_back(f.seen_k);
    }
    if (seconds < kLeast_s) {
      empty_axle(a, car, fmt::format("{:.0f} s without a gap, wanted {:.0f}", seconds, kLeast_s),
                 out);
      continue;
    }
    const double rise = base::quantile(seen, 0.98) - base::quantile(seen, 0.02);
    if (rise < kLeastRise_k) {
      empty_axle(a, car,
                 fmt::format("temperatures vary by {:.0f} K, wanted {:.0f}", rise, kLeastRise_k),
                 out);
      continue;
    }
    find_discs(car, share_sd(prior, P::brake_disc_share), model, options, out);
  }
  out.remarks.emplace_back(
      "the discs' heat is pressure times friction times speed, and brake.disc_share of it "
      "(standard "
      "deviation by its prior); capacities, conductances and cooling are as wrong as that product");
  out.remarks.emplace_back(
      "recorded temperatures are taken as those of the friction layers: the lag of a sensor looks "
      "like more capacity of the surface");
  out.remarks.emplace_back(
      "not observable: convection and radiation apart, the laws' other numbers; disc_area_m2 "
      "stands "
      "for all cooling");
  return out;
}

}  // namespace identify
