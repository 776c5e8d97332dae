// Every mechanism, whichever there are: it speaks up in every log, is described, and what is
// written back of it drives as the relations had it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "base/read_file.h"
#include "explain/write_back.h"
#include "led_car.h"
#include "mechanism.h"
#include "simulated_drive.h"
#include "support/temporary_folder.h"

namespace explain {
namespace mechanisms_test {

using explain_test::racer;
using P = vehicle::Parameter;
using vehicle::Term;

constexpr std::size_t kSteps = 400;  ///< 20 s

/// A log with every channel, in bends and under power; `few`: with places and speed alone.
Signals log_of(bool few) {
  Signals s;
  s.name = "log";
  s.n = kSteps;
  s.length_m = 1000;
  s.closed = true;
  s.rounds = 4;
  s.grip.assign(kSteps, 1.0);
  s.grade.assign(kSteps, 0.03);
  s.bank.assign(kSteps, 0.0);
  for (std::size_t c = 0; c < kChannelCount; ++c) {
    s.present[c] = !few || c == kX || c == kY || c == kVx;
    s.column[c] = "column " + std::to_string(c);
    s.x[c].assign(kSteps, s.present[c] ? 1.0 : NAN);
    s.dx[c].assign(kSteps, s.present[c] ? 0.0 : NAN);
  }
  s.x[kVx].assign(kSteps, 40.0);
  s.x[kYawRate].assign(kSteps, s.present[kYawRate] ? 0.2 : NAN);
  s.x[kGear].assign(kSteps, 3);
  s.x[kEngine].assign(kSteps, 600);
  return s;
}

/// The stated car without any term that a mechanism brings.
vehicle::Vehicle plain_car() {
  vehicle::Vehicle car = racer();
  for (const Term t : {Term::turbo_lag, Term::brake_fade, Term::brake_friction_temperature,
                       Term::tyre_warm_up, Term::tyre_thermal, Term::tyre_load_sensitivity,
                       Term::tyre_camber, Term::tyre_combined_slip, Term::tyre_relaxation,
                       Term::aero_drag, Term::aero_downforce, Term::aero_ride_height, Term::wind})
    car.terms[t] = 0.0;
  return car;
}

TEST(Mechanisms, HaveNamesThatAreTheirsAloneAndADocument) {
  const std::set<std::string_view> kinds{"road", "vehicle", "environment", "sensor", "parameter"};
  const std::string docs = base::read_file(places::source() + "/docs/crgexplain.md");
  std::set<std::string> seen;
  for (const Mechanism& m : mechanisms()) {
    EXPECT_TRUE(seen.insert(m.id).second) << m.id;
    EXPECT_TRUE(kinds.contains(m.kind())) << m.id;
    EXPECT_EQ(find_mechanism(m.id), &m);
    EXPECT_NE(docs.find("`" + std::string(m.id) + "`"), std::string::npos)
        << m.id << ": docs/crgexplain.md lists every mechanism";
  }
  EXPECT_EQ(find_mechanism("vehicle.wings"), nullptr);
  EXPECT_EQ(seen.size(), mechanism_ids().size());
}

TEST(Mechanisms, EachIdStandsInOneFile) {
  namespace fs = std::filesystem;
  std::vector<std::string> texts;
  const std::regex comment("//[^\n]*");
  for (const auto& entry : fs::recursive_directory_iterator(places::source() + "/lib/explain"))
    if (entry.path().extension() == ".cpp" || entry.path().extension() == ".h")
      texts.push_back(std::regex_replace(base::read_file(entry.path().string()), comment, ""));
  for (const Mechanism& m : mechanisms()) {
    const std::string quoted = "\"" + std::string(m.id) + "\"";
    const auto has = [&](const std::string& text) { return text.find(quoted) != text.npos; };
    EXPECT_EQ(std::count_if(texts.begin(), texts.end(), has), 1) << m.id;
  }
}

TEST(Mechanisms, EachIsTestedOrSaysWhyNotInEveryLog) {
  for (const bool few : {false, true})
    for (const vehicle::Vehicle& car : {racer(), plain_car()}) {
      const Inventory all = inventory({log_of(few)}, car);
      std::set<std::string> spoken;
      for (const Unknown& u : all.unknowns) {
        if (u.role == Role::kCurve) continue;
        const Mechanism* const m = find_mechanism(u.id);
        ASSERT_NE(m, nullptr) << u.id;
        EXPECT_EQ(u.kind, m->kind()) << u.id;
        EXPECT_FALSE(u.physics.empty() || u.equation.empty() || u.unit.empty()) << u.id;
        spoken.insert(u.id);
      }
      for (const Untestable& u : all.untestable) {
        EXPECT_FALSE(u.reason.empty()) << u.mechanism;
        spoken.insert(u.mechanism);
      }
      for (const Mechanism& m : mechanisms()) {
        if (few && m.kind() == "sensor") continue;  // errors of a sensor that no log has are none
        EXPECT_TRUE(spoken.contains(m.id)) << m.id;
      }
    }
}

TEST(Mechanisms, AnAmountIsSomethingElseThanNothing) {
  for (const Unknown& u : inventory({log_of(false)}, plain_car()).unknowns) {
    const Setting none;
    Setting some;
    u.set(some, u.step);
    EXPECT_FALSE(some == none) << u.id << " " << u.name;
  }
}

/// Bends, power and, at last, the brakes.
Lead lead_of(const vehicle::Vehicle& car) {
  Lead by;
  by.vy_known = true;
  for (std::size_t i = 0; i < kSteps; ++i) {
    const double t = Signals::kStep_s * static_cast<double>(i);
    const bool braking = t > 15;
    const double speed = braking ? 45 - 3 * (t - 15) : 30 + t, rate = 0.25 * std::sin(0.7 * t);
    by.vx_mps.push_back(speed);
    by.vy_mps.push_back(-0.15 * std::sin(0.7 * t));
    by.yaw_radps.push_back(rate);
    by.yaw_rad.push_back(0.25 / 0.7 * (1 - std::cos(0.7 * t)));
    by.steer.push_back(car.parameters[P::chassis_wheelbase_m] * rate / speed +
                       0.01 * std::sin(0.7 * t));
    by.throttle.push_back(braking ? 0.0 : 0.5 + 0.4 * std::sin(2 * t));
    by.brake_front_pa.push_back(braking ? 1.5e6 : 0.0);
    by.brake_rear_pa.push_back(braking ? 8e5 : 0.0);
    by.gear.push_back(4);
    by.gravity_mps2.push_back(car.parameters[P::environment_gravity_mps2]);
    by.fuel_kg.push_back(0.0);
  }
  return by;
}

/// RMS difference of forces, moments and loads, m/s2, rad/s2 and kN together.
double apart(const Led& a, const Led& b) {
  const auto rms = [](const std::vector<double>& p, const std::vector<double>& q) {
    double sum = 0, n = 0;
    for (std::size_t i = 0; i < p.size(); ++i)
      if (std::isfinite(p[i] - q[i])) sum += (p[i] - q[i]) * (p[i] - q[i]), n += 1;
    return std::sqrt(sum / std::max(1.0, n));
  };
  return rms(a.force_x_mps2, b.force_x_mps2) + rms(a.force_y_mps2, b.force_y_mps2) +
         rms(a.yaw_radps2, b.yaw_radps2) + rms(a.load_front_n, b.load_front_n) / 1000;
}

/// The car with what is written back of this much of the unknown.
vehicle::Vehicle written(const Unknown& u, double amount, const vehicle::Vehicle& stated,
                         const Signals& log) {
  const std::string path = places::source() + "/vehicles/open_wheel/vehicle.yaml";
  Findings all;
  Finding f;
  f.mechanism = u.id;
  f.kind = u.kind;
  f.parameters.push_back({u.name, u.unit, u.stated + amount, 0, 0});
  for (const auto& [name, held] : u.constants) f.parameters.push_back({name, "", held, held, held});
  all.findings.push_back(f);
  const auto made = corrected_vehicle(path, stated, all, {log});
  if (!made) return stated;
  const support::TemporaryFolder folder;
  for (const auto& [name, bytes] : made->files) folder.file(name, bytes);
  folder.file("vehicle.yaml", made->vehicle_yaml);
  return vehicle::read_vehicle(folder.path("vehicle.yaml"));
}

// By another way than the relations: files and terms of lib/vehicle. What acts between driver and
// car, burns, or is written as the nearest map or coupling is tested where that is.
TEST(Mechanisms, WhatIsWrittenBackDrivesAsTheRelationsHadIt) {
  const std::set<std::string> elsewhere{
      "vehicle.throttle_dead_time", "vehicle.brake_dead_time", "vehicle.steering_dead_time",
      "vehicle.steering_lag",       "vehicle.fuel_burn",       "vehicle.aero_ride_height",
      "vehicle.differential",       "parameter.wheel_radius",  "parameter.throttle_gain",
      "parameter.brake_gain",       "parameter.steering_ratio"};
  const Signals log = log_of(false);
  std::set<std::string> tested;
  for (const bool added : {true, false}) {
    // Parameters and wind act by what the car has, mechanisms of the car by what it lacks.
    const vehicle::Vehicle stated = added ? plain_car() : racer();
    const Lead by = lead_of(stated);
    Setting none;
    none.p = stated.parameters;
    const Led as_stated = lead(log, stated, none, by);
    for (const Unknown& u : inventory({log}, stated).unknowns) {
      const Mechanism* const m = find_mechanism(u.id);
      if ((u.kind == "vehicle") != added) continue;
      if (m == nullptr || m->write_car == nullptr || elsewhere.contains(u.id)) continue;
      const double amount = 2 * u.step;
      Setting some = none;
      u.set(some, amount);
      const Led had = lead(log, stated, some, by);
      const vehicle::Vehicle car = written(u, amount, stated, log);
      Setting at_it;
      at_it.p = car.parameters;
      const double moved = apart(had, as_stated), off = apart(lead(log, car, at_it, by), had);
      EXPECT_GT(moved, 1e-4) << u.id << " " << u.name;
      // Files hold nine digits.
      EXPECT_LT(off, 1e-3 * moved) << u.id << " " << u.name;
      tested.insert(u.id);
    }
  }
  EXPECT_GE(tested.size(), 15u);
}

}  // namespace mechanisms_test
}  // namespace explain
