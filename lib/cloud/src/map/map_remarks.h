// What a map says of its inputs: what does not fit, and what was corrected.
#pragma once

#include "sections.h"

namespace cloud {

inline constexpr double kTiltedMuch = 5e-4;  // of a base, as a slope across

/// Says what the counts of the first reading tell about clock, frame and units: throws Error.
void check_fit(const Sections& sections, const RoadFrame& frame, const RoadTrajectory* trajectory,
               const MapOptions& options);

/// Places that see the same ground should agree whatever the drift is.
void look_at_views(const MapOptions& options, MapReport& report);

/// Ground that changed between passes: a fault, or what campaigns are driven for.
void look_at_changes(const MapOptions& options, MapReport& report);

/// A base that is tilted as a whole, and one that may be.
void look_at_tilt(const MapOptions& options, MapReport& report);

/// Leaps and gaps of the trajectory as it was given.
void look_at_poses(const Trajectory& poses, MapReport& report);

/// What all corrections have in common is no drift: words for what was corrected.
void look_at_common(const Sections& sections, const Trajectory& poses, const MapOptions& options,
                    MapReport& report);

}  // namespace cloud
