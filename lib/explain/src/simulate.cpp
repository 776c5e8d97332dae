#include "explain/simulate.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <thread>

#include "search.h"
#include "vehicle/error.h"
#include "vehicle/lap.h"
#include "vehicle/replay.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// What is compared at the end of a window, and what an error is worth in the refit.
struct Compared {
  const char* channel;
  const char* unit;
  double worth;
};
constexpr std::array<Compared, 3> kCompared{{{"vx_mps", "m/s", 0.1}, {"vy_mps", "m/s", 0.1}, {"yaw_rate_radps", "rad/s", 0.01}}};

struct WindowEnd {
  double t_s = 0.0;  ///< since the log's first sample
  /// Of kCompared and of the place across the path: the error at the horizon, the mean square of all
  /// samples in the second half of the way to it, and that of "nothing changes".
  std::array<double, 4> error{kNaN, kNaN, kNaN, kNaN}, square{}, hold{};
};

/// Every sample of the windows, one after the other; a row of NaN after each window.
struct Driven {
  std::vector<double> t_s;
  std::array<std::vector<double>, kCompared.size()> recorded, simulated;
};

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

void note(Driven& driven, double t_s, const vehicle::Table& log, std::size_t row, const vehicle::Table& sim, std::size_t sim_row) {
  driven.t_s.push_back(t_s);
  for (std::size_t c = 0; c < kCompared.size(); ++c) {
    const auto value = [&](const vehicle::Table& table, std::size_t i) {
      const auto* column = i == kNone ? nullptr : table.find(kCompared[c].channel);
      return column == nullptr ? kNaN : (*column)[i];
    };
    driven.recorded[c].push_back(value(log, row));
    driven.simulated[c].push_back(value(sim, sim_row));
  }
}

/// Simulated minus recorded up to `horizon_s` after each window's begin.
std::vector<WindowEnd> drive(const vehicle::Vehicle& car, const vehicle::Parameters<double>& parameters, const crg::Surface& surface, const vehicle::Recording& recording,
                             double window_s, double horizon_s, Driven* driven = nullptr) {
  const auto made = vehicle::make_car(car.files, parameters, car.terms, car.contact);
  vehicle::ReplayOptions options;
  options.window_s = window_s;
  // Boost is hardly ever recorded: it needs longer to forget where it began.
  if (car.terms[vehicle::Term::turbo_lag] > 0) options.settle_s = 1.5;
  const vehicle::ReplayResult result = vehicle::replay(made, vehicle::Road(surface), recording, options);
  const vehicle::Table& sim = result.telemetry;
  const auto &time = *sim.find("time_s"), &window = *sim.find("window");
  const std::vector<double>& log_time = *recording.table.find("time_s");
  const auto &x = *recording.table.find("x_m"), &y = *recording.table.find("y_m"), &yaw = *recording.table.find("yaw_rad"), &speed = *recording.table.find("vx_mps");
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
      return std::min(log_time.size() - 1, static_cast<std::size_t>(std::lower_bound(log_time.begin(), log_time.end(), t - 1e-9) - log_time.begin()));
    };
    WindowEnd end;
    end.t_s = time[i] - log_time.front();
    const std::size_t row0 = row_of(time[begin]);
    std::array<double, 4> count{};
    for (std::size_t k = begin; k <= i; ++k) {
      const std::size_t row = row_of(time[k]);
      if (driven != nullptr) note(*driven, time[k] - log_time.front(), recording.table, row, sim, k);
      if (time[k] - time[begin] < 0.5 * horizon_s) continue;
      const auto take = [&](std::size_t c, double error, double hold) {
        if (!std::isfinite(error) || !std::isfinite(hold)) return;
        if (k == i) end.error[c] = error;
        end.square[c] += error * error;
        end.hold[c] += hold * hold;
        count[c] += 1;
      };
      for (std::size_t c = 0; c < kCompared.size(); ++c) {
        const auto *measured = recording.table.find(kCompared[c].channel), *simulated = sim.find(kCompared[c].channel);
        if (measured != nullptr && simulated != nullptr) take(c, (*simulated)[k] - (*measured)[row], (*measured)[row0] - (*measured)[row]);
      }
      const double cy = std::cos(yaw[row]), sy = std::sin(yaw[row]);
      // Nothing changes: straight on at the speed of the beginning.
      const double gone = speed[row0] * (time[k] - time[begin]);
      take(3, -sy * (sim_x[k] - x[row]) + cy * (sim_y[k] - y[row]),
           -sy * (x[row0] + gone * std::cos(yaw[row0]) - x[row]) + cy * (y[row0] + gone * std::sin(yaw[row0]) - y[row]));
    }
    if (driven != nullptr) note(*driven, end.t_s, recording.table, kNone, sim, kNone);
    for (std::size_t c = 0; c < 4; ++c) end.square[c] /= std::max(1.0, count[c]), end.hold[c] /= std::max(1.0, count[c]);
    out.push_back(end);
  }
  return out;
}

