#include "vehicle/tyre_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "base/write_file.h"
#include "support/places.h"
#include "tyre_files.h"
#include "vehicle/error.h"

namespace {

using ::testing::HasSubstr;

vehicle::TyreCoefficients test_tyre() {
  return vehicle::parse_tyre(test_tyre_text(), "test tyre").coefficients;
}

TEST(TyrePoints, AddsForcesToEveryPoint) {
  const auto points = vehicle::parse_table(
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
      vehicle::evaluate_tyre(test_tyre(), vehicle::parse_table(text, "p.csv"), "p.csv");
    } catch (const vehicle::Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message("fz_n,kappa\n1,2\n"), HasSubstr("p.csv: no column 'alpha_rad'"));
  EXPECT_THAT(message("fz_n,kappa,alpha_rad,gamma_rad,vx_mps\n1,,0,0,0\n"),
              HasSubstr("point 1 has an empty cell"));
  EXPECT_THAT(message("fz_n,kappa,alpha_rad,gamma_rad,vx_mps\n1,0,2,0,0\n"),
              HasSubstr("right angle"));
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
  const auto out = vehicle::read_table(path("o.csv"));
  const auto expected = vehicle::tyre_forces(
      test_tyre(), vehicle::TyreInput<double>{3000, 0.05, std::tan(0.1), 0.02, 20, 160000});
  EXPECT_NEAR((*out.find("fy_n"))[0], expected.fy_n, 1e-6);
  ASSERT_EQ(run("tyre --alpha angle " + files), 0);
  EXPECT_NE((*vehicle::read_table(path("o.csv")).find("fy_n"))[0], (*out.find("fy_n"))[0]);
  EXPECT_EQ(run("tyre --alpha degrees " + files), 2);
  EXPECT_EQ(run("tyre"), 2);
  EXPECT_EQ(
      run("tyre --tir " + path("none.tir") + " --points " + path("p.csv") + " -o " + path("x.csv")),
      1);
  EXPECT_FALSE(std::filesystem::exists(path("x.csv")));
  std::filesystem::remove_all(folder);
}

}  // namespace
