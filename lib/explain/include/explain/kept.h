// Results of a stage as bytes, every number to the last bit: for a run that goes on where it was
// stopped.
#pragma once

#include <string>

#include "explain/simulate.h"

namespace explain {

std::string to_bytes(const Findings& findings);
std::string to_bytes(const RefittedCar& car);
std::string to_bytes(const SimulationCheck& check);

/// The way back. Throws vehicle::Error on bytes that are none of these.
Findings findings_from_bytes(const std::string& bytes);
RefittedCar car_from_bytes(const std::string& bytes);
SimulationCheck check_from_bytes(const std::string& bytes);

}  // namespace explain
