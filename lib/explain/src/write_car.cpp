// What findings about the car mean in the words of a vehicle folder.
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "explain/fuel.h"
#include "explain/write_back.h"
#include "base/read_file.h"
#include "late_actuator.h"
#include "refit_car.h"
#include "vehicle/driver.h"
#include "vehicle/error.h"
#include "vehicle/laws/aero.h"
#include "vehicle/laws/disc_heat.h"
#include "vehicle/laws/fuel.h"
#include "vehicle/step.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;

std::string name_of(P p) { return std::string(vehicle::parameter_list()[static_cast<std::size_t>(p)].name); }

/// What changes against the stated car.
struct Changes {
  const vehicle::Vehicle& car;
  const std::vector<Signals>& logs;
  std::map<std::string, double> parameters, terms;
  std::array<std::map<std::string, double>, 2> tyre{};  ///< keywords of the tyre files
  std::map<std::string, vehicle::Map2> maps;
  bool strip = false;
  double fuel_kg = 0.0;
  std::vector<std::string> remarks;

  bool none() const { return parameters.empty() && terms.empty() && tyre[0].empty() && tyre[1].empty() && maps.empty() && !strip && remarks.empty(); }
  void set(P p, double x) { parameters[name_of(p)] = x; }
  double now(P p) const {
    const auto at = parameters.find(name_of(p));
    return at == parameters.end() ? car.parameters[p] : at->second;
  }
};

/// Calls f(speed, yaw rate, lateral speed) at every step where the first two are known; the third is 0 where it is not.
template <class F>
void at_speeds(const std::vector<Signals>& logs, F&& f) {
  for (const Signals& s : logs)
    for (std::size_t i = 0; i < s.n; ++i) {
      const double speed = s.x[kVx][i], rate = s.present[kYawRate] ? s.x[kYawRate][i] : s.dx[kYaw][i];
      if (std::isfinite(speed) && std::isfinite(rate) && speed > 6) f(speed, rate, std::isfinite(s.x[kVy][i]) ? s.x[kVy][i] : 0.0);
    }
}

/// An actuator that the stated car lacks is a pure delay or lag; to one that it has, the finding adds.
void add_actuator(Changes& out, const Finding& f) {
  const LateActuator& late = *late_actuator(f.mechanism);
  const bool had = out.car.terms[late.term] > 0;
  if (had && !commanded(out.logs, late.channel))
    out.remarks.push_back(fmt::format("{}: found behind the measured position, where no actuator of this file acts; it is added to the one before, for the driver's commands", f.mechanism));
  if (!had && out.terms.count(late.name) == 0) {
    out.set(late.dead_time, 0);
    out.set(late.lag, 0);
    out.set(late.damping, 1);
    out.set(late.lead, 0);
  }
  out.terms[late.name] = 1;
  // Two lags in a row of half the time are as late as the one that was found.
  const bool lag = f.mechanism == "vehicle.steering_lag";
  const P p = lag ? late.lag : late.dead_time;
  out.set(p, out.now(p) + (lag ? 0.5 : 1.0) * f.parameters[0].value);
}

/// Amounts up to one are the term's; beyond, what scales the same force in the tyre files.
void add_tyre_term(Changes& out, const Finding& f) {
  const std::string name = f.mechanism.substr(8);
  const Term term = *vehicle::find_term(name);
  const double amount = out.car.terms[term] + f.parameters[0].value;
  out.terms[name] = std::clamp(amount, 0.0, 1.0);
  if (amount <= 1) return;
  for (std::size_t k = 0; k < 2; ++k) {
    const vehicle::TyreCoefficients& t = out.car.files.tyre[k];
    if (term == Term::tyre_camber) out.tyre[k]["LGAY"] = amount * t.lgay;
    else if (term == Term::tyre_relaxation && t.lateral_stiffness_npm > 0) out.tyre[k]["LATERAL_STIFFNESS"] = t.lateral_stiffness_npm / amount;
    else if (term == Term::tyre_relaxation) out.tyre[k]["PTY1"] = amount * t.pty1;
    else if (k == 0) out.remarks.push_back(fmt::format("{}: found {:.4g} of what the tyre files say; a term holds 1 at most", f.mechanism, amount));
  }
}

