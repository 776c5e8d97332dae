#include "recording/log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "base/error.h"
#include "base/read_file.h"
#include "base/text_lines.h"
#include "readers.h"

namespace recording {
namespace {

constexpr std::size_t kLargestFileBytes = std::size_t{1} << 30;

/// The samples of `channel` in `rows` rows of `step_s`.
std::vector<double> spread(const Channel& channel, std::size_t rows, double step_s) {
  std::vector<double> out(rows, std::numeric_limits<double>::quiet_NaN());
  const std::vector<double>& x = channel.values;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double row = std::round(static_cast<double>(k) / channel.rate_hz / step_s);
    if (!(row < static_cast<double>(rows))) break;
    // Where the row lies beside the sample, in samples.
    const double beside = row * step_s * channel.rate_hz - static_cast<double>(k);
    double value = x[k];
    if (beside > 1e-9 && k + 1 < x.size()) value += beside * (x[k + 1] - x[k]);
    if (beside < -1e-9 && k > 0) value -= beside * (x[k - 1] - x[k]);
    out[static_cast<std::size_t>(row)] = value;
  }
  return out;
}

}  // namespace

std::string field(std::string_view bytes, std::size_t at, std::size_t length) {
  std::string_view text = bytes.substr(at, length);
  text = text.substr(0, text.find('\0'));
  return std::string(base::trimmed(text));
}

void number_names(std::vector<Channel>& channels) {
  std::set<std::string> seen;
  for (const Channel& channel : channels) seen.insert(channel.name);
  std::map<std::string, int> count;
  for (Channel& channel : channels) {
    const std::string name = channel.name.empty() ? "unnamed" : channel.name;
    int& number = count[name];
    if (++number == 1 && !channel.name.empty()) continue;
    do channel.name = fmt::format("{} #{}", name, number);
    while (!seen.insert(channel.name).second && ++number > 0);
  }
}

void set_rates(Log& log, const std::vector<double>& time_s) {
  std::vector<double> steps;  // the median: clocks have gaps and jumps
  for (std::size_t i = 1; i < time_s.size(); ++i)
    if (time_s[i] > time_s[i - 1]) steps.push_back(time_s[i] - time_s[i - 1]);
  if (steps.empty()) return;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  for (Channel& channel : log.channels) {
    const auto measured = std::count_if(channel.values.begin(), channel.values.end(),
                                        [](double v) { return std::isfinite(v); });
    channel.rate_hz =
        static_cast<double>(measured) / static_cast<double>(channel.values.size()) / *middle;
  }
}

Log parse_log(std::string_view bytes, const std::string& name) {
  if (is_motec_ld(bytes)) return parse_motec_ld(bytes, name);
  if (is_iracing_ibt(bytes)) return parse_iracing_ibt(bytes, name);
  if (is_racelogic_vbo(bytes)) return parse_racelogic_vbo(bytes, name);
  if (bytes.substr(0, 4096).find('\0') != std::string_view::npos)
    throw base::Error(
        fmt::format("{}: binary, and neither MoTeC .ld nor iRacing .ibt; export it as CSV", name));
  return parse_csv(bytes, name);
}

Log read_log(const std::string& path) {
  return parse_log(base::read_file(path, kLargestFileBytes), path);
}

Log in_rows(Log log, const std::string& name) {
  if (log.in_rows) return log;
  // The one with most samples: a short one with a high rate would ask for rows without end.
  const auto fastest = std::max_element(
      log.channels.begin(), log.channels.end(),
      [](const Channel& a, const Channel& b) { return a.values.size() < b.values.size(); });
  if (fastest == log.channels.end() || !(fastest->rate_hz > 0))
    throw base::Error(name + ": no channel with samples");
  const std::size_t rows = fastest->values.size();
  const double rate_hz = fastest->rate_hz;
  if (rows > kMostCells / (log.channels.size() + 1))
    throw base::Error(fmt::format("{}: {} rows of {} channels, more than 2 GB; cut the log", name,
                                  rows, log.channels.size()));
  Log out{log.format, {}, true};
  Channel clock{"log time", "s", rate_hz, {}, 0};
  for (std::size_t i = 0; i < rows; ++i) clock.values.push_back(static_cast<double>(i) / rate_hz);
  out.channels.push_back(std::move(clock));
  for (Channel& channel : log.channels) {
    if (channel.values.size() != rows || channel.rate_hz != rate_hz)
      channel.values = spread(channel, rows, 1.0 / rate_hz);
    out.channels.push_back(std::move(channel));
  }
  number_names(out.channels);
  return out;
}

}  // namespace recording
