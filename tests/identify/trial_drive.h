// Drives of the blind trials' two cars, which share no equation with lib/vehicle.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "recording/log_table.h"
#include "support/temporary_folder.h"
#include "trials/blind_car.h"
#include "trials/drive.h"
#include "trials/truth_car_electric.h"

namespace test_drive {

/// A car of the trials, a drive of it, and what a simulation is told of both.
struct Trial {
  trials::Track track = trials::make_track(220, 0.2, 0.1, 0.03, 2.0);
  trials::Variant truth;
  trials::Drive drive;
  support::TemporaryFolder folder;

  Trial(bool third, int laps, unsigned long long seed) {
    track.hill = {2.0, 0.5, 0.2};
    track.bank_base = 0.01;
    if (third) truth.car = trials::electric_car(trials::TyreLaw::kTable);
    drive = trials::drive(truth, track, {.laps = laps, .seed = seed}, nullptr);
    trials::write_road(track, track, trials::TruthCar{}, folder.path("track.crg"));
    trials::Random dice{seed * 1000003ull};
    for (int k = 0; k < 5; ++k) dice.uniform();
    trials::Question nothing;
    nothing.kind = "none";
    const trials::Deviations off = trials::deviate(nothing, {}, dice);
    for (std::size_t k = 0; k < off.share.size(); ++k)
      fmt::print("{} {:+.1f} %, ", trials::kParameters[k].name, 100.0 * off.share[k]);
    fmt::print("truth over stated\n");
    trials::write_car(trials::stated_car(truth, off, {}, dice), folder.path(""));
  }

  /// `sensors`: what they do beyond noise.
  recording::Recording log(double hz, bool optical, double longest_s,
                           const std::vector<trials::Effect>& sensors = {}) {
    const std::vector<trials::Column> columns =
        trials::columns({.vy = optical, .reached = truth.car.electric.has_value()});
    trials::Random dice{17};
    std::vector<trials::Row> rows = drive.row;
    rows.resize(std::min(rows.size(), static_cast<std::size_t>(longest_s / trials::kRow_s)));
    const std::string text = trials::csv(rows, columns, hz, sensors, dice);
    return recording::make_recording(recording::parse_log_table(text, "run.csv"), "run.csv");
  }

  /// Of tyre `wheel`: fx with rolling resistance, fy, fz, kappa, tan alpha.
  double of(double time_s, std::size_t wheel, std::size_t what) const {
    const auto row = static_cast<std::size_t>(std::lround(time_s / trials::kRow_s));
    const double* const tyre = &drive.row[row][trials::kTyre + wheel * trials::kTyreNumbers];
    return what == 0 ? tyre[0] - truth.car.rolling * tyre[2] : tyre[what];
  }
};

}  // namespace test_drive
