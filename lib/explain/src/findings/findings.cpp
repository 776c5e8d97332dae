#include "explain/findings.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "selection.h"

namespace explain {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0.0) return 0.0;
  const double scale = std::pow(10.0, 6.0 - std::floor(std::log10(std::abs(value))));
  const double rounded = std::round(value * scale) / scale;
  return std::isfinite(rounded) ? rounded : value;
}

Json places(const std::vector<Place>& where, bool laps) {
  if (where.empty()) return nullptr;
  Json list = Json::array();
  for (const Place& p : where) {
    Json item{{"u_begin_m", number(p.u_begin_m)}, {"u_end_m", number(p.u_end_m)}};
    if (laps) item["laps"] = p.laps;
    list.push_back(item);
  }
  return list;
}

Json mismatches(const Findings& f) {
  Json list = Json::array();
  for (const Mismatch& m : f.mismatches)
    list.push_back({{"channel", m.channel},
                    {"where", places(m.where, true)},
                    {"regime", m.regime},
                    {"size", number(m.size)},
                    {"unit", m.unit},
                    {"p_adjusted", number(m.p_adjusted)},
                    {"share_of_residual", number(m.share_of_residual)}});
  return list;
}

Json parameters(const Findings& f) {
  Json list = Json::array();
  for (const ParameterValue& p : f.parameters)
    list.push_back({{"id", p.id},
                    {"name", p.name},
                    {"stated", number(p.stated)},
                    {"value", number(p.value)},
                    {"unit", p.unit},
                    {"ci90", {number(p.low), number(p.high)}},
                    {"beyond_prior", p.beyond_prior},
                    {"at_limit", p.at_limit},
                    {"unsure", p.unsure}});
  return list;
}

Json held_out(const Finding& x) {
  Json list = Json::array();
  for (const HeldOut& h : x.held_out)
    list.push_back({{"channel", h.channel},
                    {"unit", h.unit},
                    {"by", h.whole_car ? "whole car" : "relation"},
                    {"horizon_s", number(h.horizon_s)},
                    {"rmse_before", number(h.rmse_before)},
                    {"rmse_after", number(h.rmse_after)},
                    {"drop_ci90", {number(h.drop_low), number(h.drop_high)}},
                    {"drop_sure", {number(h.sure_low), number(h.sure_high)}},
                    {"trivial_rmse", number(h.trivial_rmse)},
                    {"trend_rmse", number(h.trend_rmse)}});
  return list;
}

Json finding(const Finding& x) {
  Json item;
  item["mechanism"] = x.mechanism;
  item["kind"] = x.kind;
  item["channel"] = x.channel.empty() ? Json(nullptr) : Json(x.channel);
  item["physics"] = x.physics;
  item["equation"] = x.equation;
  item["where"] = places(x.where, false);
  item["parameters"] = Json::array();
  for (const FoundParameter& p : x.parameters)
    item["parameters"].push_back({{"name", p.name},
                                  {"value", number(p.value)},
                                  {"unit", p.unit},
                                  {"ci90", {number(p.low), number(p.high)}}});
  item["profile"] = nullptr;
  if (!x.profile.empty()) {
    item["profile"] = Json::array();
    for (const ProfilePoint& p : x.profile)
      item["profile"].push_back(
          {{"u_m", number(p.u_m)}, {"value", number(p.value)}, {"ci90", number(p.ci90)}});
  }
  item["rivals"] = Json::array();
  for (const Rival& r : x.rivals)
    item["rivals"].push_back({{"mechanism", r.mechanism},
                              {"channel", r.channel.empty() ? Json(nullptr) : Json(r.channel)},
                              {"cv_gain", number(r.cv_gain)},
                              {"separable", r.separable},
                              {"separating_experiment", r.separating_experiment}});
  item["cv_gain"] = number(x.cv_gain);
  item["statistic"] = number(x.statistic);
  item["threshold"] = number(x.threshold);
  item["stability"] = number(x.stability);
  item["held_out"] = held_out(x);
  item["not_used"] = x.not_used.empty() ? Json(nullptr) : Json(x.not_used);
  return item;
}

Json unexplained(const Findings& f) {
  Json list = Json::array();
  for (const Unexplained& u : f.unexplained)
    list.push_back({{"channel", u.channel},
                    {"locked_to", u.locked_to},
                    {"where", places(u.where, false)},
                    {"size", number(u.size)},
                    {"unit", u.unit},
                    {"share", number(u.share)},
                    {"p_adjusted", number(u.p_adjusted)}});
  return list;
}

Json tested(const Findings& f) {
  Json list = Json::array();
  for (const Evidence& e : f.evidence)
    list.push_back({{"mechanism", e.mechanism},
                    {"channel", e.channel.empty() ? Json(nullptr) : Json(e.channel)},
                    {"detail", e.detail + e.place},
                    {"amount", number(e.amount)},
                    {"unit", e.unit},
                    {"statistic", number(e.statistic)},
                    {"cv_gain", number(e.cv_gain)}});
  return list;
}

Json seen(const Findings& f) {
  Json list = Json::array();
  for (const Seen& s : seen_and_not_named(f))
    list.push_back({{"mechanism", s.mechanism},
                    {"channel", s.channel.empty() ? Json(nullptr) : Json(s.channel)},
                    {"detail", s.detail},
                    {"amount", number(s.amount)},
                    {"unit", s.unit},
                    {"ci90", {number(s.low), number(s.high)}},
                    {"statistic", number(s.statistic)},
                    {"why", s.why}});
  return list;
}

Json lap_times(const Findings& f) {
  Json lap_s{
      {"recorded", Json::array()}, {"simulated_before", nullptr}, {"simulated_after", nullptr}};
  for (const double lap : f.recorded_lap_s) lap_s["recorded"].push_back(number(lap));
  if (f.simulated_lap_before_s > 0) lap_s["simulated_before"] = number(f.simulated_lap_before_s);
  if (f.simulated_lap_after_s > 0) lap_s["simulated_after"] = number(f.simulated_lap_after_s);
  return lap_s;
}

}  // namespace

const char* name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kNone:
      return "none";
    case Verdict::kExplained:
      return "explained";
    case Verdict::kTie:
      return "tie";
    case Verdict::kNotJudged:
      return "not judged";
    case Verdict::kUnknown:
      break;
  }
  return "unknown";
}

std::string findings_json(const Findings& f) {
  Json root;
  root["version"] = 1;
  root["verdict"] = name_of(f.verdict);
  root["mismatches"] = mismatches(f);
  root["parameters"] = parameters(f);
  root["findings"] = Json::array();
  for (const Finding& x : f.findings) root["findings"].push_back(finding(x));
  root["untestable"] = Json::array();
  for (const Untestable& u : f.untestable)
    root["untestable"].push_back({{"mechanism", u.mechanism}, {"reason", u.reason}});
  root["unexplained"] = unexplained(f);
  root["seen"] = seen(f);
  root["tested"] = tested(f);
  root["null_calibration"] = {{"replicates", f.null_replicates},
                              {"threshold", number(f.threshold)},
                              {"false_alarm_rate", number(f.null_false_alarm)}};
  root["other_cars"] = {{"recordings", selection::kOtherCars},
                        {"alarms", selection::kOtherCarsAlarmed}};
  root["laps"] = f.laps;
  root["lap_s"] = lap_times(f);
  root["remarks"] = Json::array();
  for (const Remark& remark : f.remarks) root["remarks"].push_back(remark.text);
  return base::json_text(root, 1);
}

}  // namespace explain
