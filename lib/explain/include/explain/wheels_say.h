// What wheels alone say about findings of other columns.
#pragma once

#include "explain/findings.h"
#include "explain/signals.h"
#include "vehicle/vehicle_file.h"

namespace explain {

/// Where the driven wheels turn alike whatever the car turns, wheels of different radius (stagger)
/// turn it all along: an offset of the steering that forces alone tell is that as well. Names the
/// coupling, the offset as its equal; nothing of it is written. Of another car than the file's,
/// whose forces tell nothing, the coupling alone, unless the file states it.
void say_that_wheels_are_coupled(const Signals& log, const vehicle::Vehicle& car,
                                 Findings& findings);

/// A logged speed that is that of an axle's wheels within 0.2 % has their radius and their filter:
/// a gain of up to 3 % and being late by up to 0.15 s become a remark, for so wheels are.
void take_speeds_of_wheels_as_usual(const Signals& log, Findings& findings);

}  // namespace explain
