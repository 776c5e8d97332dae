// Logs of any maker as channels with name, unit and rate: CSV exports, MoTeC .ld, Racelogic .vbo,
// iRacing .ibt, MCAP, rosbag2, each of them also packed by zstd as a whole. What a file is, its
// first bytes say, not its name.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace recording {

/// One measured quantity, as logged: unit and sign are the maker's.
struct Channel {
  std::string name;            ///< as in the file, in UTF-8, no name twice in a log
  std::string unit;            ///< empty: the file names none
  double rate_hz = 0.0;        ///< samples a second; 0: not known (no clock in the file)
  std::vector<double> values;  ///< NaN: an empty cell
  std::size_t words = 0;       ///< cells that were no numbers; taken as empty
  std::size_t clock = 0;       ///< which of Log::clocks says when, where there are any
};

struct Log {
  std::string format;  ///< "CSV", "MoTeC .ld", "Racelogic .vbo", "iRacing .ibt", "MCAP", "rosbag2"
  std::vector<Channel> channels;
  /// Whether sample k of all channels is of one moment and a clock is among them; otherwise sample
  /// k of a channel is of clocks[channel.clock][k], and where there are no clocks of k / rate_hz.
  bool in_rows = true;
  std::vector<std::vector<double>> clocks = {};  ///< [s] from the log's first moment on, ascending
  std::vector<std::string> notes = {};           ///< what was not read and why, in sentences
};

/// Reads a log: a file, or a folder that rosbag2 recorded into. Throws base::Error, one line, on
/// what is none of the formats, on files that contradict themselves and on what would take more
/// than 2 GB; nothing is reserved on the word of a header alone. A CSV with a header line:
/// separated by commas, semicolons or tabs (whichever the header has most of); words and numbers
/// that are not finite become NaN; a last line that was cut off is left out. Loggers' exports may
/// have lines before the header, a line of units and one of sources after it, quotes around
/// everything, decimal commas (with semicolons or tabs), or a `#` before the header. A name twice
/// is refused, but in an export with units: there the second is called "name #2".
Log read_log(const std::string& path);
/// The same from the bytes of a file; `name` is for messages.
Log parse_log(std::string_view bytes, const std::string& name);

/// The log with one row for each moment of the channel with most samples, which becomes the clock
/// "log time" [s]. Slower channels have a value in as many rows as they have samples and NaN in the
/// others; a sample between two rows is brought to the nearer one by the straight line to its
/// neighbour. A log in rows stays as it is.
Log in_rows(Log log, const std::string& name);

}  // namespace recording
