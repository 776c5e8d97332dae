#include "vehicle/suspension_points.h"

#include <ceres/jet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "support/places.h"
#include "support/run_crgbuild.h"
#include "test_car.h"
#include "vehicle/error.h"
#include "vehicle/vehicle_file.h"

namespace suspension_points_test {

using namespace vehicle;  // NOLINT: a test of this library

struct Flat {
  double y, z;
};
// Front view of a double wishbone: inner and outer joints of both arms, the wheel's centre.
constexpr Flat kLowIn{0.30, 0.20}, kLowOut{0.70, 0.18}, kUpIn{0.35, 0.42}, kUpOut{0.66, 0.45};
constexpr Flat kWheel{0.78, 0.31};

/// The same in space: arms turn about axes along x, the rod is a copy of the lower arm.
SuspensionPoints planar() {
  SuspensionPoints p;
  const auto at = [](double x, Flat f) { return Vec3<double>{x, f.y, f.z}; };
  p.link[0] = {at(0.15, kLowIn), at(0.0, kLowOut)};
  p.link[1] = {at(-0.15, kLowIn), at(0.0, kLowOut)};
  p.link[2] = {at(0.12, kUpIn), at(0.0, kUpOut)};
  p.link[3] = {at(-0.12, kUpIn), at(0.0, kUpOut)};
  p.link[4] = {at(-0.1, kLowIn), at(-0.1, kLowOut)};
  p.wheel_m = at(0.0, kWheel);
  return p;
}

/// A five-link axle without any symmetry.
SuspensionPoints five_link() {
  SuspensionPoints p;
  p.link[0] = {{0.20, 0.31, 0.17}, {0.02, 0.70, 0.16}};
  p.link[1] = {{-0.16, 0.28, 0.19}, {-0.03, 0.71, 0.17}};
  p.link[2] = {{0.14, 0.36, 0.41}, {0.01, 0.67, 0.44}};
  p.link[3] = {{-0.13, 0.37, 0.43}, {-0.04, 0.66, 0.45}};
  p.link[4] = {{-0.12, 0.30, 0.25}, {-0.14, 0.69, 0.26}};
  p.wheel_m = {0.0, 0.78, 0.31};
  return p;
}

double distance(Flat a, Flat b) { return std::hypot(a.y - b.y, a.z - b.z); }

/// The closed form: the lower arm at an angle, the upper joint where two circles meet.
struct FourBar {
  Flat wheel;
  double turn_rad;  // of the upright, CCW in the front view (y to the right, z up)
};
FourBar four_bar(double low_rad) {
  const double low = distance(kLowIn, kLowOut), up = distance(kUpIn, kUpOut);
  const double upright = distance(kLowOut, kUpOut);
  const Flat c{kLowIn.y + low * std::cos(low_rad), kLowIn.z + low * std::sin(low_rad)};
  const double d = distance(c, kUpIn);
  const double along = (upright * upright - up * up + d * d) / (2.0 * d);
  const double across = std::sqrt(upright * upright - along * along);
  const Flat u{(kUpIn.y - c.y) / d, (kUpIn.z - c.z) / d};
  // The upper joint lies to the outside of the line from the lower joint to the upper inner one.
  const Flat f{c.y + along * u.y + across * u.z, c.z + along * u.z - across * u.y};
  const double before = std::atan2(kUpOut.z - kLowOut.z, kUpOut.y - kLowOut.y);
  const double turn = std::atan2(f.z - c.z, f.y - c.y) - before;
  const double wy = kWheel.y - kLowOut.y, wz = kWheel.z - kLowOut.z;
  return {{c.y + std::cos(turn) * wy - std::sin(turn) * wz,
           c.z + std::sin(turn) * wy + std::cos(turn) * wz},
          turn};
}
FourBar four_bar_at_travel(double travel_m) {
  double low = -0.4, high = 0.4;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (four_bar(middle).wheel.z < kWheel.z + travel_m ? low : high) = middle;
  }
  return four_bar(low);
}

