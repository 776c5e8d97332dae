#include "map_column.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/letters.h"
#include "column_words.h"
#include "confirm_mapping.h"
#include "recording/look.h"
#include "wheel_words.h"

namespace explain {
namespace {

using recording::Table;

constexpr double kFastest_mps = 120.0;  // 432 km/h: a car that seems faster is logged in km/h

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double x : values)
    if (std::isfinite(x)) most = std::max(most, std::abs(x));
  return most;
}

double least(const std::vector<double>& values) {
  double out = std::numeric_limits<double>::infinity();
  for (const double x : values)
    if (std::isfinite(x)) out = std::min(out, x);
  return out;
}

bool has_word(const Table& table, std::initializer_list<const char*> words) {
  return std::any_of(table.names.begin(), table.names.end(), [&](const std::string& name) {
    const std::string own = base::letters_and_digits_of(split_unit(name).first);
    return std::any_of(words.begin(), words.end(), [&](const char* word) { return own == word; });
  });
}
bool on_earth(const Table& table) {
  return std::any_of(table.names.begin(), table.names.end(),
                     [](const std::string& name) { return is_called(name, "latitude_rad"); });
}
/// Where a log has no other place, a heading is what a receiver calls the path's course.
bool placed_by_satellites(const Table& table) {
  return has_word(table, {"sats", "satellites", "nsat", "gpsnsat"}) ||
         (on_earth(table) && !has_word(table, {"posx", "positionx", "xposition", "easting"}));
}
bool north_yaw(const Table& table) { return has_word(table, {"yawnorth"}); }

/// What the name of a column says.
struct Guess {
  std::string channel, quantity;  ///< empty: nothing known
  std::string word;               ///< of the name, by which it is known
  std::string second;             ///< the right wheel's channel, where it is of an axle
};

bool has_quantity(const Guess& guess) {
  return !guess.quantity.empty() && guess.quantity != "none";
}

/// Of "GPS (Lat.) [deg]" also "gpslat": what stands in brackets before the unit belongs to the
/// name.
std::vector<std::string> words_of_column(const std::string& column, const std::string& stem) {
  std::vector<std::string> out = words_of(stem);
  if (const std::size_t last = column.find_last_of("([");
      last != std::string::npos && last > 0 && stem != column)
    if (const std::string whole = base::letters_and_digits_of(column.substr(0, last));
        std::find(out.begin(), out.end(), whole) == out.end())
      out.push_back(whole);
  return out;
}

Guess guess_channel(const std::string& column, const std::string& stem, const std::string& unit) {
  Guess guess;
  const auto& known = analysed_channels();
  const std::string field = stem.starts_with('/') ? stem.substr(stem.rfind('.') + 1) : column;
  if (std::find(known.begin(), known.end(), field) != known.end()) guess.channel = field;
  for (const std::string& candidate : words_of_column(column, stem)) {
    if (!guess.channel.empty()) break;
    guess.word = candidate;
    const std::string& word = guess.word;
    for (const Alias& alias : aliases())
      for (const char* other : alias.names)
        if (word == other) {
          guess.channel = alias.channel;
          guess.quantity = alias.quantity;
        }
    if (guess.channel == "yaw_rad" && unit_scale("rate", unit))
      guess.channel = "yaw_rate_radps", guess.quantity = "rate";
    for (const char* w : {"fl", "fr", "rl", "rr"})
      if (word == std::string("wheel") + w || word == std::string("wheelspeed") + w ||
          word == std::string("ws") + w || word == std::string("vel") + w ||
          (w[1] == 'l' && word == std::string("l") + w[0] + "speed") ||
          (w[1] == 'r' && word == std::string("r") + w[0] + "speed")) {
        const bool turning = unit_scale("turn", unit).has_value();
        guess.channel = fmt::format("wheel_{}_{}", w, turning ? "radps" : "mps");
        guess.quantity = turning ? "turn" : "speed";
      }
    if (const auto wheel = wheel_word(word)) {
      guess.channel = wheel->channels.front();
      if (wheel->channels.size() > 1) guess.second = wheel->channels.back();
      guess.quantity = wheel->quantity;
    }
  }
  return guess;
}

