// Brake disc temperatures by recorded pressures and speeds, with amounts that may be wrong.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "vehicle/vehicle_file.h"

namespace explain {

inline constexpr double kDiscStep_s = 0.05;

/// One axle of one recording on a clock of kDiscStep_s.
struct Stop {
  std::size_t axle = 0, log = 0;
  std::vector<double> pressure_pa, speed_mps, disc_k;
  std::vector<double> pad_heat_j;  ///< of the pads of all wheels; empty: they do not fade
  std::vector<int> lap;
};

/// Logarithms of factors, the core's difference from the surface at the begin (100 K), and the
/// three amounts that compete: the conductance's relative rise over 500 K, the relative changes of
/// emissivity and of the heat capacity's slope.
enum DiscAmount : std::size_t {
  kHeat,
  kSurface,
  kCore,
  kConductance,
  kCooling,
  kBegin,
  kRise,
  kEmissivity,
  kCapacity,
  kDiscAmounts
};
using DiscAmounts = std::array<double, kDiscAmounts>;

/// Surface temperature every kDiscStep_s from the first logged one on, K, NaN before: the discs and
/// pads of lib/vehicle with every term by its amplitude. Wheels roll as the standing car's.
/// Pressure and speed that are missing count as 0. Held to 200 to 3000 K.
std::vector<double> disc_temperature(const Stop& stop, const vehicle::Vehicle& car,
                                     const DiscAmounts& amount);

/// Heat of all pads over one recording, J, every kDiscStep_s, by pressure, speed and, for a map of
/// friction, the logged surface temperature of both axles (`disc_k` NaN or empty: the constant
/// friction). Cold at the begin; empty where the stated pads do not fade.
std::vector<double> disc_pad_heat(const std::array<Stop, 2>& axles, const vehicle::Vehicle& car);

}  // namespace explain
