// The smoother against what it must give: the truth from a log without noise, derivatives that are
// those of differences, and the algebra of one measurement.
#include "car_smoother.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/places.h"
#include "vehicle/vehicle_file.h"

namespace car_smoother_test {

using identify::CarMotion, identify::CarPoint, identify::PlaceVector, identify::StepMatrix;
using namespace vehicle;  // NOLINT: names of one library

struct Racer {
  Vehicle vehicle = read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  Car<double> car = make_car(vehicle.files, vehicle.parameters, vehicle.terms);
  Road road{0.02, -0.03};
  CarMotion motion{car, road, identify::kFineStep_s};
};

/// In a bend on the throttle, springs settled.
CarPoint cornering(const Racer& racer, RoadCursors& cursors) {
  StartOptions start;
  start.speed_mps = 35.0;
  start.gear = 3;
  CarPoint p = racer.motion.begin(start, cursors);
  p.at(identify::kPlaceSteer) = 0.03;
  p.at(identify::kPlaceThrottle) = 0.3;
  StepMatrix by;
  for (int k = 0; k < 50; ++k) EXPECT_TRUE(racer.motion.move(p, 0.01, {3, 3, {}}, cursors, by));
  return p;
}

TEST(CarMotion, MovesTheCarOfTheLibrary) {
  Racer racer;
  for (const Term t : {Term::steering_actuator, Term::steering_friction, Term::throttle_actuator})
    racer.car.terms[t] = 0.0;
  RoadCursors cursors;
  StartOptions begin;
  begin.speed_mps = 35.0;
  begin.gear = 3;
  CarPoint p = racer.motion.begin(begin, cursors);
  p.at(identify::kPlaceSteer) = 0.03;
  p.at(identify::kPlaceThrottle) = 0.3;
  Simulation<double> sim = start(racer.car, racer.road, begin);
  Controls<double> controls;
  controls.steer_command_rad = 0.03 * racer.car.parameters[Parameter::steering_ratio];
  controls.throttle_command = 0.3;
  controls.gear_command = 3;
  Detail<double> detail{};
  StepMatrix by;
  StepOptions options;
  options.step_s = identify::kFineStep_s;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(racer.motion.move(p, 0.005, {3, 3, {}}, cursors, by));
    for (int n = 0; n < 20; ++n)
      ASSERT_TRUE(step(racer.car, sim, controls, racer.road, options, detail).ok());
  }
  EXPECT_GT(std::abs(sim.state[kVy]), 0.1);
  for (std::size_t i = 0; i < kStateSize; ++i)
    EXPECT_NEAR(p.state[i], sim.state[i], 1e-6 * (1.0 + std::abs(sim.state[i]))) << state_name(i);
}

TEST(CarMotion, DerivativesAreThoseOfDifferences) {
  const Racer racer;
  RoadCursors cursors;
  const CarPoint at = cornering(racer, cursors);
  StepMatrix by, unused;
  CarPoint moved = at;
  ASSERT_TRUE(racer.motion.move(moved, 0.01, {3, 3, {}}, cursors, by));
  const identify::Seen seen = racer.motion.look(at, 3, cursors);
  for (std::size_t place = 0; place < identify::kPlaces; ++place) {
    const double h = place >= identify::kPlaceBrake && place < identify::kPlaceParts
                         ? 1e3
                         : 1e-6 * (1.0 + 10.0 * std::abs(at.at(place)));
    CarPoint more = at, less = at;
    more.at(place) += h;
    less.at(place) -= h;
    const identify::Seen up = racer.motion.look(more, 3, cursors),
                         down = racer.motion.look(less, 3, cursors);
    ASSERT_TRUE(racer.motion.move(more, 0.01, {3, 3, {}}, cursors, unused));
    ASSERT_TRUE(racer.motion.move(less, 0.01, {3, 3, {}}, cursors, unused));
    if (place >= identify::kPlaceBrake && place < identify::kPlaceParts) continue;  // a kink at 0
    const auto column = static_cast<Eigen::Index>(place);
    for (std::size_t i = 0; i < identify::kChangingPlaces; ++i) {
      const double slope = (more.at(i) - less.at(i)) / (2.0 * h);
      EXPECT_NEAR(by(static_cast<Eigen::Index>(i), column), slope,
                  2e-3 * (std::abs(slope) + 1e-3 + 1e-9 * std::abs(moved.at(i)) / h))
          << i << " by " << place;
    }
    for (std::size_t i = 0; place < identify::kMovingPlaces && i < identify::kSeen; ++i) {
      const double slope = (up.value[i] - down.value[i]) / (2.0 * h);
      EXPECT_NEAR(seen.by(static_cast<Eigen::Index>(i), column), slope,
                  2e-3 * (std::abs(slope) + 1e-2 + 1e-9 * std::abs(seen.value[i]) / h))
          << "seen " << i << " by " << place;
    }
  }
}

