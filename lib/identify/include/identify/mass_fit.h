// Mass, centre of mass and lift areas of a car from the wheel loads of a drive.
#pragma once

#include <string>

#include "base/answer.h"
#include "identify/drive_fit.h"
#include "identify/drive_windows.h"

namespace identify {

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

}  // namespace identify