/// The relations see what is missing as a share of the area.
void add_aero_term(Changes& out, const Finding& f, std::initializer_list<P> areas) {
  const std::string name = f.mechanism.substr(8);
  const double amount = out.car.terms[*vehicle::find_term(name)] + f.parameters[0].value;
  out.terms[name] = std::clamp(amount, 0.0, 1.0);
  if (amount > 1)
    for (const P area : areas) out.set(area, amount * out.now(area));
}

/// A coupling of the driven wheels whose torque grows with their speed difference, strong enough to take
/// away the share that was found of what turning asks for, at the speeds and yaw rates of the logs:
/// with slip stiffnesses K of the wheels, as loaded and slipping sideways, c v / R^2 (1 / K_left + 1 / K_right) = share / (1 - share).
void add_differential(Changes& out, const Finding& f) {
  const double wanted = std::clamp(f.parameters[0].value, 0.02, 0.98);
  const vehicle::TyreCoefficients& tyre = out.car.files.tyre[1];
  const auto& p = out.car.parameters;
  const auto roll = [&](P spring, P bar, P track) { return (p[spring] + 2 * p[bar]) * p[track] * p[track]; };
  const double rear_roll = roll(P::rear_spring_npm, P::rear_anti_roll_npm, P::rear_track_m);
  const double lean = p[P::chassis_mass_kg] * p[P::chassis_cog_height_m] / p[P::rear_track_m] * rear_roll / (rear_roll + roll(P::front_spring_npm, P::front_anti_roll_npm, P::front_track_m));
  const double radius = tyre.unloaded_radius_m * tyre.qre0, weight = p[P::chassis_mass_kg] * p[P::environment_gravity_mps2] * p[P::chassis_cog_behind_front_m] / p[P::chassis_wheelbase_m];
  const double behind = p[P::chassis_wheelbase_m] - p[P::chassis_cog_behind_front_m];
  std::vector<std::array<double, 2>> points;  // v / R^2 (1 / K_left + 1 / K_right), weight
  at_speeds(out.logs, [&](double speed, double rate, double across) {
    const double down = vehicle::laws::air_forces(p, speed, speed * speed).rear_n * out.car.terms[Term::aero_downforce];
    const double load = 0.5 * (weight + down), moved = std::min(0.9 * load, lean * speed * std::abs(rate));
    const auto stiffness = [&](double n) {
      vehicle::TyreInput<double> in;
      in.fz_n = n;
      in.tan_alpha = (across - behind * rate) / speed;
      in.vx_mps = speed;
      in.pressure_pa = p[P::rear_tyre_pressure_pa];
      vehicle::TyreFactors<double> factors;
      factors.grip_x = factors.grip_y = p[P::rear_tyre_grip];
      factors.stiffness_x = p[P::rear_tyre_slip_stiffness];
      factors.stiffness_y = p[P::rear_tyre_cornering_stiffness];
      const vehicle::TyreOptions options{.alpha = out.car.files.alpha, .moments = false};
      in.kappa = 0.005;
      const double driven = vehicle::tyre_forces(tyre, in, factors, options).fx_n;
      in.kappa = -0.005;
      return std::max(1e3, (driven - vehicle::tyre_forces(tyre, in, factors, options).fx_n) / 0.01);
    };
    points.push_back({speed / (radius * radius) * (1 / stiffness(load + moved) + 1 / stiffness(load - moved)), rate * rate});
  });
  const auto share = [&](double coupling) {
    double sum = 0, all = 1e-300;
    for (const auto& [per, w] : points) sum += w * coupling * per / (1 + coupling * per), all += w;
    return sum / all;
  };
  double low = 0, high = 1e5;
  for (int k = 0; k < 60; ++k) (share(0.5 * (low + high)) < wanted ? low : high) = 0.5 * (low + high);
  out.terms["locked_differential"] = wanted;
  out.terms["limited_slip"] = 0;
  out.set(P::differential_lock_nms, low / wanted);
}

