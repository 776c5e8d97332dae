#include "vehicle/vehicle_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "base/read_file.h"
#include "base/settings.h"
#include "base/text_lines.h"
#include "map_file.h"
#include "vehicle/error.h"
#include "vehicle/suspension_points.h"

namespace vehicle {
namespace {

constexpr std::size_t kLargestVehicleBytes = 1u << 20;
constexpr std::string_view kPrior = " prior ";

/// The parameter whose name is nearest to a mistyped one, for the error message.
std::string_view nearest_parameter(std::string_view name) {
  std::size_t best = 0;
  std::string_view found;
  for (const ParameterInfo& info : parameter_list()) {
    std::size_t same = 0;
    while (same < info.name.size() && same < name.size() && info.name[same] == name[same]) ++same;
    if (same > best) {
      best = same;
      found = info.name;
    }
  }
  return found;
}

void set_parameter(Vehicle& vehicle, std::string_view name, double value,
                   const std::string& where) {
  const auto parameter = find_parameter(name);
  if (!parameter) {
    const std::string_view near = nearest_parameter(name);
    throw Error(fmt::format("{}: there is no parameter '{}'{}", where, name.substr(0, 60),
                            near.empty() ? "" : fmt::format("; the nearest is '{}'", near)));
  }
  const auto index = static_cast<std::size_t>(*parameter);
  const ParameterInfo& info = parameter_list()[index];
  if (!(value >= info.low && value <= info.high))
    throw Error(fmt::format("{}: {} = {} {}, wanted {} to {}", where, name, value, info.unit,
                            info.low, info.high));
  vehicle.parameters.value[index] = value;
  vehicle.stated[index] = true;
}

/// Of a parameter that there is.
void set_prior(Vehicle& vehicle, std::string_view name, double prior, const std::string& where) {
  if (!(prior > 0.0))
    throw Error(fmt::format("{}: prior of {} = {}, wanted above 0", where, name, prior));
  vehicle.prior[static_cast<std::size_t>(*find_parameter(name))] = prior;
}

void set_term(Vehicle& vehicle, std::string_view name, double value, const std::string& where) {
  const auto term = find_term(name);
  if (!term) throw Error(fmt::format("{}: there is no term '{}'", where, name.substr(0, 60)));
  if (!(value >= 0.0 && value <= 1.0))
    throw Error(fmt::format("{}: amplitude of {} = {}, wanted 0 to 1", where, name, value));
  vehicle.terms[*term] = value;
}

void read_parameters(Vehicle& vehicle, const base::Section& section, const std::string& path) {
  section.for_each([&](const std::string& key, const base::Setting& value,
                       const std::string& where) {
    if (value.kind == base::Setting::Kind::kWord) {
      set_parameter(vehicle, key, base::to_number(value.word, where, key), where);
      return;
    }
    const base::Section entry(value, path, key);
    entry.allow({"value", "prior", "assumed", "source"});
    set_parameter(vehicle, key, base::to_number(entry.text("value"), where, key), where);
    const auto index = static_cast<std::size_t>(*find_parameter(key));
    if (entry.has("prior"))
      set_prior(vehicle, key, base::to_number(entry.text("prior"), where, key + ".prior"), where);
    vehicle.assumed[index] = entry.flag("assumed", vehicle.assumed[index]);
  });
}

/// The hardpoints of one axle, solved.
WheelPath read_wheel_path(const base::Section& axle, const std::string& path, const char* name) {
  axle.allow({"travel_m", "wheel_m", "link_1", "link_2", "link_3", "link_4", "link_5"});
  SuspensionPoints points;
  const auto numbers = [&](const std::string& key, std::size_t count) {
    std::vector<double> out = axle.numbers(key, count);
    if (out.empty()) throw Error(fmt::format("{}: suspension of {} lacks '{}'", path, name, key));
    for (const double value : out)
      if (!(std::abs(value) <= 10.0))
        throw Error(fmt::format("{}: suspension of {}: {} holds {}, wanted -10 to 10 m", path, name,
                                key, value));
    return out;
  };
  points.range_m = axle.number("travel_m", points.range_m, 0.001, 0.5);
  const std::vector<double> wheel = numbers("wheel_m", 3);
  points.wheel_m = {wheel[0], wheel[1], wheel[2]};
  for (std::size_t k = 0; k < points.link.size(); ++k) {
    const std::vector<double> ends = numbers(fmt::format("link_{}", k + 1), 6);
    points.link[k] = {{ends[0], ends[1], ends[2]}, {ends[3], ends[4], ends[5]}};
  }
  try {
    return make_wheel_path(points);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}: {}", path, name, error.what()));
  }
}

/// The value of a key that takes one of a few words; throws Error naming them.
template <typename Value>
void read_word(const base::Section& section, const char* key, const std::string& path,
               const char* wanted, std::initializer_list<std::pair<const char*, Value>> words,
               Value& out) {
  if (!section.has(key)) return;
  const std::string word = section.text(key);
  for (const auto& [name, value] : words)
    if (word == name) return void(out = value);
  throw Error(fmt::format("{}: {} = '{}', wanted {}", path, key, word.substr(0, 60), wanted));
}

/// A file that the vehicle's file names, beside it; listed among those read.
std::string file_beside(const std::string& path, const std::string& name, Vehicle& vehicle) {
  const std::string full = (std::filesystem::path(path).parent_path() / name).string();
  std::error_code too_long;  // a name of thousands of letters is none
  if (!std::filesystem::exists(full, too_long))
    throw Error(fmt::format("{}: '{}' is named here, but {} does not exist", path,
                            name.substr(0, 60), full.substr(0, 300)));
  vehicle.read_files.push_back(full);
  return full;
}

void read_tyres(const base::Section& tyres, const std::string& path, Vehicle& vehicle) {
  tyres.allow({"front", "rear", "alpha", "fx_arm"});
  for (const std::size_t a : {0u, 1u})
    vehicle.files.tyre[a] =
        read_tyre(file_beside(path, tyres.text(a == 0 ? "front" : "rear"), vehicle)).coefficients;
  read_word<AlphaConvention>(
      tyres, "alpha", path, "tan or angle",
      {{"tan", AlphaConvention::kTangent}, {"angle", AlphaConvention::kAngle}},
      vehicle.files.alpha);
  vehicle.files.fx_arm = FxArm::kUnstated;
  read_word<FxArm>(
      tyres, "fx_arm", path, "loaded_radius or rolling_radius",
      {{"loaded_radius", FxArm::kLoadedRadius}, {"rolling_radius", FxArm::kRollingRadius}},
      vehicle.files.fx_arm);
}

void read_maps(const base::Section& maps, const std::string& path, Vehicle& vehicle) {
  maps.allow({"engine_torque_nm", "front_damper_n", "rear_damper_n", "drag_factor",
              "front_lift_factor", "rear_lift_factor", "yaw_drag_factor", "yaw_lift_factor",
              "wake_drag_factor", "wake_lift_factor", "pad_friction", "compressor_kgps",
              "compressor_efficiency", "compressor_surge_kgps", "turbine_flow",
              "turbine_efficiency", "steering", "tyre_grip"});
  CarFiles& f = vehicle.files;
  const auto map1 = [&](Map1& map, const char* key, const char* x, const char* value) {
    if (maps.has(key)) map = read_map1(file_beside(path, maps.text(key), vehicle), x, value);
  };
  const auto map2 = [&](Map2& map, const char* key, const char* x, const char* y,
                        const char* value) {
    if (maps.has(key)) map = read_map2(file_beside(path, maps.text(key), vehicle), x, y, value);
  };
  (void)maps.text("engine_torque_nm");  // the one map no car is without
  map2(f.engine_torque_nm, "engine_torque_nm", "engine_radps", "throttle", "torque_nm");
  map1(f.damper_n[0], "front_damper_n", "rate_mps", "force_n");
  map1(f.damper_n[1], "rear_damper_n", "rate_mps", "force_n");
  map2(f.drag_factor, "drag_factor", "ride_front_m", "ride_rear_m", "factor");
  map2(f.front_lift_factor, "front_lift_factor", "ride_front_m", "ride_rear_m", "factor");
  map2(f.rear_lift_factor, "rear_lift_factor", "ride_front_m", "ride_rear_m", "factor");
  map1(f.yaw_drag_factor, "yaw_drag_factor", "yaw_rad", "factor");
  map1(f.yaw_lift_factor, "yaw_lift_factor", "yaw_rad", "factor");
  map2(f.wake_drag_factor, "wake_drag_factor", "wake_x_m", "wake_y_m", "factor");
  map2(f.wake_lift_factor, "wake_lift_factor", "wake_x_m", "wake_y_m", "factor");
  map2(f.pad_friction, "pad_friction", "pressure_pa", "surface_k", "friction");
  map2(f.compressor_kgps, "compressor_kgps", "shaft_radps", "pressure_ratio", "flow_kgps");
  map2(f.compressor_efficiency, "compressor_efficiency", "shaft_radps", "pressure_ratio",
       "efficiency");
  map1(f.compressor_surge_kgps, "compressor_surge_kgps", "pressure_ratio", "flow_kgps");
  constexpr const char* kReduced = "speed_radps_per_root_k";
  map2(f.turbine_flow, "turbine_flow", kReduced, "expansion_ratio", "flow_kgps_root_k_per_mpa");
  map2(f.turbine_efficiency, "turbine_efficiency", kReduced, "expansion_ratio", "efficiency");
  map1(f.steering, "steering", "steer_command_rad", "steer_rad");
  map1(f.tyre_grip, "tyre_grip", "tread_k", "factor");
}

}  // namespace

