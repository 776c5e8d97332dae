#include "explain/simulate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/parallel.h"
#include "mechanism.h"
#include "not_known.h"
#include "refit_car.h"
#include "vehicle/error.h"
#include "vehicle/lap.h"
#include "vehicle/replay.h"
#include "vehicle/trend.h"
#include "whole_car_errors.h"

namespace explain {
namespace {

using P = vehicle::Parameter;

/// What is compared at the end of a window, and what an error is worth in the refit.
struct Compared {
  const char* channel;
  const char* unit;
  double worth;
};
constexpr std::array<Compared, 3> kCompared{
    {{"vx_mps", "m/s", 0.1}, {"vy_mps", "m/s", 0.1}, {"yaw_rate_radps", "rad/s", 0.01}}};

struct WindowEnd {
  double t_s = 0.0;  ///< since the log's first sample
  /// Of kCompared and of the place across the path: the error at the horizon, the mean square of
  /// all samples in the second half of the way to it, and those of "nothing changes" and of what
  /// goes on along its last 0.2 s.
  std::array<double, 4> error{kNaN, kNaN, kNaN, kNaN}, square{}, hold{}, trend{};
};

/// Every sample of the windows, one after the other; a row of NaN after each window.
struct Driven {
  std::vector<double> t_s;
  std::array<std::vector<double>, kCompared.size()> recorded, simulated;
};

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

void note(Driven& driven, double t_s, const recording::Table& log, std::size_t row,
          const recording::Table& sim, std::size_t sim_row) {
  driven.t_s.push_back(t_s);
  for (std::size_t c = 0; c < kCompared.size(); ++c) {
    const auto value = [&](const recording::Table& table, std::size_t i) {
      const auto* column = i == kNone ? nullptr : table.find(kCompared[c].channel);
      return column == nullptr ? kNaN : (*column)[i];
    };
    driven.recorded[c].push_back(value(log, row));
    driven.simulated[c].push_back(value(sim, sim_row));
  }
}

/// Simulated minus recorded up to `horizon_s` after each window's begin.
std::vector<WindowEnd> drive(const vehicle::Vehicle& car, const vehicle::CarFiles& files,
                             const vehicle::Parameters<double>& parameters,
                             const crg::Surface& surface, const recording::Recording& recording,
                             double window_s, double horizon_s, Driven* driven = nullptr) {
  const auto made = vehicle::make_car(files, parameters, car.terms, car.contact);
  vehicle::ReplayOptions options;
  options.window_s = window_s;
  // The relations take the stated mass for the whole car too where no fuel is logged.
  options.fuel_kg = 0.0;
  const vehicle::ReplayResult result =
      vehicle::replay(made, vehicle::Road(surface), recording, options);
  const recording::Table& sim = result.telemetry;
  const auto &time = *sim.find("time_s"), &window = *sim.find("window");
  const std::vector<double>& log_time = *recording.table.find("time_s");
  const auto &x = *recording.table.find("x_m"), &y = *recording.table.find("y_m"),
             &yaw = *recording.table.find("yaw_rad"), &speed = *recording.table.find("vx_mps");
  const auto &sim_x = *sim.find("x_m"), &sim_y = *sim.find("y_m");
  std::vector<WindowEnd> out;
  for (std::size_t first = 0, last = 0; last < time.size(); ++last) {
    if (last + 1 < time.size() && window[last + 1] == window[last]) continue;
    const std::size_t begin = first;
    first = last + 1;
    std::size_t i = last;
    while (i > begin && time[i] - time[begin] > horizon_s + 1e-6) --i;
    if (time[i] - time[begin] < 0.9 * horizon_s) continue;
    const auto row_of = [&](double t) {
      return std::min(
          log_time.size() - 1,
          static_cast<std::size_t>(std::lower_bound(log_time.begin(), log_time.end(), t - 1e-9) -
                                   log_time.begin()));
    };
    WindowEnd end;
    end.t_s = time[i] - log_time.front();
    const std::size_t row0 = row_of(time[begin]);
    std::array<double, 4> count{};
    for (std::size_t k = begin; k <= i; ++k) {
      const std::size_t row = row_of(time[k]);
      if (driven != nullptr)
        note(*driven, time[k] - log_time.front(), recording.table, row, sim, k);
      if (time[k] - time[begin] < 0.5 * horizon_s) continue;
      const auto take = [&](std::size_t c, double error, double hold, double trend) {
        if (!std::isfinite(error) || !std::isfinite(hold)) return;
        if (k == i) end.error[c] = error;
        end.square[c] += error * error;
        end.hold[c] += hold * hold;
        end.trend[c] += trend * trend;
        count[c] += 1;
      };
      const double ahead_s = log_time[row] - log_time[row0];
      const auto trended = [&](const std::vector<double>& channel) {
        const auto [value, slope] = vehicle::trend(log_time, channel, row0, 0);
        return value + slope * ahead_s;
      };
      for (std::size_t c = 0; c < kCompared.size(); ++c) {
        const auto *measured = recording.table.find(kCompared[c].channel),
                   *simulated = sim.find(kCompared[c].channel);
        if (measured != nullptr && simulated != nullptr)
          take(c, (*simulated)[k] - (*measured)[row], (*measured)[row0] - (*measured)[row],
               trended(*measured) - (*measured)[row]);
      }
      const double cy = std::cos(yaw[row]), sy = std::sin(yaw[row]);
      // Nothing changes: straight on at the speed of the beginning.
      const double gone = speed[row0] * (time[k] - time[begin]);
      const auto across = [&](double px, double py) {
        return -sy * (px - x[row]) + cy * (py - y[row]);
      };
      take(3, across(sim_x[k], sim_y[k]),
           across(x[row0] + gone * std::cos(yaw[row0]), y[row0] + gone * std::sin(yaw[row0])),
           across(trended(x), trended(y)));
    }
    if (driven != nullptr) note(*driven, end.t_s, recording.table, kNone, sim, kNone);
    for (std::size_t c = 0; c < 4; ++c)
      for (auto* sums : {&end.square, &end.hold, &end.trend}) (*sums)[c] /= std::max(1.0, count[c]);
    out.push_back(end);
  }
  return out;
}

struct Judge {
  const std::vector<RecordedLog>* logs;
  std::set<int> judged;  ///< laps over all logs
  int lap_at(std::size_t log, double t_s) const {
    int lap = 0;
    for (std::size_t k = 0; k < log; ++k)
      lap += (*logs)[k].signals->lap.empty() ? 1 : (*logs)[k].signals->lap.back() + 1;
    const auto& laps = (*logs)[log].signals->lap;
    if (!laps.empty())
      lap += laps[std::min(laps.size() - 1,
                           static_cast<std::size_t>(std::max(0.0, t_s) / Signals::kStep_s))];
    return lap;
  }
  bool is_judged(std::size_t log, double t_s) const { return judged.count(lap_at(log, t_s)) > 0; }
};

constexpr std::array<double, 3> kHorizons{0.6, 2.0, 8.0};

struct Side {
  std::array<std::vector<std::vector<WindowEnd>>, kHorizons.size()> ends;  ///< per horizon and log
  std::vector<Driven> driven;  ///< per log, at the longest horizon
  double lap_s = kNaN;
  std::optional<RefittedCar> car;
  std::string problem;
};

/// The rows of the laps that judge, or of the others; all of them where temperatures, which no
/// window's begin sets, have to be carried along.
recording::Recording part(const recording::Recording& whole, const Judge& judge, std::size_t log,
                          bool judged) {
  recording::Recording out = whole;
  const std::vector<double>& time = *whole.table.find("time_s");
  out.stretches.clear();
  for (const recording::Stretch& stretch : whole.stretches)
    for (std::size_t i = stretch.begin; i < stretch.end; ++i) {
      if (judge.is_judged(log, time[i] - time.front()) != judged) continue;
      if (out.stretches.empty() || out.stretches.back().end != i) out.stretches.push_back({i, i});
      out.stretches.back().end = i + 1;
    }
  return out;
}

bool remembers_heat(const vehicle::Vehicle& car) {
  return car.terms[vehicle::Term::brake_friction_temperature] > 0 ||
         car.terms[vehicle::Term::tyre_thermal] > 0;
}

Side one_side(const SimulationInputs& in, const std::vector<RecordedLog>& logs, const Judge& judge,
              bool in_parts,
              const std::function<RefittedCar(const std::function<RefittedCar()>&)>& refit) {
  Side out;
  try {
    std::vector<recording::Recording> train, test;
    double fuel_kg = 0.0;
    for (std::size_t k = 0; k < logs.size(); ++k) {
      recording::Recording whole =
          recording::make_recording(*logs[k].table, logs[k].signals->name, in.mapping);
      add_unlogged_states(whole, *in.car);
      if (const auto* const fuel = whole.table.find("fuel_kg");
          fuel != nullptr && k == 0 && std::isfinite(fuel->front()))
        fuel_kg = fuel->front();
      train.push_back(in_parts ? part(whole, judge, k, false) : whole);
      test.push_back(in_parts ? part(whole, judge, k, true) : whole);
    }
    const auto errors = [&](const vehicle::CarFiles& files, const vehicle::Parameters<double>& p) {
      std::vector<double> r;
      for (std::size_t k = 0; k < train.size(); ++k) {
        if (train[k].stretches.empty()) continue;
        for (const WindowEnd& w : drive(*in.car, files, p, *in.surface, train[k], 2.0, 2.0))
          if (!judge.is_judged(k, w.t_s))
            r.insert(r.end(), w.error.begin(), w.error.begin() + kCompared.size());
      }
      return r;
    };
    std::vector<double> worth;
    for (const Compared& c : kCompared) worth.push_back(c.worth);
    out.car = refit([&] { return refitted(*in.car, errors, worth); });
    vehicle::CarFiles files = in.car->files;
    files.engine_torque_nm = out.car->engine_torque_nm;
    const vehicle::Parameters<double>& p = out.car->parameters;
    out.driven.resize(test.size());
    for (std::size_t h = 0; h < kHorizons.size(); ++h)
      for (std::size_t k = 0; k < test.size(); ++k) {
        if (test[k].stretches.empty())
          out.ends[h].emplace_back();
        else
          out.ends[h].push_back(drive(*in.car, files, p, *in.surface, test[k],
                                      std::max(2.0, kHorizons[h]), kHorizons[h],
                                      h + 1 == kHorizons.size() ? &out.driven[k] : nullptr));
      }
    const auto made = vehicle::make_car(files, p, in.car->terms, in.car->contact);
    vehicle::LapOptions lap;
    lap.record_every = 0;
    lap.fuel_kg = fuel_kg;
    const vehicle::LapResult result = vehicle::drive_laps(made, vehicle::Road(*in.surface), lap);
    if (result.complete && !result.lap_s.empty())
      out.lap_s = result.lap_s.front();
    else
      out.problem = "the built-in driver did not finish a lap: " + result.problem;
  } catch (const std::exception& error) {
    out.problem = error.what();
  }
  return out;
}

/// The samples of one lap.
DrivenTrace::Side lap_of(const Side& side, const Judge& judge, int lap, std::size_t channel) {
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

using Sides = std::array<Side, 2>;  ///< before and after

void remark_sides(const Sides& sides, SimulationCheck& out) {
  for (std::size_t k = 0; k < 2; ++k) {
    if (!sides[k].car || sides[k].car->changed.empty()) continue;
    std::string values;
    for (const P p : sides[k].car->changed)
      values += fmt::format("{} {} {:.4g}", values.empty() ? "" : ",",
                            vehicle::parameter_list()[static_cast<std::size_t>(p)].name,
                            sides[k].car->parameters[p]);
    out.remarks.push_back(
        {fmt::format("whole simulation, {}, refitted to the laps that do not judge:{}; and the "
                     "shape of the engine map",
                     k == 0 ? "before" : "after", values),
         Remark::About::kRefit});
  }
  for (std::size_t k = 0; k < 2; ++k)
    if (!sides[k].problem.empty())
      out.remarks.push_back(
          fmt::format("whole simulation, {}: {}", k == 0 ? "before" : "after", sides[k].problem));
}

void put_traces(const Sides& sides, const Judge& judge, SimulationCheck& out) {
  for (std::size_t c = 0; c < kCompared.size(); ++c) {
    const int lap = *judge.judged.begin();
    out.driven.push_back({kCompared[c].channel, kCompared[c].unit, lap,
                          lap_of(sides[0], judge, lap, c), lap_of(sides[1], judge, lap, c)});
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
    const auto &a = sides[0].ends[h][k], &b = sides[1].ends[h][k];
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

}  // namespace

SimulationCheck check_simulation(const std::vector<RecordedLog>& logs,
                                 const SimulationInputs& before, const SimulationInputs& after,
                                 const std::set<int>& hold_out, const Refit& refit) {
  SimulationCheck out;
  out.lap_before_s = out.lap_after_s = kNaN;
  Judge judge{&logs, hold_out};
  int laps = 0;
  for (const RecordedLog& log : logs)
    laps += log.signals->lap.empty() ? 1 : log.signals->lap.back() + 1;
  if (hold_out.empty())
    for (int lap = 1; lap < laps; lap += 2) judge.judged.insert(lap);
  if (judge.judged.empty()) {
    out.remarks.emplace_back(
        "the whole simulated car was not compared: one lap cannot both fit and judge it; what was "
        "found is written untried");
    return out;
  }
  out.recorded_lap_s = whole_laps_s(logs);
  Sides sides;
  const bool in_parts = !remembers_heat(*before.car) && !remembers_heat(*after.car);
  const auto side = [&](bool is_after) {
    return one_side(is_after ? after : before, logs, judge, in_parts,
                    [&](const std::function<RefittedCar()>& make) {
                      return refit ? refit(is_after, make) : make();
                    });
  };
  base::parallel_for(2, 1, 2, [&](std::size_t k, std::size_t) { sides[k] = side(k == 1); });
  out.before = sides[0].car;
  out.after = sides[1].car;
  out.lap_before_s = sides[0].lap_s;
  out.lap_after_s = sides[1].lap_s;
  remark_sides(sides, out);
  put_traces(sides, judge, out);
  for (std::size_t h = 0; h < kHorizons.size(); ++h) {
    if (sides[0].ends[h].size() != logs.size() || sides[1].ends[h].size() != logs.size()) continue;
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
