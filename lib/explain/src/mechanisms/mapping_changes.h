// What findings change in a mapping.
#pragma once

#include <vector>

#include "explain/mapping.h"
#include "explain/signals.h"
#include "vehicle/vehicle_file.h"

namespace explain {

struct MappingChanges {
  Mapping& mapping;
  const vehicle::Vehicle& car;  ///< as stated
  const std::vector<Signals>& logs;
  bool changed = false;
};

}  // namespace explain
