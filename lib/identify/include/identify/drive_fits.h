// What is found about a car from one drive: numbers with intervals, or why there is none; and the
// fits that find it. A fit's sheet has lines of a setup sheet, a remark for what was not found.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/answer.h"
#include "identify/drive_windows.h"
#include "vehicle/map.h"

namespace identify {

/// A number that was found, or why it was not.
struct Found {
  std::string name, unit;
  double value = 0.0;
  double sd = 0.0;        ///< of everything that is counted
  double sd_drive = 0.0;  ///< of it what the drive leaves open; the rest is the vehicle file's
  double within = 0.0;    ///< half the 90 % interval
  double stated = 0.0;    ///< the vehicle file's; NaN: it has none
  std::string unseen;     ///< why it is not observable; empty: it is
};

/// A drive as one answer: numbers, what they rest on, and what may be wrong.
struct DriveFit {
  std::vector<Found> found;
  std::vector<std::string> remarks;  ///< what was assumed, what cannot be told apart
  std::vector<std::string> doubts;   ///< why it must not be used
  std::size_t windows = 0, blocks = 0;

  /// Throws std::out_of_range.
  const Found& at(const std::string& name) const {
    for (const Found& f : found)
      if (f.name == name) return f;
    throw std::out_of_range(name);
  }
};

/// One place of a map over two axes.
struct MapPlace {
  double x = 0.0, y = 0.0;
  double value = 0.0, sd = 0.0, within = 0.0;  ///< half the 90 % interval
  double stated = 0.0;                         ///< the vehicle file's
  std::vector<double> seconds;                 ///< near it; of an engine in each gear
  std::string unseen;                          ///< why it is not observable; empty: it is

  bool seen() const { return unseen.empty(); }
};

/// A map of the car that was found at all its places at once.
struct FoundMap {
  std::vector<double> x, y;      ///< axes
  std::vector<MapPlace> places;  ///< by x, then y; empty: none
  DriveFit fit;

