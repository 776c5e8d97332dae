// The simulated car between two rows of a log, and what it looks like at one, with their
// derivatives by everything that a smoother estimates. Ceres stays behind this header.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <memory>

#include "vehicle/step.h"

namespace identify {

/// Places in the vector that is estimated: states of the car, what the driver does, how far the
/// car's parts are from the vehicle file, now and on the whole, what of the car stays as it is, and
/// offsets of sensors.
enum EstimatedPlace : std::size_t {
  kPlaceOfCar = 0,
  kPlaceSteer = 34,          ///< mean angle of the road wheels, rad
  kPlaceSteerRate = 35,      ///< rad/s
  kPlaceThrottle = 36,       ///< 0 to 1
  kPlaceBrake = 37,          ///< four pressures, Pa
  kPlaceParts = 41,          ///< of the car; the first two:
  kPlaceGrip = 41,           ///< both axles' grip beyond the tyre file's, share
  kPlaceCornering = 43,      ///< the same for their cornering stiffness
  kPlaceSlipStiffness = 45,  ///< the same for their longitudinal stiffness
  kPlaceBrakes = 47,         ///< the same for the brakes' torque
  kPlaceDrive = 49,          ///< the same for the engine's torque
  kChangingPlaces = 50,      ///< what changes between rows but for its noise ends here
  kPlaceStated = 50,         ///< shares beyond the vehicle file's, as kStated has them
  kMovingPlaces = 60,        ///< what moves the car ends here
  kPlaceAxOffset = 60,       ///< m/s2
  kPlaceAyOffset = 61,
  kPlaceYawRateOffset = 62,  ///< rad/s
  kPlaceSteerOffset = 63,    ///< rad
  kPlaceRolling = 64,        ///< both axles' wheels turn faster than stated radii say, share
  kPlaceRest = 66,           ///< what each of the car's parts returns to
  kPlaces = kPlaceRest + (kChangingPlaces - kPlaceParts)
};

/// A number of the vehicle file that a place is the share beyond of.
struct StatedPlace {
  vehicle::Parameter parameter;
  const char* name;
};
/// The car's parts, in the order of the places.
inline constexpr std::array<StatedPlace, kChangingPlaces - kPlaceParts> kParts{
    {{vehicle::Parameter::front_tyre_grip, "grip of the front tyres"},
     {vehicle::Parameter::rear_tyre_grip, "grip of the rear tyres"},
     {vehicle::Parameter::front_tyre_cornering_stiffness, "cornering stiffness of the front tyres"},
     {vehicle::Parameter::rear_tyre_cornering_stiffness, "cornering stiffness of the rear tyres"},
     {vehicle::Parameter::front_tyre_slip_stiffness, "slip stiffness of the front tyres"},
     {vehicle::Parameter::rear_tyre_slip_stiffness, "slip stiffness of the rear tyres"},
     {vehicle::Parameter::front_brake_area_m2, "torque of the front brakes"},
     {vehicle::Parameter::rear_brake_area_m2, "torque of the rear brakes"},
     {vehicle::Parameter::engine_torque, "torque of the engine"}}};
/// What of a car is known by its file only, is wrong by some per cent and stays so over a drive.
inline constexpr std::size_t kStatedNumbers = kMovingPlaces - kPlaceStated;
inline constexpr std::array<StatedPlace, kStatedNumbers> kStated{
    {{vehicle::Parameter::chassis_mass_kg, "mass"},
     {vehicle::Parameter::chassis_cog_behind_front_m, "centre of mass behind the front axle"},
     {vehicle::Parameter::chassis_cog_height_m, "height of the centre of mass"},
     {vehicle::Parameter::chassis_yaw_inertia_kgm2, "yaw inertia"},
     {vehicle::Parameter::aero_drag_area_m2, "drag area"},
     {vehicle::Parameter::front_lift_area_m2, "front lift area"},
     {vehicle::Parameter::rear_lift_area_m2, "rear lift area"},
     {vehicle::Parameter::front_spring_npm, "front springs"},
     {vehicle::Parameter::rear_spring_npm, "rear springs"},
     {vehicle::Parameter::front_anti_roll_npm, "front anti-roll bar"}}};

/// The states of the car that are estimated, in the order of their places. The others
/// (temperatures, fuel, the air path of a full turbo) only follow.
inline constexpr std::array<std::size_t, kPlaceSteer> kEstimatedStates = [] {
  std::array<std::size_t, kPlaceSteer> out{};
  std::size_t n = 0;
  for (std::size_t i = vehicle::kX; i <= vehicle::kYawRate; ++i) out[n++] = i;
  for (const std::size_t group :
       {vehicle::kTravel, vehicle::kTravelRate, vehicle::kSpin, vehicle::kSlipX, vehicle::kSlipY})
    for (std::size_t i = 0; i < vehicle::kWheels; ++i) out[n++] = group + i;
  out[n++] = vehicle::kEngine;
  out[n++] = vehicle::kBoost;
  return out;
}();
/// The place of an estimated state.
constexpr std::size_t place_of(std::size_t state) {
  for (std::size_t i = 0; i < kEstimatedStates.size(); ++i)
    if (kEstimatedStates[i] == state) return i;
  return kPlaces;
}

/// The place of what a part of the car returns to.
constexpr std::size_t rest_of(std::size_t part) { return kPlaceRest + part - kPlaceParts; }

using PlaceVector = Eigen::Matrix<double, kPlaces, 1>;
using PlaceMatrix = Eigen::Matrix<double, kPlaces, kPlaces>;
/// d what changes after / d all before; the other places stay as they are.
using StepMatrix = Eigen::Matrix<double, kChangingPlaces, kPlaces>;

/// The car and everything else that is estimated, at one moment.
struct CarPoint {
  vehicle::State<double> state{};
  std::array<double, kPlaces - kPlaceSteer> more{};  ///< by place, from kPlaceSteer on

