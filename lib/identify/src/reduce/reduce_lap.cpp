#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "identify/reduce.h"
#include "reduce_fit.h"
#include "vehicle/lap.h"
#include "vehicle/laws/tyre_heat.h"

namespace identify {
namespace {

using P = vehicle::Parameter;
using T = vehicle::Term;

constexpr std::size_t kEvery = 10;  // steps
constexpr double kKerb_m = 0.01;    // that a wheel stands beside the plane of the others
constexpr double kSlower = 0.85, kLeastGrip = 0.5;  // share of the grip to plan with, after a spin

/// A row of the lap: what the full car did and what its road was like.
struct LapRow {
  CarMoment moment;
  std::array<double, 3> shares{};  ///< of gravity, bank, dips and crests in what presses, m/s2
  double twist_m = 0.0;
};

/// How far the places under the wheels are from one plane.
double twist_of(const vehicle::Detail<double>& detail) {
  const auto z = [&](std::size_t i) { return detail.wheel[i].road.z_m; };
  return std::abs(z(0) - z(1) - z(2) + z(3)) / 4.0;
}

std::vector<LapRow> drive_lap(const vehicle::Car<double>& car, const vehicle::Road& road,
                              double fuel_kg, const base::Progress& progress, LapError& out_of) {
  vehicle::LapOptions options;
  options.fuel_kg = fuel_kg;
  options.record_every = 0;
  if (progress)
    options.progress = [&](const std::string&, double done) {
      progress("lap of the full car", done);
    };
  std::vector<LapRow> out;
  std::size_t steps = 0;
  options.on_step = [&](const vehicle::LapStep& step) {
    if (steps++ % kEvery != 0) return;
    vehicle::State<double> rate{};
    for (std::size_t i = 0; i < vehicle::kStateSize; ++i)
      rate[i] = (step.after[i] - step.before[i]) / options.step.step_s;
    LapRow& row = out.emplace_back();
    row.moment = moment_of(car, step.before, rate, step.detail, step.time_s);
    const std::size_t i = step.station;
    control::control_normal_shares(car.parameters[P::environment_gravity_mps2],
                                   step.before[vehicle::kVx], step.line.curvature_1pm[i],
                                   step.line.bank[i], step.line.grade[i],
                                   step.line.vertical_curvature_1pm[i], row.shares.data());
    row.twist_m = twist_of(step.detail);
  };
  vehicle::LapResult lap = vehicle::drive_laps(car, road, options);
  // A car that lost the line is driven slower: what is compared are the rows where it grips.
  for (double& grip = options.speed.grip_usage; !lap.complete && grip * kSlower > kLeastGrip;) {
    grip *= kSlower;
    out.clear();
    steps = 0;
    lap = vehicle::drive_laps(car, road, options);
  }
  if (!lap.complete)
    throw base::Error(fmt::format("the lap of the full car ended: {}", lap.problem));
  out_of.lap_s = lap.lap_s.front();
  out_of.grip_usage = options.speed.grip_usage;
  return out;
}

/// What temperature makes of the tyres of an axle, against those of the rig.
void warm(const vehicle::Car<double>& car, const CarMoment& m, PlanarState& in) {
  if (!(car.terms[T::tyre_thermal] > 0.0)) return;
  for (std::size_t a = 0; a < 2; ++a) {
    const auto f = vehicle::laws::tread_factors(car.parameters, car.files->tyre_grip,
                                                car.terms[T::tyre_thermal], m.tyre_k[a]);
    in.grip[a] = f.grip;
    in.stiffness[a] = f.stiffness;
  }
}

struct Sums {
  double ay = 0.0, yaw = 0.0, load = 0.0, mean_load = 0.0;
  std::size_t loads = 0;
  std::vector<double> misses;
  void add(const CarMoment& m, const ReducedForces& f, bool wheels) {
    const double miss = f.ay_mps2 - m.ay_mps2;
    misses.push_back(std::abs(miss));
    ay += miss * miss;
    yaw += std::pow(f.yaw_moment_nm - m.yaw_moment_nm, 2);
    for (std::size_t i = 0; i < (wheels ? 4u : 2u); ++i) {
      const double full = wheels ? m.wheel[i].fz_n : m.wheel[2 * i].fz_n + m.wheel[2 * i + 1].fz_n;
      load += std::pow((wheels ? f.fz_n[i] : f.axle_fz_n[i]) - full, 2);
      mean_load += full;
      ++loads;
    }
  }
  double load_rms() const {
    return std::sqrt(load / static_cast<double>(loads)) / (mean_load / static_cast<double>(loads));
  }
  LapError::Model of(double largest) {
    const double n = static_cast<double>(misses.size());
    std::sort(misses.begin(), misses.end());
    return {std::sqrt(ay / n) / largest,
            misses[static_cast<std::size_t>(0.95 * (n - 1.0))] / largest, std::sqrt(yaw / n),
            load_rms()};
  }
};

}  // namespace

LapError compare_on_lap(const vehicle::Car<double>& car, const Reduction& reduction,
                        const vehicle::Road& road, const base::Progress& progress) {
  LapError out;
  const std::vector<LapRow> rows = drive_lap(car, road, reduction.car.fuel_kg, progress, out);
  for (const LapRow& row : rows)
    out.largest_ay_mps2 = std::max(out.largest_ay_mps2, std::abs(row.moment.ay_mps2));
  Sums single, two, no_bank, no_vertical;
  SlipLags lags_single{}, lags_two{};
  double before_s = rows.empty() ? 0.0 : rows.front().moment.time_s;
  for (const LapRow& row : rows) {
    const CarMoment& m = row.moment;
    PlanarState in = planar_state(m);
    warm(car, m, in);
    in.an_mps2 = row.shares[0] + row.shares[1] + row.shares[2];
    const double step_s = m.time_s - before_s;
    before_s = m.time_s;
    const ReducedForces one = single_track(reduction.car, in, &lags_single, step_s);
    SlipLags same = lags_two;
    const ReducedForces both = double_track(reduction.car, in, &lags_two, step_s);
    if (row.twist_m > kKerb_m) {
      ++out.on_kerbs;
    } else if (m.vx_mps < 0.8 * reduction.least_mps || m.vx_mps > 1.05 * reduction.most_mps) {
      ++out.other_speeds;
    } else if (!grips(m)) {
      ++out.sliding;
    } else {
      ++out.rows;
      single.add(m, one, false);
      two.add(m, both, true);
      PlanarState flat = in;
      SlipLags again = same;
      flat.an_mps2 = in.an_mps2 - row.shares[1];
      no_bank.add(m, double_track(reduction.car, flat, &again, step_s), true);
      flat.an_mps2 = in.an_mps2 - row.shares[2];
      no_vertical.add(m, double_track(reduction.car, flat, &same, step_s), true);
    }
  }
  if (out.rows < 100)
    throw base::Error(
        fmt::format("only {} rows of the lap are outside kerbs, between {:.1f} and {:.1f} m/s and "
                    "without sliding wheels; "
                    "wanted at least 100",
                    out.rows, 0.8 * reduction.least_mps, 1.05 * reduction.most_mps));
  out.single = single.of(out.largest_ay_mps2);
  out.two = two.of(out.largest_ay_mps2);
  out.load_rms_without_bank = no_bank.load_rms();
  out.load_rms_without_vertical = no_vertical.load_rms();
  return out;
}

}  // namespace identify