TEST(CarMotion, LongStepsAreThoseOfDerivativesOnly) {
  const Racer racer;
  const CarMotion coarse(racer.car, racer.road, 0.002);
  RoadCursors cursors;
  const CarPoint at = cornering(racer, cursors);
  CarPoint fine = at, same = at;
  StepMatrix by, near;
  ASSERT_TRUE(racer.motion.move(fine, 0.01, {3, 3, {}}, cursors, by));
  ASSERT_TRUE(coarse.move(same, 0.01, {3, 3, {}}, cursors, near));
  for (std::size_t i = 0; i < kStateSize; ++i)
    EXPECT_EQ(fine.state[i], same.state[i]) << state_name(i);
  EXPECT_NE(by(identify::place_of(kVy), identify::kPlaceSteer),
            near(identify::place_of(kVy), identify::kPlaceSteer));
  EXPECT_NEAR(by(identify::place_of(kVy), identify::kPlaceSteer),
              near(identify::place_of(kVy), identify::kPlaceSteer),
              0.1 * std::abs(by(identify::place_of(kVy), identify::kPlaceSteer)));
}

/// Rows every 10 ms that measure these of the truth's places exactly.
std::vector<identify::SmootherRow> exact_rows(const Racer& racer, CarPoint truth,
                                              const std::vector<identify::Sensor>& sensors,
                                              int count, std::vector<CarPoint>& points) {
  RoadCursors cursors;
  std::vector<identify::SmootherRow> rows;
  StepMatrix by;
  for (int k = 0; k < count; ++k) {
    if (k > 0) racer.motion.move(truth, 0.01, {3, 3, {}}, cursors, by);
    identify::SmootherRow row;
    row.time_s = 0.01 * k;
    row.driven = {3, 3, {}};
    row.noise = PlaceVector::Constant(1e-14);
    const identify::Seen seen = racer.motion.look(truth, 3, cursors);
    for (std::size_t s = 0; s < sensors.size(); ++s)
      row.measured.push_back(
          {s, sensors[s].seen ? seen.value[sensors[s].place] : truth.at(sensors[s].place)});
    rows.push_back(row);
    points.push_back(truth);
  }
  return rows;
}

std::vector<identify::Sensor> fine_sensors() {
  return {{"vx_mps", false, identify::place_of(kVx), identify::kPlaces, 1e-3, 1e-3},
          {"yaw_rate_radps", false, identify::place_of(kYawRate), identify::kPlaces, 1e-4, 1e-4},
          {"steer_rad", false, identify::kPlaceSteer, identify::kPlaces, 1e-5, 1e-5}};
}

TEST(CarSmoother, FindsTheTruthFromExactMeasurements) {
  const Racer racer;
  RoadCursors cursors;
  const CarPoint truth = cornering(racer, cursors);
  const std::vector<identify::Sensor> sensors = fine_sensors();
  std::vector<CarPoint> points;
  std::vector<identify::SmootherRow> rows = exact_rows(racer, truth, sensors, 60, points);
  rows[30].measured[1].value += 0.5;  // a spike of the gyro
  identify::SmootherBegin begin{truth, PlaceVector::Constant(1e-8)};
  // The lateral speed is not measured and begins wrong.
  const auto vy = identify::place_of(kVy);
  begin.point.at(vy) += 0.1;
  begin.sd[static_cast<Eigen::Index>(vy)] = 0.3;
  const identify::Smoothed s = identify::smooth(racer.motion, sensors, rows, begin, RoadCursors{});
  ASSERT_EQ(s.row.size(), rows.size());
  EXPECT_EQ(s.sums.wild, 1u);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    EXPECT_NEAR(s.row[k].point.at(vy), points[k].at(vy), 0.004) << k;
    EXPECT_LT(s.row[k].point_sd[vy], 0.01) << k;
  }
}

