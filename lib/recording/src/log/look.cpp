#include "recording/look.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "readers.h"

namespace recording {

const Channel* clock_of(const Log& log) {
  for (const Channel& channel : log.channels) {
    std::string word;
    for (const char c : channel.name)
      if (std::isalnum(static_cast<unsigned char>(c)) != 0)
        word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (word.starts_with("time") || word == "t" || word == "ts" || word.starts_with("zeit") ||
        word == "sessiontime" || word == "logtime" || word.starts_with("utc") ||
        word.ends_with("timesec") || word.ends_with("timestamp"))
      return &channel;
  }
  return nullptr;
}

std::vector<double> clock_of_rows(const Log& log) {
  const Channel* const clock = clock_of(log);
  if (clock == nullptr) return {};
  std::vector<double> time_s = clock->values;
  if (clock->unit == "ms" || clock->name.find("ms") != std::string::npos)
    for (double& t : time_s) t *= 1e-3;
  return time_s;
}

double share_held(const std::vector<double>& values) {
  std::size_t same = 0, seen = 0, run = 0, longest = 0;
  double last = std::numeric_limits<double>::quiet_NaN();
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    ++seen;
    run = value == last ? run + 1 : 0;
    same += value == last ? 1 : 0;
    longest = std::max(longest, run);
    last = value;
  }
  return seen <= longest + 20
             ? 0.0
             : static_cast<double>(same - longest) / static_cast<double>(seen - longest);
}

bool is_dead(const std::vector<double>& values) {
  constexpr std::size_t kEnough = 50;
  double first = std::numeric_limits<double>::quiet_NaN();
  std::size_t seen = 0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    if (seen++ == 0) first = value;
    if (value != first) return false;
  }
  return seen >= kEnough;
}

std::vector<ChannelLook> look_at_channels(const Log& log) {
  std::vector<ChannelLook> out;
  for (const Channel& channel : log.channels) {
    ChannelLook look{.name = channel.name,
                     .unit = channel.unit,
                     .rate_hz = channel.rate_hz,
                     .words = channel.words,
                     .held = share_held(channel.values),
                     .dead = is_dead(channel.values)};
    for (const double value : channel.values) {
      if (!std::isfinite(value)) continue;
      look.least = look.samples == 0 ? value : std::min(look.least, value);
      look.greatest = look.samples == 0 ? value : std::max(look.greatest, value);
      ++look.samples;
    }
    out.push_back(std::move(look));
  }
  return out;
}

}  // namespace recording
