#include "driven_side.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.h"
#include "mechanism.h"
#include "refit_car.h"
#include "vehicle/lap.h"
#include "vehicle/replay.h"
#include "vehicle/trend.h"

namespace explain {
namespace {

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

/// What the simulated car does in windows of this length.
recording::Table driven_table(const vehicle::Vehicle& car, const vehicle::CarFiles& files,
                              const vehicle::Parameters<double>& parameters,
                              const crg::Surface& surface, const recording::Recording& recording,
                              double window_s, const std::function<void()>& tick) {
  const auto made = vehicle::make_car(files, parameters, car.terms, car.contact);
  vehicle::ReplayOptions options;
  options.window_s = window_s;
  // The relations take the stated mass for the whole car too where no fuel is logged.
  options.fuel_kg = 0.0;
  options.progress = [&](const std::string&, double) {
    if (tick) tick();
  };
  return vehicle::replay(made, vehicle::Road(surface), recording, options).telemetry;
}

/// Simulated minus recorded up to `horizon_s` after each window's begin.
std::vector<WindowEnd> ends_of(const recording::Table& sim, const recording::Recording& recording,
                               double horizon_s, Driven* driven = nullptr) {
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

double seconds_of(const std::vector<recording::Recording>& recordings) {
  double out = 0.0;
  for (const recording::Recording& r : recordings) {
    const std::vector<double>& time = *r.table.find("time_s");
    for (const recording::Stretch& s : r.stretches) out += time[s.end - 1] - time[s.begin];
  }
  return out;
}

/// Leaves pieces that are equally spread: a dozen amounts need no more than this.
void thin_out(std::vector<recording::Recording>& recordings) {
  constexpr double kEnough_s = 120.0, kPiece_s = 10.0;
  const double share = kEnough_s / seconds_of(recordings);
  if (!(share < 1.0)) return;
  double wanted = 0.0;  // pieces, of those that were met
  for (recording::Recording& r : recordings) {
    const std::vector<double>& time = *r.table.find("time_s");
    const std::vector<recording::Stretch> all = std::exchange(r.stretches, {});
    for (const recording::Stretch& stretch : all)
      for (std::size_t begin = stretch.begin, end = begin; begin < stretch.end; begin = end) {
        while (end < stretch.end && time[end] < time[begin] + kPiece_s) ++end;
        wanted += share;
        if (wanted < 1.0) continue;
        wanted -= 1.0;
        r.stretches.push_back({begin, end});
      }
  }
}

/// Along the laps that judge. The two shorter horizons share their windows.
void drive_tests(const SimulationInputs& in, const vehicle::CarFiles& files,
                 const vehicle::Parameters<double>& p,
                 const std::vector<recording::Recording>& test, const std::function<void()>& tick,
                 DrivenSide& out) {
  const std::size_t logs = test.size(), last = kHorizons.size() - 1;
  out.driven.resize(logs);
  for (auto& ends : out.ends) ends.resize(logs);
  base::parallel_for(2 * logs, 1, 2, [&](std::size_t n, std::size_t) {
    const std::size_t k = n / 2;
    if (test[k].stretches.empty()) return;
    const bool longest = n % 2 == 0;
    const recording::Table sim = driven_table(*in.car, files, p, *in.surface, test[k],
                                              longest ? kHorizons[last] : 2.0, tick);
    if (longest)
      out.ends[last][k] = ends_of(sim, test[k], kHorizons[last], &out.driven[k]);
    else
      for (std::size_t h = 0; h < last; ++h) out.ends[h][k] = ends_of(sim, test[k], kHorizons[h]);
  });
}

}  // namespace

DrivenSide drive_side(const SimulationInputs& in, const std::vector<RecordedLog>& logs,
                      const Judge& judge, bool in_parts, const RefittedCar* alike,
                      const std::function<RefittedCar(const std::function<RefittedCar()>&)>& refit,
                      const std::function<void()>& tick) {
  DrivenSide out;
  out.in_parts = in_parts;
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
    if (in_parts) thin_out(train);
    const auto errors = [&](const vehicle::CarFiles& files, const vehicle::Parameters<double>& p) {
      std::vector<double> r;
      for (std::size_t k = 0; k < train.size(); ++k) {
        if (train[k].stretches.empty()) continue;
        for (const WindowEnd& w : ends_of(
                 driven_table(*in.car, files, p, *in.surface, train[k], 2.0, tick), train[k], 2.0))
          if (!judge.is_judged(k, w.t_s))
            r.insert(r.end(), w.error.begin(), w.error.begin() + kCompared.size());
      }
      return r;
    };
    std::vector<double> worth;
    worth.reserve(kCompared.size());
    for (const Compared& c : kCompared) worth.push_back(c.worth);
    out.car = refit([&] { return refitted(*in.car, errors, worth, alike); });
    vehicle::CarFiles files = in.car->files;
    files.engine_torque_nm = out.car->engine_torque_nm;
    const vehicle::Parameters<double>& p = out.car->parameters;
    drive_tests(in, files, p, test, tick, out);
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

}  // namespace explain
