#include "force_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "pedals.h"
#include "recording/channels.h"
#include "vehicle/driver.h"

namespace identify {
namespace {

using Index = Eigen::Index;
using vehicle::kWheels;
using P = vehicle::Parameter;

/// Reads channels one by one into sensors and the rows' measurements.
class Reader {
 public:
  Reader(const recording::Recording& recording, ForceChannels& out)
      : recording_(recording), out_(out) {}

  /// Adds a channel that was recorded; `least` is the smallest noise that is believed.
  bool add(const std::string& channel, bool seen, std::size_t place, double least,
           std::size_t offset = kPlaces, double scale = 1.0, std::size_t share = kPlaces) {
    const std::vector<double>* const values = recording_.table.find(channel);
    if (values == nullptr) return false;
    std::vector<double> scaled = *values;
    for (double& v : scaled) v *= scale;
    return put({channel, seen, place, offset, 0.0, 0.0, share}, scaled,
               std::max(least, noise_of(scaled)));
  }

  /// The same of what a foot moves between stops (in the channel's unit) at which loggers cut noise
  /// off.
  bool add_pedal(const std::string& channel, std::size_t place, double least,
                 const std::vector<double>& stops, double scale = 1.0) {
    const std::vector<double>* const values = recording_.table.find(channel);
    if (values == nullptr) return false;
    std::vector<double> scaled = *values;
    double noise = 0.0;
    for (const double stop : stops) {
      const AtStop rests = at_stop(*recording_.table.find("time_s"), *values, stop);
      noise = std::max(noise, rests.noise);
      std::size_t moved = 0;
      for (std::size_t k = 0; k < scaled.size(); ++k) {
        if (!rests.row[k]) continue;
        moved += scaled[k] != stop ? 1 : 0;
        scaled[k] = stop;
      }
      if (moved > 0)
        out_.said.push_back(fmt::format(
            "{}: {} rows are taken as {:g}: noise whose other half the logger cut off there",
            channel, moved, stop));
    }
    for (double& v : scaled) v *= scale;
    noise = noise > 0.0 ? scale * noise : noise_of(scaled);
    return put({channel, false, place}, scaled, std::max(least, noise));
  }

  void need(bool found, const char* what) const {
    if (!found)
      throw base::Error(fmt::format(
          "the recording has no channel {}; forces need it: name its column in a mapping", what));
  }

 private:
  bool put(Sensor sensor, const std::vector<double>& scaled, double noise) {
    const std::size_t at = out_.sensors.size();
    std::size_t count = 0;
    for (std::size_t k = 0; k < scaled.size(); ++k) {
      if (!std::isfinite(scaled[k])) continue;
      out_.rows[k].measured.push_back({at, scaled[k]});
      ++count;
    }
    if (count == 0) return false;
    sensor.deviation = sensor.own_deviation = noise;
    out_.sensors.push_back(std::move(sensor));
    return true;
  }

