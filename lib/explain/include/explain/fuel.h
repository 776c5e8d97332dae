// Fuel that nobody logged, by the law of the simulated car.
#pragma once

#include "explain/mapping.h"
#include "explain/signals.h"
#include "vehicle/vehicle_file.h"

namespace explain {

/// What the engine gives at the wheels and loses in the gears, W, at every step of the signals:
/// mass times forward acceleration and drag, times speed, while the throttle is open; 0 elsewhere.
std::vector<double> useful_power_w(const Signals& signals, const vehicle::Vehicle& car);

/// Adds a column to the log and to the mapping: `fuel_kg` at the log's begin, less what the car
/// burns (vehicle.yaml: fuel.*, fuel_burn). Nothing is burnt once none is left.
void add_fuel(recording::Table& log, Mapping& mapping, const Signals& signals,
              const vehicle::Vehicle& car, double fuel_kg);

}  // namespace explain
