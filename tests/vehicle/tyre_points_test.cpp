#include "vehicle/tyre_points.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "base/write_file.h"
#include "support/places.h"
#include "test_car.h"
#include "vehicle/error.h"

namespace tyre_points_test {

using ::testing::HasSubstr;

vehicle::TyreCoefficients test_tyre() {
  return vehicle::parse_tyre(test_tyre_text(), "test tyre").coefficients;
}

TEST(TyrePoints, AddsForcesToEveryPoint) {
  const auto points = recording::parse_table(
      "fz_n,kappa,alpha_rad,gamma_rad,vx_mps\n3000,0.05,0,0,20\n0,0.05,0.1,0,20\n", "p");
  const auto out = vehicle::evaluate_tyre(test_tyre(), points, "p");
  ASSERT_EQ(out.rows(), 2u);
  EXPECT_GT((*out.find("fx_n"))[0], 1000.0);
  EXPECT_EQ((*out.find("fy_n"))[1], 0.0);
  EXPECT_EQ(out.names.back(), "my_nm");
}

TEST(TyrePoints, NamesWhatIsMissing) {
  const auto message = [](const std::string& text) -> std::string {
    try {
      vehicle::evaluate_tyre(test_tyre(), recording::parse_table(text, "p.csv"), "p.csv");
    } catch (const vehicle::Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message("fz_n,kappa\n1,2\n"), HasSubstr("p.csv: no column 'alpha_rad'"));
  EXPECT_THAT(message("fz_n,kappa,alpha_rad,gamma_rad,vx_mps\n1,,0,0,0\n"),
              HasSubstr("p.csv:2: no value of kappa"));
  EXPECT_THAT(message("fz_n,kappa,alpha_rad,gamma_rad,vx_mps\n1,0,2,0,0\n"),
              HasSubstr("right angle"));
}

// The sample file's numbers of TurnSlip.FollowsThePublishedEquations, written down in another
// language, here by the columns of a table.
TEST(TyrePoints, TurnSlipFollowsThePublishedEquations) {
  const std::string file = places::data() + "/tyre/sample_mf62.tir";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file;
  const auto points = recording::parse_table(
      "turn_1pm,fz_n,kappa,alpha_rad,gamma_rad,vx_mps\n0.2,4000,0,0,0,10\n50,4000,0,0,0,10\n"
      "0.5,3000,0.05,-0.08,0,10\n-1,5500,-0.1,0.05,0.06,10\n3,2000,0,0.12,-0.05,10\n",
      "p");
  const auto out = vehicle::evaluate_tyre(vehicle::read_tyre(file).coefficients, points, "p");
  constexpr double kFx_n[] = {32.741584, -189.962912, 1986.331585, -5275.481294, 1.423754};
  constexpr double kFy_n[] = {-711.420454, -24.964568, 2434.250570, -838.524179, -1900.769242};
  constexpr double kMz_nm[] = {-66.291052, -191.443759, -15.990959, 16.320815, -12.537203};
  for (std::size_t i = 0; i < out.rows(); ++i) {
    EXPECT_NEAR((*out.find("fx_n"))[i], kFx_n[i], 1e-3) << i;
    EXPECT_NEAR((*out.find("fy_n"))[i], kFy_n[i], 1e-3) << i;
    EXPECT_NEAR((*out.find("mz_nm"))[i], kMz_nm[i], 1e-4) << i;
  }
}

// Equations (4.88) to (4.90) say that a little turning is what a little inclination is: R0 turn
// counts as (1 - epsilon) sin gamma. The inclined tyre, asked without turning, runs through the
// formulas that know no turn slip.
TEST(TyrePoints, SmallTurningActsAsAnInclination) {
  vehicle::TyreCoefficients tyre = test_car_files().tyre[0];
  tyre.pvy1 = tyre.pvy2 = tyre.phy1 = tyre.phy2 = 0.0;  // a tyre without ply steer
  tyre.pdyp4 = 0.0;                                     // its root is no slope
  const double gamma = 1e-4;
  const double turn_1pm = (1.0 - tyre.pecp1) * gamma / tyre.unloaded_radius_m;
  std::string text = "fz_n,kappa,alpha_rad,gamma_rad,vx_mps,turn_1pm\n";
  for (const double fz_n : {1500.0, 3000.0, 4500.0})
    text += fmt::format("{0},0,0,{1},20,0\n{0},0,0,0,20,{2}\n", fz_n, gamma, turn_1pm);
  const auto out = vehicle::evaluate_tyre(tyre, recording::parse_table(text, "p"), "p");
  const auto& fy_n = *out.find("fy_n");
  for (std::size_t i = 0; i < out.rows(); i += 2) {
    EXPECT_GT(std::abs(fy_n[i]), 0.05);
    EXPECT_NEAR(fy_n[i + 1], fy_n[i], 2e-3 * std::abs(fy_n[i])) << i;
  }
}

TEST(TyrePoints, TurningATyreWithoutTurnSlipIsRefused) {
  const auto at = [](const char* turn) {
    return recording::parse_table(
        std::string("fz_n,kappa,alpha_rad,gamma_rad,vx_mps,turn_1pm\n3000,0,0.1,0,20,") + turn +
            "\n",
        "p.csv");
  };
  try {
    vehicle::evaluate_tyre(test_tyre(), at("0.2"), "p.csv");
    FAIL() << "not refused";
  } catch (const vehicle::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("p.csv:2: turn_1pm is 0.2"));
    EXPECT_THAT(error.what(), HasSubstr("QCRP1"));
  }
  EXPECT_NE((*vehicle::evaluate_tyre(test_tyre(), at("0"), "p").find("fy_n"))[0], 0.0);
  EXPECT_THROW(vehicle::evaluate_tyre(test_car_files().tyre[0], at(""), "p"), vehicle::Error);
}

TEST(TyrePoints, RunFromTheCommandLine) {
  const auto folder = std::filesystem::temp_directory_path() /
                      ("kerbstone_tyre_points_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const auto path = [&](const char* name) { return (folder / name).string(); };
  const auto run = [&](const std::string& arguments) {
    const std::string line =
        places::crgdrive() + " " + arguments + " >" + path("out.txt") + " 2>" + path("err.txt");
    const int status = std::system(line.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  base::write_file(path("t.tir"), test_tyre_text());
  base::write_file(
      path("p.csv"),
      "fz_n,kappa,alpha_rad,gamma_rad,vx_mps,pressure_pa\n3000,0.05,0.1,0.02,20,160000\n");
  const std::string files =
      "--tir " + path("t.tir") + " --points " + path("p.csv") + " -o " + path("o.csv");
  ASSERT_EQ(run("tyre " + files), 0);
  const auto out = recording::read_table(path("o.csv"));
  const auto expected = vehicle::tyre_forces(
      test_tyre(), vehicle::TyreInput<double>{3000, 0.05, std::tan(0.1), 0.02, 20, 160000});
  EXPECT_NEAR((*out.find("fy_n"))[0], expected.fy_n, 1e-6);
  ASSERT_EQ(run("tyre --alpha angle " + files), 0);
  EXPECT_NE((*recording::read_table(path("o.csv")).find("fy_n"))[0], (*out.find("fy_n"))[0]);
  EXPECT_EQ(run("tyre --alpha degrees " + files), 2);
  EXPECT_EQ(run("tyre"), 2);
  EXPECT_EQ(
      run("tyre --tir " + path("none.tir") + " --points " + path("p.csv") + " -o " + path("x.csv")),
      1);
  EXPECT_FALSE(std::filesystem::exists(path("x.csv")));
  std::filesystem::remove_all(folder);
}

}  // namespace tyre_points_test
