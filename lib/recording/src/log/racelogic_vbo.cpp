// Racelogic's .vbo: sections in square brackets, values separated by blanks. Times are hours,
// minutes and seconds in one number, places are minutes of arc, longitudes positive to the west.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/error.h"
#include "base/text_lines.h"
#include "clock_digits.h"
#include "readers.h"

namespace recording {
namespace {

struct Standard {
  std::string_view name, unit;
};
/// What a receiver may write by itself: [channel units] lists the units of all others. Units that
/// differ between receivers are known from the titles under [header] alone.
constexpr Standard kStandardChannels[] = {{"sats", "1"},         {"time", "s"},
                                          {"lat", "deg"},        {"long", "deg"},
                                          {"lng", "deg"},        {"velocity", "km/h"},
                                          {"heading", "deg"},    {"height", "m"},
                                          {"vert-vel", ""},      {"vertvel", ""},
                                          {"event", "1"},        {"event-1", "1"},
                                          {"event1", "1"},       {"solution_type", "1"},
                                          {"avifileindex", "1"}, {"avitime", "ms"},
                                          {"avisynctime", "ms"}, {"longacc", ""},
                                          {"latacc", ""},        {"glonass_sats", "1"},
                                          {"gps_sats", "1"},     {"velocity_quality", ""},
                                          {"_lat", ""},          {"_long", ""},
                                          {"_velocity", ""},     {"_heading", ""},
                                          {"_height", ""},       {"_vert-vel", ""}};

const Standard* standard_of(std::string name) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto found = std::find_if(std::begin(kStandardChannels), std::end(kStandardChannels),
                                  [&](const Standard& s) { return s.name == name; });
  return found == std::end(kStandardChannels) ? nullptr : found;
}

struct Sections {
  std::vector<std::string> titles, units, names;
  std::size_t units_line = 0, data_line = 0;
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
      if (section == "channel units") out.units_line = lines.number();
      if (section == "data") {
        out.data = lines.rest();
        out.data_line = lines.number();
        return out;
      }
      continue;
    }
    // A blank line there is a channel without a unit.
    if (section == "channel units") out.units.emplace_back(line);
    if (section == "header" && !line.empty()) out.titles.emplace_back(line);
    if (section == "column names")
      while (!line.empty())
        if (const std::string_view word = base::take_word(line); !word.empty())
          out.names.emplace_back(word);
  }
  return out;
}

/// The unit at the end of a title: "velocity kmh".
std::string unit_of_title(const std::string& title) {
  const std::size_t blank = title.find_last_of(" \t");
  if (blank == std::string::npos || !is_unit(std::string_view(title).substr(blank + 1))) return "";
  const std::string unit = title.substr(blank + 1);
  return unit == "kmh" ? "km/h" : unit;  // as others write it
}

/// The channels whose units [channel units] lists, if it is true that titles with a unit mark
/// standard ones (makers of converters do that) and that the sample period is not standard (older
/// receivers list no unit for it).
std::vector<std::size_t> listed_channels(const std::vector<std::string>& titles, bool by_title,
                                         bool period, const std::vector<Channel>& channels) {
  std::vector<std::size_t> out;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const bool standard = standard_of(channels[c].name) != nullptr ||
                          (by_title && c < titles.size() && !unit_of_title(titles[c]).empty()) ||
                          (!period && channels[c].name == "Tsample");
    if (!standard) out.push_back(c);
  }
  return out;
}

/// The file does not say which channels are standard; the number of units does.
void give_listed_units(const Sections& sections, Log& log) {
  const std::vector<std::string>& units = sections.units;
  // Blank lines at the end belong to channels, or part the section from the next: one does.
  std::size_t least = units.size();
  while (least > 0 && units[least - 1].empty()) --least;
  if (least == 0) return;
  const std::size_t most = units.size(), usual = std::max(least, most - 1);
  for (const bool exactly : {true, false}) {
    // What each choice that fits gives: for every channel a unit, or what it had.
    std::vector<std::vector<std::string>> fitting;
    for (const bool by_title : {true, false})
      for (const bool period : {true, false}) {
        const std::vector<std::size_t> listed =
            listed_channels(sections.titles, by_title, period, log.channels);
        const std::size_t count = listed.size();
        if (exactly ? count != usual : count < least || count > most) continue;
        std::vector<std::string>& given = fitting.emplace_back();
        for (const Channel& channel : log.channels) given.push_back(channel.unit);
        for (std::size_t k = 0; k < count; ++k)
          if (!units[k].empty() && units[k] != "(null)") given[listed[k]] = units[k];
      }
    if (fitting.empty()) continue;
    // With blank lines to spare nearly every choice fits: the first is what converters write.
    if (!exactly) fitting.resize(1);
    std::string doubtful;
    for (std::size_t c = 0; c < log.channels.size(); ++c) {
      Channel& channel = log.channels[c];
      const bool same = std::all_of(fitting.begin(), fitting.end(), [&](const auto& given) {
        return given[c] == fitting.front()[c];
      });
      channel.unit = same ? fitting.front()[c] : "";
      if (!same) doubtful += (doubtful.empty() ? "" : ", ") + channel.name;
    }
    if (!doubtful.empty())
      log.notes.push_back(
          fmt::format("[channel units] in line {} fits the channels in more than one way: the "
                      "units of {} are not known",
                      sections.units_line, doubtful));
    return;
  }
  log.notes.push_back(
      fmt::format("[channel units] in line {} lists {} units, which fits no choice of the {} "
                  "channels: none is used",
                  sections.units_line, usual, log.channels.size()));
}

/// From [channel units], the titles, or what all receivers write; otherwise the unit is not known.
void give_units(Sections& sections, Log& log) {
  if (sections.titles.size() != log.channels.size()) sections.titles.clear();
  for (std::size_t c = 0; c < log.channels.size(); ++c) {
    Channel& channel = log.channels[c];
    if (!sections.titles.empty()) channel.unit = unit_of_title(sections.titles[c]);
    const Standard* const standard = standard_of(channel.name);
    // "velocity mi/h": another unit than the usual one, which is not known here.
    const bool says_another = !sections.titles.empty() && channel.unit.empty() &&
                              (channel.name == "velocity" || channel.name == "height") &&
                              sections.titles[c].find_first_of(" \t") != std::string::npos;
    if (channel.unit.empty() && standard != nullptr && !says_another) channel.unit = standard->unit;
  }
  give_listed_units(sections, log);
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
  to_seconds_of_day(*time);
  if (std::vector<double>* const latitude = channel_of(log, "lat"))
    for (double& value : *latitude) value /= 60.0;
  for (const char* word : {"long", "lng"})
    if (std::vector<double>* const longitude = channel_of(log, word))
      for (double& value : *longitude) value /= -60.0;
}

}  // namespace

bool is_racelogic_vbo(std::string_view bytes) {
  const std::string_view head = bytes.substr(0, std::min<std::size_t>(bytes.size(), 1 << 16));
  return head.find("[column names]") != std::string_view::npos;
}

Log parse_racelogic_vbo(std::string_view text, const std::string& name) {
  Sections sections = sections_of(text);
  if (sections.names.empty() || sections.data.empty())
    throw base::Error(fmt::format("{}: a Racelogic log without {}; the file is damaged", name,
                                  sections.names.empty() ? "[column names]" : "[data]"));
  Log log{"Racelogic .vbo", {}, true};
  for (const std::string& column : sections.names) log.channels.push_back({column, "", 0.0, {}, 0});
  give_units(sections, log);
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
