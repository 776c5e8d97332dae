#include "vehicle/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "support/figure.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "test_roads.h"
#include "vehicle/error.h"
#include "vehicle/lap.h"
#include "vehicle/vehicle_file.h"

namespace replay_test {

using namespace vehicle;  // NOLINT: a test of this library

class Replay : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    vehicle_ = new Vehicle(read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml"));
    surface_ = new crg::Surface(stadium());
    car_ = new Car<double>(make_car(vehicle_->files, vehicle_->parameters, vehicle_->terms));
    lap_ = new recording::Table(drive_laps(*car_, Road(*surface_)).telemetry);
  }
  static void TearDownTestSuite() {
    delete lap_;
    delete car_;
    delete surface_;
    delete vehicle_;
  }
  static ChannelError error_of(const ReplayResult& result, const std::string& channel) {
    for (const ChannelError& e : result.errors)
      if (e.channel == channel) return e;
    ADD_FAILURE() << "no " << channel;
    return {};
  }
  static recording::Table without(const std::vector<std::string>& names) {
    recording::Table out;
    for (std::size_t c = 0; c < lap_->names.size(); ++c)
      if (std::find(names.begin(), names.end(), lap_->names[c]) == names.end())
        out.add(lap_->names[c], lap_->columns[c]);
    return out;
  }
  static Vehicle* vehicle_;
  static crg::Surface* surface_;
  static Car<double>* car_;
  static recording::Table* lap_;
};
Vehicle* Replay::vehicle_ = nullptr;
crg::Surface* Replay::surface_ = nullptr;
Car<double>* Replay::car_ = nullptr;
recording::Table* Replay::lap_ = nullptr;

// The same car on its own recording: what remains comes from commands between the recorded rows
// and from states that telemetry does not have (measured: 8 mm, 6 mm, 0.016 m/s).
TEST_F(Replay, RepeatsItsOwnRecording) {
  const ReplayResult r = replay(*car_, Road(*surface_), recording::make_recording(*lap_, "lap"));
  EXPECT_THAT(r.problems, ::testing::IsEmpty());
  EXPECT_GE(r.windows, 10u);
  support::figure("along_m", error_of(r, "along_m").rmse);
  support::figure("lateral_m", error_of(r, "lateral_m").rmse);
  support::figure("vx_mps", error_of(r, "vx_mps").rmse);
  EXPECT_LT(error_of(r, "along_m").rmse, 0.05);
  EXPECT_LT(error_of(r, "lateral_m").rmse, 0.05);
  EXPECT_LT(error_of(r, "vx_mps").rmse, 0.05);
  // The trivial predictors are no match.
  EXPECT_GT(error_of(r, "along_m").hold_rmse, 100 * error_of(r, "along_m").rmse);
  EXPECT_GT(error_of(r, "vx_mps").trend_rmse, 10 * error_of(r, "vx_mps").rmse);
  EXPECT_EQ(r.telemetry.find("window")->back(), static_cast<double>(r.windows));
  const ReplayResult again =
      replay(*car_, Road(*surface_), recording::make_recording(*lap_, "lap"));
  EXPECT_EQ(r.telemetry.columns, again.telemetry.columns);
}

TEST_F(Replay, ShowsWhatTheCarLacks) {
  Vehicle heavy = *vehicle_;
  heavy.parameters[Parameter::chassis_mass_kg] *= 1.2;
  const Car<double> car = make_car(heavy.files, heavy.parameters, heavy.terms);
  const recording::Recording recording = recording::make_recording(*lap_, "lap");
  EXPECT_GT(error_of(replay(car, Road(*surface_), recording), "vx_mps").rmse,
            5 * error_of(replay(*car_, Road(*surface_), recording), "vx_mps").rmse);
}

