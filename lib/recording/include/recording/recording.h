// Logs of real or simulated drives as canonical channels (docs/recordings.md): a mapping says which
// column is which channel; what is wrong with the clock and the samples is found and counted.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "recording/table.h"

namespace recording {

/// How one channel comes from a column: channel(t) = scale * column(t + delay_s) + offset.
struct ColumnMapping {
  std::string column;       ///< name in the log
  std::string channel;      ///< canonical name, unit included
  double scale = 1.0;       ///< to the channel's unit and sign
  double offset = 0.0;      ///< in the channel's unit
  double delay_s = 0.0;     ///< how late the log stamps the column
  double low_pass_s = 0.0;  ///< time constant of a filter in the logger, taken out again
  bool held = false;        ///< a sample equal to the one before is a repeat, no measurement
};

/// Which column is which channel. Without columns every column is taken as what its name says.
struct Mapping {
  std::string path;  ///< empty: none was read
  std::vector<ColumnMapping> columns;
  double imu_yaw_rad = 0.0;  ///< the accelerometer's axes against the body's, counter-clockwise
  double imu_ahead_m = 0.0;  ///< its place ahead of the design centre of mass
  bool has_origin = false;   ///< of the plane of latitudes and longitudes (recording/place.h)
  double origin_latitude_deg = 0.0, origin_longitude_deg = 0.0;
  double place_turn_rad = 0.0, place_x_m = 0.0,
         place_y_m = 0.0;  ///< from there to the road's frame
};

/// Reads mapping.yaml (docs/recordings.md). Throws Error with file:line on unknown channels and
/// keys, a channel twice, values that cannot be.
Mapping read_mapping(const std::string& path);

/// Rows [begin, end) of a recording without a gap between them.
struct Stretch {
  std::size_t begin = 0, end = 0;
};

struct Recording {
  Table table;          ///< canonical channels; time_s ascends strictly, yaw_rad has no jumps of a
                        ///< turn; NaN: not measured
  double step_s = 0.0;  ///< median distance of two rows
  std::vector<Stretch> stretches;  ///< broken where no row is for more than 2.5 median steps

  // What was met and mended.
  std::size_t rows_read = 0;
  std::size_t rows_repeated = 0;   ///< the same time as the row before: left out
  std::size_t rows_backwards = 0;  ///< earlier than the row before by less than a second: left out
  std::size_t clock_resets = 0;  ///< earlier by more: the time goes on a second after the last row
  std::size_t rows_without_time = 0;
  double first_trouble_s = 0.0;  ///< time of the first of all these
  double longest_gap_s = 0.0;
  std::size_t cells_not_numbers = 0;  ///< words in mapped columns: taken as empty
  /// Channels of motion that repeat the value before exactly while the car moves, in more than 3 of
  /// 10 samples, and the share. Such samples are no measurements: made empty, unless a mapping says
  /// `held: false`.
  std::vector<std::pair<std::string, double>> held;
  std::vector<std::string> constant;  ///< channels with one value throughout: left as they are
};

/// Reads a log: comma, semicolon or tab; words and numbers that are not finite count as empty.
/// Throws Error where a mapped column is missing, no time is there, or fewer than ten rows are
/// left.
Recording read_recording(const std::string& path, const Mapping& mapping = {});

/// The same from a table already read; `name` is for messages.
Recording make_recording(const Table& log, const std::string& name, const Mapping& mapping = {});

/// `values` with empty cells replaced by the straight line between their neighbours in time, the
/// nearest value at the ends; all NaN stays.
std::vector<double> fill_gaps(const std::vector<double>& time_s, const std::vector<double>& values);

}  // namespace recording
