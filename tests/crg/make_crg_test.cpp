#include <gtest/gtest.h>

#include <cmath>

#include "crg/error.h"
#include "crg/file.h"
#include "roads.h"
#include "support/figure.h"

namespace crg {
namespace make_crg_test {

double flat(double, double) { return 0.0; }

double worst_distance(const ReferenceLine& a, const ReferenceLine& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    worst = std::max(worst, std::hypot(a.x_m[i] - b.x_m[i], a.y_m[i] - b.y_m[i]));
  return worst;
}

TEST(MakeCrg, FloatHeadingsDoNotDriftOverALongLine) {
  const ReferenceLine line = test::line_along(
      220001, 0.1, [](double u) { return 0.015 * std::sin(0.013 * u) + 0.0003; }, 4.1e5, 5.5e6,
      0.3);
  const Crg crg = make_crg(line, test::grid_of(line, -1.0, 1.0, 2, flat));
  for (const double heading : crg.heading_rad)
    ASSERT_EQ(heading, static_cast<double>(static_cast<float>(heading)));
  // 22 km; half a float32 step at 4 rad is 2.4e-7 rad, over 0.1 m that is 2.4e-8 m.
  // Measured 2.0e-7, most of it the rounding of 220,000 sums of coordinates near 5.5e6 m.
  const double worst_m = worst_distance(integrate_reference_line(crg), line);
  support::figure("worst_m", worst_m);
  EXPECT_LT(worst_m, 4e-7);
  double plain_x = line.x_m[0], plain_y = line.y_m[0];
  for (std::size_t i = 1; i < line.size(); ++i) {
    plain_x += 0.1 * std::cos(static_cast<float>(line.heading_rad[i]));
    plain_y += 0.1 * std::sin(static_cast<float>(line.heading_rad[i]));
  }
  EXPECT_GT(std::hypot(plain_x - line.x_m.back(), plain_y - line.y_m.back()), 1e-6)
      << "plain rounding would do";
}

TEST(MakeCrg, ClosedTracksCloseAgain) {
  const ReferenceLine line = test::circuit(4001, 60.0, 0.2, 3);
  const Crg crg = make_crg(line, test::grid_of(line, -5.0, 5.0, 3, flat));
  EXPECT_EQ(find_value(crg.options, "REFLINE_CONTINUATION"), 1.0);
  const ReferenceLine back =
      integrate_reference_line(read_bytes(to_bytes(crg, Format::KRBI), "memory"));
  EXPECT_TRUE(back.closed);
  const double gap =
      std::hypot(back.x_m.front() - back.x_m.back(), back.y_m.front() - back.y_m.back());
  EXPECT_GT(gap, 1e-4);
  EXPECT_LT(gap, 2e-3);
}

TEST(MakeCrg, HeightOfTheLineBecomesSlopeWithoutDrift) {
  ReferenceLine line = test::line_along(30001, 0.1, [](double) { return 0.001; });
  for (std::size_t i = 0; i < line.size(); ++i)
    line.z_m.push_back(300.0 + 20.0 * std::sin(1e-3 * static_cast<double>(i)));
  line.banking.assign(line.size(), 0.0);
  for (std::size_t i = 0; i < line.size(); ++i)
    line.banking[i] = 0.05 * std::sin(2e-3 * static_cast<double>(i));
  const Crg crg = make_crg(line, test::grid_of(line, -1.0, 1.0, 2, flat));
  ASSERT_EQ(crg.slope.size(), line.size());
  const ReferenceLine back =
      integrate_reference_line(read_bytes(to_bytes(crg, Format::KRBI), "memory"));
  for (std::size_t i = 0; i < line.size(); ++i) {
    ASSERT_NEAR(back.z_m[i], line.z_m[i], 1e-9);
    ASSERT_NEAR(back.banking[i], line.banking[i], 2e-9);
  }
}

TEST(MakeCrg, ConstantHeightAndBankingNeedNoChannel) {
  ReferenceLine line = test::line_along(11, 1.0, [](double) { return 0.0; });
  line.z_m.assign(11, 12.5);
  line.banking.assign(11, 0.02);
  const Crg crg = make_crg(line, test::grid_of(line, -1.0, 1.0, 2, flat));
  EXPECT_TRUE(crg.slope.empty());
  EXPECT_TRUE(crg.banking.empty());
  const ReferenceLine back = integrate_reference_line(crg);
  EXPECT_EQ(back.z_m, line.z_m);
  EXPECT_EQ(back.banking, line.banking);
}

TEST(MakeCrg, RefusesWhatDoesNotFit) {
  const ReferenceLine line = test::line_along(11, 1.0, [](double) { return 0.0; });
  Grid grid = test::grid_of(line, -1.0, 1.0, 2, flat);
  grid.u_step_m = 0.5;
  EXPECT_THROW(make_crg(line, grid), Error);
  grid = test::grid_of(test::line_along(10, 1.0, [](double) { return 0.0; }), -1.0, 1.0, 2, flat);
  EXPECT_THROW(make_crg(line, grid), Error);
}

}  // namespace make_crg_test
}  // namespace crg