/// The unit that is written, or that the name says itself; topics of ROS turn in rad/s.
std::string unit_of(const std::string& column, const std::string& word,
                    const std::string& written) {
  if (is_unit(written)) return written;
  const bool of_topic = column.starts_with('/') || column.starts_with("field.");
  if (of_topic && word.starts_with("angularvelocity")) return "rad/s";
  const std::string of_word = unit_by_word(word);
  return of_word.empty() ? written : of_word;
}

/// The largest number of a column and of those that are in its unit, whatever that is: the other
/// accelerations or turning rates without one, the other half of a place on Earth. A longitude near
/// Greenwich would be radians by itself, and a gentle ax g beside an ay in m/s^2.
double largest_of_kind(const Table& table, std::size_t c, const Guess& guess) {
  const auto kind_of = [](const Guess& g) -> std::string {
    if (g.channel == "latitude_rad" || g.channel == "longitude_rad") return "place";
    return g.quantity == "acceleration" || g.quantity == "rate" ? g.quantity : "";
  };
  const std::string kind = kind_of(guess);
  double most = largest(table.columns[c]);
  if (kind.empty()) return most;
  std::set<std::string> seen{guess.channel};  // of each channel the first column, which is taken
  for (std::size_t k = 0; k < table.names.size(); ++k) {
    const auto [stem, unit] = split_unit(table.names[k]);
    const Guess other = guess_channel(table.names[k], stem, unit);
    if (kind_of(other) == kind && !is_unit(unit_of(table.names[k], other.word, unit)) &&
        seen.insert(other.channel).second)
      most = std::max(most, largest(table.columns[k]));
  }
  return most;
}

/// The factor to the channel's own unit: by the unit in the name, or from the size `most` of the
/// values where that decides.
void put_scale(const std::vector<double>& values, double most, const std::string& quantity,
               const std::string& unit, ColumnMapping& m, Mapping& mapping) {
  const std::string& column = m.column;
  if (const auto scale = unit_scale(quantity, unit)) {
    m.scale = *scale;
    m.offset = unit_zero(quantity, unit);
    if (quantity == "share" && m.scale == 0.01 && largest(values) <= 1.2)
      m.scale = 1.0;  // says per cent, writes shares
    mapping.notes.push_back(fmt::format("{} from '{}': unit {} in the name, factor {:g}", m.channel,
                                        column, unit, m.scale));
  } else {
    if (quantity == "time") m.scale = recording::scale_of_moments(values);
    if (quantity == "speed" && most > kFastest_mps) m.scale = 1.0 / 3.6;
    if (quantity == "share" && most > 1.5) m.scale = most > 110.0 ? 1.0 / 255 : 0.01;
    if (quantity == "acceleration" && most < 4.0 && most > 0.2) m.scale = 9.80665;
    const bool on_globe = m.channel == "latitude_rad" || m.channel == "longitude_rad";
    if ((quantity == "angle" || quantity == "rate") && most > (on_globe ? 3.2 : 7.0))
      m.scale = kDegree;
    if (on_globe && most > 1e4 && most <= 1.8e9) m.scale = 1e-7 * kDegree;  // as receivers write
    constexpr double kHighestRoad_m = 9000.0;
    if (m.channel == "z_m" && most > kHighestRoad_m) m.scale = 1e-3;
    if (quantity == "pressure" && most < 500.0) m.scale = 1e5;
    if (quantity == "turn" && most > 2500.0) m.scale = std::numbers::pi / 30;
    if (m.channel.starts_with("suspension_") && most > 1.0) m.scale = 1e-3;
    // No brake is colder than 200 K, and hardly one never cooler than 200 C.
    if (quantity == "temperature" && least(values) < 200.0) m.offset = 273.15;
    mapping.notes.push_back(fmt::format(
        "{} from '{}': no unit known ('{}'); largest value {:g}{}, factor {:g}{} guessed: check",
        m.channel, column, unit, most, most > largest(values) ? " of its kind" : "", m.scale,
        m.offset != 0.0 ? fmt::format(" and zero {:g}", m.offset) : ""));
    mapping.guessed.insert(m.channel);
  }
}

void put_held(const std::vector<double>& values, ColumnMapping& m, Mapping& mapping) {
  const double repeated = recording::share_held(values);
  const bool position = m.channel == "x_m" || m.channel == "y_m" || m.channel == "latitude_rad" ||
                        m.channel == "longitude_rad" || m.channel == "yaw_rad" ||
                        m.channel == "vx_mps" || m.channel == "yaw_rate_radps" ||
                        m.channel.starts_with("a") || m.channel.starts_with("wheel");
  if (position && repeated > 0.3 && repeated < 0.99) {
    m.held = true;
    mapping.notes.push_back(
        fmt::format("{}: {:.0f} % of the samples repeat the one before; they count as missing",
                    m.channel, 100 * repeated));
  }
}

