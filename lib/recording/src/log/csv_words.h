// What the words of a table say of its numbers: which half of the Earth, which signal of a bus.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/log.h"

namespace recording {

/// The cells of some columns as they stand in the file; of the others nothing.
using Words = std::vector<std::vector<std::string_view>>;

/// Columns whose words say something: cars and drivers, those behind a latitude or a longitude, and
/// in a table with a row for each sample of a signal (`is_long_form`) its names and units.
std::vector<bool> columns_with_words(const Log& log);

/// Throws base::Error on rows of several cars, or of drivers whose clocks do not follow each other.
void want_one_car(const Log& log, const Words& words, const std::string& name);

/// South and west are negative, where a column of N and S, or E and W, follows the numbers.
void give_signs_of_hemispheres(Log& log, const Words& words);

/// "52.1 km/h": a number and its unit; nothing where the cell is none, or has a comma.
struct Amount {
  double value;
  std::string_view unit;
};
std::optional<Amount> amount_of(std::string_view cell);

/// "48.1234N": degrees with their hemisphere, south and west negative.
std::optional<double> degrees_of(std::string_view cell);

/// Adds a column of milliseconds ("MS") to a clock of whole seconds, or spreads the rows that have
/// one second evenly over it; and lets a clock that begins again with each number of a lap go on.
/// Notes say what was done. Does nothing to rows of one signal each.
void mend_clock_by_columns(Log& log);

/// Whether there are a clock, a column of names of signals and one of their values.
bool is_long_form(const Log& log);

/// One channel for each signal of such a table, with a clock of its own. Samples that are no later
/// than the one before are left out with a note.
Log signals_of_long_form(Log log, const Words& words);

}  // namespace recording
