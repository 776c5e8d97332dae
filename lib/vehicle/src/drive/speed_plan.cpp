// How fast a car can go along a line.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "vehicle/car.h"
#include "vehicle/laws/engine.h"
#include "vehicle/laws/tyre_heat.h"
#include "vehicle/magic_formula.h"
#include "vehicle/racing_line.h"
#include "vehicle/steady_engine.h"

namespace vehicle {
namespace {

constexpr double kOfAxle = 0.9;   ///< share of an axle's own grip that a turn may take
constexpr double kOfScrub = 0.9;  ///< and of a wheel's that a locked axle may take, at most

/// Of the axles, their inner and outer wheels.
using PerWheel = std::array<std::array<double, 2>, 2>;

/// What the car can do at each station of a line.
class SpeedLimits {
 public:
  SpeedLimits(const RacingLine& line, const Car<double>& car, const SpeedOptions& options)
      : line_(line), car_(car), p_(car.parameters), options_(options) {
    if (car.terms[Term::tyre_thermal] > 0.0) {
      warmth_ = laws::tread_factors(p_, car.files->tyre_grip, car.terms[Term::tyre_thermal],
                                    options.tyre_k)
                    .grip;
    }
  }

  double mass() const { return mass_; }
  double climb_n(std::size_t i) const { return mass_ * g_ * line_.grade[i]; }
  double drag_n(double v) const { return half_density_ * drag_area_ * v * v; }

  /// Friction the tyres have at a station at the load of this speed; the weaker axle counts, the
  /// temperature and the road.
  double friction(std::size_t i, bool lateral, double v) const {
    const double load_n = load(i, v);
    double mu = 10.0;
    for (std::size_t a = 0; a < 2; ++a) {
      const double fz =
          load_n * car_.static_load_n[a] / (2.0 * (car_.static_load_n[0] + car_.static_load_n[1]));
      const TyreForces<double> f =
          tyre_forces(car_.files->tyre[a],
                      TyreInput<double>{std::max(fz, 100.0), 0, 0, 0, 30,
                                        p_.axle(a, P::front_tyre_pressure_pa)},
                      {}, {.moments = false});
      mu = std::min(mu, std::abs(lateral ? f.mu_y : f.mu_x) * p_.axle(a, P::front_tyre_grip));
    }
    return mu * warmth_ * road_grip(i) * options_.grip_usage;
  }

  double load(std::size_t i, double v) const {
    const double tilt =
        1.0 / std::sqrt(1.0 + line_.bank[i] * line_.bank[i] + line_.grade[i] * line_.grade[i]);
    // Weight, downforce, dips and crests, and the part of the cornering force a bank takes up.
    const double n =
        mass_ *
            (g_ * tilt +
             v * v * (line_.vertical_curvature_1pm[i] - line_.curvature_1pm[i] * line_.bank[i])) +
        half_density_ * lift_area_ * v * v;
    return std::max(n, 0.1 * mass_ * g_);
  }

  /// Lateral force the tyres must give at v: the turn, less what gravity on the bank gives. The
  /// bank rises to the left, so it pushes to the right.
  double lateral(std::size_t i, double v) const {
    return mass_ * std::abs(v * v * line_.curvature_1pm[i] + g_ * line_.bank[i]);
  }

  /// Whether each axle can take its part of the turn at v. The car's grip as a whole does not tell:
  /// loads of the wheels of an axle differ, the air may press the other axle more, and the wheels
  /// of a locked axle slip along their way, which turns the car out of the bend.
  bool balances(std::size_t i, double v) const {
    const double side_n = lateral(i, v), wheelbase_m = p_[P::chassis_wheelbase_m];
    const PerWheel fz_n = wheel_loads(load(i, v), side_n, v);
    const double scrub = 0.5 * car_.terms[Term::locked_differential] *
                         p_.axle(1, P::front_track_m) * std::abs(line_.curvature_1pm[i]);
    std::array<double, 2> most_n{};
    double out_nm = 0.0;
    for (std::size_t a = 0; a < 2; ++a)
      for (const double fz : fz_n[a]) {
        const double grip_n = kOfAxle * wheel_grip(a, fz) * road_grip(i);
        double along_n = 0.0;
        if (a == 1 && scrub > 0.0)
          along_n = std::min(kOfScrub * grip_n,
                             scrub * std::abs(tyre_stiffness(car_.files->tyre[a], fz,
                                                             p_.axle(a, P::front_tyre_pressure_pa))
                                                  .slip_n));
        most_n[a] += std::sqrt(grip_n * grip_n - along_n * along_n);
        out_nm += 0.5 * p_.axle(a, P::front_track_m) * along_n;
      }
    const double pair_n = out_nm / wheelbase_m;
    return share(0) * side_n + pair_n <= most_n[0] && share(1) * side_n - pair_n <= most_n[1];
  }

