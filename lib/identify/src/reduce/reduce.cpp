#include "identify/reduce.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "identify/least_squares.h"
#include "reduce_fit.h"

namespace identify {
namespace {

using P = vehicle::Parameter;

constexpr double kNoYaw = 0.002;      // yaw moment of a trim, over weight times a quarter wheelbase
constexpr double kBorderSlip = 1.25;  // slip angles of the border, over those of the rig
constexpr double kFull = 1.4;         // braking that locks wheels on any road tyre, over the loads

std::vector<double> speeds_of(const ReduceOptions& options, double most_mps) {
  std::vector<double> out;
  for (std::size_t k = 0; k < options.speeds; ++k)
    out.push_back(options.least_mps + (most_mps - options.least_mps) * static_cast<double>(k) /
                                          static_cast<double>(options.speeds - 1));
  return out;
}

/// Stairs at a speed: longer where tyres need more time for their way.
RigRun ramp_at(const ReduceOptions& options, double speed_mps, double gravity) {
  RigRun run;
  run.speed_mps = speed_mps;
  run.gravity = gravity;
  run.fuel_kg = options.fuel_kg;
  run.stair_s = 0.2 + 1.0 / speed_mps;
  run.stairs = options.slips;
  return run;
}

std::vector<RigRun> runs_of(const ReduceOptions& options, double most_mps, double friction) {
  static constexpr std::pair<double, double> kEnds[] = {{1.0, 1.0}, {1.0, 0.5}, {0.5, 1.0}};
  std::vector<RigRun> out;
  for (const double speed : speeds_of(options, most_mps))
    for (const double gravity : options.gravities)
      for (const auto& [front, rear] : kEnds) {
        RigRun run = ramp_at(options, speed, gravity);
        run.front_rad = front * options.most_slip_rad;
        run.rear_rad = rear * options.most_slip_rad;
        out.push_back(run);
        for (const double throttle : {0.4, 1.0}) {
          out.push_back(run);
          out.back().throttle = throttle;
        }
        for (const double share : {0.35, 0.75}) {
          out.push_back(run);
          out.back().braking = share * friction;
          out.back().neutral = true;
        }
        for (std::size_t axle = 0; axle < 2; ++axle) {
          out.push_back(run);
          out.back().braking = 0.55 * friction;
          out.back().brake_axle[1 - axle] = 0.0;
        }
      }
  return out;
}

/// All runs on all cores, in their order.
std::vector<std::vector<CarMoment>> drive_all(const vehicle::Car<double>& car,
                                              const std::vector<RigRun>& runs,
                                              const ReduceOptions& options,
                                              const std::string& stage, double from, double to) {
  std::vector<std::vector<CarMoment>> out(runs.size());
  std::atomic<std::size_t> done{0};
  base::parallel_for(runs.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      out[k] = run_rig(car, runs[k]);
      if (options.progress)
        options.progress(stage, from + (to - from) * static_cast<double>(++done) /
                                           static_cast<double>(runs.size()));
    }
  });
  return out;
}

double friction_of(const vehicle::Car<double>& car) {
  double mu = 10.0;
  for (std::size_t a = 0; a < 2; ++a)
    mu = std::min(mu, std::abs(vehicle::tyre_forces(car.files->tyre[a],
                                                    vehicle::TyreInput<double>{car.static_load_n[a],
                                                                               0, 0, 0, 30.0, 0.0},
                                                    {}, {.moments = false})
                                   .mu_x) *
                          car.parameters.axle(a, P::front_tyre_grip));
  return mu;
}

/// The hardest the car brakes on the rig, and the hardest it accelerates, straight on.
struct Straight {
  double brake_mps2 = 0.0, drive_mps2 = 0.0;  ///< specific force, below and above 0
  double throttle = 1.0;                      ///< the least for nearly all of the second
};