TEST(SuspensionPoints, DoubleWishboneIsTheClosedFormFourBar) {
  for (const double travel_m : {-0.08, -0.03, -0.001, 0.0, 0.02, 0.05, 0.08}) {
    const FourBar truth = four_bar_at_travel(travel_m);
    const UprightPose pose = solve_suspension(planar(), travel_m);
    EXPECT_NEAR(pose.wheel_m.x, 0.0, 1e-10);
    EXPECT_NEAR(pose.wheel_m.y, truth.wheel.y, 1e-10) << travel_m;
    // A turn that lifts the outer side of the axle leans the top inward.
    EXPECT_NEAR(pose.camber_rad, -truth.turn_rad, 1e-10) << travel_m;
    EXPECT_NEAR(pose.toe_rad, 0.0, 1e-10);
  }
  EXPECT_LT(solve_suspension(planar(), 0.05).camber_rad, -0.005);  // leans in on bump
}

TEST(SuspensionPoints, FiveLinksKeepTheirLengths) {
  const SuspensionPoints p = five_link();
  for (const double travel_m : {-0.08, -0.02, 0.0, 0.04, 0.08})
    for (const double rack_m : {-0.02, 0.0, 0.03}) {
      const UprightPose pose = solve_suspension(p, travel_m, rack_m);
      EXPECT_NEAR(pose.wheel_m.z, p.wheel_m.z + travel_m, 1e-12);
      for (std::size_t k = 0; k < 5; ++k) {
        Vec3<double> inner = p.link[k].inner_m;
        if (k == 4) inner.y += rack_m;
        const Vec3<double> arm = p.link[k].outer_m - p.wheel_m;
        const Vec3<double> outer = pose.wheel_m + arm.x * pose.direction[0] +
                                   arm.y * pose.direction[1] + arm.z * pose.direction[2];
        EXPECT_NEAR(norm(outer - inner), norm(p.link[k].outer_m - p.link[k].inner_m), 1e-11);
      }
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
          EXPECT_NEAR(dot(pose.direction[i], pose.direction[j]), i == j ? 1.0 : 0.0, 1e-12);
    }
  // The rod lies behind the wheel: pulled to the outside it turns the front of the wheel inward.
  EXPECT_GT(solve_suspension(p, 0.0, 0.02).toe_rad, 0.05);
}

TEST(SuspensionPoints, PolynomialsAreTheSolutionWithItsSlopes) {
  using Jet = ceres::Jet<double, 1>;
  const SuspensionPoints p = five_link();
  const WheelPath path = make_wheel_path(p);
  const auto check = [&](const WheelPath::Coefficients& c, const auto& of, const char* name) {
    for (double travel_m = -0.078; travel_m < 0.08; travel_m += 0.013) {
      const AlongTravel<double> at = along_travel(c, path.range_m, travel_m);
      EXPECT_NEAR(at.value, of(travel_m), 2e-5) << name << travel_m;
      EXPECT_NEAR(at.slope, (of(travel_m + 1e-4) - of(travel_m - 1e-4)) / 2e-4, 2e-3) << name;
      EXPECT_NEAR(along_travel(c, path.range_m, Jet(travel_m, 0)).value.v[0], at.slope, 1e-12);
      EXPECT_NEAR(along_travel(c, path.range_m, Jet(travel_m, 0)).slope.v[0], at.curvature, 1e-9);
    }
    EXPECT_EQ(along_travel(c, path.range_m, 0.0).value, 0.0);
    const AlongTravel<double> end = along_travel(c, path.range_m, path.range_m);
    EXPECT_NEAR(along_travel(c, path.range_m, path.range_m + 0.1).value,
                end.value + 0.1 * end.slope, 1e-12);
  };
  check(
      path.ahead_m, [&](double t) { return solve_suspension(p, t).wheel_m.x - p.wheel_m.x; }, "x");
  check(
      path.outward_m, [&](double t) { return solve_suspension(p, t).wheel_m.y - p.wheel_m.y; },
      "y");
  check(
      path.camber_rad, [&](double t) { return solve_suspension(p, t).camber_rad; }, "camber");
  check(
      path.toe_rad, [&](double t) { return solve_suspension(p, t).toe_rad; }, "toe");
}