// Errors by hand: speed held at the window's begin against a speed that grows by 2 m/s per second.
TEST_F(Replay, TrivialPredictorsAreWhatTheySay) {
  recording::Table log;
  std::vector<double> t, x, zero, v, yaw;
  for (int i = 0; i <= 250; ++i) {
    const double time = 0.01 * i;
    t.push_back(time);
    v.push_back(20 + 2 * time);
    x.push_back(20 * time + time * time);
    zero.push_back(0);
  }
  log.add("time_s", t);
  log.add("x_m", x);
  log.add("y_m", zero);
  log.add("yaw_rad", zero);
  log.add("vx_mps", v);
  log.add("throttle", zero);
  log.add("steer_rad", zero);
  const ReplayResult r = replay(*car_, Road(), recording::make_recording(log, "log"));
  EXPECT_EQ(r.windows, 1u);
  const ChannelError e = error_of(r, "vx_mps");
  EXPECT_EQ(e.samples, 200u);
  EXPECT_NEAR(e.hold_max, 4.0, 1e-9);
  EXPECT_NEAR(e.trend_max, 0.0, 1e-9);
  // Over 2 s from 21 m/s the place grows by 46 m; the trend's slope is that 0.1 s before.
  EXPECT_NEAR(error_of(r, "along_m").hold_max, 46.0, 1e-9);
  EXPECT_NEAR(error_of(r, "along_m").trend_max, 4.0 + 0.2 * 2.0, 0.1);
  EXPECT_THAT(r.driven_by, ::testing::Contains(::testing::HasSubstr("past the throttle actuator")));
}

TEST_F(Replay, DrivesWithFewerChannelsAndClosesThePath) {
  const recording::Recording few = recording::make_recording(
      without({"steer_command_rad", "throttle_command", "gear", "z_m", "roll_rad", "pitch_rad",
               "engine_radps", "wheel_fl_radps", "wheel_fr_radps", "wheel_rl_radps",
               "wheel_rr_radps", "brake_fl_command_pa", "brake_fr_command_pa",
               "brake_rl_command_pa", "brake_rr_command_pa", "boost", "vy_mps"}),
      "lap");
  const ReplayResult open = replay(*car_, Road(*surface_), few);
  EXPECT_THAT(open.problems, ::testing::IsEmpty());
  EXPECT_LT(error_of(open, "along_m").rmse, 0.1 * error_of(open, "along_m").trend_rmse);
  EXPECT_LT(error_of(open, "lateral_m").rmse, 0.3 * error_of(open, "lateral_m").trend_rmse);
  // Another car leaves the path; the driver brings it back. Without recorded steering he follows
  // by himself, and cuts corners.
  Vehicle worn = *vehicle_;
  worn.parameters[Parameter::rear_tyre_grip] *= 1.1;
  worn.parameters[Parameter::front_tyre_cornering_stiffness] *= 0.8;
  const Car<double> other = make_car(worn.files, worn.parameters, worn.terms);
  ReplayOptions options;
  options.window_s = 6;
  const double open_m = error_of(replay(other, Road(*surface_), few, options), "lateral_m").rmse;
  options.closed_path = true;
  const ReplayResult closed = replay(other, Road(*surface_), few, options);
  EXPECT_THAT(closed.problems, ::testing::IsEmpty());
  EXPECT_LT(error_of(closed, "lateral_m").rmse, 0.5 * open_m);
  const ReplayResult alone = replay(
      *car_, Road(*surface_),
      recording::make_recording(without({"steer_command_rad", "steer_rad"}), "lap"), options);
  EXPECT_THAT(alone.problems, ::testing::IsEmpty());
  EXPECT_LT(error_of(alone, "lateral_m").max, 3.0);
}

