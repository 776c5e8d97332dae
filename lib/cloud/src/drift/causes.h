// What may be wrong with the inputs when scans do not fit the base, found by trying.
#pragma once

#include <string>

#include "cloud/map_options.h"
#include "cloud/read_cloud.h"
#include "cloud/road_frame.h"
#include "cloud/trajectory.h"
#include "sections.h"

namespace cloud {

/// Tries on a part of the points: yaw of the sensor by 15 degrees all round, roll and pitch by 5
/// degrees to 20 and by quarter turns, its axes mirrored, its place by 1 m, the frame by 2 m, the
/// clock by +-5 s (also from equal beginnings and by laps), units of points and poses, and poses
/// written in other ways. One sentence: what makes the points lie closer on the base, best first,
/// or that nothing of it does. The measure: median distance from the base, after a plane per 10 m
/// driven (none for roll, pitch, units and the like). Times that are no clock are told first. Reads
/// the scans once. Empty where there is nothing to try with. `found`: the poses with the drift
/// taken out; then what is told is better than these, and empty where nothing is.
std::string likely_causes(const CloudSource& scans, const RoadFrame& frame,
                          const Trajectory& trajectory, const MapOptions& options,
                          const Trajectory* found = nullptr);

/// Where all points seem to come from one sweep, but the trajectory is longer: throws Error if they
/// are of many, each with a clock of its own. Reads the scans once more then.
void want_one_clock(const CloudSource& scans, const Sections& sections,
                    const Trajectory& trajectory);

}  // namespace cloud