/// Heights of the floor at both axles of the simulated car, straight on at this speed, m.
std::array<double, 2> floor_at(const vehicle::Vehicle& stated, const vehicle::Amplitudes<double>& terms, const vehicle::Parameters<double>& parameters, double speed_mps) {
  const auto car = vehicle::make_car(stated.files, parameters, terms);
  const vehicle::Road flat;
  vehicle::StartOptions begin;
  begin.speed_mps = speed_mps;
  begin.fuel_kg = 0;
  begin.gear = vehicle::choose_gear(car, speed_mps, 6);
  auto sim = vehicle::start(car, flat, begin);
  vehicle::Detail<double> detail;
  vehicle::Controls<double> controls;
  controls.gear_command = begin.gear;
  std::array<double, 2> sum{};
  constexpr int kSettle = 1500, kMean = 500;
  for (int i = 0; i < kSettle + kMean; ++i) {
    controls.throttle_command = std::clamp(0.3 + 0.5 * (speed_mps - sim.state[vehicle::kVx]), 0.0, 1.0);
    if (const auto result = vehicle::step(car, sim, controls, flat, {}, detail); !result.ok())
      throw vehicle::Error("the stated car, straight on: " + vehicle::describe(result, sim.time_s, sim.state[vehicle::kX], sim.state[vehicle::kY]));
    if (i < kSettle) continue;
    for (std::size_t wheel = 0; wheel < vehicle::kWheels; ++wheel) sum[vehicle::axle_of(wheel)] += detail.wheel[wheel].ride_m / (2 * kMean);
  }
  return sum;
}

/// Downforce over the heights of the floor: straight in both and weighed by what the axles give, so that
/// pitching alone changes nothing, and as steep as it takes to lose what was found at the speed where it
/// was mostly found.
void add_ride_height(Changes& out, const Finding& f) {
  double sum = 0, all = 1e-300;
  at_speeds(out.logs, [&](double speed, double, double) { sum += std::pow(speed, 9), all += std::pow(speed, 8); });  // in proportion to the square of the force that is missing
  const double speed = sum / all, pressure = vehicle::laws::dynamic_pressure(out.now(P::aero_density_kgpm3), speed);
  const double left = 1 - f.parameters[0].value * pressure / 1000;
  vehicle::Parameters<double> parameters = out.car.parameters;
  for (const auto& [name, value] : out.parameters) parameters[*vehicle::find_parameter(name)] = value;
  for (const P lift : {P::front_lift_area_m2, P::rear_lift_area_m2}) parameters[lift] *= left;
  const std::array<P, 2> ride{P::front_ride_height_m, P::rear_ride_height_m};
  std::array<double, 2> sink{}, give{};  // m; m/N of a wheel
  if (left > 0.3) try {
    const auto floor = floor_at(out.car, out.car.terms, parameters, speed);
    for (std::size_t k = 0; k < 2; ++k) {
      sink[k] = parameters[ride[k]] - floor[k];
      give[k] = 1 / std::max(1e4, parameters.axle(k, P::front_spring_npm)) + 1 / out.car.files.tyre[k].vertical_stiffness_npm;
    }
  } catch (const vehicle::Error& error) {
    out.remarks.push_back(fmt::format("{}: {}", f.mechanism, error.what()));
    return;
  }
  const double pressed = left > 0.3 ? sink[0] / give[0] + sink[1] / give[1] : 0.0;
  if (!(pressed > 100)) {
    out.remarks.push_back(fmt::format("{}: {:.4g} per kPa; at {:.3g} m/s the floor does not sink in a way that could tell: not switched on", f.mechanism, f.parameters[0].value, speed));
    return;
  }
  vehicle::Map2 factor;
  for (std::size_t k = 0; k < 2; ++k) {
    // Far enough for brakes and kerbs; constant beyond.
    const double way = 2 * give[k] * std::max(pressed, 0.5 * parameters[P::chassis_mass_kg] * parameters[P::environment_gravity_mps2]);
    (k == 0 ? factor.x : factor.y) = {parameters[ride[k]] - way, parameters[ride[k]] + way};
  }
  for (const double front : factor.x)
    for (const double rear : factor.y) factor.z.push_back(1 - (1 - left) / pressed * ((parameters[ride[0]] - front) / give[0] + (parameters[ride[1]] - rear) / give[1]));
  out.maps["front_lift_factor"] = out.maps["rear_lift_factor"] = factor;
  if (!out.car.files.front_lift_factor.empty()) out.remarks.push_back(fmt::format("{}: the maps over ride heights that the stated car has switched off are replaced", f.mechanism));
  std::fill(factor.z.begin(), factor.z.end(), 1.0);
  out.maps["drag_factor"] = factor;
  out.terms["aero_ride_height"] = 1;
}

