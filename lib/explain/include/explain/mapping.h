// From a foreign log to the canonical channels: which column, unit, sign, clock, repeated samples.
#pragma once

#include <string>
#include <vector>

#include "recording/recording.h"
#include "recording/table.h"

namespace explain {

using recording::ColumnMapping;

/// A mapping as recording::read_mapping() reads it, and how it came about.
struct Mapping : recording::Mapping {
  std::vector<std::string> notes;  ///< what was inferred and from what
};

/// Columns of channels that the analysis reads, mapped to themselves; the others left out.
Mapping identity_mapping(const recording::Table& table);

/// Guesses a mapping from names, units in the names, and the redundancy between the columns: signs
/// and the zero of headings from the path, delays from the yaw rate and acceleration the path
/// implies, repeats from counting. Throws vehicle::Error when there is no time or no position.
Mapping propose_mapping(const recording::Table& table, const std::string& name);

/// The text of a mapping.yaml (docs/recordings.md) that recording::read_mapping() takes.
std::string format_mapping(const Mapping& mapping);

}  // namespace explain
