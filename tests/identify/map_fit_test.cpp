// A map from rows that feel many of its places, against maps drawn from the prior itself.
#include "map_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "vehicle/map.h"

namespace map_fit_test {

using Eigen::MatrixXd;
using Eigen::VectorXd;

const std::vector<double> kX{0.0, 1.0, 2.0, 4.0}, kY{0.0, 0.5, 1.0};

TEST(MapFit, WeightsAreThoseOfTheMap) {
  vehicle::Map2 map{kX, kY, {}};
  for (int k = 0; k < 12; ++k) map.z.push_back(std::sin(1.7 * k));
  for (const auto& [x, y] :
       {std::pair{0.3, 0.1}, {3.0, 0.75}, {-1.0, 0.2}, {9.0, 2.0}, {2.0, 0.5}}) {
    double sum = 0.0, all = 0.0;
    for (const auto& [place, weight] : identify::map_weights(kX, kY, x, y)) {
      sum += weight * map.z[place];
      all += weight;
    }
    EXPECT_NEAR(sum, vehicle::evaluate(map, x, y), 1e-14);
    EXPECT_NEAR(all, 1.0, 1e-14);
  }
}

// Measured: 2,085 of 2,400 places inside 1.645 deviations, blocks' common errors included.
TEST(MapFit, DeviationsHold) {
  const MatrixXd prior = identify::map_covariance(kX, kY, VectorXd::Constant(12, 2.0));
  const MatrixXd root = MatrixXd(prior.selfadjointView<Eigen::Lower>().llt().matrixL());
  int inside = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    base::Random dice = base::random_of(seed, "rows");
    VectorXd draw(12);
    for (int k = 0; k < 12; ++k) draw(k) = dice.normal();
    const VectorXd truth = root * draw;
    constexpr int kRows = 240;
    MatrixXd rows = MatrixXd::Zero(kRows, 12);
    VectorXd wanted(kRows);
    std::vector<std::size_t> block;
    double shared = 0.0;
    for (int r = 0; r < kRows; ++r) {
      if (r % 6 == 0) shared = 0.1 * dice.normal();
      block.push_back(static_cast<std::size_t>(r / 6));
      // The last row of the map is never visited.
      for (const auto& [place, weight] :
           identify::map_weights(kX, kY, dice.uniform(0.0, 2.0), dice.uniform(0.0, 1.0)))
        rows(r, static_cast<Eigen::Index>(place)) += weight;
      wanted(r) = rows.row(r).dot(truth) + shared + 0.1 * dice.normal();
    }
    wanted(17) += 40.0;  // one wild row
    const identify::MapFit fit = identify::map_fit(rows, wanted, block, prior);
    EXPECT_EQ(fit.blocks, 40u);
    EXPECT_LT(fit.weight(17), 0.01);
    for (int k = 0; k < 12; ++k) {
      const double sd = std::sqrt(fit.noise(k, k) + fit.prior_left(k, k));
      inside += std::abs(fit.value(k) - truth(k)) < 1.645 * sd ? 1 : 0;
      ++all;
      EXPECT_LT(sd, 1.02 * std::sqrt(prior(k, k)));
      if (k >= 9) {
        EXPECT_GT(fit.prior_left(k, k), 4.0 * fit.noise(k, k));
      }
    }
    const VectorXd again = identify::map_fit_again(rows, wanted, prior, fit);
    EXPECT_LT((again - fit.value).norm(), 0.01);
  }
  EXPECT_GT(inside, 0.85 * all);
  EXPECT_LT(inside, 0.95 * all);
  RecordProperty("inside", inside);
}

}  // namespace map_fit_test
