// The table of forces, and what is said of its columns.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "identify/forces.h"

namespace forces_files_test {

using identify::Forces;

/// Two rows, of which the first was left out.
Forces two_rows() {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  Forces f;
  f.time_s = {0.0, 0.1};
  f.u_m = f.v_m = {1.0, 2.0};
  const auto fill = [&](identify::Estimated& e, double value) {
    e = {{kNaN, value}, {kNaN, 0.1 * value}};
  };
  for (auto& w : f.wheel) {
    for (auto* e : {&w.fx_n, &w.fy_n, &w.fz_n, &w.kappa, &w.alpha_rad, &w.camber_rad, &w.power_w})
      fill(*e, 5.0);
    w.vx_mps = w.tyre_k = {kNaN, 7.0};
  }
  for (std::size_t a = 0; a < 2; ++a)
    for (auto* e : {&f.axle_fx_n[a], &f.axle_fy_n[a], &f.axle_fz_n[a]}) fill(*e, 10.0);
  for (auto* e : {&f.vx_mps, &f.vy_mps, &f.yaw_rate_radps, &f.steer_rad, &f.sideslip_rad})
    fill(*e, 1.0);
  return f;
}

TEST(ForcesFiles, EveryNumberHasItsDeviationAndLeftOutRowsAreNotThere) {
  const recording::Table t = identify::forces_table(two_rows());
  EXPECT_EQ(t.rows(), 1u);
  for (const char* name : {"fx_fl_n", "fy_rr_n", "fz_rl_n", "fy_front_n", "fx_rear_n"}) {
    ASSERT_NE(t.find(name), nullptr) << name;
    const std::string deviation = std::string(name).insert(std::string(name).size() - 2, "_sd");
    ASSERT_NE(t.find(deviation), nullptr) << deviation;
    EXPECT_EQ(t.find(deviation)->front(), 0.1 * t.find(name)->front());
  }
  EXPECT_NE(t.find("kappa_fl_sd"), nullptr);
  EXPECT_NE(t.find("alpha_rl_sd_rad"), nullptr);
  EXPECT_NE(t.find("power_rr_sd_w"), nullptr);
  EXPECT_EQ(t.find("u_m")->front(), 2.0);
}

TEST(ForcesFiles, SaysWhatIsNotObserved) {
  Forces f = two_rows();
  const auto basis = [&](const std::string& column) -> std::string {
    for (const auto& [columns, text] : identify::forces_basis(f))
      if (columns == column) return text;
    return "none";
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(basis("fy of single wheels"), HasSubstr("split by load and reference tyre"));
  EXPECT_THAT(basis("fy_front_n, fy_rear_n"), HasSubstr("not observed"));
  EXPECT_THAT(basis("alpha, sideslip, vy"), HasSubstr("estimated: no lateral speed"));
  for (const char* channel : {"ay_mps2", "yaw_rate_radps", "vy_mps"})
    f.channels.push_back({channel, 1, 0.1});
  EXPECT_THAT(basis("fy_front_n, fy_rear_n"), HasSubstr("observed: lateral and yaw"));
  EXPECT_THAT(basis("alpha, sideslip, vy"), HasSubstr("observed: lateral speed"));
  EXPECT_THAT(basis("fz of single wheels"), HasSubstr("not observed"));
  for (const char* wheel : {"fl", "fr", "rl", "rr"})
    f.channels.push_back({std::string("suspension_") + wheel + "_m", 1, 0.1});
  EXPECT_THAT(basis("fz of single wheels"), HasSubstr("recorded travel"));
}

}  // namespace forces_files_test
