// Forces from drives of the blind trials' two cars, which share no equation with lib/vehicle: what
// their tyres truly did, against what is estimated with a stated car that is a few per cent off.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>

#include "crg/file.h"
#include "identify/forces.h"
#include "support/figure.h"
#include "trial_drive.h"
#include "vehicle/vehicle_file.h"

namespace forces_of_trials_test {

using test_drive::Trial;

struct Errors {
  double rmse = 0.0, peak = 0.0, inside = 0.0;
};

template <class Truth>
Errors errors_of(const identify::Forces& f, const identify::Estimated& e, const Truth& truth) {
  Errors out;
  double n = 0.0;
  for (std::size_t k = 0; k < f.time_s.size(); ++k) {
    if (!std::isfinite(e.value[k])) continue;
    const double is = truth(f.time_s[k]), off = e.value[k] - is;
    out.rmse += off * off;
    out.peak = std::max(out.peak, std::abs(is));
    out.inside += std::abs(off) < 1.645 * e.sd[k] ? 1.0 : 0.0;
    n += 1.0;
  }
  EXPECT_GT(n, 100.0);
  out.rmse = std::sqrt(out.rmse / n);
  out.inside /= n;
  return out;
}

/// By the stated car.
identify::Forces forces_of(const Trial& trial, const recording::Recording& log, int noise_rounds) {
  const vehicle::Vehicle stated = vehicle::read_vehicle(trial.folder.path("vehicle.yaml"));
  const vehicle::Car<double> car =
      make_car(stated.files, stated.parameters, stated.terms, stated.contact);
  const crg::Surface surface(crg::read(trial.folder.path("track.crg")));
  identify::ForcesOptions options;
  options.fuel_kg = 0.0;
  options.prior = stated.prior;
  options.rolling_sd = 1.0;
  options.noise_rounds = noise_rounds;
  return identify::estimate_forces(car, vehicle::Road(surface), log, options);
}

/// Errors within 1.5 times the own car's bounds; slip angles inside their intervals in at least
/// this share of the rows.
void judge(const Trial& trial, const identify::Forces& f, const std::string& car,
           double most_alpha_deg, double least_alpha_inside) {
  double inside = 0.0, quantities = 0.0;
  const auto say = [&](const std::string& name, const Errors& e) {
    inside += e.inside;
    quantities += 1.0;
    const std::string kind = car + name.substr(0, name.rfind(' '));
    support::figure_of_case(kind + " percent", 100.0 * e.rmse / e.peak);
    if (name.starts_with("alpha")) support::figure_of_case(kind + " deg", e.rmse * 180.0 / M_PI);
    support::figure_of_case(car + "inside percent", 100.0 * e.inside);
  };
  for (std::size_t a = 0; a < 2; ++a) {
    const auto sum = [&](std::size_t what) {
      return
          [&, what](double t) { return trial.of(t, 2 * a, what) + trial.of(t, 2 * a + 1, what); };
    };
    const Errors fx = errors_of(f, f.axle_fx_n[a], sum(0)),
                 fy = errors_of(f, f.axle_fy_n[a], sum(1));
    say(fmt::format("fx of axle {}", a), fx);
    say(fmt::format("fy of axle {}", a), fy);
    EXPECT_LT(fx.rmse, 0.075 * fx.peak) << a;
    EXPECT_LT(fy.rmse, 0.045 * fy.peak) << a;
  }
  for (std::size_t i = 0; i < vehicle::kWheels; ++i) {
    const identify::WheelForces& w = f.wheel[i];
    const auto own = [&](std::size_t what) {
      return [&, what](double t) { return trial.of(t, i, what); };
    };
    const Errors fx = errors_of(f, w.fx_n, own(0)), fy = errors_of(f, w.fy_n, own(1)),
                 fz = errors_of(f, w.fz_n, own(2)), kappa = errors_of(f, w.kappa, own(3)),
                 alpha = errors_of(f, w.alpha_rad,
                                   [&](double t) { return std::atan(trial.of(t, i, 4)); });
    say(fmt::format("fx of wheel {}", i), fx);
    say(fmt::format("fy of wheel {}", i), fy);
    say(fmt::format("fz of wheel {}", i), fz);
    say(fmt::format("kappa {}", i), kappa);
    say(fmt::format("alpha {}", i), alpha);
    EXPECT_LT(fx.rmse, 0.075 * fx.peak) << i;
    EXPECT_LT(fy.rmse, 0.09 * fy.peak) << i;
    EXPECT_LT(alpha.rmse * 180.0 / 3.14159265, most_alpha_deg) << i;
    EXPECT_GT(alpha.inside, least_alpha_inside) << i;
  }
  support::figure(car + "all inside percent", 100.0 * inside / quantities);
  EXPECT_GT(inside / quantities, 0.85);
}

// Bounds are 1.5 times those of the own car. Measured on 2026-11-26, 16 s each: 3.8 % at most of
// fx, 2.8 % of fy, 0.02 degrees. On two laps of each (2026-11-27) 6.1 %, 2.7 % and 0.2 degrees, a
// single wheel's slip angle 83.7 % inside.
TEST(SlowForcesOfTrials, AreThoseOfTheirTyres) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  for (const bool third : {false, true}) {
    Trial trial(third, heavy ? 2 : 1, 7);
    ASSERT_GT(trial.drive.row.size(), 2000u);
    for (const bool optical : {true, false}) {
      if (!heavy && !optical) continue;
      fmt::print("{} car, {} optical sensor\n", third ? "third" : "second",
                 optical ? "100 Hz, with" : "50 Hz, without");
      const recording::Recording log =
          trial.log(optical ? 100.0 : 50.0, optical, heavy ? 1e4 : 16.0);
      const identify::Forces f =
          forces_of(trial, log, heavy ? identify::ForcesOptions{}.noise_rounds : 3);
      for (const identify::PartUse& part : f.parts)
        fmt::print("  {}: {:+.3f}, freedom {:.3f}\n", part.part, part.mean, part.freedom);
      for (const std::string& doubt : f.doubts) fmt::print("  doubt: {}\n", doubt);
      for (const std::string& remark : f.remarks) fmt::print("  {}\n", remark);
      fmt::print("  {} rows, {} lost, {} of {} wild\n", f.rows, f.lost, f.wild, f.measurements);
      judge(trial, f,
            fmt::format("{} {} ", third ? "third" : "second", optical ? "optical" : "bare"),
            optical ? 0.225 : 0.6, heavy ? 0.8 : 0.85);
    }
  }
}