Straight straight_on(const vehicle::Car<double>& car, const ReduceOptions& options, double speed,
                     double gravity, double friction) {
  RigRun run = ramp_at(options, speed, gravity);
  run.front_rad = run.rear_rad = 0.0;
  run.neutral = true;
  run.braking = 0.3 * friction;
  run.braking_end = kFull * friction;
  Straight out;
  for (const CarMoment& m : run_rig(car, run)) out.brake_mps2 = std::min(out.brake_mps2, m.ax_mps2);
  run.braking = 0.0;
  run.braking_end = -1.0;
  run.neutral = false;
  run.throttle_end = 1.0;
  run.stair_s = 0.4;  // a turbocharger needs its time
  const std::vector<CarMoment> driven = run_rig(car, run);
  out.drive_mps2 = -1e9;
  for (const CarMoment& m : driven) out.drive_mps2 = std::max(out.drive_mps2, m.ax_mps2);
  for (std::size_t k = 0; k < driven.size(); ++k)
    if (driven[k].ax_mps2 > out.drive_mps2 - 0.03 * std::abs(out.drive_mps2)) {
      out.throttle = static_cast<double>(k + 1) / static_cast<double>(run.stairs);
      break;
    }
  return out;
}

double no_yaw_nm(double mass_kg, double an_mps2, double wheelbase_m) {
  return kNoYaw * mass_kg * an_mps2 * 0.25 * wheelbase_m;
}

/// The moment of largest lateral acceleration, as long as there is no yaw moment and the axle whose
/// slip grows is not past its largest side force: from there on the car slides. nullptr: there is
/// none.
const CarMoment* best_trim(const std::vector<CarMoment>& moments, const RigRun& run) {
  const std::size_t led = run.path == RigPath::kTrimFront ? 0 : 2;
  const CarMoment* best = nullptr;
  double most_n = 0.0;
  for (const CarMoment& m : moments) {
    const double force_n = m.wheel[led].fy_n + m.wheel[led + 1].fy_n;
    if (force_n < kPastPeak * most_n || std::abs(m.yaw_moment_nm) > run.trim_nm) break;
    most_n = std::max(most_n, force_n);
    if (grips(m) && (best == nullptr || m.ay_mps2 > best->ay_mps2)) best = &m;
  }
  return best;
}

std::vector<RigRun> border_runs(const vehicle::Car<double>& car, const ReduceOptions& options,
                                double most_mps, double friction, Reduction& reduction) {
  const std::vector<double> speeds = speeds_of(options, most_mps);
  const std::size_t places = speeds.size() * options.gravities.size();
  std::vector<Straight> straight(places);
  base::parallel_for(places, 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      straight[k] = straight_on(car, options, speeds[k / options.gravities.size()],
                                options.gravities[k % options.gravities.size()], friction);
  });
  std::vector<RigRun> out;
  for (std::size_t k = 0; k < places; ++k) {
    const double speed = speeds[k / options.gravities.size()],
                 gravity = options.gravities[k % options.gravities.size()];
    const double an = gravity * car.parameters[P::environment_gravity_mps2];
    GripEllipse place;
    place.vx_mps = speed;
    place.an_mps2 = an;
    place.drive_mps2 = straight[k].drive_mps2;
    place.brake_mps2 = straight[k].brake_mps2;
    reduction.ellipses.push_back(place);
    RigRun run = ramp_at(options, speed, gravity);
    run.stairs = options.slips + options.slips / 4;
    run.front_rad = run.rear_rad = kBorderSlip * options.most_slip_rad;
    for (const RigPath path : {RigPath::kTrimFront, RigPath::kTrimRear}) {
      run.path = path;
      run.trim_nm = no_yaw_nm(car.parameters[P::chassis_mass_kg] + options.fuel_kg, an,
                              car.parameters[P::chassis_wheelbase_m]);
      run.throttle = run.braking = 0.0;
      run.neutral = true;
      out.push_back(run);
      run.neutral = false;
      for (const double share : {0.4, 0.7, 0.95}) {
        run.throttle = share * straight[k].throttle;
        out.push_back(run);
      }
      run.throttle = 0.0;
      run.neutral = true;
      for (const double share : {0.25, 0.5, 0.7, 0.85}) {
        run.braking = -share * straight[k].brake_mps2 / an * 0.95;
        // Downforce presses too: the brake force is over the loads.
        const double load = an + 0.5 * car.parameters[P::aero_density_kgpm3] * speed * speed *
                                     (car.parameters[P::front_lift_area_m2] +
                                      car.parameters[P::rear_lift_area_m2]) /
                                     (car.parameters[P::chassis_mass_kg] + options.fuel_kg);
        run.braking *= an / load;
        out.push_back(run);
      }
    }
  }
  return out;
}

