// Road unevenness of 0.4 to about 25 m, measured by the car itself, against the road file.
#pragma once

#include "explain/simulate.h"

namespace explain {

/// Adds what short waves say to findings of explain(): road.kerb_or_roughness (with the heights
/// that are missing, Finding::patch) or vehicle.multi_point_contact, or why neither could be
/// tested.
///
/// The height under each wheel is body height (what the accelerometers say of the vertical
/// integrated twice, roll and pitch rates once), plus travel, plus load over the tyre's stiffness,
/// while the wheel touches the road; slow parts are taken out of it and of the
/// file's height alike (a local parabola over 0.8 s). What even and odd laps agree on and the file
/// does not have is missing: products of the two in cells of 10 m, against the same with one of
/// them shifted along u. Where the stated tyre touches in one point, the file seen through
/// lib/vehicle's contact strip, which has no free amount, competes with new heights. Needs
/// accelerations, roll and pitch rate, suspension travel and wheel loads at 80 Hz or more, and two
/// laps.
void add_short_waves(Findings& findings, const std::vector<RecordedLog>& logs,
                     const Mapping& mapping, const crg::Surface& surface,
                     const vehicle::Vehicle& car);

}  // namespace explain