  const recording::Recording& recording_;
  ForceChannels& out_;
};

void read_driver(const recording::Recording& recording, const vehicle::Car<double>& car,
                 Reader& reader, ForceChannels& out) {
  if (!reader.add("steer_rad", false, kPlaceSteer, 5e-5, kPlaceSteerOffset)) {
    if (!car.files->steering.empty())
      throw base::Error(
          "the vehicle has a steering map and the recording has no steer_rad; forces take "
          "steer_command_rad by a constant ratio only: wanted the road wheels' angle");
    reader.need(reader.add("steer_command_rad", false, kPlaceSteer, 5e-5, kPlaceSteerOffset,
                           1.0 / car.parameters[P::steering_ratio]),
                "steer_rad");
    out.said.emplace_back("steer_command_rad stands for the angle of the road wheels");
  }
  const auto pressure = [&](const std::string& channel, std::size_t wheel, double scale = 1.0) {
    return reader.add_pedal(channel, kPlaceBrake + wheel, 2e3, {0.0}, scale);
  };
  if (!reader.add_pedal("throttle", kPlaceThrottle, 0.002, {0.0, 1.0})) {
    reader.need(reader.add_pedal("throttle_command", kPlaceThrottle, 0.002, {0.0, 1.0},
                                 car.parameters[P::throttle_gain]),
                "throttle");
    out.said.emplace_back("throttle_command stands for the throttle");
  }
  const double gain = car.parameters[P::brake_gain];
  bool any = false;
  for (std::size_t i = 0; i < kWheels; ++i)
    any = pressure(fmt::format("brake_{}_pa", recording::kWheelNames[i]), i) || any;
  if (any) return;
  const bool one = recording.table.find("brake_pa") != nullptr;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::string own = fmt::format("brake_{}_command_pa", recording::kWheelNames[i]);
    any = (one ? pressure("brake_pa", i) : pressure(own, i, gain)) || any;
  }
  if (!any && recording.table.find("brake_command_pa") != nullptr)
    for (std::size_t i = 0; i < kWheels; ++i) any = pressure("brake_command_pa", i, gain) || any;
  if (!any)
    out.said.emplace_back(
        "no brake pressure was recorded: braking is followed by what it does, and is not told "
        "from drag or engine drag; which axle brakes is not known");
  else if (one)
    out.said.emplace_back("brake_pa stands for the pressure at all wheels");
  else
    out.said.emplace_back("brake commands stand for the pressures");
}

void read_car(Reader& reader) {
  reader.need(reader.add("x_m", false, place_of(vehicle::kX), 0.001), "x_m");
  reader.need(reader.add("y_m", false, place_of(vehicle::kY), 0.001), "y_m");
  reader.need(reader.add("yaw_rad", false, place_of(vehicle::kYaw), 1e-4), "yaw_rad");
  reader.need(reader.add("vx_mps", false, place_of(vehicle::kVx), 0.003), "vx_mps");
  reader.add("vy_mps", false, place_of(vehicle::kVy), 0.003);
  reader.add("roll_rate_radps", false, place_of(vehicle::kRollRate), 5e-4);
  reader.add("pitch_rate_radps", false, place_of(vehicle::kPitchRate), 5e-4);
  reader.add("yaw_rate_radps", false, place_of(vehicle::kYawRate), 2e-4, kPlaceYawRateOffset);
  reader.add("ax_mps2", true, kSeenAx, 0.01, kPlaceAxOffset);
  reader.add("ay_mps2", true, kSeenAy, 0.01, kPlaceAyOffset);
  reader.add("az_mps2", true, kSeenAz, 0.02);
  // Wheels that turn faster than the stated radii say turn the engine as much faster.
  reader.add("engine_radps", false, place_of(vehicle::kEngine), 0.3, kPlaces, 1.0,
             kPlaceRolling + 1);
  for (std::size_t i = 0; i < kWheels; ++i) {
    reader.add(fmt::format("wheel_{}_radps", recording::kWheelNames[i]), false,
               place_of(vehicle::kSpin + i), 0.02, kPlaces, 1.0,
               kPlaceRolling + vehicle::axle_of(i));
    reader.add(fmt::format("suspension_{}_m", recording::kWheelNames[i]), false,
               place_of(vehicle::kTravel + i), 5e-5);
    reader.add(fmt::format("fz_{}_n", recording::kWheelNames[i]), true, seen_of(i, kSeenFz), 5.0);
  }
}

/// The gear of every row, by the channel, else by the speeds of engine and wheels, else the one
/// that the car would choose.
std::vector<int> gears(const recording::Recording& recording, const vehicle::Car<double>& car,
                       std::vector<std::string>& said) {
  const std::vector<double>& time = *recording.table.find("time_s");
  std::vector<int> out(time.size(), 1);
  const auto filled = [&](const std::string& name) {
    const std::vector<double>* const column = recording.table.find(name);
    std::vector<double> values =
        column == nullptr ? std::vector<double>{} : recording::fill_gaps(time, *column);
    if (!values.empty() && std::isnan(values.front())) values.clear();
    return values;
  };
  if (const std::vector<double>* const gear = recording.table.find("gear")) {
    double last = kNaN;
    for (const double g : *gear)
      if (std::isfinite(g) && !std::isfinite(last)) last = g;
    for (std::size_t k = 0; k < out.size(); ++k) {
      if (std::isfinite((*gear)[k])) last = (*gear)[k];
      out[k] = std::isfinite(last)
                   ? std::clamp(static_cast<int>(std::lround(last)), -1, vehicle::kMostGears)
                   : 1;
    }
    return out;
  }
  const std::vector<double> engine = filled("engine_radps"), left = filled("wheel_rl_radps"),
                            right = filled("wheel_rr_radps"), vx = filled("vx_mps");
  const bool speeds = !engine.empty() && !left.empty() && !right.empty();
  said.emplace_back(speeds ? "no gear was recorded: it is told by the speeds of engine and wheels"
                           : "no gear was recorded: the one that the built-in driver would choose");
  int now = vehicle::choose_gear(car, vx.front(), vehicle::kMostGears);
  for (std::size_t k = 0; k < out.size(); ++k) {
    if (!speeds) {
      now = vehicle::choose_gear(car, vx[k], now);
    } else {
      const double turning = 0.5 * (left[k] + right[k]);
      double nearest = 0.08;
      for (int g = 1; g <= vehicle::kMostGears; ++g) {
        const double ratio = vehicle::overall_ratio(car.parameters, g);
        if (ratio <= 0.0 || turning < 1.0) continue;
        const double off = std::abs(engine[k] / (ratio * turning) - 1.0);
        if (off < nearest) {
          nearest = off;
          now = g;
        }
      }
    }
    out[k] = now;
  }
  return out;
}

void set_gears(const recording::Recording& recording, const vehicle::Car<double>& car,
               ForceChannels& out) {
  const std::vector<int> gear = gears(recording, car, out.said);
  // A log that never shows neutral shows the gear that was asked for: the shift follows.
  const bool neutral = std::find(gear.begin(), gear.end(), 0) != gear.end();
  const double shift_s = car.parameters[P::gearbox_shift_s];
  double changed_s = -1e9;
  int next = gear.back();
  for (std::size_t k = 0; k < gear.size(); ++k) {
    SmootherRow& row = out.rows[k];
    if (k > 0 && gear[k] != gear[k - 1]) changed_s = row.time_s;
    row.driven.gear = row.driven.next_gear = gear[k];
    if (!neutral && row.time_s - changed_s < shift_s) row.driven.gear = 0;
  }
  for (std::size_t k = gear.size(); neutral && k-- > 0;) {
    if (gear[k] != 0) next = gear[k];
    out.rows[k].driven.next_gear = next;
  }
}

/// When between two rows the gear changed is not known: half the clutch's torque may have acted for
/// that much longer or shorter.
void add_shift(const vehicle::Car<double>& car, SmootherRow& row, int gear_before, double dt_s) {
  const double about_s = dt_s / std::sqrt(12.0);
  const double clutch_nm = 0.5 * car.parameters[P::clutch_torque_nm];
  const int gear = row.driven.gear != 0 ? row.driven.gear : gear_before;
  const double ratio = std::abs(vehicle::overall_ratio(car.parameters, gear));
  const double engine = about_s * clutch_nm / car.parameters[P::engine_inertia_kgm2];
  const double wheel =
      about_s * 0.5 * clutch_nm * ratio / car.parameters[P::rear_wheel_inertia_kgm2];
  const double patch = 0.5 * dt_s * wheel * car.static_radius_m[1];
  row.noise[static_cast<Index>(place_of(vehicle::kEngine))] += engine * engine;
  for (std::size_t i = 2; i < kWheels; ++i) {
    row.noise[static_cast<Index>(place_of(vehicle::kSpin + i))] += wheel * wheel;
    row.noise[static_cast<Index>(place_of(vehicle::kSlipX + i))] += patch * patch;
  }
}

/// Shifts throw the engine's speed about.
void set_noises(const recording::Recording& recording, const vehicle::Car<double>& car,
                ForceChannels& out) {
  const PlaceVector per_second = noise_per_second();
  for (std::size_t k = 0; k < out.rows.size(); ++k) {
    SmootherRow& row = out.rows[k];
    const double dt = k == 0
                          ? recording.step_s
                          : std::min(row.time_s - out.rows[k - 1].time_s, 2.5 * recording.step_s);
    row.noise = dt * per_second;
    const int before = k > 0 ? out.rows[k - 1].driven.gear : row.driven.gear;
    if (row.driven.gear != before) add_shift(car, row, before, dt);
  }
}

/// What the vehicle file leaves open of what stays as it is, and of what its parts are on the
/// whole. Priors are two standard deviations.
void set_stated(const std::array<double, vehicle::kParameterCount>& prior, PlaceVector& sd) {
  const auto of = [&](P p) { return 0.5 * prior[static_cast<std::size_t>(p)]; };
  for (std::size_t i = 0; i < kStated.size(); ++i)
    sd[static_cast<Index>(kPlaceStated + i)] = of(kStated[i].parameter);
  for (std::size_t i = 0; i < kParts.size(); ++i) {
    const P part = kParts[i].parameter;
    double share = of(part);
    if (part == P::front_brake_area_m2) share = std::hypot(share, of(P::front_brake_friction));
    if (part == P::rear_brake_area_m2) share = std::hypot(share, of(P::rear_brake_friction));
    sd[static_cast<Index>(rest_of(kPlaceParts + i))] = share;
  }
}

}  // namespace