void apply_setting(Vehicle& vehicle, std::string_view setting, const std::string& where) {
  const std::size_t equals = setting.find('=');
  if (equals == std::string_view::npos)
    throw Error(fmt::format("{}: '{}' is not name=value", where, setting.substr(0, 60)));
  const std::string_view name = base::trimmed(setting.substr(0, equals));
  const std::string_view text = base::trimmed(setting.substr(equals + 1));
  const std::size_t word = text.find(kPrior);
  const double value = base::to_number(base::trimmed(text.substr(0, word)), where, name);
  const bool term = name.find('.') == std::string_view::npos;
  if (term && word != std::string_view::npos)
    throw Error(fmt::format("{}: {} is the amplitude of a term, which has no prior", where,
                            name.substr(0, 60)));
  if (term) {
    set_term(vehicle, name, value, where);
    return;
  }
  set_parameter(vehicle, name, value, where);
  if (word == std::string_view::npos) return;
  const std::string_view prior = base::trimmed(text.substr(word + kPrior.size()));
  set_prior(vehicle, name, base::to_number(prior, where, "prior"), where);
}

void read_setup(Vehicle& vehicle, const std::string& path) {
  const std::string text = base::read_file(path, kLargestVehicleBytes);
  std::set<std::string, std::less<>> seen;
  std::size_t number = 0;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t end = rest.find('\n');
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    ++number;
    line = base::trimmed(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    const std::string where = fmt::format("{}:{}", path, number);
    const std::string name(base::trimmed(line.substr(0, line.find('='))));
    if (!seen.insert(name).second)
      throw Error(fmt::format("{}: '{}' twice", where, name.substr(0, 60)));
    apply_setting(vehicle, line, where);
  }
}

