// Braking runs whose truth is known.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/random.h"
#include "recorded_drive.h"
#include "recording/channels.h"

namespace test_drive {

/// Eight runs on a plane from 72 m/s, each with pulses of its own pressures; `apart`: the share of
/// the rear differs from run to run.
inline Drive brake_tests(const vehicle::Car<double>& car, std::uint64_t seed, bool apart) {
  using namespace vehicle;  // NOLINT: names of one library
  const Road road;
  base::Random dice = base::random_of(seed, "pressures");
  Drive out;
  for (const std::string& name : recording::telemetry_channels()) out.telemetry.add(name, {});
  std::vector<double> row(recording::telemetry_channels().size());
  for (int run = 0; run < 8; ++run) {
    StartOptions begin;
    begin.speed_mps = 72.0;
    begin.gear = 6;
    begin.disc_k = 350.0 + 60.0 * run;
    begin.y_m = 300.0 * run;  // another place
    Simulation<double> sim = start(car, road, begin);
    Detail<double> detail{};
    const double front_pa = dice.uniform(1e6, 4.5e6), share = apart ? dice.uniform(0.2, 0.9) : 0.6;
    for (std::size_t k = 0; sim.state[kVx] > 25.0 && k < 60000; ++k) {
      Controls<double> controls{};
      controls.gear_command = 6;
      if (k > 2000 && (k / 1000) % 3 != 0)
        controls.brake_command_pa = {front_pa, front_pa, share * front_pa, share * front_pa};
      const State<double> before = sim.state;
      const double time_s = sim.time_s + 100.0 * run;
      const StepResult result = step(car, sim, controls, road, StepOptions{}, detail);
      if (!result.ok()) throw std::runtime_error(describe(result, time_s, 0.0, 0.0));
      if (k % 20 != 0 || k < 1500) continue;
      fill_telemetry(time_s, before, detail, controls, 0.0, 0.0, row);
      for (std::size_t i = 0; i < row.size(); ++i) out.telemetry.columns[i].push_back(row[i]);
    }
  }
  return out;
}

/// What a race logger writes of them, with the discs' true temperatures.
inline recording::Table logged_brake_tests(const vehicle::Car<double>& car, std::uint64_t seed,
                                           bool apart) {
  const Drive drive = brake_tests(car, seed, apart);
  recording::Table out = logged(drive, true, seed, true);
  for (const char* const channel :
       {"brake_disc_fl_k", "brake_disc_fr_k", "brake_disc_rl_k", "brake_disc_rr_k"})
    out.add(channel, *drive.telemetry.find(channel));
  return out;
}

}  // namespace test_drive
