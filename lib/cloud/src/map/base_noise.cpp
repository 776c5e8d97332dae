#include "base_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/statistics.h"

namespace cloud {
namespace {

constexpr double kLeastRough_m = 0.0002;    // less is not seen beside the points' own noise
constexpr std::size_t kMostSeen = 200'000;  // that are looked at
constexpr double kChance = 4.0,
                 kOverMean = 0.477;  // of a node's error, in the height over its mean
constexpr double kOfMean = 0.4125;   // fourth differences of that mean over those of the nodes

/// The mean over half the way to both neighbours is three quarters of the node and a quarter of
/// these.
double with_neighbours(double here, double before, double after) {
  return 0.75 * here + 0.125 * (before + after);
}

}  // namespace

BaseNoise::BaseNoise(const crg::Grid& base, bool closed,
                     const std::function<double(std::size_t)>& seen_m)
    : base_(base), rows_(base.rows() - (closed ? 1 : 0)), closed_(closed) {
  const std::size_t columns = base.columns(), every = 1 + base.z_m.size() / kMostSeen;
  // Fourth differences along the road: hills and kerbs have none.
  const auto fourth = [&](std::size_t k, const auto& of) {
    return of(k - 2 * columns) + of(k + 2 * columns) - 4.0 * (of(k - columns) + of(k + columns)) +
           6.0 * of(k);
  };
  std::vector<double> rough;
  double together = 0.0, square = 0.0;
  for (std::size_t k = 2 * columns; k + 2 * columns < rows_ * columns; k += every) {
    const double of_base =
                     fourth(k, [&](std::size_t at) { return static_cast<double>(base.z_m[at]); }),
                 seen = fourth(k, seen_m);
    if (!std::isfinite(of_base) || !std::isfinite(seen)) continue;
    rough.push_back(std::abs(of_base));
    together -= seen * of_base, square += of_base * of_base;
  }
  const double stddev_m = base::median_or(0.0, std::move(rough)) / (0.6745 * std::sqrt(70.0));
  if (stddev_m < kLeastRough_m) return;
  share_ = std::clamp(together / (kOfMean * square), 0.0, 1.0);
  stddev_m_ = std::sqrt(share_) * stddev_m;
}

double BaseNoise::over_mean_m(std::size_t row, std::size_t column) const {
  const std::size_t columns = base_.columns();
  const bool at_end = row == 0 || row + 1 >= rows_;
  if (stddev_m_ == 0.0 || (at_end && !closed_) || column == 0 || column + 1 >= columns) return 0.0;
  const auto along = [&](std::size_t j) {
    const auto z = [&](std::size_t i) { return static_cast<double>(base_.at(i % rows_, j)); };
    return with_neighbours(z(row), z(row + rows_ - 1), z(row + 1));
  };
  const double before_m = base_.v_m[column] - base_.v_m[column - 1],
               after_m = base_.v_m[column + 1] - base_.v_m[column];
  const double aside =
      (before_m * along(column - 1) + after_m * along(column + 1)) / (before_m + after_m);
  const double here = static_cast<double>(base_.at(row, column)),
               over = here - with_neighbours(along(column), aside, aside);
  return std::abs(over) < kChance * kOverMean * stddev_m_ ? share_ * over : 0.0;
}

}  // namespace cloud
