#include "actuator_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "identify/clustered_fit.h"
#include "report/plot_page.h"

namespace crgidentify {
namespace {

using identify::ActuatorFit, identify::kNormal90, identify::Uncertain;

struct FitLine {
  const char* name;
  const char* unit;
  double factor;  ///< from SI
  Uncertain ActuatorFit::*value;
  bool there;
};

std::vector<FitLine> fit_lines(const ActuatorFit& fit) {
  const auto& o = fit.order;
  return {{"gain", "", 1.0, &ActuatorFit::gain, true},
          {"offset", "", 1.0, &ActuatorFit::offset, true},
          {"dead time", "ms", 1e3, &ActuatorFit::dead_time_s, true},
          {"lag", "ms", 1e3, &ActuatorFit::lag_s, o.poles >= 2},
          {"damping", "", 1.0, &ActuatorFit::damping, o.poles >= 2},
          {o.poles == 3 ? "third lag" : "lag", "ms", 1e3, &ActuatorFit::lag2_s, o.poles % 2 == 1},
          {"lead", "ms", 1e3, &ActuatorFit::lead_s, o.zero},
          {"play, end to end", "", 1.0, &ActuatorFit::play, o.play}};
}

/// The transfer function without play and offset.
std::complex<double> response(const ActuatorFit& fit, double radps) {
  const std::complex<double> s(0.0, radps);
  std::complex<double> out = fit.gain.value * std::exp(-s * fit.dead_time_s.value);
  for (const auto& pole : fit.poles_radps) out *= -pole / (s - pole);
  return out * (1.0 + fit.lead_s.value * s);
}

report::PlotPage with_curves(report::PlotPage page, const ActuatorFit& fit) {
  ActuatorFit fine = fit;
  fine.step_s = 0.001;
  fine.hold = identify::Hold::kStep;
  std::vector<double> step(1000, 1.0);
  step[0] = 0.0;
  report::PlotLine up{"movement", {}, {}};
  up.y = identify::simulate_actuator(fine, step);
  for (std::size_t k = 0; k < step.size(); ++k) up.x.push_back(0.001 * static_cast<double>(k));
  page.plots.push_back({"Response to a step of 1", "s", "movement", {up}});
  report::PlotLine amplitude{"amplitude", {}, {}}, phase{"phase", {}, {}};
  double before = 0.0, turns = 0.0;
  for (int i = 0; i <= 300; ++i) {
    const double hz =
        0.1 * std::pow(10.0, 2.0 * i / 300.0);  // to 10 Hz, and no further than the log
    if (hz > 0.5 / fit.step_s) break;
    const auto g = response(fit, 2.0 * std::numbers::pi * hz);
    const double angle = std::arg(g) * 180.0 / std::numbers::pi;
    if (i > 0 && angle - before > 180.0) turns -= 360.0;
    if (i > 0 && angle - before < -180.0) turns += 360.0;
    before = angle;
    amplitude.x.push_back(hz);
    amplitude.y.push_back(20.0 * std::log10(std::abs(g)));
    phase.x.push_back(hz);
    phase.y.push_back(angle + turns);
  }
  page.plots.push_back({"Amplitude", "Hz", "dB", {amplitude}});
  page.plots.push_back({"Phase", "Hz", "degrees", {phase}});
  return page;
}

}  // namespace

std::string order_words(const identify::ActuatorOrder& order) {
  return fmt::format("{} {}{}{}", order.poles, order.poles == 1 ? "pole" : "poles",
                     order.zero ? (order.play ? ", a zero" : " and a zero") : "",
                     order.play ? " and play" : "");
}

std::string actuator_sheet(const ActuatorFit& fit, const std::string& part) {
  double dead_s = fit.dead_time_s.value, lag_s = fit.lag_s.value, damping = fit.damping.value;
  if (fit.order.poles == 0) {
    lag_s = 0.0;
    damping = 1.0;
  } else if (fit.order.poles == 1) {
    const double whole_s = fit.lag2_s.value;
    lag_s = std::max(0.001, whole_s / 40.0);
    damping = 0.5 * whole_s / lag_s;
    if (damping < 1.0) {  // a lag of 1 to 2 ms: the car's two are the least that it takes
      lag_s = 0.5 * whole_s;
      damping = 1.0;
    } else {
      dead_s = std::max(0.0, dead_s - lag_s * lag_s / whole_s);
    }
  }
  const bool steering = part == "steering";
  std::string out = fmt::format(
      "{}.{} = {:.6g}\n{}.dead_time_s = {:.6g}\n{}.lag_s = {:.6g}\n{}.damping = {:.6g}\n{}.lead_s "
      "= {:.6g}\n",
      part, steering ? "ratio" : "gain", steering ? 1.0 / fit.gain.value : fit.gain.value, part,
      dead_s, part, lag_s, part, damping, part, fit.lead_s.value);
  if (fit.order.play && part != "throttle")
    out += fmt::format("{}.friction_{} = {:.6g}\n", part, steering ? "rad" : "pa",
                       0.5 * fit.play.value);
  return out;
}

std::string actuator_text(const ActuatorFit& fit) {
  std::string out =
      fmt::format("{} rows every {:.4g} ms; the command taken as {} between them\n", fit.rows,
                  1e3 * fit.step_s, fit.hold == identify::Hold::kLine ? "straight" : "held");
  for (const auto& t : fit.tried)
    out += fmt::format(
        "{:28} leaves {:.4g} on blocks left out{}{}\n", order_words(t.order), t.rms,
        &t == &fit.tried.front() ? "" : fmt::format(", {:+.1f} standard errors better", t.clearly),
        t.taken ? ", taken" : "");
  out += fmt::format("{}\n", order_words(fit.order));
  for (const FitLine& line : fit_lines(fit)) {
    if (!line.there) continue;
    const Uncertain& v = fit.*(line.value);
    out += fmt::format("  {:17} {:10.5g} +- {:.2g} (90 %) {}\n", line.name, line.factor * v.value,
                       line.factor * kNormal90 * v.sd, line.unit);
  }
  for (const auto& pole : fit.poles_radps)
    out += fmt::format("  pole              {:.4g}{:+.4g}i rad/s\n", pole.real(), pole.imag());
  const identify::Arx arx = identify::arx_of(fit);
  out += fmt::format("ARX({}, {}, {}): y[k] =", arx.a.size(), arx.b.size(), arx.dead_steps);
  for (std::size_t i = 0; i < arx.a.size(); ++i)
    out += fmt::format(" {:+.6g} y[k-{}]", -arx.a[i], i + 1);
  for (std::size_t i = 0; i < arx.b.size(); ++i)
    out += fmt::format(" {:+.6g} u[k-{}]", arx.b[i], arx.dead_steps + static_cast<int>(i));
  return out + fmt::format("\nroot mean square left: {:.4g}; with gain and offset alone: {:.4g}\n",
                           fit.rms, fit.rms_plain);
}

nlohmann::ordered_json actuator_json(const ActuatorFit& fit) {
  using Json = nlohmann::ordered_json;
  const auto both = [](const Uncertain& v) { return Json{{"value", v.value}, {"sd", v.sd}}; };
  const identify::Arx arx = identify::arx_of(fit);
  Json out{{"rows", fit.rows},
           {"step_s", fit.step_s},
           {"hold", fit.hold == identify::Hold::kLine ? "line" : "step"},
           {"poles", fit.order.poles},
           {"zero", fit.order.zero},
           {"with_play", fit.order.play},
           {"gain", both(fit.gain)},
           {"offset", both(fit.offset)},
           {"dead_time_s", both(fit.dead_time_s)},
           {"lag_s", both(fit.lag_s)},
           {"damping", both(fit.damping)},
           {"lag2_s", both(fit.lag2_s)},
           {"lead_s", both(fit.lead_s)},
           {"play", both(fit.play)},
           {"arx", {{"a", arx.a}, {"b", arx.b}, {"nk", arx.dead_steps}}},
           {"rms", fit.rms},
           {"rms_gain_alone", fit.rms_plain}};
  out["poles_radps"] = Json::array();
  for (const auto& pole : fit.poles_radps) out["poles_radps"].push_back({pole.real(), pole.imag()});
  out["tried"] = Json::array();
  for (const auto& t : fit.tried)
    out["tried"].push_back({{"poles", t.order.poles},
                            {"zero", t.order.zero},
                            {"with_play", t.order.play},
                            {"rms_left_out", t.rms},
                            {"standard_errors_better", t.clearly},
                            {"taken", t.taken}});
  return out;
}

std::string actuator_page(const ActuatorFit& fit, const std::string& title,
                          const std::vector<double>& command, const std::vector<double>& movement) {
  report::PlotPage page;
  page.title = title;
  page.sentences = {order_words(fit.order) + "; the first 30 seconds of the record."};
  const auto model = identify::simulate_actuator(fit, command);
  report::PlotLine asked{"gain times command", {}, {}}, measured{"movement", {}, {}},
      fitted{"model", {}, {}};
  for (std::size_t k = 0;
       k < std::min(model.size(), movement.size()) && static_cast<double>(k) * fit.step_s < 30.0;
       ++k) {
    for (auto* line : {&asked, &measured, &fitted})
      line->x.push_back(static_cast<double>(k) * fit.step_s);
    asked.y.push_back(fit.gain.value * command[k] + fit.offset.value);
    measured.y.push_back(movement[k]);
    fitted.y.push_back(model[k]);
  }
  page.plots.push_back({"Record", "s", "movement", {asked, measured, fitted}});
  return report::plot_page(with_curves(page, fit));
}

}  // namespace crgidentify