// The wheels follow the curved path without work that no power names.
TEST(SuspensionPoints, CarChangesItsEnergyByItsPowersOnly) {
  using Jet = ceres::Jet<double, 1>;
  CarFiles files = test_car_files();
  files.wheel_path = {make_wheel_path(planar()), make_wheel_path(five_link())};
  std::mt19937 random(3);
  for (int trial = 0; trial < 10; ++trial) {
    Amplitudes<double> terms = default_amplitudes();
    terms[Term::suspension_kinematics] = trial % 2 == 0 ? 1.0 : 0.4;
    const Car<double> car = make_car(files, test_parameters(), terms);
    const State<double> s = random_state(random);
    const Inputs<double> in = random_inputs(random);
    State<double> rate;
    Detail<double> detail;
    RoadCursors cursors;
    derivative(car, s, in, Road(0.03, -0.02), cursors, rate, detail);
    Parameters<Jet> p;
    for (std::size_t i = 0; i < kParameterCount; ++i) p.value[i] = Jet(car.parameters.value[i]);
    Amplitudes<Jet> t;
    for (std::size_t i = 0; i < kTermCount; ++i) t.value[i] = Jet(terms.value[i]);
    const Car<Jet> moving = make_car<Jet>(files, p, t);
    State<Jet> along;
    for (std::size_t i = 0; i < kStateSize; ++i) {
      along[i] = Jet(s[i]);
      along[i].v[0] = rate[i];
    }
    const Powers<double>& w = detail.power;
    const double scale = std::abs(w.tyre_normal) + std::abs(w.engine) + std::abs(w.brake) + 1000.0;
    EXPECT_NEAR(energy(moving, along).v[0], w.sum(), 1e-9 * scale) << trial;
    // The left front wheel leans by what the points say.
    const double lean =
        solve_suspension(planar(), s[kTravel]).camber_rad * terms[Term::suspension_kinematics];
    EXPECT_NEAR(detail.wheel[0].axis.z,
                std::sin(-(lean + car.parameters[Parameter::front_camber_rad])), 1e-4);
  }
}

TEST(SuspensionPoints, RefusesLinksThatCannotBe) {
  using ::testing::HasSubstr;
  SuspensionPoints far = planar();
  far.range_m = 0.45;
  EXPECT_THAT([&] { make_wheel_path(far); },
              ::testing::ThrowsMessage<Error>(HasSubstr("suspension points")));
  SuspensionPoints loose = planar();
  loose.link[4] = loose.link[0];
  EXPECT_THAT([&] { make_wheel_path(loose); },
              ::testing::ThrowsMessage<Error>(HasSubstr("do not hold")));
  SuspensionPoints nothing{};
  EXPECT_THROW(make_wheel_path(nothing), Error);
}

TEST(SuspensionPoints, AreReadFromTheVehicleFile) {
  const cli::Folder folder("suspension");
  std::filesystem::copy(places::source() + "/vehicles/open_wheel", folder / "car");
  const std::string text = cli::read(folder / "car/vehicle.yaml");
  const std::string points =
      "suspension:\n  front:\n    travel_m: 0.06\n    wheel_m: [0, 0.78, 0.31]\n"
      "    link_1: [0.15, 0.30, 0.20, 0, 0.70, 0.18]\n    link_2: [-0.15, 0.30, 0.20, 0, 0.70, "
      "0.18]\n"
      "    link_3: [0.12, 0.35, 0.42, 0, 0.66, 0.45]\n    link_4: [-0.12, 0.35, 0.42, 0, 0.66, "
      "0.45]\n";
  cli::write(folder / "car/vehicle.yaml",
             text + points + "    link_5: [-0.1, 0.30, 0.20, -0.1, 0.70, 0.18]\n");
  const Vehicle v = read_vehicle(folder / "car/vehicle.yaml");
  ASSERT_TRUE(v.files.wheel_path[0].given());
  EXPECT_FALSE(v.files.wheel_path[1].given());
  EXPECT_NEAR(along_travel(v.files.wheel_path[0].camber_rad, 0.06, 0.03).value,
              -four_bar_at_travel(0.03).turn_rad, 2e-6);
  cli::write(folder / "car/vehicle.yaml", text + points);
  EXPECT_THAT([&] { read_vehicle(folder / "car/vehicle.yaml"); },
              ::testing::ThrowsMessage<Error>(::testing::HasSubstr("lacks 'link_5'")));
}

}  // namespace suspension_points_test
