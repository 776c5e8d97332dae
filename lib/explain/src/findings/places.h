#pragma once

#include <vector>

#include "explain/findings.h"

namespace explain {

/// The stretches of road, in whole cells of 20 m, that hold four fifths of an energy given at
/// places; stretches less than 40 m apart are one. Empty when they make up more than half of the
/// road: then it is everywhere.
std::vector<Place> concentrated(const std::vector<double>& u_m, const std::vector<double>& energy,
                                double length_m);

}  // namespace explain