  /// Share of the grip that cornering leaves.
  double spare(std::size_t i, double v) const {
    const double used = lateral(i, v) / std::max(1.0, friction(i, true, v) * load(i, v));
    return std::sqrt(std::max(0.0, 1.0 - used * used));
  }

  double engine_force(double v) const {
    const double radius = car_.static_radius_m[1];
    double best = 0.0;
    for (int gear = 1; gear <= kMostGears; ++gear) {
      const double ratio = overall_ratio(p_, gear);
      const double speed_e = ratio * v / radius;
      if (ratio <= 0.0 || speed_e > p_[P::engine_limit_radps]) continue;
      best = std::max(best, laws::map_torque(p_[P::engine_torque], engine_map(car_, line_),
                                             std::max(speed_e, p_[P::clutch_full_radps]), 1.0) *
                                ratio * p_[P::gearbox_efficiency] / radius);
    }
    return best;
  }

  /// Largest speed with grip to spare; a bank alone never asks for a minimum speed here.
  double cornering_speed(std::size_t i) const {
    double fast = options_.top_mps, slow = 3.0;
    const auto holds = [&](double v) {
      return lateral(i, v) <= friction(i, true, v) * load(i, v) && balances(i, v);
    };
    if (holds(fast)) return fast;
    for (int k = 0; k < 40; ++k) {
      const double v = 0.5 * (fast + slow);
      (holds(v) ? slow : fast) = v;
    }
    return slow;
  }

 private:
  using P = Parameter;

  /// Of the car's weight, on an axle.
  double share(std::size_t a) const {
    return car_.static_load_n[a] / (car_.static_load_n[0] + car_.static_load_n[1]);
  }

  double road_grip(std::size_t i) const {
    return 1.0 + car_.terms[Term::road_friction] *
                     (p_[P::environment_road_grip] * line_.friction[i] - 1.0);
  }

  /// What a wheel of an axle can give sideways on a road of grip 1.
  double wheel_grip(std::size_t a, double fz_n) const {
    if (!(fz_n > 0.0)) return 0.0;
    return fz_n * warmth_ * p_.axle(a, P::front_tyre_grip) *
           std::abs(
               peak_friction(car_.files->tyre[a], fz_n, p_.axle(a, P::front_tyre_pressure_pa)).y);
  }

  /// Loads of the wheels where the tyres give `side_n`: the side force acts on the body through the
  /// roll centres, and springs and bars share what tilts it, each axle by its stiffness.
  PerWheel wheel_loads(double load_n, double side_n, double v) const {
    std::array<double, 2> held_nmprad{}, link_nm{}, air_n{};
    for (std::size_t a = 0; a < 2; ++a) {
      const double track_m = p_.axle(a, P::front_track_m);
      held_nmprad[a] = track_m * track_m *
                       (0.5 * p_.axle(a, P::front_spring_npm) +
                        car_.terms[Term::anti_roll_bar] * p_.axle(a, P::front_anti_roll_npm));
      link_nm[a] = share(a) * side_n * p_.axle(a, P::front_roll_centre_m);
      air_n[a] = half_density_ * car_.terms[Term::aero_downforce] *
                 p_.axle(a, P::front_lift_area_m2) * v * v;
    }
    const double body_nm = side_n * p_[P::chassis_cog_height_m] - link_nm[0] - link_nm[1];
    const double all_nmprad = std::max(1.0, held_nmprad[0] + held_nmprad[1]);
    PerWheel out{};
    for (std::size_t a = 0; a < 2; ++a) {
      const double half_n =
          0.5 * std::max(0.0, share(a) * (load_n - air_n[0] - air_n[1]) + air_n[a]);
      const double moved_n = std::clamp(
          (link_nm[a] + held_nmprad[a] / all_nmprad * body_nm) / p_.axle(a, P::front_track_m),
          -half_n, half_n);
      out[a] = {half_n - moved_n, half_n + moved_n};
    }
    return out;
  }

