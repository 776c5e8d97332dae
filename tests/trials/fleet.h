// Recordings of several cars on one road: what all have is the road's, what one has is its own.
#pragma once

#include <filesystem>
#include <string>

namespace trials {

/// "none", "banking" (all turns lean more than their file says), "turbo" (one car's torque waits
/// for boost), "both". Writes DIR/car0, car1, ... with car, road and recording, DIR/sealed with the
/// truths. The road's file has the same bytes for all. The logs have no accelerometers. False, with
/// a line on stderr, where the name is not known or a car left the road.
bool make_fleet(const std::string& name, int cars, int laps, unsigned long long seed,
                const std::filesystem::path& folder);

/// The car with the turbo.
inline constexpr int kLateCar = 2;

/// How much all turns lean, per curvature, where their file has 0.5 m.
inline constexpr double kLean_m = 2.5;

}  // namespace trials
