// How a road leans, from how a car turns on it. A gyro turns about the body's axis, which leans
// with the road; heading and path turn on the map. The one is the cosine of the road's slope times
// the other, whatever tyres and forces do. No driven height is needed.
#pragma once

#include <utility>
#include <vector>

#include "explain/signals.h"

namespace explain {

/// What tells how the car turns on the map.
enum class TurningBy {
  kNone,           ///< nothing, or there is no gyro
  kHeading,        ///< the logged heading
  kCourseAndSlip,  ///< the path's course less the logged side slip
  kCourse          ///< the path's course; side slip that goes with the yaw rate looks like a delay
};
/// In words: "yaw rate and heading".
const char* name_of(TurningBy by);

/// One recording at steps of Signals::kStep_s, on the stated road. NaN: not known there.
struct Turning {
  TurningBy by = TurningBy::kNone;
  std::vector<double> gyro_radps, dgyro_radps2;
  std::vector<double> turned_rad;   ///< on the map, without jumps
  std::vector<double> cosine;       ///< of the stated slopes under the car
  std::vector<double> bank, grade;  ///< stated rise to the left, and along the car, m/m
  std::vector<double> u_m, v_m, speed_mps;
  std::vector<int> lap;
};
Turning turning_of(const Signals& s);

/// One place of a road.
struct BankingPlace {
  double u_m = 0.0;
  double added = 0.0;      ///< rise to the left beyond the file's, m/m
  double ci90 = 0.0;       ///< half of its 90 % interval
  double pivot_v_m = 0.0;  ///< about which it leans, beside the reference line
};

struct BankingByTurning {
  TurningBy by = TurningBy::kNone;
  std::vector<BankingPlace> places;  ///< equally far apart; of a closed road without its end
  double delay_s = 0.0, gain = 0.0, bias_radps = 0.0;  ///< of the gyro
  std::size_t windows = 0;
  /// Loss on half laps left out that the lean saves, against the stated road and a gyro as it is
  /// usual, whose errors count by how unusual they are; it must be selection::kProfileGain, and
  /// selection::kSure standard errors between half laps.
  double saved = 0.0, threshold = 0.0;
  bool counts = false;
  /// The same against a gyro whose gain is free. Below the threshold such a gain would do as well:
  /// selection::kProfileGain, and three standard errors between half laps. One beyond
  /// selection::kMostGyroGain is none of a gyro.
  double any_gain = 0.0, saved_beside_gain = 0.0, gain_threshold = 0.0;
  bool may_be_gain = false;
  /// Leans for sure, and takes from the cosine half of the most or more.
  std::vector<std::pair<double, double>> where_m;
  /// There, the median by how much the road turns: lean into the turns beyond the file's, m/m, and
  /// half of its 90 % interval.
  double lean = 0.0, lean_ci90 = 0.0;
  double limit =
      0.0;  ///< of 99 % for the whole lean of all turns, m/m, if the gyro's gain is usual
};

/// Windows of a second of all recordings. The profile is periodic on a closed road, as rough as
/// makes the recordings most likely, and leans into the turns, about a line that is found beside
/// it. A gyro's gain is within 0.35 % (one standard deviation), as such sensors are; how late it
/// is, up to 1 s, and a filter of the first order in it are found. Intervals count noise as what is
/// left of half laps left out, as correlated as that is; where the road does not turn they are as
/// wide as roads differ and reach to nothing. It counts if it leans by more than twice what such a
/// gain takes from the cosine. No places: less than 30 windows, or a road that does not turn.
BankingByTurning banking_by_turning(const std::vector<Turning>& logs, double length_m, bool closed);

}  // namespace explain