/// Why a column is not what its name says; empty: nothing speaks against it.
std::string doubt(const Table& table, std::size_t c, const Guess& guess, const std::string& unit) {
  // A receiver's heading is its course, and the car's would have its slip angle in it.
  if (guess.word == "heading" && placed_by_satellites(table))
    return "the receiver's course, no heading of the car";
  if (guess.word.size() == 1 && guess.word.find_first_of("xyz") == 0 && unit.empty()) {
    if (on_earth(table))
      return "one letter without a unit, which beside latitudes may be an acceleration";
    // Apps of telephones write a file for each sensor, whose name alone says which it was.
    if (has_word(table, {"secondselapsed"}))
      return "one letter without a unit, which beside seconds_elapsed may be any sensor's axis";
  }
  const std::vector<double>& values = table.columns[c];
  const double most = largest(values);
  if (guess.word == "brake" && !is_unit(unit))
    return most <= 1.0 || most == 100.0 || most == 255.0
               ? "a pedal's share or a switch, no pressure"
               : fmt::format("up to {:g} without a unit, it may be a pedal's share or a pressure",
                             most);
  constexpr double kByte = 255.0;
  if (guess.quantity == "share" && !is_unit(unit) && most > kByte)
    return fmt::format("up to {:g}, it is no share of 1, 100 or 255", most);
  if (guess.word == "fuel" && unit != "kg")
    return "its unit is not known: kg, litres or a share of the tank";
  if (guess.quantity == "speed" && !is_unit(unit) && most * (1 / 3.6) > kFastest_mps)
    return fmt::format("up to {:g}, it is no car's speed in m/s, km/h or mph", most);
  if ((guess.word == "offset" || guess.word == "interval") && !unit_scale("time", unit))
    return "its name says nothing known";
  const bool says_epoch = unit.find("1970") != std::string::npos || unit == "utc" || unit == "unix";
  if (guess.quantity == "time" && !unit.empty() && !is_unit(unit) && !says_epoch)
    return fmt::format("'{}' is no unit of time that is known", unit);
  if (unit.starts_with('%') && guess.quantity == "temperature")  // "% est."
    return "per cent is no unit of " + guess.channel;
  if (has_quantity(guess) && is_unit(unit) && !unit_scale(guess.quantity, unit))
    return fmt::format("{} is no unit of {}", unit, guess.channel);
  if (guess.channel == "time_s")
    for (std::size_t k = 0; k < table.names.size(); ++k)
      if (recording::is_finer_clock(table.names[k], table.columns[k], values))
        return fmt::format("half of its rows or more have the moment before; '{}' is finer",
                           table.names[k]);
  if (guess.channel.empty()) return "its name says nothing known";
  // A unit that stands apart in the file; brackets in a name may say something else.
  if (has_quantity(guess) && guess.quantity != "time" && table.names[c].ends_with(']') &&
      !unit.empty() && !is_unit(unit))
    return fmt::format("'{}' is no unit of {} that is known", unit, guess.channel);
  if (guess.channel != "time_s" &&
      std::none_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }))
    return "it holds no number";
  const bool of_motion = guess.quantity == "acceleration" || guess.quantity == "rate";
  if (of_motion && recording::is_dead(values))
    return fmt::format("it holds {:g} in every row", most);
  return "";
}

}  // namespace

const std::vector<std::string>& analysed_channels() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out{"time_s",
                                 "x_m",
                                 "y_m",
                                 "z_m",
                                 "yaw_rad",
                                 "vx_mps",
                                 "vy_mps",
                                 "roll_rate_radps",
                                 "pitch_rate_radps",
                                 "yaw_rate_radps",
                                 "ax_mps2",
                                 "ay_mps2",
                                 "az_mps2",
                                 "steer_rad",
                                 "steer_command_rad",
                                 "throttle",
                                 "throttle_command",
                                 "brake_pa",
                                 "brake_command_pa",
                                 "gear",
                                 "engine_radps",
                                 "fuel_kg"};
    for (const char* w : {"fl", "fr", "rl", "rr"})
      for (const char* form :
           {"wheel_{}_radps", "wheel_{}_mps", "brake_{}_pa", "brake_{}_command_pa", "fz_{}_n",
            "suspension_{}_m", "brake_disc_{}_k"})
        out.push_back(fmt::format(fmt::runtime(form), w));
    return out;
  }();
  return names;
}