namespace {

/// Of states that are estimated: at a begin, and what comes in per second.
struct StateDeviation {
  std::size_t state, count;
  double begin, per_second;
};
constexpr StateDeviation kStateDeviations[] = {
    {vehicle::kX, 2, 0.3, 1e-3},           {vehicle::kZ, 1, 0.01, 1e-3},
    {vehicle::kRoll, 2, 0.01, 1e-4},       {vehicle::kYaw, 1, 0.03, 1e-4},
    {vehicle::kVx, 2, 0.5, 3e-3},          {vehicle::kVz, 1, 0.1, 0.01},
    {vehicle::kRollRate, 3, 0.1, 2e-3},    {vehicle::kTravel, 4, 0.01, 1e-4},
    {vehicle::kTravelRate, 4, 0.05, 0.02}, {vehicle::kSpin, 4, 3.0, 0.1},
    {vehicle::kSlipX, 8, 0.01, 1e-5},      {vehicle::kEngine, 1, 30.0, 1.0},
    {vehicle::kBoost, 1, 0.3, 0.02}};

PlaceVector deviations(double rest, double StateDeviation::*of, double brake, double part) {
  PlaceVector sd = PlaceVector::Constant(rest);
  for (const StateDeviation& d : kStateDeviations)
    for (std::size_t i = 0; i < d.count; ++i) sd[static_cast<Index>(place_of(d.state + i))] = d.*of;
  sd.segment<kPlaceParts - kPlaceBrake>(kPlaceBrake).setConstant(brake);
  sd.segment<kChangingPlaces - kPlaceParts>(kPlaceParts).setConstant(part);
  return sd;
}

}  // namespace

