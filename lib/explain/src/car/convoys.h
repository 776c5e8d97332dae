// What cars share that are led together.
#pragma once

#include "explain/model.h"

namespace explain {

/// The stated car's files with the setting's amounts.
vehicle::CarFiles files_with(const Signals& signals, const vehicle::Vehicle& car,
                             const Setting& setting);

}  // namespace explain
