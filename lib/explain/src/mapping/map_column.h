// What one column of a foreign log is: which channel by its name, in which unit, held or not.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "explain/mapping.h"
#include "recording/table.h"

namespace explain {

/// Every channel the analysis reads.
const std::vector<std::string>& analysed_channels();

/// Whether a column has a name of the channel that other loggers use.
bool is_called(const std::string& column, std::string_view channel);

/// Takes column `c` of the table into the mapping, or leaves it out; a note says why. `taken` has
/// the channels that other columns gave. The pressure of an axle gives the channels of both wheels.
void map_column(const recording::Table& table, std::size_t c, std::set<std::string>& taken,
                Mapping& mapping);

/// Takes column `c` as the clock.
void map_clock(const recording::Table& table, std::size_t c, Mapping& mapping);

/// Pressures of all wheels make a common one superfluous; that of one axle alone stands for all.
void settle_pressures(Mapping& mapping);

}  // namespace explain
