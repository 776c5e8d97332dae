// The car against recordings of another simulator, TUMFTM Open-Car-Dynamics: the same car with its
// true parameters, driven by the recorded controls with crgdrive's own replay.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "base/read_file.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/recorded_car.h"
#include "vehicle/replay.h"

namespace recorded_simulator_test {

using namespace vehicle;  // NOLINT: a test of this library

/// "fz_fl_n" -> "fz" and so on: one row for four wheels.
std::string group(const std::string& channel) {
  for (const char* const wheels : {"fz", "suspension", "wheel"})
    if (channel.starts_with(std::string(wheels) + "_")) return wheels;
  return channel;
}

/// A logger cuts the noise of a pedal at its stop off, which leaves 12 kPa of pressure and takes
/// 0.0017 of the throttle in the mean: 37 N of braking, 13 N less of engine. As driven: at the
/// stop.
void put_pedals_at_their_stops(recording::Recording& recording) {
  for (std::size_t c = 0; c < recording.table.names.size(); ++c) {
    const std::string& name = recording.table.names[c];
    for (double& value : recording.table.columns[c]) {
      if (name.starts_with("brake") && value < 1e5) value = 0.0;
      if (name == "throttle" && value > 0.985) value = 1.0;
      if (name == "throttle" && value < 0.012) value = 0.0;
    }
  }
}

/// The recording with the noise of its logger added once more: what noise in commands and starting
/// states does to a replay is the difference of the two.
recording::Recording noisier(const recording::Recording& recording, const nlohmann::json& noise,
                             std::uint64_t seed) {
  recording::Recording out = recording;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (std::size_t c = 0; c < out.table.names.size(); ++c) {
    const std::string& name = out.table.names[c];
    std::string kind = group(name);
    if (name.starts_with("steer")) kind = "steer";
    if (name.starts_with("brake")) kind = "brake";
    if (name.starts_with("throttle")) kind = "throttle";
    if (!noise.contains(kind)) continue;
    for (double& value : out.table.columns[c])
      value += noise.at(kind).get<double>() * normal(random);
  }
  return out;
}

struct Sum {
  double squares = 0.0, carried = 0.0;
  std::size_t samples = 0, carried_samples = 0;
};
using Sums = std::map<std::string, Sum>;

/// Errors of the car on one recording, added to `sums`.
void add_replay(const Car<double>& car, const recording::Recording& recording,
                const recording::Recording& noisy, double window_s, Sums& sums) {
  ReplayOptions options;
  options.window_s = window_s;
  options.fuel_kg = 0.0;
  const ReplayResult clean = replay(car, Road(), recording, options);
  const ReplayResult shaken = replay(car, Road(), noisy, options);
  EXPECT_TRUE(clean.problems.empty());
  ASSERT_EQ(clean.telemetry.rows(), shaken.telemetry.rows());
  for (const ChannelError& e : clean.errors) {
    Sum& sum = sums[group(e.channel)];
    sum.squares += static_cast<double>(e.samples) * e.rmse * e.rmse;
    sum.samples += e.samples;
    const auto *const one = clean.telemetry.find(e.channel), *const other =
                                                                 shaken.telemetry.find(e.channel);
    if (one == nullptr) continue;
    for (std::size_t i = 0; i < one->size(); ++i)
      sum.carried += ((*one)[i] - (*other)[i]) * ((*one)[i] - (*other)[i]);
    sum.carried_samples += one->size();
  }
}

// Summed up in docs/evidence.md. `noise` is that of the logger; `carried` what noise in commands
// and starting states makes of a replay; `rest` is what remains of the error's square beside both.
TEST(SlowRecordedSimulator, IsFollowedWithinTheNoiseOfTheLogs) {
  const std::string folder = places::data() + "/ocd_trials";
  if (!std::filesystem::exists(folder + "/truth.json"))
    GTEST_SKIP() << "no recordings of Open-Car-Dynamics here";
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const nlohmann::json truth =
      base::parse_json<nlohmann::json>(base::read_file(folder + "/truth.json", 1u << 24));
  const nlohmann::json& noise = truth.at("noise_sd");
  std::map<std::pair<bool, double>, Sums> all;  // by (whole car, window)
  for (const nlohmann::json& trial : truth.at("trials")) {
    const std::string id = trial.at("id");
    if (trial.at("class") != "none" || (!heavy && id != "t01")) continue;
    recording::Recording recording = support::recorded_log(folder + "/" + id + ".csv.xz");
    put_pedals_at_their_stops(recording);
    recording::Recording noisy = noisier(recording, noise, 1);
    put_pedals_at_their_stops(noisy);
    support::RecordedCar stated = support::recorded_car(folder, trial.at("parameter_factors"));
    for (const bool whole : {true, false}) {
      // The other simulator's wheels act on the body by their forces only.
      stated.terms[Term::gyroscopic] = stated.terms[Term::wheel_reaction] = whole ? 1.0 : 0.0;
      const Car<double> car = make_car(stated.files, stated.parameters, stated.terms);
      for (const double window_s : {0.6, 2.0, 8.0}) {
        if (!heavy && window_s < 8.0) continue;
        add_replay(car, recording, noisy, window_s, all[{whole, window_s}]);
      }
    }
  }
  fmt::print("{:<22} {:>6} {:<15} {:>9} {:>8} {:>8} {:>8} {:>10}\n", "car", "window", "channel",
             "RMSE", "noise", "carried", "rest", "rest/noise");
  for (const auto& [key, sums] : all) {
    const auto [whole, window_s] = key;
    for (const std::string channel : {"yaw_rate_radps", "vy_mps", "ax_mps2", "ay_mps2", "fz",
                                      "suspension", "vx_mps", "wheel"}) {
      const Sum& sum = sums.at(channel);
      const double sd = noise.at(channel), square = sum.squares / static_cast<double>(sum.samples);
      const double carried = sum.carried / static_cast<double>(sum.carried_samples);
      const double rest = std::sqrt(std::max(0.0, square - sd * sd - carried));
      fmt::print("{:<22} {:>6} {:<15} {:>9.4g} {:>8.4g} {:>8.4g} {:>8.4g} {:>10.2f}\n",
                 whole ? "whole" : "wheels by forces only", window_s, channel, std::sqrt(square),
                 sd, std::sqrt(carried), rest, rest / sd);
      support::figure_of_case(whole ? "whole" : "forces", rest / sd);
      const bool speed = channel == "vx_mps" || channel == "wheel";  // drifts: nothing holds it
      EXPECT_LT(rest, (whole   ? 1.8
                       : speed ? 0.75
                               : 0.5) *
                          sd)
          << channel << " " << window_s << " s";
    }
  }
}

}  // namespace recorded_simulator_test
