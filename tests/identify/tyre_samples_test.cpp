#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "identify/tyre_fit.h"

namespace tyre_samples_test {

using ::testing::HasSubstr;

identify::TyreSamples read(const std::string& text) {
  identify::TyreSamples out;
  identify::add_tyre_samples(out, recording::parse_table(text, "bench.csv"), "bench.csv");
  return out;
}

std::string refusal(const std::string& text) {
  try {
    read(text);
  } catch (const base::Error& error) {
    return error.what();
  }
  return "";
}

TEST(TyreSamples, RowsWithoutWhatIsNeededAreCounted) {
  const auto samples = read(
      "fz_n,kappa,alpha_rad,gamma_rad,vx_mps,fx_n,fy_n\n"
      "3000,0,0.1,0,30,5,-2000\n"
      "3000,0,0.1,,30,5,-2000\n"
      "-1,0,0.1,0,30,5,-2000\n"
      "3000,0,0.1,0,30,,\n"
      "3000,0,0.1,0,30,,-2000\n");
  ASSERT_EQ(samples.rows(), 2u);
  EXPECT_EQ(samples.left_out, 3u);
  EXPECT_DOUBLE_EQ(samples.conditions[0].tan_alpha, std::tan(0.1));
  EXPECT_EQ(samples.conditions[0].pressure_pa, 0.0);
  EXPECT_TRUE(std::isnan(samples.fx_n[1]));
}

TEST(TyreSamples, OtherTablesAreRefused) {
  EXPECT_THAT(refusal("fz_n,kappa\n1,2\n"), HasSubstr("bench.csv: no column 'alpha_rad'"));
  EXPECT_THAT(refusal("fz_n,kappa,alpha_rad,gamma_rad,vx_mps\n3000,0,0,0,30\n"),
              HasSubstr("'fx_n' or 'fy_n'"));
  EXPECT_THAT(refusal("fz_n,kappa,alpha_rad,gamma_rad,vx_mps,fy_n\n3000,0,4,0,30,1\n"),
              HasSubstr("row 1 has alpha_rad = 4, wanted radians"));
  EXPECT_THAT(refusal("fz_n,kappa,alpha_rad,gamma_rad,vx_mps,fy_n\n3000,0,0,0,30,1e300\n"),
              HasSubstr("row 1 has fy_n = 1e+300, wanted 1e+06 at most"));
}

TEST(TyreSamples, AreThinnedEvenly) {
  identify::TyreSamples samples;
  for (int i = 0; i < 10; ++i) {
    samples.conditions.push_back({1000.0 + i, 0, 0, 0, 30, 0});
    samples.fx_n.push_back(i);
    samples.fy_n.push_back(NAN);
  }
  const auto few = identify::thinned(samples, 4);
  EXPECT_THAT(few.fx_n, ::testing::ElementsAre(0, 3, 6, 9));
  EXPECT_EQ(identify::thinned(samples, 10).rows(), 10u);
}

}  // namespace tyre_samples_test
