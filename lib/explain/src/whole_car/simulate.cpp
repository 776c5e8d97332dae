#include "explain/simulate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "driven_side.h"
#include "whole_car_errors.h"

namespace explain {
namespace {

using P = vehicle::Parameter;

bool remembers_heat(const vehicle::Vehicle& car) {
  return car.terms[vehicle::Term::brake_friction_temperature] > 0 ||
         car.terms[vehicle::Term::tyre_thermal] > 0;
}

/// The samples of one lap.
DrivenTrace::Side lap_of(const DrivenSide& side, const Judge& judge, int lap, std::size_t channel) {
  DrivenTrace::Side out;
  for (std::size_t k = 0; k < side.driven.size(); ++k) {
    const Driven& d = side.driven[k];
    const Signals& s = *(*judge.logs)[k].signals;
    for (std::size_t i = 0; i < d.t_s.size(); ++i) {
      const auto place = static_cast<std::size_t>(std::max(0.0, d.t_s[i]) / Signals::kStep_s);
      if (place >= s.n || judge.lap_at(k, d.t_s[i]) != lap) continue;
      out.u_m.push_back(s.u_m[place]);
      out.recorded.push_back(d.recorded[channel][i]);
      out.simulated.push_back(d.simulated[channel][i]);
    }
  }
  return out;
}

std::vector<double> whole_laps_s(const std::vector<RecordedLog>& logs) {
  std::vector<double> laps_s;
  for (const RecordedLog& log : logs) {
    const Signals& s = *log.signals;
    for (std::size_t lap = 0, begin = 0; lap < s.whole.size(); ++lap) {
      std::size_t end = begin;
      while (end < s.n && s.lap[end] == static_cast<int>(lap)) ++end;
      if (s.whole[lap]) laps_s.push_back(static_cast<double>(end - begin) * Signals::kStep_s);
      begin = end;
    }
  }
  return laps_s;
}

using Sides = std::array<const DrivenSide*, 2>;  ///< before and after

void remark_sides(const Sides& sides, SimulationCheck& out) {
  for (std::size_t k = 0; k < 2; ++k) {
    if (!sides[k]->car || sides[k]->car->changed.empty()) continue;
    std::string values;
    for (const P p : sides[k]->car->changed)
      values += fmt::format("{} {} {:.4g}", values.empty() ? "" : ",",
                            vehicle::parameter_list()[static_cast<std::size_t>(p)].name,
                            sides[k]->car->parameters[p]);
    out.remarks.push_back(
        {fmt::format("whole simulation, {}, refitted to the laps that do not judge:{}; and the "
                     "shape of the engine map",
                     k == 0 ? "before" : "after", values),
         Remark::About::kRefit});
  }
  for (std::size_t k = 0; k < 2; ++k)
    if (!sides[k]->problem.empty())
      out.remarks.push_back(
          fmt::format("whole simulation, {}: {}", k == 0 ? "before" : "after", sides[k]->problem));
}

void put_traces(const Sides& sides, const Judge& judge, SimulationCheck& out) {
  for (std::size_t c = 0; c < kCompared.size(); ++c) {
    const int lap = *judge.judged.begin();
    out.driven.push_back({kCompared[c].channel, kCompared[c].unit, lap,
                          lap_of(*sides[0], judge, lap, c), lap_of(*sides[1], judge, lap, c)});
    const auto& recorded = out.driven.back().before.recorded;
    if (std::none_of(recorded.begin(), recorded.end(), [](double v) { return std::isfinite(v); }))
      out.driven.pop_back();
  }
}

/// Squared errors of compared quantity `c` at the ends of stretches that judge, of horizon `h`.
std::vector<SquaredErrors> squares_of(const Sides& sides, const Judge& judge, std::size_t h,
                                      std::size_t c) {
  std::vector<SquaredErrors> squares;
  for (std::size_t k = 0; k < judge.logs->size(); ++k) {
    const auto &a = sides[0]->ends[h][k], &b = sides[1]->ends[h][k];
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
      if (std::isfinite(a[i].error[c]) && std::isfinite(b[i].error[c]) &&
          judge.is_judged(k, a[i].t_s))
        squares.push_back({a[i].square[c], b[i].square[c], a[i].hold[c], a[i].trend[c]});
  }
  return squares;
}

HeldOut held_out_of(const std::vector<SquaredErrors>& squares, std::size_t h, std::size_t c) {
  HeldOut held;
  held.channel = c < kCompared.size() ? kCompared[c].channel : "lateral_m";
  held.unit = c < kCompared.size() ? kCompared[c].unit : "m";
  held.horizon_s = kHorizons[h];
  held.whole_car = true;
  set_errors(squares, 97 + 10 * h + c, held);
  return held;
}

/// Whether both are the same car and road on the same columns, but for accelerations, which no
/// window takes anything from.
bool drives_alike(const SimulationInputs& a, const SimulationInputs& b) {
  const auto driven = [](const Mapping& mapping) {
    std::vector<recording::ColumnMapping> out = mapping.columns;
    std::erase_if(out, [](const auto& c) {
      return c.channel == "ax_mps2" || c.channel == "ay_mps2" || c.channel == "az_mps2";
    });
    return out;
  };
  const auto values = [](const recording::ColumnMapping& c) {
    return std::tie(c.column, c.channel, c.scale, c.offset, c.delay_s, c.low_pass_s, c.held);
  };
  const auto place = [](const Mapping& m) {
    return std::tie(m.has_origin, m.origin_latitude_deg, m.origin_longitude_deg, m.place_turn_rad,
                    m.place_x_m, m.place_y_m);
  };
  const auto of_a = driven(a.mapping), of_b = driven(b.mapping);
  return a.car == b.car && a.surface == b.surface && place(a.mapping) == place(b.mapping) &&
         std::equal(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(),
                    [&](const auto& x, const auto& y) { return values(x) == values(y); });
}

}  // namespace

SimulationCheck check_simulation(const std::vector<RecordedLog>& logs,
                                 const SimulationInputs& before, const SimulationInputs& after,
                                 const CheckOptions& options, KnownSide& before_side) {
  SimulationCheck out;
  out.lap_before_s = out.lap_after_s = kNaN;
  Judge judge{&logs, options.hold_out};
  int laps = 0;
  for (const RecordedLog& log : logs)
    laps += log.signals->lap.empty() ? 1 : log.signals->lap.back() + 1;
  if (options.hold_out.empty())
    for (int lap = 1; lap < laps; lap += 2) judge.judged.insert(lap);
  if (judge.judged.empty()) {
    out.remarks.emplace_back(
        "the whole simulated car was not compared: one lap cannot both fit and judge it; what was "
        "found is written untried");
    return out;
  }
  out.recorded_lap_s = whole_laps_s(logs);
  const bool in_parts = !remembers_heat(*before.car) && !remembers_heat(*after.car);
  const auto side = [&](bool is_after, const RefittedCar* alike) {
    return std::make_shared<const DrivenSide>(drive_side(
        is_after ? after : before, logs, judge, in_parts, alike,
        [&](const std::function<RefittedCar()>& make) {
          return options.refit ? options.refit(is_after, make) : make();
        },
        options.tick));
  };
  if (before_side == nullptr || before_side->in_parts != in_parts)
    before_side = side(false, nullptr);
  const KnownSide now = drives_alike(before, after)
                            ? before_side
                            : side(true, before_side->car ? &*before_side->car : nullptr);
  const Sides sides{before_side.get(), now.get()};
  out.before = sides[0]->car;
  out.after = sides[1]->car;
  out.lap_before_s = sides[0]->lap_s;
  out.lap_after_s = sides[1]->lap_s;
  remark_sides(sides, out);
  put_traces(sides, judge, out);
  for (std::size_t h = 0; h < kHorizons.size(); ++h) {
    if (sides[0]->ends[h].size() != logs.size() || sides[1]->ends[h].size() != logs.size())
      continue;
    for (std::size_t c = 0; c < 4; ++c)
      if (const auto squares = squares_of(sides, judge, h, c); squares.size() >= 8)
        out.held_out.push_back(held_out_of(squares, h, c));
  }
  if (out.held_out.empty())
    out.remarks.emplace_back(
        "the whole simulated car was not compared: the laps that judge have fewer than 8 windows "
        "that both sides drive; what was found is written untried");
  return out;
}

}  // namespace explain
