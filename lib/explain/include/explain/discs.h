// Brake discs: does the stated two-node disc follow the logged temperatures?
#pragma once

#include "explain/simulate.h"

namespace explain {

/// Adds vehicle.brake_disc_conductance to the findings, or why it could not be tested. The disc of
/// lib/vehicle (surface and core, docs/vehicle.md) is driven with the logged pressures and speeds;
/// heat entering, both capacities, conductance, cooling and the core's temperature at the begin are
/// refitted with their prior widths. Then one more amount may act: a conductance that rises with
/// temperature, or its rivals, another emissivity or another slope of the heat capacity. It is
/// found when its score against blocks of 20 s with signs turned at random is exceeded by less than
/// 1 % of 1,000, and every lap is predicted better from the others. Needs disc temperatures, brake
/// pressures and 60 s.
void add_discs(Findings& findings, const std::vector<RecordedLog>& logs, const Mapping& mapping,
               const vehicle::Vehicle& car);

}  // namespace explain
