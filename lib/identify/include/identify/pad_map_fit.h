// Friction of brake pads over pressure and disc temperature, from how a car slows down.
#pragma once

#include "identify/brakes_fit.h"

namespace identify {

/// Friction over pressure, Pa, and temperature of the surface, K; seconds are those of all wheels.
/// Of its `fit` front_pads and rear_pads are an axle over the mean of both, by its own area.
using PadMapFit = FoundMap;

/// Force of the brakes as in fit_brakes = sum over the wheels of 2 * friction * pressure * area *
/// arm / radius. The friction is the vehicle file's (a map, or one number) and a smooth deviation
/// from it over pressure and temperature. Without pressures, temperatures or enough windows no
/// place is seen; `fit.remarks` say why.
PadMapFit fit_pad_map(const vehicle::Car<double>& car, const Prior& prior,
                      const DriveWindows& drive, const WeighedOptions& options = {});

}  // namespace identify
