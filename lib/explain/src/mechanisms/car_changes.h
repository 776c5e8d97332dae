// What findings change in a vehicle folder.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "explain/findings.h"
#include "explain/signals.h"
#include "vehicle/vehicle_file.h"

namespace explain {

std::string name_of(vehicle::Parameter p);
std::string name_of(vehicle::Term t);

/// Changes against the stated car. Amounts are what the file is to hold, not differences.
struct CarChanges {
  const vehicle::Vehicle& car;
  const std::vector<Signals>& logs;
  std::map<std::string, double> parameters{}, terms{};
  std::array<std::map<std::string, double>, 2> tyre{};  ///< keywords of the tyre files
  std::map<std::string, vehicle::Map2> maps{};
  bool strip = false;    ///< contact with a strip of road
  double fuel_kg = 0.0;  ///< on board where a log begins
  std::vector<std::string> remarks{};

  bool none() const;
  void set(vehicle::Parameter p, double value) { parameters[name_of(p)] = value; }
  void set(vehicle::Term t, double amount) { terms[name_of(t)] = amount; }
  /// As changed so far.
  double now(vehicle::Parameter p) const;
  /// The constants that the amount of a finding goes with: all its parameters but the first.
  void set_constants(const Finding& f);
};

/// Calls f(speed, yaw rate, lateral speed) at every step where the first two are known; the third
/// is 0 where it is not.
template <class F>
void at_speeds(const std::vector<Signals>& logs, F&& f) {
  for (const Signals& s : logs)
    for (std::size_t i = 0; i < s.n; ++i) {
      const double speed = s.x[kVx][i];
      const double rate = s.present[kYawRate] ? s.x[kYawRate][i] : s.dx[kYaw][i];
      if (std::isfinite(speed) && std::isfinite(rate) && speed > 6)
        f(speed, rate, std::isfinite(s.x[kVy][i]) ? s.x[kVy][i] : 0.0);
    }
}

}  // namespace explain