TEST(CarSmoother, FindsByHowMuchWheelsTurnFasterThanStatedRadiiSay) {
  const Racer racer;
  RoadCursors cursors;
  const CarPoint truth = cornering(racer, cursors);
  const std::size_t front = identify::kPlaceRolling;
  std::vector<identify::Sensor> sensors{
      {"vx_mps", false, identify::place_of(kVx), identify::kPlaces, 1e-3, 1e-3},
      {"yaw_rate_radps", false, identify::place_of(kYawRate), identify::kPlaces, 1e-4, 1e-4},
      {"steer_rad", false, identify::kPlaceSteer, identify::kPlaces, 1e-5, 1e-5}};
  for (std::size_t i = 0; i < 2; ++i)
    sensors.push_back(
        {"wheel", false, identify::place_of(kSpin + i), identify::kPlaces, 1e-2, 1e-2, front});
  std::vector<CarPoint> points;
  std::vector<identify::SmootherRow> rows = exact_rows(racer, truth, sensors, 60, points);
  for (identify::SmootherRow& row : rows)
    for (std::size_t m = 3; m < 5; ++m) row.measured[m].value *= 1.03;
  identify::SmootherBegin begin{truth, PlaceVector::Constant(1e-8)};
  begin.sd[static_cast<Eigen::Index>(front)] = 0.02;
  const identify::Smoothed s = identify::smooth(racer.motion, sensors, rows, begin, RoadCursors{});
  ASSERT_EQ(s.row.size(), rows.size());
  EXPECT_NEAR(s.row[30].point.at(front), 0.03, 1e-3);
  EXPECT_NEAR(s.row[30].point.at(identify::place_of(kSpin)),
              points[30].at(identify::place_of(kSpin)), 0.1);
  EXPECT_LT(s.row[30].point_sd[front], 1e-3);
  EXPECT_EQ(s.sums.stretches, 1u);
}

// A car whose file leaves its mass open by 2.5 %. What tyres and engine push is open, too, so that
// side forces are mass times acceleration: as uncertain as the mass.
TEST(CarSmoother, StatedNumbersAreHeldAndTheirUncertaintyCounts) {
  const Racer racer;
  RoadCursors cursors;
  const CarPoint truth = cornering(racer, cursors);
  const auto mass = static_cast<Eigen::Index>(identify::kPlaceStated);
  std::vector<identify::Sensor> sensors = fine_sensors();
  sensors.push_back({"ay_mps2", true, identify::kSeenAy, identify::kPlaces, 0.01, 0.01});
  std::vector<CarPoint> points;
  const auto rows = exact_rows(racer, truth, sensors, 60, points);
  identify::SmootherBegin begin{truth, PlaceVector::Constant(1e-8)};
  begin.sd.segment<identify::kMovingPlaces - identify::kPlaceStated>(mass).setZero();
  for (std::size_t i = identify::kPlaceParts; i < identify::kChangingPlaces; ++i)
    begin.sd[static_cast<Eigen::Index>(identify::rest_of(i))] = 0.1;
  for (std::size_t i = 0; i < identify::kPlaceSteer; ++i)
    begin.sd[static_cast<Eigen::Index>(i)] = 0.01;
  const auto middle = [&](double mass_sd, double mass_off) {
    begin.sd[mass] = mass_sd;
    begin.point.at(identify::kPlaceStated) = mass_off;
    return identify::smooth(racer.motion, sensors, rows, begin, RoadCursors{}).row.at(40);
  };
  const identify::SmoothedRow sure = middle(0.0, 0.0), open = middle(0.025, 0.0),
                              heavier = middle(0.0, 0.025), wrong = middle(0.025, 0.025);
  for (std::size_t a = 0; a < 2; ++a) {
    const double side = sure.axle[a][identify::kSeenFy];
    EXPECT_NEAR(open.axle[a][identify::kSeenFy], side, 0.002 * std::abs(side));
    const double more = heavier.axle[a][identify::kSeenFy] - side,
                 sd = std::sqrt(std::pow(open.axle_sd[a][identify::kSeenFy], 2) -
                                std::pow(sure.axle_sd[a][identify::kSeenFy], 2));
    EXPECT_NEAR(std::abs(more / side), 0.025, 0.01) << a;
    EXPECT_NEAR(sd, std::abs(more), 0.1 * std::abs(more)) << a;
    // A mass that the file has wrong stays so, whatever the log would make of it.
    EXPECT_NEAR(wrong.axle[a][identify::kSeenFy], side + more, 0.1 * std::abs(more)) << a;
  }
  EXPECT_NEAR(open.point.at(identify::kPlaceStated), 0.0, 1e-12);
  EXPECT_NEAR(open.point_sd[identify::kPlaceStated], 0.025, 1e-6);
}

