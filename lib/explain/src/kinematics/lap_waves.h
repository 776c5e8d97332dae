// Waves along a lap, from which profiles of a road are summed up.
#pragma once

#include <Eigen/Core>

namespace explain {

/// Turns of a wave along the lap.
double wave_turns(std::size_t column, bool closed);

/// Waves along a lap of `places` places: of a closed one whole waves, of an open one half waves.
/// One column per wave, `columns` in all, the first is constant 1; waves have the amplitude 1.
Eigen::MatrixXd waves(std::size_t places, std::size_t columns, bool closed);

}  // namespace explain
