// Sizes that tyres are sold by.
#pragma once

#include <string>

#include "base/answer.h"
#include "vehicle/data_sheet.h"

namespace vehicle {

/// 215/40R18 (width in mm, height as a share of it, rim in inches), 325/705R18 or 30/68-18 (width
/// and outer diameter in mm or cm), 18x7.5-10 (outer diameter, width and rim in inches). A refusal
/// says what was wanted.
base::Answer<TyreSize> tyre_size(const std::string& name);

}  // namespace vehicle