PlaceVector begin_deviations(const std::array<double, vehicle::kParameterCount>& prior) {
  PlaceVector sd = deviations(1.0, &StateDeviation::begin, 3e5, 0.03);
  sd[kPlaceSteer] = 0.02;
  sd[kPlaceSteerRate] = 0.3;
  sd[kPlaceThrottle] = 0.1;
  set_stated(prior, sd);
  sd[kPlaceAxOffset] = sd[kPlaceAyOffset] = 0.1;
  sd[kPlaceYawRateOffset] = 0.003;
  sd[kPlaceSteerOffset] = 0.001;
  sd[kPlaceRolling] = sd[kPlaceRolling + 1] = 0.02;
  return sd;
}

PlaceVector noise_per_second() {
  PlaceVector sd =
      deviations(0.0, &StateDeviation::per_second, 5e6, 0.03 * std::sqrt(2.0 / kForgetPart_s));
  sd[kPlaceSteerRate] = 2.0;
  sd[kPlaceThrottle] = 1.0;
  return sd.cwiseAbs2();
}

ForceChannels read_force_channels(const recording::Recording& recording,
                                  const vehicle::Car<double>& car) {
  ForceChannels out;
  const std::vector<double>& time = *recording.table.find("time_s");
  out.rows.resize(time.size());
  for (std::size_t k = 0; k < time.size(); ++k) out.rows[k].time_s = time[k];
  Reader reader(recording, out);
  read_car(reader);
  read_driver(recording, car, reader, out);
  set_gears(recording, car, out);
  set_noises(recording, car, out);
  move_feet(recording, out);
  return out;
}

}  // namespace identify
