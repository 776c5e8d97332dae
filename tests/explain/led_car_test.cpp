// The car that is led along a recording has the forces of the car that drove it.
#include "led_car.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "simulated_drive.h"

namespace explain {
namespace led_car_test {

using explain_test::racer;
using P = vehicle::Parameter;

/// A free drive on a plane in third gear, turning and pushing, every 50 ms; the accelerations are
/// those of its places in the map over 50 ms.
struct FreeDrive {
  Lead lead;
  std::vector<double> ahead_mps2, left_mps2, yaw_radps2, load_front_n, load_rear_n, rear_radps;
};

FreeDrive free_drive(const vehicle::Vehicle& v, double seconds) {
  const auto car = vehicle::make_car(v.files, v.parameters, v.terms, v.contact);
  const vehicle::Road road;
  vehicle::StartOptions begin;
  begin.speed_mps = 30;
  begin.gear = 3;
  begin.fuel_kg = 0;
  auto sim = vehicle::start(car, road, begin);
  vehicle::Detail<double> detail{};
  vehicle::Controls<double> c;
  c.gear_command = 3;
  const auto controls = [&](double t) {
    c.throttle_command = 0.45 + 0.25 * std::sin(0.9 * t);
    c.steer_command_rad = v.parameters[P::steering_ratio] * 0.03 * std::sin(1.7 * t);
  };
  std::vector<vehicle::State<double>> states;
  std::vector<vehicle::Detail<double>> details;
  for (int i = 0; i < static_cast<int>(seconds * 1000); ++i) {
    states.push_back(sim.state);
    controls(sim.time_s);
    EXPECT_TRUE(vehicle::step(car, sim, c, road, {}, detail).ok());
    details.push_back(detail);
  }
  FreeDrive out;
  out.lead.vy_known = true;
  for (std::size_t i = 50; i + 51 < states.size(); i += 50) {
    const auto& s = states[i];
    controls(0.001 * static_cast<double>(i));
    out.lead.vx_mps.push_back(s[vehicle::kVx]);
    out.lead.vy_mps.push_back(s[vehicle::kVy]);
    out.lead.yaw_radps.push_back(s[vehicle::kYawRate]);
    out.lead.yaw_rad.push_back(s[vehicle::kYaw]);
    out.lead.steer.push_back(c.steer_command_rad);
    out.lead.throttle.push_back(c.throttle_command);
    out.lead.gear.push_back(3);
    out.lead.gravity_mps2.push_back(v.parameters[P::environment_gravity_mps2]);
    out.lead.fuel_kg.push_back(0.0);
    const auto speed = [&](std::size_t at, std::size_t place) {
      return (states[at + 1][place] - states[at][place]) / 0.001;
    };
    const double ax = (speed(i + 25, vehicle::kX) - speed(i - 25, vehicle::kX)) / 0.05;
    const double ay = (speed(i + 25, vehicle::kY) - speed(i - 25, vehicle::kY)) / 0.05;
    const double sy = std::sin(s[vehicle::kYaw]), cy = std::cos(s[vehicle::kYaw]);
    out.ahead_mps2.push_back(cy * ax + sy * ay);
    out.left_mps2.push_back(cy * ay - sy * ax);
    out.yaw_radps2.push_back((speed(i + 25, vehicle::kYaw) - speed(i - 25, vehicle::kYaw)) / 0.05);
    const auto& w = details[i].wheel;
    out.load_front_n.push_back(w[0].fz_n + w[1].fz_n);
    out.load_rear_n.push_back(w[2].fz_n + w[3].fz_n);
    out.rear_radps.push_back(0.5 * (s[vehicle::kSpin + 2] + s[vehicle::kSpin + 3]));
  }
  return out;
}

Signals signals_of(std::size_t n) {
  Signals s;
  s.n = n;
  s.grip.assign(n, 1.0);
  s.commanded[kSteer] = s.commanded[kThrottle] = true;
  return s;
}

/// Root mean square of the difference after the first second, over that of the wanted one's
/// changes.
double apart(const std::vector<double>& got, const std::vector<double>& wanted) {
  double difference = 0, square = 0, mean = 0;
  std::size_t count = 0;
  for (std::size_t i = 20; i + 1 < wanted.size(); ++i) mean += wanted[i], ++count;
  mean /= static_cast<double>(count);
  for (std::size_t i = 20; i + 1 < wanted.size(); ++i) {
    difference += (got[i] - wanted[i]) * (got[i] - wanted[i]);
    square += (wanted[i] - mean) * (wanted[i] - mean);
  }
  return std::sqrt(difference / square);
}

TEST(LedCar, HasTheForcesOfTheDriveThatItIsLedAlong) {
  const vehicle::Vehicle v = racer();
  Setting stated;
  stated.p = v.parameters;
  FreeDrive drive = free_drive(v, 20);
  const Signals s = signals_of(drive.lead.vx_mps.size());
  const auto expect_alike = [&](const Led& led, double most) {
    EXPECT_LT(apart(led.force_x_mps2, drive.ahead_mps2), most);
    EXPECT_LT(apart(led.force_y_mps2, drive.left_mps2), most);
    EXPECT_LT(apart(led.yaw_radps2, drive.yaw_radps2), most);
    EXPECT_LT(apart(led.load_front_n, drive.load_front_n), most);
    EXPECT_LT(apart(led.load_rear_n, drive.load_rear_n), most);
    EXPECT_LT(apart(led.rear_radps, drive.rear_radps), most);
  };
  expect_alike(lead(s, v, stated, drive.lead), 0.02);
  // Without its side slip it finds one by itself.
  drive.lead.vy_known = false;
  expect_alike(lead(s, v, stated, drive.lead), 0.02);
}

TEST(LedCar, CarriesItsWeightAndTheAirAndIsHeldBackByDrag) {
  vehicle::Vehicle v = racer();
  v.terms[vehicle::Term::aero_ride_height] = 0.0;
  Setting stated;
  stated.p = v.parameters;
  const std::size_t n = 40;
  const Signals s = signals_of(n);
  Lead by;
  const double speed = 60, g = v.parameters[P::environment_gravity_mps2];
  by.vx_mps.assign(n, speed);
  for (auto* zero : {&by.vy_mps, &by.yaw_radps, &by.yaw_rad, &by.steer, &by.fuel_kg})
    zero->assign(n, 0.0);
  by.gear.assign(n, 5);
  by.gravity_mps2.assign(n, g);
  const Led led = lead(s, v, stated, by);
  const auto& p = v.parameters;
  const double pressure = 0.5 * p[P::aero_density_kgpm3] * speed * speed;
  const double mass = p[P::chassis_mass_kg];
  EXPECT_NEAR(led.load_front_n[30] + led.load_rear_n[30],
              mass * g + pressure * (p[P::front_lift_area_m2] + p[P::rear_lift_area_m2]),
              0.003 * mass * g);
  // What one square metre of drag more takes away.
  Setting more = stated;
  more.p[P::aero_drag_area_m2] += 0.1;
  EXPECT_NEAR(led.force_x_mps2[30] - lead(s, v, more, by).force_x_mps2[30], 0.1 * pressure / mass,
              0.01 * 0.1 * pressure / mass);
}

TEST(LedCar, IsNoLighterThanItsWheels) {
  const vehicle::Vehicle v = racer();
  Setting burnt;
  burnt.p = v.parameters;
  FreeDrive drive = free_drive(v, 6);
  drive.lead.reserve_kg = 2 * v.parameters[P::chassis_mass_kg];
  EXPECT_NO_THROW(lead(signals_of(drive.lead.vx_mps.size()), v, burnt, drive.lead));
}

TEST(LedCar, SaysNothingWhereNothingLeadsItAndGoesOnAfter) {
  const vehicle::Vehicle v = racer();
  Setting stated;
  stated.p = v.parameters;
  FreeDrive drive = free_drive(v, 6);
  for (std::size_t i = 50; i < 56; ++i)
    drive.lead.vx_mps[i] = std::numeric_limits<double>::quiet_NaN();
  const Led led = lead(signals_of(drive.lead.vx_mps.size()), v, stated, drive.lead);
  for (std::size_t i = 50; i < 56; ++i) EXPECT_TRUE(std::isnan(led.force_x_mps2[i])) << i;
  for (const std::size_t i : {48, 60, 90})
    EXPECT_NEAR(led.force_y_mps2[i], drive.left_mps2[i], 0.3) << i;
}

// Cars of other masses, forces and pedals, one with other files, one led faster than any car: each
// goes bit for bit as alone, over a gap as well.
TEST(LedCar, GoesInAConvoyAsItGoesAlone) {
  const vehicle::Vehicle v = racer();
  FreeDrive drive = free_drive(v, 4);
  drive.lead.vx_mps[40] = std::numeric_limits<double>::quiet_NaN();
  const Signals s = signals_of(drive.lead.vx_mps.size());
  std::vector<Setting> settings(7);
  for (Setting& set : settings) set.p = v.parameters;
  settings[1].p[P::chassis_mass_kg] *= 1.1;
  settings[2].p[P::front_tyre_grip] *= 0.8;
  settings[3].engine_shape[0] = 0.1;
  settings[4].p[P::rear_lift_area_m2] *= 1.3;
  settings[5].curve[1] = 0.1;
  std::vector<Lead> leads(settings.size(), drive.lead);
  for (double& gravity : leads[5].gravity_mps2) gravity *= 1.2;
  leads[4].vx_mps[20] = std::numeric_limits<double>::quiet_NaN();
  std::fill(leads[6].vx_mps.begin() + 20, leads[6].vx_mps.end(), 2000.0);
  std::vector<const Setting*> of;
  for (const Setting& set : settings) of.push_back(&set);
  const std::vector<std::vector<std::size_t>> groups = convoys(s, v, of);
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[1], std::vector<std::size_t>{3});
  const auto same = [](const std::vector<double>& a, const std::vector<double>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) {
      return x == y || (std::isnan(x) && std::isnan(y));
    });
  };
  for (const auto& group : groups) {
    std::vector<Guided> cars;
    for (const std::size_t k : group) cars.push_back({of[k], &leads[k]});
    const std::vector<Led> led = lead(s, v, cars);
    for (std::size_t n = 0; n < group.size(); ++n) {
      const Led alone = lead(s, v, *cars[n].setting, *cars[n].by);
      EXPECT_TRUE(same(led[n].force_x_mps2, alone.force_x_mps2)) << group[n];
      EXPECT_TRUE(same(led[n].force_y_mps2, alone.force_y_mps2)) << group[n];
      EXPECT_TRUE(same(led[n].yaw_radps2, alone.yaw_radps2)) << group[n];
      EXPECT_TRUE(same(led[n].load_rear_n, alone.load_rear_n)) << group[n];
      EXPECT_TRUE(same(led[n].rear_radps, alone.rear_radps)) << group[n];
      EXPECT_EQ(std::isfinite(led[n].force_x_mps2[30]), group[n] != 6) << group[n];
    }
  }
}

}  // namespace led_car_test
}  // namespace explain
