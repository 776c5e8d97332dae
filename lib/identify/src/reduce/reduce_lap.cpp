#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "identify/reduce.h"
#include "reduce_fit.h"
#include "vehicle/driver.h"
#include "vehicle/laws/tyre_heat.h"

namespace identify {
namespace {

using P = vehicle::Parameter;
using T = vehicle::Term;

constexpr double kKerb_m = 0.01;  // that a wheel stands beside the plane of the others

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
                              double fuel_kg, const base::Progress& progress, double& lap_s) {
  if (road.surface() == nullptr) throw base::Error("a lap needs a CRG road");
  vehicle::RacingLine line = vehicle::plan_line(*road.surface());
  vehicle::SpeedOptions plan;
  plan.fuel_kg = fuel_kg;
  vehicle::plan_speed(line, car, plan);
  const std::size_t first = line.closed ? 0 : std::min<std::size_t>(4, line.s_m.size() - 2);
  vehicle::StartOptions begin;
  begin.x_m = line.x_m[first];
  begin.y_m = line.y_m[first];
  begin.yaw_rad = line.heading_rad[first];
  begin.z_near_m = road.surface()->z_at_uv(
      line.u_begin_m + line.u_step_m * static_cast<double>(first), line.v_m[first]);
  begin.speed_mps = line.speed_mps[first];
  begin.gear = vehicle::choose_gear(car, begin.speed_mps, vehicle::kMostGears);
  begin.fuel_kg = fuel_kg;
  vehicle::Simulation<double> sim = vehicle::start(car, road, begin);
  vehicle::Driver driver;
  driver.gear = begin.gear;
  driver.station = first;
  driver.s_m = line.s_m[first];
  vehicle::Detail<double> detail{};
  const vehicle::StepOptions step;
  std::vector<LapRow> out;
  const double nose_m = car.parameters[P::chassis_cog_behind_front_m] + 1.0;
  bool half_round = false;
  double last_m = driver.s_m;
  for (std::size_t k = 0; k < 600000; ++k) {
    const vehicle::Controls<double> controls = drive(driver, line, car, sim.state, detail);
    const vehicle::State<double> before = sim.state;
    const double time_s = sim.time_s;
    const vehicle::StepResult result = vehicle::step(car, sim, controls, road, step, detail);
    if (!result.ok())
      throw base::Error(fmt::format(
          "the lap of the full car ended: {}",
          describe(result, time_s, detail.wheel[0].road.u_m, detail.wheel[0].road.v_m)));
    if (k % 10 == 0) {
      vehicle::State<double> rate{};
      for (std::size_t i = 0; i < vehicle::kStateSize; ++i)
        rate[i] = (sim.state[i] - before[i]) / step.step_s;
      LapRow row;
      row.moment = moment_of(car, before, rate, detail, time_s);
      const std::size_t i = driver.station;
      control::control_normal_shares(
          car.parameters[P::environment_gravity_mps2], before[vehicle::kVx], line.curvature_1pm[i],
          line.bank[i], line.grade[i], line.vertical_curvature_1pm[i], row.shares.data());
      row.twist_m = twist_of(detail);
      out.push_back(row);
    }
    if (progress && k % 4096 == 0) progress("lap of the full car", driver.s_m / line.length_m);
    half_round = half_round || std::abs(driver.s_m - 0.5 * line.length_m) < 0.1 * line.length_m;
    const bool over =
        line.closed ? half_round && driver.s_m < last_m - 0.5 * line.length_m
                    : driver.station + 3 >= line.s_m.size() || line.length_m - driver.s_m < nose_m;
    last_m = driver.s_m;
    if (over) {
      lap_s = sim.time_s;
      return out;
    }
  }
  throw base::Error("the full car did not finish its lap within 600 s");
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
  const std::vector<LapRow> rows = drive_lap(car, road, reduction.car.fuel_kg, progress, out.lap_s);
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
