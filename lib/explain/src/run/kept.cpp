#include "explain/kept.h"

#include <nlohmann/json.hpp>

#include "vehicle/error.h"

// One line per struct of findings.h and simulate.h: a field that is forgotten here is lost between
// two runs, which the test of a killed run would see.
namespace vehicle {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Map2, x, y, z)
}  // namespace vehicle

namespace explain {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Place, u_begin_m, u_end_m, laps)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Mismatch, channel, regime, unit, where, size, p_adjusted,
                                   share_of_residual)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ParameterValue, id, name, unit, stated, value, low, high,
                                   beyond_prior, at_limit, unsure)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FoundParameter, name, unit, value, low, high)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ProfilePoint, u_m, value, ci90)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Rival, mechanism, channel, separating_experiment, cv_gain,
                                   separable)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(HeldOut, channel, unit, horizon_s, rmse_before, rmse_after,
                                   drop_low, drop_high, trivial_rmse, whole_car, trend_rmse,
                                   sure_low, sure_high)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(HeightPatch, u_step_m, v_step_m, right_m, columns, dz_m)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Finding, mechanism, kind, channel, physics, equation, where,
                                   parameters, profile, patch, rivals, stability, cv_gain,
                                   statistic, threshold, held_out, unknown, not_used)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Untestable, mechanism, reason)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Unexplained, channel, locked_to, unit, where, share, p_adjusted,
                                   size)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Evidence, mechanism, channel, detail, amount, statistic, cv_gain,
                                   unit, place, least)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Trace, channel, unit, u_m, before, after, lap)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(DrivenTrace::Side, u_m, recorded, simulated)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(DrivenTrace, channel, unit, lap, before, after)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Remark, text, about)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Findings, verdict, mismatches, parameters, findings, untestable,
                                   unexplained, evidence, traces, driven, held_out, remarks,
                                   null_false_alarm, null_replicates, threshold, laps, rounds,
                                   doubtful_car, broken_columns, recorded_lap_s,
                                   simulated_lap_before_s, simulated_lap_after_s)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SimulationCheck, held_out, driven, lap_before_s, lap_after_s,
                                   recorded_lap_s, remarks)  // cars: below

static void to_json(nlohmann::json& json, const RefittedCar& car) {
  std::vector<std::size_t> changed;
  for (const vehicle::Parameter p : car.changed) changed.push_back(static_cast<std::size_t>(p));
  json = {{"parameters", car.parameters.value},
          {"engine", car.engine_torque_nm},
          {"changed", changed},
          {"slopes", car.slopes}};
}

static void from_json(const nlohmann::json& json, RefittedCar& out) {
  json.at("parameters").get_to(out.parameters.value);
  json.at("engine").get_to(out.engine_torque_nm);
  json.at("slopes").get_to(out.slopes);
  for (const std::size_t p : json.at("changed").get<std::vector<std::size_t>>()) {
    if (p >= vehicle::kParameterCount) throw vehicle::Error("not a car that was kept");
    out.changed.push_back(static_cast<vehicle::Parameter>(p));
  }
}

namespace {

std::string bytes_of(const nlohmann::json& value) {
  std::string out;
  nlohmann::json::to_cbor(value, out);
  return out;
}

template <class T>
T read(const std::string& bytes) {
  try {
    return nlohmann::json::from_cbor(bytes).get<T>();
  } catch (const nlohmann::json::exception& error) {
    throw vehicle::Error(std::string("not a stage that was kept: ") + error.what());
  }
}

}  // namespace

std::string to_bytes(const Findings& findings) { return bytes_of(findings); }
Findings findings_from_bytes(const std::string& bytes) { return read<Findings>(bytes); }

std::string to_bytes(const RefittedCar& car) { return bytes_of(car); }
RefittedCar car_from_bytes(const std::string& bytes) { return read<RefittedCar>(bytes); }

std::string to_bytes(const SimulationCheck& check) {
  nlohmann::json json = check;
  if (check.before) json["before"] = *check.before;
  if (check.after) json["after"] = *check.after;
  return bytes_of(json);
}

SimulationCheck check_from_bytes(const std::string& bytes) {
  const auto json = read<nlohmann::json>(bytes);
  auto out = read<SimulationCheck>(bytes);
  if (json.contains("before")) out.before = json["before"].get<RefittedCar>();
  if (json.contains("after")) out.after = json["after"].get<RefittedCar>();
  return out;
}

}  // namespace explain