// A whole lap in one window. With recorded pedals a car with more drag runs away from it; the push
// that holds it is the drag that the recorded car did not have.
TEST_F(Replay, HoldsTheSpeedOfAWholeLapAndTellsWhatThatTakes) {
  Vehicle draggy = *vehicle_;
  const double more_m2 = 0.2 * draggy.parameters[Parameter::aero_drag_area_m2];
  draggy.parameters[Parameter::aero_drag_area_m2] += more_m2;
  const Car<double> other = make_car(draggy.files, draggy.parameters, draggy.terms);
  const recording::Recording recording = recording::make_recording(*lap_, "lap");
  ReplayOptions options;
  options.window_s = 0.0;
  options.closed_path = true;
  const double away_m = error_of(replay(other, Road(*surface_), recording, options), "along_m").max;
  options.hold_speed = true;
  const ReplayResult own = replay(*car_, Road(*surface_), recording, options);
  const ReplayResult held = replay(other, Road(*surface_), recording, options);
  EXPECT_THAT(held.problems, ::testing::IsEmpty());
  const ChannelError along = error_of(held, "along_m"), speed = error_of(held, "vx_mps");
  // Drag of the difference at the driven speeds; ride heights and yaw change it by less than 1 %.
  // The own car needs a little push, too: he does not steer to the millimetre as in the lap.
  double expected_n = 0.0, pushed_n = 0.0;
  const std::vector<double>& vx_mps = *held.telemetry.find("vx_mps");
  const std::vector<double>& hold_n = *held.telemetry.find("hold_n");
  for (std::size_t i = 0; i < vx_mps.size(); ++i) {
    expected_n +=
        0.5 * draggy.parameters[Parameter::aero_density_kgpm3] * more_m2 * vx_mps[i] * vx_mps[i];
    pushed_n += hold_n[i] - own.hold_mean_n;
  }
  std::printf(
      "own push mean %.1f rms %.1f N; more drag: mean %.1f N of %.1f N; along %.2f m, without %.1f "
      "m; speed %.3f m/s\n",
      own.hold_mean_n, own.hold_rms_n, held.hold_mean_n,
      expected_n / static_cast<double>(vx_mps.size()), along.max, away_m, speed.rmse);
  EXPECT_GT(away_m, 5.0);                         // measured 10.2
  EXPECT_LT(along.max, 0.1);                      // 0.04
  EXPECT_LT(speed.rmse, 0.03);                    // 0.011
  EXPECT_NEAR(pushed_n / expected_n, 1.0, 0.02);  // 0.992
  EXPECT_LT(std::abs(own.hold_mean_n), 5.0);      // 2.4, root mean square 34
  options.driver = true;
  EXPECT_THROW(replay(other, Road(*surface_), recording, options), Error);
}

// No recorded command at all: the driver takes the car along the recorded path for a whole lap.
TEST_F(Replay, LetsTheDriverFollowTheRecordedLine) {
  const recording::Recording path = recording::make_recording(
      without({"steer_command_rad", "steer_rad", "throttle_command", "throttle", "gear",
               "brake_fl_command_pa", "brake_fr_command_pa", "brake_rl_command_pa",
               "brake_rr_command_pa", "brake_fl_pa", "brake_fr_pa", "brake_rl_pa", "brake_rr_pa"}),
      "lap");
  ReplayOptions options;
  options.window_s = 0.0;
  options.driver = true;
  const ReplayResult r = replay(*car_, Road(*surface_), path, options);
  EXPECT_THAT(r.problems, ::testing::IsEmpty());
  EXPECT_EQ(r.windows, 1u);
  std::printf("driver on the recorded line: lateral %.2f m, speed rms %.2f m/s\n",
              error_of(r, "lateral_m").max, error_of(r, "vx_mps").rmse);
  EXPECT_LT(error_of(r, "lateral_m").max, 1.5);  // measured 0.68
  EXPECT_LT(error_of(r, "vx_mps").rmse, 1.5);    // 0.66
  EXPECT_THAT(r.driven_by.front(), ::testing::HasSubstr("the driver"));
}

