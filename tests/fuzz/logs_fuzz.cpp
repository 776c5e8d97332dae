// Logs of every maker; what is read has channels that fit together.
#include <cmath>

#include "base/error.h"
#include "fuzz/target.h"
#include "laps.h"
#include "recording/log.h"

void fuzz::run(std::string_view bytes) {
  const std::string name = "log";
  recording::Log beside;  // the bytes as the .ldx beside a log
  beside.channels.emplace_back().values.assign(100, 1.0);
  beside.channels.back().rate_hz = 10.0;
  recording::add_laps_of_ldx(beside, bytes, name);
  require(beside.channels.back().values.size() == 100, "laps of the log's length");
  try {
    recording::Log log = recording::parse_log(bytes, name);
    for (const recording::Channel& channel : log.channels) {
      for (const double value : channel.values) require(!std::isinf(value), "finite or empty");
      require(channel.rate_hz >= 0 && std::isfinite(channel.rate_hz), "a rate");
    }
    log = recording::in_rows(std::move(log), name);
    for (const recording::Channel& channel : log.channels)
      require(channel.values.size() == log.channels.front().values.size(), "columns of one length");
  } catch (const base::Error& error) {
    require_refusal(error, name);
  }
}
