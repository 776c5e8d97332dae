// From a foreign log to the canonical channels: which column, unit, sign, clock, repeated samples.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "recording/recording.h"
#include "recording/table.h"

namespace explain {

using recording::ColumnMapping;

/// A mapping as recording::read_mapping() reads it, and how it came about.
struct Mapping : recording::Mapping {
  std::vector<std::string> notes;    ///< what was inferred and from what
  std::vector<std::string> missing;  ///< without which it is a draft to be completed by hand
  std::set<std::string> guessed;     ///< channels in a unit that the log does not name
};

/// Columns of channels that the analysis reads, mapped to themselves; the others left out.
Mapping identity_mapping(const recording::Table& table);

/// Guesses a mapping from names, units in the names, and the redundancy between the columns: signs
/// and the zero of headings from the path, delays from the yaw rate and acceleration the path
/// implies, repeats from counting. Units that the log does not name are those that the path wants;
/// accelerations that the path exchanges are exchanged. Where there is no clock, neither place nor
/// speed, or fewer than 50 rows, what names alone say, and `missing`. `name` is for messages.
Mapping propose_mapping(const recording::Table& table, const std::string& name);

/// The text of a mapping.yaml (docs/recordings.md) that recording::read_mapping() takes.
std::string format_mapping(const Mapping& mapping);

}  // namespace explain
