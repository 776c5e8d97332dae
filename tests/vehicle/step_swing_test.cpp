// No swing at the step whatever the frictions, and words where a step cannot do it.
#include "vehicle/step_swing.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

#include "support/places.h"
#include "vehicle/manoeuvre.h"
#include "vehicle/poles.h"
#include "vehicle/vehicle_file.h"

namespace step_swing_test {

using namespace vehicle;  // NOLINT: a test of this library
using P = Parameter;

bool heavy() { return std::getenv("KERBSTONE_HEAVY") != nullptr; }

Vehicle open_wheel() {
  return read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
}

/// How far the last 200 rows of a channel go up and down in turn: the median size of their second
/// differences over 4, which is the half swing of a period of two rows.
double alternation(const recording::Table& table, const char* name) {
  const std::vector<double>& y = *table.find(name);
  std::vector<double> bends;
  for (std::size_t i = y.size() - 200; i + 1 < y.size(); ++i)
    bends.push_back(std::abs(y[i - 1] - 2.0 * y[i] + y[i + 1]) / 4.0);
  std::nth_element(bends.begin(), bends.begin() + 100, bends.end());
  return bends[100];
}

// The finding: a strong clutch with a narrow stick speed made the body pitch from step to step and
// turned the car over.
TEST(StepSwing, FrictionsInsideTheirBoundsDoNotChatter) {
  const Vehicle v = open_wheel();
  const std::vector<double> torques_nm =
      heavy() ? std::vector<double>{100, 700, 1500, 1e4, 1e5} : std::vector<double>{700, 1500, 1e5};
  const std::vector<double> sticks_radps =
      heavy() ? std::vector<double>{0.1, 0.5, 6, 100} : std::vector<double>{0.1, 6};
  const std::vector<double> preloads_nm =
      heavy() ? std::vector<double>{40, 5000} : std::vector<double>{5000};
  const std::vector<double> speeds_mps =
      heavy() ? std::vector<double>{8, 20, 50} : std::vector<double>{20};
  double most = 0.0, worst_yaw = 0.0;
  int runs = 0;
  for (const double speed_mps : speeds_mps)
    for (const double preload_nm : preloads_nm)
      for (const double differential_stick_radps : {0.01, 1.0})
        for (const Integrator integrator : {Integrator::kSemiImplicit, Integrator::kExplicitEuler})
          for (const double torque_nm : torques_nm)
            for (const double stick_radps : sticks_radps) {
              Parameters<double> p = v.parameters;
              p[P::clutch_torque_nm] = torque_nm;
              p[P::clutch_stick_radps] = stick_radps;
              p[P::differential_preload_nm] = preload_nm;
              p[P::differential_stick_radps] = differential_stick_radps;
              const Car<double> car = make_car(v.files, p, v.terms);
              Manoeuvre m;
              m.speed_mps = speed_mps;
              m.duration_s = 4.0;
              m.steer_rad = 0.02;
              m.step.integrator = integrator;
              const ManoeuvreResult r = run_manoeuvre(car, m);
              ++runs;
              const std::string where = fmt::format(
                  "clutch {} N m / {} rad/s, differential {} N m / {} rad/s, {} m/s, {}", torque_nm,
                  stick_radps, preload_nm, differential_stick_radps, speed_mps,
                  integrator == Integrator::kExplicitEuler ? "explicit" : "semi-implicit");
              ASSERT_TRUE(r.complete) << where << ": " << r.problem;
              const double az = alternation(r.telemetry, "az_mps2");
              EXPECT_LT(az, 1e-4) << where;  // measured 1.1e-6
              EXPECT_LT(r.step_swing, StepSwing::kWorthSaying) << where << ": " << r.swing_warning;
              most = std::max(most, az);
              // The same with a tenth of the step.
              if (heavy() && speed_mps == 20.0 && integrator == Integrator::kSemiImplicit) {
                m.step.step_s = 1e-4;
                const double fine = run_manoeuvre(car, m).telemetry.find("yaw_rate_radps")->back();
                const double yaw = r.telemetry.find("yaw_rate_radps")->back();
                worst_yaw = std::max(worst_yaw, std::abs(yaw / fine - 1.0));
              }
            }
  EXPECT_LT(worst_yaw, 0.005);  // measured 0.0007
  fmt::print(
      "{} runs: at most {:.3g} m/s2 up and down, yaw rate within {:.3g} of a tenth of the step\n",
      runs, most, worst_yaw);
}

struct Unresolved {
  const char* name;
  const char* channel;
  std::vector<std::pair<P, double>> values;
};

// Inside their bounds, but no step of a millisecond resolves them: the run says so, and so does the
// linearised car.
TEST(StepSwing, TellsWhatAStepDoesNotResolveAndThePolesAgree) {
  const Vehicle v = open_wheel();
  const std::vector<Unresolved> cases{
      {"dampers hard around the knee",
       "az_mps2",
       {{P::front_bump_damping_nspm, 1e5},
        {P::front_rebound_damping_nspm, 1e5},
        {P::front_damper_fast_share, 0.15}}},
      {"hard dampers",
       "az_mps2",
       {{P::front_bump_damping_nspm, 1e5},
        {P::front_rebound_damping_nspm, 1e5},
        {P::front_damper_fast_share, 1.0}}},
      {"stiff springs of light wheels",
       "az_mps2",
       {{P::rear_spring_npm, 5e6}, {P::rear_unsprung_mass_kg, 1.0}}},
      {"as shipped", "az_mps2", {}}};
  for (const Unresolved& one : cases) {
    Parameters<double> p = v.parameters;
    for (const auto& [which, value] : one.values) p[which] = value;
    const Car<double> car = make_car(v.files, p, v.terms);
    Manoeuvre m;
    m.kind = ManoeuvreKind::kBump;
    m.speed_mps = 10.0;
    m.duration_s = 6.0;
    const ManoeuvreResult r = run_manoeuvre(car, m);
    const bool chatters = !one.values.empty();
    const double swing = r.complete ? alternation(r.telemetry, one.channel) : 1e9;
    EXPECT_EQ(swing > 0.01, chatters) << one.name << ": " << swing;
    EXPECT_EQ(!r.swing_warning.empty() || !r.complete, chatters)
        << one.name << ": " << r.swing_warning;
    bool told = false;
    try {
      const auto at = linearise(car, 2.0, {0.001}).radii.front();
      told = at.semi_implicit > 1.0 || at.semi_implicit_swing > StepSwing::kWorthSaying;
      fmt::print("{}: swing {:.3g}, eigenvalue {:.4f}, poles' swing {:.3g}; {}\n", one.name, swing,
                 at.semi_implicit, at.semi_implicit_swing, r.swing_warning);
    } catch (const std::exception& error) {
      told = true;
      fmt::print("{}: swing {:.3g}; poles: {}; {}\n", one.name, swing, error.what(), r.problem);
    }
    EXPECT_EQ(told, chatters) << one.name;
  }
}

}  // namespace step_swing_test
