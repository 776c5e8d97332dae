// What a grid must be before it is sampled. Private to the grid stages.
#pragma once

#include "crg/reference_line.h"
#include "mesh/ray_surface.h"
#include "road/centreline.h"
#include "road/sample.h"

namespace road {

/// Throws Error naming the figure and the flag that mends it: no line, steps that are none, more
/// nodes than the limit, steps below what float32 resolves there, a road narrower than two steps.
/// The steps of `options` are given.
void check_sampling(const crg::ReferenceLine& line, const Centreline& centreline,
                    const RaySurface& surface, const SampleOptions& options);

}  // namespace road