  bool any_seen() const { return std::ranges::any_of(places, &MapPlace::seen); }
  /// For a car: places that were not seen as their neighbours and the stated shape say.
  vehicle::Map2 map() const {
    vehicle::Map2 out{x, y, {}};
    for (const MapPlace& place : places) out.z.push_back(place.value);
    return out;
  }
};

/// What fits of parts of a car are told. A mass is found by fit_mass(), which takes no notice of
/// it.
struct WeighedOptions {
  double mass_kg = 0.0;     ///< with fuel; 0: the vehicle file's and fuel_kg
  double mass_sd_kg = 0.0;  ///< of it; with mass_kg 0 that of the vehicle file's prior
  double fuel_kg = 30.0;
  bool body_axes = true;  ///< as the windows'
};

/// Per axle, load = share of the mass * normal acceleration + lift area * dynamic pressure
/// -+ transfer * longitudinal acceleration, means over windows. Drag, rolling resistance, wheels'
/// inertia, ride height maps and how far springs and tyres give way are those of `car`; `prior` is
/// how far its parameters may be off (vehicle::Vehicle). Found: mass_kg (with fuel, at the middle
/// of the drive), mass_rate_kgps (of two minutes and more), cog_behind_front_m, cog_height_m (with
/// fuel, standing), front_lift_area_m2, rear_lift_area_m2. A refusal where there are no loads, no
/// accelerations, or too few windows.
base::Answer<DriveFit> fit_mass(const vehicle::Car<double>& car, const Prior& prior,
                                const DriveWindows& drive, const WeighedOptions& options = {});

/// What `fit` says as lines of a setup sheet, without the fuel; a remark for what was not found.
std::string mass_sheet(const vehicle::Car<double>& car, const DriveFit& fit, double fuel_kg);

struct AeroFitOptions : WeighedOptions {
  std::vector<std::pair<double, double>> engine_off_s;  ///< from, to: nothing drives or drags
};

/// By coast-downs (gear 0, or `engine_off_s`): inertia + rolling = - drag - rest. Without, at open
/// throttle: inertia + rolling = factor * engine map - drag. Found: drag_area_m2, and
/// rest_n: what slows the car at any speed beyond the vehicle file's rolling resistance, or an
/// offset of ax_mps2. Throws base::Error where accelerations are missing.
DriveFit fit_aero(const vehicle::Car<double>& car, const Prior& prior, const DriveWindows& drive,
                  const AeroFitOptions& options = {});

std::string aero_sheet(const DriveFit& fit);

/// Means over windows, of each axle: half the sum of the loads = spring rate * half the sum of the
/// travels + what braking, driving and cornering press through the links; half the difference =
/// (spring rate + 2 bar) * half the difference of the travels - what the links carry of the side
/// force, by the vehicle file. Found of front and rear: spring_npm, anti_roll_npm. `mass_kg` with
/// fuel. Dampers are not found: means over half a second do not show them. Throws base::Error
/// without loads or travels.
DriveFit fit_suspension(const vehicle::Car<double>& car, const Prior& prior,
                        const DriveWindows& drive, double mass_kg);

std::string suspension_sheet(const DriveFit& fit);

/// Pieces of a twentieth of a second, of each wheel: load = spring * travel + bar * the other's
/// travel + what side force, driving and braking press through the links + damper, in the shape
/// that the vehicle file gives it. Noise of the travels makes rates look larger than they are: its
/// share is found from the rows and taken out. Found of front and rear: bump_damping_nspm,
/// rebound_damping_nspm; with a damper map of the vehicle file bump_damper, rebound_damper as
/// factors on it. What is missing is said in `unseen`.
DriveFit fit_dampers(const vehicle::Car<double>& car, const recording::Recording& recording);

/// Force of the brakes = engine's drag - inertia - rolling - drag = factor of the front * its
/// torque by the vehicle file + factor of the rear * its torque. Found: front_torque, rear_torque
/// (factors on the vehicle file's), torque (one factor for both), and factors of both at the
/// pressures and disc temperatures that were visited, torque_20_40_bar or
/// torque_20_40_bar_500_700_k. Throws base::Error without pressures.
DriveFit fit_brakes(const vehicle::Car<double>& car, const Prior& prior, const DriveWindows& drive,
                    const WeighedOptions& options = {});

std::string brakes_sheet(const vehicle::Car<double>& car, const DriveFit& fit);

/// Friction over pressure, Pa, and temperature of the surface, K; seconds are those of all wheels.
/// Of its `fit` front_pads and rear_pads are an axle over the mean of both, by its own area.
using PadMapFit = FoundMap;

/// Force of the brakes as in fit_brakes = sum over the wheels of 2 * friction * pressure * area *
/// arm / radius. The friction is the vehicle file's (a map, or one number) and a smooth deviation
/// from it over pressure and temperature. Without pressures, temperatures or enough windows no
/// place is seen; `fit.remarks` say why.
PadMapFit fit_pad_map(const vehicle::Car<double>& car, const Prior& prior,
                      const DriveWindows& drive, const WeighedOptions& options = {});

struct DiscsFitOptions {
  std::array<double, 2> torque{1.0, 1.0};  ///< of each axle's brakes over the car's
  double torque_sd = 0.0;                  ///< share; heat is as wrong as it
};

/// The two nodes of laws/disc_heat.h, heated by pressure times the car's pad friction times speed,
/// run through the longest stretch of the recording and are held against the recorded
/// temperatures of the surfaces. Found of front and rear: disc_surface_capacity_jpk,
/// disc_core_capacity_jpk, disc_conductance_wpk, disc_area_m2 (as a measure of all cooling).
/// Nothing is thrown: what is missing is said in `unseen`.
DriveFit fit_discs(const vehicle::Car<double>& car, const Prior& prior,
                   const recording::Recording& recording, const DiscsFitOptions& options = {});

/// Torque, N m, over engine speed, rad/s, and throttle: what the crankshaft gives with full boost,
/// factors included. Of its `fit` torque is the found over the stated map, mean of the places seen;
/// torque_gear_3 that of this gear over the map of all.
using EngineFit = FoundMap;

/// Mass * acceleration + what turns + rolling + drag + front side force over the steering =
/// (torque - engine inertia * its acceleration) * ratio / radius, window by window, of straight and
/// turning, unbraked windows in one gear. The torque is the vehicle file's map and a smooth
/// deviation from it, found at all its places at once. Throws base::Error without throttle, and
/// for a car with the full turbocharged engine, which has no map.
EngineFit fit_engine(const vehicle::Car<double>& car, const Prior& prior, const DriveWindows& drive,
                     const recording::Recording& recording, const WeighedOptions& options = {});

}  // namespace identify
