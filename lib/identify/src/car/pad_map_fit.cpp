#include "identify/pad_map_fit.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <set>

#include "brakes_rows.h"
#include "identify/clustered_fit.h"
#include "longitudinal.h"
#include "map_fit.h"
#include "window_fit.h"

namespace identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using vehicle::kWheels;
using P = vehicle::Parameter;
using vehicle::Term;
constexpr double kAxleShare = 0.05;  ///< standard deviation of one axle against the other

/// The vehicle file's map, or its friction at even places.
vehicle::Map2 stated_pad_map(const vehicle::Car<double>& car) {
  const vehicle::Map2& map = car.files->pad_friction;
  if (map.x.size() > 1 && map.y.size() > 1 && car.terms[Term::brake_friction_temperature] > 0.0)
    return map;
  vehicle::Map2 out{{0.0, 2e6, 4e6, 6e6, 9e6}, {280.0, 400.0, 600.0, 800.0, 1000.0, 1200.0}, {}};
  const double mean = 0.5 * (car.parameters.axle(0, P::front_brake_friction) +
                             car.parameters.axle(1, P::front_brake_friction));
  out.z.assign(out.x.size() * out.y.size(), mean);
  return out;
}

/// Of the vehicle file's friction of an axle over the map's: 1 where the map acts.
double axle_share(const vehicle::Car<double>& car, const vehicle::Map2& stated, std::size_t axle) {
  const bool acts =
      !car.files->pad_friction.empty() && car.terms[Term::brake_friction_temperature] > 0.0;
  return acts ? 1.0 : car.parameters.axle(axle, P::front_brake_friction) / stated.z.front();
}

struct Equations {
  MatrixXd rows;
  VectorXd wanted;
};

/// Unknowns: friction at the map's places less the stated one; the two axles' factors less 1.
Equations equations(const vehicle::Car<double>& car, const Windows& windows,
                    const vehicle::Map2& stated, bool by_speed, const BrakesGranted& granted) {
  const auto places = static_cast<Index>(stated.z.size());
  Equations out{MatrixXd::Zero(static_cast<Index>(windows.size()), places + 2),
                VectorXd::Zero(static_cast<Index>(windows.size()))};
  const std::array<double, 2> share{axle_share(car, stated, 0), axle_share(car, stated, 1)};
  for (Index r = 0; r < out.rows.rows(); ++r) {
    const DriveWindow& w = *windows[static_cast<std::size_t>(r)];
    double given = 0.0;
    for (std::size_t i = 0; i < kWheels; ++i) {
      const std::size_t a = vehicle::axle_of(i);
      const double pressure = std::max(0.0, w.brake_pa[i]);
      const double per_friction =
          share[a] * 2.0 * pressure * car.parameters.axle(a, P::front_brake_area_m2) *
          car.parameters.axle(a, P::front_brake_radius_m) / force_arm(car, w, a, granted.mass_kg);
      for (const auto& [place, weight] : map_weights(stated.x, stated.y, pressure, w.disc_k[i]))
        out.rows(r, static_cast<Index>(place)) += per_friction * weight;
      const double force = per_friction * vehicle::evaluate(stated, pressure, w.disc_k[i]);
      out.rows(r, places + static_cast<Index>(a)) += force;
      given += force;
    }
    out.wanted(r) = braking_force(car, w, by_speed, granted) - given;
  }
  return out;
}

MatrixXd pads_held_by(const vehicle::Map2& stated) {
  const Eigen::Map<const VectorXd> size(stated.z.data(), static_cast<Index>(stated.z.size()));
  MatrixXd out = MatrixXd::Zero(size.size() + 2, size.size() + 2);
  out.topLeftCorner(size.size(), size.size()) = map_covariance(stated.x, stated.y, size, {});
  const double half = 0.5 * kAxleShare * kAxleShare;  // the map is that of the mean of both
  out.bottomRightCorner(2, 2) << half, -half, -half, half;
  return out;
}