struct Judge {
  const std::vector<RecordedLog>* logs;
  std::set<int> judged;  ///< laps over all logs
  int lap_at(std::size_t log, double t_s) const {
    int lap = 0;
    for (std::size_t k = 0; k < log; ++k) lap += (*logs)[k].signals->lap.empty() ? 1 : (*logs)[k].signals->lap.back() + 1;
    const auto& laps = (*logs)[log].signals->lap;
    if (!laps.empty()) lap += laps[std::min(laps.size() - 1, static_cast<std::size_t>(std::max(0.0, t_s) / Signals::kStep_s))];
    return lap;
  }
  bool is_judged(std::size_t log, double t_s) const { return judged.count(lap_at(log, t_s)) > 0; }
};

/// Three steps of Gauss and Newton from the stated parameters, on the windows of training laps.
vehicle::Parameters<double> refitted(const SimulationInputs& in, const std::vector<vehicle::Recording>& recordings, const Judge& judge) {
  // Each changes by one factor; the brakes' of both axles together.
  const std::vector<std::vector<P>> free{{P::engine_torque}, {P::aero_drag_area_m2}, {P::front_brake_friction, P::rear_brake_friction}, {P::front_tyre_cornering_stiffness},
                                         {P::rear_tyre_cornering_stiffness}};
  const auto residual = [&](const vehicle::Parameters<double>& p) {
    std::vector<double> r;
    for (std::size_t k = 0; k < recordings.size(); ++k)
      for (const WindowEnd& w : drive(*in.car, p, *in.surface, recordings[k], 2.0, 2.0)) {
        if (judge.is_judged(k, w.t_s)) continue;
        for (std::size_t c = 0; c < kCompared.size(); ++c) r.push_back(std::isfinite(w.error[c]) ? std::clamp(w.error[c] / kCompared[c].worth, -10.0, 10.0) : 0.0);
      }
    return r;
  };
  vehicle::Parameters<double> p = in.car->parameters;
  const std::vector<double> base = residual(p);
  const auto n = static_cast<Eigen::Index>(base.size());
  if (n < 30) return p;
  Eigen::MatrixXd jacobian(n, static_cast<Eigen::Index>(free.size()));
  const Eigen::VectorXd r0 = Eigen::Map<const Eigen::VectorXd>(base.data(), n);
  constexpr double kMove = 0.03;
  for (std::size_t j = 0; j < free.size(); ++j) {
    vehicle::Parameters<double> other = p;
    for (const P which : free[j]) other[which] *= 1 + kMove;
    const std::vector<double> there = residual(other);
    if (there.size() != base.size()) return p;
    jacobian.col(static_cast<Eigen::Index>(j)) = (Eigen::Map<const Eigen::VectorXd>(there.data(), n) - r0) / kMove;
  }
  Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
  for (std::size_t j = 0; j < free.size(); ++j) {
    const double width = std::max(0.01, in.car->prior[static_cast<std::size_t>(free[j].front())]);
    normal(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(j)) += 1 / (width * width);
  }
  // The derivatives of the first step serve the other two as well.
  const auto solver = normal.ldlt();
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(jacobian.cols()), r = r0;
  for (int round = 0; round < 3; ++round) {
    Eigen::VectorXd pull = jacobian.transpose() * r;
    for (std::size_t j = 0; j < free.size(); ++j) {
      const double width = std::max(0.01, in.car->prior[static_cast<std::size_t>(free[j].front())]);
      pull[static_cast<Eigen::Index>(j)] += moved[static_cast<Eigen::Index>(j)] / (width * width);
    }
    moved -= solver.solve(pull);
    for (std::size_t j = 0; j < free.size(); ++j) {
      double& change = moved[static_cast<Eigen::Index>(j)];
      change = std::clamp(change, -0.3, 0.3);
      for (const P which : free[j]) p[which] = in.car->parameters[which] * (1 + change);
    }
    if (round == 2) break;
    const std::vector<double> now = residual(p);
    if (now.size() != base.size()) break;
    r = Eigen::Map<const Eigen::VectorXd>(now.data(), n);
  }
  return p;
}

constexpr std::array<double, 3> kHorizons{0.6, 2.0, 8.0};

struct Side {
  std::array<std::vector<std::vector<WindowEnd>>, kHorizons.size()> ends;  ///< per horizon and log
  std::vector<Driven> driven;                                              ///< per log, at the longest horizon
  double lap_s = kNaN;
  std::string problem;
};

