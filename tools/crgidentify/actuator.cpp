// An actuator from its recorded command and movement: a setup sheet, words, JSON, curves.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/error.h"
#include "base/interval90.h"
#include "base/json_text.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "commands.h"
#include "identify/actuator_fit.h"
#include "recording/recording.h"
#include "report/plot_page.h"

namespace crgidentify {
namespace {

using identify::ActuatorFit, base::kNormal90, identify::Uncertain;
using nlohmann::ordered_json;

/// One channel each, of the longest stretch without a gap in time.
struct Channels {
  std::vector<double> time_s, command, movement;
};

Channels read_channels(const ActuatorCommand& command, const std::string& in,
                       const std::string& out) {
  recording::Mapping mapping;
  if (!command.mapping_path.empty()) mapping = recording::read_mapping(command.mapping_path);
  const recording::Recording recording = recording::read_recording(command.recording_path, mapping);
  if (recording.table.find(command.out_path) != nullptr)
    throw command::UsageError("-o " + command.out_path +
                              " is a channel: a file is wanted; --measure names the channel");
  const std::vector<double>& time_s = *recording.table.find("time_s");
  const auto longest = *std::max_element(
      recording.stretches.begin(), recording.stretches.end(),
      [](const auto& a, const auto& b) { return a.end - a.begin < b.end - b.begin; });
  const auto cut = [&](const std::vector<double>& values) {
    return std::vector<double>(values.begin() + static_cast<std::ptrdiff_t>(longest.begin),
                               values.begin() + static_cast<std::ptrdiff_t>(longest.end));
  };
  const auto channel = [&](const std::string& name) {
    const std::vector<double>* const values = recording.table.find(name);
    if (values == nullptr)
      throw base::Error(
          fmt::format("{}: no channel {}; name its column in a mapping, or another "
                      "channel by --command or --measure",
                      command.recording_path, name));
    return cut(recording::fill_gaps(time_s, *values));
  };
  return {cut(time_s), channel(in), channel(out)};
}

identify::ActuatorFitOptions options_of(const ActuatorCommand& command) {
  identify::ActuatorFitOptions options;
  options.threads = command.threads;
  if (command.order != "auto") {
    identify::ActuatorOrder order;
    order.poles = command.order[0] - '0';
    order.zero = command.order.find("zero") != std::string::npos;
    order.play = command.order.find("play") != std::string::npos;
    options.order = order;
  }
  if (command.hold != "auto")
    options.hold = command.hold == "line" ? identify::Hold::kLine : identify::Hold::kStep;
  return options;
}

/// "2 poles, a zero and play".
std::string order_words(const identify::ActuatorOrder& order) {
  return fmt::format("{} {}{}{}", order.poles, order.poles == 1 ? "pole" : "poles",
                     order.zero ? (order.play ? ", a zero" : " and a zero") : "",
                     order.play ? " and play" : "");
}

/// The numbers of a fit; those that its order does not have are 0 in JSON and left out in words.
struct FitLine {
  const char *name, *key, *unit;
  double factor;  ///< from SI
  Uncertain value;
  bool there;
};

std::vector<FitLine> fit_lines(const ActuatorFit& f) {
  const auto& o = f.order;
  return {{"gain", "gain", "", 1.0, f.gain, true},
          {"offset", "offset", "", 1.0, f.offset, true},
          {"dead time", "dead_time_s", "ms", 1e3, f.dead_time_s, true},
          {"lag", "lag_s", "ms", 1e3, f.lag_s, o.poles >= 2},
          {"damping", "damping", "", 1.0, f.damping, o.poles >= 2},
          {o.poles == 3 ? "third lag" : "lag", "lag2_s", "ms", 1e3, f.lag2_s, o.poles % 2 == 1},
          {"lead", "lead_s", "ms", 1e3, f.lead_s, o.zero},
          {"play, end to end", "play", "", 1.0, f.play, o.play}};
}

/// The lines of a setup sheet for `part` (steering, throttle or brake). At most 2 poles: the car's
/// actuators have no more. One pole becomes two of which the other is 1,600 times as fast, or as
/// fast as a lag of 1 ms allows.
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
  for (const FitLine& line : fit_lines(fit))
    if (line.there)
      out += fmt::format("  {:17} {:10.5g} +- {:.2g} (90 %) {}\n", line.name,
                         line.factor * line.value.value, line.factor * kNormal90 * line.value.sd,
                         line.unit);
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

ordered_json actuator_json(const ActuatorFit& fit) {
  ordered_json out{{"rows", fit.rows},
                   {"step_s", fit.step_s},
                   {"hold", fit.hold == identify::Hold::kLine ? "line" : "step"},
                   {"poles", fit.order.poles},
                   {"zero", fit.order.zero},
                   {"with_play", fit.order.play}};
  for (const FitLine& line : fit_lines(fit))
    out[line.key] = {{"value", line.value.value}, {"sd", line.value.sd}};
  const identify::Arx arx = identify::arx_of(fit);
  out["arx"] = {{"a", arx.a}, {"b", arx.b}, {"nk", arx.dead_steps}};
  out["rms"] = fit.rms;
  out["rms_gain_alone"] = fit.rms_plain;
  out["poles_radps"] = out["tried"] = ordered_json::array();
  for (const auto& pole : fit.poles_radps) out["poles_radps"].push_back({pole.real(), pole.imag()});
  for (const auto& t : fit.tried)
    out["tried"].push_back({{"poles", t.order.poles},
                            {"zero", t.order.zero},
                            {"with_play", t.order.play},
                            {"rms_left_out", t.rms},
                            {"standard_errors_better", t.clearly},
                            {"taken", t.taken}});
  return out;
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

/// Part of the record, response to a step, amplitude and phase.
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

}  // namespace

int actuator(const ActuatorCommand& command, Terminal& terminal) {
  const bool steering = command.part == "steering", throttle = command.part == "throttle";
  const std::string in = !command.input.empty() ? command.input
                         : steering             ? "steer_command_rad"
                         : throttle             ? "throttle_command"
                                                : "brake_fl_command_pa";
  const std::string out = !command.movement.empty() ? command.movement
                          : steering                ? "steer_rad"
                          : throttle                ? "throttle"
                                                    : "brake_fl_pa";
  terminal.start("reading");
  const Channels channels = read_channels(command, in, out);
  terminal.start("fitting");
  identify::ActuatorFit fit, for_car;
  try {
    identify::ActuatorFitOptions options = options_of(command);
    fit = for_car =
        identify::fit_actuator(channels.time_s, channels.command, channels.movement, options);
    if (fit.order.poles == 3) {  // the car's actuators have two
      options.order = identify::ActuatorOrder{2, true, fit.order.play};
      for_car =
          identify::fit_actuator(channels.time_s, channels.command, channels.movement, options);
    }
  } catch (const base::Error& error) {
    throw base::Error(
        fmt::format("{}: {} to {}: {}", command.recording_path, in, out, error.what()));
  }
  std::string sheet =
      fmt::format("# {} to {}, {} rows of {} (sha256 {})\n", in, out, fit.rows,
                  command.recording_path, base::sha256_of_file(command.recording_path));
  if (fit.order.poles == 3)
    sheet += fmt::format(
        "# 3 poles leave {:.4g} rms, 2 and a zero, as below, {:.4g}; the car's actuators have 2\n",
        fit.rms, for_car.rms);
  sheet += actuator_sheet(for_car, command.part);
  if (for_car.dead_time_s.value > 0.2)
    terminal.remark(fmt::format("the dead time is {:.3f} s; a car takes no more than 0.2 s",
                                for_car.dead_time_s.value));
  if (!command.out_path.empty()) base::write_file(command.out_path, sheet);
  if (!command.plots_path.empty())
    base::write_file(command.plots_path,
                     actuator_page(fit, in + " to " + out, channels.command, channels.movement));
  if (terminal.json) {
    auto json = actuator_json(fit);
    json["command"] = in;
    json["movement"] = out;
    terminal.print(base::json_text(json));
  } else {
    terminal.print(sheet + actuator_text(fit));
  }
  return kOk;
}

}  // namespace crgidentify
