// The words of other loggers: names of columns and of units.
#pragma once

#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace explain {

constexpr double kDegree = std::numbers::pi / 180.0;  ///< rad

/// What others call a channel.
struct Alias {
  const char* channel;
  const char* quantity;  ///< picks the unit table
  std::vector<const char*> names;
};

/// Names that other loggers use, lower case without punctuation.
const std::vector<Alias>& aliases();

/// "vx (m/s)" or "vx[m/s]" into name and unit, the unit in lower case.
std::pair<std::string, std::string> split_unit(const std::string& column);

/// What a column may be known by: its name; for a channel of a topic ("/odom.twist.twist.linear.x",
/// "field.twist.twist.linear.x") its last two parts, then the last one where that is more than a
/// letter.
std::vector<std::string> words_of(const std::string& stem);

/// The unit that such a word of words_of() says itself, as "rpm" and "gforcex" do; else nothing.
std::string unit_by_word(const std::string& word);

/// What one of the unit is in the quantity's own; none: no unit of it.
std::optional<double> unit_scale(const std::string& quantity, const std::string& unit);

/// What 0 of the unit is in the quantity's own: 273.15 K of 0 C.
double unit_zero(const std::string& quantity, const std::string& unit);

/// Whether it is a unit of any quantity.
bool is_unit(const std::string& unit);

}  // namespace explain
