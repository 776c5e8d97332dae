// States of the car that hardly a log has, worked out from what it has: windows of a replay that
// begin in the middle of a tip-in or a stop must not begin with what they had a window ago.
#pragma once

#include "vehicle/recording.h"
#include "vehicle/vehicle_file.h"

namespace explain {

/// Adds the column `boost` by recorded throttle and engine speed (without it: that at which
/// turbo.rise_s holds), settled at the log's begin. Nothing where the car has no first-order boost,
/// the log no throttle, or the column already.
void add_boost(vehicle::Recording& recording, const vehicle::Vehicle& car);

/// Adds the column `pad_heat_j`, the heat of the pads of a car whose brakes fade, by recorded
/// pressures and speed; cold at the log's begin. Wheels roll as the standing car's; the pads'
/// friction is the constant one.
void add_pad_heat(vehicle::Recording& recording, const vehicle::Vehicle& car);

/// Adds the column `tyre_warmth` of tyres that warm up, by recorded speed and yaw rate; cold at the
/// log's begin. Nothing without a yaw rate.
void add_warmth(vehicle::Recording& recording, const vehicle::Vehicle& car);

/// Rolling radius of an axle's tyres on the standing car without fuel, m.
double standing_radius_m(const vehicle::Vehicle& car, std::size_t axle);

}  // namespace explain