// What other stretches told of the sensor's offset is not told again; how well they did counts.
TEST(CarSmoother, AKnownOffsetOfTheSteeringSensorIsHeld) {
  const Racer racer;
  RoadCursors cursors;
  const CarPoint truth = cornering(racer, cursors);
  std::vector<identify::Sensor> sensors = fine_sensors();
  sensors[1].deviation = 3e-3;
  sensors[2].offset = identify::kPlaceSteerOffset;
  std::vector<CarPoint> points;
  const auto rows = exact_rows(racer, truth, sensors, 60, points);
  identify::SmootherBegin begin{truth, PlaceVector::Constant(1e-8)};
  begin.sd[identify::kPlaceSteer] = 0.01;
  begin.sd[identify::kPlaceSteerOffset] = 1e-3;
  begin.point.at(identify::kPlaceSteerOffset) = 2e-4;
  const auto middle = [&] {
    return identify::smooth(racer.motion, sensors, rows, begin, RoadCursors{}).row.at(30);
  };
  EXPECT_LT(middle().point_sd[identify::kPlaceSteer], 3e-4);  // the turning of the car tells it
  begin.steer_offset_known = true;
  const identify::SmoothedRow held = middle();
  EXPECT_NEAR(held.point.at(identify::kPlaceSteerOffset), 2e-4, 1e-12);
  EXPECT_NEAR(held.point.at(identify::kPlaceSteer), points[30].at(identify::kPlaceSteer) - 2e-4,
              2e-5);
  EXPECT_NEAR(held.point_sd[identify::kPlaceSteer], 1e-3, 5e-5);
}

TEST(CarSmoother, IsLostWhereTooMuchIsFarFromWhatWasExpected) {
  const Racer racer;
  RoadCursors cursors;
  const CarPoint truth = cornering(racer, cursors);
  const std::vector<identify::Sensor> sensors = fine_sensors();
  std::vector<CarPoint> points;
  std::vector<identify::SmootherRow> rows = exact_rows(racer, truth, sensors, 60, points);
  for (std::size_t k = 30; k < 60; ++k) rows[k].measured[1].value += k % 2 == 0 ? 1.0 : -1.0;
  identify::SmootherBegin begin{truth, PlaceVector::Constant(1e-8)};
  EXPECT_EQ(identify::smooth(racer.motion, sensors, rows, begin, RoadCursors{}).row.size(), 60u);
  begin.most_wild = 0.25;
  EXPECT_TRUE(identify::smooth(racer.motion, sensors, rows, begin, RoadCursors{}).row.empty());
}

TEST(CarSmoother, OneMeasurementCountsAsItsPrecisionSays) {
  const Racer racer;
  RoadCursors cursors;
  const CarPoint at = cornering(racer, cursors);
  const std::vector<identify::Sensor> sensors{
      {"vx_mps", false, identify::place_of(kVx), identify::kPlaces, 0.3, 0.3}};
  std::vector<CarPoint> points;
  std::vector<identify::SmootherRow> rows = exact_rows(racer, at, sensors, 1, points);
  rows[0].measured[0].value += 1.0;
  identify::SmootherBegin begin{at, PlaceVector::Constant(1e-6)};
  const auto vx = identify::place_of(kVx);
  begin.sd[static_cast<Eigen::Index>(vx)] = 0.4;
  const identify::Smoothed s = identify::smooth(racer.motion, sensors, rows, begin, RoadCursors{});
  // Precisions add: 0.4 and 0.3 make 0.24; the mean is weighted by them.
  EXPECT_NEAR(s.row[0].point.at(vx) - at.at(vx), 0.16 / (0.16 + 0.09), 1e-6);
  EXPECT_NEAR(s.row[0].point_sd[vx], 0.24, 1e-6);
}

}  // namespace car_smoother_test
