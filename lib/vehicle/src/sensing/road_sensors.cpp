#include "vehicle/road_sensors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "read_road_sensors.h"
#include "vehicle/error.h"

namespace vehicle {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::size_t kMostBeams = 256, kMostPoints = 200'000;
constexpr double kMostPointsPerSecond = 2e6;  ///< of all scans
constexpr double kMostOnTheWay = 2e6;         ///< points of all scans, in the time of their delays
constexpr double kMostEdgePoints = 200.0;     ///< a reach over its spacing

SensorClock read_clock(const base::Section& entry, double rate_hz) {
  return {entry.number("rate_hz", rate_hz, 0.01, 1000.0), entry.number("delay_s", 0.0, 0.0, 10.0)};
}

std::vector<double> read_beams(const base::Section& entry, const std::string& name,
                               const std::string& where) {
  const std::vector<std::string> words = entry.words("beams_deg");
  if (words.empty() || words.size() > kMostBeams)
    throw Error(fmt::format("{}: {}: beams_deg has {} elevations, wanted 1 to {}", where,
                            name.substr(0, 60), words.size(), kMostBeams));
  std::vector<double> out;
  for (const std::string& word : words) {
    const double beam_deg = base::to_number(word, where, "beams_deg");
    if (!(std::abs(beam_deg) <= 90.0))
      throw Error(fmt::format("{}: {}: a beam at {} degrees, wanted -90 to 90", where,
                              name.substr(0, 60), beam_deg));
    out.push_back(kDegree * beam_deg);
  }
  return out;
}

ScanSensor read_scan(const base::Section& entry, const std::string& name,
                     const std::string& where) {
  entry.allow({"rate_hz", "delay_s", "at_m", "turned_deg", "beams_deg", "field_deg", "step_deg",
               "nearest_m", "reach_m", "noise_m", "lost"});
  ScanSensor out;
  out.name = name;
  out.clock = read_clock(entry, 10.0);
  out.mounting = read_mounting(entry, name, where);
  out.beams_rad = read_beams(entry, name, where);
  out.field_rad = kDegree * entry.number("field_deg", 360.0, 0.01, 360.0);
  out.step_rad = kDegree * entry.number("step_deg", 1.0, 0.01, 360.0);
  out.nearest_m = entry.number("nearest_m", 0.5, 0.01, 300.0);
  out.reach_m = entry.number("reach_m", 80.0, 0.1, 300.0);
  out.noise_m = entry.number("noise_m", 0.0, 0.0, 10.0);
  out.lost = entry.number("lost", 0.0, 0.0, 1.0);
  if (!(out.nearest_m < out.reach_m))
    throw Error(
        fmt::format("{}: {}: nearest_m has to be below reach_m", where, name.substr(0, 60)));
  const std::size_t points = out.columns() * out.beams_rad.size();
  if (points > kMostPoints)
    throw Error(
        fmt::format("{}: {}: {} beams in a scan, at most {} wanted; fewer beams_deg, or a "
                    "larger step_deg",
                    where, name.substr(0, 60), points, kMostPoints));
  return out;
}

void want_moderate(const std::vector<ScanSensor>& scans, const std::string& path) {
  double per_second = 0.0, on_the_way = 0.0;
  for (const ScanSensor& scan : scans) {
    const double points =
        static_cast<double>(scan.columns() * scan.beams_rad.size()) * scan.clock.rate_hz;
    per_second += points;
    on_the_way += points * scan.clock.delay_s;
  }
  if (per_second > kMostPointsPerSecond)
    throw Error(fmt::format(
        "{}: the scans have {:.0f} beams a second together, at most {:.0f} wanted; a lower rate_hz",
        path, per_second, kMostPointsPerSecond));
  if (on_the_way > kMostOnTheWay)
    throw Error(fmt::format(
        "{}: the scans have {:.0f} beams on the way together (beams times rate_hz times delay_s), "
        "at most {:.0f} wanted; a shorter delay_s or a lower rate_hz",
        path, on_the_way, kMostOnTheWay));
}

EdgeSensor read_edges(const base::Section& entry, const std::string& name,
                      const std::string& where) {
  entry.allow({"rate_hz", "delay_s", "at_m", "turned_deg", "field_deg", "reach_m", "spacing_m",
               "noise_deg", "lost"});
  EdgeSensor out;
  out.name = name;
  out.clock = read_clock(entry, 30.0);
  out.mounting = read_mounting(entry, name, where);
  out.field_rad = kDegree * entry.number("field_deg", 90.0, 0.1, 360.0);
  out.reach_m = entry.number("reach_m", 60.0, 1.0, 300.0);
  out.spacing_m = entry.number("spacing_m", 1.0, 0.01, 100.0);
  out.noise_rad = kDegree * entry.number("noise_deg", 0.0, 0.0, 45.0);
  out.lost = entry.number("lost", 0.0, 0.0, 1.0);
  if (out.reach_m / out.spacing_m > kMostEdgePoints)
    throw Error(fmt::format("{}: {}: spacing_m is {}, and reach_m more than {} times that", where,
                            name.substr(0, 60), out.spacing_m, kMostEdgePoints));
  return out;
}

}  // namespace

Mounting read_mounting(const base::Section& entry, const std::string& name,
                       const std::string& where) {
  Mounting out;
  const auto read = [&](const char* key, double most, std::array<double, 3>& to, double unit) {
    const std::vector<double> numbers = entry.numbers(key, 3);
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      if (!(std::abs(numbers[k]) <= most))
        throw Error(fmt::format("{}: {}: {} has {}, wanted -{} to {}", where, name.substr(0, 60),
                                key, numbers[k], most, most));
      to[k] = unit * numbers[k];
    }
  };
  read("at_m", 100.0, out.at_m, 1.0);
  read("turned_deg", 360.0, out.turned_rad, kDegree);
  return out;
}

std::size_t ScanSensor::columns() const {
  return static_cast<std::size_t>(std::max(1.0, std::floor(field_rad / step_rad + 1e-9)));
}

RoadSensorFile read_road_sensors(const base::Section& top) {
  RoadSensorFile out;
  if (top.has("scans"))
    top.section("scans").for_each(
        [&](const std::string& name, const base::Setting& value, const std::string& where) {
          out.scans.push_back(read_scan(base::Section(value, top.path(), name), name, where));
        });
  want_moderate(out.scans, top.path());
  if (top.has("edges"))
    top.section("edges").for_each(
        [&](const std::string& name, const base::Setting& value, const std::string& where) {
          out.edges.push_back(read_edges(base::Section(value, top.path(), name), name, where));
        });
  if (top.has("pose")) {
    constexpr std::array kAxes{"x", "y", "z", "roll", "pitch", "yaw"};
    constexpr std::array kMotion{"vx",       "vy", "vz", "roll_rate", "pitch_rate",
                                 "yaw_rate", "ax", "ay", "az"};
    const base::Section pose = top.section("pose");
    pose.allow({"x", "y", "z", "roll", "pitch", "yaw", "vx", "vy", "vz", "roll_rate", "pitch_rate",
                "yaw_rate", "ax", "ay", "az"});
    for (std::size_t k = 0; k < kAxes.size(); ++k)
      if (pose.has(kAxes[k])) out.pose[k] = pose.text(kAxes[k]);
    for (std::size_t k = 0; k < kMotion.size(); ++k)
      if (pose.has(kMotion[k])) out.motion[k] = pose.text(kMotion[k]);
  }
  return out;
}

}  // namespace vehicle
