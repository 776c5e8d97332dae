// Telemetry as MCAP, for programs that show logs.
#pragma once

#include <string>

#include "recording/table.h"

namespace recording {

/// The bytes of an MCAP file (recording/mcap.h) with the rows of a table of telemetry channels: the
/// topics /place, /motion, /controls, /engine, /wheels and, of columns with other names, /other.
/// read_log() gives the table back with the same names, order and bits. `about`: what made the
/// drive. Throws Error without a column time_s.
std::string format_mcap(const Table& table, const std::string& about);

}  // namespace recording
