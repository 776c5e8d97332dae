// What is said of the columns themselves, before any physics.
#pragma once

#include "explain/findings.h"
#include "explain/signals.h"

namespace explain {

/// Names what Signals::late has as one finding `sensor.delay` of all its columns. A delay that the
/// analysis found in one of these columns beside is put in it and counted to that column's own
/// finding.
void name_late_columns(const Signals& log, Findings& findings);

/// Beside a broken column nothing about road, car or air is written back.
void hold_back_beside_broken_columns(Findings& findings);

}  // namespace explain
