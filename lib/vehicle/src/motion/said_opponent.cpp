#include "vehicle/said_opponent.h"

#include <charconv>
#include <cmath>

namespace vehicle {

SaidOpponent said_opponent(const std::string& said) {
  const std::size_t at = said.rfind('@');
  if (at == std::string::npos || at == 0) return {said, {}, {}};
  double value = 0.0;
  const char* const last = said.data() + said.size() - 1;
  const auto [end, error] = std::from_chars(said.data() + at + 1, last, value);
  if (error != std::errc() || end != last || !std::isfinite(value)) return {said, {}, {}};
  const std::string path = said.substr(0, at);
  if (*last == 's') return {path, value, {}};
  if (*last == 'm') return {path, {}, value};
  return {said, {}, {}};
}

}  // namespace vehicle
