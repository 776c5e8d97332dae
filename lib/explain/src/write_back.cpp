#include "explain/write_back.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "crg/edit.h"
#include "refit_car.h"
#include "vehicle/error.h"

namespace explain {
namespace {

/// A profile at every row: a quadratic B-spline over its cells, to nothing outside. Kinks of banking would
/// be bumps under the wheels beside the middle of the road.
std::vector<double> profile_along(const Finding& f, std::size_t rows, double u_step_m) {
  std::vector<double> out(rows, 0.0);
  const double cell = f.profile[1].u_m - f.profile[0].u_m;
  const auto value = [&](std::ptrdiff_t j) { return j < 0 || j >= static_cast<std::ptrdiff_t>(f.profile.size()) ? 0.0 : f.profile[static_cast<std::size_t>(j)].value; };
  for (std::size_t i = 0; i < rows; ++i) {
    const double place = (static_cast<double>(i) * u_step_m - f.profile.front().u_m) / cell;
    const auto j = static_cast<std::ptrdiff_t>(std::floor(place + 0.5));
    const double t = place - static_cast<double>(j);
    out[i] = 0.5 * (0.5 - t) * (0.5 - t) * value(j - 1) + (0.75 - t * t) * value(j) + 0.5 * (0.5 + t) * (0.5 + t) * value(j + 1);
  }
  return out;
}

/// Between the middles of the bins linearly.
void add_patch(const HeightPatch& patch, crg::Grid& grid) {
  const auto rows = static_cast<std::ptrdiff_t>(patch.dz_m.size() / patch.columns), columns = static_cast<std::ptrdiff_t>(patch.columns);
  const auto value = [&](std::ptrdiff_t i, std::ptrdiff_t j) {
    return i < 0 || j < 0 || i >= rows || j >= columns ? 0.0 : patch.dz_m[static_cast<std::size_t>(i * columns + j)];
  };
  for (std::size_t r = 0; r < grid.rows(); ++r)
    for (std::size_t c = 0; c < grid.columns(); ++c) {
      const double u = static_cast<double>(r) * grid.u_step_m / patch.u_step_m - 0.5, v = (grid.v_m[c] - patch.right_m) / patch.v_step_m - 0.5;
      const auto i = static_cast<std::ptrdiff_t>(std::floor(u)), j = static_cast<std::ptrdiff_t>(std::floor(v));
      const double fu = u - static_cast<double>(i), fv = v - static_cast<double>(j);
      grid.at(r, c) += static_cast<float>((1 - fu) * ((1 - fv) * value(i, j) + fv * value(i, j + 1)) + fu * ((1 - fv) * value(i + 1, j) + fv * value(i + 1, j + 1)));
    }
}

}  // namespace

std::optional<crg::Crg> friction_map(const crg::Crg& road, const crg::Crg* known, const Findings& findings) {
  std::optional<crg::Crg> out;
  for (const Finding& f : findings.findings) {
    if (f.mechanism != "road.friction" || f.profile.size() < 2) continue;
    if (!out) {
      out = crg::crop(road, {});
      out->z_double_m.clear();
      std::fill(out->grid.z_m.begin(), out->grid.z_m.end(), 1.0f);
      if (known != nullptr)
        for (std::size_t i = 0; i < std::min(out->grid.z_m.size(), known->grid.z_m.size()); ++i)
          if (std::isfinite(known->grid.z_m[i])) out->grid.z_m[i] = known->grid.z_m[i];
      out->comment.push_back("factors on the grip, found by crgexplain from recordings");
    }
    const std::size_t rows = out->grid.rows();
    const std::vector<double> along = profile_along(f, rows, out->grid.u_step_m);
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t j = 0; j < out->grid.columns(); ++j) out->grid.at(i, j) *= static_cast<float>(std::clamp(1 + along[i], 0.1, 2.0));
  }
  return out;
}

