#include <Eigen/Cholesky>
#include <algorithm>

#include "car_smoother.h"

namespace identify {

void NoiseSums::add(const NoiseSums& other) {
  for (std::size_t i = 0; i < kPlaces; ++i) {
    came_in[i] += other.came_in[i];
    assumed[i] += other.assumed[i];
    part[i] += other.part[i];
    part_weight[i] += other.part_weight[i];
    part_squares[i] += other.part_squares[i];
  }
  measured.resize(std::max(measured.size(), other.measured.size()));
  count.resize(measured.size());
  for (std::size_t i = 0; i < other.measured.size(); ++i) {
    measured[i] += other.measured[i];
    count[i] += other.count[i];
  }
  stated += other.stated;
  stated_weight += other.stated_weight;
  wild += other.wild;
  stretches += other.stretches;
}

void add_constants(const CarPoint& point, const PlaceVector& variance, const SmootherBegin& begin,
                   NoiseSums& sums) {
  for (std::size_t i = kPlaceSteerOffset; i < kPlaces; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    if (!(begin.sd[at] > 0.0) || !(variance[at] > 0.0)) continue;
    const double weight = 1.0 / variance[at] - 1.0 / (begin.sd[at] * begin.sd[at]);
    if (!(weight > 0.0)) continue;
    const double part = (point.at(i) - begin.point.at(i)) / variance[at];
    sums.part[i] += part;
    sums.part_weight[i] += weight;
    sums.part_squares[i] += part * part / weight;
  }
  ++sums.stretches;
}

void add_parts(const CarPoint& point, const PlaceVector& variance, const SmootherBegin& begin,
               NoiseSums& sums) {
  for (std::size_t i = kPlaceParts; i < kChangingPlaces; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const std::size_t rest = rest_of(i);
    if (begin.sd[static_cast<Eigen::Index>(rest)] > 0.0) continue;
    const double known = std::max(0.0, 1.0 - variance[at] / (begin.sd[at] * begin.sd[at]));
    sums.part[rest] += known * (point.at(i) - begin.point.at(rest));
    sums.part_weight[rest] += known;
  }
}

void add_stated(const PlaceVector& moved, const PlaceMatrix& covariance, const SmootherBegin& begin,
                NoiseSums& sums) {
  std::vector<Eigen::Index> numbers;
  for (std::size_t i = 0; i < kStatedNumbers; ++i)
    if (begin.sd[static_cast<Eigen::Index>(kPlaceStated + i)] > 0.0)
      numbers.push_back(static_cast<Eigen::Index>(i));
  const auto n = static_cast<Eigen::Index>(numbers.size());
  Eigen::MatrixXd own(n, n), before = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd off(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const Eigen::Index at = kPlaceStated + numbers[static_cast<std::size_t>(j)];
    off[j] = moved[at];
    before(j, j) = 1.0 / (kHeld * begin.sd[at] * kHeld * begin.sd[at]);
    for (Eigen::Index k = 0; k < n; ++k)
      own(j, k) = covariance(at, kPlaceStated + numbers[static_cast<std::size_t>(k)]);
  }
  const Eigen::MatrixXd weight = own.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  const Eigen::VectorXd part = weight * off;
  for (Eigen::Index j = 0; j < n; ++j) {
    const Eigen::Index row = numbers[static_cast<std::size_t>(j)];
    sums.stated[row] += part[j];
    for (Eigen::Index k = 0; k < n; ++k)
      sums.stated_weight(row, numbers[static_cast<std::size_t>(k)]) += weight(j, k) - before(j, k);
  }
}

}  // namespace identify