/// The free radius at which the standing tyre rolls on `share` of what the stated one rolls on.
double radius_that_rolls(const vehicle::TyreCoefficients& stated, double load_n, double pressure_pa, double share) {
  const auto rolls = [&](double radius_m) {
    vehicle::TyreCoefficients t = stated;
    t.unloaded_radius_m = radius_m;
    return vehicle::standing_rolling_radius(t, load_n, pressure_pa);
  };
  double radius = stated.unloaded_radius_m;
  const double wanted = share * rolls(radius);
  for (int k = 0; k < 5; ++k) radius += (wanted - rolls(radius)) / stated.qre0;
  return radius;
}

void add_wheel_radius(Changes& out, const Finding& f) {
  if (out.logs.front().wheels_in_mps) return;  // the logger's, see corrected_mapping()
  const std::size_t k = f.parameters[0].name.starts_with("front") ? 0 : 1;
  const auto& p = out.car.parameters;
  const double a = p[P::chassis_cog_behind_front_m], wheelbase = p[P::chassis_wheelbase_m];
  const double load = p[P::chassis_mass_kg] * p[P::environment_gravity_mps2] * (k == 0 ? wheelbase - a : a) / (2 * wheelbase);
  out.tyre[k]["UNLOADED_RADIUS"] = radius_that_rolls(out.car.files.tyre[k], load, p.axle(k, P::front_tyre_pressure_pa), f.parameters[0].value);
}

/// The car as stated is that of the log's begin: what burns over the log becomes fuel in its centre of
/// mass. What the power does not explain burns without torque.
void add_fuel_burn(Changes& out, const Finding& f) {
  if (std::any_of(out.logs.begin(), out.logs.end(), [](const Signals& s) { return s.present[kFuel]; })) {
    out.remarks.push_back(fmt::format("{}: {:.4g} kg/s beyond what the fuel loses that was logged or given; the gauge, the mass or the stated fuel_burn is off", f.mechanism, f.parameters[0].value));
    return;
  }
  const auto& p = out.car.parameters;
  double longest = 0, work = 0, seconds = 1e-9;
  for (const Signals& s : out.logs) {
    longest = std::max(longest, Signals::kStep_s * static_cast<double>(s.n)), seconds += Signals::kStep_s * static_cast<double>(s.n);
    for (const double power : useful_power_w(s, out.car)) work += power * Signals::kStep_s;
  }
  const double rate = f.parameters[0].value;
  out.fuel_kg = rate * longest;
  out.terms["fuel_burn"] = 1;
  out.set(P::fuel_idle_kgps, std::max(0.0, rate - vehicle::laws::fuel_for_work(p, work / seconds)));
  out.set(P::chassis_mass_kg, out.now(P::chassis_mass_kg) - out.fuel_kg);
  if (!out.car.stated[static_cast<std::size_t>(P::fuel_tank_behind_front_m)]) out.set(P::fuel_tank_behind_front_m, out.now(P::chassis_cog_behind_front_m));
  if (!out.car.stated[static_cast<std::size_t>(P::fuel_tank_height_m)]) out.set(P::fuel_tank_height_m, out.now(P::chassis_cog_height_m));
  out.remarks.push_back(fmt::format("chassis.mass_kg is less by the {:.4g} kg of fuel with which the log begins: drive with --fuel-kg {:.4g}", out.fuel_kg, out.fuel_kg));
}

