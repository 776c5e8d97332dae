// From a foreign log to the canonical channels: which column, unit, sign, clock, repeated samples.
#pragma once

#include <string>
#include <vector>

#include "vehicle/table.h"

namespace explain {

/// One column of a log: channel value = (column * scale + offset), read at time_s - delay_s, with a
/// first-order low-pass of the logger taken out again.
struct ColumnMap {
  std::string column;   ///< as in the log
  std::string channel;  ///< canonical name (docs/crgexplain.md)
  double scale = 1.0, offset = 0.0;
  double delay_s = 0.0;     ///< the log is late by this
  double low_pass_s = 0.0;  ///< time constant of a filter in the logger
  bool held = false;        ///< a sample equal to the one before is a repeat: no measurement
};

struct Mapping {
  std::vector<ColumnMap> columns;
  double imu_yaw_rad = 0.0;        ///< the accelerometer's axes against the body's, CCW
  double imu_ahead_m = 0.0;        ///< its place ahead of the centre of mass
  std::vector<std::string> notes;  ///< what was inferred and from what; comments of the file
};

/// Every canonical channel the analysis reads, in a fixed order.
const std::vector<std::string>& canonical_channels();

/// Canonical columns mapped to themselves; the others left out.
Mapping identity_mapping(const vehicle::Table& table);

/// Guesses a mapping from names, units in the names, and the redundancy between the columns: signs
/// and the zero of headings from the path, delays from the yaw rate and acceleration the path
/// implies, repeats from counting. Throws vehicle::Error when there is no time or no position.
Mapping propose_mapping(const vehicle::Table& table, const std::string& name);

/// mapping.yaml (docs/formats.md). Throws vehicle::Error with file:line.
Mapping read_mapping(const std::string& path);
std::string format_mapping(const Mapping& mapping);

}  // namespace explain
