#include "scenarios.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>

#include "truth_car_electric.h"
#include "write_trial.h"

namespace trials {
namespace {

/// Of the driver: how he drives each lap.
unsigned long long route = 20;
/// Whether the third car drives.
bool third = false;

/// A track and a car, nothing missing, all channels.
Trial plain(const std::string& name, double hz = 50, int laps = 5) {
  Trial t;
  t.name = name;
  t.kind = "proof";
  t.track = make_track(215, 0.22, 0.12, 0.035, 2.0);
  t.track.hill = {2.5, 0.8, 0.3};
  t.track.hill_phase = {1, 3, 5};
  t.track.bank_base = 0.01;
  t.style.laps = laps;
  t.style.seed = route;
  t.hz = hz;
  t.off = 0.02;
  if (third) t.truth.car = t.nominal = electric_car(TyreLaw::kBrush);
  return t;
}

/// Of the most affected one of these channels: the truth files of the proofs leave out the right
/// rear wheel and the vertical.
double planar_size(const Drive& d) {
  double size = 0;
  for (const std::size_t channel : {kX, kYaw, kVx, kVy, kR, kWrl})
    size = std::max(size, d.channel_size[channel]);
  return size;
}

void add(Trial& t, const Effect& e) {
  t.truth.car.effects.push_back(e);
  Style one = t.style;
  one.laps = 1;
  const Variant without{t.nominal};
  Variant alone = without;
  alone.car.effects = {e};
  t.sizes.push_back(
      e.mechanism.starts_with("sensor.") ? 0.0 : planar_size(drive(alone, t.track, one, &without)));
}

Trial none() { return plain("none"); }

/// More torque and a turbo that is late: flat out, the lap takes as long as without both.
Trial compensated() {
  Trial t = plain("compensated");
  t.style.pace_low = 0.66;
  t.style.pace_high = 0.8;
  t.style.first_pace = 0.8;
  t.style.drive = 2.2;
  const Effect lag{"vehicle.turbo_lag", "", 0.3, 0, 0, 0.5};
  const auto lap_s = [&](double torque, bool late) {
    TruthCar car = t.nominal;
    if (late) car.effects = {lag, {"parameter.engine_torque", "", torque}};
    Style two = t.style;
    two.laps = 2;
    return drive({car}, t.track, two, nullptr).lap_s;
  };
  const double stated_s = lap_s(0, false);
  double low = 0, high = 0.2;
  for (int k = 0; k < 7; ++k) {
    const double mid = 0.5 * (low + high);
    (lap_s(mid, true) > stated_s ? low : high) = mid;
  }
  add(t, lag);
  add(t, {"parameter.engine_torque", "", 0.5 * (low + high)});
  t.notes = {{"lap_s", lap_s(0.5 * (low + high), true)},
             {"lap_s_of_the_stated_car", stated_s},
             {"lap_s_without_the_torque", lap_s(0, true)}};
  return t;
}

/// Pads that fade, and stated brakes that are weaker by as much as they fade on average; no
/// temperature is logged.
Trial fade() {
  Trial t = plain("fade");
  add(t, {"vehicle.brake_friction_temperature", "", 0.4});
  t.nominal.brake_f *= 0.9;
  t.nominal.brake_r *= 0.9;
  return t;
}

/// A road that leans by 4 to 7 % in three corners, and a file that is flat there.
Trial banking() {
  Trial t = plain("banking");
  const double l = t.track.length_m;
  add(t, {"road.banking", "", 0.06, 0.10 * l, 0.25 * l});
  return t;
}

/// A drive whose log also has what the wheels and the body do, 200 times a second.
Trial shaken(const std::string& name) {
  Trial t = plain(name, 200, 4);
  t.ride.emplace();
  t.style.pace_low = 0.66;
  t.style.pace_high = 0.8;
  return t;
}

/// Waves of 6 and 5 mm that were smoothed away, over the whole width.
Trial bumps() {
  Trial t = shaken("bumps");
  t.stated_track = t.track;
  t.style.sway_m = 0.6;
  t.track.feature = {{300, 340, -10, 10, 0.006, 4.0, false},
                     {900, 925, -10, 10, 0.005, 2.5, false}};
  t.stated_track->feature = {{300, 340, -10, 10, 0.0, 4.0, false}};
  return t;
}

/// A kerb of 30 mm teeth left of the line that the file has at a third of its height.
Trial kerb() {
  Trial t = shaken("kerb");
  t.stated_track = t.track;
  t.style.sway_m = 0.4;
  t.track.feature = {{500, 520, 0.2, 3.0, 0.03, 1.0, true}};
  t.stated_track->feature = {{500, 520, 0.2, 3.0, 0.01, 1.0, true}};
  return t;
}

/// The same kerb, known exactly; the simulated tyre touches the road in one point.
Trial contact() {
  Trial t = shaken("contact");
  t.style.sway_m = 0.4;
  t.track.feature = {{500, 520, 0.2, 3.0, 0.03, 0.5, true},
                     {1000, 1030, -10, 10, 0.015, 0.8, true}};
  return t;
}

/// Discs that start cold and conduct better when hot, or (slope 0) do not.
Trial discs(const std::string& name, double slope_1pk) {
  Trial t = plain(name, 50, 6);
  t.discs.emplace();
  t.discs->slope_1pk = slope_1pk;
  return t;
}

/// A gyro that is late; slow swings do not show whether by a delay or a filter.
Trial alike(bool apart) {
  Trial t = plain(apart ? "alike-apart" : "alike");
  t.style.sway_waves = 2;
  t.style.pace_high = 0.8;
  t.style.laps = 3;
  t.alike = {"sensor.delay", "sensor.low_pass"};
  add(t, {"sensor.delay", "yaw_rate_radps", 0.06});
  if (apart) {
    t.experiment = t.style;
    t.experiment->laps = 2;
    t.experiment->seed = 21;
    t.experiment->weave_rad = 0.02;
  }
  return t;
}

/// A push that no library knows: the brakes turn the car.
Trial outside() {
  Trial t = plain("outside");
  add(t, {"outside.brake_pull", "", 7});
  return t;
}

/// One effect, and a stated car without these terms.
Trial lacks(const std::string& name, const Effect& effect, std::vector<std::string> without = {}) {
  Trial t = plain(name);
  t.without = std::move(without);
  add(t, effect);
  return t;
}

/// Scenarios that the third car cannot drive.
const std::set<std::string> kOfTheSecond{"compensated", "burn",  "bumps",      "kerb",
                                         "contact",     "discs", "discs-plain"};

}  // namespace

bool make_scenario(const std::string& name, const std::filesystem::path& folder, int laps) {
  const std::map<std::string, Trial (*)()> all{
      {"none", none},
      {"compensated", compensated},
      {"fade", fade},
      {"banking", banking},
      {"bumps", bumps},
      {"kerb", kerb},
      {"contact", contact},
      {"discs", [] { return discs("discs", 2e-3); }},
      {"discs-plain", [] { return discs("discs-plain", 0.0); }},
      {"alike", [] { return alike(false); }},
      {"alike-apart", [] { return alike(true); }},
      {"outside", outside},
      {"relaxation",
       [] {
         return lacks("relaxation", {"vehicle.tyre_relaxation", "", 1.0}, {"tyre_relaxation"});
       }},
      {"long",
       [] {
         return lacks("long", {"vehicle.tyre_relaxation", "", 3.0}, {"tyre_relaxation"});
       }},
      {"camber",
       [] {
         Trial t = plain("camber");
         t.nominal.camber = t.truth.car.camber = 0.05;
         add(t, {"vehicle.tyre_camber", "", 2.0});
         return t;
       }},
      {"combined",
       [] {
         return lacks("combined", {"vehicle.tyre_combined_slip", "", 1.0}, {"tyre_combined_slip"});
       }},
      {"load",
       [] {
         return lacks("load", {"vehicle.tyre_load_sensitivity", "", 1.0},
                      {"tyre_load_sensitivity"});
       }},
      {"downforce",
       [] {
         return lacks("downforce", {"vehicle.aero_downforce", "", 1.0}, {"aero_downforce"});
       }},
      {"ride",
       [] {
         return lacks("ride", {"vehicle.aero_ride_height", "", 0.3});
       }},
      {"coupled",
       [] {
         return lacks("coupled", {"vehicle.differential", "", 0.3});
       }},
      {"wind",
       [] {
         return lacks("wind", {"environment.wind", "", 6, 0, 0, 0.7});
       }},
      {"warm",
       [] {
         return lacks("warm", {"vehicle.tyre_thermal", "", 0.2, 0, 0, 50});
       }},
      {"burn",
       [] {
         return lacks("burn", {"vehicle.fuel_burn", "", 0.15});
       }},
      {"misplaced",
       [] {
         Trial t = plain("misplaced");
         t.stated_track = t.track;
         t.track.hill = t.stated_track->hill = {4, 2, 1};
         t.track.shift_m = 20;
         return t;
       }},
      {"radius",
       [] {
         Trial t = plain("radius");
         t.truth.car.radius_r *= 1.12;
         return t;
       }},
      {"late",
       [] {
         Trial t = plain("late");
         t.truth.throttle_dead_s = 0.08;
         return t;
       }},
      {"gains",
       [] {
         Trial t = plain("gains");
         t.commands = true;
         t.truth.car.brake_f *= 1.22;
         t.truth.car.brake_r *= 1.22;
         t.truth.steer_gain = 1.15;
         t.truth.throttle_gain = 1.15;
         return t;
       }},
      {"filtered",
       [] {
         Trial t = plain("filtered");
         add(t, {"sensor.low_pass", "ax_mps2", 0.02});
         return t;
       }},
      {"play",
       [] {
         Trial t = plain("play");
         t.commands = true;
         t.truth.steer_play_rad = 0.008;
         return t;
       }},
      {"slippery", [] {
         Trial t = plain("slippery");
         const double l = t.track.length_m;
         add(t, {"road.friction", "", -0.3, 0.6 * l, 0.75 * l});
         return t;
       }}};
  const std::size_t colon = name.find(':');
  if (colon != std::string::npos) route = std::strtoull(name.c_str() + colon + 1, nullptr, 10);
  const std::string of_third = "third-";
  third = name.starts_with(of_third);
  const std::size_t begin = third ? of_third.size() : 0;
  const auto found = all.find(name.substr(begin, colon - begin));
  // About a turbo, fuel, or what shakes and heats the second car.
  const bool without_third = found != all.end() && kOfTheSecond.contains(found->first);
  if (found == all.end() || (third && without_third)) {
    std::fprintf(stderr,
                 "make_trials: no scenario %s; there are (of the third car with third- before "
                 "them)",
                 name.c_str());
    for (const auto& [known, make] : all) std::fprintf(stderr, " %s", known.c_str());
    std::fprintf(stderr, "\n");
    return false;
  }
  Trial trial = found->second();
  if (laps > 0) trial.style.laps = laps;
  if (third) trial.name = of_third + trial.name;
  if (colon != std::string::npos) trial.name += name.substr(colon + 1);
  std::filesystem::create_directories(folder / "sealed");
  Random dice{7};
  return write_trial(trial, dice, folder);
}

}  // namespace trials
