#include "laps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text_lines.h"
#include "readers.h"
#include "recording/look.h"

namespace recording {
namespace {

constexpr const char* kLap = "beacon lap";
constexpr std::size_t kMostSaid = 30;  // laps

/// The value of an attribute in one tag; nothing where it has none.
std::string_view attribute(std::string_view tag, const std::string& key) {
  const std::string begin = " " + key + "=\"";
  const std::size_t at = tag.find(begin);
  if (at == std::string_view::npos) return {};
  const std::string_view rest = tag.substr(at + begin.size());
  return rest.substr(0, rest.find('"'));
}

/// The moments of the channel with most samples; of a log in rows, of its clock.
std::vector<double> moments(const Log& log, Channel& lap) {
  if (log.in_rows) {
    if (const Channel* clock = clock_by_values(log)) lap.rate_hz = clock->rate_hz;
    return clock_of_rows(log);
  }
  const auto longest = std::max_element(
      log.channels.begin(), log.channels.end(),
      [](const Channel& a, const Channel& b) { return a.values.size() < b.values.size(); });
  if (longest == log.channels.end() || !(longest->rate_hz > 0.0)) return {};
  lap.rate_hz = longest->rate_hz;
  std::vector<double> out(longest->values.size());
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = static_cast<double>(k) / lap.rate_hz;
  return out;
}

}  // namespace

void add_laps(Log& log, const std::vector<double>& beacons_s, const std::string& from) {
  Channel lap;
  lap.name = kLap;
  const std::vector<double> time_s = moments(log, lap);
  if (time_s.empty() || std::any_of(log.channels.begin(), log.channels.end(),
                                    [](const Channel& c) { return c.name == kLap; }))
    return;
  std::vector<double> ends = beacons_s;
  std::sort(ends.begin(), ends.end());
  const auto last =
      std::find_if(time_s.rbegin(), time_s.rend(), [](double t) { return std::isfinite(t); });
  if (last == time_s.rend()) return;
  const auto behind = std::upper_bound(ends.begin(), ends.end(), *last);
  const auto left_out = ends.end() - behind;
  ends.erase(behind, ends.end());
  if (ends.empty()) return;
  for (const double t : time_s)
    lap.values.push_back(
        std::isfinite(t) ? static_cast<double>(
                               1 + (std::upper_bound(ends.begin(), ends.end(), t) - ends.begin()))
                         : std::numeric_limits<double>::quiet_NaN());
  std::string said;
  for (std::size_t k = 0; k < std::min(ends.size(), kMostSaid); ++k)
    said += fmt::format("{}{:.3f}", k == 0 ? "" : ", ", ends[k]);
  if (ends.size() > kMostSaid) said += fmt::format(" and {} more", ends.size() - kMostSaid);
  log.notes.push_back(
      fmt::format("laps end at {} s, by {}{}", said, from,
                  left_out > 0 ? fmt::format("; {} behind the last sample left out", left_out)
                               : std::string()));
  log.channels.push_back(std::move(lap));
}

void add_laps_of_ldx(Log& log, std::string_view text, const std::string& name) {
  std::vector<double> beacons_s;
  for (std::size_t at = text.find("<Marker "); at != std::string_view::npos;
       at = text.find("<Marker ", at + 1)) {
    const std::size_t end = text.find('>', at);
    if (end == std::string_view::npos) break;
    const std::string_view tag = text.substr(at, end - at);
    if (attribute(tag, "ClassName") != "BCN") continue;
    const auto microseconds = base::to_number<double>(attribute(tag, "Time"));
    if (!microseconds || !std::isfinite(*microseconds)) {
      log.notes.push_back(
          fmt::format("{}: the time of a beacon is '{}', where microseconds from the begin of the "
                      "log are wanted: read without laps",
                      name, std::string(attribute(tag, "Time").substr(0, 40))));
      return;
    }
    beacons_s.push_back(1e-6 * *microseconds);
  }
  add_laps(log, beacons_s, name);
}

}  // namespace recording