TEST_F(Replay, DoesNotDriveOverGapsAndSaysWhatIsMissing) {
  recording::Table torn = *lap_;
  for (std::size_t r = 1000; r < torn.rows(); ++r) torn.columns[0][r] += 5;
  const ReplayResult r = replay(*car_, Road(*surface_), recording::make_recording(torn, "lap"));
  EXPECT_LT(error_of(r, "along_m").max, 1.0);
  const auto refusal = [&](const std::vector<std::string>& names) -> std::string {
    try {
      replay(*car_, Road(*surface_), recording::make_recording(without(names), "lap"));
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal({"yaw_rad"}), ::testing::HasSubstr("no channel yaw_rad"));
  EXPECT_THAT(refusal({"steer_rad", "steer_command_rad"}), ::testing::HasSubstr("neither"));
  EXPECT_THAT(refusal({"throttle", "throttle_command"}), ::testing::HasSubstr("neither"));
  ReplayOptions options;
  options.settle_s = 1e4;
  EXPECT_THROW(replay(*car_, Road(*surface_), recording::make_recording(*lap_, "lap"), options),
               Error);
}

// A real drive (25 Hz, two laps) on the flat road between the surveyed edges, by a car of which
// little is known. Measured: along 1.01 m, lateral 0.33 m, yaw rate 0.034 rad/s after up to 2 s on
// the recorded commands; nothing changes: 19.8 m, 1.82 m, 0.077 rad/s.
TEST_F(Replay, PutnamParkIsDrivenCloserThanTheTrivialPredictors) {
  namespace fs = std::filesystem;
  const fs::path data = fs::path(places::data()) / "recordings";
  if (!fs::exists(data / "putnam_run4_2.csv")) GTEST_SKIP() << "the recording is not here";
  const cli::Folder folder;
  const cli::Ran built =
      cli::crgbuild({"from-edges", (data / "putnam_inner_bound.csv").string(),
                     (data / "putnam_outer_bound.csv").string(), "-o", folder.path()});
  ASSERT_EQ(built.code, 0) << built.err;
  const crg::Surface surface(crg::read(folder / "putnam.crg"));
  const fs::path car_folder = fs::path(places::source()) / "vehicles/av21";
  const Vehicle v = read_vehicle((car_folder / "vehicle.yaml").string());
  const Car<double> car = make_car(v.files, v.parameters, v.terms);
  const recording::Recording recording = recording::read_recording(
      (data / "putnam_run4_2.csv").string(),
      recording::read_mapping((car_folder / "putnam_mapping.yaml").string()));
  const ReplayResult r = replay(car, Road(surface), recording);
  EXPECT_THAT(r.problems, ::testing::IsEmpty());
  EXPECT_GT(r.windows, 200u);
  for (const std::string channel : {"along_m", "lateral_m", "yaw_rate_radps", "vx_mps"}) {
    support::figure(channel, error_of(r, channel).rmse);
    support::figure("trend_" + channel, error_of(r, channel).trend_rmse);
  }
  EXPECT_LT(error_of(r, "along_m").rmse, 0.1 * error_of(r, "along_m").hold_rmse);
  EXPECT_LT(error_of(r, "lateral_m").rmse, 0.25 * error_of(r, "lateral_m").trend_rmse);
  EXPECT_LT(error_of(r, "yaw_rate_radps").rmse, 0.6 * error_of(r, "yaw_rate_radps").trend_rmse);
}

// One recorded speed that cannot be: the car that is put on it runs away, and its tyres burn. The
// windows behind it begin with the tyres of before.
TEST_F(Replay, GoesOnFromBeforeACarThatRanAway) {
  const ReplayResult sound =
      replay(*car_, Road(*surface_), recording::make_recording(*lap_, "lap"));
  const std::vector<double>& windows = *sound.telemetry.find("window");
  const auto third = std::find(windows.begin(), windows.end(), 3.0);
  const double begin_s =
      (*sound.telemetry.find("time_s"))[static_cast<std::size_t>(third - windows.begin())];
  recording::Table lap = without({"tyre_fl_k", "tyre_fr_k", "tyre_rl_k", "tyre_rr_k"});
  const std::vector<double>& time = *lap_->find("time_s");
  for (std::size_t c = 0; c < lap.names.size(); ++c)
    if (lap.names[c] == "vx_mps")
      for (std::size_t k = 0; k < time.size(); ++k)
        if (std::abs(time[k] - begin_s) < 1e-6) lap.columns[c][k] = 900.0;
  const ReplayResult r = replay(*car_, Road(*surface_), recording::make_recording(lap, "lap"));
  ASSERT_EQ(r.problems.size(), 1u);
  EXPECT_THAT(r.problems[0], ::testing::HasSubstr("window 3"));
  const std::vector<double>& tyre = *sound.telemetry.find("tyre_rl_k");
  const double warmest = *std::max_element(tyre.begin(), tyre.end());
  std::size_t behind = 0;
  for (std::size_t k = 0; k < r.telemetry.rows(); ++k) {
    if (!((*r.telemetry.find("window"))[k] > 3.0)) continue;
    EXPECT_LT((*r.telemetry.find("tyre_rl_k"))[k], warmest + 1.0) << k;
    ++behind;
  }
  EXPECT_GT(behind, 100u);
}

}  // namespace replay_test
