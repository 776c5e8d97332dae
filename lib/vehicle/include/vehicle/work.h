// What every force of a step did to the car's energy.
#pragma once

#include "vehicle/step.h"

namespace vehicle {

/// Work of each force over one step, J, in the members of Powers. A step holds its forces (those of
/// `detail`) while the velocities go from those of `before` to those of `after`, so that the work
/// of a force is exactly its product with the mean velocity; the torques of frictions that can
/// stick are those of the step. Summing powers at the steps instead would count a share of half a
/// step too much or too little wherever a force changes with the speed that it changes.
Powers<double> work_of_step(const Car<double>& car, const State<double>& before,
                            const State<double>& after, const Detail<double>& detail,
                            const StepOptions& options);

}  // namespace vehicle