void find(const Windows& windows, const vehicle::Map2& stated, const MapFit& fit,
          const MatrixXd& granted, double seconds, const PadMapOptions& options, PadMapFit& out) {
  const double freedom = static_cast<double>(fit.blocks) - 2.0;
  std::vector<std::set<std::size_t>> from(stated.z.size());
  for (std::size_t k = 0; k < stated.z.size(); ++k) {
    const auto i = static_cast<Index>(k);
    const double drive = fit.noise(i, i), file = fit.prior_left(i, i) + granted(i, i);
    out.cells.push_back({stated.x[k / stated.y.size()], stated.y[k % stated.y.size()],
                         stated.z[k] + fit.value(i), std::sqrt(drive + file),
                         half_width_90(freedom, std::sqrt(drive), std::sqrt(file)), stated.z[k],
                         0.0, std::string()});
  }
  for (const DriveWindow* w : windows)
    for (std::size_t i = 0; i < kWheels; ++i)
      for (const auto& [place, weight] :
           map_weights(stated.x, stated.y, std::max(0.0, w->brake_pa[i]), w->disc_k[i])) {
        out.cells[place].seconds += weight * seconds;
        if (weight > 0.2) from[place].insert(w->block);
      }
  for (std::size_t k = 0; k < out.cells.size(); ++k) {
    PadCell& cell = out.cells[k];
    if (cell.seconds < options.least_seconds || from[k].size() < 2)
      cell.unseen = fmt::format("{:.1f} s of wheels near it, at {} places of the road",
                                cell.seconds, from[k].size());
    else if (cell.within > options.most_share * std::abs(cell.friction))
      cell.unseen = fmt::format("its 90 % interval would be {:.2g} either way", cell.within);
  }
  for (std::size_t a = 0; a < 2; ++a) {
    const auto i = static_cast<Index>(stated.z.size() + a);
    const double drive = fit.noise(i, i), file = fit.prior_left(i, i) + granted(i, i);
    Found f{a == 0 ? "front_pads" : "rear_pads", "1", 1.0 + fit.value(i), 0, 0, 0, 1.0, {}};
    f.sd_drive = std::sqrt(drive);
    f.sd = std::sqrt(drive + file);
    f.within = half_width_90(freedom, f.sd_drive, std::sqrt(file));
    if (f.within > 0.8 * kNormal90 * kAxleShare * std::sqrt(0.5))
      f.unseen = "front and rear pressures go together: no more is known of it than before";
    out.fit.found.push_back(std::move(f));
  }
}

}  // namespace

PadMapFit fit_pad_map(const vehicle::Car<double>& car,
                      const std::array<double, vehicle::kParameterCount>& prior,
                      const DriveWindows& drive, const BrakesFitOptions& options,
                      const PadMapOptions& map_options) {
  const auto sd_share = [&](P parameter) {
    return 0.5 * prior[static_cast<std::size_t>(parameter)];
  };
  const auto& p = car.parameters;
  const bool weighed = options.mass_kg > 0.0;
  const double mass_kg = weighed ? options.mass_kg : p[P::chassis_mass_kg] + options.fuel_kg;
  const double mass_sd_kg =
      weighed ? options.mass_sd_kg : sd_share(P::chassis_mass_kg) * p[P::chassis_mass_kg];
  PadMapFit out;
  Windows windows;
  std::size_t without = 0;
  std::set<std::size_t> blocks;
  std::vector<std::size_t> block;
  for (const DriveWindow& w : drive.windows) {
    if (!brakes_count(car, w, options)) continue;
    if (!std::isfinite(w.disc_k[0] + w.disc_k[1] + w.disc_k[2] + w.disc_k[3])) {
      ++without;
      continue;
    }
    windows.push_back(&w);
    blocks.insert(w.block);
    block.push_back(w.block);
  }
  out.fit.windows = windows.size();
  out.fit.blocks = blocks.size();
  if (windows.size() < 10 || blocks.size() < 5) {
    out.fit.remarks.push_back(
        fmt::format("not observable: friction over pressure and temperature: {} braked windows at "
                    "{} places with "
                    "temperatures of all discs, wanted 10 at 5; {} without temperatures",
                    windows.size(), blocks.size(), without));
    return out;
  }
  const bool by_speed =
      !drive.accelerations || (options.body_axes && !drive.loads && !drive.travels);
  const vehicle::Map2 stated = stated_pad_map(car);
  if (stated.z.size() > kMostMapPlaces) {
    out.fit.remarks.push_back(fmt::format(
        "not observable: friction over pressure and temperature: the vehicle file's map has {} "
        "places, wanted {} at most: give one with a coarser map",
        stated.z.size(), kMostMapPlaces));
    return out;
  }
  out.pressure_pa = stated.x;
  out.surface_k = stated.y;
  const MatrixXd held = pads_held_by(stated);
  const BrakesGranted is{mass_kg, 1.0, 1.0, 1.0, 0.0};
  const Equations e = equations(car, windows, stated, by_speed, is);
  const MapFit fit = map_fit(e.rows, e.wanted, block, held);
  MatrixXd granted = MatrixXd::Zero(held.rows(), held.cols());
  const VectorXd value = map_fit_again(e.rows, e.wanted, held, fit);
  const auto add = [&](const vehicle::Car<double>& other, const BrakesGranted& g) {
    const Equations moved = equations(other, windows, stated, by_speed, g);
    const VectorXd off = map_fit_again(moved.rows, moved.wanted, held, fit) - value;
    granted += off * off.transpose();
  };
  for (const BrakesGranted& g : brakes_granted(mass_kg, mass_sd_kg, sd_share(P::aero_drag_area_m2)))
    add(car, g);
  if (const auto other = other_arm(car)) add(other->car, is);
  find(windows, stated, fit, granted, 0.5, map_options, out);
  out.fit.remarks.emplace_back(
      "areas and radii of the brakes are the vehicle file's: the map has what is wrong of them");
  return out;
}

vehicle::Map2 pad_map_of(const PadMapFit& fit) {
  vehicle::Map2 out{fit.pressure_pa, fit.surface_k, {}};
  for (const PadCell& cell : fit.cells) out.z.push_back(cell.friction);
  return out;
}

}  // namespace identify