void find_border(const ReduceOptions& options, const std::vector<RigRun>& plans,
                 const std::vector<std::vector<CarMoment>>& driven, Reduction& out) {
  // Both ways of the same throttle or braking: the better one is the border.
  const std::size_t half = 8;  // runs of one way at one place
  for (std::size_t place = 0; place * 2 * half < plans.size(); ++place)
    for (std::size_t level = 0; level < half; ++level) {
      const std::size_t one = place * 2 * half + level;
      const CarMoment* best = best_trim(driven[one], plans[one]);
      const CarMoment* other = best_trim(driven[one + half], plans[one + half]);
      if (best == nullptr || (other != nullptr && other->ay_mps2 > best->ay_mps2)) best = other;
      const double an_mps2 = plans[one].gravity * out.car.gravity_mps2;
      if (best == nullptr || best->ay_mps2 < 0.1 * an_mps2) continue;
      const PlanarState s = planar_state(*best);
      GripPoint p;
      p.vx_mps = plans[one].speed_mps;
      p.an_mps2 = an_mps2;
      p.ax_mps2 = s.ax_mps2;
      p.full_mps2 = best->ay_mps2;
      std::copy_n(s.fx_n, 2, p.fx_n.begin());
      p.drive_nm = s.drive_nm;
      p.rolls_free = level == 0;
      out.border.push_back(p);
      if (level == 0) {
        out.ellipses[place].ay_mps2 = best->ay_mps2;
        out.ellipses[place].ax_mps2 = s.ax_mps2;
      }
    }
  base::parallel_for(out.border.size(), 1, options.threads,
                     [&](std::size_t begin, std::size_t end) {
                       for (std::size_t k = begin; k < end; ++k) {
                         GripPoint& p = out.border[k];
                         PlanarState in;
                         in.vx_mps = p.vx_mps;
                         in.ax_mps2 = p.ax_mps2;
                         in.an_mps2 = p.an_mps2;
                         std::copy_n(p.fx_n.begin(), 2, in.fx_n);
                         in.drive_nm = p.drive_nm;
                         const double most_rad = kBorderSlip * options.most_slip_rad;
                         p.single_mps2 = steady_limit(out.car, in, false, most_rad);
                         p.double_mps2 = steady_limit(out.car, in, true, most_rad);
                       }
                     });
}

/// 1 on the border's formula.
double radius_of(const GripEllipse& e, double ax_mps2, double ay_mps2) {
  const double ellipse[] = {e.ay_mps2,    e.ax_mps2,     e.drive_mps2,
                            e.brake_mps2, e.drive_power, e.brake_power};
  return control::control_ellipse_radius(ellipse, ax_mps2, ay_mps2);
}

void fit_ellipses(Reduction& out) {
  ErrorSum error;
  std::vector<GripEllipse> found;
  for (GripEllipse e : out.ellipses) {
    if (!(e.ay_mps2 > 0.0 && e.ax_mps2 > e.brake_mps2 + 0.1 && e.drive_mps2 > e.ax_mps2 + 0.1))
      continue;  // no such place: the car does not drive there
    std::vector<const GripPoint*> here;
    for (const GripPoint& p : out.border)
      if (p.vx_mps == e.vx_mps && p.an_mps2 == e.an_mps2) here.push_back(&p);
    std::vector<Unknown> powers{{"drive", 2.0, 1.0, 12.0, 1.0}, {"brake", 2.0, 1.0, 12.0, 1.0}};
    least_squares(powers, [&](const std::vector<double>& values, std::vector<double>& left) {
      e.drive_power = values[0];
      e.brake_power = values[1];
      left.clear();
      for (const GripPoint* p : here) left.push_back(radius_of(e, p->ax_mps2, p->full_mps2) - 1.0);
    });
    e.drive_power = powers[0].value;
    e.brake_power = powers[1].value;
    for (const GripPoint* p : here)
      error.add_miss(p->full_mps2, 1.0 / radius_of(e, p->ax_mps2, p->full_mps2) - 1.0);
    found.push_back(e);
  }
  out.ellipses = found;
  out.ellipse_error =
      error.as("border as ellipses, distance from the free-rolling car", "m/s2", true);
}

