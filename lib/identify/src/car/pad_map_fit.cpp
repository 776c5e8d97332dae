#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "brakes_rows.h"
#include "identify/drive_fits.h"
#include "map_fit.h"
#include "recording/channels.h"
#include "vehicle/laws/brake_pads.h"

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

/// Unknowns: friction at the map's places less the stated one; the two axles' factors less 1.
MapEquations equations(const vehicle::Car<double>& car, const Windows& windows,
                       const vehicle::Map2& stated, bool by_speed, const Granted& granted) {
  const auto places = static_cast<Index>(stated.z.size());
  MapEquations out{MatrixXd::Zero(static_cast<Index>(windows.size()), places + 2),
                   VectorXd::Zero(static_cast<Index>(windows.size()))};
  const std::array<double, 2> share{axle_share(car, stated, 0), axle_share(car, stated, 1)};
  for (Index r = 0; r < out.rows.rows(); ++r) {
    const DriveWindow& w = *windows[static_cast<std::size_t>(r)];
    double given = 0.0;
    for (std::size_t i = 0; i < kWheels; ++i) {
      const std::size_t a = vehicle::axle_of(i);
      const double pressure = std::max(0.0, w.brake_pa[i]);
      const double per_friction =
          share[a] *
          vehicle::laws::brake_torque(1.0, pressure, car.parameters.axle(a, P::front_brake_area_m2),
                                      car.parameters.axle(a, P::front_brake_radius_m)) /
          force_arm(car, w, a, granted.mass_kg);
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
  out.topLeftCorner(size.size(), size.size()) = map_covariance(stated.x, stated.y, size);
  const double half = 0.5 * kAxleShare * kAxleShare;  // the map is that of the mean of both
  out.bottomRightCorner(2, 2) << half, -half, -half, half;
  return out;
}

void find(const Windows& windows, const vehicle::Map2& stated, const MapSolved& s, double seconds,
          PadMapFit& out) {
  PlaceFinder finder(stated, s, 1, out);
  for (const DriveWindow* w : windows)
    for (std::size_t i = 0; i < kWheels; ++i)
      finder.near(std::max(0.0, w->brake_pa[i]), w->disc_k[i], 0, seconds, w->block);
  finder.hide(0.0, "of wheels ", "");
  for (std::size_t a = 0; a < 2; ++a) {
    Found f =
        map_factor(fmt::format("{}_pads", recording::kAxleNames[a]),
                   VectorXd::Unit(s.fit.value.size(), static_cast<Index>(stated.z.size() + a)), s);
    if (f.within > 0.8 * base::kNormal90 * kAxleShare * std::sqrt(0.5))
      f.unseen = "front and rear pressures go together: no more is known of it than before";
    out.fit.found.push_back(std::move(f));
  }
}

}  // namespace

PadMapFit fit_pad_map(const vehicle::Car<double>& car, const Prior& prior,
                      const DriveWindows& drive, const WeighedOptions& options) {
  PadMapFit out;
  Windows windows;
  std::size_t without = 0;
  std::vector<std::size_t> block;
  for (const DriveWindow& w : drive.windows) {
    if (!brakes_count(car, w)) continue;
    if (!std::isfinite(w.disc_k[0] + w.disc_k[1] + w.disc_k[2] + w.disc_k[3])) {
      ++without;
      continue;
    }
    windows.push_back(&w);
    block.push_back(w.block);
  }
  out.fit.windows = windows.size();
  out.fit.blocks = blocks_of(windows);
  if (windows.size() < 10 || out.fit.blocks < 5) {
    out.fit.remarks.push_back(
        fmt::format("not observable: friction over pressure and temperature: {} braked windows at "
                    "{} places with "
                    "temperatures of all discs, wanted 10 at 5; {} without temperatures",
                    windows.size(), out.fit.blocks, without));
    return out;
  }
  const vehicle::Map2 stated = stated_pad_map(car);
  if (stated.z.size() > kMostMapPlaces) {
    out.fit.remarks.push_back(fmt::format(
        "not observable: friction over pressure and temperature: the vehicle file's map has {} "
        "places, wanted {} at most: give one with a coarser map",
        stated.z.size(), kMostMapPlaces));
    return out;
  }
  const Along along(car, prior, drive, options);
  const MatrixXd held = pads_held_by(stated);
  const auto equations_of = [&](const vehicle::Car<double>& other, const Granted& granted) {
    return equations(other, windows, stated, along.by_speed, granted);
  };
  const MapEquations e = equations_of(car, along.is);
  MapSolved solved{map_fit(e.rows, e.wanted, block, held), {}};
  solved.granted = along.granted_covariance(
      {}, brakes_moved(along), [&](const vehicle::Car<double>& other, const Granted& granted) {
        const MapEquations of = equations_of(other, granted);
        return map_fit_again(of.rows, of.wanted, held, solved.fit);
      });
  find(windows, stated, solved, 0.5, out);
  out.fit.remarks.emplace_back(
      "areas and radii of the brakes are the vehicle file's: the map has what is wrong of them");
  return out;
}

}  // namespace identify
