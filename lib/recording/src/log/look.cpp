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

double scale_of_moments(double largest) {
  if (largest > 6e17) return 1e-9;
  if (largest > 6e14) return 1e-6;
  return largest > 6e11 ? 1e-3 : 1.0;
}

std::vector<double> clock_of_rows(const Log& log) {
  const Channel* const clock = clock_of(log);
  if (clock == nullptr) return {};
  std::vector<double> time_s = clock->values;
  double largest = 0.0;
  for (const double t : time_s)
    if (std::isfinite(t)) largest = std::max(largest, std::abs(t));
  const auto in = [&](const std::string& unit) {
    return clock->unit == unit || clock->name.ends_with("_" + unit) ||
           clock->name.find("(" + unit + ")") != std::string::npos ||
           clock->name.find("[" + unit + "]") != std::string::npos;
  };
  const double scale = in("ms")   ? 1e-3
                       : in("us") ? 1e-6
                       : in("ns") ? 1e-9
                                  : scale_of_moments(largest);
  for (double& t : time_s) t *= scale;
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
