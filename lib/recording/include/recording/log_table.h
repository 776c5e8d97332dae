// Logs of any maker as one table: apart from tables, because a unit's shared object has no use for
// the readers of lib/recording.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "recording/table.h"

namespace recording {

/// Reads a log of any maker (recording/log.h) as one table. A column is called as its channel, with
/// the unit where the file names it apart: "speed [m/s]". `words` counts the cells that were no
/// numbers; `notes` says what was not read.
Table read_log_table(const std::string& path, std::vector<std::size_t>* words = nullptr,
                     std::vector<std::string>* notes = nullptr);
Table parse_log_table(const std::string& text, const std::string& name,
                      std::vector<std::size_t>* words = nullptr);

}  // namespace recording