  double& at(std::size_t place) {
    return place < kPlaceSteer ? state[kEstimatedStates[place]] : more[place - kPlaceSteer];
  }
  double at(std::size_t place) const {
    return place < kPlaceSteer ? state[kEstimatedStates[place]] : more[place - kPlaceSteer];
  }
};

/// What is seen of the car at a moment: specific force, then seven numbers per wheel.
enum SeenPlace : std::size_t {
  kSeenAx,
  kSeenAy,
  kSeenAz,    ///< m/s2, in the accelerometer's place and axes
  kSeenWheel  ///< first wheel's first; then kSeenPerWheel for each
};
enum SeenOfWheel : std::size_t {
  kSeenFx,
  kSeenFy,
  kSeenFz,
  kSeenKappa,
  kSeenAlpha,
  kSeenCamber,
  kSeenPower,
  kSeenPerWheel
};
inline constexpr std::size_t kSeen = kSeenWheel + vehicle::kWheels * kSeenPerWheel;
constexpr std::size_t seen_of(std::size_t wheel, SeenOfWheel what) {
  return kSeenWheel + wheel * kSeenPerWheel + what;
}

struct Seen {
  std::array<double, kSeen> value{};
  Eigen::Matrix<double, kSeen, kMovingPlaces> by;  ///< derivatives
  std::array<double, vehicle::kWheels> wheel_vx_mps{}, rolling_radius_m{};
  bool on_road = true;  ///< every wheel stands on the road
};

/// Where the accelerometer sits: ahead of the design centre of mass, its axes turned against the
/// body's, counter-clockwise.
struct ImuPlace {
  double ahead_m = 0.0, yaw_rad = 0.0;
};

/// A part of the car is followed no further than this share off the vehicle file: tyres without
/// grip would never be seen to have some again.
constexpr double kMostOff = 0.6;

/// The same of what kStated has: it is known within some per cent.
constexpr double kMostStatedOff = 0.3;

/// How long a part's difference from the vehicle file stays as it is, and a turning of the
/// steering.
inline constexpr double kForgetPart_s = 0.5, kForgetSteer_s = 0.5;

/// The longest step of the car itself. A kerb under a wheel lasts for milliseconds: steps of 2 ms
/// were further off there than the sensors' noise. Derivatives cost thirty times as much; they have
/// longer steps of their own.
inline constexpr double kFineStep_s = 0.00025;

/// What happens from a row to the next one that no smoothing moves.
struct Driven {
  int gear = 1, next_gear = 1;  ///< next_gear: the one to come while `gear` is 0
  /// How fast throttle and brakes move, by place from kPlaceThrottle on.
  std::array<double, kPlaceParts - kPlaceThrottle> feet_per_s{};
};

/// The laws of lib/vehicle with their derivatives. Car and road must outlive it; may be shared
/// between threads.
class CarMotion {
 public:
  CarMotion(const vehicle::Car<double>& car, const vehicle::Road& road, double most_step_s,
            const ImuPlace& imu = {});
  ~CarMotion();

  /// Moves the point on by `dt_s`, in equal steps of at most most_step_s, and gives d after /
  /// d before. False where the car lost the road or ran away; the point is of no use then.
  bool move(CarPoint& point, double dt_s, const Driven& driven, vehicle::RoadCursors& cursors,
            StepMatrix& by) const;

  Seen look(const CarPoint& point, int gear, vehicle::RoadCursors& cursors) const;

  /// A car that rolls at this place, before anything is known of it beyond its place and speed.
  CarPoint begin(const vehicle::StartOptions& options, vehicle::RoadCursors& cursors) const;

 private:
  struct Inside;
  std::unique_ptr<Inside> in_;
};

}  // namespace identify