PartError limit_error(const Reduction& r, double GripPoint::*reduced, const std::string& name) {
  ErrorSum sum;
  for (const GripPoint& p : r.border)
    if (p.rolls_free) sum.add_miss(p.full_mps2, p.*reduced / p.full_mps2 - 1.0);
  return sum.as(name, "m/s2", true);
}

}  // namespace

Reduction reduce_car(const vehicle::Car<double>& car, const ReduceOptions& options) {
  Reduction out;
  for (std::size_t a = 0; a < 2; ++a)
    for (const auto part :
         {P::front_brake_area_m2, P::front_brake_radius_m, P::front_brake_friction})
      if (!(car.parameters.axle(a, part) > 0.0))
        throw base::Error(
            fmt::format("the {} brakes have no area, radius or friction, wanted more than 0: the "
                        "rig brakes both axles",
                        recording::kAxleNames[a]));
  const double most_mps = options.most_mps > 0.0 ? options.most_mps : top_speed(car);
  if (!(most_mps > options.least_mps + 5.0) || options.speeds < 2 || options.gravities.empty())
    throw base::Error(fmt::format(
        "speeds from {:g} to {:g} m/s: wanted at least two, 5 m/s apart; {}", options.least_mps,
        most_mps,
        options.most_mps > 0.0 ? "give others" : "the car's engine and drag allow no more"));
  out.least_mps = options.least_mps;
  out.most_mps = most_mps;
  out.most_slip_rad = options.most_slip_rad;
  out.gravities = options.gravities;
  out.car = plain_numbers(car, options.fuel_kg);
  const double friction = friction_of(car);
  const std::vector<RigRun> runs = runs_of(options, most_mps, friction);
  std::vector<CarMoment> moments;
  for (const auto& run : drive_all(car, runs, options, "full car on the rig", 0.0, 0.4))
    moments.insert(moments.end(), run.begin(), run.end());
  const std::vector<RigRun> plans = border_runs(car, options, most_mps, friction, out);
  const auto trims = drive_all(car, plans, options, "border of the full car", 0.4, 0.7);
  std::vector<CarMoment> trimmed;
  for (const auto& run : trims) trimmed.insert(trimmed.end(), run.begin(), run.end());
  out.runs = runs.size() + plans.size();
  out.moments = moments.size() + trimmed.size();
  if (moments.size() < 5 * runs.size())
    throw base::Error(fmt::format(
        "the full car on the rig came to {} moments in {} runs, wanted at least {}: it does not "
        "settle, or rolls over; look at it with crgdrive manoeuvre ramp",
        moments.size(), runs.size(), 5 * runs.size()));
  if (options.progress) options.progress("fitting", 0.7);
  fit_loads(out.car, moments, out.parts);
  fit_radius(out.car, moments, out.parts);
  fit_curves(out.car, moments, trimmed, car, options.threads, out.parts);
  fit_yaw(out.car, moments, out.parts);
  std::vector<std::vector<CarMoment>> sweeps;
  for (const double share : {0.35, 0.7}) {
    const double v = std::max(options.least_mps, share * most_mps);
    // About a third of gravity: a steering angle without slip is L ay / v^2.
    const double steer = std::clamp(4.0 * out.car.wheelbase_m / (v * v) + 0.012, 0.012, 0.1);
    sweeps.push_back(run_swept_sine(car, v, steer, 12.0, options.fuel_kg));
  }
  fit_relaxation(out.car, sweeps, out.parts);
  judge_differential(out.car, moments, out.parts);
  if (options.progress) options.progress("border of the reduced car", 0.85);
  find_border(options, plans, trims, out);
  fit_ellipses(out);
  out.limit_single = limit_error(out, &GripPoint::single_mps2, "steady-state limit, single-track");
  out.limit_double = limit_error(out, &GripPoint::double_mps2, "steady-state limit, double-track");
  return out;
}

}  // namespace identify