std::optional<crg::Crg> corrected_road(const crg::Crg& road, const Findings& findings) {
  const auto height = [](const Finding& f) { return !f.patch.dz_m.empty() || f.mechanism == "road.banking" || f.mechanism == "road.grade" || f.mechanism == "road.vertical_curvature"; };
  if (std::none_of(findings.findings.begin(), findings.findings.end(), height)) return std::nullopt;
  crg::Crg out = crg::crop(road, {});  // works the modifiers in
  out.z_double_m.clear();
  const std::size_t rows = out.grid.rows(), columns = out.grid.columns();
  for (const Finding& f : findings.findings) {
    if (!f.patch.dz_m.empty()) add_patch(f.patch, out.grid);
    if (!height(f) || !f.patch.dz_m.empty() || f.profile.size() < 2) continue;
    const std::vector<double> along = profile_along(f, rows, out.grid.u_step_m);
    std::vector<double> rise(rows, 0.0);
    const bool curvature = f.mechanism == "road.vertical_curvature";
    if (f.mechanism != "road.banking") {
      // Grade is the derivative of the height, curvature the second; what does not come back to
      // zero at the end is spread over the lap.
      const auto integrate = [&](std::vector<double>& v) {
        double sum = 0;
        for (double& x : v) sum += x * out.grid.u_step_m, x = sum;
        const double left = v.back();
        for (std::size_t i = 0; i < rows; ++i) v[i] -= left * static_cast<double>(i) / static_cast<double>(rows - 1);
      };
      rise = along;
      integrate(rise);
      if (curvature) {
        double mean = 0;
        for (const double x : rise) mean += x / static_cast<double>(rows);
        for (double& x : rise) x -= mean;
        integrate(rise);
      }
    }
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t j = 0; j < columns; ++j)
        out.grid.at(i, j) += static_cast<float>(f.mechanism == "road.banking" ? along[i] * out.grid.v_m[j] : rise[i]);
  }
  out.comment.push_back("heights corrected by crgexplain from recordings");
  return out;
}

namespace {

/// The number that an equation names last after these words.
double after(const std::string& equation, const std::string& words) {
  const std::size_t at = equation.rfind(words);
  if (at == std::string::npos) throw vehicle::Error(equation + ": says no " + words);
  return std::atof(equation.c_str() + at + words.size());
}

}  // namespace

std::string engine_map_csv(const vehicle::Map2& map) {
  std::string out = "engine_radps:throttle";
  for (const double y : map.y) out += fmt::format(",{:.9g}", y);
  for (std::size_t i = 0; i < map.x.size(); ++i) {
    out += fmt::format("\n{:.9g}", map.x[i]);
    for (std::size_t j = 0; j < map.y.size(); ++j) out += fmt::format(",{:.9g}", map.z[i * map.y.size() + j]);
  }
  return out + "\n";
}

