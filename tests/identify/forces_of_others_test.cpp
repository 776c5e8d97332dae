// Forces from recordings of a simulator that shares nothing with this project, TUMFTM
// Open-Car-Dynamics: wheel loads and lateral speed are kept from the estimate and compared with it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "base/read_file.h"
#include "identify/forces.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/recorded_car.h"

namespace forces_of_others_test {

using nlohmann::json;

/// Without the channels that the estimate is compared with.
recording::Recording without_truth(const recording::Recording& log, double longest_s) {
  return support::begin_of(log, longest_s, [](const std::string& name) {
    return name == "vy_mps" || name.starts_with("fz_");
  });
}

struct Compared {
  double rmse = 0.0, inside = 0.0, most = 0.0;
};

/// Against a measured channel of white noise `noise`, which counts in the interval and is taken out
/// of the root mean square.
Compared compare(const identify::Estimated& e, const std::vector<double>& measured, double noise) {
  double square = 0.0, inside = 0.0, n = 0.0;
  Compared out;
  for (std::size_t k = 0; k < e.value.size(); ++k) {
    if (!std::isfinite(e.value[k]) || !std::isfinite(measured[k])) continue;
    const double error = e.value[k] - measured[k];
    square += error * error;
    inside += std::abs(error) < 1.645 * std::hypot(e.sd[k], noise) ? 1.0 : 0.0;
    out.most = std::max(out.most, std::abs(measured[k]));
    n += 1.0;
  }
  EXPECT_GT(n, 100.0);
  out.rmse = std::sqrt(std::max(0.0, square / n - noise * noise));
  out.inside = inside / n;
  return out;
}

/// Against what the true car and all channels tell, which is held to be the truth here; that one's
/// own deviation counts in the interval.
void judge(const std::string& name, const identify::Estimated& e,
           const identify::Estimated& reference, double most_share, double most) {
  double square = 0.0, peak = 0.0, inside = 0.0, n = 0.0;
  for (std::size_t k = 0; k < e.value.size(); ++k) {
    if (!std::isfinite(e.value[k]) || !std::isfinite(reference.value[k])) continue;
    const double off = e.value[k] - reference.value[k];
    square += off * off;
    peak = std::max(peak, std::abs(reference.value[k]));
    inside += std::abs(off) < 1.645 * std::hypot(e.sd[k], reference.sd[k]) ? 1.0 : 0.0;
    n += 1.0;
  }
  const double rmse = std::sqrt(square / n);
  support::figure_of_case(name.substr(0, name.rfind(' ')) + " percent", 100.0 * rmse / peak);
  support::figure_of_case("inside_percent", 100.0 * inside / n);
  EXPECT_LT(rmse, std::max(most, most_share * peak)) << name;
}

identify::Forces estimate(support::RecordedCar c, const recording::Recording& log, bool true_car) {
  // The other simulator's wheels act on the body by their forces only.
  c.terms[vehicle::Term::gyroscopic] = c.terms[vehicle::Term::wheel_reaction] = 0.0;
  const vehicle::Car<double> car = vehicle::make_car(c.files, c.parameters, c.terms);
  identify::ForcesOptions options;
  options.fuel_kg = 0.0;
  options.noise_rounds = 3;
  if (!true_car) options.prior = support::few_per_cent();
  return identify::estimate_forces(car, vehicle::Road(), log, options);
}

// Mass, its place, yaw inertia, drag, grip and cornering stiffness are off by 2 to 4 %. Bounds are
// 1.5 times the own car's.
TEST(ForcesOfOthers, AreThoseOfTheTrueCar) {
  const std::string folder = places::data() + "/ocd_trials";
  if (!std::filesystem::exists(folder + "/truth.json"))
    GTEST_SKIP() << "no recordings of Open-Car-Dynamics here";
  if (std::getenv("KERBSTONE_HEAVY") == nullptr)
    GTEST_SKIP() << "minutes; KERBSTONE_HEAVY=1 runs it";
  const json truth = base::parse_json<json>(base::read_file(folder + "/truth.json", 1u << 24));
  for (const json& trial : truth.at("trials")) {
    const std::string id = trial.at("id");
    if (id != "t01" && id != "t02" && id != "t03" && id != "t06" && id != "t09") continue;
    SCOPED_TRACE(id);
    const recording::Recording log = support::recorded_log(folder + "/" + id + ".csv.xz");
    const json& factors = trial.at("parameter_factors");
    const identify::Forces reference = estimate(support::recorded_car(folder, factors),
                                                support::begin_of(log, 40.0), true),
                           f = estimate(support::stated_car(folder, factors),
                                        support::begin_of(log, 40.0), false);
    fmt::print("{}: {} rows, {} lost\n", id, f.rows, f.lost);
    for (const auto& [name, factor] : factors.items())
      fmt::print("  truly {} {:+.4f}\n", name, factor.get<double>() - 1.0);
    for (std::size_t a = 0; a < 2; ++a) {
      judge(fmt::format("fx of axle {}", a), f.axle_fx_n[a], reference.axle_fx_n[a], 0.075, 0.0);
      judge(fmt::format("fy of axle {}", a), f.axle_fy_n[a], reference.axle_fy_n[a], 0.045, 0.0);
    }
    for (std::size_t i = 0; i < vehicle::kWheels; ++i) {
      const identify::WheelForces &w = f.wheel[i], &r = reference.wheel[i];
      judge(fmt::format("fx of wheel {}", i), w.fx_n, r.fx_n, 0.075, 0.0);
      judge(fmt::format("fy of wheel {}", i), w.fy_n, r.fy_n, 0.09, 0.0);
      judge(fmt::format("fz of wheel {}", i), w.fz_n, r.fz_n, 0.06, 0.0);
      judge(fmt::format("alpha of wheel {}", i), w.alpha_rad, r.alpha_rad, 0.0, 0.225 / 57.3);
    }
  }
}

TEST(SlowForcesOfOthers, LoadsAndLateralSpeedAreThoseThatWereKeptBack) {
  const std::string folder = places::data() + "/ocd_trials";
  if (!std::filesystem::exists(folder + "/truth.json"))
    GTEST_SKIP() << "no recordings of Open-Car-Dynamics here";
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const json truth = base::parse_json<json>(base::read_file(folder + "/truth.json", 1u << 24));
  const json& noise = truth.at("noise_sd");
  for (const json& trial : truth.at("trials")) {
    const std::string id = trial.at("id");
    if (trial.at("class") != "none" || (!heavy && id != "t01")) continue;
    SCOPED_TRACE(id);
    const recording::Recording log = support::recorded_log(folder + "/" + id + ".csv.xz");
    const recording::Recording seen = without_truth(log, heavy ? 90.0 : 20.0);
    const json& factors = trial.at("parameter_factors");
    for (const bool true_car : {true, false}) {
      support::RecordedCar stated =
          true_car ? support::recorded_car(folder, factors) : support::stated_car(folder, factors);
      // The other simulator's wheels act on the body by their forces only.
      stated.terms[vehicle::Term::gyroscopic] = stated.terms[vehicle::Term::wheel_reaction] = 0.0;
      const vehicle::Car<double> car =
          vehicle::make_car(stated.files, stated.parameters, stated.terms);
      identify::ForcesOptions options;
      options.fuel_kg = 0.0;
      if (!true_car) options.prior = support::few_per_cent();
      if (!heavy) options.noise_rounds = 2;
      const identify::Forces f = identify::estimate_forces(car, vehicle::Road(), seen, options);
      EXPECT_GT(f.rows, 9 * seen.table.rows() / 10);
      fmt::print("{} {}: {} of {} rows, {:.2f} % wild\n", id, true_car ? "true car" : "stated car",
                 f.rows, seen.table.rows(),
                 100.0 * static_cast<double>(f.wild) / static_cast<double>(f.measurements));
      EXPECT_TRUE(f.doubts.empty()) << f.doubts.front();
      const std::array<const char*, 4> names{"fl", "fr", "rl", "rr"};
      for (std::size_t i = 0; i < 4; ++i)
        if (const auto* const fz = log.table.find(fmt::format("fz_{}_n", names[i]))) {
          const Compared c = compare(f.wheel[i].fz_n, *fz, noise.at("fz").get<double>());
          fmt::print("  fz_{}: {:.0f} N of {:.0f}, inside {:.1f} %\n", names[i], c.rmse, c.most,
                     100.0 * c.inside);
          // 33 N at most where parameters are true; loads rest on mass and its place.
          if (true_car) {
            EXPECT_LT(c.rmse, 50.0);
            EXPECT_NEAR(c.inside, 0.9, 0.05);
          }
        }
      if (const auto* const vy = log.table.find("vy_mps")) {
        const Compared c = compare(f.vy_mps, *vy, noise.at("vy_mps").get<double>());
        fmt::print("  vy: {:.3f} m/s, inside {:.1f} %\n", c.rmse, 100.0 * c.inside);
        EXPECT_LT(c.rmse, 0.05);  // 0.032 at most
        EXPECT_NEAR(c.inside, 0.9, 0.05);
      }
    }
  }
}

}  // namespace forces_of_others_test
