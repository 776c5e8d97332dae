// Capacities and conductances of brake discs, of cars whose truth is known.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "base/random.h"
#include "identify/drive_fits.h"
#include "recorded_drive.h"
#include "recording/channels.h"
#include "support/figure.h"
#include "support/places.h"
#include "vehicle/vehicle_file.h"
#include "window_fit.h"

namespace discs_fit_test {

using identify::DiscsFitOptions, identify::DriveFit, identify::Found;
using P = vehicle::Parameter;

/// Three minutes on a plane: from 25 to 65 m/s and back with other pressures every time.
test_drive::Drive stop_and_go(const vehicle::Car<double>& car, std::uint64_t seed) {
  using namespace vehicle;  // NOLINT: names of one library
  const Road road;
  base::Random dice = base::random_of(seed, "pressures");
  test_drive::Drive out;
  for (const std::string& name : recording::telemetry_channels()) out.telemetry.add(name, {});
  std::vector<double> row(recording::telemetry_channels().size());
  StartOptions begin;
  begin.speed_mps = 40.0;
  begin.gear = 4;
  begin.disc_k = 420.0;
  Simulation<double> sim = start(car, road, begin);
  Detail<double> detail{};
  double front_pa = 2e6;
  bool brakes = false;
  for (std::size_t k = 0; k < 180000; ++k) {
    if (!brakes && sim.state[kVx] > 60.0) {
      brakes = true;
      front_pa = dice.uniform(1e6, 4e6);
    }
    if (brakes && sim.state[kVx] < 30.0) brakes = false;
    Controls<double> controls{};
    controls.gear_command = 4;
    controls.throttle_command = brakes ? 0.0 : 1.0;
    if (brakes) controls.brake_command_pa = {front_pa, front_pa, 0.6 * front_pa, 0.6 * front_pa};
    const State<double> before = sim.state;
    const double time_s = sim.time_s;
    const StepResult result = step(car, sim, controls, road, StepOptions{}, detail);
    if (!result.ok()) throw std::runtime_error(describe(result, time_s, 0.0, 0.0));
    if (k % 20 != 0) continue;
    fill_telemetry(time_s, before, detail, controls, 0.0, 0.0, row);
    for (std::size_t i = 0; i < row.size(); ++i) out.telemetry.columns[i].push_back(row[i]);
  }
  return out;
}

constexpr std::array<P, 8> kLooked{
    P::front_disc_surface_capacity_jpk, P::front_disc_core_capacity_jpk,
    P::front_disc_conductance_wpk,      P::front_disc_area_m2,
    P::rear_disc_surface_capacity_jpk,  P::rear_disc_core_capacity_jpk,
    P::rear_disc_conductance_wpk,       P::rear_disc_area_m2};

struct Driven {
  vehicle::Vehicle stated =
      vehicle::read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  vehicle::Car<double> as_stated =
      make_car(stated.files, stated.parameters, stated.terms, stated.contact);
  vehicle::Parameters<double> truth = stated.parameters;
  recording::Table log;
};

/// Discs up to a quarter off; the share of the heat by its prior; temperatures within 4 K.
Driven driven(std::uint64_t seed) {
  Driven out;
  base::Random dice = base::random_of(seed, "car");
  for (const P p : kLooked) out.truth[p] *= 1.0 + dice.uniform(-0.25, 0.25);
  out.truth[P::brake_disc_share] = std::min(
      1.0, out.truth[P::brake_disc_share] *
               (1.0 + 0.5 * out.stated.prior[static_cast<std::size_t>(P::brake_disc_share)] *
                          dice.normal()));
  const auto car = make_car(out.stated.files, out.truth, out.stated.terms, out.stated.contact);
  const test_drive::Drive drive = stop_and_go(car, seed);
  out.log = test_drive::logged(drive, true, seed, true);
  for (const char* wheel : {"fl", "fr", "rl", "rr"}) {
    const std::string channel = fmt::format("brake_disc_{}_k", wheel);
    std::vector<double> values = *drive.telemetry.find(channel);
    base::Random noise = base::random_of(seed, channel);
    for (double& v : values) v += 4.0 * noise.normal();
    out.log.add(channel, values);
  }
  return out;
}

TEST(DiscsFit, TheTruthLiesInItsIntervals) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  struct Score {
    int inside = 0, seen = 0, all = 0;
    double square = 0.0, known = 0.0, largest = 0.0;
  };
  std::map<std::string, Score> scores;
  for (std::uint64_t seed = 1; seed <= (heavy ? 20u : 2u); ++seed) {
    const Driven d = driven(seed);
    const DriveFit fit =
        identify::fit_discs(d.as_stated, d.stated.prior, recording::make_recording(d.log, "log"));
    EXPECT_TRUE(fit.doubts.empty());
    for (std::size_t k = 0; k < kLooked.size(); ++k) {
      const Found& f = fit.found[k];
      const double is = d.truth[kLooked[k]];
      Score& s = scores[f.name];
      ++s.all;
      if (!f.unseen.empty()) continue;
      ++s.seen;
      // Heat as stated is off by the share's error, and so is what is found.
      const double share = d.stated.parameters[P::brake_disc_share] / d.truth[P::brake_disc_share];
      s.known += std::pow(f.value / (is * share) - 1.0, 2.0);
      s.inside += std::abs(f.value - is) < f.within ? 1 : 0;
      s.square += std::pow(f.value / is - 1.0, 2.0);
      s.largest = std::max(s.largest, std::abs(f.value / is - 1.0));
    }
  }
  int inside = 0, seen = 0;
  for (const auto& [name, s] : scores) {
    support::figure_of_case("stated_percent", 100.0 * std::sqrt(s.square / std::max(1, s.seen)));
    support::figure_of_case("known_percent", 100.0 * std::sqrt(s.known / std::max(1, s.seen)));
    EXPECT_LT(std::sqrt(s.known / std::max(1, s.seen)), 0.05) << name;
    EXPECT_LT(s.largest, 0.2) << name;
    inside += s.inside;
    seen += s.seen;
  }
  support::figure("inside", inside), support::figure("seen", seen);
  EXPECT_GE(inside, 0.8 * seen);
  EXPECT_GE(seen, 12);
}

TEST(DiscsFit, WhatIsMissingIsSaid) {
  const Driven d = driven(1);
  recording::Table bare, cold = d.log;
  for (std::size_t c = 0; c < d.log.names.size(); ++c)
    if (!d.log.names[c].starts_with("brake_disc_")) bare.add(d.log.names[c], d.log.columns[c]);
  const auto look = [&](const recording::Table& log) {
    return identify::fit_discs(d.as_stated, d.stated.prior, recording::make_recording(log, "log"));
  };
  EXPECT_THAT(look(bare).at("front_disc_conductance_wpk").unseen,
              testing::HasSubstr("no temperatures"));
  for (auto& column : cold.columns) column.resize(1000);
  const DriveFit fit = look(cold);
  EXPECT_THAT(fit.at("rear_disc_area_m2").unseen, testing::HasSubstr("s without a gap"));
  EXPECT_THAT(identify::plain_sheet(fit.found),
              testing::HasSubstr("# rear.disc_area_m2 not observable: 20 s"));
}

}  // namespace discs_fit_test