/// How far off the road wheels' angle is, on the mean of a drive with a steering sensor that is off
/// by 1 mrad; looks at the front slip angles.
double steering_off(bool third, unsigned long long seed) {
  Trial trial(third, 1, seed);
  const identify::Forces f =
      forces_of(trial, trial.log(50.0, true, 16.0, {{"sensor.bias", "steer_rad", 0.001}}), 3);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_GT(
        errors_of(f, f.wheel[i].alpha_rad, [&](double t) { return std::atan(trial.of(t, i, 4)); })
            .inside,
        0.85);
  double off = 0.0, rows = 0.0;
  for (std::size_t k = 0; k < f.time_s.size(); ++k) {
    if (!std::isfinite(f.steer_rad.value[k])) continue;
    const auto row = static_cast<std::size_t>(std::lround(f.time_s[k] / trials::kRow_s));
    off +=
        f.steer_rad.value[k] - trial.drive.row[row][third ? trials::kSteerReached : trials::kSteer];
    rows += 1.0;
  }
  return off / rows;
}

// A sensor that is off by 1 mrad is found to be, beside tyres that are not the stated ones.
TEST(SlowForcesOfTrials, TellTheSteeringSensorsOffset) {
  const unsigned long long last = std::getenv("KERBSTONE_HEAVY") != nullptr ? 5 : 1;
  double squares = 0.0, count = 0.0;
  for (const bool third : {false, true})
    for (unsigned long long seed = 1; seed <= last; ++seed) {
      const double off = steering_off(third, seed);
      fmt::print("{} car: {:.3f} mrad of 1 were not found\n", third ? "third" : "second",
                 1e3 * off);
      squares += off * off;
      count += 1.0;
    }
  fmt::print("root mean square {:.3f} mrad\n", 1e3 * std::sqrt(squares / count));
  EXPECT_LT(std::sqrt(squares / count), 1.5e-4);  // measured: 0.07 mrad
}

// Over ten cars that are off what is stated as trials are (up to 4 %, places 1.6 %).
TEST(ForcesOfTrials, HoldTheirIntervals) {
  if (std::getenv("KERBSTONE_HEAVY") == nullptr)
    GTEST_SKIP() << "minutes; KERBSTONE_HEAVY=1 runs it";
  constexpr double kSeeds = 5.0;
  for (const bool third : {false, true}) {
    std::map<std::string, double> inside;
    for (unsigned long long seed = 1; seed <= static_cast<unsigned long long>(kSeeds); ++seed) {
      Trial trial(third, 1, seed);
      const identify::Forces f = forces_of(trial, trial.log(50.0, true, 16.0), 3);
      const auto look = [&](const std::string& name, const identify::Estimated& e,
                            const auto& truth) {
        inside[name] += errors_of(f, e, truth).inside / kSeeds;
      };
      for (std::size_t i = 0; i < vehicle::kWheels; ++i) {
        const auto own = [&](std::size_t what) {
          return [&trial, i, what](double t) { return trial.of(t, i, what); };
        };
        look(fmt::format("fx of wheel {}", i), f.wheel[i].fx_n, own(0));
        look(fmt::format("fy of wheel {}", i), f.wheel[i].fy_n, own(1));
        look(fmt::format("fz of wheel {}", i), f.wheel[i].fz_n, own(2));
        look(fmt::format("kappa {}", i), f.wheel[i].kappa, own(3));
        look(fmt::format("alpha {}", i), f.wheel[i].alpha_rad,
             [&trial, i](double t) { return std::atan(trial.of(t, i, 4)); });
      }
      for (std::size_t a = 0; a < 2; ++a) {
        const auto sum = [&](std::size_t what) {
          return [&trial, a, what](double t) {
            return trial.of(t, 2 * a, what) + trial.of(t, 2 * a + 1, what);
          };
        };
        look(fmt::format("fx of axle {}", a), f.axle_fx_n[a], sum(0));
        look(fmt::format("fy of axle {}", a), f.axle_fy_n[a], sum(1));
      }
    }
    for (const auto& [name, share] : inside) {
      support::figure_of_case(third ? "third_inside_percent" : "second_inside_percent",
                              100.0 * share);
      // Measured: fx 84 to 99 %, all else 86 to 100 % (docs/evidence.md).
      EXPECT_GT(share, name.starts_with("fx") ? 0.82 : 0.85) << name;
    }
  }
}

}  // namespace forces_of_trials_test