Vehicle read_vehicle(const std::string& path) {
  Vehicle vehicle;
  for (std::size_t i = 0; i < kParameterCount; ++i) vehicle.prior[i] = parameter_list()[i].prior;
  vehicle.read_files.push_back(path);
  const base::Setting root = base::read_settings(path);
  const base::Section top(root, path, "a vehicle file");
  top.allow(
      {"name", "tyres", "maps", "suspension", "setup", "contact", "turbo", "parameters", "terms"});
  vehicle.name = top.text("name");
  read_tyres(top.section("tyres"), path, vehicle);
  read_maps(top.section("maps"), path, vehicle);
  read_word<Turbo>(top, "turbo", path, "first_order or full",
                   {{"first_order", Turbo::kFirstOrder}, {"full", Turbo::kFull}},
                   vehicle.files.turbo);
  if (top.has("suspension")) {
    const base::Section both = top.section("suspension");
    both.allow({"front", "rear"});
    for (const std::size_t a : {0u, 1u}) {
      const char* const axle = a == 0 ? "front" : "rear";
      if (both.has(axle))
        vehicle.files.wheel_path[a] = read_wheel_path(both.section(axle), path, axle);
    }
  }
  read_word<Contact>(top, "contact", path, "single_point, four_point or strip",
                     {{"single_point", Contact::kSinglePoint},
                      {"four_point", Contact::kFourPoint},
                      {"strip", Contact::kStrip}},
                     vehicle.contact);
  if (top.has("parameters")) read_parameters(vehicle, top.section("parameters"), path);
  if (top.has("terms"))
    top.section("terms").for_each(
        [&](const std::string& key, const base::Setting& value, const std::string& where) {
          if (value.kind != base::Setting::Kind::kWord)
            throw Error(fmt::format("{}: amplitude of {} is no number", where, key.substr(0, 60)));
          set_term(vehicle, key, base::to_number(value.word, where, key), where);
        });
  if (top.has("setup")) read_setup(vehicle, file_beside(path, top.text("setup"), vehicle));
  try {
    check_car(vehicle.files, vehicle.parameters, vehicle.terms);
  } catch (const Error& error) {  // concerns the car as a whole: no single line
    throw Error(path + ": " + error.what());
  }
  return vehicle;
}

Vehicle read_vehicle(const std::string& path, const std::string& setup_path,
                     const std::vector<std::string>& settings) {
  Vehicle vehicle = read_vehicle(path);
  if (!setup_path.empty()) read_setup(vehicle, setup_path);
  for (const std::string& setting : settings) apply_setting(vehicle, setting, "--set");
  return vehicle;
}

}  // namespace vehicle
