// A log as a smoother takes it: what each channel measures, how noisy it is, what happens between
// rows. Private to forces.cpp.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "car_smoother.h"
#include "drive_columns.h"
#include "recording/recording.h"

namespace identify {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct ForceChannels {
  std::vector<Sensor> sensors;
  std::vector<SmootherRow> rows;  ///< one per row of the recording
  std::vector<std::string> said;  ///< sentences: what drives what, what was assumed
};

/// The channels of a recording that say something about the car. Noises are those of third
/// differences; noise that comes into the driver's actions follows how these move. Throws
/// base::Error where one that is needed is missing.
ForceChannels read_force_channels(const recording::Recording& recording,
                                  const vehicle::Car<double>& car);

/// What each estimated number is uncertain by at a begin, and the variance that comes into it per
/// second. `prior`: two standard deviations of what the vehicle file says, as ParameterInfo has it.
PlaceVector begin_deviations(const std::array<double, vehicle::kParameterCount>& prior);
PlaceVector noise_per_second();

}  // namespace identify