void add_finding(Changes& out, const Finding& f) {
  const auto value = [&](std::size_t k) { return f.parameters.at(k).value; };
  if (f.parameters.empty()) return;
  const auto set_constants = [&] {
    for (std::size_t k = 1; k < f.parameters.size(); ++k) out.parameters[f.parameters[k].name] = value(k);
  };
  if (f.kind == "parameter" && f.parameters[0].name == "brake.gain") {
    // The gain would not act on measured pressures.
    const double grown = value(0) / out.car.parameters[P::brake_gain];
    for (const P p : brake_strength(out.car)) out.set(p, grown * out.car.parameters[p]);
  } else if (f.mechanism == "parameter.wheel_radius") {
    add_wheel_radius(out, f);
  } else if (f.mechanism == "parameter.throttle_gain" && !commanded(out.logs, kThrottle)) {
    // Behind a measured throttle no gain acts: what was found is the engine's torque at part throttle.
    const auto& p = out.car.parameters;
    out.maps["engine_torque_nm"] = shaped_engine_map(out.car.files.engine_torque_nm, {0.5 * (value(0) / p[P::throttle_gain] - 1), 0, 0, 0}, p[P::engine_limit_radps]);
  } else if (f.kind == "parameter") {
    out.parameters[f.parameters[0].name] = value(0);
  } else if (f.mechanism == "vehicle.turbo_lag") {
    out.terms["turbo_lag"] = 1;
    out.set(P::turbo_share, value(0));
    set_constants();
  } else if (late_actuator(f.mechanism) != nullptr) {
    add_actuator(out, f);
  } else if (f.mechanism == "environment.wind") {
    double x = out.now(P::environment_wind_mps) * std::cos(out.now(P::environment_wind_heading_rad)), y = out.now(P::environment_wind_mps) * std::sin(out.now(P::environment_wind_heading_rad));
    if (out.terms.count("wind") == 0) x = y = 0;  // the relations know no stated wind
    for (const FoundParameter& p : f.parameters) (p.name.ends_with("+x") ? x : y) += p.value;
    out.terms["wind"] = 1;
    out.set(P::environment_wind_mps, std::hypot(x, y));
    out.set(P::environment_wind_heading_rad, std::atan2(y, x));
  } else if (f.mechanism == "vehicle.brake_friction_temperature") {
    out.terms["brake_fade"] = 1;
    out.set(P::brake_fade_1pmj, fade_1pmj(value(0)));
    set_constants();
  } else if (f.mechanism == "vehicle.brake_disc_conductance") {
    out.set(P::brake_conductance_slope_1pk, value(0) / vehicle::laws::kConductanceReference_k);
    set_constants();
  } else if (f.mechanism == "vehicle.multi_point_contact") {
    out.strip = true;
  } else if (f.mechanism == "vehicle.differential" && vehicle::find_term(f.parameters[0].name)) {
    const std::string& term = f.parameters[0].name;
    out.terms[term] = std::clamp(out.car.terms[*vehicle::find_term(term)] + value(0), 0.0, 1.0);
  } else if (f.mechanism == "vehicle.differential") {
    add_differential(out, f);
  } else if (f.mechanism == "vehicle.aero_drag") {
    add_aero_term(out, f, {P::aero_drag_area_m2});
  } else if (f.mechanism == "vehicle.aero_downforce") {
    add_aero_term(out, f, {P::front_lift_area_m2, P::rear_lift_area_m2});
  } else if (f.mechanism == "vehicle.aero_ride_height") {
    add_ride_height(out, f);
  } else if (f.mechanism == "vehicle.tyre_thermal") {
    out.terms["tyre_warm_up"] = 1;
    out.set(P::tyre_warm_up_loss, value(0));
    set_constants();
  } else if (f.mechanism.starts_with("vehicle.tyre_")) {
    add_tyre_term(out, f);
  } else if (f.mechanism == "vehicle.fuel_burn") {
    add_fuel_burn(out, f);
  } else if (f.kind == "vehicle" || f.kind == "environment") {
    out.remarks.push_back(fmt::format("{}: {} = {:.5g} {}; a vehicle file has nothing that holds it", f.mechanism, f.parameters[0].name, value(0), f.parameters[0].unit));
  }
}

/// Keeps what a map at the key says about prior and source.
void write_value(YAML::Node root, const std::string& name, double value) {
  if (root["parameters"] && root["parameters"][name] && root["parameters"][name].IsMap()) root["parameters"][name]["value"] = value;
  else root["parameters"][name] = value;
}

}  // namespace

std::string map_csv(const vehicle::Map2& map, const std::string& axes) {
  std::string out = axes;
  for (const double y : map.y) out += fmt::format(",{:.9g}", y);
  for (std::size_t i = 0; i < map.x.size(); ++i) {
    out += fmt::format("\n{:.9g}", map.x[i]);
    for (std::size_t j = 0; j < map.y.size(); ++j) out += fmt::format(",{:.9g}", map.z[i * map.y.size() + j]);
  }
  return out + "\n";
}