void map_column(const Table& table, std::size_t c, std::set<std::string>& taken, Mapping& mapping) {
  const std::string& column = table.names[c];
  const auto [stem, written] = split_unit(column);
  Guess guess = guess_channel(column, stem, written);
  // The one of our names that others have, too, and mean per cent by it.
  if (column == "throttle" && largest(table.columns[c]) > 1.5) guess.quantity = "share";
  const std::string unit = unit_of(column, guess.word, written);
  ColumnMapping m{column, guess.channel};
  const std::string why = guess.word == "yaw" && north_yaw(table) ? "its name says nothing known"
                                                                  : doubt(table, c, guess, unit);
  if (!why.empty()) {
    mapping.notes.push_back(fmt::format("column '{}' is not used: {}", column, why));
    return;
  }
  if (!taken.insert(m.channel).second) {
    mapping.notes.push_back(
        fmt::format("column '{}' is not used: {} comes from another", column, m.channel));
    return;
  }
  if (has_quantity(guess))
    put_scale(table.columns[c], largest_of_kind(table, c, guess), guess.quantity, unit, m, mapping);
  const ColumnMapping* const ahead = find_channel(mapping, "vx_mps");
  if (m.channel == "vy_mps" && mapping.guessed.contains("vy_mps") && ahead != nullptr &&
      mapping.guessed.contains("vx_mps"))
    m.scale = ahead->scale;
  put_held(table.columns[c], m, mapping);
  mapping.columns.push_back(m);
  if (guess.second.empty() || !taken.insert(guess.second).second) return;
  m.channel = guess.second;
  mapping.columns.push_back(m);
}

bool is_called(const std::string& column, std::string_view channel) {
  for (const std::string& word : words_of_column(column, split_unit(column).first))
    for (const Alias& alias : aliases())
      if (alias.channel == channel && std::any_of(alias.names.begin(), alias.names.end(),
                                                  [&](const char* name) { return word == name; }))
        return true;
  return false;
}

void map_clock(const Table& table, std::size_t c, Mapping& mapping) {
  ColumnMapping m{table.names[c], "time_s"};
  put_scale(table.columns[c], largest(table.columns[c]), "time", split_unit(m.column).second, m,
            mapping);
  mapping.columns.insert(mapping.columns.begin(), m);
}

void settle_pressures(Mapping& mapping) {
  const auto has = [&](const std::string& channel) {
    return std::any_of(mapping.columns.begin(), mapping.columns.end(),
                       [&](const ColumnMapping& m) { return m.channel == channel; });
  };
  const bool front = has("brake_fl_pa") && has("brake_fr_pa"),
             rear = has("brake_rl_pa") && has("brake_rr_pa"), all = has("brake_pa");
  if (front && rear && all) {
    mapping.notes.emplace_back("brake_pa is not used: every wheel has a pressure of its own");
    std::erase_if(mapping.columns, [](const ColumnMapping& m) { return m.channel == "brake_pa"; });
  }
  if (front == rear || all) return;
  const std::array<std::string, 2> wheels =
      front ? std::array<std::string, 2>{"brake_fl_pa", "brake_fr_pa"}
            : std::array<std::string, 2>{"brake_rl_pa", "brake_rr_pa"};
  const auto column = [&](const std::string& channel) {
    return std::find_if(mapping.columns.begin(), mapping.columns.end(),
                        [&](const ColumnMapping& m) { return m.channel == channel; })
        ->column;
  };
  if (column(wheels[0]) != column(wheels[1])) return;  // a sensor at every wheel of one axle
  std::erase_if(mapping.columns, [&](const ColumnMapping& m) { return m.channel == wheels[1]; });
  for (ColumnMapping& m : mapping.columns)
    if (m.channel == wheels[0]) {
      m.channel = "brake_pa";
      mapping.notes.push_back(
          fmt::format("brake_pa from '{}': pressures of the other axle are not in this log; this "
                      "one stands for all wheels",
                      m.column));
    }
}

}  // namespace explain