  const RacingLine& line_;
  const Car<double>& car_;
  const Parameters<double>& p_;
  const SpeedOptions& options_;
  double mass_ = p_[P::chassis_mass_kg] + options_.fuel_kg;
  double g_ = p_[P::environment_gravity_mps2];
  double half_density_ = 0.5 * p_[P::aero_density_kgpm3];
  double lift_area_ = value_of(car_.terms[Term::aero_downforce]) *
                      (p_[P::front_lift_area_m2] + p_[P::rear_lift_area_m2]);
  double drag_area_ = value_of(car_.terms[Term::aero_drag]) * p_[P::aero_drag_area_m2];
  double warmth_ = 1.0;
};

}  // namespace

void plan_speed(RacingLine& line, const Car<double>& car, const SpeedOptions& options) {
  line.engine_torque_nm = steady_engine(car);
  const SpeedLimits limits(line, car, options);
  const std::size_t n = line.v_m.size();
  std::vector<double>& speed = line.speed_mps;
  speed.assign(n, options.top_mps);
  for (std::size_t i = 0; i < n; ++i) speed[i] = limits.cornering_speed(i);
  const auto distance = [&](std::size_t i) {
    return i + 1 < n ? line.s_m[i + 1] - line.s_m[i] : line.length_m - line.s_m[i];
  };
  const double driven_share = car.static_load_n[1] / (car.static_load_n[0] + car.static_load_n[1]);
  // Twice round a closed lap, so that the end knows the beginning. An open road ends rolling.
  const std::size_t rounds = line.closed ? 2 * n : n;
  if (options.standing_start) speed[0] = std::min(speed[0], 3.0);
  if (!line.closed) {
    // Nobody knows what was before: as fast as asked, at most what the engine holds there.
    const auto holds = [&](double v) {
      return limits.engine_force(v) >= limits.drag_n(v) + limits.climb_n(0);
    };
    if (options.begin_mps > 0.0) speed[0] = std::min(speed[0], options.begin_mps);
    while (speed[0] > 3.0 && !holds(speed[0])) speed[0] = std::max(3.0, speed[0] - 0.25);
  }
  for (std::size_t k = 0; k + 1 < rounds; ++k) {  // forwards: acceleration
    const std::size_t i = k % n, j = (k + 1) % n;
    if (options.standing_start && j == 0) break;
    const double v = speed[i];
    const double grip =
        0.9 * limits.friction(i, false, v) * limits.load(i, v) * driven_share * limits.spare(i, v);
    const double force =
        std::min(grip, limits.engine_force(v)) - limits.drag_n(v) - limits.climb_n(i);
    speed[j] = std::min(
        speed[j], std::sqrt(std::max(9.0, v * v + 2.0 * force / limits.mass() * distance(i))));
  }
  for (std::size_t k = rounds; k-- > 1;) {  // backwards: braking
    const std::size_t j = k % n, i = (k - 1) % n;
    if (!line.closed && j == 0) continue;
    const double v = speed[j];
    const double grip =
        0.85 * limits.friction(i, false, v) * limits.load(i, v) * limits.spare(i, v);
    const double force = grip + limits.drag_n(v) + limits.climb_n(i);
    speed[i] = std::min(
        speed[i],
        std::sqrt(std::max(9.0, v * v + 2.0 * std::max(0.0, force) / limits.mass() * distance(i))));
  }
}

}  // namespace vehicle
