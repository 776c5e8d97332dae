// Drives as MCAP, for programs that show logs (Foxglove, PlotJuggler) and for ours.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

namespace recording {

/// Numbers that go together at every moment: one topic, whose messages are JSON objects.
struct WrittenTopic {
  std::string name;                    ///< "/motion"
  std::vector<std::string> fields;     ///< no name twice in a file that is to be read as a table
  std::vector<const double*> columns;  ///< columns[i] belongs to fields[i]; as long as the moments
};

/// The bytes of an MCAP file: a message for every topic at every moment `time_s` (written as
/// nanoseconds; where moments are negative, from the earliest on), values as text that reads back
/// to the same bits, what is no finite number left out; chunks of about 1 MB packed by zstd,
/// indexes, statistics and CRCs. `columns`: names in the order in which read_log() gives them back,
/// as one table (recording/log.h); `about`: what made the drive, kept beside them.
std::string format_mcap(std::span<const double> time_s, const std::vector<WrittenTopic>& topics,
                        const std::vector<std::string>& columns, const std::string& about);

}  // namespace recording
