// The readers of single formats, and what they share.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "recording/log.h"

namespace recording {

/// Cells of a log, over all channels: 2 GB.
constexpr std::size_t kMostCells = std::size_t{1} << 28;

constexpr std::size_t kLargestFileBytes = std::size_t{1} << 30;

/// What a file that zstd packed as a whole holds.
std::string unpacked_file(std::string_view bytes, const std::string& name);

/// A recording of rosbag2 in a folder: all files that its metadata.yaml names, as one log. Throws
/// base::Error where one is missing.
Log read_bag_folder(const std::string& folder);

Log parse_csv(std::string_view text, const std::string& name);
Log parse_motec_ld(std::string_view bytes, const std::string& name);
Log parse_racelogic_vbo(std::string_view text, const std::string& name);
Log parse_iracing_ibt(std::string_view bytes, const std::string& name);
Log parse_mcap(std::string_view bytes, const std::string& name);
Log parse_rosbag2(std::string_view bytes, const std::string& name);

/// What the data logging of Haltech exports as CSV: whole numbers, whose scale the type of each
/// channel says. Values in rpm, km/h, %, kPa, g, degrees and what else `unit` names; of a type that
/// is not known as they stand, without a unit, and a note says so.
Log parse_haltech_csv(std::string_view text, const std::string& name);

/// A table whose cells stand between blanks, as one between commas with as many lines; empty where
/// it is none.
std::string blanks_to_commas(std::string_view text);

/// Throws base::Error, with the way out, where the bytes are a format that is known and not read.
void refuse_what_is_not_read(std::string_view bytes, const std::string& name);

bool is_haltech_csv(std::string_view text);
bool is_motec_ld(std::string_view bytes);
bool is_racelogic_vbo(std::string_view bytes);
bool is_iracing_ibt(std::string_view bytes);
bool is_mcap(std::string_view bytes);
bool is_rosbag2(std::string_view bytes);

/// The channel of a log in rows that is called a clock, or nullptr.
const Channel* clock_of(const Log& log);

/// That, or the first with is_time_that_runs(): of a log whose rows are read.
const Channel* clock_by_values(const Log& log);

/// Names that come again get a number: "speed", "speed #2".
void number_names(std::vector<Channel>& channels);

/// Whether a cell or a word is a unit of measurement, in brackets or without.
bool is_unit(std::string_view cell);

/// Samples a second of every channel of a log in rows, by the clock `time_s` of the rows.
void set_rates(Log& log, const std::vector<double>& time_s);

/// A little-endian value at `at`, which must lie inside the bytes.
template <class T>
T little(std::string_view bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));  // the machines we build for are little-endian
  return value;
}

/// Text of a field of fixed length, up to its first zero, without blanks at its ends.
std::string field(std::string_view bytes, std::size_t at, std::size_t length);

}  // namespace recording