std::string corrected_vehicle(const std::string& vehicle_path, const vehicle::Vehicle& car, const Findings& findings, const RefittedCar* refit) {
  if (findings.doubtful_car) return "";
  // What each finding means in the words of a vehicle file.
  std::map<std::string, double> parameters, terms;
  bool strip = false;
  std::vector<std::string> remarks;
  for (const Finding& f : findings.findings) {
    const auto value = [&](std::size_t k) { return f.parameters.at(k).value; };
    const auto set = [&](const char* name, double x) { parameters[name] = x; };
    if (f.parameters.empty()) continue;
    if (f.kind == "parameter" && f.parameters[0].name == "brake.gain") {
      // The gain would not act on measured pressures.
      const double grown = value(0) / car.parameters[vehicle::Parameter::brake_gain];
      for (const vehicle::Parameter p : brake_strength(car)) parameters[std::string(vehicle::parameter_list()[static_cast<std::size_t>(p)].name)] = grown * car.parameters[p];
    } else if (f.kind == "parameter") {
      if (vehicle::find_parameter(f.parameters[0].name)) set(f.parameters[0].name.c_str(), value(0));
      else remarks.push_back(fmt::format("{}: {} = {:.5g}; change the tyre's radius by this share", f.mechanism, f.parameters[0].name, value(0)));
    } else if (f.mechanism == "vehicle.turbo_lag") {
      terms["turbo_lag"] = 1;
      set("turbo.share", std::clamp(value(0), 0.0, 0.95));
      set("turbo.rise_s", after(f.equation, "rise "));
    } else if (f.mechanism == "vehicle.throttle_dead_time" || f.mechanism == "vehicle.brake_dead_time" || f.mechanism == "vehicle.steering_dead_time") {
      const std::string name = f.mechanism.substr(8, f.mechanism.find("_dead") - 8);
      const bool had = car.terms[*vehicle::find_term(name + "_actuator")] > 0;
      terms[name + "_actuator"] = 1;
      const auto p = *vehicle::find_parameter(name + ".dead_time_s");
      parameters[name + ".dead_time_s"] = std::clamp((had ? car.parameters[p] : 0.0) + value(0), 0.0, 0.2);
      if (!had) parameters[name + ".lag_s"] = 0;
    } else if (f.mechanism == "vehicle.steering_lag") {
      terms["steering_actuator"] = 1;
      set("steering.lag_s", std::max(0.0, value(0) / 2));
    } else if (f.mechanism == "environment.wind") {
      double x = 0, y = 0;
      for (const FoundParameter& p : f.parameters) (p.name.ends_with("+x") ? x : y) = p.value;
      terms["wind"] = 1;
      set("environment.wind_mps", std::hypot(x, y));
      set("environment.wind_heading_rad", std::atan2(y, x));
    } else if (f.mechanism == "vehicle.brake_friction_temperature") {
      terms["brake_fade"] = 1;
      set("brake.fade_1pmj", value(0) / 0.75);
      set("brake.fade_s", after(f.equation, "; T "));
    } else if (f.mechanism == "vehicle.brake_disc_conductance") {
      set("brake.conductance_slope_1pk", value(0) / 500.0);
      for (std::size_t k = 1; k < f.parameters.size(); ++k) set(f.parameters[k].name.c_str(), value(k));
    } else if (f.mechanism == "vehicle.multi_point_contact") {
      strip = true;
    } else if (f.mechanism == "vehicle.differential") {
      terms["locked_differential"] = 1;
      terms["limited_slip"] = 0;
    } else if (f.kind == "vehicle" || f.kind == "environment") {
      remarks.push_back(fmt::format("{}: {} = {:.5g} {}; the vehicle file has no single parameter for it: set the term and its map by hand", f.mechanism,
                                    f.parameters[0].name, value(0), f.parameters[0].unit));
      if (f.mechanism == "vehicle.tyre_thermal") terms["tyre_thermal"] = 1;
      if (f.mechanism == "vehicle.fuel_burn") terms["fuel_burn"] = 1;
      if (f.mechanism.starts_with("vehicle.tyre_") && f.mechanism != "vehicle.tyre_thermal") terms[f.mechanism.substr(8)] = 1;
    }
  }
  if (parameters.empty() && terms.empty() && remarks.empty() && !strip) return "";
  YAML::Node root = YAML::LoadFile(vehicle_path);
  if (strip) root["contact"] = "strip";
  const std::filesystem::path folder = std::filesystem::absolute(vehicle_path).parent_path();
  for (const char* section : {"tyres", "maps"})
    if (root[section])
      for (auto entry : root[section])
        if (entry.first.as<std::string>() != "alpha") entry.second = (folder / entry.second.as<std::string>()).lexically_normal().string();
  if (refit != nullptr) {
    root["maps"]["engine_torque_nm"] = "engine.csv";
    for (const vehicle::Parameter p : refit->changed)
      if (refit->parameters[p] != car.parameters[p]) parameters[std::string(vehicle::parameter_list()[static_cast<std::size_t>(p)].name)] = refit->parameters[p];
    remarks.push_back("engine map, drag, brakes, tyre stiffness, grip and gear shift are refitted together with what was found.");
  }
  // A setup sheet is read after the parameters and would undo them: its values move into the file.
  if (root["setup"]) {
    for (std::size_t k = 0; k < vehicle::kParameterCount; ++k)
      if (car.stated[k]) {
        const std::string name(vehicle::parameter_list()[k].name);
        if (!root["parameters"] || !root["parameters"][name]) root["parameters"][name] = car.parameters.value[k];
        else if (root["parameters"][name].IsMap()) root["parameters"][name]["value"] = car.parameters.value[k];
        else root["parameters"][name] = car.parameters.value[k];
      }
    root.remove("setup");
  }
  for (const auto& [name, value] : parameters) {
    const vehicle::ParameterInfo& info = vehicle::parameter_list()[static_cast<std::size_t>(*vehicle::find_parameter(name))];
    const double kept = std::clamp(value, info.low, info.high);
    if (root["parameters"] && root["parameters"][name] && root["parameters"][name].IsMap()) root["parameters"][name]["value"] = kept;
    else root["parameters"][name] = kept;
  }
  for (const auto& [name, value] : terms) root["terms"][name] = value;
  YAML::Emitter yaml;
  yaml.SetDoublePrecision(9);
  yaml << root;
  std::string out = "# Corrected by crgexplain; see findings.json.\n";
  for (const std::string& remark : remarks) out += "# " + remark + "\n";
  return out + yaml.c_str() + "\n";
}

std::optional<Mapping> corrected_mapping(const Mapping& mapping, const Findings& findings) {
  Mapping out = mapping;
  bool changed = false;
  for (const Finding& f : findings.findings) {
    if (f.kind != "sensor" || f.parameters.empty()) continue;
    const double value = f.parameters[0].value;
    if (f.mechanism == "sensor.misalignment") out.imu_yaw_rad += value, changed = true;
    if (f.mechanism == "sensor.lever_arm") out.imu_ahead_m += value, changed = true;
    for (ColumnMapping& m : out.columns) {
      // A finding about the mean of two columns names both.
      if (("," + f.channel + ",").find("," + m.column + ",") == std::string::npos) continue;
      if (f.mechanism == "sensor.bias") m.offset -= value;
      else if (f.mechanism == "sensor.gain") m.scale /= 1 + value, m.offset /= 1 + value;
      else if (f.mechanism == "sensor.delay") m.delay_s += value;
      else if (f.mechanism == "sensor.low_pass") m.low_pass_s = std::max(0.0, m.low_pass_s + value);
      else continue;
      changed = true;
    }
  }
  if (!changed) return std::nullopt;
  return out;
}

}  // namespace explain