Side one_side(const SimulationInputs& in, const std::vector<RecordedLog>& logs, const Judge& judge) {
  Side out;
  try {
    std::vector<vehicle::Recording> recordings;
    recordings.reserve(logs.size());
    for (const RecordedLog& log : logs) recordings.push_back(vehicle::make_recording(*log.table, log.signals->name, in.mapping));
    const vehicle::Parameters<double> p = refitted(in, recordings, judge);
    out.driven.resize(recordings.size());
    for (std::size_t h = 0; h < kHorizons.size(); ++h)
      for (std::size_t k = 0; k < recordings.size(); ++k)
        out.ends[h].push_back(drive(*in.car, p, *in.surface, recordings[k], std::max(2.0, kHorizons[h]), kHorizons[h], h + 1 == kHorizons.size() ? &out.driven[k] : nullptr));
    const auto made = vehicle::make_car(in.car->files, p, in.car->terms, in.car->contact);
    vehicle::LapOptions lap;
    lap.record_every = 0;
    const vehicle::LapResult result = vehicle::drive_laps(made, vehicle::Road(*in.surface), lap);
    if (result.complete && !result.lap_s.empty()) out.lap_s = result.lap_s.front();
    else out.problem = "the built-in driver did not finish a lap: " + result.problem;
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

}  // namespace

SimulationCheck check_simulation(const std::vector<RecordedLog>& logs, const SimulationInputs& before, const SimulationInputs& after, const std::set<int>& hold_out) {
  SimulationCheck out;
  out.lap_before_s = out.lap_after_s = kNaN;
  Judge judge{&logs, hold_out};
  int laps = 0;
  for (const RecordedLog& log : logs) laps += log.signals->lap.empty() ? 1 : log.signals->lap.back() + 1;
  if (hold_out.empty())
    for (int lap = 1; lap < laps; lap += 2) judge.judged.insert(lap);
  if (judge.judged.empty()) {
    out.remarks.push_back("the whole simulated car was not compared: one lap cannot both fit and judge it");
    return out;
  }
  for (const RecordedLog& log : logs) {
    const Signals& s = *log.signals;
    for (std::size_t lap = 0, begin = 0; lap < s.whole.size(); ++lap) {
      std::size_t end = begin;
      while (end < s.n && s.lap[end] == static_cast<int>(lap)) ++end;
      if (s.whole[lap]) out.recorded_lap_s.push_back(static_cast<double>(end - begin) * Signals::kStep_s);
      begin = end;
    }
  }
  Side sides[2];
  std::thread other([&] { sides[1] = one_side(after, logs, judge); });
  sides[0] = one_side(before, logs, judge);
  other.join();
  out.lap_before_s = sides[0].lap_s;
  out.lap_after_s = sides[1].lap_s;
  for (std::size_t k = 0; k < 2; ++k)
    if (!sides[k].problem.empty()) out.remarks.push_back(fmt::format("whole simulation, {}: {}", k == 0 ? "before" : "after", sides[k].problem));
  for (std::size_t c = 0; c < kCompared.size(); ++c) {
    const int lap = *judge.judged.begin();
    out.driven.push_back({kCompared[c].channel, kCompared[c].unit, lap, lap_of(sides[0], judge, lap, c), lap_of(sides[1], judge, lap, c)});
    const auto& recorded = out.driven.back().before.recorded;
    if (std::none_of(recorded.begin(), recorded.end(), [](double v) { return std::isfinite(v); })) out.driven.pop_back();
  }
  for (std::size_t h = 0; h < kHorizons.size(); ++h) {
    if (sides[0].ends[h].size() != logs.size() || sides[1].ends[h].size() != logs.size()) continue;
    for (std::size_t c = 0; c < 4; ++c) {
      std::vector<std::array<double, 3>> squares;
      for (std::size_t k = 0; k < logs.size(); ++k) {
        const auto &a = sides[0].ends[h][k], &b = sides[1].ends[h][k];
        for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
          if (std::isfinite(a[i].error[c]) && std::isfinite(b[i].error[c]) && judge.is_judged(k, a[i].t_s)) squares.push_back({a[i].square[c], b[i].square[c], a[i].hold[c]});
      }
      if (squares.size() < 8) continue;
      HeldOut held;
      held.channel = c < kCompared.size() ? kCompared[c].channel : "lateral_m";
      held.unit = c < kCompared.size() ? kCompared[c].unit : "m";
      held.horizon_s = kHorizons[h];
      held.whole_car = true;
      const auto rms = [&](std::size_t which) {
        double sum = 0;
        for (const auto& s : squares) sum += s[which];
        return std::sqrt(sum / static_cast<double>(squares.size()));
      };
      held.rmse_before = rms(0);
      held.rmse_after = rms(1);
      held.trivial_rmse = rms(2);
      Dice dice{97 + 10 * h + c};
      std::vector<double> drops;
      for (int draw = 0; draw < 400; ++draw) {
        double a = 0, b = 0;
        for (std::size_t i = 0; i < squares.size(); ++i) {
          const auto& s = squares[static_cast<std::size_t>(dice.roll() * static_cast<double>(squares.size()))];
          a += s[0];
          b += s[1];
        }
        drops.push_back(a > 0 ? 1 - std::sqrt(b / a) : 0.0);
      }
      std::sort(drops.begin(), drops.end());
      held.drop_low = drops[20];
      held.drop_high = drops[379];
      out.held_out.push_back(held);
    }
  }
  return out;
}

}  // namespace explain
