#include "sim/opponents.h"

#include <charconv>
#include <cmath>

#include "recording/log_table.h"
#include "recording/table.h"

namespace sim {
namespace {

/// The number before `unit` behind the last @; nothing where there is none.
std::optional<double> after_at(const std::string& said, char unit) {
  const std::size_t at = said.rfind('@');
  if (at == std::string::npos || at == 0 || said.back() != unit) return std::nullopt;
  double value = 0.0;
  const char* const last = said.data() + said.size() - 1;
  const auto [end, error] = std::from_chars(said.data() + at + 1, last, value);
  if (error != std::errc() || end != last || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

OpponentDrive read_opponent(const std::string& said) {
  const std::optional<double> ahead_s = after_at(said, 's'), ahead_m = after_at(said, 'm');
  const std::string path = ahead_s || ahead_m ? said.substr(0, said.rfind('@')) : said;
  recording::Table log = recording::read_log_table(path);
  if (log.find("x_m") == nullptr && log.find("y_m") == nullptr)
    for (std::string& name : log.names) {
      if (name == "car.x") name = "x_m";
      if (name == "car.y") name = "y_m";
    }
  return {path, vehicle::make_opponent(log, ahead_s.value_or(0.0), path), ahead_m};
}

}  // namespace sim
