// Racelogic's .vbo: sections in square brackets, values separated by blanks. Times are hours,
// minutes and seconds in one number, places are minutes of arc, longitudes positive to the west.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/text_lines.h"
#include "readers.h"

namespace recording {
namespace {

struct Known {
  std::string_view name, unit;
};
/// What every receiver writes; the units of all others are listed in the file.
constexpr Known kKnown[] = {{"sats", "1"},          {"time", "s"},         {"lat", "deg"},
                            {"long", "deg"},        {"velocity", "km/h"},  {"heading", "deg"},
                            {"height", "m"},        {"vert-vel", "m/s"},   {"event", "1"},
                            {"solution_type", "1"}, {"avifileindex", "1"}, {"avitime", "ms"},
                            {"avisynctime", "ms"},  {"event-1", "1"}};

std::string named_unit(std::string_view unit) {
  return unit == "(null)" ? std::string() : std::string(unit);
}

struct Sections {
  std::vector<std::string> units, names;
  std::size_t data_line = 0;
  std::string_view data;
};

Sections sections_of(std::string_view text) {
  Sections out;
  base::Lines lines(text);
  std::string_view line;
  std::string section;
  while (lines.next(line)) {
    line = base::trimmed(line);
    if (line.starts_with('[') && line.ends_with(']')) {
      section = line.substr(1, line.size() - 2);
      if (section == "data") {
        out.data = lines.rest();
        out.data_line = lines.number();
        return out;
      }
      continue;
    }
    if (line.empty()) continue;
    if (section == "channel units") out.units.push_back(named_unit(line));
    if (section == "column names")
      while (!line.empty())
        if (const std::string_view word = base::take_word(line); !word.empty())
          out.names.emplace_back(word);
  }
  return out;
}

/// From the last column backwards: older files list no unit for the sample period, newer ones do.
void give_units(const std::vector<std::string>& units, std::vector<Channel>& channels) {
  std::size_t left = units.size();
  for (std::size_t c = channels.size(); c-- > 0;) {
    const auto known = std::find_if(std::begin(kKnown), std::end(kKnown),
                                    [&](const Known& k) { return k.name == channels[c].name; });
    if (known != std::end(kKnown))
      channels[c].unit = known->unit;
    else if (left > 0)
      channels[c].unit = units[--left];
  }
}

std::vector<double>* channel_of(Log& log, std::string_view name) {
  for (Channel& channel : log.channels)
    if (channel.name == name) return &channel.values;
  return nullptr;
}

void to_plain_units(Log& log, const std::string& name) {
  std::vector<double>* const time = channel_of(log, "time");
  if (time == nullptr)
    throw base::Error(name + ": no column 'time' under [column names]; the file is damaged");
  double days = 0.0, last = 0.0;
  for (double& t : *time) {
    const double hours = std::floor(t / 10000.0), minutes = std::floor((t - hours * 1e4) / 100.0);
    t = hours * 3600.0 + minutes * 60.0 + (t - hours * 1e4 - minutes * 100.0);
    if (!std::isfinite(t)) continue;
    if (t + days < last - 43200.0) days += 86400.0;  // midnight
    last = t += days;
  }
  if (std::vector<double>* const latitude = channel_of(log, "lat"))
    for (double& value : *latitude) value /= 60.0;
  if (std::vector<double>* const longitude = channel_of(log, "long"))
    for (double& value : *longitude) value /= -60.0;
}

}  // namespace

bool is_racelogic_vbo(std::string_view bytes) {
  const std::string_view head = bytes.substr(0, std::min<std::size_t>(bytes.size(), 1 << 16));
  return head.find("[column names]") != std::string_view::npos;
}

Log parse_racelogic_vbo(std::string_view text, const std::string& name) {
  const Sections sections = sections_of(text);
  if (sections.names.empty() || sections.data.empty())
    throw base::Error(fmt::format("{}: a Racelogic log without {}; the file is damaged", name,
                                  sections.names.empty() ? "[column names]" : "[data]"));
  Log log{"Racelogic .vbo", {}, true};
  for (const std::string& column : sections.names) log.channels.push_back({column, "", 0.0, {}, 0});
  give_units(sections.units, log.channels);
  const std::size_t columns = log.channels.size();
  base::Lines lines(sections.data);
  std::string_view line;
  std::vector<std::string_view> cells;
  while (lines.next(line)) {
    const bool last = lines.rest().empty();
    cells.clear();
    while (!line.empty())
      if (const std::string_view word = base::take_word(line); !word.empty()) cells.push_back(word);
    if (cells.empty()) continue;
    if (cells.size() != columns) {
      if (last) break;  // cut off
      throw base::Error(fmt::format("{}:{}: {} cells, [column names] has {}", name,
                                    sections.data_line + lines.number(), cells.size(), columns));
    }
    for (std::size_t c = 0; c < columns; ++c) {
      const auto value = base::to_number<double>(cells[c]);
      const bool good = value && std::isfinite(*value);
      if (!good) ++log.channels[c].words;
      log.channels[c].values.push_back(good ? *value : std::nan(""));
    }
  }
  if (log.channels[0].values.empty()) throw base::Error(name + ": no whole line under [data]");
  to_plain_units(log, name);
  set_rates(log, *channel_of(log, "time"));
  number_names(log.channels);
  return log;
}

}  // namespace recording