std::optional<CorrectedCar> corrected_vehicle(const std::string& vehicle_path, const vehicle::Vehicle& car, const Findings& findings, const std::vector<Signals>& logs,
                                              const RefittedCar* refit) {
  if (findings.doubtful_car) return std::nullopt;
  Changes changes{car, logs, {}, {}, {}, {}, false, 0.0, {}};
  // What needs mass and downforce as corrected comes last.
  const auto last = [](const Finding& f) { return f.mechanism == "vehicle.aero_ride_height" || f.mechanism == "vehicle.fuel_burn"; };
  for (const bool second : {false, true})
    for (const Finding& f : findings.findings)
      if (last(f) == second) add_finding(changes, f);
  if (changes.none()) return std::nullopt;

  CorrectedCar out;
  out.fuel_kg = changes.fuel_kg;
  YAML::Node root = YAML::LoadFile(vehicle_path);
  if (changes.strip) root["contact"] = "strip";
  const std::filesystem::path folder = std::filesystem::absolute(vehicle_path).parent_path();
  for (const char* section : {"tyres", "maps"})
    if (root[section])
      for (auto entry : root[section])
        if (const auto key = entry.first.as<std::string>(); key != "alpha" && key != "fx_arm")
          entry.second = (folder / entry.second.as<std::string>()).lexically_normal().string();
  for (std::size_t k = 0; k < 2; ++k) {
    if (changes.tyre[k].empty()) continue;
    const char *axle = k == 0 ? "front" : "rear", *file = k == 0 ? "front.tir" : "rear.tir";
    out.files.emplace_back(file, vehicle::with_tyre_values(base::read_file(root["tyres"][axle].as<std::string>(), vehicle::kLargestTyreBytes), changes.tyre[k]));
    root["tyres"][axle] = file;
  }
  for (const auto& [name, map] : changes.maps) {
    const bool engine = name == "engine_torque_nm";
    const std::string file = engine ? "engine.csv" : name.substr(0, name.find("_factor")) + ".csv";
    if (!engine || refit == nullptr) out.files.emplace_back(file, map_csv(map, engine ? "engine_radps:throttle" : "ride_front_m:ride_rear_m"));
    root["maps"][name] = file;
  }
  if (refit != nullptr) {
    out.files.emplace_back("engine.csv", map_csv(refit->engine_torque_nm, "engine_radps:throttle"));
    root["maps"]["engine_torque_nm"] = "engine.csv";
    for (const P p : refit->changed)
      if (refit->parameters[p] != car.parameters[p]) changes.set(p, refit->parameters[p]);
    changes.remarks.push_back("engine map, drag, brakes, tyre stiffness, grip and gear shift are refitted together with what was found.");
  }
  // A setup sheet is read after the parameters and would undo them: its values move into the file.
  if (root["setup"]) {
    for (std::size_t k = 0; k < vehicle::kParameterCount; ++k)
      if (car.stated[k]) write_value(root, std::string(vehicle::parameter_list()[k].name), car.parameters.value[k]);
    for (std::size_t k = 0; k < vehicle::kTermCount; ++k)
      if (car.terms.value[k] != vehicle::default_amplitudes().value[k]) root["terms"][std::string(vehicle::term_list()[k].name)] = car.terms.value[k];
    root.remove("setup");
  }
  for (const auto& [name, value] : changes.parameters) {
    const auto p = vehicle::find_parameter(name);
    if (!p) throw vehicle::Error(name + ": found, but no parameter of a vehicle file");
    const vehicle::ParameterInfo& info = vehicle::parameter_list()[static_cast<std::size_t>(*p)];
    const double kept = std::clamp(value, info.low, info.high);
    if (kept != value) changes.remarks.push_back(fmt::format("{}: found {:.5g} {}; a vehicle file holds {:g} to {:g}", name, value, info.unit, info.low, info.high));
    write_value(root, name, kept);
  }
  for (const auto& [name, value] : changes.terms) root["terms"][name] = value;
  YAML::Emitter yaml;
  yaml.SetDoublePrecision(9);
  yaml << root;
  out.vehicle_yaml = "# Corrected by crgexplain; see findings.json.\n";
  for (const std::string& remark : changes.remarks) out.vehicle_yaml += "# " + remark + "\n";
  out.vehicle_yaml += yaml.c_str() + std::string("\n");
  return out;
}

}  // namespace explain
