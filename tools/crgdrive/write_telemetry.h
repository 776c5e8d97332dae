// Telemetry to a file, as its name asks.
#pragma once

#include <string>

#include "recording/table.h"

namespace crgdrive {

bool is_mcap(const std::string& path);

/// A name that ends in .mcap: MCAP, numbers to the bit, `from` kept as its metadata; any other: CSV
/// with `digits` digits after the remarks `from`.
void write_telemetry(const std::string& path, const std::string& from,
                     const recording::Table& table, int digits = 9);

}  // namespace crgdrive
